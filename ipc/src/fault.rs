//! Every fault of a channel or of the driver, in one table: flag, cause, detection, reaction, time, remedy.
//!
//! The driver's supervisor latches by it, the monitor and the client's error texts quote it, and the documentation prints
//! it ([`fault_table_markdown`]). Nothing else in the project explains a fault.

use std::fmt;

/// Why a channel is, or the whole driver went, without power. The number travels in messages; 0 there means "no fault".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u32)]
pub enum Fault {
    /// No sample has come from this channel (yet).
    NoSample = 1,
    /// A sample is NaN or infinite.
    NotFinite = 2,
    /// An input of the converter is at the end of its range.
    Saturated = 3,
    /// A sample is finite but impossible for this wire.
    OutOfRange = 4,
    /// An input of the converter repeats one code.
    Stuck = 5,
    /// Voltage but no current.
    OpenWire = 6,
    /// Current but far too little resistance.
    ShortedWire = 7,
    /// A tap or the sliding probe has lost contact.
    ProbeLost = 8,
    /// The supply fell below its minimum.
    SupplyDip = 9,
    /// More current in the on-phase than the wire or its switch may carry.
    OverCurrent = 10,
    /// More heat went into the wire than it can have given off.
    EnergyBudget = 11,
    /// The estimated wire temperature is above its limit.
    OverTemperature = 12,
    /// The setpoint's lease ran out.
    StaleSetpoint = 13,
    /// A setpoint outside the channel's limits was asked for.
    SetpointOutOfRange = 14,
    /// Too many cycles in a row came too late.
    CycleOverrun = 15,
    /// The backend reported an error.
    Backend = 16,
    /// The driver is stopping.
    Stopping = 17,
    /// The driver is gone without having stopped.
    DriverDied = 18,
    /// The length stands still though heat must have moved the wire.
    ProbeStuck = 19,
    /// The other wire of its joint has a fault.
    JointPartner = 20,
    /// The machine slept while it drove.
    Suspended = 21,
    /// The output stage conducts although it is given no duty.
    StageOn = 22,
    /// The supply was cut off, because another channel's output stage cannot be switched off.
    SupplyCut = 23,
    /// The output stage does not conduct, or badly.
    StageWeak = 24,
    /// The supply rose above its maximum.
    SupplyHigh = 25,
}

/// What there is to know about one fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultRow {
    /// The fault.
    pub fault: Fault,
    /// Its short name in reports, `status --json` and the monitor.
    pub flag: &'static str,
    /// What happened, as the end of "channel x is off because …".
    pub cause: &'static str,
    /// By what it is told.
    pub detection: &'static str,
    /// What the driver does about it.
    pub reaction: &'static str,
    /// How long it takes from the first evidence until the reaction has put out its duty.
    pub time: &'static str,
    /// What a person can do about it.
    pub remedy: &'static str,
}

