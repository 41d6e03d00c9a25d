// Stub for tests alone: see README.md.
#ifndef HARDWARE_INTERFACE__TYPES__HARDWARE_COMPONENT_INTERFACE_PARAMS_HPP_
#define HARDWARE_INTERFACE__TYPES__HARDWARE_COMPONENT_INTERFACE_PARAMS_HPP_
#include "hardware_interface/hardware_info.hpp"
#include "rclcpp/logger.hpp"

namespace hardware_interface {
struct HardwareComponentInterfaceParams {
    HardwareInfo hardware_info;
};

struct HardwareComponentParams {
    HardwareInfo hardware_info;
    rclcpp::Logger logger = rclcpp::get_logger("resource_manager");
};
}  // namespace hardware_interface
#endif  // HARDWARE_INTERFACE__TYPES__HARDWARE_COMPONENT_INTERFACE_PARAMS_HPP_
