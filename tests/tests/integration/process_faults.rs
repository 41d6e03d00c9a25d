//! Each fault of the driver's process, of the machine under it and of its clients, once or twice, by the machine that measures them
//! a hundred times (`sinew-trust`). What was promised has to be kept; how fast it is measured there, and only quoted in `docs/trust.md`.

use sinew_trust::failure::Failure;
use sinew_trust::kind::{Group, Kind, Unit};
use sinew_trust::site::Site;

/// Carries out each of these, and says which promise was broken.
fn hold(wanted: impl Fn(&Kind) -> bool, tries: usize) {
    let site = Site::new().unwrap().with_sinew(sinew_tests::sinew()).with_itself(sinew_tests::trust());
    let mut broken = String::new();
    for mut kind in sinew_trust::kinds().into_iter().filter(wanted) {
        // Busy machines are late; nobody's wire depends on that here.
        if kind.unit == Unit::Milliseconds {
            kind.within = 10_000.0;
        }
        let row = kind.measure(&site, tries, 3);
        match row.measured.remark {
            Some(why) if row.measured.tries == 0 && why.contains(&Failure::Impossible(String::new()).to_string()) => {
                println!("{}: {why}", row.name);
            }
            _ if row.measured.kept => {}
            remark => broken += &format!("{}: {}\n", row.name, remark.unwrap_or_default()),
        }
    }
    assert!(broken.is_empty(), "{broken}");
}

#[test]
fn a_driver_that_dies_stops_hangs_or_sleeps_leaves_no_wire_heated() {
    hold(|kind| kind.group == Group::Process && kind.name != "cpu_starved", 1);
}

#[test]
fn a_loop_that_is_let_down_leaves_no_wire_heated() {
    hold(|kind| kind.group == Group::Loop, 1);
}

#[test]
fn clients_cost_nobody_else_anything() {
    hold(|kind| kind.group == Group::Clients && kind.name != "crowd", 2);
}

#[test]
fn what_breaks_on_the_simulated_clock_is_off_in_time() {
    hold(|kind| matches!(kind.group, Group::Electrical | Group::Budgets | Group::Commands), 3);
}

#[test]
fn a_guard_or_a_kernel_that_lets_the_driver_down_leaves_no_wire_heated() {
    hold(|kind| kind.group == Group::Linux, 1);
}
