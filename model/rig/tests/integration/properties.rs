//! Whatever a rig file says, reading it never panics; what is read and written is read the same again.

use std::sync::LazyLock;

use proptest::prelude::*;
use proptest::sample::Index;
use sinew_rig::{Algorithm, Estimator, FaultKind, HEXAPOD_TOML, Prior, RapidHeating, Rig, SimulatedFault};

/// A file with every table in it.
const FULL: &str = r#"# a bench
[rig]
name = "bench"        # found by this
rate_hz = 5000
ambient_c = 22.5
realtime = "strict"
realtime_priority = 70
realtime_cpu = 1

[[channel]]
name = "left"

[channel.wire]
diameter_mm = 0.125   # measured
length_mm = 160.0

[channel.taps]
l0_mm = 5.0
ls_mm = 145.0

[channel.drive]
kind = "pwm"
supply_v = 6.0
shunt_ohm = 0.1

[channel.load]
mass_kg = 0.2
damping_n_s_per_m = 40.0

[channel.sensors]
position_zero = "free"
noise = { position_m = 1.5e-5 }

[channel.initial]
temperature_c = 30.0
martensite = 0.9

[channel.priors]
convection_w_per_m2_k = "20 %"
austenite_temperature_c = 4.0

[channel.material]
kinetics = "richards"
heating_skew = 1.5
criterion = "brinson"
detwinning_start_mpa = 100.0
detwinning_finish_mpa = 170.0
mixing = "parallel"
convection = "natural"

[channel.adc]
bits = 12

[channel.front_end]
index = 4

[channel.linux]
pwm = "1-0040/3" # beside the green one
polarity = "inversed"
v1 = "1-0048:in_voltage0"
v1_gain = 2.5
supply_offset_v = -0.25
current = "ina219:in_voltage0"
current_gain = 10.0

[channel.limits]
maximum_power_w = 2.5

[channel.control]
algorithm = "sliding_mode_first_order"
lambda_per_s = 12.0

[channel.effects."thermal.draught"] # when the window was open
gain = 0.25
start_s = 33.0
end_s = 52.0

[channel.effects."thermal.sheath"]

[channel.effects."thermal.neighbour"]
conductance_w_per_k = 1e-4
channel = "right"

[[channel]]
name = "right"
wire = { diameter_mm = 0.25, length_mm = 100.0 }
drive.supply_v = 9.0
control = { algorithm = "pid", estimator = "luenberger", rapid_heating = "temperature", heat_loss_feedforward = true, pid_derivative_s_per_mm = 0.125 }
load.mass_kg = 0.3

[[channel]]
name = "flexor"
wire = { diameter_mm = 0.05, length_mm = 100.0 }
drive.supply_v = 12.0

[[channel]]
name = "extensor"
wire = { diameter_mm = 0.05, length_mm = 100.0 }
drive.supply_v = 12.0

[[joint]]
name = "knee"
agonist = "flexor"
antagonist = "extensor"
radius_mm = 8.0        # to the pin
inertia_kg_mm2 = 2.5

[recording.columns]
position_m = { column = "Pos", scale = -1.0, offset = 0.5 }

[backend]
kind = "simulated"

[backend.serial]
port = "/dev/serial/by-id/usb-bench" # the left one
baud_hz = 1000000
watchdog_periods = 8

[backend.linux]
sampling = "sysfs"
phase = "free"
trigger = "timer"
guard_ms = 50
root = "/tmp/root"

[black_box]
enabled = false
before_s = 4.5
after_s = 0.0
keep = 3
memory_mb = 64

[simulation]
seed = 7
pace = "as_fast_as_possible"

[[simulation.fault]]
channel = "right"
kind = "supply_dip"
start_s = 1.5
end_s = 2.0
value = 0.4
"#;

/// Things that go wrong in files, put in place of something else.
const JUNK: &[&str] = &[
    "",
    "nan",
    "-inf",
    "inf",
    "1e999",
    "-1",
    "0",
    "\"\"",
    "\"x\"",
    "[]",
    "{}",
    "[[channel]]",
    "[channel]",
    "true",
    "1979-05-27",
    "\n",
    "\"",
    "'''",
    "=",
    "{ a = 1 }",
    "99999999999999999999999999",
    "0x7f",
    "1_0",
    "\u{feff}",
    "é",
    "\0",
    "[channel.effects]",
    "effects = 3",
    "[simulation.fault]",
    "\"20 %\"",
    "#",
    ".",
    "\\",
];

