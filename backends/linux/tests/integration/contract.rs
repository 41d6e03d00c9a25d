//! The conformance suite for backends against a simulated kernel, with every call of the allocator counted, and tests specific
//! to Linux: names, takeovers, devices that disappear.

use std::fs;
use std::path::Path;
use std::thread;
use std::time::Duration;

use crate::bench::{Bench, bench, guarded};
use sinew_backend::conformance::suite;
use sinew_backend::{Backend, BackendError, ChannelFault, Sample, Zero};
use sinew_linux_backend::LinuxRig;
use sinew_linux_tree::Scans;
use sinew_rig::{FaultKind, LinuxSampling};

fn keeps(bench: &mut Bench) {
    let findings = suite(bench);
    assert!(findings.counts_allocations, "allocations have to be counted");
    assert_eq!(findings.skipped, ["does not wait"]);
    println!("{findings:?}");
}

#[test]
fn it_keeps_the_contract_with_triggered_scans() {
    let Some(mut bench) = bench(3, 1000.0, Scans::OnPhase, LinuxSampling::Buffer) else { return };
    keeps(&mut bench);
}

#[test]
fn it_keeps_the_contract_with_scans_of_any_moment() {
    let Some(mut bench) = bench(2, 500.0, Scans::Free(40), LinuxSampling::Buffer) else { return };
    keeps(&mut bench);
}

#[test]
fn it_keeps_the_contract_input_by_input() {
    let Some(mut bench) = bench(2, 100.0, Scans::OnPhase, LinuxSampling::Sysfs) else { return };
    bench.triggered_by_hand();
    keeps(&mut bench);
}

#[test]
fn samples_are_what_the_wires_gave() {
    let Some(bench) = bench(3, 1000.0, Scans::OnPhase, LinuxSampling::Buffer) else { return };
    let mut backend = bench.backend();
    backend.start().unwrap();
    let duty = [0.5, 0.25, 0.1];
    let mut samples = [Sample::NONE; 3];
    backend.exchange(&duty, &mut samples).unwrap();
    assert!(bench.duties().iter().zip(duty).all(|(out, asked)| (out - asked).abs() < 1e-6), "{:?}", bench.duties());
    bench.tree.pass();
    backend.exchange(&duty, &mut samples).unwrap();
    for (channel, sample) in samples.iter().enumerate() {
        let truth = bench.tree.kernel().rig().truth(channel).unwrap();
        let resistance_ohm = sample.v3_v / sample.current_a;
        let error = resistance_ohm / truth.resistance_ohm - 1.0;
        assert!(error.abs() < 0.02, "channel {channel}: {resistance_ohm} Ω, truly {}", truth.resistance_ohm);
        assert!(sample.v1_v.is_finite() && sample.v2_v > sample.v1_v && sample.v3_v > sample.v2_v, "{sample:?}");
    }
    // without a new scan there is no sample, rather than the old one
    backend.exchange(&duty, &mut samples).unwrap();
    assert!(samples.iter().all(|sample| sample.current_a.is_nan()), "{samples:?}");
    // nor with a buffer that ran full long ago
    (0..5000).for_each(|_| bench.tree.pass());
    assert!(bench.tree.kernel().converters[0].dropped > 0);
    backend.exchange(&duty, &mut samples).unwrap();
    assert!(samples.iter().all(|sample| sample.current_a.is_nan()), "{samples:?}");
    bench.tree.pass();
    backend.exchange(&duty, &mut samples).unwrap();
    assert!(samples.iter().all(|sample| sample.current_a > 0.0), "{samples:?}");
    // the same duty again is no write
    let writes = bench.tree.kernel().output(0).writes;
    backend.exchange(&duty, &mut samples).unwrap();
    assert_eq!(bench.tree.kernel().output(0).writes, writes);
}

