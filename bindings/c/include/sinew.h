/*
 * sinew.h: the client of a robot program, for C. Written from its sources by cbindgen; do not edit.
 *
 * A program connects to a running driver (`sinew run`), reads its state and gives commands with leases:
 * docs/bindings.md is the guided tour. Link with `pkg-config --cflags --libs sinew`.
 *
 * Results. Every call that can fail gives a SinewStatus: SINEW_OK, SINEW_NOTHING where it waited in vain, or an error below zero,
 * whose words with what to do about it are sinew_last_error(). What a call would have written is then left as it was (handles: null).
 *
 * Threads. Any thread may call anything. A client may be shared between threads; a stream and a fault watch are for one thread at a time,
 * and say so to the second (SINEW_ERROR_IN_USE). The words of an error are those of the thread whose call failed. What is
 * closed while another thread is in a call with it lives until that call ends. A process made by fork() connects anew: handles it has
 * inherited are refused there (SINEW_ERROR_HANDLE), and stay good in the process before.
 *
 * Pointers. Null where something is needed, an odd address, a name without an end, a handle that is closed or is none: an error with its remedy.
 * What is not null has to lead to what the call is said to write or read; that no library can see. Handles are numbers, not addresses.
 *
 * Panics never come through; SINEW_ERROR_PANIC reports one. Names and words are UTF-8. Units are SI. What is not known is NaN.
 */

#ifndef SINEW_H
#define SINEW_H

#include <stddef.h>
#include <stdint.h>

// Version of the calls and structs below; that of the library is sinew_abi().
#define SINEW_ABI 3

// Version of the messages it speaks; that of the library is sinew_protocol().
#define SINEW_PROTOCOL 7

// Why a channel is, or the whole driver went, without power; 0 in messages means no fault. sinew_fault_remedy() says
// what to do.
enum SinewFault
#ifdef __cplusplus
  : uint32_t
#endif
 {
  // no sample has arrived from the channel's converter.
  SINEW_FAULT_NO_SAMPLE = 1,
  // a sample was NaN or infinite.
  SINEW_FAULT_NOT_FINITE = 2,
  // an input of the converter is at the end of its range.
  SINEW_FAULT_SATURATED = 3,
  // the measured length or resistance is outside what this wire can have.
  SINEW_FAULT_OUT_OF_RANGE = 4,
  // an input of the converter repeats one code for longer than its noise allows.
  SINEW_FAULT_STUCK = 5,
  // there is voltage but no current: the wire, a crimp or a lead is open.
  SINEW_FAULT_OPEN_WIRE = 6,
  // the resistance is far too small: the wire or part of it is bridged.
  SINEW_FAULT_SHORTED_WIRE = 7,
  // the taps contradict each other or the wire's resistance: a tap or the sliding probe has lost contact.
  SINEW_FAULT_PROBE_LOST = 8,
  // the supply voltage fell below its minimum.
  SINEW_FAULT_SUPPLY_DIP = 9,
  // the current in the on-phase is above the channel's limit.
  SINEW_FAULT_OVER_CURRENT = 10,
  // more heat went into the wire than it can have given off.
  SINEW_FAULT_ENERGY_BUDGET = 11,
  // the estimated wire temperature is above its limit.
  SINEW_FAULT_OVER_TEMPERATURE = 12,
  // the setpoint's lease ran out before it was renewed (in recordings up to protocol 5; since then the mode `lapsed`,
  // no fault).
  SINEW_FAULT_STALE_SETPOINT = 13,
  // a setpoint was NaN or outside the channel's limits.
  SINEW_FAULT_SETPOINT_OUT_OF_RANGE = 14,
  // too many cycles in a row came too late to control the wires.
  SINEW_FAULT_CYCLE_OVERRUN = 15,
  // the backend reported an error.
  SINEW_FAULT_BACKEND_ERROR = 16,
  // the driver is stopping.
  SINEW_FAULT_STOPPING = 17,
  // the driver is gone without having stopped, or its loop stands still.
  SINEW_FAULT_DRIVER_DIED = 18,
  // the wire was heated or cooled so far that it must have moved, but its measured length stands still: a tap sticks to
  // it, or the load is jammed.
  SINEW_FAULT_PROBE_STUCK = 19,
  // the other wire of its joint has a fault.
  SINEW_FAULT_JOINT_PARTNER = 20,
  // the machine was suspended while it drove: nobody watched the wires, and no lease ran out, for an unknown time.
  SINEW_FAULT_SUSPENDED = 21,
  // current flows although no duty is given: the output stage is stuck on, and its own gate cannot switch it off.
  SINEW_FAULT_STAGE_ON = 22,
  // the output stage of another channel is stuck on, so that everything on its supply was switched off.
  SINEW_FAULT_SUPPLY_CUT = 23,
  // less voltage than the supply has reaches the wire: the output stage does not switch on, or only in part, or a lead
  // is loose.
  SINEW_FAULT_STAGE_WEAK = 24,
  // the supply voltage is above its maximum.
  SINEW_FAULT_SUPPLY_HIGH = 25,
  // the emergency stop is open, or has not been reset since it was; a rig that has one starts so.
  SINEW_FAULT_EMERGENCY_STOP = 26,
};
#ifndef __cplusplus
typedef uint32_t SinewFault;
#endif

