/*
 * sinew.hpp: the client of a robot program, for C++17. Nothing but a thin layer over sinew.h, whose rules for threads hold here too:
 * a Client may be shared between threads, what else there is is for one thread at a time.
 *
 * Handles close themselves, can be moved and not copied. Errors are exceptions whose text ends with what to do about it. Times are
 * std::chrono durations, 0.5s as well as 20ms. Units are SI; what is not known is NaN. docs/bindings.md is the guided tour.
 */
#ifndef SINEW_HPP
#define SINEW_HPP

#include <sinew.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace sinew {

/// Any std::chrono duration becomes one of these.
using Seconds = std::chrono::duration<double>;

/// Waits as long as it takes.
inline constexpr Seconds for_ever{std::numeric_limits<double>::infinity()};

/// A fault by its code, with its words; 0 is none.
struct Fault {
    std::uint32_t code = 0;

    explicit operator bool() const noexcept { return code != 0; }
    /// Its short name in reports.
    const char *flag() const noexcept { return sinew_fault_flag(code); }
    /// What happened, as the end of "the channel is off because …".
    const char *cause() const noexcept { return sinew_fault_cause(code); }
    /// What a person can do about it.
    const char *remedy() const noexcept { return sinew_fault_remedy(code); }
};

/// What the driver refused, and why. What a reason has not is 0 for codes and NaN for numbers.
struct Refusal {
    /// The channel's name; "all channels" for commands that name none.
    std::string channel;
    /// What was asked for: SINEW_COMMAND_KIND_…
    std::uint32_t kind;
    /// The value asked for, in SI units.
    double value;
    /// Why not: SINEW_OUTCOME_…
    std::uint32_t outcome;
    /// The fault in the way.
    Fault fault;
    /// Smallest and largest value or hold that would have been taken.
    double low, high;
    /// Too hot: after this long it has cooled, at the most, s.
    double longest_s;
    /// Too hot: what is believed of its temperature, and what that has to come down to, °C.
    double temperature_c, below_c;
    /// What is wrong, and what to do about it.
    std::string message, remedy;
};

/// A call that failed. what() ends with the remedy.
class Error : public std::runtime_error {
public:
    Error(SinewStatus status, const std::string &text, std::string remedy)
        : std::runtime_error(text), status_(status), remedy_(std::make_shared<const std::string>(std::move(remedy))) {}

    /// SINEW_ERROR_…
    SinewStatus status() const noexcept { return status_; }
    /// What to do about it; empty where the error says all there is.
    const std::string &remedy() const noexcept { return *remedy_; }

private:
    SinewStatus status_;
    // shared: an exception has to be copied without throwing
    std::shared_ptr<const std::string> remedy_;
};

/// The driver refused a command, or all of a request for several channels.
class Refused : public Error {
public:
    Refused(SinewStatus status, const std::string &text, std::string remedy, std::vector<Refusal> refusals)
        : Error(status, text, std::move(remedy)),
          refusals_(std::make_shared<const std::vector<Refusal>>(std::move(refusals))) {}

    /// Each with its own reason.
    const std::vector<Refusal> &refusals() const noexcept { return *refusals_; }

private:
    std::shared_ptr<const std::vector<Refusal>> refusals_;
};

/// The driver is gone: connect again for the next one.
class DriverGone : public Error {
public:
    using Error::Error;
};

