/*
 * The wires of a rig as a system of ros2_control. What the URDF says of it and what it does is told in docs/bindings.md.
 *
 * read() and write() neither allocate nor wait: read() copies the driver's latest cycle out of shared memory, write() leaves its setpoints with
 * a thread of this component, which hands them to the driver.
 */
#ifndef SINEW_ROS2_CONTROL__SYSTEM_HPP_
#define SINEW_ROS2_CONTROL__SYSTEM_HPP_

#include <memory>
#include <string>
#include <vector>

#include "hardware_interface/system_interface.hpp"
#include "rclcpp/duration.hpp"
#include "rclcpp/time.hpp"
#include "rclcpp_lifecycle/state.hpp"

namespace sinew_ros2_control {

class System : public hardware_interface::SystemInterface {
public:
    using CallbackReturn = hardware_interface::CallbackReturn;
    using Interfaces = std::vector<std::string>;

    System();
    /// Switches its wires off if it is still active.
    ~System() override;

    using SystemInterface::on_init;
    /// Reads the URDF's parameters. ERROR for what cannot be meant.
    CallbackReturn on_init(const hardware_interface::HardwareComponentInterfaceParams &params) override;
    /// Connects to the driver and finds the channels. FAILURE where there is no driver, or it has not these channels.
    CallbackReturn on_configure(const rclcpp_lifecycle::State &previous) override;
    CallbackReturn on_cleanup(const rclcpp_lifecycle::State &previous) override;
    /// Waits for the sensors and claims the channels. FAILURE while a wire has a fault. Nothing is heated before a controller commands it.
    CallbackReturn on_activate(const rclcpp_lifecycle::State &previous) override;
    /// Switches the wires off.
    CallbackReturn on_deactivate(const rclcpp_lifecycle::State &previous) override;
    CallbackReturn on_shutdown(const rclcpp_lifecycle::State &previous) override;
    /// Switches the wires off and lets go of the driver: it can be configured anew.
    CallbackReturn on_error(const rclcpp_lifecycle::State &previous) override;

    hardware_interface::return_type prepare_command_mode_switch(const Interfaces &start, const Interfaces &stop) override;
    hardware_interface::return_type perform_command_mode_switch(const Interfaces &start, const Interfaces &stop) override;

    /// ERROR when the driver is gone.
    hardware_interface::return_type read(const rclcpp::Time &time, const rclcpp::Duration &period) override;
    /// DEACTIVATE, or as `on_fault` says, when a wire has got a fault; ERROR when the driver is gone or refuses.
    hardware_interface::return_type write(const rclcpp::Time &time, const rclcpp::Duration &period) override;

private:
    struct Rig;

    CallbackReturn failed(CallbackReturn how, const char *place, const std::string &text) const;
    void let_go() noexcept;

    std::unique_ptr<Rig> rig_;
};

}  // namespace sinew_ros2_control

#endif  // SINEW_ROS2_CONTROL__SYSTEM_HPP_