// One channel in one cycle, in SI units. What is not known is NaN.
typedef struct SinewChannelState {
  // (m) Wire length as well as it is known: measured, without the noise of a sample, a few ms late; NaN while it is not
  // measured.
  double length_m;
  // (m) The same as the last sample measured it, with its noise: what replays and models go by; NaN while it is not
  // measured.
  double measured_length_m;
  // (m/s) Observed speed, positive when the wire gets longer.
  double velocity_m_s;
  // (m/s²) Observed acceleration.
  double acceleration_m_s2;
  // (m) Commanded length; NaN when there is none.
  double target_m;
  // Duty given for the next period, 0..1.
  double duty;
  // (Ω) Measured resistance.
  double resistance_ohm;
  // (°C) Estimated wire temperature.
  double temperature_c;
  // Estimated martensite fraction, 0..1.
  double martensite;
  // (W) Mean electrical power over the period just past.
  double power_w;
  // (m/s²) The controller's surface σ (sliding mode) or error; 0 without a controller.
  double surface;
  // (s) What is left of the setpoint's lease; infinite when the driver moves the channel by itself, NaN without a
  // setpoint.
  double lease_s;
  // Value of the client's setpoint as the loop took it: m for a length and for a force against a spring, N for the
  // tension of a joint, a duty 0..1; NaN without one.
  double asked;
  // (V) Supply as sampled in the period just past; NaN = not sampled. This and the four below are the bits the backend
  // delivered.
  double supply_v;
  // (V) First tap as sampled; NaN = not sampled.
  double v1_v;
  // (V) Second tap as sampled; NaN = not sampled.
  double v2_v;
  // (V) Moving end as sampled; NaN = not sampled.
  double v3_v;
  // (A) Current as sampled; NaN = not sampled.
  double current_a;
  // What the channel is doing: 0 waiting, 1 off, 2 length, 3 duty, 4 force, 5 program, 6 fault, 7 lapsed.
  uint32_t mode;
  // Code of the latched fault, 0 = none.
  uint32_t fault;
  // Verdict on the present sample, 0 = good: the codes of `sinew_sensing::Health`.
  uint32_t health;
  // Bits of `SINEW_FLAG_…`: 1 controller at its limit, 2 settled, 4 held back by the supervisor or the limits of the
  // tension, 8 and that is the heat budget, 16 and that is the temperature budget, 32 the first of the latched faults,
  // 64 the next period is dark, 128 the output has not confirmed its duty, 256 an emergency stop holds everything off.
  uint32_t flags;
  // The request the loop took right before this cycle: its kind as in `SinewCommandKind`, plus 256 times its place
  // among those of this cycle; 0 = none. A channel takes one a cycle.
  uint32_t order;
  // How the backend failed in this cycle, 0 = it did not: the codes of `sinew_driver::BackendError`.
  uint32_t backend;
  // Process id of the client that has claimed the channel, 0 = nobody.
  uint32_t owner;
  // Priority of that claim, 0 to 9; 0 without one.
  uint32_t priority;
} SinewChannelState;

// The controller is at one of its two limits.
#define SINEW_FLAG_SATURATED 1

// The target has been reached.
#define SINEW_FLAG_SETTLED (1 << 1)

// A limit of power, duty or tension holds the duty from what the controller asks for.
#define SINEW_FLAG_LIMITED (1 << 2)

// And that limit is the heat budget: the duty is derated, so that the wire takes no more than it can give off.
#define SINEW_FLAG_HEAT_BUDGET (1 << 3)

// And that limit is the estimated temperature: the duty is derated, so that it stays below its maximum.
#define SINEW_FLAG_TEMPERATURE_BUDGET (1 << 4)

// The fault that is latched was the first of those latched now on any channel.
#define SINEW_FLAG_FIRST (1 << 5)

// The period ahead is dark: no duty, so that it shows whether the output stage switches off. Its sample has no length.
#define SINEW_FLAG_DARK (1 << 6)

// The output has not confirmed its duty: it may be at any that it was given since it last did.
#define SINEW_FLAG_UNCONFIRMED (1 << 7)

// An emergency stop holds everything off: it is open, or has not been reset since.
#define SINEW_FLAG_STOPPED (1 << 8)

// Most channels of a rig.
#define SINEW_MAX_CHANNELS 64

// Bytes of a name, with the zero byte at its end.
#define SINEW_NAME_SIZE 65

