//! The rules of chapter 2, as printed.

use proptest::prelude::*;
use sinew_design::*;

fn lift(force_n: f64, stroke_m: f64) -> Requirement {
    Requirement::of(Motion::Linear { force_n, stroke_m })
}

fn turn(torque_n_m: f64, angle_rad: f64, joint: Option<Joint>) -> Requirement {
    Requirement { span_m: Some(0.2), ..Requirement::of(Motion::Rotary { torque_n_m, angle_rad, joint }) }
}

/// Method B of the thesis: D ≥ √(F/55 n) and L ≥ δ/0.04.
#[test]
fn follows_method_b() {
    for s in sizings(&lift(3.4, 6.4e-3), &STOCK_DIAMETERS_M) {
        let d = s.wire.diameter_m * 1e3;
        assert!(d >= (3.4 / (55.1 * f64::from(s.wires))).sqrt(), "{s:?}");
        assert!((s.wire.length_m - 0.16).abs() < 1e-12);
    }
    let all = designs(&lift(3.4, 6.4e-3), &STOCK_DIAMETERS_M);
    let best = best(&all).unwrap().sizing;
    assert_eq!((best.wires, best.wire.diameter_m), (1, 0.25e-3));
}

/// Method A: L = E/(2.2 D²) in one wire, or in as many as the room takes, and a lever or radius for the rest.
#[test]
fn follows_method_a() {
    let by_energy = Requirement { method: Some(Method::Energy), ..lift(3.4, 20e-3) };
    for s in sizings(&by_energy, &STOCK_DIAMETERS_M) {
        let d = s.wire.diameter_m * 1e3;
        assert!((s.wire.length_m * 1e3 / (3.4 * 20.0 / (2.2 * d * d)) - 1.0).abs() < 0.01, "{s:?}");
        assert!(s.wires == 1 && (s.lever * s.wire.stroke_m() - 20e-3).abs() < 1e-12);
    }
    let short = Requirement { span_m: Some(0.1), ..by_energy };
    for (s, one) in sizings(&short, &STOCK_DIAMETERS_M).iter().zip(sizings(&by_energy, &STOCK_DIAMETERS_M)) {
        assert_eq!(f64::from(s.wires), (one.wire.length_m / 0.1 * (1.0 - 1e-9)).ceil().min(1000.0), "{s:?}");
    }
    let motion = Motion::Rotary { torque_n_m: 0.02, angle_rad: 1.0, joint: Some(Joint::Pulley) };
    for s in sizings(&Requirement::of(motion), &STOCK_DIAMETERS_M) {
        assert!((s.radius_m.unwrap() / (0.04 * s.wire.length_m) - 1.0).abs() < 1e-12 && s.wires == 1, "{s:?}");
    }
}

/// Speed first, by cooling, then as many wires as it takes.
#[test]
fn a_fast_motion_takes_many_thin_wires() {
    let all = designs(&Requirement { cycle_s: Some(1.8), ..lift(3.4, 6.4e-3) }, &STOCK_DIAMETERS_M);
    let best = best(&all).unwrap();
    assert!(best.sizing.wires > 1 && best.prediction.unwrap().cycle.cycle_s() <= 1.8, "{best:?}");
    assert!(all.iter().any(|design| matches!(design.shortfall, Some(Shortfall::TooSlow(_)))));
}

/// A lever trades force for stroke, and loses nothing: the work stays.
#[test]
fn a_short_span_gets_a_lever_unless_the_method_has_none() {
    let cramped = Requirement { span_m: Some(0.08), ..lift(1.0, 6.4e-3) };
    for s in sizings(&cramped, &STOCK_DIAMETERS_M) {
        assert!((s.lever - 2.0).abs() < 1e-12 && s.wire.length_m == 0.08 && s.lack.is_none());
        assert!((f64::from(s.wires) * s.useful_n * s.wire.stroke_m() - 6.4e-3).abs() < 1e-12, "{s:?}");
    }
    for s in sizings(&Requirement { method: Some(Method::Stroke), ..cramped }, &STOCK_DIAMETERS_M) {
        assert_eq!(s.lack, Some(Lack::Strain(0.04 * 0.08)));
    }
}