namespace detail {

[[noreturn]] inline void raise(SinewStatus status) {
    const std::string text = sinew_last_error(), remedy = sinew_last_remedy();
    if (status == SINEW_ERROR_DRIVER_GONE) {
        throw DriverGone(status, text, remedy);
    }
    if (status == SINEW_ERROR_REFUSED || status == SINEW_ERROR_REFUSED_TOGETHER) {
        std::vector<Refusal> refusals;
        SinewRefusal told;
        for (std::size_t i = 0; i < sinew_refusals() && sinew_refusal(i, &told) == SINEW_OK; ++i) {
            refusals.push_back({told.channel, told.kind, told.value, told.outcome, Fault{told.fault}, told.low, told.high,
                                told.longest_s, told.temperature_c, told.below_c, told.message, told.remedy});
        }
        throw Refused(status, text, remedy, std::move(refusals));
    }
    throw Error(status, text, remedy);
}

/// Whether it is done; false where nothing came in time.
inline bool done(SinewStatus status) {
    if (status < 0) {
        raise(status);
    }
    return status == SINEW_OK;
}

/// The text as C sees it, which must not end before its end.
inline const char *whole(const std::string &text) {
    if (text.find('\0') != std::string::npos) {
        throw Error(SINEW_ERROR_ARGUMENT, "a name has a zero byte in it; write it as it stands in the rig file",
                    "write it as it stands in the rig file");
    }
    return text.c_str();
}

template <class Handle, SinewStatus (*close)(Handle *)>
struct Close {
    void operator()(Handle *handle) const noexcept { close(handle); }
};

template <class Handle, SinewStatus (*close)(Handle *)>
using Owned = std::unique_ptr<Handle, Close<Handle, close>>;

/// What comes from a source, one after the other, until nothing comes for so long. An input range: to be gone through once.
template <class Source>
class Arrivals {
public:
    using Value = typename Source::Value;

    class Iterator {
    public:
        using iterator_category = std::input_iterator_tag;
        using value_type = Value;
        using difference_type = std::ptrdiff_t;
        using pointer = const Value *;
        using reference = const Value &;

        Iterator() = default;
        explicit Iterator(Arrivals *arrivals) : arrivals_(arrivals) { ++*this; }

        reference operator*() const { return arrivals_->value_; }
        pointer operator->() const { return &arrivals_->value_; }
        Iterator &operator++() {
            if (!arrivals_->source_->next(arrivals_->value_, arrivals_->timeout_)) {
                arrivals_ = nullptr;
            }
            return *this;
        }
        void operator++(int) { ++*this; }
        friend bool operator==(const Iterator &a, const Iterator &b) { return a.arrivals_ == b.arrivals_; }
        friend bool operator!=(const Iterator &a, const Iterator &b) { return !(a == b); }

    private:
        Arrivals *arrivals_ = nullptr;
    };

    Arrivals(Source &source, Seconds timeout) : source_(&source), timeout_(timeout) {}
    Iterator begin() { return Iterator(this); }
    Iterator end() { return Iterator(); }

private:
    Source *source_;
    Seconds timeout_;
    Value value_{};
};

/// A cycle that is a range of its channels, in the rig's order.
template <class Base>
struct Channels : Base {
    using value_type = SinewChannelState;
    using const_iterator = const SinewChannelState *;

    Channels() : Base() {}

    std::size_t size() const noexcept { return this->channels; }
    bool empty() const noexcept { return size() == 0; }
    const SinewChannelState *begin() const noexcept { return this->channel; }
    const SinewChannelState *end() const noexcept { return this->channel + size(); }
    /// The channel with this number; std::out_of_range where there is none.
    const SinewChannelState &operator[](std::size_t number) const {
        if (number >= size()) {
            throw std::out_of_range("there is no channel " + std::to_string(number) + " among " + std::to_string(size()));
        }
        return this->channel[number];
    }
};

}  // namespace detail

/// The latest state: one whole cycle. `for (const SinewChannelState &state : client.latest())`.
using Snapshot = detail::Channels<SinewSnapshot>;
/// One cycle of a stream.
using Cycle = detail::Channels<SinewCycle>;

/// What does not change about a channel while the driver runs.
struct ChannelInfo : SinewChannelInfo {
    /// Length at a stroke, m: 0 = cold, 1 = hot.
    double length_at_stroke(double stroke) const noexcept {
        return cold_length_m + stroke * (hot_length_m - cold_length_m);
    }
    /// Stroke at a length: the inverse; NaN for a channel without stroke.
    double stroke_at_length(double length_m) const noexcept {
        const double stroke_m = cold_length_m - hot_length_m;
        return stroke_m > 0.0 ? (cold_length_m - length_m) / stroke_m : std::numeric_limits<double>::quiet_NaN();
    }
};

/// One setpoint of several.
struct Wanted : SinewWanted {
    Wanted(std::uint32_t number, SinewCommandKind what, double how_much) noexcept
        : SinewWanted{number, static_cast<std::uint32_t>(what), how_much} {}