// What a call comes to. Errors are below zero; `sinew_last_error` has their words.
enum SinewStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Done.
  SINEW_OK = 0,
  // Nothing has come in the time given. No error.
  SINEW_NOTHING = 1,
  // An argument that no call takes: null, text without an end, a time that is none.
  SINEW_ERROR_ARGUMENT = -1,
  // What was handed over is not, or not any more, what the call is for: it has been closed, or was never opened.
  SINEW_ERROR_HANDLE = -2,
  // Another thread is using this stream or fault watch.
  SINEW_ERROR_IN_USE = -3,
  // A mistake of the library itself. Nothing of it has got out; the words say what to report.
  SINEW_ERROR_PANIC = -4,
  // An error this table has no code for; its words say all.
  SINEW_ERROR_OTHER = -5,
  // A rig name outside the allowed characters or too long.
  SINEW_ERROR_RIG_NAME = -6,
  // No driver for this rig is running.
  SINEW_ERROR_NOT_RUNNING = -7,
  // A driver holds the rig but has not opened its services in time.
  SINEW_ERROR_STARTING = -8,
  // The driver this client was connected to is gone: connect again for the next one.
  SINEW_ERROR_DRIVER_GONE = -9,
  // Driver and library speak different versions of the messages.
  SINEW_ERROR_PROTOCOL = -10,
  // There is no channel of that name.
  SINEW_ERROR_UNKNOWN_CHANNEL = -11,
  // No channels, or more than a rig can have.
  SINEW_ERROR_CHANNELS = -12,
  // The driver refused a command; see `sinew_refusal`.
  SINEW_ERROR_REFUSED = -13,
  // The driver refused a request for several channels and carried out none of it; see `sinew_refusal`.
  SINEW_ERROR_REFUSED_TOGETHER = -14,
  // The driver did not answer in time.
  SINEW_ERROR_NO_ANSWER = -15,
  // The folder for locks and sockets cannot be used.
  SINEW_ERROR_RUNTIME_DIR = -16,
  // The driver serves no more of something at once.
  SINEW_ERROR_FULL = -17,
  // The driver is another user's, and lets only others look.
  SINEW_ERROR_NOT_ADMITTED = -18,
  // The gateway for other users could be anybody's.
  SINEW_ERROR_GATEWAY = -19,
  // Shared memory could not be opened.
  SINEW_ERROR_SERVICE = -20,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SinewStatus SinewStatus;
#else
typedef int32_t SinewStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How the driver is.
enum SinewDriverHealth
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Services are there, the loop does not run yet.
  SINEW_DRIVER_HEALTH_STARTING = 0,
  // The loop runs.
  SINEW_DRIVER_HEALTH_RUNNING = 1,
  // Its process lives but the loop has not written for a while.
  SINEW_DRIVER_HEALTH_STALLED = 2,
  // It is stopping or has stopped in order.
  SINEW_DRIVER_HEALTH_STOPPED = 3,
  // It ended without stopping.
  SINEW_DRIVER_HEALTH_DIED = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SinewDriverHealth SinewDriverHealth;
#else
typedef uint32_t SinewDriverHealth;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What a pair of times says of the device's clock.
enum SinewClockNews
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // It goes on as before.
  SINEW_CLOCK_NEWS_NONE = 0,
  // It shows an earlier time than before: it was reset. All pairs before are forgotten, as with those below.
  SINEW_CLOCK_NEWS_WENT_BACK = 1,
  // It was set.
  SINEW_CLOCK_NEWS_JUMPED = 2,
  // Its rate changed by more than is assumed of it.
  SINEW_CLOCK_NEWS_UNSTEADY = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SinewClockNews SinewClockNews;
#else
typedef uint32_t SinewClockNews;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What a channel is doing.
enum SinewMode
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Nothing is known about the wire yet: no complete sample has come.
  SINEW_MODE_WAITING = 0,
  // Only the sensing pulse.
  SINEW_MODE_OFF = 1,
  // Length under control.
  SINEW_MODE_LENGTH = 2,
  // Duty as commanded.
  SINEW_MODE_DUTY = 3,
  // Force under control.
  SINEW_MODE_FORCE = 4,
  // The driver itself moves the wire (the built-in hexapod's walk).
  SINEW_MODE_PROGRAM = 5,
  // Switched off by a latched fault.
  SINEW_MODE_FAULT = 6,
  // Off, because its setpoint's lease ended and nothing else moves it. No fault: the next setpoint is taken.
  SINEW_MODE_LAPSED = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SinewMode SinewMode;
