//! The line that switches the supply, and the inputs of an emergency stop, as files of sysfs: what they do to simulated wires, and what
//! the wires' rig does to them.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;
use std::time::{Duration, Instant};

use crate::bench::{Bench, bench, bench_with, guarded};
use sinew_backend::{Backend, BackendError, Sample, StopInputs, Zero};
use sinew_linux_backend::{LinuxRig, Settings};
use sinew_linux_tree::{ENABLE, STOP, Scans, value_file};
use sinew_rig::{EnableSignal, FaultKind, LinuxSampling, Polarity, Rig};

const RATE_HZ: f64 = 1000.0;
const CLOSED: StopInputs = StopInputs { is_closed: true, is_reset_pressed: false };
const PRESSED: StopInputs = StopInputs { is_closed: true, is_reset_pressed: true };

fn lines(change: impl FnOnce(&mut Rig)) -> Option<Bench> {
    bench_with(1, RATE_HZ, Scans::OnPhase, LinuxSampling::Buffer, |rig| {
        // Here it is not the guard's to find a loop that a busy machine keeps waiting.
        rig.backend.linux.guard_ms = 5000;
        change(rig);
    })
}

/// An exchange, and the period that it begins.
fn period(bench: &Bench, backend: &mut LinuxRig) -> Result<(), BackendError> {
    let exchanged = backend.exchange(&[0.3], &mut [Sample::NONE]);
    bench.tree.pass();
    exchanged
}

/// Power of the wire in the period just past, W.
fn power_w(bench: &Bench) -> f64 {
    bench.tree.kernel().rig().truth(0).expect("a simulated wire").power_w
}

#[test]
fn a_level_is_off_but_from_the_first_exchange_to_the_end_and_while_it_is_cut() {
    for polarity in [Polarity::Normal, Polarity::Inversed] {
        let Some(bench) = lines(|rig| rig.backend.enable.polarity = polarity) else { return };
        let is_on = || bench.enable_is_high() == (polarity == Polarity::Normal);
        let mut backend = bench.backend();
        assert!(!is_on());
        backend.start().unwrap();
        bench.tree.pass();
        assert!(!is_on() && !bench.tree.kernel().has_supply(), "off before the first exchange");
        assert!(bench.tree.kernel().line(ENABLE).unwrap().output);
        (0..3).for_each(|_| period(&bench, &mut backend).unwrap());
        assert!(is_on() && power_w(&bench) > 0.0, "{} W", power_w(&bench));
        let writes = bench.tree.kernel().line(ENABLE).unwrap().writes;
        (0..10).for_each(|_| period(&bench, &mut backend).unwrap());
        assert_eq!(bench.tree.kernel().line(ENABLE).unwrap().writes, writes, "what it has already is not written");

        assert!(backend.cut() && backend.cut());
        assert!(!is_on(), "at once");
        (0..3).for_each(|_| period(&bench, &mut backend).unwrap());
        assert!(!is_on());
        assert_eq!(power_w(&bench), 0.0);
        backend.restore();
        assert!(!is_on(), "with the next exchange");
        (0..2).for_each(|_| period(&bench, &mut backend).unwrap());
        assert!(is_on() && power_w(&bench) > 0.0);

        assert_eq!(backend.stop(), Zero::Confirmed);
        assert!(!is_on());
        backend.cut();
        backend.start().unwrap();
        assert!(!is_on());
        period(&bench, &mut backend).unwrap();
        assert!(is_on(), "the next start restores it");
        let panicked = catch_unwind(AssertUnwindSafe(move || {
            let _backend = backend;
            panic!("as somebody's bug might");
        }));
        assert!(panicked.is_err() && !is_on());
    }
}

