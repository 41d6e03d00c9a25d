// A joint between ROS and the wires that turn it: positions, velocities and efforts one way, setpoints the other.
#ifndef SINEW_ROS2_CONTROL__JOINT_HPP_
#define SINEW_ROS2_CONTROL__JOINT_HPP_

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include <sinew.hpp>

#include "parameters.hpp"

namespace sinew_ros2_control {

/// One wire against its load, or two against each other. Angles in rad and efforts in N m where there is a radius, else m and N.
class Joint {
public:
    /// Error for a channel the rig has not; std::invalid_argument for what cannot be, with the remedy.
    Joint(const JointParameters &parameters, const sinew::Client &client);

    const std::string &name() const noexcept { return parameters_.name; }
    std::uint32_t channel() const noexcept { return channel_; }
    std::optional<std::uint32_t> antagonist() const noexcept { return antagonist_; }

    double position(const sinew::Snapshot &state) const noexcept;
    double velocity(const sinew::Snapshot &state) const noexcept;
    /// What the wire pulls with, at rest, against its spring; NaN where that is not known.
    double effort(const sinew::Snapshot &state) const noexcept;

    /// A command in the driver's units, within what it takes.
    struct Setpoint {
        SinewCommandKind kind;
        double value;
        /// Whether that is far from what was asked for.
        bool is_beyond;
    };
    Setpoint setpoint(Command command, double value) const noexcept;

private:
    const SinewChannelState &of(const sinew::Snapshot &state, std::uint32_t channel) const noexcept { return state.channel[channel]; }
    /// What the wire pulls with at this length, N.
    double tension_n(double length_m) const noexcept;

    JointParameters parameters_;
    std::uint32_t channel_;
    std::optional<std::uint32_t> antagonist_;
    sinew::ChannelInfo info_;
    /// Lengths at position 0, m.
    double zero_m_, antagonist_zero_m_;
    /// Change of length with position: m per rad, or 1; negative where position grows as the wire contracts.
    double slope_;
};

}  // namespace sinew_ros2_control

#endif  // SINEW_ROS2_CONTROL__JOINT_HPP_