static FULL_RIG: LazyLock<Rig> = LazyLock::new(|| Rig::parse(FULL, "rig.toml").unwrap_or_else(|e| panic!("{e}")));

/// Pieces of a file as one would mark them to type over them.
fn pieces(text: &str) -> Vec<std::ops::Range<usize>> {
    let mut pieces = Vec::new();
    let mut start = 0;
    let breaks = |c: char| c.is_whitespace() || "=[]{},".contains(c);
    for (i, c) in text.char_indices() {
        if breaks(c) {
            if start < i {
                pieces.push(start..i);
            }
            pieces.push(i..i + c.len_utf8());
            start = i + c.len_utf8();
        }
    }
    pieces
}

/// Reads; whatever is accepted must be sound, and whatever is refused must say where.
fn read(text: &str) {
    match Rig::parse(text, "rig.toml") {
        Ok(rig) => {
            for channel in &rig.channels {
                channel.model.validate().unwrap();
                let l = &channel.limits;
                let numbers = [l.min_length_m, l.max_length_m, l.max_duty, l.max_power_w, l.max_current_a]
                    .into_iter()
                    .chain([
                        l.max_temperature_c,
                        l.continuous_current_a,
                        l.energy_budget_j,
                        l.energy_drain_w,
                        l.lease_s,
                        l.max_lease_s,
                    ])
                    .chain([channel.adc.voltage_range_v, channel.adc.current_range_a, channel.control.minimum_duty])
                    .chain([channel.control.pi_proportional_per_m, channel.control.pi_integral_per_m_s])
                    .chain([channel.control.pid_derivative_s_per_m]);
                for n in numbers {
                    assert!(n.is_finite(), "{n} from\n{text}");
                }
                assert!(l.min_length_m < l.max_length_m && l.lease_s <= l.max_lease_s);
                assert!(
                    channel.control.minimum_duty < l.max_duty || channel.model.drive.supply_v == 0.0 || !pwm(channel)
                );
            }
            for joint in &rig.joints {
                let models = rig.channels_of(joint).unwrap().map(|index| &rig.channels[index].model);
                joint.mechanics.validate(models).unwrap();
                assert!(joint.min_tension_n < joint.tension_n && joint.tension_n <= joint.max_tension_n);
            }
            assert!(rig.to_toml() == text, "nothing was changed");
            let _ = rig.check_drivable();
        }
        Err(error) => {
            let lines = text.lines().count().max(1) + 1;
            assert!(!error.problems().is_empty());
            for problem in error.problems() {
                assert!((1..=lines).contains(&problem.line), "{problem}");
                assert!(!problem.to_string().contains("NaN, expected"), "{problem}");
            }
        }
    }
}

fn pwm(channel: &sinew_rig::Channel) -> bool {
    channel.model.drive.kind == sinew_physics::DriveKind::Pwm
}

