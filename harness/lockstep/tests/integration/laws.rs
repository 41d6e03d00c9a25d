//! Every control law of the rig file, by its word, in the driver's engine before simulated wires with noise.

use sinew_backend::allocations::{calls_of_this_thread, is_counting};
use sinew_backend::{Backend, Sample};
use sinew_driver::{Answer, Ask, Beat, Engine, Occurrence, Order};
use sinew_rig::{Algorithm, Control, Rig};
use sinew_sim_backend::SimulatedRig;

/// One channel for each law as it is by default, and some with what goes with them.
fn rig() -> Rig {
    let options = [
        "algorithm = \"pi\", heat_loss_feedforward = true",
        "algorithm = \"pid\", pid_derivative_s_per_mm = 0.03, rapid_heating = \"temperature\"",
        "algorithm = \"relay\", relay_band_mm = 0.1, rapid_heating = \"resistance\"",
        "algorithm = \"sliding_mode\", lambda_per_s = 8.0, rapid_heating = \"temperature\"",
        "algorithm = \"binary_segment\", segment = 1, segments = 2",
    ];
    let words = Algorithm::ALL.map(|(word, _)| format!("algorithm = \"{word}\""));
    let channels: String = words
        .iter()
        .map(String::as_str)
        .chain(options)
        .enumerate()
        .map(|(index, control)| {
            format!(
                "[[channel]]\nname = \"w{index}\"\nwire = {{ diameter_mm = 0.125, length_mm = 160.0 }}\n\
                 taps = {{ ls_mm = 150.0 }}\ndrive = {{ supply_v = 6.0, shunt_ohm = 0.1 }}\n\
                 load = {{ mass_kg = 0.2, damping_n_s_per_m = 40.0 }}\nlimits = {{ maximum_power_w = 3.0 }}\n\
                 control = {{ {control} }}\n\n"
            )
        })
        .collect();
    let text = format!("[rig]\nname = \"laws\"\nrate_hz = 1000.0\n\n{channels}");
    Rig::parse(&text, "laws.toml").unwrap_or_else(|e| panic!("{e}"))
}

/// Where a wire ends of which 40 % of the stroke is asked. A piece of a wire is wholly martensite or wholly austenite: of two, the shorter
/// one does the third of the way.
fn ends_at(control: &Control) -> f64 {
    match (control.algorithm, control.segments) {
        (Algorithm::BinarySegment, 1) => 0.0,
        (Algorithm::BinarySegment, _) => 1.0,
        _ => 0.4,
    }
}

/// Each brings its wire to 40 % of the stroke or about it, without a fault, without leaving its duties, and without allocating.
#[test]
fn every_law_drives_its_wire() {
    let rig = rig();
    let count = rig.channels.len();
    let mut engine = Engine::at_rest(&rig, None).unwrap();
    let mut backend = SimulatedRig::new(&rig).unwrap();
    backend.start().unwrap();
    let (mut samples, mut duty) = (vec![Sample::NONE; count], vec![0.0; count]);
    let mut errors = vec![0.0f64; count];
    let cycles = 10_000u64;
    assert!(is_counting());
    let mut allocations = 0;
    for cycle in 0..cycles {
        let now_ns = cycle * 1_000_000;
        if cycle == 50 {
            for channel in 0..count {
                let reference_m = engine.channels()[channel].stroke_range().length_m(0.4);
                let order = Order { ticket: 1, channel, ask: Ask::Length(reference_m), hold_ns: u64::MAX };
                assert_eq!(engine.take(&order, now_ns), Some(Answer::Done));
            }
        }
        let exchanged = backend.exchange(&duty, &mut samples);
        let before = calls_of_this_thread();
        engine.cycle(Beat { now_ns, missed: 0 }, exchanged, &samples, &mut duty, |event| {
            assert!(!matches!(event.what, Occurrence::Tripped(_)), "{event:?}");
        });
        allocations += calls_of_this_thread() - before;
        for (index, channel) in engine.channels().iter().enumerate() {
            let limits = &rig.channels[index].limits;
            assert!((0.0..=limits.max_duty).contains(&duty[index]), "{index}: {}", duty[index]);
            if cycle > cycles * 3 / 4 {
                let stroke = channel.stroke_range();
                let truth = backend.truth(index).unwrap();
                let off = stroke.stroke(truth.length_m) - ends_at(&rig.channels[index].control);
                errors[index] += off.abs() / (cycles / 4) as f64;
            }
        }
    }
    assert_eq!(allocations, 0);
    for (channel, error) in rig.channels.iter().zip(&errors) {
        // the relay cycles by a tenth of the stroke, the static servo takes its time; who is the default does neither
        let most = match channel.control.algorithm {
            Algorithm::SlidingMode => 0.005,
            // as far as the resistance alone tells the length
            Algorithm::ResistancePolynomial | Algorithm::ResistanceNetwork => 0.5,
            _ => 0.1,
        };
        assert!(*error < most, "{}: {error}", channel.control.algorithm.word());
    }
}
