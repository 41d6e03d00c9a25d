// A robot program in C++: walks the built-in hexapod with a tripod gait, as examples/gait.rs does.
//
//     sinew run                                                                    in one terminal: the driver, on simulated wires
//     c++ -std=c++17 gait.cpp $(pkg-config --cflags --libs sinew) -o gait          in another
//     ./gait            or  ./gait RIG 30                                          another rig of the same legs, for 30 s
//
// Six legs of three wires. The legs of a tripod move together, the two tripods in turn: while one steps, the other carries. A wire contracts within
// a second when heated but takes two or three to cool and stretch again, so what needs cooling gets more time.

#include <sinew.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <thread>

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

namespace {

// Half a gait cycle: one tripod's step.
constexpr double step_s = 4.0;
// How often setpoints are sent, all of them in one request.
constexpr auto tick = 20ms;
// How long each holds: if this program hangs or dies, the wires go off this much later.
constexpr auto lease = 500ms;

// Ctrl-C and SIGTERM only raise a flag: this program ends where it knows what state it is in.
volatile std::sig_atomic_t interrupted = 0;

struct Leg {
    // Coxa, femur, tibia: their numbers in the driver.
    std::array<std::uint32_t, 3> wires;
    int tripod;
};

std::vector<Leg> find_legs(const sinew::Client &client) {
    std::vector<Leg> legs;
    int row = 0;
    for (const std::string place : {"front", "middle", "rear"}) {
        int column = 0;
        for (const std::string side : {"left", "right"}) {
            const auto wire = [&](const char *joint) { return client.channel(place + "_" + side + "_" + joint); };
            legs.push_back({{wire("coxa"), wire("femur"), wire("tibia")}, (row + column) % 2});
            ++column;
        }
        ++row;
    }
    return legs;
}

// From 0 to 1 between two times, without a jerk at either end.
double ramp(double t, double from, double to) {
    const double x = std::clamp((t - from) / (to - from), 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

// Strokes of coxa, femur and tibia, 0 = cold and long, so long into the leg's own cycle, which begins with its step.
std::array<double, 3> strokes(double t_s) {
    const double t = std::fmod(t_s, 2.0 * step_s);
    const double lifted = ramp(t, 0.0, 1.0) - ramp(t, 2.0, 4.0);
    // Forward in the air, back on the ground: that pushes the body forward.
    const double forward = ramp(t, 1.0, 2.0) - ramp(t, step_s, 2.0 * step_s);
    return {0.15 + 0.45 * forward, 0.15 + 0.45 * lifted, 0.20 + 0.25 * forward};
}

// Sends a pose. Wires the driver refuses are told about and left out; the others walk on.
void send(const sinew::Client &client, std::vector<sinew::Wanted> &pose) {
    try {
        client.set_many(pose, lease);
    } catch (const sinew::Refused &refused) {
        for (const sinew::Refusal &refusal : refused.refusals()) {
            std::fprintf(stderr, "%s; %s\n", refusal.message.c_str(), refusal.remedy.c_str());
            const auto is_it = [&](const sinew::Wanted &wanted) {
                return client.channels()[wanted.channel].name == refusal.channel;
            };
            pose.erase(std::remove_if(pose.begin(), pose.end(), is_it), pose.end());
        }
        try {
            if (!pose.empty()) {
                client.set_many(pose, lease);
            }
        } catch (const sinew::Refused &) {
            // One more has failed meanwhile: the next pose comes soon.
        }
    }
}

void walk(const sinew::Client &client, const std::vector<Leg> &legs, double end_s) {
    auto stream = client.stream();
    auto faults = client.faults();
    std::vector<sinew::Wanted> pose;
    const auto start = Clock::now();
    auto next = start;
    double next_line = 1.0, squares = 0.0, lengths = 0.0;
    const auto elapsed = [&] { return sinew::Seconds(Clock::now() - start).count(); };

    while (!interrupted && elapsed() < end_s) {
        const double t = elapsed();

        // Command every wire, all in the same cycle.
        pose.clear();
        for (const Leg &leg : legs) {
            const auto stroke = strokes(t + step_s * leg.tripod);
            for (std::size_t joint = 0; joint < stroke.size(); ++joint) {
                pose.push_back(sinew::Wanted::stroke(leg.wires[joint], stroke[joint]));
            }
        }
        send(client, pose);

        // See what became of it: every cycle since the last look, not only the latest.
        for (const sinew::Cycle &cycle : stream.within(0s)) {
            for (const SinewChannelState &state : cycle) {
                const double error_m = state.length_m - state.target_m;
                // NaN while a wire has no length or no target.
                if (!std::isnan(error_m)) {
                    squares += error_m * error_m;
                    lengths += 1.0;
                }
            }
        }
        for (const sinew::FaultChange &change : faults.within(0s)) {
            const char *const what = change.after ? change.after.cause() : "fault cleared";
            std::fprintf(stderr, "%s: %s; %s\n", client.channels()[change.channel].name, what, change.after.remedy());
        }

        if (elapsed() >= next_line) {
            const auto lost = static_cast<unsigned long long>(stream.lost());
            std::printf("%6.1f s  rms error %.3f mm  lost cycles %llu\n", t, 1e3 * std::sqrt(squares / lengths), lost);
            std::fflush(stdout);
            squares = lengths = 0.0;
            next_line += 1.0;
        }
        next += tick;
        std::this_thread::sleep_until(next);
    }
}

}  // namespace

int main(int count, char **arguments) try {
    const std::string rig = count > 1 ? arguments[1] : "hexapod";
    const double end_s = count > 2 ? std::stod(arguments[2]) : HUGE_VAL;
    const auto interrupt = [](int) { interrupted = 1; };
    std::signal(SIGINT, interrupt);
    std::signal(SIGTERM, interrupt);

    const auto client = sinew::Client::connect(rig);
    const auto legs = find_legs(client);
    std::printf("walking %s: %zu channels at %g Hz\n", rig.c_str(), client.channels().size(), client.info().rate_hz);
    std::fflush(stdout);

    std::exception_ptr failed;
    try {
        walk(client, legs, end_s);
    } catch (...) {
        failed = std::current_exception();
    }
    // Whatever has happened: hand the wires back cold. Were this program killed instead, their leases would see to it.
    client.all_off();
    std::puts("all channels off");
    if (failed) {
        std::rethrow_exception(failed);
    }
    return EXIT_SUCCESS;
} catch (const std::exception &error) {
    // The text of an error of sinew ends with what to do about it.
    std::fprintf(stderr, "gait: %s\n", error.what());
    return EXIT_FAILURE;
}
