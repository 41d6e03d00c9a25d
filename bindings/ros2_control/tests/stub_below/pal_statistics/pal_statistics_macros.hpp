// Stub for tests alone: see README.md of this folder.
#pragma once
#include <cxxabi.h>

#include <cstdlib>
#include <functional>
#include <string>

#include "rclcpp/rclcpp.hpp"

namespace pal_statistics {
using IdType = int;
struct RegistrationsRAII {
    void enableAll() {}
    void disableAll() {}
};
struct StatisticsRegistry {
    template <class... Arguments>
    IdType registerVariable(Arguments &&...) {
        return 0;
    }
    template <class... Arguments>
    IdType registerFunction(Arguments &&...) {
        return 0;
    }
};
template <class T>
IdType customRegister(StatisticsRegistry &, const std::string &, const T *, RegistrationsRAII *, bool) {
    return 0;
}
}  // namespace pal_statistics

#define REGISTER_ENTITY(...)
#define UNREGISTER_ENTITY(...)
