//! Every fault of a channel or of the driver, in one table: flag, cause, reaction, remedy.
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
    /// What the driver does about it, within one period.
    pub reaction: &'static str,
    /// What a person can do about it.
    pub remedy: &'static str,
}

/// The table, in the order of the codes.
pub const FAULT_TABLE: [FaultRow; 21] = [
    FaultRow {
        fault: Fault::NoSample,
        flag: "no_sample",
        cause: "no sample has arrived from the channel's converter",
        reaction: "output stays zero until every sensor of the channel has reported; once running: channel off, latched",
        remedy: "wait a moment after the start; if it stays, check the converter's cable and its configured channel, then reset",
    },
    FaultRow {
        fault: Fault::NotFinite,
        flag: "not_finite",
        cause: "a sample was NaN or infinite",
        reaction: "channel off, latched",
        remedy: "check the backend and the converter's scaling in the rig file, then reset",
    },
    FaultRow {
        fault: Fault::Saturated,
        flag: "saturated",
        cause: "an input of the converter is at the end of its range",
        reaction: "channel off, latched",
        remedy: "if it is the current, look for a short with the power off first; else raise voltage_range_v or current_range_a in [channel.adc] to what the amplifier gives, or lower its gain, then reset",
    },
    FaultRow {
        fault: Fault::OutOfRange,
        flag: "out_of_range",
        cause: "the measured length or resistance is outside what this wire can have",
        reaction: "channel off, latched",
        remedy: "compare length, diameter and taps in the rig file with the wire; check for a slipped crimp, then reset",
    },
    FaultRow {
        fault: Fault::Stuck,
        flag: "stuck",
        cause: "an input of the converter repeats one code for longer than its noise allows",
        reaction: "channel off, latched",
        remedy: "power-cycle the converter and check its clock and cable, then reset",
    },
    FaultRow {
        fault: Fault::OpenWire,
        flag: "open_wire",
        cause: "there is voltage but no current: the wire, a crimp or a lead is open",
        reaction: "channel off, latched",
        remedy: "check wire, crimps and leads for a break with the power off, then reset",
    },
    FaultRow {
        fault: Fault::ShortedWire,
        flag: "shorted_wire",
        cause: "the resistance is far too small: the wire or part of it is bridged",
        reaction: "channel off, latched",
        remedy: "look for a wire touching the frame or its neighbour with the power off, then reset",
    },
    FaultRow {
        fault: Fault::ProbeLost,
        flag: "probe_lost",
        cause: "the taps contradict each other or the wire's resistance: a tap or the sliding probe has lost contact",
        reaction: "channel off, latched",
        remedy: "clean and re-seat the probe and the taps, then reset",
    },
    FaultRow {
        fault: Fault::SupplyDip,
        flag: "supply_dip",
        cause: "the supply voltage fell below its minimum",
        reaction: "channel off, latched",
        remedy: "check the supply's current limit and the leads, or drive fewer wires at once, then reset",
    },
    FaultRow {
        fault: Fault::OverCurrent,
        flag: "over_current",
        cause: "the current in the on-phase is above the channel's limit",
        reaction: "channel off, latched",
        remedy: "check supply_v and maximum_current_a against the wire's resistance and look for a partial short, then reset",
    },
    FaultRow {
        fault: Fault::EnergyBudget,
        flag: "energy_budget",
        cause: "more heat went into the wire than it can have given off",
        reaction: "channel off, latched",
        remedy: "let it cool; check that the wire moves freely and reaches its target, ask for less stroke or hold, then reset",
    },
    FaultRow {
        fault: Fault::OverTemperature,
        flag: "over_temperature",
        cause: "the estimated wire temperature is above its limit",
        reaction: "channel off, latched",
        remedy: "let it cool; check the load and maximum_temperature_c in [channel.limits], then reset",
    },
    FaultRow {
        fault: Fault::StaleSetpoint,
        flag: "stale_setpoint",
        cause: "the setpoint's lease ran out before it was renewed",
        reaction: "channel off until the next setpoint; nothing to reset",
        remedy: "send setpoints more often than their hold time, or with a longer hold; check that the commanding program still runs",
    },
    FaultRow {
        fault: Fault::SetpointOutOfRange,
        flag: "setpoint_out_of_range",
        cause: "a setpoint was NaN or outside the channel's limits",
        reaction: "the command is refused, the setpoint before it stays in force",
        remedy: "ask for a value inside the limits that the refusal names, or widen [channel.limits] in the rig file",
    },
    FaultRow {
        fault: Fault::CycleOverrun,
        flag: "cycle_overrun",
        cause: "too many cycles in a row came too late to control the wires",
        reaction: "all channels off, latched",
        remedy: "run `sinew doctor` for what this machine lacks, lower rate_hz, or free the processor, then reset",
    },
    FaultRow {
        fault: Fault::Backend,
        flag: "backend_error",
        cause: "the backend reported an error",
        reaction: "all channels of that backend off, latched",
        remedy: "read the driver's log for the backend's own words, mend that, then reset or restart the driver",
    },
    FaultRow {
        fault: Fault::Stopping,
        flag: "stopping",
        cause: "the driver is stopping",
        reaction: "all channels off, then the driver ends",
        remedy: "start the driver again with `sinew run`",
    },
    FaultRow {
        fault: Fault::DriverDied,
        flag: "driver_died",
        cause: "the driver is gone without having stopped, or its loop stands still",
        reaction: "the power stage's own watchdog switches off; clients are told",
        remedy: "look why it ended (its log, `dmesg`), then start it again with `sinew run`; nothing has to be cleaned up",
    },
    FaultRow {
        fault: Fault::ProbeStuck,
        flag: "probe_stuck",
        cause: "the wire was heated or cooled so far that it must have moved, but its measured length stands still: a tap sticks to it, or the load is jammed",
        reaction: "channel off, latched",
        remedy: "see that the wire slides through its taps and the load moves freely; if it does, compare material and load in the rig file with the wire, then reset",
    },
    FaultRow {
        fault: Fault::JointPartner,
        flag: "joint_partner",
        cause: "the other wire of its joint has a fault",
        reaction: "channel off in the same period as its partner, latched",
        remedy: "mend and reset the other channel of the joint, then reset this one",
    },
    FaultRow {
        fault: Fault::Suspended,
        flag: "suspended",
        cause: "the machine was suspended while it drove: nobody watched the wires, and no lease ran out, for an unknown time",
        reaction: "all channels off in the first cycle after it, latched",
        remedy: "keep the machine awake while it drives (`systemd-inhibit --what=sleep sinew run ...`), look at the rig, then reset",
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
    let mut text = String::from("| code | flag | cause | reaction | remedy |\n|---|---|---|---|---|\n");
    for row in &FAULT_TABLE {
        text +=
            &format!("| {} | `{}` | {} | {} | {} |\n", row.fault.code(), row.flag, row.cause, row.reaction, row.remedy);
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
            for text in [row.cause, row.reaction, row.remedy] {
                assert!(text.len() > 10 && !text.ends_with('.') && !text.contains('|'), "{}: {text}", row.flag);
            }
        }
    }

    #[test]
    fn the_documentation_prints_this_table() {
        let page = include_str!("../../docs/client.md");
        assert!(page.contains(&fault_table_markdown()), "put this into docs/client.md:\n{}", fault_table_markdown());
    }
}
