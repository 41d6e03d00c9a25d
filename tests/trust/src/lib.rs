//! Fault injection: tests the driver's guarantees. It injects every fault, a hundred times each at random phases,
//! measures the *output* independently of the driver's own report, and writes the table of `docs/trust.md`.
//!
//! - [`kinds`] lists the faults; [`kind`] defines one of them, and its row of the table.
//! - [`lockstep`]: engine and simulated wires on a simulated clock, compared with a reference without the fault.
//! - [`witness`]: a driver's process with an output log that outlives it.
//! - `serial` and `linux`: a driver's process and a front-end, or a simulated kernel, whose own outputs are measured.
//!
//! ```
//! // the table of docs/trust.md: every fault the driver knows has a kind that injects it
//! assert!(sinew_trust::kinds().iter().any(|kind| kind.faults.contains(&sinew_ipc::Fault::OpenWire)));
//! ```
#![forbid(unsafe_code)]

mod budgets;
pub mod burn;
pub mod clients;
mod clocks;
mod commands;
mod disk;
pub mod drive;
mod driven;
mod electrical;
pub mod failure;
pub mod kind;
mod linux;
pub mod lockstep;
mod mortal;
pub mod process;
pub mod restart;
pub mod running;
mod serial;
pub mod site;
pub mod soak;
mod stop;
pub mod table;
pub mod terminals;
pub mod witness;

use kind::Kind;

/// Every kind of fault, in the order of the table.
pub fn kinds() -> Vec<Kind> {
    let mut kinds = electrical::kinds();
    kinds.extend(stop::kinds());
    kinds.extend(budgets::kinds());
    kinds.extend(commands::kinds());
    kinds.extend(process::kinds());
    kinds.extend(terminals::kinds());
    kinds.extend(disk::kinds());
    kinds.extend(clients::kinds());
    kinds.extend(serial::kinds());
    kinds.extend(linux::kinds());
    kinds
}

#[cfg(test)]
mod tests {
    use super::*;
    use kind::Group;
    use sinew_ipc::fault::FAULT_TABLE;
    use std::collections::BTreeSet;

    #[test]
    fn every_fault_of_the_drivers_table_is_injected() {
        let shown: BTreeSet<&str> = kinds().iter().flat_map(|kind| kind.faults).map(|fault| fault.flag()).collect();
        for row in FAULT_TABLE.iter().filter(|row| !row.is_retired) {
            assert!(shown.contains(row.flag), "nobody injects {}", row.flag);
        }
    }

    #[test]
    fn every_group_has_its_faults() {
        let groups = [
            Group::Electrical,
            Group::Stop,
            Group::Budgets,
            Group::Commands,
            Group::Loop,
            Group::Process,
            Group::Clients,
            Group::Serial,
            Group::Linux,
        ];
        for group in groups {
            assert!(kinds().iter().any(|kind| kind.group == group), "nothing breaks in {group:?}");
        }
    }

    #[test]
    fn kinds_are_many_and_told_apart() {
        let kinds = kinds();
        let names: BTreeSet<&str> = kinds.iter().map(|kind| kind.name).collect();
        assert_eq!(names.len(), kinds.len());
        assert!(names.len() >= 40, "{}", names.len());
        for kind in &kinds {
            for text in [kind.injected, kind.expected, kind.lost] {
                assert!(!text.is_empty() && !text.contains('|'), "{}: {text:?}", kind.name);
            }
        }
    }
}
