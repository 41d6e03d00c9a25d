//! Every kind of mistake is found at its line, with its key and what would be right.

use sinew_physics::{Amplifier, Detwinning, DriveKind};
use sinew_rig::{Error, Mapping, Rig};

pub const GOOD: &str = r#"[rig]
name = "bench"
rate_hz = 1000.0

[[channel]]
name = "wire"

[channel.wire]
diameter_mm = 0.125
length_mm = 160.0

[channel.taps]
ls_mm = 150.0

[channel.drive]
supply_v = 6.0

[channel.load]
mass_kg = 0.2

[channel.material]
latent_heat_j_per_kg = 24200
"#;

/// The messages for the good file with one piece replaced.
fn messages(from: &str, to: &str) -> String {
    assert_eq!(GOOD.matches(from).count(), 1, "{from}");
    of(&GOOD.replace(from, to))
}

fn of(text: &str) -> String {
    match Rig::parse(text, "rig.toml") {
        Ok(_) => "accepted".into(),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
fn says(from: &str, to: &str, expected: &str) {
    assert_eq!(messages(from, to), expected);
}

/// The good file with more lines at its end, which are lines 23 and on.
#[track_caller]
pub fn with(more: &str, expected: &str) {
    assert_eq!(of(&format!("{GOOD}{more}")), expected);
}

#[test]
fn the_good_file_is_good() {
    let rig = Rig::parse(GOOD, "rig.toml").unwrap();
    assert_eq!(rig.channels[0].model.geometry.length_m, 0.16);
    rig.check_drivable().unwrap();
}

#[test]
fn out_of_range() {
    says(
        "latent_heat_j_per_kg = 24200",
        "latent_heat_j_per_kg = -3",
        "rig.toml:22: channel \"wire\": material.latent_heat_j_per_kg is -3, expected 0 to 200000",
    );
    says(
        "mass_kg = 0.2",
        "mass_kg = 1e300",
        "rig.toml:19: channel \"wire\": load.mass_kg is 1e300, expected 0.000001 to 10000",
    );
    says("rate_hz = 1000.0", "rate_hz = 20001", "rig.toml:3: rig.rate_hz is 20001, expected 0.001 to 20000");
    says(
        "diameter_mm = 0.125",
        "diameter_mm = 0",
        "rig.toml:9: channel \"wire\": wire.diameter_mm is 0, expected 0.005 to 10",
    );
    says("rate_hz = 1000.0", "realtime_priority = 99", "rig.toml:3: rig.realtime_priority is 99, expected 1 to 98");
}

#[test]
fn what_depends_on_another_key() {
    says(
        "ls_mm = 150.0",
        "ls_mm = 150.0\nl0_mm = 20",
        "rig.toml:13: channel \"wire\": taps.ls_mm is 150, expected 0.16 to 140",
    );
    says(
        "latent_heat_j_per_kg = 24200",
        "martensite_temperature_c = 95",
        "rig.toml:22: channel \"wire\": material.martensite_temperature_c is 95, expected -200 to 93",
    );
    // The default of M is what is wrong then: the channel's header stands for it.
    says(
        "latent_heat_j_per_kg = 24200",
        "austenite_temperature_c = 60",
        "rig.toml:5: channel \"wire\": material.martensite_temperature_c is 67 (the default), expected -200 to 60",
    );
}

#[test]
fn values_at_their_bounds_are_taken() {
    // 30.1 + 129.9 = 160: the second tap at the very end of the wire, in decimals that no double holds exactly.
    let mut taken = 0;
    for tenths in 1..1599 {
        let (l0, ls) = (f64::from(tenths) / 10.0, f64::from(1600 - tenths) / 10.0);
        let text = GOOD.replace("ls_mm = 150.0", &format!("l0_mm = {l0}\nls_mm = {ls}"));
        let rig = Rig::parse(&text, "rig.toml").unwrap_or_else(|e| panic!("{e}"));
        rig.channels[0].model.validate().unwrap();
        assert_eq!(rig.to_toml(), text);
        taken += 1;
    }
    assert_eq!(taken, 1598);
    for (key, bound) in [("austenite_resistivity_uohm_cm", 1000), ("martensite_resistivity_uohm_cm", 1)] {
        let text = GOOD.replace("latent_heat_j_per_kg = 24200", &format!("{key} = {bound}"));
        Rig::parse(&text, "rig.toml").unwrap().channels[0].model.validate().unwrap();
    }
}

#[test]
fn not_a_number() {
    says(
        "mass_kg = 0.2",
        "mass_kg = nan",
        "rig.toml:19: channel \"wire\": load.mass_kg is nan, expected a number, 0.000001 to 10000",
    );
    says(
        "mass_kg = 0.2",
        "mass_kg = -inf",
        "rig.toml:19: channel \"wire\": load.mass_kg is -inf, expected a number, 0.000001 to 10000",
    );
    says(
        "supply_v = 6.0",
        "supply_v = 1e999",
        "rig.toml:16: channel \"wire\": drive.supply_v is 1e999, expected a number, 0 to 1000",
    );
    says(
        "supply_v = 6.0",
        "supply_v = \"6 V\"",
        "rig.toml:16: channel \"wire\": drive.supply_v is the text \"6 V\", expected a number, 0 to 1000",
    );
    says(
        "supply_v = 6.0",
        "supply_v = 6.0\n[channel.adc]\nbits = 16.0",
        "rig.toml:18: channel \"wire\": adc.bits is 16.0, expected a whole number, 4 to 32",
    );
}

#[test]
fn unknown_keys() {
    says(
        "diameter_mm = 0.125",
        "diameter_mm = 0.125\ndiamter_mm = 0.1",
        "rig.toml:10: channel \"wire\": wire.diamter_mm is unknown, did you mean diameter_mm?",
    );
    says(
        "mass_kg = 0.2",
        "mass_kg = 0.2\nconvection_w_per_m2_k = 80",
        "rig.toml:20: channel \"wire\": load.convection_w_per_m2_k is unknown here: it belongs in [channel.material]",
    );
    says(
        "mass_kg = 0.2",
        "mass_kg = 0.2\ncolour = \"red\"",
        "rig.toml:20: channel \"wire\": load.colour is unknown; \
         expected kind, mass_kg, damping_n_s_per_m, spring_n_per_m, preload_n",
    );
    with("[channel.materials]\n", "rig.toml:23: channel \"wire\": materials is unknown, did you mean material?");
    with("[rigg]\n", "rig.toml:23: rigg is unknown, did you mean rig?");
    with("[recording.colums]\n", "rig.toml:23: recording.colums is unknown, did you mean columns?");
    with("[simulation]\nsed = 3\n", "rig.toml:24: simulation.sed is unknown, did you mean seed?");
}

#[test]
fn missing_keys() {
    says(
        "diameter_mm = 0.125\n",
        "",
        "rig.toml:8: channel \"wire\": wire.diameter_mm is missing, \
         expected the wire's diameter in mm, such as 0.125, or what it is sold as, such as kind = \"flexinol-150-lt\"",
    );
    says(
        "[channel.wire]\ndiameter_mm = 0.125\nlength_mm = 160.0\n",
        "",
        "rig.toml:5: channel \"wire\": wire.length_mm is missing, \
         expected the wire's hot, unloaded length in mm, such as 160.0\n\
         rig.toml:5: channel \"wire\": wire.diameter_mm is missing, \
         expected the wire's diameter in mm, such as 0.125, or what it is sold as, such as kind = \"flexinol-150-lt\"",
    );
    says(
        "supply_v = 6.0\n",
        "",
        "rig.toml:15: channel \"wire\": drive.supply_v is missing, \
         expected the supply voltage in V, such as 6.0 (or another drive kind)",
    );
    says(
        "mass_kg = 0.2\n",
        "",
        "rig.toml:18: channel \"wire\": load.mass_kg is missing, \
         expected the moving mass in kg, such as 0.2 (or another load kind)",
    );
    says("name = \"bench\"\n", "", "rig.toml:1: rig.name is missing, expected a name such as \"tensile-bench\"");
    says("name = \"wire\"\n", "", "rig.toml:5: channel \"#1\": name is missing, expected a name such as \"wire\"");
    assert_eq!(of("[rig]\nname = \"a\"\n"), "rig.toml:1: channel is missing, expected at least one [[channel]]");
    assert_eq!(
        of(""),
        "rig.toml:1: rig.name is missing, expected a name such as \"tensile-bench\"\n\
         rig.toml:1: channel is missing, expected at least one [[channel]]"
    );
}

#[test]
fn names() {
    says(
        "name = \"wire\"",
        "name = \"my wire\"",
        "rig.toml:6: channel \"#1\": name is \"my wire\", \
         expected letters, digits, '-', '_' and '.', a letter or digit first, at most 32",
    );
    says(
        "name = \"bench\"",
        "name = \"../bench\"",
        "rig.toml:2: rig.name is \"../bench\", \
         expected letters, digits, '-', '_' and '.', a letter or digit first, at most 48",
    );
    says("name = \"bench\"", "name = 3", "rig.toml:2: rig.name is 3, expected a name in quotes");
    let second = GOOD.split_once("[[channel]]").unwrap().1;
    assert_eq!(
        of(&format!("{GOOD}[[channel]]{second}")),
        "rig.toml:24: channel \"#2\": name \"wire\" is used twice, first in line 6; expected a name of its own"
    );
}

#[test]
fn sixty_four_channels_and_no_more() {
    let (head, channel) = GOOD.split_once("[[channel]]").unwrap();
    let rig = |n: usize| {
        let channels = (0..n).map(|i| format!("[[channel]]{}", channel.replace("\"wire\"", &format!("\"w{i}\""))));
        format!("{head}{}", channels.collect::<String>())
    };
    assert_eq!(Rig::parse(&rig(64), "rig.toml").unwrap().channels.len(), 64);
    let error = of(&rig(65));
    assert!(error.contains(": channel has 65 entries, expected at most 64"), "{error}");
    assert_eq!(error.lines().count(), 1);
}

/// What each criterion and each kind of drive does without.
#[test]
fn criteria_and_amplifiers() {
    let brinson =
        "[channel.effects.\"kinetic.lag\"]\nseconds = 0.1\n[channel.effects.\"thermal.radiation\"]\nemissivity = 0.5\n";
    with(brinson, "accepted");
    assert_eq!(
        messages("latent_heat_j_per_kg = 24200\n", &format!("criterion = \"brinson\"\n{brinson}")),
        "rig.toml:23: channel \"wire\": effects.\"kinetic.lag\" has nothing to act on with this drive, load, taps and criterion; \
         take it out",
    );
    says("supply_v = 6.0", "supply_v = 6.0\nkind = \"amplifier\"\nfull_current_a = 0.4\nfilter_hz = 20", "accepted");
    says(
        "supply_v = 6.0",
        "kind = \"amplifier\"",
        "rig.toml:15: channel \"wire\": drive.supply_v is missing, expected the supply voltage in V, such as 6.0 (or another drive \
         kind)\nrig.toml:15: channel \"wire\": drive.full_current_a is missing, expected the regulated current at duty 1 in A, \
         such as 0.5",
    );
    says(
        "supply_v = 6.0",
        "supply_v = 6.0\nfull_current_a = 0.4",
        "rig.toml:17: channel \"wire\": drive.full_current_a makes no sense without kind = \"amplifier\"; add that or take it out",
    );
    let amplified = GOOD.replace("supply_v = 6.0", "kind = \"amplifier\"\nsupply_v = 6.0\nfull_current_a = 0.4");
    let rig = Rig::parse(&amplified, "rig.toml").unwrap();
    let drive = rig.channels[0].model.drive.kind;
    assert_eq!(drive, DriveKind::Amplifier(Amplifier { full_current_a: 0.4, filter_hz: 40.0 }));
    assert_eq!(Rig::parse(&rig.to_toml(), "rig.toml").unwrap().channels[0].model, rig.channels[0].model);
    let error = rig.check_drivable().unwrap_err().to_string();
    assert!(
        error.starts_with("rig.toml:16: channel \"wire\": drive.kind cannot be driven: the driver would take"),
        "{error}"
    );
}

/// Detwinning has a start and a finish, and effects that it cannot be had beside.
#[test]
fn detwinning() {
    let both = "detwinning_start_mpa = 100.0\ndetwinning_finish_mpa = 170.0";
    says("latent_heat_j_per_kg = 24200", both, "accepted");
    let rig = Rig::parse(&GOOD.replace("latent_heat_j_per_kg = 24200", both), "rig.toml").unwrap();
    let detwinning = rig.channels[0].model.material.detwinning;
    assert_eq!(detwinning, Some(Detwinning { start_pa: 100e6, finish_pa: 170e6 }));
    assert_eq!(Rig::parse(&rig.to_toml(), "rig.toml").unwrap().channels[0].model, rig.channels[0].model);
    assert_eq!(Rig::parse(GOOD, "rig.toml").unwrap().channels[0].model.material.detwinning, None);
    says(
        "latent_heat_j_per_kg = 24200",
        "detwinning_start_mpa = 100.0",
        "rig.toml:22: channel \"wire\": material.detwinning_finish_mpa is missing, expected a stress in MPa beside \
         detwinning_start_mpa, such as 170.0; or leave out both",
    );
    says(
        "latent_heat_j_per_kg = 24200",
        "detwinning_finish_mpa = 170.0",
        "rig.toml:22: channel \"wire\": material.detwinning_start_mpa is missing, expected a stress in MPa beside \
         detwinning_finish_mpa, such as 100.0; or leave out both",
    );
    says(
        "latent_heat_j_per_kg = 24200",
        "detwinning_start_mpa = 100.0\ndetwinning_finish_mpa = 100.5",
        "rig.toml:23: channel \"wire\": material.detwinning_finish_mpa is 100.5, expected 101 to 2000",
    );
    for (id, key) in [
        ("kinetic.distributed", "spread_k = 5"),
        ("kinetic.lag", "seconds = 0.1"),
        ("mechanical.stress_dependent_strain", "stress_scale_mpa = 50"),
        ("thermal.end_conduction", "conductivity_w_per_m_k = 18"),
    ] {
        let effect = format!("[channel.effects.\"{id}\"]\n{key}\n");
        with(&effect, "accepted");
        assert_eq!(
            messages("latent_heat_j_per_kg = 24200\n", &format!("{both}\n{effect}")),
            format!(
                "rig.toml:24: channel \"wire\": effects.\"{id}\" cannot be had beside detwinning_start_mpa in \
                 [channel.material]; take one of the two out"
            ),
        );
    }
    with(&format!("{both}\n[channel.effects.\"mechanical.two_way\"]\nstrain = 0.005\n"), "accepted");
}

#[test]
fn kinds() {
    says(
        "supply_v = 6.0",
        "kind = \"pmw\"\nsupply_v = 6.0",
        "rig.toml:16: channel \"wire\": drive.kind is \"pmw\", \
         expected \"pwm\", \"power\", \"current\", \"temperature\" or \"amplifier\"; did you mean \"pwm\"?",
    );
    says(
        "latent_heat_j_per_kg = 24200",
        "criterion = \"brinso\"",
        "rig.toml:22: channel \"wire\": material.criterion is \"brinso\", expected \"driving_temperature\", \"tanaka\", \
         \"liang_rogers\", \"brinson\" or \"elahinia_ahmadian\"; did you mean \"brinson\"?",
    );
    says(
        "latent_heat_j_per_kg = 24200",
        "kinetics = \"boltzmann\"",
        "rig.toml:22: channel \"wire\": material.kinetics is \"boltzmann\", \
         expected \"logistic\", \"linear\", \"square_root\", \"tanaka\", \"liang_rogers\" or \"richards\"",
    );
}

#[test]
fn keys_that_make_no_sense_together() {
    says(
        "supply_v = 6.0",
        "kind = \"power\"\n[channel.limits]\nmaximum_duty = 0.5",
        "rig.toml:18: channel \"wire\": limits.maximum_duty makes no sense: duty belongs to drive kind \"pwm\"; \
         take it out or change the drive",
    );
    says(
        "mass_kg = 0.2",
        "mass_kg = 0.2\nkind = \"imposed_force\"",
        "rig.toml:19: channel \"wire\": load.mass_kg makes no sense with an imposed position or force; \
         take it out, or set kind = \"spring_mass_damper\"",
    );
    says(
        "latent_heat_j_per_kg = 24200",
        "heating_skew = 2",
        "rig.toml:22: channel \"wire\": material.heating_skew makes no sense without kinetics = \"richards\"; \
         add that or take it out",
    );
    says(
        "[channel.taps]\nls_mm = 150.0",
        "[channel.control]\nsensing = \"dual\"",
        "rig.toml:13: channel \"wire\": control.sensing is \"dual\" but there is no [channel.taps]; \
         add the taps or use \"resistance\"",
    );
    with(
        "[channel.limits]\nminimum_length_mm = 170\nmaximum_length_mm = 150\n",
        "rig.toml:24: channel \"wire\": limits.minimum_length_mm leaves no length: minimum_length_mm is 170, \
         maximum_length_mm 150; expected the minimum below the maximum",
    );
    with(
        "[channel.limits]\nmaximum_duty = 0.01\n",
        "rig.toml:24: channel \"wire\": limits.maximum_duty leaves nothing to control with: \
         sensing_duty 0.02 is not below the largest duty, 0.01",
    );
    with(
        "[channel.limits]\nmaximum_current_a = 0.1\n",
        "rig.toml:24: channel \"wire\": limits.maximum_current_a is 0.1, but this supply drives 0.449 to 0.608 A \
         through this wire whenever it is on; expected more",
    );
    with(
        "[channel.adc]\ncurrent_range_a = 0.5\n",
        "rig.toml:24: channel \"wire\": adc.current_range_a hides an over-current: \
         current_range_a 0.5 must be above maximum_current_a 0.6986447153",
    );
    with(
        "[channel.limits]\ndefault_hold_s = 9\nmaximum_hold_s = 3\n",
        "rig.toml:24: channel \"wire\": limits.default_hold_s leaves no lease: default_hold_s 9 is above maximum_hold_s 3",
    );
    with(
        "[channel.limits]\nmaximum_temperature_c = 20\n",
        "rig.toml:24: channel \"wire\": limits.maximum_temperature_c is 20, expected more than the ambient temperature, 25",
    );
    says(
        "rate_hz = 1000.0",
        "realtime = \"off\"\nrealtime_cpu = 1",
        "rig.toml:4: rig.realtime_cpu makes no sense with realtime = \"off\"; take one of the two out",
    );
}

#[test]
fn limits_follow_one_another() {
    let rig =
        Rig::parse(&format!("{GOOD}[channel.limits]\nmaximum_power_w = 1.5\nmaximum_hold_s = 0.2\n"), "").unwrap();
    let limits = rig.channels[0].limits;
    assert_eq!(limits.max_power_w, 1.5);
    assert!((0.3..0.5).contains(&limits.max_duty), "{}", limits.max_duty);
    assert_eq!(limits.lease_s, 0.2);
}

#[test]
fn tables_of_another_kind() {
    assert_eq!(
        of("rig = 3\nchannel = 4\n"),
        "rig.toml:1: rig is 3, expected a table: [rig]\n\
         rig.toml:2: channel is 4, expected an array of tables: [[channel]], with two brackets"
    );
    assert_eq!(
        of("[rig]\nname = \"a\"\n[channel]\nname = \"b\"\n"),
        "rig.toml:3: channel is a single table [channel], expected an array of tables: [[channel]], with two brackets"
    );
    assert_eq!(
        of("channel = [1]\n[rig]\nname = \"a\"\n").lines().next().unwrap(),
        "rig.toml:1: channel \"#1\": is 1, expected a table: [[channel]]"
    );
}

#[test]
fn priors() {
    with(
        "[channel.priors]\nconvection = \"20 %\"\n",
        "rig.toml:24: channel \"wire\": priors.convection is unknown; \
         expected a numeric key of wire, taps, drive, load, initial or material, ambient_c, \
         or a number of an effect, such as \"thermal.draught.gain\"",
    );
    with(
        "[channel.priors]\nconvection_w_per_m2 = \"20 %\"\n",
        "rig.toml:24: channel \"wire\": priors.convection_w_per_m2 is unknown, did you mean convection_w_per_m2_k?",
    );
    let expected = "expected 1 sigma, 0 or more: a number in the key's unit, or text such as \"20 %\"";
    for (value, found) in
        [("-1", "-1"), ("\"20\"", "the text \"20\""), ("\"a %\"", "the text \"a %\""), ("true", "true")]
    {
        with(
            &format!("[channel.priors]\nmass_kg = {value}\n"),
            &format!("rig.toml:24: channel \"wire\": priors.mass_kg is {found}, {expected}"),
        );
    }
    for value in ["-1", "\"-1 %\"", "nan", "\"nan %\""] {
        assert!(
            of(&format!("{GOOD}[channel.priors]\nmass_kg = {value}\n"))
                .contains(":24: channel \"wire\": priors.mass_kg is")
        );
    }
    assert_eq!(of(&format!("{GOOD}[channel.priors]\nmass_kg = \"20%\"\nambient_c = 3\n")), "accepted");
    with("[channel.priors]\n\"thermal.draught.gain\" = 0.2\n\"kinetic.lag.seconds\" = \"50 %\"\n", "accepted");
    with(
        "[channel.priors]\nthermal.draught.gain = 0.2\n",
        "rig.toml:24: channel \"wire\": priors.thermal is unknown; \
         write the name of an effect's number in quotes, such as \"thermal.draught.gain\"",
    );
}

#[test]
fn noise_of_sensors() {
    let noise = |body: &str| format!("[channel.sensors]\nposition_zero = \"free\"\n[channel.sensors.noise]\n{body}\n");
    with(
        &noise("position_m = 0.0"),
        "rig.toml:26: channel \"wire\": sensors.noise.position_m is 0, expected 1e-12 to 1000000",
    );
    with(
        &noise("supply_v = 0.003"),
        "rig.toml:26: channel \"wire\": sensors.noise.supply_v is unknown; \
         expected current_a, v1_v, v2_v, v3_v, force_n, position_m, temperature_c, power_w",
    );
    with(
        &noise("position = 1e-5"),
        "rig.toml:26: channel \"wire\": sensors.noise.position is unknown, did you mean position_m?",
    );
    with(
        "[channel.sensors]\nnoise = 0.003\n",
        "rig.toml:24: channel \"wire\": sensors.noise is 0.003, expected a table: [channel.sensors.noise]",
    );
    // Noise is no place where a key of that name belongs.
    with(
        "[channel.initial]\nforce_n = 3\n",
        "rig.toml:24: channel \"wire\": initial.force_n is unknown; expected temperature_c, martensite",
    );
    let rig = Rig::parse(&format!("{GOOD}{}", noise("position_m = 1.5e-5\nv3_v = 0.002")), "").unwrap();
    let noise: Vec<(&str, f64)> = rig.channels[0].noise.iter().map(|(key, rms)| (key.as_str(), *rms)).collect();
    assert_eq!(noise, [("position_m", 1.5e-5), ("v3_v", 0.002)]);
}

#[test]
fn effects() {
    const GAIN: &str = "-0.95 to 20";
    let draught = |body: &str| format!("[channel.effects.\"thermal.draught\"]\n{body}\n");
    with(&draught("gain = 0.35\nstart_s = 33.0\nend_s = 52.0"), "accepted");
    with(
        &draught("gain = 0.35\nend_s = 52.0"),
        "rig.toml:23: channel \"wire\": effects.\"thermal.draught\".start_s is missing, \
         expected when it begins, in s from the first sample",
    );
    with(
        &draught("gain = 0.35\nstart_s = 52.0\nend_s = 33"),
        "rig.toml:26: channel \"wire\": effects.\"thermal.draught\".end_s is 33, expected more than start_s, 52",
    );
    with(
        &draught("gain = nan"),
        &format!("rig.toml:24: channel \"wire\": effects.\"thermal.draught\".gain is nan, expected a number, {GAIN}"),
    );
    with(
        &draught("gain = -2"),
        &format!("rig.toml:24: channel \"wire\": effects.\"thermal.draught\".gain is -2, expected {GAIN}"),
    );
    with(
        "[channel.effects.\"sensing.delay\"]\nseconds = 0.02\nsensor = \"force\"\n",
        "rig.toml:25: channel \"wire\": effects.\"sensing.delay\".sensor is \"force\", expected \"position_m\", \
         \"force_n\", \"current_a\" or \"voltages\"; did you mean \"force_n\"?",
    );
    with(
        "[channel.effects.\"sensing.delay\"]\nsensor = 3\n",
        "rig.toml:24: channel \"wire\": effects.\"sensing.delay\".sensor is 3, expected a name in quotes",
    );
    with(
        "[channel.effects.\"thermal.draft\"]\n",
        "rig.toml:23: channel \"wire\": effects.\"thermal.draft\" is unknown, did you mean \"thermal.draught\"?",
    );
    with(
        "[channel.effects.\"thermal.latent_heat\"]\n",
        "rig.toml:23: channel \"wire\": effects.\"thermal.latent_heat\" is unknown here: \
         it is part of the reference model, set latent_heat_j_per_kg in [channel.material]",
    );
    with(
        "[channel.effects.thermal.draught]\n",
        "rig.toml:23: channel \"wire\": effects.\"thermal\" is unknown as an effect; \
         write its id in quotes, such as [channel.effects.\"thermal.draught\"]",
    );
    with(
        "[channel.effects.\"kinetic.lag\"]\nsecond = 0\n",
        "rig.toml:24: channel \"wire\": effects.\"kinetic.lag\".second is unknown, did you mean seconds?",
    );
    with(
        "[channel.effects.\"thermal.neighbour\"]\nchannel = \"wires\"\n",
        "rig.toml:24: channel \"wire\": effects.\"thermal.neighbour\".channel is \"wires\", \
         expected the name of a channel; did you mean \"wire\"?",
    );
    with(
        "[channel.effects.\"thermal.neighbour\"]\nchannel = \"wire\"\n",
        "rig.toml:24: channel \"wire\": effects.\"thermal.neighbour\".channel is the channel itself, \
         expected another, or none for a body at ambient",
    );
    let furnace = format!("{}[channel.drive]\nkind = \"temperature\"\n", draught("gain = 1\nstart_s = 0\nend_s = 9"));
    assert_eq!(
        messages("[channel.drive]\nsupply_v = 6.0\n", &furnace),
        "rig.toml:15: channel \"wire\": effects.\"thermal.draught\" has nothing to act on with this drive, load, taps and criterion; \
         take it out",
    );
    // At their null all are accepted, whatever their other parameters say.
    with(&draught("gain = 0\nstart_s = 33.0"), "accepted");
    with("[channel.effects.\"kinetic.asymmetry\"]\nheating_skew = 1.0\ncooling_skew = 1\n", "accepted");
    with("[channel.effects.\"thermal.sheath\"]\n", "accepted");
}

#[test]
fn columns() {
    with(
        "[recording.columns]\nposition = \"Pos\"\n",
        "rig.toml:24: recording.columns.position is unknown, did you mean position_m?",
    );
    with(
        "[recording.columns]\nposition_m = { column = \"Pos\", scale = 0 }\n",
        "rig.toml:24: recording.columns.position_m.scale is 0, \
         expected the factor from the foreign unit to the contract's",
    );
    with(
        "[recording.columns]\nposition_m = { scale = 2 }\n",
        "rig.toml:24: recording.columns.position_m.column is missing, expected the foreign column's name",
    );
    let text = format!("{GOOD}[recording.columns]\nposition_m = {{ column = \"Pos\", scale = -1.0 }}\nduty = \"D\"\n");
    let rig = Rig::parse(&text, "").unwrap();
    assert_eq!((rig.recording.columns["position_m"].scale, rig.recording.columns["position_m"].offset), (-1.0, 0.0));
    assert_eq!((rig.recording.columns["duty"].column.as_str(), rig.recording.columns["duty"].scale), ("D", 1.0));
}

#[test]
fn the_format_of_foreign_files() {
    with(
        "[recording.format]\nseperator = \";\"\n",
        "rig.toml:24: recording.format.seperator is unknown, did you mean separator?",
    );
    for (line, says) in [
        ("separator = \"; \"", "recording.format.separator is the text \"; \", expected what stands between cells"),
        ("decimal = \"comma\"", "recording.format.decimal is the text \"comma\", expected \".\" or \",\""),
        ("dates = \"german\"", "recording.format.dates is the text \"german\", expected \"dmy\", \"mdy\" or \"ymd\""),
        ("header_line = -1", "recording.format.header_line is -1, expected the line on which the names begin"),
        ("first_line = \"7\"", "recording.format.first_line is the text \"7\", expected the line of the first row"),
        ("sheet = 1", "recording.format.sheet is 1, expected the name of the sheet"),
    ] {
        let error = Rig::parse(&format!("{GOOD}[recording.format]\n{line}\n"), "rig.toml").unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
    let text =
        "[recording.format]\nseparator = \"\\t\"\ndecimal = \",\"\nfirst_line = 7\n[recording.columns]\nduty = \"D\"\n";
    let rig = Rig::parse(&format!("{GOOD}{text}"), "").unwrap();
    let mapping = Mapping::parse(text, "map.toml").unwrap();
    assert_eq!(rig.recording, mapping, "a file of its own says the same");
    let format = &mapping.format;
    assert_eq!(
        (format.separator.as_deref(), format.decimal.as_deref(), format.first_line),
        (Some("\t"), Some(","), Some(7))
    );
    assert_eq!(format.header_line, None);
    let remarks = [("duty".to_string(), "of 255\nduty = 1".to_string()), (String::new(), "not used: x".to_string())];
    let written = mapping.to_toml(&["of a \"file\"".to_string()], &remarks);
    assert_eq!(Mapping::parse(&written, "").unwrap(), mapping, "{written}");
    assert!(written.starts_with("# of a \"file\"\n") && written.contains("# of 255 duty = 1\nduty = {"), "{written}");
    let error = Mapping::parse("[rig]\nname = \"x\"\n", "map.toml").unwrap_err().to_string();
    assert!(error.contains("map.toml:1: rig is unknown; a mapping has [recording.format]"), "{error}");
}

#[test]
fn simulated_faults() {
    let fault = |body: &str| format!("[[simulation.fault]]\n{body}\n");
    with(
        &fault("kind = \"open\"\nstart_s = 1"),
        "rig.toml:24: simulation.fault.kind is \"open\", expected \"open_wire\", \"shorted_wire\", \"probe_lost\", \
         \"contact_resistance\", \"probe_stuck\", \"supply_dip\", \"supply_high\", \
         \"stage_on\", \"stage_weak\", \"write_fails\", \"jammed\", \"adc_stuck\", \"adc_saturated\", \"adc_nan\", \"backend_error\", \"estop_open\" \
         or \"estop_reset\"; did you mean \"open_wire\"?",
    );
    with(
        &fault("kind = \"open_wire\""),
        "rig.toml:23: simulation.fault.start_s is missing, expected when it begins, in s",
    );
    with(
        &fault("kind = \"open_wire\"\nstart_s = 3\nend_s = 2"),
        "rig.toml:26: simulation.fault.end_s is 2, expected more than start_s, 3",
    );
    with(
        &fault("kind = \"adc_nan\"\nstart_s = 3\nvalue = 2"),
        "rig.toml:26: simulation.fault.value makes no sense with this kind; take it out",
    );
    with(
        &fault("kind = \"supply_dip\"\nstart_s = 3\nvalue = 2"),
        "rig.toml:26: simulation.fault.value is 2, expected 0 to 1",
    );
    with(
        &fault("channel = \"wires\"\nkind = \"supply_dip\"\nstart_s = 3"),
        "rig.toml:24: simulation.fault.channel is \"wires\", expected the name of a channel; did you mean \"wire\"?",
    );
    let text = format!("{GOOD}{}", fault("channel = \"wire\"\nkind = \"probe_lost\"\nstart_s = 3\nvalue = 1"));
    let rig = Rig::parse(&text, "").unwrap();
    let fault = &rig.simulation.faults[0];
    assert_eq!((fault.channel, fault.size(), fault.end_s), (Some(0), 1.0, f64::INFINITY));
    assert!(!fault.acts_at(2.9) && fault.acts_at(3.0) && fault.acts_at(1e9));
}

#[test]
fn backends() {
    let with = |more: &str, expected: &str| {
        let found = of(&format!("{GOOD}{more}"));
        assert!(found.contains(expected), "{found}");
    };
    with("[backend]\nkind = \"usb\"", "backend.kind is \"usb\", expected");
    with(
        "[backend]\nkind = \"serial\"",
        "backend.serial.port is missing, expected the device the front-end is on, such as \"/dev/ttyACM0\"",
    );
    with(
        "[backend.serial]\nport = \"\"",
        "backend.serial.port is \"\", expected a device: text without control characters",
    );
    with("[backend.serial]\nwatchdog_periods = 1", "backend.serial.watchdog_periods is 1, expected 2 to 1000");
    with("[backend.serial]\nbaud = 9600", "backend.serial.baud is unknown, did you mean baud_hz?");
    let serial = "[backend]\nkind = \"serial\"\nserial.port = \"/dev/ttyACM0\"\n";
    with(&format!("{serial}[simulation]\npace = \"as_fast_as_possible\""), "simulation.pace makes no sense with wires");

    let linux = "[backend]\nkind = \"linux\"\n";
    with(linux, "channel \"wire\": linux.pwm is missing, expected the output, such as \"pwmchip0/1\"");
    with(linux, "linux.current is missing");
    with("[backend.linux]\nguard_ms = 5", "backend.linux.guard_ms is 5, expected 20 to 1000");
    let places = "linux = { pwm = \"pwmchip0/1\", v3 = \"1-0048:in_voltage2\", current = \"1-0048:in_current0\", \
                  v1 = \"1-0048:in_voltage0\", v2 = \"1-0048:in_voltage1\" }";
    let placed = GOOD.replacen("[[channel]]", &format!("[[channel]]\n{places}"), 1) + "\n" + linux;
    let rig = Rig::parse(&placed, "rig.toml").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(rig.channels[0].backend.linux.current.name.as_deref(), Some("1-0048:in_current0"));
    assert_eq!(
        (rig.channels[0].backend.linux.v1.gain, rig.channels[0].backend.linux.supply.name.as_ref()),
        (1.0, None)
    );
    let nothing = placed.replacen("pwmchip0/1\"", "pwmchip0/1\", v2_gain = 0.0", 1);
    assert!(of(&nothing).contains("linux.v2_gain is 0: nothing could be measured"), "{}", of(&nothing));

    let second = GOOD.find("[[channel]]").map(|at| GOOD[at..].replace("\"wire\"", "\"other\"")).unwrap();
    let both = format!("{GOOD}\n{second}\n{serial}");
    let rig = Rig::parse(&both, "rig.toml").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!([0, 1, 2].map(|channel| rig.front_end_index(channel)), [Some(0), Some(1), None]);
    let same = both.replacen("[[channel]]", "[[channel]]\nfront_end = { index = 1 }", 1);
    let error = Rig::parse(&same, "rig.toml").unwrap_err().to_string();
    assert!(error.contains("front_end.index is 1, where channel \"wire\" is already"), "{error}");
}

#[test]
fn all_mistakes_at_once_in_the_order_of_their_lines() {
    let text = GOOD
        .replace("rate_hz = 1000.0", "rate_hz = \"fast\"")
        .replace("mass_kg = 0.2", "mass = 0.2")
        .replace("diameter_mm = 0.125", "diameter_mm = nan");
    let error = Rig::parse(&text, "rig.toml").unwrap_err();
    let lines: Vec<usize> = error.problems().iter().map(|p| p.line).collect();
    assert_eq!(lines, [3, 9, 18, 19], "{error}");
}

#[test]
fn syntax() {
    let error = of("[rig]\nname = \"a\nrate_hz = 3\n");
    assert!(error.starts_with("rig.toml:2: not TOML: "), "{error}");
    let error = of("[rig]\nname = \"a\"\nname = \"b\"\n");
    assert!(error.starts_with("rig.toml:3: not TOML: duplicate key"), "{error}");
    // A recording given in place of a rig file.
    let error = of("time_s,duty\n0.0,0.1\n");
    assert!(error.starts_with("rig.toml:1: not TOML: "), "{error}");
}

#[test]
fn unreadable_files() {
    let error = Rig::load(std::path::Path::new("/no/such/rig.toml")).unwrap_err();
    assert!(matches!(&error, Error::Unreadable { file, .. } if file == "/no/such/rig.toml"));
    let error = Rig::load(std::path::Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap_err();
    assert!(matches!(error, Error::Unreadable { .. }));
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("not-text.toml");
    std::fs::write(&path, b"[rig]\nname = \"\xff\"\n").unwrap();
    let error = Rig::load(&path).unwrap_err().to_string();
    assert!(error.ends_with("not-text.toml: cannot be read: line 2 is not UTF-8 text; is this a rig file?"), "{error}");
}

#[test]
fn a_shared_input_needs_a_shunt_room_and_an_off_phase() {
    let shared = "[channel.adc]\ncircuit = \"shared\"\n";
    with(
        shared,
        "rig.toml:24: channel \"wire\": adc.circuit is \"shared\", but shunt_ohm + switch_ohm = 0 Ω show the current by 0.00 mV \
         only, in 1.5 mV of noise; expected more than 16 times the noise: a larger shunt, or a better converter",
    );
    let circuit = "[channel.drive]\nsupply_v = 6.0\nshunt_ohm = 0.1\n";
    let drive = "[channel.drive]\nsupply_v = 6.0\n";
    let more = |more: &str| of(&format!("{}{shared}{more}", GOOD.replace(drive, circuit)));
    assert_eq!(more(""), "accepted");
    // A current range of its own is not what limits it.
    assert_eq!(more("current_range_a = 0.1\n"), "accepted");
    assert_eq!(
        more("voltage_range_v = 5.0\n"),
        "rig.toml:26: channel \"wire\": adc.voltage_range_v is 5, but the shared input sees the whole supply_v, 6; \
         expected more"
    );
    assert_eq!(
        more("[channel.limits]\nmaximum_duty = 0.99\n"),
        "rig.toml:27: channel \"wire\": limits.maximum_duty leaves no off-phase to see the supply in: maximum_duty 0.99 and \
         sensing_duty 0.02 must not be more than 1 together"
    );
    assert_eq!(
        more("[channel.limits]\nmaximum_current_a = 200\n"),
        "rig.toml:27: channel \"wire\": limits.maximum_current_a is 200, but a shared input over 0.1 Ω ends at 100 A; \
         expected less"
    );
    let text = format!("{}{shared}", GOOD.replace(drive, circuit));
    let rig = Rig::parse(&text, "").unwrap();
    assert_eq!(rig.channels[0].limits.max_duty, 0.98);
    // Written back in its place.
    let mut separate = rig.clone();
    separate.channels[0].adc.circuit = sinew_rig::SamplingCircuit::SeparateTaps;
    let text = separate.to_toml();
    assert!(text.contains("circuit = \"separate_taps\""), "{text}");
    assert_eq!(Rig::parse(&text, "").unwrap().channels[0].adc.circuit, sinew_rig::SamplingCircuit::SeparateTaps);
}

#[test]
fn a_demonstrator_has_a_wire_that_can_move_it() {
    let ball = |more: &str, expected: &str| with(&format!("[demonstrator]\nkind = \"ball_on_beam\"\n{more}"), expected);
    ball("", "accepted");
    ball("channel = \"wire\"\n", "accepted");
    ball(
        "channel = \"wiar\"\n",
        "rig.toml:25: demonstrator.channel is \"wiar\", expected the name of a channel; did you mean \"wire\"?",
    );
    ball(
        "start_mm = 130\n",
        "rig.toml:25: demonstrator.start_mm is 130, beside the beam, which ends 120 mm from its pivot",
    );
    ball(
        "draught_for_s = 5\ndraught_every_s = 4\n",
        "rig.toml:26: demonstrator.draught_every_s is 4, expected more than draught_for_s, 5",
    );
    ball(
        "jitter_us = 1\n",
        "rig.toml:25: demonstrator.jitter_us makes no sense without pulses; take it out, or set kind = \"servo\"",
    );
    with(
        "[demonstrator]\nkind = \"arm\"\n",
        "rig.toml:24: demonstrator.elbow_channel is missing, expected a second channel, for the elbow",
    );
    with(
        "[demonstrator]\nkind = \"arm\"\nelbow_channel = \"wire\"\n",
        "rig.toml:25: demonstrator.elbow_channel is the shoulder's, \"wire\"; expected another channel",
    );
    ball(
        "upper_link_mm = 100\n",
        "rig.toml:25: demonstrator.upper_link_mm makes no sense without links; take it out, or set kind = \"arm\" or \"torso\"",
    );
    ball(
        "elbow_channel = \"wire\"\n",
        "rig.toml:25: demonstrator.elbow_channel makes no sense without an arm; take it out, or set kind = \"arm\"",
    );
    ball(
        "paddle_g = 8\n",
        "rig.toml:25: demonstrator.paddle_g makes no sense without a paddle; take it out, or set kind = \"torso\"",
    );
    with(
        "[demonstrator]\nkind = \"servo\"\nball_g = 3\n",
        "rig.toml:25: demonstrator.ball_g makes no sense without a ball; take it out, or set kind = \"ball_on_beam\" or \"torso\"",
    );
    with(
        "[demonstrator]\nkind = \"torso\"\n",
        "rig.toml:24: demonstrator.channel has too few channels from there on: two arms of four wires are 8, the rig has 1",
    );
    let torso = include_str!("../../../../examples/torso.toml");
    assert_eq!(of(torso), "accepted");
    assert_eq!(
        of(&torso.replace("start_mm = 30.0", "start_mm = -80")),
        "rig.toml:84: demonstrator.start_mm is -80, beside the paddle, which ends 80 mm from its middle"
    );
    assert_eq!(
        of(&torso.replace("ball_g", "half_beam_mm = 100\nball_g")),
        "rig.toml:83: demonstrator.half_beam_mm makes no sense without a beam; take it out, or set kind = \"ball_on_beam\""
    );
    assert_eq!(
        of(&torso.replace("paddle_g = 8.0", "paddle_g = 40.0")),
        "rig.toml:81: demonstrator.paddle_g is 40, but with spring, arm, paddle and ball \"right_elbow\" pulls with 5.5 N where it is level; expected \
         more than 0, or it hangs slack, and at most 3.3, or it tires soon: another weight, lever_mm or preload_n"
    );
    // a forearm that hangs over behind is drawn up by its weight
    assert_eq!(
        of(&torso.replace("elbow_degrees = 95.0", "elbow_degrees = 275.0")),
        "rig.toml:81: demonstrator.paddle_g is 8, but with spring, arm, paddle and ball \"right_elbow\" pulls with -1.4 N where it is level; expected \
         more than 0, or it hangs slack, and at most 3.3, or it tires soon: another weight, lever_mm or preload_n"
    );
    with(
        "[demonstrator]\nkind = \"servo\"\ndegrees_per_ms = 0\n",
        "rig.toml:25: demonstrator.degrees_per_ms is 0: no pulse would turn it; expected more or less",
    );
    with(
        "[demonstrator]\nkind = \"hexapod\"\n",
        "rig.toml:24: demonstrator.channel has too few channels from there on: six legs of three wires are 18, the rig has 1",
    );
    let walker = include_str!("../../../../examples/walker.toml");
    assert_eq!(of(walker), "accepted");
    assert_eq!(
        of(&walker.replace("body_g = 60.0", "body_g = 200.0")),
        "rig.toml:139: demonstrator.body_g is 200, but on three legs, where a middle one bears half of it, the spring of \"front_left_femur\" \
         holds no more than 111; expected at most that, a longer lever_mm or a larger preload_n"
    );
    assert_eq!(
        of(&walker.replace("body_g", "belly_mm = 50.0\nbody_g")),
        "rig.toml:139: demonstrator.belly_mm is 50, but its legs lift the hips by 39.0 mm; expected less than that"
    );
    ball(
        "coxa_mm = 10\n",
        "rig.toml:25: demonstrator.coxa_mm makes no sense without legs; take it out, or set kind = \"hexapod\"",
    );
    assert_eq!(
        of(&format!("{}[demonstrator]\nkind = \"servo\"\n", GOOD.replace("mass_kg = 0.2", "kind = \"imposed_force\""))),
        "rig.toml:24: demonstrator.channel is \"wire\", whose load does not move by itself; expected one with a mass_kg"
    );
    with(
        "[demonstrator]\nkind = \"servo\"\n[backend]\nkind = \"serial\"\n[backend.serial]\nport = \"/dev/ttyACM0\"\n",
        "rig.toml:24: demonstrator.kind makes no sense with wires that are not simulated; take it out",
    );
}
