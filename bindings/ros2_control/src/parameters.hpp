// What the URDF says in <param>, read and checked: `<hardware>`, each `<joint>`, each `<sensor>`.
#ifndef SINEW_ROS2_CONTROL__PARAMETERS_HPP_
#define SINEW_ROS2_CONTROL__PARAMETERS_HPP_

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <sinew.h>

#include "hardware_interface/hardware_info.hpp"

namespace sinew_ros2_control {

/// What becomes of the whole when a wire has a fault.
enum class OnFault { deactivate, error, carry_on };

struct HardwareParameters {
    /// Name of the rig; empty: the only one that runs.
    std::string rig;
    /// Of the claim on the channels, 0 to 9; without one others may command them, too.
    std::optional<std::uint32_t> priority;
    /// How long a setpoint holds, and the claim, s.
    double hold_s = 0.5;
    /// Time in which a setpoint is approached, s.
    double over_s = 0.01;
    /// A setpoint the driver gets to later than this is not carried out, s.
    double within_s = 0.1;
    /// How long activation waits for the sensors, s.
    double ready_s = 5.0;
    OnFault on_fault = OnFault::deactivate;
    /// Whether activation resets latched faults.
    bool reset_faults = false;
    /// SCHED_FIFO of the thread that hands setpoints over; 0: not asked for.
    int thread_priority = 0;
};

/// What can be commanded of a joint.
enum Command : std::size_t { position, effort, stroke, duty, commands };
inline constexpr const char *command_names[commands] = {"position", "effort", "stroke", "duty"};

struct JointParameters {
    std::string name, channel;
    /// The other wire, which turns it back; empty without.
    std::string antagonist;
    /// Lever or spool, m per rad; none: the joint is moved in m.
    std::optional<double> radius_m;
    /// 1: position grows as the wire contracts; -1: as it gets longer.
    double direction = 1.0;
    /// Wire length at position 0, m; none: cold, or for two wires the middle of the stroke.
    std::optional<double> zero_m;
    /// Spring and pull on the wire at its hot, unloaded length; none: effort is not known.
    std::optional<double> spring_n_per_m, preload_n;
};

/// A quantity of a channel that a `<sensor>` may have, in the unit of the driver.
struct Quantity {
    const char *name;
    double (*of)(const SinewChannelState &channel);
};

struct SensorParameters {
    std::string name, channel;
    /// What of the channel, in the order of the URDF.
    std::vector<const Quantity *> quantities;
};

/// Everything of one `<ros2_control>`. std::invalid_argument says what is wrong, where, and what would be right.
struct Parameters {
    HardwareParameters hardware;
    std::vector<JointParameters> joints;
    std::vector<SensorParameters> sensors;

    static Parameters of(const hardware_interface::HardwareInfo &info);
};

}  // namespace sinew_ros2_control

#endif  // SINEW_ROS2_CONTROL__PARAMETERS_HPP_