#[test]
fn a_stage_that_conducts_by_itself_shows_in_the_dark_where_the_converter_runs_on() {
    let Some(bench) = bench(1, 100.0, Scans::Free(64), LinuxSampling::Buffer) else { return };
    let mut backend = bench.backend();
    backend.start().unwrap();
    let mut samples = [Sample::NONE];
    let mut look = || {
        bench.tree.pass();
        backend.exchange(&[0.0], &mut samples).unwrap();
        samples[0].current_a
    };
    let dark_a = (0..3).map(|_| look()).last().unwrap();
    assert!(dark_a.abs() < 0.01, "{dark_a} A: a reading, and nothing flows");
    bench.tree.kernel().faults().set(0, FaultKind::StageOn);
    let stuck_a = (0..3).map(|_| look()).last().unwrap();
    assert!(stuck_a > 0.05, "{stuck_a} A");
}

#[test]
fn a_heated_output_of_a_dead_program_is_taken_over_and_put_to_zero() {
    let Some(mut bench) = bench(2, 1000.0, Scans::OnPhase, LinuxSampling::Buffer) else { return };
    // Here it is not the guard's to find a loop that a busy machine keeps waiting.
    bench.rig.backend.linux.guard_ms = 5000;
    let chip = bench.tree.root().join("sys/class/pwm/pwmchip0");
    fs::write(chip.join("export"), "1").unwrap();
    // longer than the rig's, so that zero has to come before the period
    for (file, value) in [("period", "5000000"), ("duty_cycle", "4000000"), ("enable", "1")] {
        fs::write(chip.join("pwm1").join(file), value).unwrap();
    }
    // and a converter that still runs
    let device = bench.tree.root().join("sys/bus/iio/devices/iio:device1");
    fs::write(device.join("scan_elements/in_voltage3_en"), "1").unwrap();
    fs::write(device.join("trigger/current_trigger"), "pwm-on-phase").unwrap();
    fs::write(device.join("buffer/enable"), "1").unwrap();
    assert_eq!(bench.duties(), [0.0, 0.8]);
    let mut backend = bench.backend();
    assert_eq!(bench.duties(), [0.0, 0.8], "looking for it changes nothing");
    backend.start().unwrap();
    assert_eq!(bench.duties(), [0.0, 0.0]);
    assert_eq!(bench.tree.kernel().output(1).period_ns, 1_000_000);

    // a second driver is refused while the first one runs, and does not disturb it
    let mut samples = [Sample::NONE; 2];
    backend.exchange(&[0.3, 0.3], &mut samples).unwrap();
    let mut second = bench.backend();
    let refused = thread::scope(|scope| {
        let refused = scope.spawn(|| second.bring_up().unwrap_err().to_string());
        while !refused.is_finished() {
            backend.exchange(&[0.3, 0.3], &mut samples).unwrap();
            thread::sleep(Duration::from_millis(1));
        }
        refused.join().unwrap()
    });
    assert!(refused.contains("belongs to another driver that still runs"), "{refused}");
    assert_eq!(bench.duties(), [0.3, 0.3]);
    drop(backend);
    assert_eq!(bench.duties(), [0.0, 0.0]);
    second.start().unwrap();
}

