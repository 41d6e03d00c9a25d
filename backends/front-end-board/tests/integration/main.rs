//! The noise budget of the board holds, and its page says what it comes to, and has its pins.

#[path = "../../examples/common/budget.rs"]
#[allow(dead_code, reason = "the example prints what is not judged here")]
mod budget;
mod netlist;

use budget::{CANDIDATES, RATE_HZ, SENSING_DUTY, WANTED_M, current_a, rows, shunt_noise_v, sigma_m, total_v};
use sinew_front_end_board::{LEAD_NS, MIN_ON_NS, SHUNT_OHM, nucleo, pico};

const PAGE: &str = include_str!("../../../../docs/board.md");

#[test]
fn a_sample_s_length_is_good_to_a_tenth_of_a_millimetre() {
    let current_a = current_a(SHUNT_OHM, 0.05);
    let rows = rows();
    let (board, all) = (sigma_m(total_v(&rows[..4]), current_a), sigma_m(total_v(&rows), current_a));
    assert!(board < WANTED_M / 5.0, "the board alone: {board}");
    assert!(all < WANTED_M, "with the taps: {all}");
    for (row, sigma) in rows.iter().map(|row| (row.cause, sigma_m(row.noise_v, current_a))) {
        let cell = format!("| {:.2} |", sigma * 1e6);
        assert!(PAGE.lines().any(|line| line.contains(row) && line.ends_with(&cell)), "docs/board.md: {row} {cell}");
    }
    for total in [format!("| {:.2} |", board * 1e6), format!("| {:.2} |", all * 1e6)] {
        assert!(PAGE.contains(&total), "docs/board.md lacks {total}");
    }
    let milliamperes = format!("{:.2} mA", shunt_noise_v() / SHUNT_OHM * 1e3);
    assert!(PAGE.contains(&milliamperes), "docs/board.md lacks {milliamperes}");
}

#[test]
fn the_converter_that_was_chosen_is_the_one_that_can() {
    let current_a = current_a(SHUNT_OHM, 0.05);
    let seen_s = SENSING_DUTY / RATE_HZ - f64::from(LEAD_NS) * 1e-9;
    let [own, multiplexed, chosen] = CANDIDATES;
    assert!(sigma_m(own.sigma_v(), current_a) > WANTED_M, "the RP2040's own is too coarse");
    assert!(sigma_m(multiplexed.sigma_v(), current_a) < WANTED_M);
    assert!(multiplexed.missing(seen_s) > 0.1, "the sensing pulse is over before its filter has settled");
    assert!(sigma_m(chosen.sigma_v(), current_a) < WANTED_M);
    assert!(chosen.missing(seen_s) < 1e-3);
    // What is missing at the shortest on-phase is as `MIN_ON_NS` says.
    assert!(chosen.missing(f64::from(MIN_ON_NS - LEAD_NS) * 1e-9) < 8e-3);
    for candidate in CANDIDATES {
        let sigma = format!("| {:.1} |", sigma_m(candidate.sigma_v(), current_a) * 1e6);
        assert!(PAGE.lines().any(|line| line.starts_with(&format!("| {} |", candidate.name)) && line.contains(&sigma)));
        assert!(PAGE.contains(candidate.source), "docs/board.md names the source: {}", candidate.source);
    }
}

#[test]
fn no_pin_is_used_twice_and_the_page_has_them_all() {
    for (index, (pin, name, held)) in pico::TABLE.iter().enumerate() {
        assert!(pico::TABLE[..index].iter().all(|(other, ..)| other != pin), "GP{pin} twice");
        let row = format!("| GP{pin} | {name} | {held} |");
        assert!(PAGE.contains(&row), "docs/board.md lacks the row {row:?}");
    }
    assert_eq!(PAGE.lines().filter(|line| line.starts_with("| GP")).count(), pico::TABLE.len());
}

#[test]
fn the_second_board_has_the_first_one_s_signals_on_pins_of_its_own() {
    for (index, (pin, name, held)) in nucleo::TABLE.iter().enumerate() {
        assert!(nucleo::TABLE[..index].iter().all(|(other, ..)| other != pin), "{pin} twice");
        let function = pin.function.map_or(String::new(), |function| format!(", AF{function}"));
        let row = format!("| {pin}{function} | {name} | {held} |");
        assert!(PAGE.contains(&row), "docs/board.md lacks the row {row:?}");
    }
    let of_the_page =
        PAGE.lines().filter(|line| ["| PA", "| PB", "| PC"].iter().any(|port| line.starts_with(port))).count();
    assert_eq!(of_the_page, nucleo::TABLE.len());
    // The circuit is drawn once: its nets by these names. Only the emergency stop, which is a break input, is held otherwise.
    for (pin, name, held) in pico::TABLE {
        let same = nucleo::TABLE.iter().find(|(_, other, _)| *other == name).unwrap_or_else(|| panic!("no {name}"));
        assert!(same.2 == held || pin == pico::STOP, "{name}: {} and {held}", same.2);
    }
}
