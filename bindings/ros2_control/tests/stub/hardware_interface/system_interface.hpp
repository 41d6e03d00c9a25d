// Stub for tests alone: see README.md. The component's own memory of its interfaces, made from the URDF as in Jazzy.
#ifndef HARDWARE_INTERFACE__SYSTEM_INTERFACE_HPP_
#define HARDWARE_INTERFACE__SYSTEM_INTERFACE_HPP_
#include <memory>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "hardware_interface/handle.hpp"
#include "hardware_interface/hardware_info.hpp"
#include "hardware_interface/types/hardware_component_interface_params.hpp"
#include "hardware_interface/types/hardware_interface_return_values.hpp"
#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "rclcpp/duration.hpp"
#include "rclcpp/logger.hpp"
#include "rclcpp/time.hpp"
#include "rclcpp_lifecycle/node_interfaces/lifecycle_node_interface.hpp"
#include "rclcpp_lifecycle/state.hpp"

namespace hardware_interface {
using CallbackReturn = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;

class HardwareComponentInterface : public rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface {
public:
    HardwareComponentInterface() = default;
    HardwareComponentInterface(const HardwareComponentInterface &) = delete;
    HardwareComponentInterface(HardwareComponentInterface &&) = delete;

    CallbackReturn init(const HardwareComponentParams &params) {
        logger_ = params.logger;
        info_ = params.hardware_info;
        HardwareComponentInterfaceParams own;
        own.hardware_info = info_;
        return on_init(own);
    }
    virtual CallbackReturn on_init(const HardwareInfo &hardware_info) {
        info_ = hardware_info;
        return CallbackReturn::SUCCESS;
    }
    virtual CallbackReturn on_init(const HardwareComponentInterfaceParams &params) { return on_init(params.hardware_info); }

    virtual std::vector<StateInterface::ConstSharedPtr> on_export_state_interfaces() {
        std::vector<StateInterface::ConstSharedPtr> exported;
        for (const auto *components : {&info_.joints, &info_.sensors, &info_.gpios}) {
            for (const ComponentInfo &component : *components) {
                for (const InterfaceInfo &interface : component.state_interfaces) {
                    const InterfaceDescription description(component.name, interface);
                    exported.push_back(states_[description.get_name()] = std::make_shared<StateInterface>(description));
                }
            }
        }
        return exported;
    }
    virtual std::vector<CommandInterface::SharedPtr> on_export_command_interfaces() {
        std::vector<CommandInterface::SharedPtr> exported;
        for (const auto *components : {&info_.joints, &info_.gpios}) {
            for (const ComponentInfo &component : *components) {
                for (const InterfaceInfo &interface : component.command_interfaces) {
                    const InterfaceDescription description(component.name, interface);
                    exported.push_back(commands_[description.get_name()] = std::make_shared<CommandInterface>(description));
                }
            }
        }
        return exported;
    }

    virtual return_type prepare_command_mode_switch(const std::vector<std::string> &, const std::vector<std::string> &) {
        return return_type::OK;
    }
    virtual return_type perform_command_mode_switch(const std::vector<std::string> &, const std::vector<std::string> &) {
        return return_type::OK;
    }
    virtual return_type read(const rclcpp::Time &time, const rclcpp::Duration &period) = 0;
    virtual return_type write(const rclcpp::Time &, const rclcpp::Duration &) { return return_type::OK; }

    virtual bool has_state(const std::string &name) const { return states_.count(name) != 0; }
    virtual const StateInterface::SharedPtr &get_state_interface_handle(const std::string &name) const { return found(states_, name); }
    template <typename T>
    bool set_state(const StateInterface::SharedPtr &handle, const T &value, bool wait_until_set) {
        return there(handle)->set_value(value, wait_until_set);
    }
    virtual bool has_command(const std::string &name) const { return commands_.count(name) != 0; }
    virtual const CommandInterface::SharedPtr &get_command_interface_handle(const std::string &name) const { return found(commands_, name); }
    template <typename T>
    bool set_command(const CommandInterface::SharedPtr &handle, const T &value, bool wait_until_set) {
        return there(handle)->set_value(value, wait_until_set);
    }
    template <typename T>
    bool get_command(const CommandInterface::SharedPtr &handle, T &command, bool wait_until_get) const {
        return there(handle)->get_value(command, wait_until_get);
    }

    virtual rclcpp::Logger get_logger() const { return logger_; }
    const HardwareInfo &get_hardware_info() const { return info_; }

protected:
    HardwareInfo info_;

private:
    template <typename Handles>
    const typename Handles::mapped_type &found(const Handles &handles, const std::string &name) const {
        const auto handle = handles.find(name);
        if (handle == handles.end()) {
            throw std::runtime_error("there is no interface " + name + " in " + info_.name);
        }
        return handle->second;
    }
    template <typename Handle>
    static const Handle &there(const Handle &handle) {
        if (!handle) {
            throw std::runtime_error("the handle of an interface is null");
        }
        return handle;
    }

    std::unordered_map<std::string, StateInterface::SharedPtr> states_;
    std::unordered_map<std::string, CommandInterface::SharedPtr> commands_;
    rclcpp::Logger logger_ = rclcpp::get_logger("hardware_component_interface");
};

class SystemInterface : public HardwareComponentInterface {
public:
    return_type write(const rclcpp::Time &time, const rclcpp::Duration &period) override = 0;
};
}  // namespace hardware_interface
#endif  // HARDWARE_INTERFACE__SYSTEM_INTERFACE_HPP_
