//! Every fault of a channel or of the driver, in one table: code, flag, cause, detection, reaction and its time, remedy.
//!
//! A row becomes a variant of [`Fault`] and an entry of [`FAULT_TABLE`]. The driver's supervisor latches by it; the monitor, the
//! scope, `status --json`, the events of recordings, the black box and the client's error texts quote it; `docs/client.md` prints it
//! ([`fault_table_markdown`]). Nothing else in the project explains a fault.
//!
//! To add a fault, add its row here, with the next code, and trip it where it is detected.

use std::fmt::{self, Write as _};

/// What there is to know about one fault: a row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultRow {
    /// The fault.
    pub fault: Fault,
    /// Its short name in reports, `status --json` and the monitor.
    pub flag: &'static str,
    /// What happened, as the end of "channel x is off because …".
    pub cause: &'static str,
    /// How it is detected.
    pub detection: &'static str,
    /// What the driver does about it.
    pub reaction: &'static str,
    /// How long it takes from the first evidence until the reaction has put out its duty.
    pub time: &'static str,
    /// What a person can do about it.
    pub remedy: &'static str,
    /// Whether it stays until the driver is started anew, because nothing in a running one can show that it is mended.
    pub needs_restart: bool,
    /// Whether no driver raises it any more: it stands in older recordings.
    pub is_retired: bool,
    /// Whether it follows from a fault of another channel, and so is never the first.
    pub follows_another: bool,
}

/// Makes of the table [`Fault`] and [`FAULT_TABLE`]. The rows stand in the order of their codes, from 1 without a gap.
macro_rules! faults {
    ($( $fault:ident = $code:literal, $flag:literal {
        cause: $cause:literal, $($rest:tt)*
    } )+) => {
        /// Why a channel is, or the whole driver went, without power. The number travels in messages; 0 there means "no fault".
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u32)]
        pub enum Fault {
            $( #[doc = $cause] $fault = $code, )+
        }

        /// The table, in the order of the codes.
        // a row may say all there is to say, or leave the rarer things at their defaults
        #[allow(clippy::needless_update)]
        pub const FAULT_TABLE: [FaultRow; [$($code),+].len()] = [
            $( FaultRow { fault: Fault::$fault, flag: $flag, cause: $cause, $($rest)* ..ROW }, )+
        ];
    };
}

/// What most rows have in common.
const ROW: FaultRow = FaultRow {
    fault: Fault::NoSample,
    flag: "",
    cause: "",
    detection: "",
    reaction: "",
    time: "",
    remedy: "",
    needs_restart: false,
    is_retired: false,
    follows_another: false,
};