/// A pulley has the whole torque at every angle, a lever less at both ends, for which the wires make up; neither does more work
/// than its wires.
#[test]
fn a_joint_gets_a_radius() {
    for s in sizings(&turn(0.02, 1.0, Some(Joint::Pulley)), &STOCK_DIAMETERS_M) {
        assert!((s.radius_m.unwrap() - 8e-3).abs() < 1e-12);
        assert!((f64::from(s.wires) * s.useful_n - 2.5).abs() < 1e-9);
        let tight = 8e-3 < s.wire.bend_radius_m();
        assert_eq!(s.lack, tight.then(|| Lack::Radius(s.wire.bend_radius_m())));
    }
    for s in sizings(&turn(0.02, 1.0, Some(Joint::Lever)), &STOCK_DIAMETERS_M) {
        let radius_m = s.radius_m.unwrap();
        assert!((2.0 * radius_m * 0.5f64.sin() - 8e-3).abs() < 1e-12, "the ends are the stroke apart");
        assert!((f64::from(s.wires) * s.useful_n * radius_m * 0.5f64.cos() - 0.02).abs() < 1e-12);
    }
    let either = sizings(&turn(0.02, 1.0, None), &STOCK_DIAMETERS_M);
    assert!(either.iter().all(|s| s.lack.is_none()), "what is too tight to wind gets a lever");
    let far = sizings(&turn(0.02, 2.5, Some(Joint::Lever)), &STOCK_DIAMETERS_M);
    assert!(far.iter().all(|s| s.lack == Some(Lack::Angle(MOST_LEVER_RAD))));
}

/// Pulleys give as much wire as they have passes, a tube as much as is wanted; both cost force twice, and beyond a limit all of it.
#[test]
fn a_route_gives_length_for_force() {
    let asked = Requirement { span_m: Some(0.05), ..lift(1.0, 10e-3) };
    let through = |route| Design::of(&Requirement { route, ..asked }, 0.15e-3);
    let (straight, pulleys) = (through(Route::Straight), through(Route::Pulleys(5)));
    assert!((straight.sizing.lever - 5.0).abs() < 1e-9 && (pulleys.sizing.lever - 1.0).abs() < 1e-9);
    let kept = 0.97f64.powi(4);
    assert_eq!(
        f64::from(pulleys.sizing.wires),
        (1.0 / (kept * 170.0 - 100.0 / kept) / pulleys.sizing.wire.area_m2() / 1e6).ceil()
    );
    let tube = through(Route::Tube { bent_rad: 2.0, friction: 0.05 });
    assert_eq!(tube.sizing.wire.length_m, 0.25);
    let bare = Design::of(&lift(1.0, 10e-3), 0.15e-3);
    let cooling_s = |design: &Design| design.prediction.unwrap().cycle.cooling_s;
    assert!(cooling_s(&tube) < 0.7 * cooling_s(&bare), "{tube:?}");
    let Some(Shortfall::Lack(Lack::Friction(most_rad))) =
        through(Route::Tube { bent_rad: 7.0, friction: 0.05 }).shortfall
    else {
        panic!("a tube that is bent by more than a turn moves nothing")
    };
    assert!(through(Route::Tube { bent_rad: 0.98 * most_rad, friction: 0.05 }).sizing.lack.is_none());
}

