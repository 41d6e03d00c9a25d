#include "sinew_ros2_control/system.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include <sinew.hpp>

#include "joint.hpp"
#include "parameters.hpp"
#include "rclcpp/logging.hpp"
#include "sender.hpp"

using namespace std::chrono_literals;
using hardware_interface::CommandInterface;
using hardware_interface::return_type;
using hardware_interface::StateInterface;

namespace sinew_ros2_control {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// What is in force of a joint.
struct Driven {
    Joint joint;
    StateInterface::SharedPtr position, velocity, effort;
    /// By `Command`; null where the URDF has none.
    CommandInterface::SharedPtr command[commands];
    /// Their full names, such as left/position.
    std::string names[commands];
    /// What a controller has claimed, and the value it has given last.
    std::optional<Command> claimed;
    double value = unknown;
    /// While it is being switched off: the first message that does so, and the cycle in which that was with the driver.
    bool is_to_be_off = false;
    std::uint64_t off_message = 0, off_cycle = 0;
    /// Its fault when it was looked at last.
    std::uint32_t fault = 0;
};

/// A quantity of a channel and where it goes to.
struct Sensed {
    std::uint32_t channel;
    const Quantity *quantity;
    StateInterface::SharedPtr place;
};

}  // namespace

/// All there is from configuration on.
struct System::Rig {
    Parameters parameters;
    /// From configuration on.
    std::optional<sinew::Client> client;
    std::vector<Driven> joints;
    std::vector<Sensed> sensors;
    /// Every channel of a joint.
    std::vector<std::uint32_t> channels;
    /// A lease in cycles of the driver.
    std::uint64_t lease_cycles = 0;
    sinew::Snapshot state;
    /// While it is active.
    std::unique_ptr<Sender> sender;

    explicit Rig(Parameters found) : parameters(std::move(found)) {}

    const char *name_of(std::uint32_t channel) const { return client->channels()[channel].name; }
    /// The channel of a joint that has a fault: that which came first, not its partner's.
    std::uint32_t faulty(const Driven &driven) const {
        const auto partner = driven.joint.antagonist();
        const std::uint32_t fault = state.channel[driven.joint.channel()].fault;
        return partner && (fault == 0 || fault == SINEW_FAULT_JOINT_PARTNER) ? *partner : driven.joint.channel();
    }
    /// Whether a joint that is being switched off is off, and stays so: a message that is with the driver may still be overtaken by the next.
    bool is_off(Driven &driven, const Sender &sender) {
        if (driven.off_message == 0 || sender.sent() < driven.off_message) {
            return false;
        }
        if (driven.off_cycle == 0) {
            driven.off_cycle = state.cycle;
        }
        const std::uint32_t mode = state.channel[driven.joint.channel()].mode;
        const bool is_driven = mode == SINEW_MODE_LENGTH || mode == SINEW_MODE_DUTY || mode == SINEW_MODE_FORCE;
        // driven for longer than a lease: it is somebody else who does
        driven.is_to_be_off = state.cycle < driven.off_cycle + (is_driven ? lease_cycles : 10);
        return !driven.is_to_be_off;
    }
    std::vector<sinew::Wanted> all_off() const {
        std::vector<sinew::Wanted> off;
        std::transform(channels.begin(), channels.end(), std::back_inserter(off), sinew::Wanted::off);
        return off;
    }
};

System::System() = default;

System::~System() {
    let_go();
}

System::CallbackReturn System::failed(CallbackReturn how, const char *place, const std::string &text) const {
    RCLCPP_ERROR(get_logger(), "%s: %s", place, text.c_str());
    return how;
}

/// Switches the wires off, whatever has happened; a driver that is gone has done so itself.
void System::let_go() noexcept {
    if (!rig_ || !rig_->sender) {
        return;
    }
    try {
        // first: nothing it still has may come after the off
        rig_->sender.reset();
        if (rig_->channels.empty()) {
            return;
        }
        rig_->client->set_many(rig_->all_off());
        if (rig_->parameters.hardware.priority) {
            rig_->client->release(rig_->channels);
        }
        RCLCPP_INFO(get_logger(), "wires off");
    } catch (const std::exception &error) {
        RCLCPP_WARN(get_logger(), "wires go off with their leases, in %g s at the latest: %s", rig_->parameters.hardware.hold_s, error.what());
    }
}

