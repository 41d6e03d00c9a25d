// Plays the controller manager with the wires of a simulated rig: `drive LIBRARY TASK RIG …`, where TASK is one of those at the end.
// What it cannot see for itself, such as what a wire gets, is looked at by whoever has started it.
#include "manager.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

#include <sinew.hpp>

using namespace std::chrono_literals;

// ---- what read and write ask of the machine -------------------------------------------------------------------------------------------

namespace {
thread_local bool is_watched = false;
thread_local std::uint64_t allocations = 0;
}  // namespace

// The sanitizers have an allocator of their own.
#if defined(__SANITIZE_ADDRESS__)
#define SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SANITIZED 1
#endif
#endif
#ifndef SANITIZED
#define SANITIZED 0
// Every allocation of the process, of C++ and of Rust, comes by here.
extern "C" {
void *__libc_malloc(std::size_t size);
void *__libc_calloc(std::size_t count, std::size_t size);
void *__libc_realloc(void *memory, std::size_t size);
void *__libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void *memory);

void *malloc(std::size_t size) {
    allocations += is_watched;
    return __libc_malloc(size);
}
void *calloc(std::size_t count, std::size_t size) {
    allocations += is_watched;
    return __libc_calloc(count, size);
}
void *realloc(void *memory, std::size_t size) {
    allocations += is_watched;
    return __libc_realloc(memory, size);
}
void *aligned_alloc(std::size_t alignment, std::size_t size) {
    allocations += is_watched;
    return __libc_memalign(alignment, size);
}
int posix_memalign(void **memory, std::size_t alignment, std::size_t size) {
    allocations += is_watched;
    *memory = __libc_memalign(alignment, size);
    return *memory == nullptr ? 12 : 0;
}
void free(void *memory) {
    allocations += is_watched;
    __libc_free(memory);
}
}
#endif

