// Stub for tests alone: see README.md of this folder.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "rclcpp/duration.hpp"
#include "rclcpp/logger.hpp"
#include "rclcpp/logging.hpp"
#include "rclcpp/time.hpp"

#define RCLCPP_WARN_EXPRESSION(logger, expression, ...) \
    do {                                                \
        if (expression) RCLCPP_WARN(logger, __VA_ARGS__); \
    } while (0)

namespace rclcpp {
struct Clock {
    using SharedPtr = std::shared_ptr<Clock>;
};
struct NodeOptions {
    NodeOptions &enable_logger_service(bool) { return *this; }
    NodeOptions &arguments(const std::vector<std::string> &) { return *this; }
};
namespace node_interfaces {
struct NodeBaseInterface {
    using SharedPtr = std::shared_ptr<NodeBaseInterface>;
};
struct NodeClockInterface {
    using SharedPtr = std::shared_ptr<NodeClockInterface>;
    Clock::SharedPtr get_clock() { return nullptr; }
};
}  // namespace node_interfaces
struct Node {
    using SharedPtr = std::shared_ptr<Node>;
    Node(const std::string &, const std::string &, const NodeOptions &) {}
    node_interfaces::NodeBaseInterface::SharedPtr get_node_base_interface() { return nullptr; }
};
struct Executor {
    using WeakPtr = std::weak_ptr<Executor>;
    void add_node(node_interfaces::NodeBaseInterface::SharedPtr) {}
};
}  // namespace rclcpp
