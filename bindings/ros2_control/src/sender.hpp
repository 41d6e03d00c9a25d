// The thread that speaks with the driver while the component is active, so that write() does not: it hands over the newest setpoints, renews
// the claim, looks after the driver and says what is refused.
#ifndef SINEW_ROS2_CONTROL__SENDER_HPP_
#define SINEW_ROS2_CONTROL__SENDER_HPP_

#include <semaphore.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <sinew.hpp>

#include "latest.hpp"
#include "rclcpp/logger.hpp"

namespace sinew_ros2_control {

/// What is wanted, as write() leaves it.
struct Message {
    /// From 1 on.
    std::uint64_t number = 0;
    std::size_t count = 0;
    std::array<SinewWanted, SINEW_MAX_CHANNELS> wanted{};

    void add(std::uint32_t channel, SinewCommandKind kind, double value) noexcept {
        wanted[count++] = {channel, static_cast<std::uint32_t>(kind), value};
    }
};

/// What is claimed.
struct Claim {
    std::vector<std::uint32_t> channels;
    std::uint32_t priority;
    sinew::Seconds hold;
};

class Sender {
public:
    /// Starts the thread. `client` has to be there longer.
    Sender(const sinew::Client &client, const sinew::SetpointOptions &options, std::optional<Claim> claim, int thread_priority,
           const rclcpp::Logger &logger);
    /// Ends it. What is in force stays so until its lease ends.
    ~Sender();
    Sender(const Sender &) = delete;
    Sender &operator=(const Sender &) = delete;

    // For the thread of read() and write(): none of these waits or allocates.

    /// An empty message to be filled.
    Message &place() noexcept {
        Message &message = messages_.place();
        message.number = ++written_;
        message.count = 0;
        return message;
    }
    /// Hands it over. An empty one says that the controllers run, and nothing more.
    void hand_over() noexcept {
        messages_.hand_over();
        // never waits; wakes the thread if it sleeps
        sem_post(&woken_);
    }
    /// The last message the driver has been given.
    std::uint64_t sent() const noexcept { return sent_.load(std::memory_order_acquire); }
    /// Says once in a while that this joint was asked for more than it has. `name` has to stay.
    void beyond_reach(const char *name) noexcept { beyond_reach_.store(name, std::memory_order_relaxed); }
    /// Whether the driver is gone or refuses; why() is good from then on.
    bool failed() const noexcept { return failed_.load(std::memory_order_acquire); }
    const std::string &why() const noexcept { return why_; }

private:
    void run(int thread_priority);
    void step();
    void refused(const sinew::Refused &refused);
    void fail(const std::string &why);

    const sinew::Client &client_;
    sinew::Setpoints setpoints_;
    const std::optional<Claim> claim_;
    const rclcpp::Logger logger_;

    Latest<Message> messages_;
    std::uint64_t written_ = 0;
    sem_t woken_;
    std::atomic<bool> ends_{false}, failed_{false};
    std::atomic<std::uint64_t> sent_{0};
    std::atomic<const char *> beyond_reach_{nullptr};
    std::string why_;

    // The thread's own.
    using Clock = std::chrono::steady_clock;
    std::vector<sinew::Wanted> wanted_;
    Clock::time_point last_message_, last_claim_, last_look_, last_word_;
    std::string last_refusal_;

    std::thread thread_;
};

}  // namespace sinew_ros2_control

#endif  // SINEW_ROS2_CONTROL__SENDER_HPP_