#else
typedef uint32_t SinewMode;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What a command asks for.
enum SinewCommandKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Hold a wire length, m.
  SINEW_COMMAND_KIND_LENGTH = 1,
  // Hold a share of the stroke, 0 (cold) .. 1 (hot).
  SINEW_COMMAND_KIND_STROKE = 2,
  // Give a duty, 0..1.
  SINEW_COMMAND_KIND_DUTY = 3,
  // Hold a tension, N.
  SINEW_COMMAND_KIND_FORCE = 4,
  // Only the sensing pulse.
  SINEW_COMMAND_KIND_OFF = 5,
  // Clear a latched fault whose cause has gone.
  SINEW_COMMAND_KIND_RESET = 6,
  // Stop the driver.
  SINEW_COMMAND_KIND_STOP = 7,
  // Have the channel to oneself, with a priority, 0..9: others' setpoints and resets are refused.
  SINEW_COMMAND_KIND_CLAIM = 8,
  // Let go of a claim.
  SINEW_COMMAND_KIND_RELEASE = 9,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SinewCommandKind SinewCommandKind;
#else
typedef uint32_t SinewCommandKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What became of a command.
enum SinewOutcome
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // The loop has it.
  SINEW_OUTCOME_TAKEN = 0,
  // There is no channel of that number.
  SINEW_OUTCOME_UNKNOWN_CHANNEL = 1,
  // This driver does not know that kind of command.
  SINEW_OUTCOME_UNKNOWN_COMMAND = 2,
  // Value or hold is NaN or infinite.
  SINEW_OUTCOME_NOT_FINITE = 3,
  // The value is outside `low..=high`.
  SINEW_OUTCOME_OUT_OF_RANGE = 4,
  // The hold is outside `low..=high`, s.
  SINEW_OUTCOME_HOLD_OUT_OF_RANGE = 5,
  // The channel is off by a latched fault: reset it first.
  SINEW_OUTCOME_FAULTED = 6,
  // The cause of the fault is still there: a reset is refused.
  SINEW_OUTCOME_CAUSE_REMAINS = 7,
  // The channel has not proved its sensors yet.
  SINEW_OUTCOME_WAITING = 8,
  // This channel cannot do that (no force control, say).
  SINEW_OUTCOME_UNSUPPORTED = 9,
  // Too many commands at once: try again.
  SINEW_OUTCOME_BUSY = 10,
  // The driver is stopping.
  SINEW_OUTCOME_STOPPING = 11,
  // Who asks may look but not command.
  SINEW_OUTCOME_NOT_PERMITTED = 12,
  // Not carried out: an `off` that was asked for later has overtaken it.
  SINEW_OUTCOME_OVERTAKEN = 13,
  // The fault cannot be cleared yet: the wire has to cool first.
  SINEW_OUTCOME_TOO_HOT = 14,
  // Not carried out because another one of the same request was refused.
  SINEW_OUTCOME_WITH_OTHERS = 15,
  // The request names the channel twice, or asks beside others for what is asked for alone (a reset, a stop).
  SINEW_OUTCOME_NOT_TOGETHER = 16,
  // Another client has claimed the channel.
  SINEW_OUTCOME_CLAIMED = 17,
  // Not carried out: the setpoint of a stream came after its deadline.
  SINEW_OUTCOME_LATE = 18,
  // The time to approach a setpoint in is outside `low..=high`, s.
  SINEW_OUTCOME_APPROACH_OUT_OF_RANGE = 19,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SinewOutcome SinewOutcome;
#else
typedef uint32_t SinewOutcome;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What the driver as a whole is doing.
enum SinewDriverState
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Services are there, the loop does not run yet.
  SINEW_DRIVER_STATE_STARTING = 0,
  // The loop runs.
  SINEW_DRIVER_STATE_RUNNING = 1,
  // Outputs go to zero, the end is near.
  SINEW_DRIVER_STATE_STOPPING = 2,
  // Outputs are zero and stay so; this was the last state.
  SINEW_DRIVER_STATE_STOPPED = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SinewDriverState SinewDriverState;
#else
typedef uint32_t SinewDriverState;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A connection to a running driver. Threads may share it.
typedef struct SinewClient SinewClient;

// The clock of another device beside the driver's, learnt from pairs of times. For one thread at a time.
typedef struct SinewClockMap SinewClockMap;

// Every cycle from the moment it was opened, in order. For one thread at a time.
typedef struct SinewCycleStream SinewCycleStream;

// Watches for faults. For one thread at a time.
typedef struct SinewFaultWatch SinewFaultWatch;

// A stream of setpoints. For one thread at a time.
typedef struct SinewSetpoints SinewSetpoints;

// What does not change while the driver runs.
typedef struct {
  // Version of the driver's messages.
  uint32_t protocol;
  // Process id of the driver.
  uint32_t pid;
  // Name of the rig.
  char rig[SINEW_NAME_SIZE];
  // Rate of the loop, Hz.
  double rate_hz;
  // When the driver started, CLOCK_MONOTONIC, ns.
  uint64_t started_ns;
  // How many channels there are.
  uint32_t channels;
  // 1 when the wires are simulated, 0 when they are real.
  uint32_t simulated;
  // 1 when the driver is another user's, reached through its gateway.
  uint32_t foreign;
} SinewInfo;