System::CallbackReturn System::on_init(const hardware_interface::HardwareComponentInterfaceParams &params) {
    const CallbackReturn parsed = SystemInterface::on_init(params);
    if (parsed != CallbackReturn::SUCCESS) {
        return parsed;
    }
    try {
        rig_ = std::make_unique<Rig>(Parameters::of(info_));
    } catch (const std::exception &error) {
        return failed(CallbackReturn::ERROR, "the URDF", error.what());
    }
    return CallbackReturn::SUCCESS;
}

System::CallbackReturn System::on_configure(const rclcpp_lifecycle::State &) {
    try {
        std::string name = rig_->parameters.hardware.rig;
        if (name.empty()) {
            const auto found = sinew::Client::discover();
            if (found.size() != 1) {
                return failed(CallbackReturn::FAILURE, "on_configure",
                              found.empty() ? "no driver runs; start one with `sinew run RIG.toml`"
                                            : "several drivers run; name the one meant: <param name=\"rig\"> in <hardware>");
            }
            name = found.front();
        }
        rig_->client.emplace(sinew::Client::connect(name));
        rig_->joints.clear();
        rig_->sensors.clear();
        rig_->channels.clear();
        for (const JointParameters &parameters : rig_->parameters.joints) {
            rig_->joints.push_back({Joint(parameters, *rig_->client), {}, {}, {}, {}, {}, {}, unknown, false, 0, 0, 0});
            Driven &driven = rig_->joints.back();
            const auto state = [&](const char *interface) -> StateInterface::SharedPtr {
                const std::string full = parameters.name + "/" + interface;
                return has_state(full) ? get_state_interface_handle(full) : nullptr;
            };
            driven.position = state(hardware_interface::HW_IF_POSITION);
            driven.velocity = state(hardware_interface::HW_IF_VELOCITY);
            driven.effort = state(hardware_interface::HW_IF_EFFORT);
            for (std::size_t i = 0; i < commands; ++i) {
                driven.names[i] = parameters.name + "/" + command_names[i];
                if (has_command(driven.names[i])) {
                    driven.command[i] = get_command_interface_handle(driven.names[i]);
                }
            }
            rig_->channels.push_back(driven.joint.channel());
            if (const auto antagonist = driven.joint.antagonist()) {
                rig_->channels.push_back(*antagonist);
            }
        }
        for (const SensorParameters &parameters : rig_->parameters.sensors) {
            const std::uint32_t channel = rig_->client->channel(parameters.channel);
            for (const Quantity *const quantity : parameters.quantities) {
                rig_->sensors.push_back({channel, quantity, get_state_interface_handle(parameters.name + "/" + quantity->name)});
            }
        }
        rig_->lease_cycles = static_cast<std::uint64_t>(rig_->parameters.hardware.hold_s * rig_->client->info().rate_hz);
        rig_->client->latest(rig_->state);
        RCLCPP_INFO(get_logger(), "connected to %s: %zu joints on %zu of its %zu channels, %s", name.c_str(), rig_->joints.size(),
                    rig_->channels.size(), rig_->client->channels().size(),
                    rig_->client->info().simulated != 0 ? "simulated" : "on real wires");
    } catch (const std::exception &error) {
        rig_->client.reset();
        return failed(CallbackReturn::FAILURE, "on_configure", error.what());
    }
    return CallbackReturn::SUCCESS;
}

System::CallbackReturn System::on_cleanup(const rclcpp_lifecycle::State &) {
    let_go();
    rig_->client.reset();
    return CallbackReturn::SUCCESS;
}

