#include "parameters.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <set>
#include <stdexcept>
#include <unordered_map>

namespace sinew_ros2_control {
namespace {

using hardware_interface::ComponentInfo;
using hardware_interface::InterfaceInfo;

const Quantity quantities[] = {
    {"temperature", [](const SinewChannelState &channel) { return channel.temperature_c; }},
    {"length", [](const SinewChannelState &channel) { return channel.length_m; }},
    {"resistance", [](const SinewChannelState &channel) { return channel.resistance_ohm; }},
    {"martensite", [](const SinewChannelState &channel) { return channel.martensite; }},
    {"power", [](const SinewChannelState &channel) { return channel.power_w; }},
    {"duty", [](const SinewChannelState &channel) { return channel.duty; }},
    {"current", [](const SinewChannelState &channel) { return channel.current_a; }},
    {"supply", [](const SinewChannelState &channel) { return channel.supply_v; }},
    {"mode", [](const SinewChannelState &channel) { return static_cast<double>(channel.mode); }},
    {"fault", [](const SinewChannelState &channel) { return static_cast<double>(channel.fault); }},
};

constexpr const char *state_names[] = {"position", "velocity", "effort"};

/// The names of a row, for people.
template <class Row, class Name>
std::string listed(const Row &row, Name name) {
    std::string list;
    for (const auto &entry : row) {
        list += (list.empty() ? "" : ", ") + std::string(name(entry));
    }
    return list;
}

std::string listed(const std::set<std::string> &names) {
    return listed(names, [](const std::string &name) { return name; });
}

/// The `<param>`s of one place. Each is asked for by name; what nobody asks for is a mistake.
class Params {
public:
    Params(std::string place, const std::unordered_map<std::string, std::string> &found) : place_(std::move(place)), found_(found) {}

    [[noreturn]] void wrong(const std::string &what) const { throw std::invalid_argument(place_ + ": " + what); }

    std::string text(const char *key, const std::string &otherwise) {
        known_.insert(key);
        const auto found = found_.find(key);
        return found == found_.end() ? otherwise : found->second;
    }

    std::optional<double> number(const char *key, double low, double high) {
        const std::string text = this->text(key, "");
        if (text.empty() && found_.count(key) == 0) {
            return std::nullopt;
        }
        double value = 0.0;
        // from_chars: a decimal point is one wherever the program runs
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc() || end != text.data() + text.size() || !(value >= low && value <= high)) {
            std::string range(128, '\0');
            range.resize(static_cast<std::size_t>(std::snprintf(range.data(), range.size(), "%g to %g", low, high)));
            wrong(std::string(key) + " = \"" + text + "\" is not a number from " + range + "; write one, with a decimal point");
        }
        return value;
    }

    /// One of these words; its place.
    std::size_t word(const char *key, std::initializer_list<const char *> words, std::size_t otherwise) {
        const std::string text = this->text(key, *(words.begin() + otherwise));
        const auto found = std::find(words.begin(), words.end(), text);
        if (found == words.end()) {
            wrong(std::string(key) + " = \"" + text + "\"; write one of " + listed(words, [](const char *word) { return word; }));
        }
        return static_cast<std::size_t>(found - words.begin());
    }

