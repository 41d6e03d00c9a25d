//! Joints in the rig file: two channels that turn one joint.

use sinew_physics::Load;
use sinew_rig::{JointAlgorithm, Rig};

const PAIR: &str = r#"[rig]
name = "bench"

[[channel]]
name = "flexor"
wire = { diameter_mm = 0.125, length_mm = 160.0 }
taps = { ls_mm = 150.0 }
drive = { supply_v = 6.0 }

[[channel]]
name = "extensor"
wire = { diameter_mm = 0.1, length_mm = 160.0 }
drive = { supply_v = 6.0 }

[[channel]]
name = "third"
wire = { diameter_mm = 0.1, length_mm = 160.0 }
drive = { supply_v = 6.0 }
load = { mass_kg = 0.1 }

[[joint]]
name = "knee"
agonist = "flexor"
antagonist = "extensor"
radius_mm = 8.0          # to the pin
inertia_kg_mm2 = 2.5
"#;

fn of(text: &str) -> String {
    match Rig::parse(text, "rig.toml") {
        Ok(_) => "accepted".into(),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
fn says(from: &str, to: &str, expected: &str) {
    assert_eq!(PAIR.matches(from).count(), 1, "{from}");
    assert_eq!(of(&PAIR.replace(from, to)), expected);
}

#[test]
fn a_joint_is_read_with_its_defaults() {
    let rig = Rig::parse(PAIR, "rig.toml").unwrap_or_else(|e| panic!("{e}"));
    rig.check_drivable().unwrap();
    let joint = &rig.joints[0];
    let thin = rig.channels[1].model.geometry.area_m2();
    assert_eq!((joint.mechanics.radius_m, joint.mechanics.inertia_kg_m2), (0.008, 2.5e-6));
    let stiffness: f64 = [0, 1].map(|i| 75e9 * rig.channels[i].model.geometry.area_m2() / 0.16).iter().sum();
    let critical = 2.0 * (0.008 * 0.008 * stiffness * 2.5e-6_f64).sqrt();
    assert!((joint.mechanics.damping_n_m_s / (0.3 * critical) - 1.0).abs() < 1e-12);
    assert!((joint.mechanics.pretension_n - 100e6 * thin).abs() < 1e-12);
    assert!((joint.max_tension_n - 500e6 * thin).abs() < 1e-12);
    assert_eq!(joint.min_tension_n, 0.5 * joint.mechanics.pretension_n);
    assert_eq!((joint.mechanics.spring_n_m, joint.mechanics.torque_n_m), (0.0, 0.0));
    assert_eq!(rig.channels_of(joint), Some([0, 1]));
    assert_eq!(rig.joint_of(1).map(|(joint, side)| (joint.name.as_str(), side)), Some(("knee", 1)));
    assert!(rig.joint_of(2).is_none());
    for index in [0, 1] {
        assert_eq!(rig.channels[index].model.load, Load::ImposedPosition);
        let nominal = rig.nominal_model(index);
        let hot = sinew_physics::hot_length_m(&nominal).unwrap();
        let cold = sinew_physics::cold_length_m(&nominal).unwrap();
        let limits = &rig.channels[index].limits;
        assert!(cold - hot > 0.006 && limits.min_length_m < hot && cold < limits.max_length_m);
        // the tightest the pair gets shifts A the furthest
        let m = &rig.channels[index].model;
        let shift = joint.max_tension_n / m.geometry.area_m2() * m.material.stress_shift_k_per_pa;
        assert!((limits.max_temperature_c - (93.0 + 60.0 + shift)).abs() < 1e-9, "{}", limits.max_temperature_c);
    }
    assert!(matches!(rig.nominal_model(2).load, Load::SpringMassDamper { mass_kg: 0.1, .. }));
    // what the load is may be said
    assert_eq!(
        of(&PAIR.replacen("{ supply_v = 6.0 }", "{ supply_v = 6.0 }\nload.kind = \"imposed_position\"", 1)),
        "accepted"
    );
}

#[test]
fn every_mistake_has_its_line_and_its_remedy() {
    says(
        "antagonist = \"extensor\"",
        "antagonist = \"extensr\"",
        "rig.toml:10: channel \"extensor\": load.mass_kg is missing, \
         expected the moving mass in kg, such as 0.2 (or another load kind)\n\
         rig.toml:24: joint.antagonist is \"extensr\", expected the name of a channel; did you mean \"extensor\"?",
    );
    says(
        "agonist = \"flexor\"\nantagonist = \"extensor\"",
        "agonist = \"flexor\"\nantagonist = \"flexor\"",
        "rig.toml:10: channel \"extensor\": load.mass_kg is missing, \
         expected the moving mass in kg, such as 0.2 (or another load kind)\n\
         rig.toml:24: joint.antagonist is the agonist \"flexor\" itself, expected another channel",
    );
    let second = "\n[[joint]]\nname = \"hip\"\nagonist = \"extensor\"\nantagonist = \"third\"\nradius_mm = 8\n\
                  inertia_kg_mm2 = 2.5\n";
    assert_eq!(
        of(&format!("{}{second}", PAIR.replace("load = { mass_kg = 0.1 }\n", "\n"))),
        "rig.toml:30: joint.agonist is \"extensor\", which turns joint \"knee\" already (line 24); expected another channel"
    );
    assert_eq!(
        of(&format!("{PAIR}{}", second.replace("extensor", "flexor").replace("hip", "knee"))),
        "rig.toml:19: channel \"third\": load.mass_kg makes no sense: the wire turns joint \"knee\" and has no load of its own; \
         take [channel.load] out\n\
         rig.toml:29: joint.name \"knee\" is used twice, first in line 22; expected a name of its own\n\
         rig.toml:30: joint.agonist is \"flexor\", which turns joint \"knee\" already (line 23); expected another channel"
    );
    says(
        "name = \"knee\"",
        "name = \"third\"",
        "rig.toml:22: joint.name \"third\" is a channel's; expected a name of its own",
    );
    says(
        "inertia_kg_mm2 = 2.5",
        "inertia_kg_mm2 = 0.0001",
        "rig.toml:26: joint.inertia_kg_mm2 is 0.0001, expected 0.00169931059 to 1000000000",
    );
    says(
        "inertia_kg_mm2 = 2.5\n",
        "",
        "rig.toml:21: joint.inertia_kg_mm2 is missing, expected the moment of inertia in kg mm², such as 2.5",
    );
    says(
        "inertia_kg_mm2 = 2.5",
        "inertia_kg_mm2 = 2.5\npretension_n = 1\ntension_n = 5",
        "rig.toml:28: joint.tension_n leaves no tension: minimum_tension_n 0.5, tension_n 5, \
         maximum_tension_n 3.926990817; expected them in this order",
    );
    says(
        "inertia_kg_mm2 = 2.5",
        "inertia_kg_mm2 = 2.5\nradius = 8",
        "rig.toml:27: joint.radius is unknown, did you mean radius_mm?",
    );
    says(
        "radius_mm = 8.0 ",
        "radius_mm = nan ",
        "rig.toml:25: joint.radius_mm is nan, expected a number, 0.01 to 10000",
    );
    says(
        "drive = { supply_v = 6.0 }\n\n[[channel]]\nname = \"third\"",
        "drive = { supply_v = 6.0 }\nlimits = { maximum_force_n = 2.0 }\n\n[[channel]]\nname = \"third\"",
        "rig.toml:14: channel \"extensor\": limits.maximum_force_n makes no sense: the tension of a joint's wires is limited \
         by joint \"knee\"; use its minimum_tension_n and maximum_tension_n",
    );
    says(
        "load = { mass_kg = 0.1 }",
        "load = { mass_kg = 0.1 }\nlimits = { minimum_force_n = 3.0, maximum_force_n = 2.0 }",
        "rig.toml:20: channel \"third\": limits.minimum_force_n leaves no tension: minimum_force_n is 3, maximum_force_n 2; \
         expected the minimum below the maximum",
    );
    let error = of(&PAIR.replace("[[joint]]", "[joint]"));
    let expected =
        "rig.toml:21: joint is a single table [joint], expected an array of tables: [[joint]], with two brackets";
    assert_eq!(error.lines().last(), Some(expected), "{error}");
}

#[test]
fn joints_are_written_and_read_again() {
    let mut rig = Rig::parse(PAIR, "rig.toml").unwrap();
    assert_eq!(rig.to_toml(), PAIR);
    rig.joints[0].mechanics.radius_m = 0.0095;
    rig.joints[0].tension_n = 1.25;
    let expected = PAIR
        .replace("radius_mm = 8.0          # to the pin", "radius_mm = 9.5          # to the pin")
        .replace("inertia_kg_mm2 = 2.5\n", "inertia_kg_mm2 = 2.5\ntension_n = 1.25\n");
    assert_eq!(rig.to_toml(), expected);
    let again = Rig::parse(&expected, "rig.toml").unwrap();
    // what was not written follows: the damping is that of the longer lever
    assert!(again.joints[0].mechanics.damping_n_m_s > rig.joints[0].mechanics.damping_n_m_s);
    rig.joints[0].mechanics.damping_n_m_s = again.joints[0].mechanics.damping_n_m_s;
    assert_eq!(again, rig);

    // taken away, its wires are held at an imposed position, and say so
    rig.joints.clear();
    let text = rig.to_toml();
    let again = Rig::parse(&text, "rig.toml").unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert!(again.joints.is_empty() && !text.contains("[[joint]]"));
    assert!(again.channels.iter().take(2).all(|channel| channel.model.load == Load::ImposedPosition));

    // and put back
    let mut back = again.clone();
    back.joints = Rig::parse(PAIR, "rig.toml").unwrap().joints;
    let text = back.to_toml();
    let again = Rig::parse(&text, "rig.toml").unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(again.joints, back.joints);
}

/// The law of a joint and its gains are read and written back; a law there is none of is refused with the words there are, and gains with a law
/// that takes none.
#[test]
fn a_joint_has_a_law_of_its_own() {
    assert_eq!(Rig::parse(PAIR, "rig.toml").unwrap().joints[0].algorithm, JointAlgorithm::Decoupling);
    let with = |keys: &str| format!("{PAIR}{keys}");
    let gains = "algorithm = \"differential_force\"\npi_proportional_per_mm = 3.0\npid_derivative_s_per_mm = 0.05\n";
    let rig = Rig::parse(&with(gains), "rig.toml").unwrap_or_else(|e| panic!("{e}"));
    let joint = &rig.joints[0];
    assert_eq!(joint.algorithm, JointAlgorithm::DifferentialForce);
    let given = (joint.proportional_per_m, joint.integral_per_m_s, joint.derivative_s_per_m);
    assert_eq!(given, (Some(3000.0), None, Some(50.0)));
    assert_eq!(Rig::parse(&rig.to_toml(), "rig.toml").unwrap(), rig);

    let words: Vec<&str> = JointAlgorithm::ALL.into_iter().map(|(word, _)| word).collect();
    let refused = of(&with("algorithm = \"relay\"\n"));
    assert!(refused.contains("joint.algorithm"), "{refused}");
    assert!(words.iter().all(|word| refused.contains(word)), "{refused}");
    let refused = of(&with("pi_integral_per_mm_s = 1.0\n"));
    assert!(refused.contains("joint.pi_integral_per_mm_s makes no sense with algorithm = \"decoupling\""), "{refused}");
    assert!(refused.contains("choose \"differential_force\""), "{refused}");
}