/// The table, in the order of the codes.
pub const FAULT_TABLE: [FaultRow; 25] = [
    FaultRow {
        fault: Fault::NoSample,
        flag: "no_sample",
        cause: "no sample has arrived from the channel's converter",
        detection: "every input that is needed is NaN where duty was given, twice in a row; after the start or a reset: no proof of health within 1 s (and 32 periods)",
        reaction: "output stays zero until every sensor of the channel has reported; once running: channel off, latched",
        time: "2 periods",
        remedy: "wait a moment after the start; if it stays, check the converter's cable and its configured channel, then reset",
    },
    FaultRow {
        fault: Fault::NotFinite,
        flag: "not_finite",
        cause: "a sample was NaN or infinite",
        detection: "some, not all, of the inputs needed are NaN or infinite, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "check the backend and the converter's scaling in the rig file, then reset",
    },
    FaultRow {
        fault: Fault::Saturated,
        flag: "saturated",
        cause: "an input of the converter is at the end of its range",
        detection: "a voltage or the current within 1.5 steps of the end of its range, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "if it is the current, look for a short with the power off first; else raise voltage_range_v or current_range_a in [channel.adc] to what the amplifier gives, or lower its gain, then reset",
    },
    FaultRow {
        fault: Fault::OutOfRange,
        flag: "out_of_range",
        cause: "the measured length or resistance is outside what this wire can have",
        detection: "length beyond minimum_length_mm or maximum_length_mm by more than 8 sigma of its noise, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "compare length, diameter and taps in the rig file with the wire; check for a slipped crimp, then reset",
    },
    FaultRow {
        fault: Fault::Stuck,
        flag: "stuck",
        cause: "an input of the converter repeats one code for longer than its noise allows",
        detection: "codes repeat for longer than their noise does once in 10^15 samples, all inputs weighed together, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods after the codes have repeated as often as their noise asks for: 2 to 6 samples for a whole 16 bit converter",
        remedy: "power-cycle the converter and check its clock and cable, then reset",
    },
    FaultRow {
        fault: Fault::OpenWire,
        flag: "open_wire",
        cause: "there is voltage but no current: the wire, a crimp or a lead is open",
        detection: "the current is below a fifth of the least it can be while V3 stands, or the resistance is above 1.4 times its largest, twice in a row; with a shared input: neither current nor supply",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "check wire, crimps and leads for a break with the power off, then reset",
    },
    FaultRow {
        fault: Fault::ShortedWire,
        flag: "shorted_wire",
        cause: "the resistance is far too small: the wire or part of it is bridged",
        detection: "the resistance is below 0.7 of its least by more than 8 sigma, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "look for a wire touching the frame or its neighbour with the power off, then reset",
    },
    FaultRow {
        fault: Fault::ProbeLost,
        flag: "probe_lost",
        cause: "the taps contradict each other or the wire's resistance: a tap or the sliding probe has lost contact",
        detection: "the taps' share of each other is off by 1 to 2 % and 8 sigma, or the length is beyond its range by half of that, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "clean and re-seat the probe and the taps, then reset",
    },
    FaultRow {
        fault: Fault::SupplyDip,
        flag: "supply_dip",
        cause: "the supply voltage fell below its minimum",
        detection: "the supply is below 0.8 of supply_v, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "check the supply's current limit and the leads, or drive fewer wires at once, then reset",
    },
    FaultRow {
        fault: Fault::OverCurrent,
        flag: "over_current",
        cause: "the current in the on-phase is above the channel's limit",
        detection: "the current in the on-phase is above maximum_current_a by more than 8 sigma, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "check supply_v and maximum_current_a against the wire's resistance and look for a partial short, then reset",
    },
    FaultRow {
        fault: Fault::EnergyBudget,
        flag: "energy_budget",
        cause: "more heat went into the wire than it can have given off",
        detection: "the heat taken in, less what drains at energy_drain_w in proportion to how full the account is, exceeds energy_budget_j for 2 periods; from 80 % of it on the duty is derated first",
        reaction: "channel off, latched",
        time: "1 period after the second",
        remedy: "let it cool; check that the wire moves freely and reaches its target, ask for less stroke or hold, then reset",
    },
    FaultRow {
        fault: Fault::OverTemperature,
        flag: "over_temperature",
        cause: "the estimated wire temperature is above its limit",
        detection: "the estimate from power, length and resistance is above maximum_temperature_c, or unknown, for 2 periods; from 80 % of the rise above ambient on the duty is derated first",
        reaction: "channel off, latched",
        time: "1 period after the second",
        remedy: "let it cool; check the load and maximum_temperature_c in [channel.limits], then reset",
    },
    FaultRow {
        fault: Fault::StaleSetpoint,
        flag: "stale_setpoint",
        cause: "the setpoint's lease ran out before it was renewed",
        detection: "the lease's end has passed",
        reaction: "channel off until the next setpoint; nothing to reset",
        time: "1 period",
        remedy: "send setpoints more often than their hold time, or with a longer hold; check that the commanding program still runs",
    },
    FaultRow {
        fault: Fault::SetpointOutOfRange,
        flag: "setpoint_out_of_range",
        cause: "a setpoint was NaN or outside the channel's limits",
        detection: "compared with the channel's limits when it is asked for",
        reaction: "the command is refused, the setpoint before it stays in force",
        time: "at once",
        remedy: "ask for a value inside the limits that the refusal names, or widen [channel.limits] in the rig file",
    },
    FaultRow {
        fault: Fault::CycleOverrun,
        flag: "cycle_overrun",
        cause: "too many cycles in a row came too late to control the wires",
        detection: "late without a break for 0.25 s and 3 missed periods, one gap or many",
        reaction: "all channels off, latched",
        time: "in the first cycle that runs again; meanwhile the front-end's watchdog",
        remedy: "run `sinew doctor` for what this machine lacks, lower rate_hz, or free the processor, then reset",
    },
    FaultRow {
        fault: Fault::Backend,
        flag: "backend_error",
        cause: "the backend reported an error",
        detection: "the exchange returns an error",
        reaction: "all channels of that backend off, latched",
        time: "the backend has put out zero before it returns",
        remedy: "read the driver's log for the backend's own words, mend that, then reset or restart the driver",
    },
    FaultRow {
        fault: Fault::Stopping,
        flag: "stopping",
        cause: "the driver is stopping",
        detection: "a signal, a client's stop or the end of --duration",
        reaction: "all channels off, then the driver ends",
        time: "1 period",
        remedy: "start the driver again with `sinew run`",
    },
    FaultRow {
        fault: Fault::DriverDied,
        flag: "driver_died",
        cause: "the driver is gone without having stopped, or its loop stands still",
        detection: "clients: the process is gone, or its heartbeat stands still; the front-end: no duty within its time-out",
        reaction: "the power stage's own watchdog switches off; clients are told",
        time: "the watchdog's time-out of the front-end",
        remedy: "look why it ended (its log, `dmesg`), then start it again with `sinew run`; nothing has to be cleaned up",
    },
    FaultRow {
        fault: Fault::ProbeStuck,
        flag: "probe_stuck",
        cause: "the wire was heated or cooled so far that it must have moved, but its measured length stands still: a tap sticks to it, or the load is jammed",
        detection: "with every error of the model allowed for, the heat put in (or given off) must have moved the wire, and the filtered length stands to within 8 sigma; or the duty is derated for 1 s and the length has not moved by 5 % of the stroke since it was told to. With taps and a load of its own only",
        reaction: "channel off, latched",
        time: "as long as it takes until the heat proves it: 1.3 to 1.7 s where it is heated, up to 8 s where it cools",
        remedy: "see that the wire slides through its taps and the load moves freely; if it does, compare material and load in the rig file with the wire, then reset",
    },
    FaultRow {
        fault: Fault::JointPartner,
        flag: "joint_partner",
        cause: "the other wire of its joint has a fault",
        detection: "its partner is latched",
        reaction: "channel off in the same period as its partner, latched",
        time: "the same period as its partner",
        remedy: "mend and reset the other channel of the joint, then reset this one",
    },
    FaultRow {
        fault: Fault::Suspended,
        flag: "suspended",
        cause: "the machine was suspended while it drove: nobody watched the wires, and no lease ran out, for an unknown time",
        detection: "CLOCK_BOOTTIME has gone ahead of CLOCK_MONOTONIC since the last cycle",
        reaction: "all channels off in the first cycle after it, latched",
        time: "the first cycle after it: its exchange hands over zeros",
        remedy: "keep the machine awake while it drives (`systemd-inhibit --what=sleep sinew run ...`), look at the rig, then reset",
    },
    FaultRow {
        fault: Fault::StageOn,
        flag: "stage_on",
        cause: "current flows although no duty is given: the output stage is stuck on, and its own gate cannot switch it off",
        detection: "with the gate closed the current is above a fifth of the least it can be on, in 2 looks in a row: in every period without duty, in dark periods laid where the wire moves as no heat that was asked for can move it; with a shared input in every off-phase",
        reaction: "all channels off, the backend's master switch off where it has one (Backend::cut), latched until the driver is started anew; takes the place of a fault that was latched before",
        time: "2 periods after the first dark look; a look is laid within 0.1 s of motion that was not asked for (0.5 s from the failure at worst)",
        remedy: "pull the supply's plug first: without a master switch the wire still heats. Replace the output stage, then start the driver anew",
    },
    FaultRow {
        fault: Fault::SupplyCut,
        flag: "supply_cut",
        cause: "the output stage of another channel is stuck on, so that everything on its supply was switched off",
        detection: "another channel is stage_on",
        reaction: "channel off in the same period, latched until the driver is started anew",
        time: "the same period as the channel that is stuck",
        remedy: "mend the channel that shows stage_on, then start the driver anew",
    },
    FaultRow {
        fault: Fault::StageWeak,
        flag: "stage_weak",
        cause: "less voltage than the supply has reaches the wire: the output stage does not switch on, or only in part, or a lead is loose",
        detection: "neither current nor V3 in the on-phase, or more than a quarter of the supply stays in output stage and leads, twice in a row; with a shared input: the on-phase shows the supply like the off-phase",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "check the output stage's gate, its heat and the leads before the taps with the power off; enter leads that are this long as lead_ohm, then reset",
    },
    FaultRow {
        fault: Fault::SupplyHigh,
        flag: "supply_high",
        cause: "the supply voltage is above its maximum",
        detection: "the supply is above 1.25 of supply_v, twice in a row",
        reaction: "channel off, latched",
        time: "2 periods",
        remedy: "check that the right supply is plugged in and supply_v in [channel.drive] says what it gives, then reset",
    },
];

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
    pub fn row(self) -> &'static FaultRow {
        // The codes are the table's order, which `the_table_is_in_the_order_of_its_codes` checks.
        &FAULT_TABLE[self.code() as usize - 1]
    }

    /// Its short name.
    pub fn flag(self) -> &'static str {
        self.row().flag
    }

    /// What happened.
    pub fn cause(self) -> &'static str {
        self.row().cause
    }

    /// By what it is told.
    pub fn detection(self) -> &'static str {
        self.row().detection
    }

    /// How long the reaction takes.
    pub fn time(self) -> &'static str {
        self.row().time
    }

    /// Whether it stays until the driver is started anew, because nothing in a running one can show that it is mended.
    pub const fn needs_restart(self) -> bool {
        matches!(self, Fault::StageOn | Fault::SupplyCut)
    }

    /// Whether it follows from a fault of another channel, and so is never the first.
    pub const fn follows_another(self) -> bool {
        matches!(self, Fault::JointPartner | Fault::SupplyCut)
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
    let mut text =
        String::from("| code | flag | cause | told by | reaction | within | remedy |\n|---|---|---|---|---|---|---|\n");
    for row in &FAULT_TABLE {
        let FaultRow { fault, flag, cause, detection, reaction, time, remedy } = row;
        let code = fault.code();
        text += &format!("| {code} | `{flag}` | {cause} | {detection} | {reaction} | {time} | {remedy} |\n");
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

    #[test]
    fn the_documentation_prints_this_table() {
        let page = include_str!("../../docs/client.md");
        assert!(page.contains(&fault_table_markdown()), "put this into docs/client.md:\n{}", fault_table_markdown());
    }
}