namespace {

/// Counts what read and write allocate or free, and how often they sleep.
struct Watch {
    explicit Watch(Manager &manager) {
        manager.enter = [this] {
            slept_ = sleeps_so_far();
            is_watched = true;
        };
        manager.leave = [this] {
            is_watched = false;
            sleeps += sleeps_so_far() - slept_;
        };
    }
    static long sleeps_so_far() {
        rusage usage{};
        getrusage(RUSAGE_THREAD, &usage);
        return usage.ru_nvcsw;
    }
    long sleeps = 0;

private:
    long slept_ = 0;
};

// ---- URDFs ----------------------------------------------------------------------------------------------------------------------------

std::string file(const std::string &path) {
    std::ifstream stream(path);
    std::stringstream text;
    text << stream.rdbuf();
    CHECK(stream);
    return text.str();
}

std::string param(const std::string &name, const std::string &value) {
    return "<param name=\"" + name + "\">" + value + "</param>";
}

const std::string states = "<state_interface name=\"position\"/><state_interface name=\"velocity\"/><state_interface name=\"effort\"/>";

std::string commanded(const std::string &interface) {
    return "<command_interface name=\"" + interface + "\"/>";
}

std::string joint(const std::string &name, const std::string &more) {
    return "<joint name=\"" + name + "\">" + states + more + "</joint>";
}

/// The joints of a robot that <ros2_control> may name: the manager's parser looks for them.
std::string body() {
    std::string body = "<link name=\"base\"/>";
    for (const char *const name : {"hip", "left", "lft", "right", "knee"}) {
        body += std::string("<link name=\"") + name + "_link\"/><joint name=\"" + name + "\" type=\"revolute\"><parent link=\"base\"/><child link=\"" +
                name + "_link\"/><limit lower=\"-3\" upper=\"3\" effort=\"10\" velocity=\"10\"/></joint>";
    }
    return body;
}

std::string urdf(const std::string &hardware, const std::string &components) {
    return "<robot name=\"bench\">" + body() + "<ros2_control name=\"wires\" type=\"system\"><hardware><plugin>sinew_ros2_control/System</plugin>" + hardware +
           "</hardware>" + components + "</ros2_control></robot>";
}

/// Two wires against springs of their own: left turns a lever, right pulls straight.
std::string bench(const std::string &rig, const std::string &hardware = "") {
    const std::string spring = param("spring_n_per_m", "150") + param("preload_n", "2.4");
    return urdf(param("rig", rig) + hardware,
                joint("hip", commanded("position") + commanded("effort") + param("channel", "left") + param("radius_mm", "8") + spring) +
                    joint("right", commanded("position") + commanded("stroke") + commanded("duty") + param("direction", "-1") + param("zero_mm", "0")) +
                    "<sensor name=\"left_wire\"><state_interface name=\"temperature\"/><state_interface name=\"length\"/><state_interface "
                    "name=\"duty\"/>" +
                    param("channel", "left") + "</sensor>");
}

const char *library = "", *rig = "";

State start(Manager &manager, const std::string &text) {
    auto info = read_urdf(text);
    CHECK(info.hardware_plugin_name == "sinew_ros2_control/System");
    if (info.hardware_parameters.count("rig") == 1) {
        info.hardware_parameters["rig"] = rig;
    }
    CHECK(manager.init(info) == State::unconfigured);
    CHECK(manager.configure() == State::inactive);
    return manager.activate();
}

/// What the driver says of a channel.
SinewChannelState seen(const sinew::Client &client, const std::string &channel) {
    return client.latest()[client.channel(channel)];
}
bool is(const SinewChannelState &channel, SinewMode mode) {
    return channel.mode == static_cast<std::uint32_t>(mode);
}

/// Whether something comes about soon: a command is in force from the next cycle on, and to be seen after it.
bool soon(const std::function<bool()> &is_so) {
    for (int i = 0; i < 500; ++i) {
        if (is_so()) {
            return true;
        }
        std::this_thread::sleep_for(2ms);
    }
    return false;
}
bool soon(const sinew::Client &client, const std::vector<std::string> &channels, SinewMode mode) {
    return soon([&] { return std::all_of(channels.begin(), channels.end(), [&](const std::string &name) { return is(seen(client, name), mode); }); });
}

double at(std::vector<double> times, double share) {
    std::sort(times.begin(), times.end());
    return times.at(std::min(times.size() - 1, static_cast<std::size_t>(share * static_cast<double>(times.size()))));
}

void say(const char *what, const std::vector<double> &times) {
    std::printf("%s: p50 %.1f us, p99 %.1f us, longest %.1f us\n", what, 1e6 * at(times, 0.5), 1e6 * at(times, 0.99), 1e6 * at(times, 1.0));
}

// ---- tasks ----------------------------------------------------------------------------------------------------------------------------

/// All joints of a URDF move as they are told, and reading and writing them asks nothing of the machine.
void walk(const std::string &path) {
    Manager manager(library, "sinew_ros2_control::System");
    CHECK(start(manager, file(path)) == State::active);
    const sinew::Client client = sinew::Client::connect(rig);
    CHECK(manager.commands().size() == client.channels().size());
    CHECK(manager.states().size() == 4 * client.channels().size());
    std::vector<std::string> positions;
    for (const auto &[name, interface] : manager.commands()) {
        positions.push_back(name);
    }
    Watch watch(manager);
    manager.read_s.reserve(8 * update_rate);
    manager.write_s.reserve(8 * update_rate);

    // A wire that nobody has commanded goes on as before.
    for (unsigned int i = 0; i < update_rate / 2; ++i) {
        manager.cycle();
    }
    for (const SinewChannelState &channel : client.latest()) {
        CHECK(!is(channel, SINEW_MODE_LENGTH));
    }
    CHECK(manager.switch_mode(positions, {}) == return_type::OK);
    const auto begin = std::chrono::steady_clock::now();
    const auto gait = [&] {
        const double t = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        for (std::size_t i = 0; i < positions.size(); ++i) {
            manager.set(positions[i], 0.25 - 0.15 * std::cos(0.8 * t + static_cast<double>(i)));
        }
    };
    for (unsigned int i = 0; i < 5 * update_rate; ++i) {
        manager.cycle(gait);
    }
    manager.until("every joint to be where it was told", [&] {
        return std::all_of(positions.begin(), positions.end(), [&](const std::string &name) {
            return std::abs(manager.get(name) - 0.35) < 0.02;
        });
    }, [&] {
        for (const std::string &name : positions) {
            manager.set(name, 0.35);
        }
    });
    for (const std::string &name : positions) {
        const std::string joint = name.substr(0, name.find('/'));
        const SinewChannelState channel = seen(client, joint);
        const auto &info = client.channels()[client.channel(joint)];
        // position, length, velocity, effort and temperature are those of the wire
        CHECK(std::abs(channel.target_m - (info.cold_length_m - 0.35 * 0.008)) < 1e-9);
        CHECK(std::abs(channel.length_m - channel.target_m) < 0.02 * 0.008 + 2e-4);
        CHECK(channel.owner == static_cast<std::uint32_t>(getpid()) && channel.priority == 5);
        CHECK(std::abs(manager.get(joint + "/velocity")) < 1.5);
        const double effort = manager.get(joint + "/effort");
        CHECK(effort > 0.008 * 1.0 && effort < 0.008 * 2.6);
        CHECK(manager.get(joint + "_wire/temperature") > 40.0 && manager.get(joint + "_wire/temperature") < 200.0);
    }
    std::printf("%zu reads and %zu writes of %zu joints\n", manager.read_s.size(), manager.write_s.size(), positions.size());
    say("read", manager.read_s);
    say("write", manager.write_s);
    if (!SANITIZED) {
        std::printf("allocations %llu\n", static_cast<unsigned long long>(allocations));
        CHECK(allocations == 0);
        // and what counts does count
        is_watched = true;
        void *volatile memory = std::malloc(100);
        std::free(memory);
        is_watched = false;
        CHECK(allocations == 2);
    }
    std::printf("sleeps %ld\n", watch.sleeps);
    CHECK(watch.sleeps == 0);

    // A controller that goes takes its wires with it; the others go on.
    const std::vector<std::string> gone(positions.begin(), positions.begin() + 3);
    CHECK(manager.switch_mode({}, gone) == return_type::OK);
    manager.until("the wires of a controller that has gone to be off", [&] {
        return std::all_of(gone.begin(), gone.end(), [&](const std::string &name) {
            return is(seen(client, name.substr(0, name.find('/'))), SINEW_MODE_OFF);
        });
    });
    for (unsigned int i = 0; i < update_rate / 2; ++i) {
        manager.cycle();
    }
    for (const std::string &name : positions) {
        const bool has_gone = std::find(gone.begin(), gone.end(), name) != gone.end();
        CHECK(is(seen(client, name.substr(0, name.find('/'))), has_gone ? SINEW_MODE_OFF : SINEW_MODE_LENGTH));
    }
    CHECK(manager.deactivate() == State::inactive);
    CHECK(soon([&] {
        const sinew::Snapshot state = client.latest();
        return std::all_of(state.begin(), state.end(), [](const SinewChannelState &channel) { return is(channel, SINEW_MODE_OFF) && channel.owner == 0; });
    }));
    // It can still be read, and be taken through it all again. A cycle that a busy machine has missed measured nothing, and says so: NaN.
    manager.until("a wire that is off to be measured", [&] { return std::isfinite(manager.get(positions.front())); });
    CHECK(manager.activate() == State::active && manager.deactivate() == State::inactive);
    CHECK(manager.cleanup() == State::unconfigured);
    CHECK(manager.configure() == State::inactive && manager.activate() == State::active);
    CHECK(manager.shutdown() == State::finalized);
}

/// Every kind of command, and who has which.
void kinds() {
    Manager manager(library, "sinew_ros2_control::System");
    CHECK(start(manager, bench(rig, param("priority", "3"))) == State::active);
    const sinew::Client client = sinew::Client::connect(rig);
    const auto &left = client.channels()[client.channel("left")];

    // One joint, one command.
    CHECK(manager.switch_mode({"hip/position", "hip/effort"}, {}) == return_type::ERROR);
    CHECK(manager.switch_mode({"hip/effort", "right/stroke", "somebody_elses/position"}, {}) == return_type::OK);
    CHECK(manager.switch_mode({"hip/position"}, {}) == return_type::ERROR);
    const double tension_n = 2.0;
    manager.until("tension and stroke to be there", [&] {
        return std::abs(manager.get("hip/effort") - 0.008 * tension_n) < 0.008 * 0.03 && std::abs(seen(client, "right").target_m - (left.cold_length_m + 0.3 * (left.hot_length_m - left.cold_length_m))) < 1e-9;
    }, [&] {
        manager.set("hip/effort", 0.008 * tension_n);
        manager.set("right/stroke", 0.3);
    });
    CHECK(is(seen(client, "left"), SINEW_MODE_FORCE) && is(seen(client, "right"), SINEW_MODE_LENGTH));
    // position 0 of right is a length of 0 and grows with the wire: it is the length
    CHECK(std::abs(manager.get("right/position") - seen(client, "right").length_m) < 1e-3);
    // of right nobody has said what pulls it
    CHECK(std::isnan(manager.get("right/effort")));
    CHECK(std::abs(manager.get("left_wire/length") - seen(client, "left").length_m) < 1e-3);

    CHECK(manager.switch_mode({"hip/position", "right/duty"}, {"hip/effort", "right/stroke"}) == return_type::OK);
    manager.until("the first wire to be driven on, the second by its duty", [&] {
        return is(seen(client, "left"), SINEW_MODE_LENGTH) && is(seen(client, "right"), SINEW_MODE_DUTY) && std::abs(manager.get("hip/position") - 0.2) < 0.02;
    }, [&] {
        manager.set("hip/position", 0.2);
        manager.set("right/duty", 0.1);
    });
    // More than there is: held at the end of its way. NaN: nothing is wanted, and the lease ends.
    manager.until("one to be held at its end and the other one's lease to end", [&] {
        return std::abs(seen(client, "left").target_m - left.min_length_m) < 1e-9 && is(seen(client, "right"), SINEW_MODE_LAPSED);
    }, [&] {
        manager.set("hip/position", 3.0);
        manager.set("right/duty", std::numeric_limits<double>::quiet_NaN());
    });
    CHECK(manager.state == State::active);

    // Nobody else's commands are taken, but anybody's off; the next write heats again.
    try {
        client.set_stroke("right", 0.5, 1s);
        CHECK(!"it is claimed");
    } catch (const sinew::Refused &refused) {
        CHECK(refused.refusals().front().outcome == SINEW_OUTCOME_CLAIMED);
    }
    // The one with the higher priority gets it, and this one ends with the words of the refusal.
    client.claim({client.channel("left")}, 7, 2s);
    manager.until("the claim to be lost", [&] { return manager.state == State::unconfigured; }, [&] { manager.set("hip/position", 0.1); });
    CHECK(soon(client, {"left"}, SINEW_MODE_OFF));
}

/// Two wires that turn one joint.
void antagonists() {
    const auto text = [](const std::string &first, const std::string &second) {
        return urdf(param("rig", rig), joint("knee", commanded("position") + param("channel", first) + param("antagonist", second) + param("radius_mm", "8")));
    };
    const sinew::Client client = sinew::Client::connect(rig);
    {
        Manager manager(library, "sinew_ros2_control::System");
        CHECK(start(manager, text("flexor", "extensor")) == State::active);
        CHECK(manager.switch_mode({"knee/position"}, {}) == return_type::OK);
        for (const double angle : {0.15, -0.15}) {
            manager.until("the joint to turn", [&] { return std::abs(manager.get("knee/position") - angle) < 0.02; },
                          [&] { manager.set("knee/position", angle); });
        }
        CHECK(is(seen(client, "flexor"), SINEW_MODE_LENGTH) && is(seen(client, "extensor"), SINEW_MODE_LENGTH));
        CHECK(std::isnan(manager.get("knee/effort")));
        CHECK(manager.deactivate() == State::inactive);
        CHECK(soon(client, {"flexor", "extensor"}, SINEW_MODE_OFF));
    }
    // Which wires turn a joint is said by the rig file.
    Manager manager(library, "sinew_ros2_control::System");
    CHECK(start(manager, text("single", "flexor")) == State::active);
    CHECK(manager.switch_mode({"knee/position"}, {}) == return_type::OK);
    manager.until("the mistake to be seen", [&] { return manager.state == State::unconfigured; }, [&] { manager.set("knee/position", 0.2); });
    CHECK(soon(client, {"single"}, SINEW_MODE_OFF));
}

/// A wire gets a fault some time after the start.
void fault(const std::string &on_fault) {
    Manager manager(library, "sinew_ros2_control::System");
    const bool resets = on_fault == "reset";
    CHECK(start(manager, bench(rig, resets ? param("reset_faults", "true") : param("on_fault", on_fault))) == State::active);
    const sinew::Client client = sinew::Client::connect(rig);
    CHECK(manager.switch_mode({"hip/position", "right/stroke"}, {}) == return_type::OK);
    const auto command = [&] {
        manager.set("hip/position", 0.3);
        manager.set("right/stroke", 0.4);
    };
    manager.until("both wires to be driven", [&] { return is(seen(client, "right"), SINEW_MODE_LENGTH); }, command);
    manager.until("the fault", [&] { return seen(client, "left").fault != 0; }, command);
    const auto run_on = [&] {
        for (unsigned int i = 0; i < 2 * update_rate; ++i) {
            manager.cycle(command);
        }
    };
    run_on();
    if (on_fault == "carry_on") {
        CHECK(manager.state == State::active && is(seen(client, "right"), SINEW_MODE_LENGTH));
        CHECK(manager.deactivate() == State::inactive);
    } else {
        CHECK(manager.state == (on_fault == "error" ? State::unconfigured : State::inactive));
        CHECK(soon(client, {"right"}, SINEW_MODE_OFF));
        CHECK(manager.configure() == State::inactive);
        if (resets) {
            // It goes on as soon as the cause has gone.
            manager.until("the fault to be reset", [&] { return manager.activate() == State::active; });
            manager.until("the wire to be driven again", [&] { return is(seen(client, "left"), SINEW_MODE_LENGTH); }, command);
            CHECK(manager.deactivate() == State::inactive);
            return;
        }
        // It stays off until somebody has mended and reset it.
        CHECK(manager.activate() == State::inactive);
    }
    std::puts("off");
}

/// Holds both wires until it is killed, or until it is told to leave in an orderly way.
void hold(const std::string &how) {
    auto manager = std::make_unique<Manager>(library, "sinew_ros2_control::System");
    CHECK(start(*manager, bench(rig, how == "claimed" ? param("priority", "5") : "")) == State::active);
    CHECK(manager->switch_mode({"hip/position", "right/stroke"}, {}) == return_type::OK);
    const auto command = [&] {
        manager->set("hip/position", 0.4);
        manager->set("right/stroke", 0.4);
    };
    const sinew::Client client = sinew::Client::connect(rig);
    manager->until("both wires to be heated", [&] { return seen(client, "left").duty > 0.05 && seen(client, "right").duty > 0.05; }, command);
    std::puts("holding");
    std::fflush(stdout);
    if (how == "destroyed") {
        manager.reset();
        CHECK(soon(client, {"left", "right"}, SINEW_MODE_OFF));
        return;
    }
    if (how == "stuck") {
        // A manager that hangs writes no more.
        std::this_thread::sleep_for(1500ms);
        CHECK(is(seen(client, "left"), SINEW_MODE_LAPSED) && is(seen(client, "right"), SINEW_MODE_LAPSED));
        // and goes on where it was
        manager->until("it to go on", [&] { return is(seen(client, "left"), SINEW_MODE_LENGTH); }, command);
        CHECK(manager->deactivate() == State::inactive);
        return;
    }
    while (manager->state == State::active) {
        manager->cycle(command);
    }
    // The driver has gone. The next one is found as soon as it is there.
    CHECK(manager->state == State::unconfigured);
    std::puts("gone");
    std::fflush(stdout);
    while (manager->configure() != State::inactive) {
        std::this_thread::sleep_for(100ms);
    }
    CHECK(manager->activate() == State::active);
    // the manager has stopped the controllers of a component that failed; they are started anew
    CHECK(manager->switch_mode({"hip/position", "right/stroke"}, {"hip/position", "right/stroke"}) == return_type::OK);
    manager->until("the next driver's wires to move", [&] { return std::abs(manager->get("hip/position") - 0.4) < 0.03; }, command);
    CHECK(manager->shutdown() == State::finalized);
    std::puts("moved again");
}

/// The first thing somebody writes: each joint of it moves.
void first(const std::string &path) {
    Manager manager(library, "sinew_ros2_control::System");
    CHECK(start(manager, file(path)) == State::active);
    for (const auto &[name, interface] : manager.commands()) {
        const std::string &command = name;
        CHECK(manager.switch_mode({command}, {}) == return_type::OK);
        manager.until("the joint to move", [&] { return std::abs(manager.get(command) - 0.3) < 0.03; }, [&] { manager.set(command, 0.3); });
    }
    for (const auto &[name, interface] : manager.states()) {
        std::printf("%s %.3g\n", name.c_str(), manager.get(name));
    }
    CHECK(manager.deactivate() == State::inactive);
}

/// What cannot be meant is said at once, with the place; what is not there, when it is looked for.
void mistakes() {
    const auto init = [](const std::string &text) {
        Manager manager(library, "sinew_ros2_control::System");
        return manager.init(read_urdf(text));
    };
    const std::string position = commanded("position");
    const std::string wrong[] = {
        urdf(param("rgi", rig), joint("left", position)),
        urdf(param("priority", "10"), joint("left", position)),
        urdf(param("priority", "2.5"), joint("left", position)),
        urdf(param("hold_s", "0,5"), joint("left", position)),
        urdf(param("hold_s", "0.02"), joint("left", position)),
        urdf(param("over_s", "1"), joint("left", position)),
        urdf(param("on_fault", "ignore"), joint("left", position)),
        urdf("", joint("left", position + param("radius", "8"))),
        urdf("", joint("left", position + param("radius_mm", "nan"))),
        urdf("", joint("left", position + param("radius_mm", ""))),
        urdf("", joint("left", position + param("direction", "2"))),
        urdf("", joint("left", commanded("velocity"))),
        urdf("", joint("left", commanded("effort"))),
        urdf("", joint("left", position + param("preload_n", "2"))),
        urdf("", joint("left", position + param("antagonist", "right"))),
        urdf("", joint("left", position + param("antagonist", "right") + param("radius_mm", "8") + param("zero_mm", "160"))),
        urdf("", joint("left", commanded("duty") + param("antagonist", "right") + param("radius_mm", "8"))),
        urdf("", joint("left", position) + joint("hip", position + param("channel", "left"))),
        urdf("", "<joint name=\"left\"><state_interface name=\"acceleration\"/></joint>"),
        urdf("", "<sensor name=\"left\"><state_interface name=\"temprature\"/></sensor>"),
        urdf("", "<gpio name=\"left\"><state_interface name=\"temperature\"/></gpio>"),
    };
    for (const std::string &text : wrong) {
        CHECK(init(text) == State::finalized);
    }
    const auto configured = [](const std::string &text) {
        Manager manager(library, "sinew_ros2_control::System");
        CHECK(manager.init(read_urdf(text)) == State::unconfigured);
        return manager.configure();
    };
    CHECK(configured(urdf(param("rig", "nobodys"), joint("left", position))) == State::unconfigured);
    CHECK(configured(urdf(param("rig", rig), joint("lft", position))) == State::unconfigured);
    CHECK(configured(urdf(param("rig", rig), "<sensor name=\"rigth\"><state_interface name=\"temperature\"/></sensor>")) == State::unconfigured);
    CHECK(configured(urdf(param("rig", rig), joint("left", position))) == State::inactive);
    // A URDF with sensors alone is one, too.
    Manager manager(library, "sinew_ros2_control::System");
    CHECK(start(manager, urdf(param("rig", rig), "<sensor name=\"right\"><state_interface name=\"temperature\"/></sensor>")) == State::active);
    manager.cycle();
    CHECK(std::isfinite(manager.get("right/temperature")));
    CHECK(manager.deactivate() == State::inactive);
    std::puts("refused all");
}

}  // namespace

int main(int count, char **arguments) {
    CHECK(count >= 4);
    library = arguments[1];
    rig = arguments[3];
    const std::string task = arguments[2], more = count > 4 ? arguments[4] : "";
    task == "walk"          ? walk(more)
    : task == "kinds"       ? kinds()
    : task == "antagonists" ? antagonists()
    : task == "fault"       ? fault(more)
    : task == "hold"        ? hold(more)
    : task == "first"       ? first(more)
    : task == "mistakes"    ? mistakes()
                            : std::_Exit(2);
}