// What does not change about a channel while the driver runs.
typedef struct {
  // Its name in the rig file.
  char name[SINEW_NAME_SIZE];
  // Shortest length that may be asked for, m.
  double min_length_m;
  // Longest length that may be asked for, m.
  double max_length_m;
  // Length at full stroke: hot, under the load at rest, m.
  double hot_length_m;
  // Length without stroke: cold, under the load at rest, m.
  double cold_length_m;
  // Hot, unloaded length L_0, m.
  double rest_length_m;
  // Largest duty, 0..1.
  double max_duty;
  // Largest current in the on-phase, A.
  double max_current_a;
  // Largest mean power, W.
  double max_power_w;
  // Highest estimated temperature, °C.
  double max_temperature_c;
  // Lease of a setpoint that names none, s.
  double lease_s;
} SinewChannelInfo;

// The latest state of everything: one consistent cycle.
typedef struct {
  // Number of the cycle, from 1; 0 before the first.
  uint64_t cycle;
  // When its samples were taken, CLOCK_MONOTONIC, ns; the driver's heartbeat.
  uint64_t monotonic_ns;
  // Periods skipped since the start because the loop was late.
  uint64_t missed;
  // How many of the channels are there.
  uint32_t channels;
  // What the driver is doing: `SinewDriverState`.
  uint32_t state;
  // The channels; `channels` of them are there.
  SinewChannelState channel[SINEW_MAX_CHANNELS];
} SinewSnapshot;

// How long something took, ns.
typedef struct {
  // How often it was measured.
  uint64_t count;
  // Half of them took no longer, ns.
  uint64_t p50_ns;
  // 99 of 100 took no longer, ns.
  uint64_t p99_ns;
  // 999 of 1000 took no longer, ns.
  uint64_t p999_ns;
  // The longest, ns.
  uint64_t max_ns;
} SinewTiming;

// How the loop does.
typedef struct {
  // How late the loop woke up.
  SinewTiming lateness;
  // How long a cycle took.
  SinewTiming cycle_time;
  // Time between two cycles.
  SinewTiming period;
  // Cycles that ran.
  uint64_t cycles;
  // Periods skipped because the loop was late.
  uint64_t missed;
  // Cycles that took longer than a period.
  uint64_t overruns;
  // Cycles that no stream has, because they did not fit on the way to the publisher.
  uint64_t ring_drops;
  // Allocations inside the loop; 0 unless something is wrong.
  uint64_t allocations;
  // Commands taken.
  uint64_t commands;
  // Commands refused.
  uint64_t refusals;
  // Priority under SCHED_FIFO, 0 without.
  uint32_t priority;
  // Processor the loop is pinned to, -1 without.
  int32_t cpu;
  // Threads of the driver that have died and without which it goes on; `sinew status` names them.
  uint32_t dead_threads;
} SinewLoopStats;

// One cycle of a stream.
typedef struct {
  // Number of the cycle, from 1, consecutive over the cycles that ran.
  uint64_t cycle;
  // When its samples were taken, CLOCK_MONOTONIC, ns.
  uint64_t monotonic_ns;
  // Periods skipped since the start because the loop was late. They have no cycle number.
  uint64_t missed;
  // Cycles lost between the one before and this one: this reader was too slow.
  uint64_t lost;
  // How many of the channels are there.
  uint32_t channels;
  // The channels, in the rig's order; those that are not there are left as they were.
  SinewChannelState channel[SINEW_MAX_CHANNELS];
} SinewCycle;

// What became of a command.
typedef struct {
  // Number of the cycle from which on it is in force.
  uint64_t cycle;
  // The lease as granted, s; 0 where there is none.
  double hold_s;
} SinewTaken;

// One setpoint of several.
typedef struct {
  // Number of the channel.
  uint32_t channel;
  // What is asked for: length, stroke, duty, force or off of `SinewCommandKind`.
  uint32_t kind;
  // Value in SI units; 0 for off.
  double value;
} SinewWanted;

// What became of the messages of a stream of setpoints so far. Those in none of the other counts are on their way.
typedef struct {
  // Messages given to `sinew_setpoints_send`.
  uint64_t sent;
  // In force.
  uint64_t taken;
  // Not carried out because a later one of the stream, or an off, has overtaken them.
  uint64_t overtaken;
  // Not carried out because they came after their deadline.
  uint64_t late;
  // Refused for another reason.
  uint64_t refused;
  // Not sent because too many were without an answer.
  uint64_t held_back;
  // Number of the cycle in which the last one was taken; 0 = none yet.
  uint64_t cycle;
} SinewSetpointProgress;

// One change of a channel's fault.
typedef struct {
  // Number of the channel.
  uint32_t channel;
  // The fault before, 0 = none.
  uint32_t before;
  // The fault from now on, 0 = cleared.
  uint32_t after;
  // The cycle it was seen in.
  uint64_t cycle;
  // When, CLOCK_MONOTONIC, ns.
  uint64_t monotonic_ns;
} SinewFaultChange;

