// Stub for tests alone: see README.md.
#ifndef RCLCPP__LOGGER_HPP_
#define RCLCPP__LOGGER_HPP_
#include <string>
#include <utility>

namespace rclcpp {
class Logger {
public:
    const char *get_name() const { return name_.c_str(); }

private:
    friend Logger get_logger(const std::string &name);
    explicit Logger(std::string name) : name_(std::move(name)) {}
    std::string name_;
};
inline Logger get_logger(const std::string &name) {
    return Logger(name);
}
}  // namespace rclcpp
#endif  // RCLCPP__LOGGER_HPP_