faults! {
    NoSample = 1, "no_sample" {
        cause: "no sample has arrived from the channel's converter",
        detection: "every input that is needed is NaN where duty was given, twice in a row; after the start or a reset: no proof of health within 1 s (and 32 periods)",
        reaction: "output stays zero until every sensor of the channel has reported; once running: channel off, latched",
        time: "2 periods",
        remedy: "wait a moment after the start; if it stays, check the converter's cable and its configured channel, then reset",
    }
    NotFinite = 2, "not_finite" {
        cause: "a sample was NaN or infinite",
        detection: "some, not all, of the inputs needed are NaN or infinite, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "check the backend and the converter's scaling in the rig file, then reset",
    }
    Saturated = 3, "saturated" {
        cause: "an input of the converter is at the end of its range",
        detection: "a voltage or the current within 1.5 steps of the end of its range, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "if it is the current, look for a short with the power off first; else raise voltage_range_v or current_range_a in [channel.adc] to what the amplifier gives, or lower its gain, then reset",
    }
    OutOfRange = 4, "out_of_range" {
        cause: "the measured length or resistance is outside what this wire can have",
        detection: "length beyond minimum_length_mm or maximum_length_mm by more than 8 sigma of its noise, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "compare length, diameter and taps in the rig file with the wire; check for a slipped crimp, then reset",
    }
    Stuck = 5, "stuck" {
        cause: "an input of the converter repeats one code for longer than its noise allows",
        detection: "codes repeat for longer than their noise does once in 10^15 samples, all inputs weighed together, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods after the codes have repeated as often as their noise asks for: 2 to 6 samples for a whole 16 bit converter",
        remedy: "power-cycle the converter and check its clock and cable, then reset",
    }
    OpenWire = 6, "open_wire" {
        cause: "there is voltage but no current: the wire, a crimp or a lead is open",
        detection: "the current is below a fifth of the least it can be while V3 stands, or the resistance is above 1.4 times its largest, twice in a row; with a shared input: neither current nor supply",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "check wire, crimps and leads for a break with the power off, then reset",
    }
    ShortedWire = 7, "shorted_wire" {
        cause: "the resistance is far too small: the wire or part of it is bridged",
        detection: "the resistance is below 0.7 of its least by more than 8 sigma, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "look for a wire touching the frame or its neighbour with the power off, then reset",
    }
    ProbeLost = 8, "probe_lost" {
        cause: "the taps contradict each other or the wire's resistance: a tap or the sliding probe has lost contact",
        detection: "the taps' share of each other is off by 1 to 2 % and 8 sigma, or the length is beyond its range by half of that, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "clean and re-seat the probe and the taps, then reset",
    }
    SupplyDip = 9, "supply_dip" {
        cause: "the supply voltage fell below its minimum",
        detection: "the supply is below 0.8 of supply_v, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "check the supply's current limit and the leads, or drive fewer wires at once, then reset",
    }
    OverCurrent = 10, "over_current" {
        cause: "the current in the on-phase is above the channel's limit",
        detection: "the current in the on-phase is above maximum_current_a by more than 8 sigma, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "check supply_v and maximum_current_a against the wire's resistance and look for a partial short, then reset",
    }
    EnergyBudget = 11, "energy_budget" {
        cause: "more heat went into the wire than it can have given off",
        detection: "the heat taken in, less what drains at energy_drain_w in proportion to how full the account is, exceeds energy_budget_j for 2 periods; from 80 % of it on the duty is derated first",
        reaction: "channel off, latched",
        time: "1 period after the second",
        remedy: "let it cool; check that the wire moves freely and reaches its target, ask for less stroke or hold, then reset",
    }
    OverTemperature = 12, "over_temperature" {
        cause: "the estimated wire temperature is above its limit",
        detection: "the estimate from power, length and resistance is above maximum_temperature_c, or unknown, for 2 periods; from 80 % of the rise above ambient on the duty is derated first",
        reaction: "channel off, latched",
        time: "1 period after the second",
        remedy: "let it cool; check the load and maximum_temperature_c in [channel.limits], then reset",
    }
    StaleSetpoint = 13, "stale_setpoint" {
        cause: "the setpoint's lease ran out before it was renewed (in recordings up to protocol 5; since then the mode `lapsed`, no fault)",
        detection: "the lease's end has passed",
        reaction: "channel off until the next setpoint; nothing to reset",
        time: "1 period",
        remedy: "send setpoints more often than their hold time, or with a longer hold; check that the commanding program still runs",
        is_retired: true,
    }
    SetpointOutOfRange = 14, "setpoint_out_of_range" {
        cause: "a setpoint was NaN or outside the channel's limits",
        detection: "compared with the channel's limits when it is requested",
        reaction: "the command is refused, the setpoint before it stays in force",
        time: "at once",
        remedy: "ask for a value inside the limits that the refusal names, or widen [channel.limits] in the rig file",
    }
    CycleOverrun = 15, "cycle_overrun" {
        cause: "too many cycles in a row came too late to control the wires",
        detection: "late without a break for 0.25 s and 3 missed periods, one gap or many",
        reaction: "all channels off, latched",
        time: "in the first cycle that runs again; meanwhile the front-end's watchdog",
        remedy: "run `sinew doctor` for what this machine lacks, lower rate_hz, or free the processor, then reset",
    }
    Backend = 16, "backend_error" {
        cause: "the backend reported an error",
        detection: "the exchange returns an error",
        reaction: "all channels of that backend off, latched",
        time: "the backend has put out zero before it returns",
        remedy: "read the driver's log for the backend's own words, mend that, then reset or restart the driver",
    }
    Stopping = 17, "stopping" {
        cause: "the driver is stopping",
        detection: "a signal, a client's stop or the end of --duration",
        reaction: "all channels off, then the driver ends",
        time: "1 period",
        remedy: "start the driver again with `sinew run`",
    }
    DriverDied = 18, "driver_died" {
        cause: "the driver is gone without having stopped, or its loop stands still",
        detection: "clients: the process is gone, or its heartbeat stands still; the front-end: no duty within its time-out",
        reaction: "the power stage's own watchdog switches off; clients report it",
        time: "the watchdog's time-out of the front-end",
        remedy: "look why it ended (its log, `dmesg`), then start it again with `sinew run`; nothing has to be cleaned up",
    }
    ProbeStuck = 19, "probe_stuck" {
        cause: "the wire was heated or cooled so far that it must have moved, but its measured length stands still: a tap sticks to it, or the load is jammed",
        detection: "with every error of the model allowed for, the heat put in (or given off) must have moved the wire, and the filtered length stands to within 8 sigma; or the duty is derated for 1 s and the length has not moved by 5 % of the stroke since it was commanded to. With taps and a load of its own only",
        reaction: "channel off, latched",
        time: "as long as it takes until the heat proves it: 1.3 to 1.7 s where it is heated, up to 8 s where it cools",
        remedy: "see that the wire slides through its taps and the load moves freely; if it does, compare material and load in the rig file with the wire, then reset",
    }
    JointPartner = 20, "joint_partner" {
        cause: "the other wire of its joint has a fault",
        detection: "its partner is latched",
        reaction: "channel off in the same period as its partner, latched",
        time: "the same period as its partner",
        remedy: "mend and reset the other channel of the joint, then reset this one",
        follows_another: true,
    }
    Suspended = 21, "suspended" {
        cause: "the machine was suspended while it drove: nobody watched the wires, and no lease ran out, for an unknown time",
        detection: "CLOCK_BOOTTIME has gone ahead of CLOCK_MONOTONIC since the last cycle",
        reaction: "all channels off in the first cycle after it, latched",
        time: "the first cycle after it: its exchange hands over zeros",
        remedy: "keep the machine awake while it drives (`systemd-inhibit --what=sleep sinew run ...`), look at the rig, then reset",
    }
    StageOn = 22, "stage_on" {
        cause: "current flows although no duty is given: the output stage is stuck on, and its own gate cannot switch it off",
        detection: "with the gate closed the current is above a fifth of the least it can be on, in 2 looks in a row: in every period without duty, in dark periods laid where the wire moves as no commanded heat can move it; with a shared input in every off-phase",
        reaction: "all channels off, the backend's master switch off where it has one (Backend::cut), latched until the driver is started anew; takes the place of a fault that was latched before",
        time: "2 periods after the first dark look; a look is laid within 0.1 s of motion that was not commanded (0.5 s from the failure at worst)",
        remedy: "pull the supply's plug first: without a master switch the wire still heats. Replace the output stage, then start the driver anew",
        needs_restart: true,
    }
    SupplyCut = 23, "supply_cut" {
        cause: "the output stage of another channel is stuck on, so that everything on its supply was switched off",
        detection: "another channel is stage_on",
        reaction: "channel off in the same period, latched until the driver is started anew",
        time: "the same period as the channel that is stuck",
        remedy: "mend the channel that shows stage_on, then start the driver anew",
        needs_restart: true, follows_another: true,
    }
    StageWeak = 24, "stage_weak" {
        cause: "less voltage than the supply has reaches the wire: the output stage does not switch on, or only in part, or a lead is loose",
        detection: "neither current nor V3 in the on-phase, or more than a quarter of the supply stays in output stage and leads, twice in a row; with a shared input: the on-phase shows the supply like the off-phase",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "check the output stage's gate, its heat and the leads before the taps with the power off; enter leads that are this long as lead_ohm, then reset",
    }
    SupplyHigh = 25, "supply_high" {
        cause: "the supply voltage is above its maximum",
        detection: "the supply is above 1.25 of supply_v, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "check that the right supply is plugged in and supply_v in [channel.drive] says what it gives, then reset",
    }
    EmergencyStop = 26, "emergency_stop" {
        cause: "the emergency stop is open, or has not been reset since it was; a rig that has one starts so",
        detection: "its input (`[backend.estop]`) is not closed in an exchange; at the start whatever it shows",
        reaction: "zero on all channels, not even the sensing pulse; the supply off where there is a line for it; latched. No client can reset it",
        time: "2 periods for zero, 1 for the supply",
        remedy: "see that nobody is in danger, close it, press its reset button (or x at the terminal of `sinew run`), then reset the channels",
    }
}