// What is assumed of another clock; `sinew_clock_rules` has what is usual.
typedef struct {
  // What its rate and the driver's are apart by at the most, ppm.
  double max_rate_ppm;
  // What that may change by in a second, ppm/s: temperature mostly.
  double drift_ppm_per_s;
  // What its stamps are rounded to, ns.
  uint64_t resolution_ns;
  // The least that late stamps are ever delayed by, ns. Nothing that only comes late can tell: at 0 all answers are too
  // late by just that.
  uint64_t least_delay_ns;
  // What that is off by, ns.
  uint64_t least_delay_error_ns;
  // Late stamps must cover so much time before they say anything, s.
  double settle_s;
  // Pairs older than this are forgotten, s.
  double window_s;
  // Pairs that are kept at the most.
  uint32_t pairs;
} SinewClockRules;

// Whether a device's clock has been set.
typedef struct {
  // What has come to pass.
  SinewClockNews news;
  // By how much it was set, ns, forward where this is positive; 0 where that is not known.
  int64_t by_ns;
} SinewClockChange;

// What the driver refused, and why. What a reason has not is 0 for codes and NaN for numbers.
typedef struct {
  // The channel's name; "all channels" for commands that name none.
  char channel[SINEW_NAME_SIZE];
  // What was asked for: `SinewCommandKind`.
  uint32_t kind;
  // Why not: `SinewOutcome`.
  uint32_t outcome;
  // The fault in the way: `SinewFault`.
  uint32_t fault;
  // The value asked for, in SI units.
  double value;
  // Smallest value or hold that would have been taken.
  double low;
  // Largest value or hold that would have been taken.
  double high;
  // Too hot: after this long it has cooled, at the most, s.
  double longest_s;
  // Too hot: what is believed of its temperature, °C.
  double temperature_c;
  // Too hot: what that has to come down to, °C. Where it has, the heat account has to drain.
  double below_c;
  // What is wrong. Valid until the next call of this thread that fails.
  const char *message;
  // What to do about it. Valid as long.
  const char *remedy;
} SinewRefusal;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Version of the calls and structs this library has: `SINEW_ABI` of the header it was built with.
uint32_t sinew_abi(void);

// Version of the messages this library speaks; a driver of another one is refused by `sinew_connect`.
uint32_t sinew_protocol(void);

// Connects to the driver of this rig: the own user's, or another user's through its gateway. `*client` is null unless
// this comes to
// `SINEW_OK`. Waits up to 2 s for a driver that is just starting, and later up to 1 s for the answer to a command.
SinewStatus sinew_connect(const char *rig,
                          SinewClient **client);

// Connects with patience of one's own: for a driver that is just starting, and for the answer to a command, s.
SinewStatus sinew_connect_with(const char *rig, double connect_s, double answer_s, SinewClient **client);

// Closes a client. Setpoints it has given hold until their leases end; `sinew_all_off` ends them at once. Streams and
// fault watches that were
// opened with it stay good, and are closed by calls of their own. Null is fine.
SinewStatus sinew_close(SinewClient *client);

// Names of the rigs a driver is running for, sorted: writes as many as there is room for, and how many there are.
SinewStatus sinew_discover(char (*rigs)[SINEW_NAME_SIZE], size_t room, size_t *found);

// What does not change while the driver runs.
SinewStatus sinew_info(const SinewClient *client, SinewInfo *info);

// The channels, in the rig's order: writes as many as there is room for (`SINEW_MAX_CHANNELS` is always enough), and
// how many there are.
SinewStatus sinew_channels(const SinewClient *client,
                           SinewChannelInfo *channels,
                           size_t room,
                           size_t *found);

// The number of the channel with this name; a mistyped one is told which was meant.
SinewStatus sinew_channel(const SinewClient *client, const char *channel, uint32_t *number);

// The text of the rig file as the driver read it: as many bytes as there is room for, the last of them a zero, and how
// many the whole needs
// with its zero. 0 where the driver left none.
SinewStatus sinew_rig_text(const SinewClient *client,
                           char *text,
                           size_t room,
                           size_t *needed);

// The latest state: one whole cycle, never parts of two. Does not wait, and goes on giving the last one after the
// driver's end.
// Channels that are not there are left as they were.
SinewStatus sinew_latest(const SinewClient *client,
                         SinewSnapshot *snapshot);

// How the driver is, and the age of its latest state, s. Either may be null.
SinewStatus sinew_health(const SinewClient *client, SinewDriverHealth *health, double *age_s);

// How the loop does.
SinewStatus sinew_loop_stats(const SinewClient *client, SinewLoopStats *stats);

// Sleeps until the driver has something new, `SINEW_NOTHING` when that took longer. Comes back at once when something
// has come since the last
// call. Threads that sleep at the same time do so best with a client each.
SinewStatus sinew_wait(const SinewClient *client,
                       double timeout_s);

