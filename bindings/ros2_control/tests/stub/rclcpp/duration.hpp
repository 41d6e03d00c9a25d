// Stub for tests alone: see README.md.
#ifndef RCLCPP__DURATION_HPP_
#define RCLCPP__DURATION_HPP_
#include <chrono>
#include <cstdint>

namespace rclcpp {
class Duration {
public:
    explicit Duration(std::chrono::nanoseconds ns) : ns_(ns.count()) {}
    std::int64_t nanoseconds() const { return ns_; }
    double seconds() const { return static_cast<double>(ns_) * 1e-9; }

private:
    std::int64_t ns_;
};
}  // namespace rclcpp
#endif  // RCLCPP__DURATION_HPP_