impl Fault {
    /// The number that stands for it in messages.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// The fault with this number; `None` for 0 (no fault) and for numbers this version does not know.
    pub fn from_code(code: u32) -> Option<Fault> {
        let row = FAULT_TABLE.get((code as usize).checked_sub(1)?)?;
        Some(row.fault)
    }

    /// The fault with this flag.
    pub fn from_flag(flag: &str) -> Option<Fault> {
        FAULT_TABLE.iter().find(|row| row.flag == flag).map(|row| row.fault)
    }

    /// Its row of the table.
    pub const fn row(self) -> &'static FaultRow {
        // The codes are the table's order, which `the_table_is_in_the_order_of_its_codes` checks.
        &FAULT_TABLE[self as usize - 1]
    }

    /// Its short name.
    pub fn flag(self) -> &'static str {
        self.row().flag
    }

    /// What happened.
    pub fn cause(self) -> &'static str {
        self.row().cause
    }

    /// How it is detected.
    pub fn detection(self) -> &'static str {
        self.row().detection
    }

    /// How long the reaction takes.
    pub fn time(self) -> &'static str {
        self.row().time
    }

    /// Whether it stays until the driver is started anew, because nothing in a running one can show that it is mended.
    pub const fn needs_restart(self) -> bool {
        self.row().needs_restart
    }

    /// Whether it follows from a fault of another channel, and so is never the first.
    pub const fn follows_another(self) -> bool {
        self.row().follows_another
    }

    /// What the driver does about it.
    pub fn reaction(self) -> &'static str {
        self.row().reaction
    }

    /// What a person can do about it.
    pub fn remedy(self) -> &'static str {
        self.row().remedy
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.flag(), self.cause())
    }
}