// Every cycle from now on, in order. Buffers about two seconds; who falls behind further loses the oldest, and is told
// how many. A driver serves 64
// streams at once.
SinewStatus sinew_stream(const SinewClient *client,
                         SinewCycleStream **stream);

// The next cycle, waiting for it up to so long; `SINEW_NOTHING` when none came. `SINEW_ERROR_DRIVER_GONE` once
// everything the driver had sent
// is read. Channels that are not there are left as they were.
SinewStatus sinew_stream_next(SinewCycleStream *stream,
                              double timeout_s,
                              SinewCycle *cycle);

// Cycles received so far, and lost since the first one received: exactly those the driver ran and this reader did not
// get. Either may be null.
SinewStatus sinew_stream_counts(const SinewCycleStream *stream,
                                uint64_t *received,
                                uint64_t *lost);

// Closes a stream. Null is fine.
SinewStatus sinew_stream_close(SinewCycleStream *stream);

// Holds a wire length, m, for `hold_s` unless renewed; 0 takes the channel's own default. Comes back once the driver
// has taken the command.
// Send setpoints several times per lease: when a lease ends, its wire goes off.
SinewStatus sinew_set_length(const SinewClient *client,
                             const char *channel,
                             double length_m,
                             double hold_s);

// Holds a share of the stroke, 0 (cold) to 1 (hot), like `sinew_set_length`.
SinewStatus sinew_set_stroke(const SinewClient *client, const char *channel, double stroke, double hold_s);

// Gives a duty, 0 to 1, without control, like `sinew_set_length`.
SinewStatus sinew_set_duty(const SinewClient *client, const char *channel, double duty, double hold_s);

// Holds a tension, N, like `sinew_set_length`.
SinewStatus sinew_set_force(const SinewClient *client, const char *channel, double force_n, double hold_s);

// Any command of `SinewCommandKind` to a channel by name. `taken`, which may be null, gets the cycle and the lease.
SinewStatus sinew_set(const SinewClient *client,
                      const char *channel,
                      uint32_t kind,
                      double value,
                      double hold_s,
                      SinewTaken *taken);

// Setpoints for several channels in one request: all of them are in force from the same cycle on, or none is, and
// `sinew_refusal` has each
// refused channel's own reason. They hold for `hold_s` unless renewed; 0 takes the shortest of the channels' defaults.
// An off among
// setpoints holds until the next command. `taken`, which may be null, gets the cycle and the lease.
SinewStatus sinew_set_many(const SinewClient *client,
                           const SinewWanted *wanted,
                           size_t count,
                           double hold_s,
                           SinewTaken *taken);

// Has these channels to itself: setpoints and resets of other clients are refused with this process's id, until it lets
// go of them or `hold_s`
// has passed without a word of it (0: the channels' default lease). Off and stop stay open to everybody. All of them or
// none; a
// higher priority, 0 to 9, takes a channel over. `taken`, which may be null, gets the lease.
SinewStatus sinew_claim(const SinewClient *client,
                        const uint32_t *channels,
                        size_t count,
                        uint32_t priority,
                        double hold_s,
                        SinewTaken *taken);

// Lets go of these channels; one that this client has not claimed stays as it is.
SinewStatus sinew_release(const SinewClient *client, const uint32_t *channels, size_t count);

// Only the sensing pulse from now on.
SinewStatus sinew_off(const SinewClient *client, const char *channel);

// Only the sensing pulse on every channel from now on.
SinewStatus sinew_all_off(const SinewClient *client);

// Clears a latched fault whose cause has gone.
SinewStatus sinew_reset(const SinewClient *client, const char *channel);

// Stops the driver: outputs to zero, then it ends.
SinewStatus sinew_stop(const SinewClient *client);

// Opens a stream of setpoints. Each message holds for `hold_s` unless the next one comes (0: the shortest of its
// channels' defaults), is
// approached in a straight line within `over_s` from what was wanted before (0: it holds at once; at the most the
// lease, usually the
// planner's own period), and is not carried out where the driver gets to it later than `within_s` (0: whenever it
// comes).
SinewStatus sinew_setpoints(const SinewClient *client,
                            double hold_s,
                            double over_s,
                            double within_s,
                            SinewSetpoints **setpoints);

// Sends setpoints for several channels on their way, all or none, and does not wait: the newest overtakes those that
// still wait. A refusal is
// that of an earlier message, and this one is on its way all the same; with every other error it was not sent.
// `progress`, which may be
// null, gets what became of the messages so far.
SinewStatus sinew_setpoints_send(SinewSetpoints *setpoints,
                                 const SinewWanted *wanted,
                                 size_t count,
                                 SinewSetpointProgress *progress);

// Looks for answers to what is on its way, without waiting. `progress`, which may be null, gets what became of the
// messages so far.
SinewStatus sinew_setpoints_poll(SinewSetpoints *setpoints,
                                 SinewSetpointProgress *progress);