    static Wanted length(std::uint32_t channel, double length_m) { return {channel, SINEW_COMMAND_KIND_LENGTH, length_m}; }
    static Wanted stroke(std::uint32_t channel, double stroke) { return {channel, SINEW_COMMAND_KIND_STROKE, stroke}; }
    static Wanted duty(std::uint32_t channel, double duty) { return {channel, SINEW_COMMAND_KIND_DUTY, duty}; }
    static Wanted force(std::uint32_t channel, double force_n) { return {channel, SINEW_COMMAND_KIND_FORCE, force_n}; }
    static Wanted off(std::uint32_t channel) { return {channel, SINEW_COMMAND_KIND_OFF, 0.0}; }
};
static_assert(sizeof(Wanted) == sizeof(SinewWanted), "a row of one is a row of the other");

/// The cycle from which on a command is in force, and the lease as granted.
using Taken = SinewTaken;

/// A time on another clock.
struct Mapped {
    /// The time, ns.
    std::int64_t ns;
    /// What it is off by at the most, ns.
    std::uint64_t error_ns;
};

/// A time of the driver's, CLOCK_MONOTONIC.
struct Stamp {
    /// The time, ns.
    std::uint64_t ns;
    /// What it is off by at the most, ns.
    std::uint64_t error_ns;
};

/// The clock of another device beside the driver's, a data acquisition's or a camera's, learnt from pairs of times. Needs no driver. For one
/// thread at a time.
class ClockMap {
public:
    /// What is usual of another clock, to be changed where more is known.
    static SinewClockRules usual() {
        SinewClockRules rules;
        detail::done(sinew_clock_rules(&rules));
        return rules;
    }

    explicit ClockMap(const SinewClockRules &rules = usual()) : handle_(opened(rules)) {}

    /// Adds a time the device showed between two of the driver's: before it was asked and after its answer came.
    SinewClockChange bracket(std::uint64_t before_ns, std::int64_t other_ns, std::uint64_t after_ns) {
        SinewClockChange change;
        detail::done(sinew_clock_map_bracket(handle_.get(), before_ns, other_ns, after_ns, &change));
        return change;
    }
    /// Adds two times of one moment, of which the driver's is off by `error_ns` at the most.
    SinewClockChange pair(std::uint64_t driver_ns, std::int64_t other_ns, std::uint64_t error_ns) {
        SinewClockChange change;
        detail::done(sinew_clock_map_pair(handle_.get(), driver_ns, other_ns, error_ns, &change));
        return change;
    }
    /// Adds a stamp of the device and when it was received, never earlier, in the order in which they were.
    SinewClockChange late(std::uint64_t received_ns, std::int64_t other_ns) {
        SinewClockChange change;
        detail::done(sinew_clock_map_late(handle_.get(), received_ns, other_ns, &change));
        return change;
    }

    /// The driver's time of a time of the device; nothing where it is not known.
    std::optional<Stamp> driver_at(std::int64_t other_ns) const {
        Stamp at{};
        const bool known = detail::done(sinew_clock_map_driver_at(handle_.get(), other_ns, &at.ns, &at.error_ns));
        return known ? std::optional(at) : std::nullopt;
    }
    /// The device's time of a driver's stamp; nothing where it is not known.
    std::optional<Mapped> other_at(std::uint64_t driver_ns) const {
        Mapped at{};
        const bool known = detail::done(sinew_clock_map_other_at(handle_.get(), driver_ns, &at.ns, &at.error_ns));
        return known ? std::optional(at) : std::nullopt;
    }
    /// What the device's clock runs fast by, and what that is off by at the most, ppm; nothing where it is not known.
    std::optional<std::pair<double, double>> rate_ppm() const {
        std::pair<double, double> rate;
        const bool known = detail::done(sinew_clock_map_rate(handle_.get(), &rate.first, &rate.second));
        return known ? std::optional(rate) : std::nullopt;
    }

private:
    static SinewClockMap *opened(const SinewClockRules &rules) {
        SinewClockMap *handle = nullptr;
        detail::done(sinew_clock_map(&rules, &handle));
        return handle;
    }

    detail::Owned<SinewClockMap, sinew_clock_map_close> handle_;
};

