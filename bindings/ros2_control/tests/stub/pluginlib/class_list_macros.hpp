// Stub for tests alone: see README.md. A library says what it has by one function, where pluginlib has a register of all.
#ifndef PLUGINLIB__CLASS_LIST_MACROS_HPP_
#define PLUGINLIB__CLASS_LIST_MACROS_HPP_
#include <string_view>

#define PLUGINLIB_EXPORT_CLASS(Class, Base)                                         \
    extern "C" Base *pluginlib_stub_create(const char *type) {                      \
        return std::string_view(type) == #Class ? static_cast<Base *>(new Class()) : nullptr; \
    }
#endif  // PLUGINLIB__CLASS_LIST_MACROS_HPP_
