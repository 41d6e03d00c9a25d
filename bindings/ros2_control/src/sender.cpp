#include "sender.hpp"

#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <cstring>

#include "rclcpp/logging.hpp"

using namespace std::chrono_literals;

namespace sinew_ros2_control {
namespace {

/// How often the thread looks around without being woken.
constexpr auto round_s = 20ms;
/// How often the driver is looked after.
constexpr auto look_s = 100ms;
/// How often the same warning is said.
constexpr auto word_s = 5s;

/// Sleeps until it is woken, at the most for a round; takes all that has woken it.
void sleep(sem_t &woken) {
    timespec until{};
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += std::chrono::nanoseconds(round_s).count();
    if (until.tv_nsec >= 1'000'000'000) {
        until.tv_nsec -= 1'000'000'000;
        ++until.tv_sec;
    }
    if (sem_clockwait(&woken, CLOCK_MONOTONIC, &until) == 0) {
        while (sem_trywait(&woken) == 0) {
        }
    }
}

/// Whether a refusal is no more than a moment's.
bool passes(const sinew::Refusal &refusal) {
    switch (refusal.outcome) {
        case SINEW_OUTCOME_BUSY:
        case SINEW_OUTCOME_WAITING:
        case SINEW_OUTCOME_OVERTAKEN:
        case SINEW_OUTCOME_LATE:
        // because of another one in its request
        case SINEW_OUTCOME_WITH_OTHERS:
        // the state of the channel says so, too: what comes of a fault is decided there
        case SINEW_OUTCOME_FAULTED:
            return true;
        default:
            return false;
    }
}

}  // namespace

Sender::Sender(const sinew::Client &client, const sinew::SetpointOptions &options, std::optional<Claim> claim, int thread_priority,
               const rclcpp::Logger &logger)
    : client_(client), setpoints_(client.setpoints(options)), claim_(std::move(claim)), logger_(logger) {
    wanted_.reserve(SINEW_MAX_CHANNELS);
    sem_init(&woken_, 0, 0);
    last_message_ = last_claim_ = last_look_ = Clock::now();
    thread_ = std::thread([this, thread_priority] { run(thread_priority); });
}

Sender::~Sender() {
    ends_ = true;
    sem_post(&woken_);
    thread_.join();
    sem_destroy(&woken_);
}

void Sender::run(int thread_priority) {
    pthread_setname_np(pthread_self(), "sinew-sender");
    if (thread_priority > 0) {
        sched_param parameter{};
        parameter.sched_priority = thread_priority;
        if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter)) {
            RCLCPP_WARN(logger_, "thread_priority = %d was not granted: %s; raise rtprio in limits.conf(5), or leave it out",
                        thread_priority, std::strerror(error));
        }
    }
    while (!ends_ && !failed_) {
        sleep(woken_);
        try {
            step();
        } catch (const sinew::Refused &error) {
            refused(error);
        } catch (const std::exception &error) {
            fail(error.what());
        }
    }
}

void Sender::step() {
    const auto now = Clock::now();
    if (const Message *const message = messages_.take()) {
        last_message_ = now;
        wanted_.clear();
        for (std::size_t i = 0; i < message->count; ++i) {
            const SinewWanted &wanted = message->wanted[i];
            wanted_.emplace_back(wanted.channel, static_cast<SinewCommandKind>(wanted.kind), wanted.value);
        }
        if (!wanted_.empty()) {
            const std::uint64_t number = message->number;
            try {
                setpoints_.send(wanted_);
            } catch (const sinew::Refused &error) {
                // about an earlier message: this one is on its way
                sent_.store(number, std::memory_order_release);
                throw;
            }
            sent_.store(number, std::memory_order_release);
        }
    } else {
        setpoints_.poll();
    }
    // A claim ends with the controllers: one that is renewed for a manager that hangs would keep others out.
    if (claim_ && now - last_claim_ > claim_->hold / 3.0 && now - last_message_ < claim_->hold) {
        last_claim_ = now;
        client_.claim(claim_->channels, claim_->priority, claim_->hold);
    }
    if (now - last_look_ > look_s) {
        last_look_ = now;
        if (!client_.is_alive()) {
            fail("the driver has ended or its loop stands still; see its log, then start it again with `sinew run`");
        }
    }
    const char *const beyond = beyond_reach_.exchange(nullptr, std::memory_order_relaxed);
    if (beyond != nullptr && now - last_word_ > word_s) {
        last_word_ = now;
        RCLCPP_WARN(logger_, "%s is asked for more than its wire can do and held at the end of its way; "
                    "give it that limit in the URDF, or check radius_mm, zero_mm and direction", beyond);
    }
}

void Sender::refused(const sinew::Refused &refused) {
    const auto &refusals = refused.refusals();
    if (!std::all_of(refusals.begin(), refusals.end(), passes)) {
        fail(refused.what());
    } else if (last_refusal_ != refused.what()) {
        last_refusal_ = refused.what();
        RCLCPP_WARN(logger_, "not carried out: %s", refused.what());
    }
}

void Sender::fail(const std::string &why) {
    why_ = why;
    failed_.store(true, std::memory_order_release);
}

}  // namespace sinew_ros2_control
