// Stub for tests alone: see README.md of this folder.
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "rclcpp/rclcpp.hpp"

namespace realtime_tools {
struct AsyncSchedulingPolicy {
    explicit AsyncSchedulingPolicy(const std::string & = "") {}
    std::string to_string() const { return ""; }
};
struct AsyncFunctionHandlerParams {
    int thread_priority = 0;
    AsyncSchedulingPolicy scheduling_policy;
    std::vector<int> cpu_affinity_cores;
    rclcpp::Clock::SharedPtr clock;
    rclcpp::Logger logger = rclcpp::get_logger("");
    unsigned int exec_rate = 0;
    bool print_warnings = false;
};
template <class T>
struct AsyncFunctionHandler {
    void init(std::function<T(const rclcpp::Time &, const rclcpp::Duration &)>, const AsyncFunctionHandlerParams &) {}
    void start_thread() {}
    void stop_thread() {}
    void pause_execution() {}
    std::pair<bool, T> trigger_async_callback(const rclcpp::Time &, const rclcpp::Duration &) { return {true, T{}}; }
};
}  // namespace realtime_tools