#[test]
fn wrong_names_are_answered_with_what_there_is() {
    let Some(bench) = bench(2, 1000.0, Scans::OnPhase, LinuxSampling::Buffer) else { return };
    let refused = |change: &dyn Fn(&mut sinew_linux_backend::Settings)| {
        let mut settings = guarded(&bench.rig);
        change(&mut settings);
        LinuxRig::new(settings).unwrap_err().to_string()
    };
    let says = |error: String, words: &[&str]| {
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    says(
        refused(&|s| s.channels[1].pwm = "pwmchip7/1".into()),
        &["linux.pwm", "no such chip", "pwmchip0 (device 1-0040, outputs 0 to 15)"],
    );
    says(refused(&|s| s.channels[1].pwm = "1-0040/16".into()), &["pwmchip0 has outputs 0 to 15"]);
    says(refused(&|s| s.channels[1].pwm = "pwmchip0".into()), &["expected a chip and the number"]);
    says(refused(&|s| s.channels[1].pwm = "1-0040/0".into()), &["has that output already"]);
    let input = |name: &str| Some(name.to_string());
    says(
        refused(&|s| s.channels[0].inputs.v3.name = input("ina219:in_voltage1")),
        &["no such converter", "iio:device1 (ads131 at 2-0049: in_current0, in_voltage0"],
    );
    says(
        refused(&|s| s.channels[0].inputs.v3.name = input("ads131:in_voltage1")),
        &["several converters", "2-0048", "2-0049"],
    );
    says(refused(&|s| s.channels[0].inputs.v3.name = input("2-0048:in_voltage9")), &["no such input", "in_voltage3"]);
    says(refused(&|s| s.channels[0].inputs.v3.name = input("in_voltage9")), &["expected a device and its input"]);
    says(refused(&|s| s.channels[0].inputs.current.name = None), &["linux.current", "without the current"]);
    says(refused(&|s| s.trigger = Some("timer".into())), &["backend.linux.trigger", "there is pwm-on-phase"]);

    // and what only shows when it is set up
    bench.tree.kernel().chips[0].outputs[1].taken = true;
    let error = bench.backend().bring_up().unwrap_err();
    says(error.to_string(), &["pwmchip0/export", "write 1"]);
    says(error.remedy(), &["somebody else has it"]);
    bench.tree.kernel().chips[0].outputs[1].taken = false;
    let node = fs::File::open(bench.tree.root().join("dev/iio:device0")).unwrap();
    says(bench.backend().bring_up().unwrap_err().remedy(), &["somebody else has it"]);
    drop(node);
    let mut settings = guarded(&bench.rig);
    settings.guard.0 = Path::new("/no/such/program").into();
    says(LinuxRig::new(settings).unwrap().bring_up().unwrap_err().to_string(), &["guard", "/no/such/program"]);
    assert_eq!(bench.duties(), [0.0, 0.0]);
}

#[test]
fn what_is_unplugged_is_an_error_and_everything_else_is_put_to_zero() {
    let Some(bench) = bench(3, 1000.0, Scans::OnPhase, LinuxSampling::Buffer) else { return };
    let mut backend = bench.backend();
    let mut samples = [Sample::NONE; 3];
    let duty = [0.4; 3];
    let mut exchange = |backend: &mut LinuxRig| {
        bench.tree.pass();
        (backend.exchange(&duty, &mut samples), samples)
    };
    backend.start().unwrap();
    exchange(&mut backend).0.unwrap();

    // one converter: its channel alone
    bench.tree.kernel().converters[1].gone = true;
    let (error, samples) = exchange(&mut backend);
    assert_eq!(error, Err(BackendError::Channel { channel: 1, fault: ChannelFault::Converter }));
    assert!(samples[1].current_a.is_nan() && samples[0].current_a > 0.0 && samples[2].current_a > 0.0);
    assert_eq!(bench.duties(), [0.4, 0.0, 0.4]);
    // two: each is told of
    bench.tree.kernel().converters[2].gone = true;
    let (error, _) = exchange(&mut backend);
    assert_eq!(error, Err(BackendError::Channel { channel: 1, fault: ChannelFault::Converter }));
    let failure = Some(ChannelFault::Converter);
    assert_eq!([0, 1, 2].map(|channel| backend.failure(channel)), [None, failure, failure]);

    // all of them
    for converter in &mut bench.tree.kernel().converters {
        converter.gone = true;
    }
    let (error, samples) = exchange(&mut backend);
    assert!(matches!(error, Err(BackendError::Unavailable { os_error: 19 })), "{error:?}");
    assert!(samples.iter().all(|sample| sample.current_a.is_nan()));
    assert_eq!(bench.duties(), [0.0; 3]);
    assert_eq!(backend.stop(), Zero::Confirmed);

    // the whole board
    bench.tree.kernel().plug_in();
    backend.start().unwrap();
    exchange(&mut backend).0.unwrap();
    bench.tree.kernel().unplug();
    let (error, samples) = exchange(&mut backend);
    assert!(matches!(error, Err(BackendError::Unavailable { os_error: 19 })), "{error:?}");
    assert!(samples.iter().all(|sample| sample.current_a.is_nan()));
    assert!((0..samples.len()).all(|channel| !backend.is_confirmed(channel)));
    assert_eq!(backend.stop(), Zero::Unconfirmed, "nobody knows what a board does that is not there");
}
