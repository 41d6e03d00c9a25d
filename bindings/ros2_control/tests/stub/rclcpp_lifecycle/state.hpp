// Stub for tests alone: see README.md.
#ifndef RCLCPP_LIFECYCLE__STATE_HPP_
#define RCLCPP_LIFECYCLE__STATE_HPP_
#include <cstdint>
#include <string>
#include <utility>

namespace rclcpp_lifecycle {
class State {
public:
    State(std::uint8_t id, std::string label) : id_(id), label_(std::move(label)) {}
    std::uint8_t id() const { return id_; }
    std::string label() const { return label_; }

private:
    std::uint8_t id_;
    std::string label_;
};
}  // namespace rclcpp_lifecycle
#endif  // RCLCPP_LIFECYCLE__STATE_HPP_