    void nothing_else() const {
        for (const auto &[key, value] : found_) {
            if (known_.count(key) == 0) {
                wrong("there is no parameter \"" + key + "\"; there are " + listed(known_));
            }
        }
    }

private:
    std::string place_;
    const std::unordered_map<std::string, std::string> &found_;
    std::set<std::string> known_;
};

HardwareParameters hardware_of(const hardware_interface::HardwareInfo &info) {
    constexpr double longest_s = 3600.0;
    Params params("<hardware> of " + info.name, info.hardware_parameters);
    HardwareParameters hardware;
    hardware.rig = params.text("rig", "");
    if (const auto priority = params.number("priority", 0.0, 9.0)) {
        if (*priority != std::floor(*priority)) {
            params.wrong("priority is not whole; write one of 0 to 9");
        }
        hardware.priority = static_cast<std::uint32_t>(*priority);
    }
    hardware.hold_s = params.number("hold_s", 0.001, longest_s).value_or(hardware.hold_s);
    // The manager's own period: a slow manager then moves the driver's fast loop without steps.
    const double period_s = info.rw_rate > 0 ? 1.0 / info.rw_rate : hardware.over_s;
    hardware.over_s = params.number("over_s", 0.0, longest_s).value_or(std::min(period_s, hardware.hold_s));
    hardware.within_s = params.number("within_s", 0.0, longest_s).value_or(hardware.within_s);
    hardware.ready_s = params.number("ready_s", 0.0, longest_s).value_or(hardware.ready_s);
    hardware.on_fault = static_cast<OnFault>(params.word("on_fault", {"deactivate", "error", "carry_on"}, 0));
    hardware.reset_faults = params.word("reset_faults", {"false", "true"}, 0) == 1;
    hardware.thread_priority = static_cast<int>(params.number("thread_priority", 0.0, 99.0).value_or(0.0));
    params.nothing_else();
    if (hardware.over_s > hardware.hold_s) {
        params.wrong("over_s is longer than hold_s; a setpoint has to be reached before it ends");
    }
    if (info.rw_rate > 0 && hardware.hold_s < 3.0 * period_s) {
        params.wrong("hold_s is shorter than three periods of the manager; each write renews it, and one that is late must not end it");
    }
    return hardware;
}

JointParameters joint_of(const ComponentInfo &component) {
    constexpr double longest_mm = 1e5;
    Params params("<joint> " + component.name, component.parameters);
    JointParameters joint;
    joint.name = component.name;
    joint.channel = params.text("channel", component.name);
    joint.antagonist = params.text("antagonist", "");
    const auto metres = [&](const char *key, double low) {
        const auto mm = params.number(key, low, longest_mm);
        return mm ? std::optional<double>(*mm * 1e-3) : std::nullopt;
    };
    joint.radius_m = metres("radius_mm", 0.001);
    joint.direction = params.word("direction", {"1", "-1"}, 0) == 0 ? 1.0 : -1.0;
    joint.zero_m = metres("zero_mm", 0.0);
    joint.spring_n_per_m = params.number("spring_n_per_m", 0.0, 1e7);
    joint.preload_n = params.number("preload_n", -1e5, 1e5);
    params.nothing_else();

    if (joint.spring_n_per_m.has_value() != joint.preload_n.has_value()) {
        params.wrong("spring_n_per_m and preload_n belong together; write both, as in [channel.load] of the rig file");
    }
    if (!joint.antagonist.empty()) {
        if (!joint.radius_m) {
            params.wrong("two wires turn it, and it has no lever; write radius_mm as in [[joint]] of the rig file");
        }
        if (joint.zero_m || joint.spring_n_per_m) {
            params.wrong("of a joint between two wires the rig file says where 0 is and what pulls; leave out zero_mm, spring_n_per_m and preload_n");
        }
    }
    for (const InterfaceInfo &interface : component.state_interfaces) {
        if (std::none_of(std::begin(state_names), std::end(state_names), [&](const char *name) { return interface.name == name; })) {
            params.wrong("there is no state interface \"" + interface.name + "\"; there are " +
                         listed(state_names, [](const char *name) { return name; }) + "; other quantities are those of a <sensor>");
        }
    }
    for (const InterfaceInfo &interface : component.command_interfaces) {
        if (std::none_of(std::begin(command_names), std::end(command_names), [&](const char *name) { return interface.name == name; })) {
            params.wrong("there is no command interface \"" + interface.name + "\"; there are " +
                         listed(command_names, [](const char *name) { return name; }));
        }
        if (interface.name == command_names[effort] && !joint.spring_n_per_m) {
            params.wrong("effort can only be commanded against a spring; write spring_n_per_m and preload_n, or leave it out");
        }
        if (interface.name == command_names[duty] && !joint.antagonist.empty()) {
            params.wrong("a duty is for one wire and this joint has two; leave it out");
        }
    }
    return joint;
}

SensorParameters sensor_of(const ComponentInfo &component) {
    Params params("<sensor> " + component.name, component.parameters);
    SensorParameters sensor;
    sensor.name = component.name;
    sensor.channel = params.text("channel", component.name);
    params.nothing_else();
    for (const InterfaceInfo &interface : component.state_interfaces) {
        const auto found = std::find_if(std::begin(quantities), std::end(quantities), [&](const Quantity &quantity) {
            return interface.name == quantity.name;
        });
        if (found == std::end(quantities)) {
            params.wrong("there is no state interface \"" + interface.name + "\"; there are " +
                         listed(quantities, [](const Quantity &quantity) { return quantity.name; }));
        }
        sensor.quantities.push_back(&*found);
    }
    return sensor;
}

}  // namespace

Parameters Parameters::of(const hardware_interface::HardwareInfo &info) {
    Parameters parameters{hardware_of(info), {}, {}};
    std::set<std::string> taken;
    const auto take = [&](const std::string &joint, const std::string &channel) {
        if (!channel.empty() && !taken.insert(channel).second) {
            throw std::invalid_argument("<joint> " + joint + ": its channel \"" + channel + "\" is another joint's, too; name each once");
        }
    };
    for (const ComponentInfo &component : info.joints) {
        parameters.joints.push_back(joint_of(component));
        take(parameters.joints.back().name, parameters.joints.back().channel);
        take(parameters.joints.back().name, parameters.joints.back().antagonist);
    }
    for (const ComponentInfo &component : info.sensors) {
        parameters.sensors.push_back(sensor_of(component));
    }
    if (!info.gpios.empty()) {
        throw std::invalid_argument("<gpio> " + info.gpios.front().name + ": there are none; a channel's quantities are those of a <sensor>");
    }
    return parameters;
}

}  // namespace sinew_ros2_control
