// Stub for tests alone: see README.md of this folder.
#pragma once
#include "rclcpp/rclcpp.hpp"
