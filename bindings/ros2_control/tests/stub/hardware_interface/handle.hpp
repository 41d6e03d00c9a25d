// Stub for tests alone: see README.md. A handle keeps its value and a lock, which nobody waits for who does not ask to.
#ifndef HARDWARE_INTERFACE__HANDLE_HPP_
#define HARDWARE_INTERFACE__HANDLE_HPP_
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <stdexcept>
#include <string>

#include "hardware_interface/hardware_info.hpp"

namespace hardware_interface {
class Handle {
public:
    explicit Handle(const InterfaceDescription &description) : name_(description.get_name()) {
        const InterfaceInfo &info = description.interface_info;
        if (info.data_type != "double") {
            throw std::runtime_error("the stub has no interfaces of type " + info.data_type);
        }
        if (!info.initial_value.empty()) {
            value_ = std::stod(info.initial_value);
        }
    }
    virtual ~Handle() = default;

    const std::string &get_name() const { return name_; }

    template <typename T = double>
    [[nodiscard]] std::optional<T> get_optional() const {
        T value;
        return get_value(value, false) ? std::optional<T>(value) : std::nullopt;
    }
    template <typename T>
    [[nodiscard]] bool get_value(T &value, bool wait_for_lock) const {
        std::shared_lock<std::shared_mutex> lock(mutex_, std::defer_lock);
        if (wait_for_lock) {
            lock.lock();
        } else if (!lock.try_lock()) {
            return false;
        }
        value = value_;
        return true;
    }
    template <typename T>
    [[nodiscard]] bool set_value(const T &value, bool wait_for_lock) {
        std::unique_lock<std::shared_mutex> lock(mutex_, std::defer_lock);
        if (wait_for_lock) {
            lock.lock();
        } else if (!lock.try_lock()) {
            return false;
        }
        value_ = value;
        return true;
    }
    template <typename T>
    [[nodiscard]] bool set_value(const T &value) {
        return set_value(value, false);
    }
    std::shared_mutex &get_mutex() const { return mutex_; }

private:
    std::string name_;
    double value_ = std::numeric_limits<double>::quiet_NaN();
    mutable std::shared_mutex mutex_;
};

class StateInterface : public Handle {
public:
    using Handle::Handle;
    using SharedPtr = std::shared_ptr<StateInterface>;
    using ConstSharedPtr = std::shared_ptr<const StateInterface>;
};

class CommandInterface : public Handle {
public:
    using Handle::Handle;
    using SharedPtr = std::shared_ptr<CommandInterface>;
};
}  // namespace hardware_interface
#endif  // HARDWARE_INTERFACE__HANDLE_HPP_
