// What the controller manager does with a component, for tests: loads its library, gives it the URDF, takes it through its lifecycle and has it
// read and written in a loop of fixed rate.
#ifndef MANAGER_HPP
#define MANAGER_HPP

#include <dlfcn.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "hardware_interface/system_interface.hpp"

#define CHECK(condition)                                                                       \
    do {                                                                                       \
        if (!(condition)) {                                                                    \
            std::cerr << __FILE__ << ":" << __LINE__ << ": not so: " << #condition << "\n";    \
            std::_Exit(1);                                                                     \
        }                                                                                      \
    } while (false)

using hardware_interface::return_type;
using CallbackReturn = hardware_interface::CallbackReturn;

/// The manager's update rate, Hz.
inline constexpr unsigned int update_rate = 100;

// ---- the URDF -------------------------------------------------------------------------------------------------------------------------

#if __has_include("hardware_interface/component_parser.hpp")
#include "hardware_interface/component_parser.hpp"

/// The manager's own parser.
inline hardware_interface::HardwareInfo read_urdf(const std::string &text) {
    auto systems = hardware_interface::parse_control_resources_from_urdf(text);
    CHECK(systems.size() == 1);
    // 0: the manager's
    CHECK(systems.front().rw_rate == 0);
    systems.front().rw_rate = update_rate;
    return systems.front();
}
#else
#include <tinyxml2.h>

inline std::unordered_map<std::string, std::string> params_of(const tinyxml2::XMLElement &element) {
    std::unordered_map<std::string, std::string> params;
    for (auto *param = element.FirstChildElement("param"); param != nullptr; param = param->NextSiblingElement("param")) {
        params[param->Attribute("name")] = param->GetText() == nullptr ? "" : param->GetText();
    }
    return params;
}

inline std::vector<hardware_interface::InterfaceInfo> interfaces_of(const tinyxml2::XMLElement &element, const char *kind) {
    std::vector<hardware_interface::InterfaceInfo> interfaces;
    for (auto *found = element.FirstChildElement(kind); found != nullptr; found = found->NextSiblingElement(kind)) {
        interfaces.emplace_back();
        interfaces.back().name = found->Attribute("name");
        interfaces.back().parameters = params_of(*found);
    }
    return interfaces;
}

inline std::vector<hardware_interface::ComponentInfo> components_of(const tinyxml2::XMLElement &system, const char *kind) {
    std::vector<hardware_interface::ComponentInfo> components;
    for (auto *found = system.FirstChildElement(kind); found != nullptr; found = found->NextSiblingElement(kind)) {
        hardware_interface::ComponentInfo component;
        component.name = found->Attribute("name");
        component.type = kind;
        component.state_interfaces = interfaces_of(*found, "state_interface");
        component.command_interfaces = interfaces_of(*found, "command_interface");
        component.parameters = params_of(*found);
        components.push_back(component);
    }
    return components;
}

/// The `<ros2_control>` of a URDF, as the manager's parser reads it.
inline hardware_interface::HardwareInfo read_urdf(const std::string &text) {
    tinyxml2::XMLDocument document;
    CHECK(document.Parse(text.c_str()) == tinyxml2::XML_SUCCESS);
    const auto *robot = document.FirstChildElement("robot");
    CHECK(robot != nullptr && robot->FirstChildElement("ros2_control") != nullptr);
    const auto &system = *robot->FirstChildElement("ros2_control");
    const auto *hardware = system.FirstChildElement("hardware");
    CHECK(hardware != nullptr && hardware->FirstChildElement("plugin") != nullptr);
    hardware_interface::HardwareInfo info;
    info.name = system.Attribute("name");
    info.type = system.Attribute("type");
    info.rw_rate = update_rate;
    info.hardware_plugin_name = hardware->FirstChildElement("plugin")->GetText();
    info.hardware_parameters = params_of(*hardware);
    info.joints = components_of(system, "joint");
    info.sensors = components_of(system, "sensor");
    info.gpios = components_of(system, "gpio");
    info.original_xml = text;
    return info;
}
#endif

// ---- the lifecycle --------------------------------------------------------------------------------------------------------------------

enum class State { finalized, unconfigured, inactive, active };

class Manager {
public:
    /// Loads `type`, the class that pluginlib would find for the plugin's name.
    Manager(const char *library, const char *type) {
        handle_ = dlopen(library, RTLD_NOW | RTLD_LOCAL);
        if (handle_ == nullptr) {
            std::cerr << dlerror() << "\n";
            std::_Exit(1);
        }
        const auto create = reinterpret_cast<hardware_interface::SystemInterface *(*)(const char *)>(dlsym(handle_, "pluginlib_stub_create"));
        CHECK(create != nullptr);
        component.reset(create(type));
        CHECK(component != nullptr);
    }

