#include "joint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace sinew_ros2_control {
namespace {

/// Share of the way by which a command may be beyond its end without a word: what is measured has noise, and a controller that holds what is
/// measured may ask for a little more than there is.
constexpr double slack = 0.02;

double middle_m(const sinew::ChannelInfo &info) {
    return info.length_at_stroke(0.5);
}

}  // namespace

Joint::Joint(const JointParameters &parameters, const sinew::Client &client)
    : parameters_(parameters), channel_(client.channel(parameters.channel)), info_(client.channels()[channel_]),
      antagonist_zero_m_(std::numeric_limits<double>::quiet_NaN()) {
    slope_ = -parameters.direction * parameters.radius_m.value_or(1.0);
    zero_m_ = parameters.zero_m.value_or(info_.cold_length_m);
    if (!parameters.antagonist.empty()) {
        antagonist_ = client.channel(parameters.antagonist);
        zero_m_ = middle_m(info_);
        antagonist_zero_m_ = middle_m(client.channels()[*antagonist_]);
    }
}

double Joint::position(const sinew::Snapshot &state) const noexcept {
    double change_m = of(state, channel_).length_m - zero_m_;
    if (antagonist_) {
        // both wires say where it is, each with its own error
        change_m = 0.5 * (change_m - (of(state, *antagonist_).length_m - antagonist_zero_m_));
    }
    return change_m / slope_;
}

double Joint::velocity(const sinew::Snapshot &state) const noexcept {
    double change_m_s = of(state, channel_).velocity_m_s;
    if (antagonist_) {
        change_m_s = 0.5 * (change_m_s - of(state, *antagonist_).velocity_m_s);
    }
    return change_m_s / slope_;
}

double Joint::tension_n(double length_m) const noexcept {
    if (!parameters_.spring_n_per_m) {
        return std::numeric_limits<double>::quiet_NaN();
    }
    return *parameters_.preload_n - *parameters_.spring_n_per_m * (length_m - info_.rest_length_m);
}

double Joint::effort(const sinew::Snapshot &state) const noexcept {
    // virtual work: what turns it forward is what shortens the wire
    return -tension_n(of(state, channel_).length_m) * slope_;
}

Joint::Setpoint Joint::setpoint(Command command, double value) const noexcept {
    double low = 0.0, high = 1.0;
    SinewCommandKind kind = SINEW_COMMAND_KIND_STROKE;
    switch (command) {
        case Command::position:
            kind = SINEW_COMMAND_KIND_LENGTH;
            value = zero_m_ + slope_ * value;
            low = info_.min_length_m, high = info_.max_length_m;
            break;
        case Command::effort:
            kind = SINEW_COMMAND_KIND_FORCE;
            value = -value / slope_;
            low = tension_n(info_.max_length_m), high = tension_n(info_.min_length_m);
            break;
        case Command::duty:
            kind = SINEW_COMMAND_KIND_DUTY;
            high = info_.max_duty;
            break;
        case Command::stroke:
        case Command::commands:
            break;
    }
    const double most = slack * (high - low);
    return {kind, std::clamp(value, low, high), value < low - most || value > high + most};
}

}  // namespace sinew_ros2_control