/// Wires in series share the voltage, rows of them add their currents, and rows are filled.
#[test]
fn the_way_of_the_current_suits_the_supply() {
    let asked = Requirement { source: Source::of_voltage(Some(24.0)), ..lift(6.0, 6e-3) };
    for s in sizings(&asked, &STOCK_DIAMETERS_M) {
        assert_eq!(s.path.wires(), s.wires);
        assert!((s.wire_v() * f64::from(s.path.in_series) - 24.0).abs() < 1e-9, "{s:?}");
        assert!((s.source_a() - 24.0 / s.path.resistance_ohm(&s.wire)).abs() < 1e-9);
    }
    let of_150 = Sizing::of(&asked, 0.15e-3);
    assert!(of_150.path.in_series > 1, "24 V are too much for one wire of 150 mm: {of_150:?}");
    let limited = Source { most_current_a: Some(1.0), ..asked.source };
    let few_amps = Sizing::of(&Requirement { source: limited, ..asked }, 0.15e-3);
    assert!(few_amps.source_a() <= 1.0, "{few_amps:?}");
    // a current source drives its current through the rows, whatever voltage that takes, up to what it has
    let source = Source { current_a: Some(0.8), supply_v: Some(3.0), ..Source::of_voltage(None) };
    let driven = Design::of(&Requirement { source, ..lift(2.0, 6e-3) }, 0.1e-3);
    assert!(matches!(driven.shortfall, Some(Shortfall::LowCompliance(volts)) if volts > 3.0), "{driven:?}");
}

/// Of a demand no wire meets, each change named is one that works, and is no farther than it has to be.
#[test]
fn the_nearest_demand_works() {
    let asked = Requirement { cycle_s: Some(0.5), wires: Some(2), ..lift(20.0, 6e-3) };
    assert!(best(&designs(&asked, &STOCK_DIAMETERS_M)).is_none());
    let found = nearest(&Requirement { cycle_s: None, ..asked }, &STOCK_DIAMETERS_M[..8], &[]);
    let force = found.iter().find_map(|near| match near.change {
        Change::Force(force_n) => Some(force_n),
        _ => None,
    });
    // two wires of 0.2 mm pull 2 × 70 MPa · A
    let most_n = 2.0 * WireRules::of(0.2e-3, 0.15).useful_force_n();
    assert!(force.is_some_and(|force_n| force_n <= most_n && force_n > 0.9 * most_n), "{force:?} of {most_n}");
    let wires = found.iter().find_map(|near| match near.change {
        Change::Wires(wires) => Some(wires),
        _ => None,
    });
    assert_eq!(wires, Some((20.0 / (0.5 * most_n)).ceil() as u32));
    assert!(found.is_sorted_by(|a, b| a.distance <= b.distance));
    assert!(found.iter().all(|near| near.design.shortfall.is_none()));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    /// Whatever is asked, what is said to do does it.
    #[test]
    fn what_will_do_does(
        force_n in 1e-3..100.0f64, stroke_m in 1e-4..0.5f64, cycle_s in 0.01..100.0f64, span_m in 0.01..2.0f64,
        supply_v in 0.5..100.0f64, most_a in 0.1..20.0f64,
    ) {
        let source = Source { most_current_a: Some(most_a), ..Source::of_voltage(Some(supply_v)) };
        let asked = Requirement { cycle_s: Some(cycle_s), span_m: Some(span_m), source, ..lift(force_n, stroke_m) };
        for design in designs(&asked, &STOCK_DIAMETERS_M) {
            let s = &design.sizing;
            prop_assert!(s.safe_duty() <= 1.0);
            // with less the rule of eq. 11 promises heat for nothing
            let is_meant = s.lack.is_none() && s.current_a() >= s.wire.safe_current_a();
            prop_assert!(!is_meant || s.efficiency() < 0.025309, "better than eq. 17 promises: {s:?}");
            if design.shortfall.is_none() {
                let said = design.prediction.unwrap();
                prop_assert!(said.cycle.cycle_s() <= cycle_s);
                prop_assert!(f64::from(s.wires) * s.wire.useful_force_n() >= force_n * s.lever * (1.0 - 1e-9));
                prop_assert!(s.wire.length_m <= span_m + 1e-12);
                prop_assert!(s.wire.stroke_m() * s.lever >= stroke_m * (1.0 - 1e-9));
                prop_assert!(said.stroke_m > s.wire.stroke_m());
                prop_assert!(s.source_a() <= most_a);
            }
        }
    }
}
