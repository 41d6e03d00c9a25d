// Stub for tests alone: see README.md.
#ifndef RCLCPP__TIME_HPP_
#define RCLCPP__TIME_HPP_
#include <cstdint>

namespace rclcpp {
class Time {
public:
    explicit Time(std::int64_t nanoseconds = 0) : ns_(nanoseconds) {}
    std::int64_t nanoseconds() const { return ns_; }

private:
    std::int64_t ns_;
};
}  // namespace rclcpp
#endif  // RCLCPP__TIME_HPP_
