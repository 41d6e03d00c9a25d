// Stub for tests alone: see README.md. Everything goes to stderr, a line each.
#ifndef RCLCPP__LOGGING_HPP_
#define RCLCPP__LOGGING_HPP_
#include <cstdarg>
#include <cstdio>

#include "rclcpp/logger.hpp"

namespace rclcpp {
__attribute__((format(printf, 3, 4))) inline void stub_say(const char *level, const Logger &logger, const char *format, ...) {
    char line[4096];
    va_list values;
    va_start(values, format);
    std::vsnprintf(line, sizeof line, format, values);
    va_end(values);
    std::fprintf(stderr, "[%s] [%s]: %s\n", level, logger.get_name(), line);
}
}  // namespace rclcpp

#define RCLCPP_INFO(logger, ...) ::rclcpp::stub_say("INFO", logger, __VA_ARGS__)
#define RCLCPP_WARN(logger, ...) ::rclcpp::stub_say("WARN", logger, __VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) ::rclcpp::stub_say("ERROR", logger, __VA_ARGS__)
#endif  // RCLCPP__LOGGING_HPP_