/// One change of a channel's fault.
struct FaultChange {
    /// Number of the channel.
    std::uint32_t channel;
    /// The fault before, and from now on.
    Fault before, after;
    /// The cycle it was seen in.
    std::uint64_t cycle;
    /// When, CLOCK_MONOTONIC, ns.
    std::uint64_t monotonic_ns;
};

/// Every cycle from the moment it was opened, in order. For one thread at a time.
class CycleStream {
public:
    using Value = Cycle;

    /// The next cycle, waiting for it up to so long; false when none came.
    bool next(Cycle &cycle, Seconds timeout) {
        return detail::done(sinew_stream_next(handle_.get(), timeout.count(), &cycle));
    }
    /// The cycles as they come, until none comes for so long: 0s is what is there already.
    detail::Arrivals<CycleStream> within(Seconds timeout) { return {*this, timeout}; }

    /// Cycles received so far.
    std::uint64_t received() const { return counts().first; }
    /// Cycles lost since the first one received: exactly those the driver ran and this reader did not get.
    std::uint64_t lost() const { return counts().second; }

private:
    friend class Client;
    explicit CycleStream(SinewCycleStream *handle) : handle_(handle) {}

    std::pair<std::uint64_t, std::uint64_t> counts() const {
        std::pair<std::uint64_t, std::uint64_t> counts;
        detail::done(sinew_stream_counts(handle_.get(), &counts.first, &counts.second));
        return counts;
    }

    detail::Owned<SinewCycleStream, sinew_stream_close> handle_;
};

/// Watches for faults. For one thread at a time.
class FaultWatch {
public:
    using Value = FaultChange;

    /// The next change, waiting for it up to so long; false when none came.
    bool next(FaultChange &change, Seconds timeout) {
        SinewFaultChange told;
        if (!detail::done(sinew_faults_next(handle_.get(), timeout.count(), &told))) {
            return false;
        }
        change = {told.channel, Fault{told.before}, Fault{told.after}, told.cycle, told.monotonic_ns};
        return true;
    }
    /// The changes as they come, until none comes for so long: 0s is what is there already.
    detail::Arrivals<FaultWatch> within(Seconds timeout) { return {*this, timeout}; }

private:
    friend class Client;
    explicit FaultWatch(SinewFaultWatch *handle) : handle_(handle) {}

    detail::Owned<SinewFaultWatch, sinew_faults_close> handle_;
};

/// How the setpoints of a stream are meant.
struct SetpointOptions {
    /// How long each holds unless the next one comes; 0s: the shortest of its channels' defaults.
    Seconds hold{0.5};
    /// The time in which each is approached in a straight line from what was wanted before; 0s: it holds at once.
    Seconds over{0.0};
    /// A message the driver gets to later than this is not carried out; 0s: whenever it comes.
    Seconds within{0.1};
};

/// Setpoints that nobody waits for: the newest wins. For one thread at a time.
class Setpoints {
public:
    /// Sends a message on its way, for each channel once, all or none. Refused is about an earlier one; this one is on its way all the same.
    SinewSetpointProgress send(const std::vector<Wanted> &wanted) { return send(wanted.data(), wanted.size()); }
    /// The same: `setpoints.send({Wanted::stroke(left, 0.4), Wanted::off(right)})`.
    SinewSetpointProgress send(std::initializer_list<Wanted> wanted) { return send(wanted.begin(), wanted.size()); }
    /// Looks for answers; what became of the messages so far.
    SinewSetpointProgress poll() {
        SinewSetpointProgress progress;
        detail::done(sinew_setpoints_poll(handle_.get(), &progress));
        return progress;
    }

private:
    friend class Client;
    explicit Setpoints(SinewSetpoints *handle) : handle_(handle) {}

    SinewSetpointProgress send(const Wanted *wanted, std::size_t count) {
        SinewSetpointProgress progress;
        detail::done(sinew_setpoints_send(handle_.get(), wanted, count, &progress));
        return progress;
    }

    detail::Owned<SinewSetpoints, sinew_setpoints_close> handle_;
};

