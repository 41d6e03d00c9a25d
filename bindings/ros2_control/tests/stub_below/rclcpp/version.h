// Stub for tests alone: see README.md of this folder.
#pragma once
#define RCLCPP_VERSION_MAJOR 28
#define RCLCPP_VERSION_GTE(major, minor, patch) (RCLCPP_VERSION_MAJOR >= (major))