#[test]
fn the_full_file_is_read_and_stays_as_it_is() {
    read(FULL);
    assert!(Rig::parse(FULL, "rig.toml").is_ok());
    read(HEXAPOD_TOML);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_mutation_panics(
        edits in prop::collection::vec((any::<Index>(), any::<Index>(), any::<Index>(), 0..4u8), 1..4),
        hexapod in prop::bool::weighted(0.1),
    ) {
        let mut text = if hexapod { HEXAPOD_TOML[..2400].to_string() } else { FULL.to_string() };
        for (place, other, junk, kind) in edits {
            let pieces = pieces(&text);
            if pieces.is_empty() {
                break;
            }
            let at = pieces[place.index(pieces.len())].clone();
            let from = text[pieces[other.index(pieces.len())].clone()].to_string();
            match kind {
                0 => text.replace_range(at, JUNK[junk.index(JUNK.len())]),
                1 => text.replace_range(at, ""),
                2 => text.replace_range(at, &from),
                _ => text.insert_str(at.start, &from),
            }
        }
        read(&text);
    }

    #[test]
    fn no_number_panics(place in any::<Index>(), number in any::<f64>()) {
        let values: Vec<_> = pieces(FULL).into_iter().filter(|p| FULL[p.clone()].parse::<f64>().is_ok()).collect();
        let mut text = FULL.to_string();
        text.replace_range(values[place.index(values.len())].clone(), &format!("{number:?}").replace("NaN", "nan"));
        read(&text);
    }

    #[test]
    fn no_text_panics(text in "\\PC*") {
        read(&text);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn changed_parameters_come_back(
        changes in prop::collection::vec((0..2usize, any::<Index>(), 0.0..1.0f64), 1..12),
    ) {
        let mut rig = FULL_RIG.clone();
        let parameters: Vec<_> = sinew_rig::parameters().collect();
        for (channel, which, share) in changes {
            let parameter = parameters[which.index(parameters.len())];
            if let Some(value) = rig.parameter(channel, parameter.key) {
                // Near the value, as a fit goes, and within the range.
                let near = (value * (0.7 + 0.6 * share) + 0.01 * share).clamp(parameter.low, parameter.high);
                rig.set_parameter(channel, parameter.key, near).unwrap();
                // To SI and back costs a last digit.
                let found = rig.parameter(channel, parameter.key).unwrap();
                prop_assert!((found - near).abs() <= 4.0 * f64::EPSILON * near.abs(), "{} {}", found, near);
            }
        }
        let text = rig.to_toml();
        // A fit may end where the file's limits contradict each other; that is said, not written over.
        if let Ok(again) = Rig::parse(&text, "rig.toml") {
            for (was, is) in rig.channels.iter().zip(&again.channels) {
                prop_assert_eq!(&was.model, &is.model);
            }
            prop_assert_eq!(again.to_toml(), text.clone());
            prop_assert!(text.contains("# measured") && text.contains("# found by this"));
            // Limits follow the model, so a rig that was read again is the same to the last bit.
            prop_assert_eq!(&again.refreshed().unwrap(), &again);
        }
    }

    #[test]
    fn changed_effects_come_back(
        changes in prop::collection::vec((0..2usize, any::<Index>(), any::<Index>(), 0.0..1.0f64, 0..4u8), 1..12),
    ) {
        let mut rig = FULL_RIG.clone();
        let catalogue: Vec<_> = sinew_physics::effects::catalogue().collect();
        for (channel, effect, parameter, share, kind) in changes {
            let effect = catalogue[effect.index(catalogue.len())];
            let p = &effect.parameters[parameter.index(effect.parameters.len())];
            let value = match kind {
                // one in four goes back to where nothing acts
                0 => p.default(&rig.channels[channel].model),
                _ => p.plausible.0 + share * (p.plausible.1 - p.plausible.0),
            };
            rig.set_effect(channel, effect.id, p.key, value).unwrap();
            let found = rig.effect_parameter(channel, effect.id, p.key).unwrap();
            prop_assert!((found - value).abs() <= 4.0 * f64::EPSILON * value.abs(), "{} {}", found, value);
        }
        let text = rig.to_toml();
        prop_assert!(text.contains("# measured") && text.contains("# when the window was open"));
        // a model no file may say (a draught that ends before it begins) is refused, not written over
        if let Ok(again) = Rig::parse(&text, "rig.toml") {
            for (was, is) in rig.channels.iter().zip(&again.channels) {
                prop_assert_eq!(&was.model, &is.model);
                prop_assert_eq!(&was.neighbour, &is.neighbour);
            }
            prop_assert_eq!(again.to_toml(), text.clone());
            prop_assert_eq!(&again.refreshed().unwrap(), &again);
        }
    }

    #[test]
    fn changed_settings_come_back(
        duty in 0.1..1.0f64, temperature in 60.0..400.0f64, hold in 0.5..5.0f64, sigma in 0.0..10.0f64,
        percent in 0.0..500.0f64, start in 0.0..100.0f64, seed in 0..=i64::MAX as u64, scale in 0.1..10.0f64,
    ) {
        let mut rig = FULL_RIG.clone();
        rig.name = "other".into();
        rig.channels[1].name = "far_right".into();
        rig.channels[1].limits.max_duty = duty;
        rig.channels[0].limits.max_temperature_c = temperature;
        rig.channels[0].limits.lease_s = hold;
        rig.channels[0].control.algorithm =
            [Algorithm::SlidingMode, Algorithm::Relay, Algorithm::InputOutputLinearised][(seed % 3) as usize];
        rig.channels[0].control.estimator =
            [Estimator::Enthalpy, Estimator::Luenberger, Estimator::LuenbergerScheduled][(seed % 3) as usize];
        rig.channels[0].control.lambda_per_s = None;
        rig.channels[0].control.rapid_heating = RapidHeating::Resistance;
        rig.channels[0].control.relay_band_m = (seed % 3 == 1).then_some(scale / 1e3);
        rig.channels[0].control.heat_loss_feedforward = (seed % 3 == 2).then_some(false);
        rig.channels[1].control.heat_loss_feedforward = Some(false);
        rig.channels[1].control.pid_derivative_s_per_m = scale * 1e3;
        rig.channels[0].noise.remove("position_m");
        rig.channels[0].noise.insert("v3_v".into(), 1e-3 * scale);
        rig.channels[1].noise.insert("force_n".into(), 0.01 * duty);
        rig.channels[0].priors.remove("austenite_temperature_c");
        rig.channels[0].priors.insert("mass_kg".into(), Prior::Absolute(sigma));
        rig.channels[1].priors.insert("latent_heat_j_per_kg".into(), Prior::Relative(percent / 100.0));
        rig.channels[0].neighbour = None;
        rig.set_effect(0, "thermal.draught", "gain", 0.0).unwrap();
        rig.set_effect(1, "kinetic.lag", "seconds", duty).unwrap();
        rig.channels[1].neighbour = Some("left".into());
        rig.simulation.seed = seed;
        rig.simulation.faults.push(SimulatedFault {
            channel: Some(0), kind: FaultKind::ProbeLost, start_s: start, end_s: f64::INFINITY, value: Some(1.0),
        });
        rig.recording.format.separator = Some("\t".into());
        rig.recording.format.first_line = Some(seed as usize % 100);
        rig.recording.columns.insert("duty".into(), sinew_rig::Column { column: "D".into(), scale, offset: 0.0 });
        let text = rig.to_toml();
        let again = Rig::parse(&text, "rig.toml").unwrap();
        // What was not written follows what was; all the rest is as it was set.
        rig.channels[0].limits.energy_budget_j = again.channels[0].limits.energy_budget_j;
        rig.channels[0].limits.continuous_current_a = again.channels[0].limits.continuous_current_a;
        rig.channels[0].limits.energy_drain_w = again.channels[0].limits.energy_drain_w;
        let (l, a) = (&mut rig.channels[0], &again.channels[0]);
        for (was, is) in [
            (&mut l.limits.max_current_a, a.limits.max_current_a),
            (&mut l.limits.max_duty, a.limits.max_duty),
            (&mut l.adc.current_range_a, a.adc.current_range_a),
        ] {
            // The hottest wire has the greatest resistance: these follow the temperature, but not far.
            prop_assert!((*was / is - 1.0).abs() < 0.2, "{} {}", was, is);
            *was = is;
        }
        prop_assert_eq!(&again, &rig);
    }
}

#[test]
fn channels_can_be_taken_away_and_added() {
    let mut rig = FULL_RIG.clone();
    let mut third = rig.channels[0].clone();
    third.name = "third".into();
    rig.channels.remove(0);
    rig.channels.push(third);
    rig.channels.push(FULL_RIG.channels[0].clone());
    // The dip's channel has moved up.
    rig.simulation.faults[0].channel = Some(0);
    let again = Rig::parse(&rig.to_toml(), "rig.toml").unwrap_or_else(|e| panic!("{e}\n{}", rig.to_toml()));
    assert_eq!(again, rig);

    let mut hexapod = Rig::hexapod();
    hexapod.channels.truncate(3);
    let again = Rig::parse(&hexapod.to_toml(), "rig.toml").unwrap();
    assert_eq!(again, hexapod);
}

#[test]
fn kinds_can_be_changed() {
    let mut rig = FULL_RIG.clone();
    let c = &mut rig.channels[0];
    c.model.effects = sinew_physics::effects::Effects::default();
    c.model.load = sinew_physics::Load::ImposedForce;
    c.model.drive.kind = sinew_physics::DriveKind::Temperature;
    c.model.taps = None;
    c.model.material.kinetics = sinew_physics::Kinetics::Logistic;
    let again = rig.refreshed().unwrap_or_else(|e| panic!("{e}\n{}", rig.to_toml()));
    assert_eq!(again.channels[0].model, rig.channels[0].model);
    assert_eq!(again.channels[1], rig.channels[1]);
}

#[test]
fn effects_come_and_go_in_their_place() {
    let mut rig = FULL_RIG.clone();
    rig.set_effect(0, "thermal.draught", "gain", 0.3).unwrap();
    rig.set_effect(0, "empirical.thermal", "tau", 0.125).unwrap();
    rig.set_effect(1, "thermal.latent_heat", "latent_heat_j_per_kg", 20e3).unwrap();
    rig.set_effect(1, "mechanical.stress_dependent_strain", "stress_scale_mpa", 40.3).unwrap();
    rig.set_effect(1, "thermal.draught", "gain", 0.1).unwrap();
    rig.set_effect(1, "thermal.draught", "end_s", 2.5).unwrap();
    rig.channels[0].neighbour = None;
    let with_effects = FULL
        .replace("gain = 0.25\n", "gain = 0.3\n")
        .replace("1e-4\nchannel = \"right\"\n", "1e-4\n\n# empirical: fitted to a recording, not a mechanism\n[channel.effects.\"empirical.thermal\"]\ntau = 0.125\n")
        .replace(
            "load.mass_kg = 0.3\n",
            "load.mass_kg = 0.3\n\n[channel.material]\nlatent_heat_j_per_kg = 20000.0\n\n\
             [channel.effects.\"thermal.draught\"]\ngain = 0.1\nstart_s = 0.0\nend_s = 2.5\n\n\
             [channel.effects.\"mechanical.stress_dependent_strain\"]\nstress_scale_mpa = 40.3\n",
        );
    let text = rig.to_toml();
    let taus: Vec<&str> = text.lines().filter(|line| line.starts_with("tau")).collect();
    assert_eq!(taus, ["tau = 0.125"], "what has many terms names those that are not 0");
    assert_eq!(text, with_effects);

    let mut again = Rig::parse(&text, "rig.toml").unwrap();
    assert_eq!(again.channels[1].model, rig.channels[1].model);
    for channel in &mut again.channels {
        sinew_physics::effects::effect("mechanical.stress_dependent_strain").unwrap().set_null(&mut channel.model);
        sinew_physics::effects::effect("empirical.thermal").unwrap().set_null(&mut channel.model);
        sinew_physics::effects::effect("thermal.neighbour").unwrap().set_null(&mut channel.model);
    }
    let text = again.to_toml();
    assert!(!text.contains("stress_dependent") && !text.contains("empirical") && !text.contains("neighbour"), "{text}");
    assert!(text.contains("thermal.sheath"), "what was empty before is the user's own");
    assert_eq!(Rig::parse(&text, "rig.toml").unwrap(), again);
}

#[test]
fn a_value_changes_in_its_place() {
    let mut rig = FULL_RIG.clone();
    rig.set_parameter(0, "diameter_mm", 0.126).unwrap();
    rig.set_parameter(0, "convection_w_per_m2_k", 113.5).unwrap();
    rig.set_parameter(1, "lead_ohm", 0.25).unwrap();
    rig.set_parameter(1, "outer_loop_weight", 0.5).unwrap();
    let expected = FULL
        .replace("diameter_mm = 0.125   # measured", "diameter_mm = 0.126   # measured")
        .replace("convection = \"natural\"\n", "convection = \"natural\"\nconvection_w_per_m2_k = 113.5\n")
        .replace("drive.supply_v = 9.0\n", "drive.supply_v = 9.0\ndrive.lead_ohm = 0.25\n")
        .replace("load.mass_kg = 0.3\n", "load.mass_kg = 0.3\n\n[channel.material]\nouter_loop_weight = 0.5\n");
    assert_eq!(rig.to_toml(), expected);
}