/// How long a client is willing to wait.
struct ClientOptions {
    /// For a driver that is just starting, when connecting.
    Seconds connect{2.0};
    /// For the answer to a command.
    Seconds answer{1.0};
};

/// A connection to a running driver. Threads may share it.
class Client {
public:
    /// Connects to the driver of this rig.
    static Client connect(const std::string &rig, const ClientOptions &options = {}) {
        SinewClient *handle = nullptr;
        detail::done(sinew_connect_with(detail::whole(rig), options.connect.count(), options.answer.count(), &handle));
        return Client(handle);
    }

    /// Names of the rigs a driver is running for, sorted.
    static std::vector<std::string> discover() {
        std::vector<Name> names;
        std::size_t found = 0;
        do {
            names.resize(found);
            detail::done(sinew_discover(names.empty() ? nullptr : &names.front().text, names.size(), &found));
        } while (found > names.size());
        std::vector<std::string> rigs;
        for (std::size_t i = 0; i < found; ++i) {
            rigs.emplace_back(names[i].text);
        }
        return rigs;
    }

    /// The system's time of a driver's stamp, ns since 1970 (UTC), and what that is off by at the most, ns: as the clock is set now.
    static Mapped system_time(std::uint64_t monotonic_ns) {
        Mapped at{};
        detail::done(sinew_system_time(monotonic_ns, &at.ns, &at.error_ns));
        return at;
    }

    /// What does not change while the driver runs.
    SinewInfo info() const {
        SinewInfo info;
        detail::done(sinew_info(get(), &info));
        return info;
    }
    /// The channels, in the rig's order.
    const std::vector<ChannelInfo> &channels() const noexcept { return channels_; }
    /// The number of a channel; a mistyped name is told which was meant.
    std::uint32_t channel(const std::string &name) const {
        std::uint32_t number = 0;
        detail::done(sinew_channel(get(), detail::whole(name), &number));
        return number;
    }
    /// The text of the rig file as the driver read it, if it left one.
    std::optional<std::string> rig_text() const {
        std::string text;
        std::size_t needed = 0;
        do {
            text.resize(needed);
            detail::done(sinew_rig_text(get(), text.data(), text.size(), &needed));
        } while (needed > text.size());
        if (needed == 0) {
            return std::nullopt;
        }
        text.resize(needed - 1);
        return text;
    }

    /// The latest state: one whole cycle, never parts of two. Does not wait.
    Snapshot latest() const {
        Snapshot snapshot;
        latest(snapshot);
        return snapshot;
    }
    /// The same, into a place of one's own.
    void latest(Snapshot &snapshot) const { detail::done(sinew_latest(get(), &snapshot)); }
    /// How the driver is: SINEW_DRIVER_HEALTH_…
    SinewDriverHealth health() const {
        SinewDriverHealth health{};
        detail::done(sinew_health(get(), &health, nullptr));
        return health;
    }
    /// Whether the driver's process lives and its loop runs.
    bool is_alive() const {
        const auto now = health();
        return now == SINEW_DRIVER_HEALTH_STARTING || now == SINEW_DRIVER_HEALTH_RUNNING;
    }
    /// Age of the latest state.
    Seconds age() const {
        double age_s = 0.0;
        detail::done(sinew_health(get(), nullptr, &age_s));
        return Seconds(age_s);
    }
    /// How the loop does.
    SinewLoopStats loop_stats() const {
        SinewLoopStats stats;
        detail::done(sinew_loop_stats(get(), &stats));
        return stats;
    }
    /// Sleeps until the driver has something new; false when that took longer.
    bool wait(Seconds timeout) const { return detail::done(sinew_wait(get(), timeout.count())); }
    /// Every cycle from now on.
    CycleStream stream() const {
        SinewCycleStream *handle = nullptr;
        detail::done(sinew_stream(get(), &handle));
        return CycleStream(handle);
    }
    /// Fault changes from now on; the first reported are the faults that are there already.
    FaultWatch faults() const {
        SinewFaultWatch *handle = nullptr;
        detail::done(sinew_faults(get(), &handle));
        return FaultWatch(handle);
    }

