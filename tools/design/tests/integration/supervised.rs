//! A design is one that the driver does not hold back, and one that it would hold back is said to be none.

use sinew_backend::Backend;
use sinew_design::{Cycle, Design, HeldBack, Motion, Requirement, Source, Task, predict};
use sinew_driver::Ask;
use sinew_ipc::ChannelState;
use sinew_lockstep::Lockstep;

/// What the supervisor holds back by.
const BUDGETS: u32 = ChannelState::FLAG_HEAT_BUDGET | ChannelState::FLAG_TEMPERATURE_BUDGET;
/// Periods after which a wire that is held back is not waited for any more.
const MOST_PERIODS: u64 = 30_000;

/// What held it back of all that the driver may, and times and temperatures of the last of some cycles, open loop, at the most duty
/// there is.
fn driven(design: &Design, cycles: u32) -> (u32, Cycle) {
    let rig = design.rig().unwrap();
    let task = Task::new(&rig, design.sizing.wire.stroke_m()).unwrap();
    let length_m = rig.nominal_model(0).geometry.length_m;
    let mut bench = Lockstep::new(&rig, None).unwrap();
    bench.run_s(0.5);
    let mut held_back = 0;
    let mut cycle = Cycle { pull_n: 0.0, heating_s: 0.0, cooling_s: 0.0, first_s: 0.0, hottest_c: 0.0, power_w: 0.0 };
    let mut until = |bench: &mut Lockstep, cycle: &mut Cycle, ask: Ask, there: &dyn Fn(f64) -> bool| {
        bench.ask(0, ask);
        let from = bench.period();
        // the true wire, not what is measured of it
        while !there(bench.wires().truth(0).unwrap().length_m) {
            bench.step();
            held_back |= bench.state(0).flags;
            cycle.hottest_c = cycle.hottest_c.max(bench.wires().truth(0).unwrap().temperature_c);
            if bench.period() - from > MOST_PERIODS {
                assert!(held_back & BUDGETS != 0, "it does not get there, and nothing holds it back");
                return f64::INFINITY;
            }
        }
        (bench.period() - from) as f64 / rig.rate_hz
    };
    for _ in 0..cycles {
        cycle.hottest_c = 0.0;
        cycle.heating_s = until(&mut bench, &mut cycle, Ask::Duty(task.on_duty), &|at| at <= length_m + task.short_m);
        cycle.cooling_s = until(&mut bench, &mut cycle, Ask::Off, &|at| at >= length_m + task.long_m);
    }
    assert!(bench.trips().is_empty(), "{:?}", bench.trips());
    assert!(cycle.hottest_c < task.budgets.temperature_c, "{cycle:?}");
    (held_back & BUDGETS, cycle)
}

fn lift(force_n: f64, stroke_m: f64, supply_v: Option<f64>) -> Requirement {
    let motion = Motion::Linear { force_n, stroke_m };
    Requirement { source: Source::of_voltage(supply_v), ..Requirement::of(motion) }
}

#[test]
fn the_driver_does_with_a_design_what_is_predicted() {
    for (asked, diameter_m) in [
        (lift(0.6, 6e-3, None), 0.125e-3),
        (lift(0.2, 4e-3, Some(5.0)), 0.076e-3),
        (lift(2.0, 6e-3, Some(6.0)), 0.2e-3),
        (lift(10.0, 8e-3, None), 0.38e-3),
    ] {
        let design = Design::of(&asked, diameter_m);
        assert_eq!(design.shortfall, None, "{diameter_m}");
        let said = design.prediction.unwrap().cycle;
        let (held_back, done) = driven(&design, 4);
        assert_eq!(held_back, 0, "{diameter_m}: the supervisor held it back");
        for (predicted, driven) in [(said.heating_s, done.heating_s), (said.cooling_s, done.cooling_s)] {
            assert!((predicted / driven - 1.0).abs() < 0.1, "{diameter_m}: {said:?} {done:?}");
        }
        assert!((said.hottest_c - done.hottest_c).abs() < 5.0, "{diameter_m}: {said:?} {done:?}");
    }
}

/// Whether a wire moves on and on without being held back is said rightly, whatever its account drains, and wherever its temperature ends.
#[test]
fn what_the_supervisor_holds_back_is_said() {
    let design = Design::of(&lift(0.6, 6e-3, None), 0.125e-3);
    let mean_w = design.prediction.unwrap().cycle.power_w;
    let drains = [0.4, 0.6, 0.9, 1.3].map(|filled| format!("energy_drain_w = {}", mean_w / filled));
    let limits = [130.0, 140.0, 160.0, 180.0].map(|celsius| format!("maximum_temperature_c = {celsius:.1}"));
    let mut said = Vec::new();
    for limit in drains.iter().chain(&limits) {
        let text = format!("{}limits = {{ {limit} }}\n", design.rig_text);
        let rig = sinew_rig::Rig::parse(&text, "limited").unwrap_or_else(|error| panic!("{error}"));
        let held_back = predict(&rig, design.sizing.wire.stroke_m()).unwrap().held_back;
        let (flags, _) = driven(&Design { rig_text: text, ..design.clone() }, 8);
        let flag = match held_back {
            None => 0,
            Some(HeldBack::Heat) => ChannelState::FLAG_HEAT_BUDGET,
            Some(HeldBack::Temperature) => ChannelState::FLAG_TEMPERATURE_BUDGET,
        };
        assert_eq!(flags, flag, "{limit}: {held_back:?}");
        said.push(held_back);
    }
    assert!(said.contains(&None) && said.contains(&Some(HeldBack::Heat)), "{said:?}");
    assert!(said.contains(&Some(HeldBack::Temperature)), "{said:?}");
}

/// The load that is written is damped lightly; the driver's default law holds it all the same.
#[test]
fn the_drivers_law_holds_a_designed_wire() {
    for (asked, diameter_m) in
        [(lift(0.2, 4e-3, Some(5.0)), 0.076e-3), (lift(0.6, 6e-3, None), 0.125e-3), (lift(10.0, 8e-3, None), 0.38e-3)]
    {
        let design = Design::of(&asked, diameter_m);
        let mut bench = Lockstep::new(&design.rig().unwrap(), None).unwrap();
        bench.run_s(0.5);
        let cycle_s = design.prediction.unwrap().cycle.cycle_s();
        for stroke in [0.3, 0.7, 0.5] {
            bench.move_to(0, stroke);
            bench.run_s(3.0 * cycle_s);
            let off_m = (bench.wires().truth(0).unwrap().length_m - bench.state(0).target_m).abs();
            assert!(off_m < 0.02 * design.sizing.wire.stroke_m(), "{diameter_m}: {off_m} m off at {stroke}");
        }
        assert!(bench.trips().is_empty(), "{:?}", bench.trips());
    }
}
