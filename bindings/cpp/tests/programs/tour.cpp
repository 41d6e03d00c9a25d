// Every call of sinew.hpp once, as it is meant and as it is not: `tour RIG`, a simulated rig with the channels left and right, whose sensors have
// proved themselves.
#include <sinew.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <thread>
#include <type_traits>

#include <csignal>
#include <sys/types.h>

using namespace std::chrono_literals;

// Handles are moved, never copied; so are those who own them.
static_assert(!std::is_copy_constructible_v<sinew::Client> && !std::is_copy_assignable_v<sinew::Client>);
static_assert(!std::is_copy_constructible_v<sinew::CycleStream> && !std::is_copy_constructible_v<sinew::FaultWatch>);
static_assert(std::is_nothrow_move_constructible_v<sinew::Client> && std::is_nothrow_move_assignable_v<sinew::Client>);
static_assert(std::is_nothrow_copy_constructible_v<sinew::Refused>);

#define CHECK(condition)                                                                                     \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            std::cerr << __FILE__ << ":" << __LINE__ << ": not so: " << #condition << "; last error: "       \
                      << sinew_last_error() << "\n";                                                         \
            std::exit(1);                                                                                    \
        }                                                                                                    \
    } while (false)

template <class Exception = sinew::Error, class Call>
Exception failing(SinewStatus status, const std::string &words, Call call) {
    try {
        call();
    } catch (const Exception &error) {
        const std::string what = error.what();
        if (error.status() != status || what.find(words) == std::string::npos) {
            std::cerr << "status " << error.status() << ": " << what << "\n";
            std::exit(1);
        }
        CHECK(!error.remedy().empty() && what.find(error.remedy()) != std::string::npos);
        return error;
    }
    std::cerr << "nothing was thrown that says: " << words << "\n";
    std::exit(1);
}