System::CallbackReturn System::on_activate(const rclcpp_lifecycle::State &) {
    const HardwareParameters &hardware = rig_->parameters.hardware;
    try {
        const sinew::Client &client = *rig_->client;
        const auto is = [&](std::uint32_t channel, SinewMode mode) { return rig_->state.channel[channel].mode == static_cast<std::uint32_t>(mode); };
        const auto end = std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::nanoseconds>(sinew::Seconds(hardware.ready_s));
        const auto waiting = [&] {
            client.latest(rig_->state);
            return std::find_if(rig_->channels.begin(), rig_->channels.end(), [&](std::uint32_t channel) { return is(channel, SINEW_MODE_WAITING); });
        };
        for (auto found = waiting(); found != rig_->channels.end(); found = waiting()) {
            if (std::chrono::steady_clock::now() > end) {
                return failed(CallbackReturn::FAILURE, "on_activate",
                              std::string(rig_->name_of(*found)) + " waits for its sensors; see `sinew status` for what they lack, or raise ready_s");
            }
            std::this_thread::sleep_for(10ms);
        }
        for (Driven &driven : rig_->joints) {
            const std::uint32_t channel = rig_->faulty(driven);
            if (const sinew::Fault fault{rig_->state.channel[channel].fault}) {
                if (!hardware.reset_faults) {
                    return failed(CallbackReturn::FAILURE, "on_activate",
                                  std::string(rig_->name_of(channel)) + " is off: " + fault.cause() + "; " + fault.remedy() +
                                      ", and activate again (reset_faults = true resets by itself)");
                }
                client.reset(rig_->name_of(channel));
                // its partner's has gone with its own cause, but stays latched
                if (const auto partner = driven.joint.antagonist()) {
                    const std::uint32_t other = channel == *partner ? driven.joint.channel() : *partner;
                    client.latest(rig_->state);
                    if (rig_->state.channel[other].fault != 0) {
                        client.reset(rig_->name_of(other));
                    }
                }
            }
        }
        std::optional<Claim> claim;
        if (hardware.priority && !rig_->channels.empty()) {
            claim = Claim{rig_->channels, *hardware.priority, sinew::Seconds(hardware.hold_s)};
            client.claim(claim->channels, claim->priority, claim->hold);
        }
        // Nothing is wanted until a controller says so.
        for (Driven &driven : rig_->joints) {
            driven.value = unknown;
            driven.is_to_be_off = false;
            driven.fault = 0;
            for (const auto &command : driven.command) {
                if (command) {
                    set_command(command, unknown, true);
                }
            }
        }
        client.latest(rig_->state);
        const sinew::SetpointOptions options{sinew::Seconds(hardware.hold_s), sinew::Seconds(hardware.over_s), sinew::Seconds(hardware.within_s)};
        rig_->sender = std::make_unique<Sender>(client, options, std::move(claim), hardware.thread_priority, get_logger());
    } catch (const std::exception &error) {
        return failed(CallbackReturn::FAILURE, "on_activate", error.what());
    }
    return CallbackReturn::SUCCESS;
}

System::CallbackReturn System::on_deactivate(const rclcpp_lifecycle::State &) {
    let_go();
    return CallbackReturn::SUCCESS;
}

System::CallbackReturn System::on_shutdown(const rclcpp_lifecycle::State &) {
    let_go();
    if (rig_) {
        rig_->client.reset();
    }
    return CallbackReturn::SUCCESS;
}

System::CallbackReturn System::on_error(const rclcpp_lifecycle::State &) {
    let_go();
    if (rig_) {
        rig_->client.reset();
    }
    return CallbackReturn::SUCCESS;
}

/// Two commands for one joint at a time contradict each other.
return_type System::prepare_command_mode_switch(const Interfaces &start, const Interfaces &stop) {
    if (!rig_) {
        return return_type::OK;
    }
    const auto names = [](const Interfaces &interfaces, const std::string &name) {
        return std::find(interfaces.begin(), interfaces.end(), name) != interfaces.end();
    };
    for (const Driven &driven : rig_->joints) {
        std::size_t claimed = 0;
        for (std::size_t i = 0; i < commands; ++i) {
            const bool is_held = driven.claimed == static_cast<Command>(i) && !names(stop, driven.names[i]);
            claimed += is_held || names(start, driven.names[i]) ? 1 : 0;
        }
        if (claimed > 1) {
            RCLCPP_ERROR(get_logger(), "%s would be commanded in two ways at a time; let one controller have it, with one command interface",
                         driven.joint.name().c_str());
            return return_type::ERROR;
        }
    }
    return return_type::OK;
}

return_type System::perform_command_mode_switch(const Interfaces &start, const Interfaces &stop) {
    if (!rig_) {
        return return_type::OK;
    }
    const auto each = [&](const Interfaces &interfaces, auto then) {
        for (const std::string &interface : interfaces) {
            for (Driven &driven : rig_->joints) {
                for (std::size_t i = 0; i < commands; ++i) {
                    if (driven.command[i] && interface == driven.names[i]) {
                        then(driven, static_cast<Command>(i));
                    }
                }
            }
        }
    };
    each(stop, [](Driven &driven, Command command) {
        if (driven.claimed == command) {
            driven.claimed.reset();
            driven.is_to_be_off = true;
            driven.off_message = driven.off_cycle = 0;
        }
    });
    each(start, [&](Driven &driven, Command command) {
        driven.claimed = command;
        driven.is_to_be_off = false;
        // what the controller before wanted is not wanted any more
        driven.value = unknown;
        set_command(driven.command[command], unknown, false);
    });
    return return_type::OK;
}