    /// Holds a wire length, m, for so long unless renewed; 0s takes the channel's own default.
    Taken set_length(const std::string &channel, double length_m, Seconds hold = {}) const {
        return set(channel, SINEW_COMMAND_KIND_LENGTH, length_m, hold);
    }
    /// Holds a share of the stroke, 0 (cold) to 1 (hot).
    Taken set_stroke(const std::string &channel, double stroke, Seconds hold = {}) const {
        return set(channel, SINEW_COMMAND_KIND_STROKE, stroke, hold);
    }
    /// Gives a duty, 0 to 1, without control.
    Taken set_duty(const std::string &channel, double duty, Seconds hold = {}) const {
        return set(channel, SINEW_COMMAND_KIND_DUTY, duty, hold);
    }
    /// Holds a tension, N.
    Taken set_force(const std::string &channel, double force_n, Seconds hold = {}) const {
        return set(channel, SINEW_COMMAND_KIND_FORCE, force_n, hold);
    }
    /// Any command to a channel by name.
    Taken set(const std::string &channel, SinewCommandKind kind, double value, Seconds hold = {}) const {
        Taken taken{};
        const auto code = static_cast<std::uint32_t>(kind);
        detail::done(sinew_set(get(), detail::whole(channel), code, value, hold.count(), &taken));
        return taken;
    }
    /// Setpoints for several channels, all in force from the same cycle on, or none (Refused, with each channel's own reason).
    Taken set_many(const std::vector<Wanted> &wanted, Seconds hold = {}) const {
        return set_many(wanted.data(), wanted.size(), hold);
    }
    /// The same: `client.set_many({Wanted::stroke(left, 0.4), Wanted::off(right)}, 200ms)`.
    Taken set_many(std::initializer_list<Wanted> wanted, Seconds hold = {}) const {
        return set_many(wanted.begin(), wanted.size(), hold);
    }
    /// A stream of setpoints, for a planner that does not wait.
    Setpoints setpoints(const SetpointOptions &options = {}) const {
        SinewSetpoints *handle = nullptr;
        const auto &[hold, over, within] = options;
        detail::done(sinew_setpoints(get(), hold.count(), over.count(), within.count(), &handle));
        return Setpoints(handle);
    }
    /// Has these channels to itself (priority 0 to 9) until it lets go of them or `hold` has passed without a word of it; off and stop
    /// stay open to everybody.
    Taken claim(const std::vector<std::uint32_t> &channels, std::uint32_t priority, Seconds hold = {}) const {
        Taken taken{};
        detail::done(sinew_claim(get(), channels.data(), channels.size(), priority, hold.count(), &taken));
        return taken;
    }
    /// Lets go of these channels.
    void release(const std::vector<std::uint32_t> &channels) const {
        detail::done(sinew_release(get(), channels.data(), channels.size()));
    }
    /// Only the sensing pulse from now on.
    void off(const std::string &channel) const { detail::done(sinew_off(get(), detail::whole(channel))); }
    /// Only the sensing pulse on every channel from now on.
    void all_off() const { detail::done(sinew_all_off(get())); }
    /// Clears a latched fault whose cause has gone.
    void reset(const std::string &channel) const { detail::done(sinew_reset(get(), detail::whole(channel))); }
    /// Stops the driver: outputs to zero, then it ends.
    void stop() const { detail::done(sinew_stop(get())); }

    /// The handle, for calls of sinew.h; it stays this client's.
    const SinewClient *get() const noexcept { return handle_.get(); }

private:
    struct Name {
        char text[SINEW_NAME_SIZE];
    };

    explicit Client(SinewClient *handle) : handle_(handle) {
        std::size_t found = 0;
        SinewChannelInfo told[SINEW_MAX_CHANNELS];
        detail::done(sinew_channels(get(), told, SINEW_MAX_CHANNELS, &found));
        for (std::size_t i = 0; i < found; ++i) {
            channels_.push_back(ChannelInfo{told[i]});
        }
    }

    Taken set_many(const Wanted *wanted, std::size_t count, Seconds hold) const {
        Taken taken{};
        detail::done(sinew_set_many(get(), wanted, count, hold.count(), &taken));
        return taken;
    }

    detail::Owned<SinewClient, sinew_close> handle_;
    std::vector<ChannelInfo> channels_;
};

}  // namespace sinew

#endif