// Closes a stream of setpoints. What the driver has not begun with is not carried out; what is in force holds until its
// lease ends. Null is
// fine.
SinewStatus sinew_setpoints_close(SinewSetpoints *setpoints);

// Fault changes from now on; the first reported are the faults that are there already. Faults stay latched until
// somebody resets them, so looking
// now and then misses none but those that are reset in between.
SinewStatus sinew_faults(const SinewClient *client,
                         SinewFaultWatch **faults);

// The next change, waiting for it up to so long; `SINEW_NOTHING` when none came. When the driver has died each channel
// changes to
// `SINEW_FAULT_DRIVER_DIED` once; then, if asked to wait, `SINEW_ERROR_DRIVER_GONE`.
SinewStatus sinew_faults_next(SinewFaultWatch *faults,
                              double timeout_s,
                              SinewFaultChange *change);

// Closes a fault watch. Null is fine.
SinewStatus sinew_faults_close(SinewFaultWatch *faults);

// The short name of a fault in reports; empty for 0 and for what this version does not know. The text stays.
const char *sinew_fault_flag(uint32_t fault);

// What happened, as the end of "the channel is off because …"; empty as for `sinew_fault_flag`.
const char *sinew_fault_cause(uint32_t fault);

// What a person can do about it; empty as for `sinew_fault_flag`.
const char *sinew_fault_remedy(uint32_t fault);

// The name of what a channel is doing, a `SinewMode`; empty for what this version does not know. The text stays.
const char *sinew_mode_name(uint32_t mode);

// The clock of all times in messages: CLOCK_MONOTONIC, ns.
uint64_t sinew_monotonic_ns(void);

// The system's time of a driver's stamp, ns since 1970 (UTC), and what that is off by at the most, ns: by a
// comparison of the two clocks, made now. A stamp from before the system's clock was set comes out as that is set
// now.
SinewStatus sinew_system_time(uint64_t monotonic_ns, int64_t *system_ns, uint64_t *error_ns);

// What is usual of another clock: to be changed where more is known, and handed to `sinew_clock_map`.
SinewStatus sinew_clock_rules(SinewClockRules *rules);

// Opens a map of a device's clock, a data acquisition's or a camera's, that knows nothing yet. `rules` may be
// null: what is usual. Needs no driver.
SinewStatus sinew_clock_map(const SinewClockRules *rules, SinewClockMap **map);

// Adds a time the device showed between two of the driver's: before it was asked and after its answer came.
// `change`, which may be null, gets whether the device's clock has been set meanwhile.
SinewStatus sinew_clock_map_bracket(SinewClockMap *map,
                                    uint64_t before_ns,
                                    int64_t other_ns,
                                    uint64_t after_ns,
                                    SinewClockChange *change);

// Adds two times of one moment, of which the driver's is off by `error_ns` at the most. `change` as above.
SinewStatus sinew_clock_map_pair(SinewClockMap *map,
                                 uint64_t driver_ns,
                                 int64_t other_ns,
                                 uint64_t error_ns,
                                 SinewClockChange *change);

// Adds a stamp of the device and when it was received, some unknown time later and never earlier, in the order in
// which they were received. `change` as above.
SinewStatus sinew_clock_map_late(SinewClockMap *map, uint64_t received_ns, int64_t other_ns, SinewClockChange *change);

// The driver's time of a time of the device, and what that is off by at the most, ns; `SINEW_NOTHING` where it is
// not known: before enough pairs, and before the first pair since the device's clock was set.
SinewStatus sinew_clock_map_driver_at(const SinewClockMap *map,
                                      int64_t other_ns,
                                      uint64_t *driver_ns,
                                      uint64_t *error_ns);

// The device's time of a driver's stamp, as above.
SinewStatus sinew_clock_map_other_at(const SinewClockMap *map,
                                     uint64_t driver_ns,
                                     int64_t *other_ns,
                                     uint64_t *error_ns);

// What the device's clock runs fast by as of the latest pair, and what that is off by at the most, ppm;
// `SINEW_NOTHING` where it is not known.
SinewStatus sinew_clock_map_rate(const SinewClockMap *map, double *rate_ppm, double *error_ppm);

// Closes a map of a clock. Null is fine.
SinewStatus sinew_clock_map_close(SinewClockMap *map);

// What went wrong in the call of this thread that failed last, and after a semicolon what to do about it; empty before
// the first.
// Valid until the next call of this thread that fails.
const char *sinew_last_error(void);

// What to do about it, alone; empty where the error says all there is. Valid as long.
const char *sinew_last_remedy(void);

// How many commands the driver refused in the call of this thread that failed last: 0 unless that was
// `SINEW_ERROR_REFUSED` or `SINEW_ERROR_REFUSED_TOGETHER`.
size_t sinew_refusals(void);

// One of them, from 0.
SinewStatus sinew_refusal(size_t index, SinewRefusal *refusal);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SINEW_H */