/// The table as Markdown, as it stands in `docs/client.md`.
pub fn fault_table_markdown() -> String {
    let mut text = String::from(
        "| code | flag | cause | detected by | reaction | within | remedy |\n|---|---|---|---|---|---|---|\n",
    );
    for row in &FAULT_TABLE {
        let FaultRow { fault, flag, cause, detection, reaction, time, remedy, .. } = row;
        let code = fault.code();
        let _ = writeln!(text, "| {code} | `{flag}` | {cause} | {detection} | {reaction} | {time} | {remedy} |");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_table_is_in_the_order_of_its_codes() {
        for (index, row) in FAULT_TABLE.iter().enumerate() {
            assert_eq!(row.fault.code() as usize, index + 1, "{}", row.flag);
            assert_eq!(row.fault.row(), row);
            assert_eq!(Fault::from_code(row.fault.code()), Some(row.fault));
            assert_eq!(Fault::from_flag(row.flag), Some(row.fault));
        }
        assert_eq!(Fault::from_code(0), None);
        assert_eq!(Fault::from_code(FAULT_TABLE.len() as u32 + 1), None);
        assert_eq!(Fault::from_code(u32::MAX), None);
    }

    #[test]
    fn every_fault_has_a_name_of_its_own_and_says_what_to_do() {
        let flags: BTreeSet<_> = FAULT_TABLE.iter().map(|row| row.flag).collect();
        assert_eq!(flags.len(), FAULT_TABLE.len());
        for row in &FAULT_TABLE {
            assert!(row.flag.chars().all(|c| c.is_ascii_lowercase() || c == '_'), "{}", row.flag);
            for text in [row.cause, row.detection, row.reaction, row.time, row.remedy] {
                assert!(text.len() > 5 && !text.ends_with('.') && !text.contains('|'), "{}: {text}", row.flag);
            }
        }
    }
}