return_type System::read(const rclcpp::Time &, const rclcpp::Duration &) {
    Rig &rig = *rig_;
    try {
        rig.client->latest(rig.state);
    } catch (const std::exception &error) {
        failed(CallbackReturn::ERROR, "read", error.what());
        return return_type::ERROR;
    }
    if (rig.state.state >= static_cast<std::uint32_t>(SINEW_DRIVER_STATE_STOPPING) || (!rig.sender && !rig.client->is_alive())) {
        failed(CallbackReturn::ERROR, "read", "the driver has ended; start it again with `sinew run`, then configure and activate");
        return return_type::ERROR;
    }
    // One that a controller looks at right now keeps its value until the next cycle.
    const auto put = [this](const StateInterface::SharedPtr &place, double value) {
        if (place) {
            set_state(place, value, false);
        }
    };
    for (const Driven &driven : rig.joints) {
        put(driven.position, driven.joint.position(rig.state));
        put(driven.velocity, driven.joint.velocity(rig.state));
        put(driven.effort, driven.joint.effort(rig.state));
    }
    for (const Sensed &sensed : rig.sensors) {
        put(sensed.place, sensed.quantity->of(rig.state.channel[sensed.channel]));
    }
    return return_type::OK;
}

return_type System::write(const rclcpp::Time &, const rclcpp::Duration &) {
    Rig &rig = *rig_;
    if (!rig.sender) {
        return return_type::OK;
    }
    Sender &sender = *rig.sender;
    if (sender.failed()) {
        failed(CallbackReturn::ERROR, "write", sender.why());
        return return_type::ERROR;
    }
    bool has_new_fault = false;
    for (Driven &driven : rig.joints) {
        const std::uint32_t channel = rig.faulty(driven);
        const std::uint32_t code = rig.state.channel[channel].fault;
        if (code != 0 && code != driven.fault) {
            const sinew::Fault fault{code};
            RCLCPP_ERROR(get_logger(), "%s: %s is off: %s; %s", driven.joint.name().c_str(), rig.name_of(channel), fault.cause(), fault.remedy());
            has_new_fault = true;
        }
        driven.fault = code;
        const auto partner = driven.joint.antagonist();
        const auto is_moved = [&](std::uint32_t number) { return rig.state.channel[number].mode == static_cast<std::uint32_t>(SINEW_MODE_LENGTH); };
        if (partner && code == 0 && is_moved(driven.joint.channel()) && !is_moved(*partner)) {
            failed(CallbackReturn::ERROR, "write",
                   std::string(rig.name_of(driven.joint.channel())) + " and " + rig.name_of(*partner) +
                       " are not the wires of one [[joint]] of the rig file; put them there, or leave antagonist out");
            return return_type::ERROR;
        }
    }
    if (has_new_fault && rig.parameters.hardware.on_fault != OnFault::carry_on) {
        return rig.parameters.hardware.on_fault == OnFault::error ? return_type::ERROR : return_type::DEACTIVATE;
    }

    Message &message = sender.place();
    for (Driven &driven : rig.joints) {
        if (driven.is_to_be_off && !rig.is_off(driven, sender)) {
            if (driven.off_message == 0) {
                driven.off_message = message.number;
            }
            message.add(driven.joint.channel(), SINEW_COMMAND_KIND_OFF, 0.0);
        }
        if (!driven.claimed || driven.fault != 0) {
            continue;
        }
        double value = unknown;
        // one that a controller writes right now: what it wrote last
        if (get_command(driven.command[*driven.claimed], value, false)) {
            driven.value = value;
        }
        // NaN: nothing is wanted, and what was ends with its lease
        if (std::isnan(driven.value)) {
            continue;
        }
        const Joint::Setpoint setpoint = driven.joint.setpoint(*driven.claimed, driven.value);
        if (setpoint.is_beyond) {
            sender.beyond_reach(driven.names[*driven.claimed].c_str());
        }
        message.add(driven.joint.channel(), setpoint.kind, setpoint.value);
    }
    sender.hand_over();
    return return_type::OK;
}

}  // namespace sinew_ros2_control

#include "pluginlib/class_list_macros.hpp"

PLUGINLIB_EXPORT_CLASS(sinew_ros2_control::System, hardware_interface::SystemInterface)