#[test]
fn pulses_are_an_edge_a_period_and_a_relay_that_misses_them_drops_out() {
    let Some(bench) =
        lines(|rig| (rig.backend.enable.signal, rig.backend.enable.dropout_s) = (EnableSignal::Pulses, 0.01))
    else {
        return;
    };
    let mut backend = bench.backend();
    backend.start().unwrap();
    bench.tree.pass();
    assert!(!bench.tree.kernel().has_supply());
    let edges = || bench.tree.kernel().line(ENABLE).unwrap().edges;
    for count in 1..100 {
        let before = edges();
        period(&bench, &mut backend).unwrap();
        assert_eq!(edges(), before + 1);
        assert!(bench.tree.kernel().has_supply());
        assert!(count < 2 || power_w(&bench) > 0.0, "period {count}");
    }
    // a driver that stands still with a duty put out
    (0..9).for_each(|_| bench.tree.pass());
    assert!(power_w(&bench) > 0.0);
    (0..3).for_each(|_| bench.tree.pass());
    assert_eq!(power_w(&bench), 0.0);
    period(&bench, &mut backend).unwrap();
    assert!(bench.tree.kernel().has_supply());

    backend.cut();
    assert!(!bench.enable_is_high());
    let before = edges();
    (0..20).for_each(|_| period(&bench, &mut backend).unwrap());
    assert_eq!(edges(), before);
    assert_eq!(power_w(&bench), 0.0);
    backend.restore();
    period(&bench, &mut backend).unwrap();
    assert!(bench.tree.kernel().has_supply());
    drop(backend);
    assert!(!bench.enable_is_high());
}

#[test]
fn an_emergency_stop_is_seen_in_the_next_exchange_and_takes_the_supply_with_it() {
    for polarity in [Polarity::Normal, Polarity::Inversed] {
        let Some(bench) = lines(|rig| rig.backend.estop.polarity = polarity) else { return };
        let faults = bench.tree.kernel().faults();
        let mut backend = bench.backend();
        assert_eq!(backend.stop_inputs(), Some(StopInputs::OPEN), "nothing is known before the first exchange");
        backend.start().unwrap();
        let look = |backend: &mut LinuxRig| {
            period(&bench, backend).unwrap();
            backend.stop_inputs()
        };
        assert_eq!(look(&mut backend), Some(CLOSED));
        assert!(bench.enable_is_high());
        faults.set(0, FaultKind::EstopReset);
        bench.tree.pass();
        assert_eq!(look(&mut backend), Some(PRESSED));
        faults.set(0, FaultKind::EstopOpen);
        bench.tree.pass();
        assert_eq!(look(&mut backend), Some(StopInputs { is_closed: false, is_reset_pressed: true }));
        assert!(!bench.enable_is_high() && power_w(&bench) == 0.0, "it does not wait for the driver's latch");
        faults.clear_all();
        bench.tree.pass();
        assert_eq!(look(&mut backend), Some(CLOSED));
        assert!(bench.enable_is_high());

        // one that cannot be read
        bench.tree.kernel().line_mut(STOP).unwrap().broken = true;
        assert_eq!(look(&mut backend), Some(StopInputs::OPEN));
        assert!(!bench.enable_is_high());
        bench.tree.kernel().line_mut(STOP).unwrap().broken = false;
        assert_eq!(look(&mut backend), Some(CLOSED));
        // also in an exchange that fails
        faults.set(0, FaultKind::EstopOpen);
        bench.tree.pass();
        assert!(backend.exchange(&[2.0], &mut [Sample::NONE]).is_err());
        assert_eq!(backend.stop_inputs(), Some(StopInputs::OPEN));
        assert!(!bench.enable_is_high());
        backend.exchange(&[0.3], &mut [Sample::NONE]).unwrap();
        assert_eq!(backend.stop(), Zero::Confirmed);
        assert_eq!(backend.stop_inputs(), Some(StopInputs::OPEN));
    }
}

