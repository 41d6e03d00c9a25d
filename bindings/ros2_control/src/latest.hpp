// One thread writes, another has the newest that is whole, and neither ever waits for the other.
#ifndef SINEW_ROS2_CONTROL__LATEST_HPP_
#define SINEW_ROS2_CONTROL__LATEST_HPP_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace sinew_ros2_control {

/// Three places: one the writer fills, one the reader looks at, and one between them that is exchanged with either.
template <class Value>
class Latest {
public:
    /// Where the writer writes. What is there is some earlier value.
    Value &place() noexcept { return places_[writers_]; }
    /// Hands over what was written; what was handed over before and not yet taken is gone.
    void hand_over() noexcept {
        writers_ = between_.exchange(static_cast<std::uint8_t>(writers_ | fresh), std::memory_order_acq_rel) & ~fresh;
    }
    /// The newest, if it is new to the reader. Good until the reader's next call.
    const Value *take() noexcept {
        if ((between_.load(std::memory_order_relaxed) & fresh) == 0) {
            return nullptr;
        }
        readers_ = between_.exchange(readers_, std::memory_order_acq_rel) & ~fresh;
        return &places_[readers_];
    }

private:
    static constexpr std::uint8_t fresh = 4;
    static_assert(std::atomic<std::uint8_t>::is_always_lock_free);

    std::array<Value, 3> places_{};
    std::uint8_t writers_ = 0, readers_ = 1;
    std::atomic<std::uint8_t> between_{2};
};

}  // namespace sinew_ros2_control

#endif  // SINEW_ROS2_CONTROL__LATEST_HPP_