int main(int count, char **arguments) {
    CHECK(count == 2);
    const std::string rig = arguments[1];

    const auto now = sinew::Client::system_time(sinew_monotonic_ns());
    const auto since = std::chrono::system_clock::now().time_since_epoch();
    CHECK(std::chrono::duration_cast<std::chrono::seconds>(since - std::chrono::nanoseconds(now.ns)).count() == 0 && now.error_ns > 0);
    sinew::ClockMap camera;
    CHECK(sinew::ClockMap::usual().pairs == 128 && !camera.driver_at(0) && !camera.rate_ppm());
    CHECK(camera.bracket(1000000000, 5000, 1000040000).news == SINEW_CLOCK_NEWS_NONE);
    CHECK(camera.pair(2000000000, 1000005000, 40000).news == SINEW_CLOCK_NEWS_NONE);
    const auto when = camera.driver_at(500005000);
    CHECK(when && when->ns + when->error_ns >= 1500000000 && when->ns <= 1500000000 + when->error_ns && when->error_ns < 300000);
    CHECK(camera.other_at(when->ns) && std::abs(camera.rate_ppm()->first) <= 200.0);
    CHECK(camera.late(3000000000, 7).news == SINEW_CLOCK_NEWS_WENT_BACK);
    auto fast = sinew::ClockMap::usual();
    fast.max_rate_ppm = 500.0;
    const sinew::ClockMap slewed(fast), moved = std::move(camera);
    CHECK(!slewed.other_at(1));
    const auto rigs = sinew::Client::discover();
    CHECK(std::find(rigs.begin(), rigs.end(), rig) != rigs.end());
    auto first = sinew::Client::connect(rig);
    const auto client = std::move(first);
    failing(SINEW_ERROR_ARGUMENT, "the client is null", [&] { first.all_off(); });
    CHECK(client.info().rate_hz == 500.0 && rig == client.info().rig && client.channels().size() == 2);
    const auto left = client.channel("left"), right = client.channel("right");
    for (const sinew::ChannelInfo &info : client.channels()) {
        CHECK(std::abs(info.stroke_at_length(info.length_at_stroke(0.4)) - 0.4) < 1e-9);
    }
    CHECK(client.rig_text().value().find("[[channel]]") != std::string::npos);
    CHECK(client.is_alive() && client.health() == SINEW_DRIVER_HEALTH_RUNNING && client.age() < 60s);
    CHECK(client.wait(60s) && client.loop_stats().allocations == 0);

    std::size_t seen = 0;
    for (const SinewChannelState &state : client.latest()) {
        CHECK(state.mode == SINEW_MODE_OFF && state.resistance_ohm > 1.0);
        ++seen;
    }
    CHECK(seen == 2 && client.latest().size() == 2 && client.latest()[left].duty <= 0.02);
    bool is_out = false;
    try {
        client.latest()[2];
    } catch (const std::out_of_range &) {
        is_out = true;
    }
    CHECK(is_out);

    auto stream = client.stream();
    std::uint64_t cycles = 0, before = 0;
    for (const sinew::Cycle &cycle : stream.within(60s)) {
        CHECK(cycle.size() == 2 && (before == 0 || cycle.cycle == before + 1 + cycle.lost));
        before = cycle.cycle;
        if (++cycles == 100) {
            break;
        }
    }
    CHECK(cycles == 100 && stream.received() == 100);
    for (const sinew::Cycle &cycle : stream.within(0s)) {
        before = cycle.cycle;
    }

    auto faults = client.faults();
    CHECK(client.set_stroke("left", 0.3, 60s).hold_s == 60.0);
    CHECK(std::abs(client.latest()[left].target_m - client.channels()[left].length_at_stroke(0.3)) < 1e-9);
    client.set_length("left", client.channels()[left].length_at_stroke(0.2), 60s);
    client.set_duty("right", 0.1, 60s);
    client.set_force("right", 2.0, 60s);
    CHECK(client.set("left", SINEW_COMMAND_KIND_STROKE, 0.2).hold_s == client.channels()[left].lease_s);
    std::vector<sinew::Wanted> pose{sinew::Wanted::stroke(left, 0.1), sinew::Wanted::off(right)};
    client.set_many(pose, 60s);
    const auto taken = client.set_many({sinew::Wanted::stroke(left, 0.1), sinew::Wanted::duty(right, 0.05)}, 250ms);
    CHECK(taken.cycle > before && taken.hold_s == 0.25);
    // A stream of setpoints, which nobody waits for; its refusals come with a later call.
    auto setpoints = client.setpoints({250ms, 50ms, 0s});
    setpoints.send({sinew::Wanted::stroke(left, 0.1), sinew::Wanted::duty(right, 0.05)});
    while (setpoints.poll().taken < 1) {
        client.wait(1s);
    }
    setpoints.send({sinew::Wanted::stroke(left, 7.0)});
    bool is_refused = false;
    while (!is_refused) {
        try {
            setpoints.poll();
        } catch (const sinew::Refused &refused) {
            is_refused = true;
        }
    }
    // Leases that run out are no faults.
    while (client.latest()[left].mode != SINEW_MODE_LAPSED || client.latest()[right].mode != SINEW_MODE_LAPSED) {
        client.wait(60s);
    }
    // A driver that stands still for half a second is: of every channel.
    CHECK(::kill(static_cast<pid_t>(client.info().pid), SIGSTOP) == 0);
    std::this_thread::sleep_for(500ms);
    CHECK(::kill(static_cast<pid_t>(client.info().pid), SIGCONT) == 0);
    int stalled = 0;
    for (const sinew::FaultChange &change : faults.within(60s)) {
        CHECK(!change.before && change.after && change.after.code == SINEW_FAULT_CYCLE_OVERRUN);
        CHECK(std::string(change.after.flag()) == "cycle_overrun" && change.after.remedy()[0] != '\0');
        if (++stalled == 2) {
            break;
        }
    }
    // It may have been heated all along, and has to cool first.
    for (bool is_reset = false; !is_reset;) {
        try {
            client.reset("left");
            is_reset = true;
        } catch (const sinew::Refused &) {
            std::this_thread::sleep_for(50ms);
        }
    }
    client.off("right");
    client.all_off();

    // What is wrong, and what to do about it.
    failing(SINEW_ERROR_NOT_RUNNING, "no driver for rig \"nobodys-rig\"", [] { sinew::Client::connect("nobodys-rig", {0s, 1s}); });
    failing(SINEW_ERROR_UNKNOWN_CHANNEL, "did you mean \"left\"?", [&] { client.channel("lefd"); });
    failing(SINEW_ERROR_ARGUMENT, "a name has a zero byte in it", [&] { client.off(std::string("left\0x", 6)); });
    failing(SINEW_ERROR_ARGUMENT, "hold_s = NaN", [&] { client.set_duty("left", 0.1, sinew::Seconds(NAN)); });
    failing(SINEW_ERROR_CHANNELS, "1 to 64 channels", [&] { client.set_many({}, 1s); });
    const auto refused = failing<sinew::Refused>(SINEW_ERROR_REFUSED_TOGETHER, "nothing of the request", [&] {
        client.set_many({sinew::Wanted::stroke(left, 7.0), sinew::Wanted::duty(right, NAN)}, 1s);
    });
    CHECK(refused.refusals().size() == 2 && refused.refusals()[0].channel == "left");
    CHECK(refused.refusals()[0].outcome == SINEW_OUTCOME_OUT_OF_RANGE && refused.refusals()[0].high < 7.0);
    CHECK(refused.refusals()[1].outcome == SINEW_OUTCOME_NOT_FINITE && !refused.refusals()[1].remedy.empty());
    failing<sinew::Refused>(SINEW_ERROR_REFUSED, "stroke 7 is outside", [&] { client.set_stroke("left", 7.0); });

    client.stop();
    failing<sinew::DriverGone>(SINEW_ERROR_DRIVER_GONE, "has stopped", [&] {
        for (const sinew::Cycle &cycle : stream.within(sinew::for_ever)) {
            CHECK(cycle.cycle == before + 1 + cycle.lost);
            before = cycle.cycle;
        }
    });
    CHECK(!client.is_alive() && client.latest()[left].duty == 0.0);
    std::cout << "seen all\n";
}