#[test]
fn lines_that_are_unplugged_are_off_and_open_until_they_are_back() {
    let Some(bench) = lines(|_| ()) else { return };
    let mut backend = bench.backend();
    backend.start().unwrap();
    (0..2).for_each(|_| period(&bench, &mut backend).unwrap());
    bench.tree.kernel().unplug();
    assert!(period(&bench, &mut backend).is_err());
    assert_eq!(backend.stop_inputs(), Some(StopInputs::OPEN));
    assert!(!bench.enable_is_high());
    bench.tree.kernel().plug_in();
    let since = Instant::now();
    while period(&bench, &mut backend).is_err() || backend.stop_inputs() != Some(CLOSED) || !bench.enable_is_high() {
        assert!(since.elapsed() < Duration::from_secs(60), "{:?}", backend.stop_inputs());
        thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn an_enable_line_that_cannot_be_written_fails_the_exchange() {
    let Some(bench) = lines(|_| ()) else { return };
    let mut backend = bench.backend();
    backend.start().unwrap();
    bench.tree.kernel().line_mut(ENABLE).unwrap().broken = true;
    assert_eq!(period(&bench, &mut backend), Err(BackendError::Io { os_error: 5 }));
    assert_eq!(bench.duties(), [0.0]);
    bench.tree.kernel().line_mut(ENABLE).unwrap().broken = false;
    period(&bench, &mut backend).unwrap();
    assert!(bench.enable_is_high());
}

#[test]
fn a_driver_that_still_runs_keeps_its_line() {
    let Some(bench) = bench(1, RATE_HZ, Scans::OnPhase, LinuxSampling::Buffer) else { return };
    // Somebody else's with outputs of his own.
    let line = fs::File::open(bench.tree.root().join(&value_file(ENABLE)[1..])).unwrap();
    rustix::fs::flock(&line, rustix::fs::FlockOperation::LockExclusive).unwrap();
    let error = bench.backend().bring_up().unwrap_err().to_string();
    assert!(error.contains("gpio17/value belongs to another driver"), "{error}");
    drop(line);
    bench.backend().bring_up().unwrap();
}

#[test]
fn a_light_is_a_line_too_with_all_its_brightness() {
    // A plain folder will do: a light has nothing of a kernel's manners that matters here.
    let Some(bench) = lines(|_| ()) else { return };
    let folder = tempfile::tempdir().unwrap();
    let light = folder.path().join("sys/class/leds/supply");
    fs::create_dir_all(&light).unwrap();
    fs::write(light.join("max_brightness"), "255\n").unwrap();
    fs::write(light.join("brightness"), "7\n").unwrap();
    for name in ["sys/class/pwm", "sys/devices", "sys/bus", "dev"] {
        std::os::unix::fs::symlink(bench.tree.root().join(name), folder.path().join(name)).unwrap();
    }
    let mut settings = Settings { root: folder.path().into(), stop: None, ..guarded(&bench.rig) };
    settings.enable.as_mut().unwrap().line = "/sys/class/leds/supply/brightness".into();
    let shown = || fs::read_to_string(light.join("brightness")).unwrap();
    let mut backend = LinuxRig::new(settings).unwrap();
    backend.start().unwrap();
    // a file does not forget what is longer, as an attribute does
    assert!(shown().starts_with('0'), "{}", shown());
    backend.exchange(&[0.3], &mut [Sample::NONE]).unwrap();
    assert_eq!(shown(), "255");
    assert_eq!(backend.stop_inputs(), None);
    drop(backend);
    assert!(shown().starts_with('0'), "{}", shown());
}

#[test]
fn wrong_lines_are_answered_with_what_there_is() {
    let Some(bench) = lines(|_| ()) else { return };
    let refused = |change: &dyn Fn(&mut Settings)| {
        let mut settings = guarded(&bench.rig);
        change(&mut settings);
        LinuxRig::new(settings).unwrap_err().to_string()
    };
    let enable = |line: &str| refused(&|settings| settings.enable.as_mut().unwrap().line = line.into());
    let says = |error: String, words: &[&str]| {
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    says(enable("gpiochip0/17"), &["backend.enable.line", "no such GPIO chip; there is none"]);
    says(enable("gpiochip0"), &["expected a chip and the number of its line"]);
    says(enable("/sys/class/gpio/gpio4/value"), &["no such file", "exported"]);
    says(enable("/sys/class/gpio/gpio17"), &["no such file"]);
    says(enable(&value_file(STOP)), &["backend.estop.line", "enable.line is that line already"]);
    says(
        refused(&|settings| settings.stop.as_mut().unwrap().reset_line = Some("pinctrl/3".into())),
        &["backend.estop.reset_line", "no such GPIO chip"],
    );
}
