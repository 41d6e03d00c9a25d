// Stub for tests alone: see README.md.
#ifndef HARDWARE_INTERFACE__HARDWARE_INFO_HPP_
#define HARDWARE_INTERFACE__HARDWARE_INFO_HPP_
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace hardware_interface {
struct InterfaceInfo {
    std::string name, min, max, initial_value;
    std::string data_type = "double";
    int size = 1;
    std::unordered_map<std::string, std::string> parameters;
    bool enable_limits = true;
};

struct ComponentInfo {
    std::string name, type;
    std::vector<InterfaceInfo> command_interfaces, state_interfaces;
    std::unordered_map<std::string, std::string> parameters;
};

struct InterfaceDescription {
    InterfaceDescription(const std::string &prefix, InterfaceInfo info)
        : prefix_name(prefix), interface_info(std::move(info)), interface_name(prefix_name + "/" + interface_info.name) {}

    std::string prefix_name;
    InterfaceInfo interface_info;
    std::string interface_name;
    const std::string &get_name() const { return interface_name; }
};

struct HardwareInfo {
    std::string name, type, group;
    unsigned int rw_rate = 0;
    bool is_async = false;
    std::string hardware_plugin_name;
    std::unordered_map<std::string, std::string> hardware_parameters;
    std::vector<ComponentInfo> joints, sensors, gpios;
    std::string original_xml;
};
}  // namespace hardware_interface
#endif  // HARDWARE_INTERFACE__HARDWARE_INFO_HPP_