    State init(const hardware_interface::HardwareInfo &info) {
        hardware_interface::HardwareComponentParams params;
        params.hardware_info = info;
        params.logger = rclcpp::get_logger("resource_manager.hardware_component.system." + info.name);
        if (component->init(params) != CallbackReturn::SUCCESS) {
            return state = State::finalized;
        }
        for (const auto &interface : component->on_export_state_interfaces()) {
            states_[interface->get_name()] = interface;
        }
        for (const auto &interface : component->on_export_command_interfaces()) {
            commands_[interface->get_name()] = interface;
        }
        return state = State::unconfigured;
    }
    State configure() { return state == State::unconfigured ? went(component->on_configure(previous_), State::inactive) : state; }
    State activate() { return state == State::inactive ? went(component->on_activate(previous_), State::active) : state; }
    State deactivate() { return state == State::active ? went(component->on_deactivate(previous_), State::inactive) : state; }
    State cleanup() { return state == State::inactive ? went(component->on_cleanup(previous_), State::unconfigured) : state; }
    State shutdown() { return went(component->on_shutdown(previous_), State::finalized); }

    return_type switch_mode(const std::vector<std::string> &start, const std::vector<std::string> &stop) {
        const return_type prepared = component->prepare_command_mode_switch(start, stop);
        return prepared == return_type::OK ? component->perform_command_mode_switch(start, stop) : prepared;
    }

    /// One period: read, the controllers, write. What the manager does of what they return is done.
    void cycle(const std::function<void()> &controllers = {}) {
        static const auto period = std::chrono::nanoseconds(1'000'000'000 / update_rate);
        const rclcpp::Time now(std::chrono::steady_clock::now().time_since_epoch().count());
        if (state == State::inactive || state == State::active) {
            before();
            const return_type said = component->read(now, rclcpp::Duration(period));
            after(read_s);
            // Jazzy: a read has no other way out
            if (said != return_type::OK) {
                error();
            }
        }
        if (controllers) {
            controllers();
        }
        if (state == State::active) {
            before();
            const return_type said = component->write(now, rclcpp::Duration(period));
            after(write_s);
            if (said == return_type::ERROR) {
                error();
            } else if (said == return_type::DEACTIVATE) {
                deactivate();
            }
        }
        next_ += period;
        if (next_ < std::chrono::steady_clock::now()) {
            next_ = std::chrono::steady_clock::now();
        }
        std::this_thread::sleep_until(next_);
    }
    /// Cycles until something is so, 20 s at the longest.
    void until(const char *what, const std::function<bool()> &is_so, const std::function<void()> &controllers = {}) {
        for (unsigned int i = 0; i < 20 * update_rate; ++i) {
            cycle(controllers);
            if (is_so()) {
                return;
            }
        }
        std::cerr << "waited in vain: " << what << "\n";
        std::_Exit(1);
    }

    double get(const std::string &name) const {
        CHECK(states_.count(name) == 1);
        return states_.at(name)->get_optional().value();
    }
    void set(const std::string &name, double value) {
        CHECK(commands_.count(name) == 1);
        CHECK(commands_.at(name)->set_value(value));
    }
    bool has_state(const std::string &name) const { return states_.count(name) == 1; }
    const auto &states() const { return states_; }
    const auto &commands() const { return commands_; }

    std::unique_ptr<hardware_interface::SystemInterface> component;
    State state = State::unconfigured;
    /// How long each call took, s; kept while there is room for it.
    std::vector<double> read_s, write_s;
    /// Called right before and after each read and write.
    std::function<void()> enter, leave;

private:
    State went(CallbackReturn said, State to) {
        if (said == CallbackReturn::SUCCESS) {
            state = to;
        } else if (said == CallbackReturn::ERROR) {
            error();
        }
        return state;
    }
    void error() { state = component->on_error(previous_) == CallbackReturn::SUCCESS ? State::unconfigured : State::finalized; }

    void before() {
        if (enter) {
            enter();
        }
        began_ = std::chrono::steady_clock::now();
    }
    void after(std::vector<double> &times) {
        const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
        if (leave) {
            leave();
        }
        if (times.size() < times.capacity()) {
            times.push_back(took_s);
        }
    }

    void *handle_ = nullptr;
    const rclcpp_lifecycle::State previous_{0, "unknown"};
    std::map<std::string, hardware_interface::StateInterface::ConstSharedPtr> states_;
    std::map<std::string, hardware_interface::CommandInterface::SharedPtr> commands_;
    std::chrono::steady_clock::time_point next_ = std::chrono::steady_clock::now(), began_;
};

#endif  // MANAGER_HPP
