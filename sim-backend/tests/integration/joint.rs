//! Two simulated wires on one joint, from the driver's side of the contract.

use sinew_backend::{Backend, Sample};
use sinew_physics::{Inputs, JointMotion};
use sinew_rig::{FaultKind, Rig};
use sinew_sim_backend::{SimulatedRig, World};

/// A free wire between the two of a joint, all at 1 kHz.
fn rig() -> Rig {
    let text = "[rig]\nname = \"bench\"\n\n\
        [[channel]]\nname = \"extensor\"\nwire = { diameter_mm = 0.1, length_mm = 160.0 }\ntaps = { ls_mm = 150.0 }\n\
        drive = { supply_v = 9.0, shunt_ohm = 0.1 }\n\n\
        [[channel]]\nname = \"free\"\nwire = { diameter_mm = 0.125, length_mm = 160.0 }\n\
        drive = { supply_v = 6.0, shunt_ohm = 0.1 }\nload = { mass_kg = 0.2 }\n\n\
        [[channel]]\nname = \"flexor\"\nwire = { diameter_mm = 0.125, length_mm = 160.0 }\ntaps = { ls_mm = 150.0 }\n\
        drive = { supply_v = 6.0, shunt_ohm = 0.1 }\n\n\
        [[joint]]\nname = \"knee\"\nagonist = \"flexor\"\nantagonist = \"extensor\"\nradius_mm = 8.0\n\
        inertia_kg_mm2 = 2.5\nspring_n_mm = 5.0\ntorque_n_mm = 1.0\n";
    Rig::parse(text, "bench.toml").unwrap_or_else(|e| panic!("{e}"))
}

fn started(rig: &Rig) -> SimulatedRig {
    let mut backend = SimulatedRig::new(rig).unwrap_or_else(|e| panic!("{e}"));
    backend.start().unwrap();
    backend
}

/// Duties that work the joint to and fro.
fn duties(tick: usize) -> [f64; 3] {
    let phase = (tick as f64 * 2e-3).sin();
    [0.22 - 0.18 * phase, 0.1, 0.25 + 0.2 * phase]
}

#[test]
fn its_joint_is_the_joint_of_the_physics() {
    let rig = rig();
    let mut backend = started(&rig);
    let [flexor, free, extensor] = [2, 1, 0].map(|index| &rig.channels[index].model);
    let mut motion = JointMotion::new(&rig.joints[0].mechanics, [flexor, extensor]).unwrap();
    let mut wires = [motion.wire(0, flexor).unwrap(), motion.wire(1, extensor).unwrap()];
    let mut alone = sinew_physics::Wire::new(free).unwrap();
    let mut samples = [Sample::NONE; 3];
    let mut before = [0.0; 3];
    let mut travel = (0.0_f64, 0.0_f64);
    for tick in 0..8000 {
        let duty = duties(tick);
        backend.exchange(&duty, &mut samples).unwrap();
        let inputs = [
            Inputs { drive: before[2], ..flexor.rest_inputs() },
            Inputs { drive: before[0], ..extensor.rest_inputs() },
        ];
        let [agonist, antagonist] = &mut wires;
        motion.step([agonist, antagonist], [&inputs[0], &inputs[1]], 0.0, 1e-3);
        alone.step(&Inputs { drive: before[1], ..free.rest_inputs() }, 1e-3);
        before = duty;

        let joint = backend.joint(0).unwrap();
        assert_eq!(joint.angle_rad(), motion.angle_rad(), "period {tick}");
        for (channel, wire) in [(2, &wires[0]), (0, &wires[1]), (1, &alone)] {
            let truth = backend.truth(channel).unwrap();
            assert_eq!(truth.temperature_c, wire.temperature_c());
            assert!((truth.force_n - wire.tension_n()).abs() < 1e-9);
        }
        travel = (travel.0.min(joint.angle_rad()), travel.1.max(joint.angle_rad()));
    }
    assert!(travel.1 - travel.0 > 0.2, "{travel:?}");
    // the lengths of the two wires always add up to the same
    let sum = backend.truth(0).unwrap().length_m + backend.truth(2).unwrap().length_m;
    let rest = rig.joints[0].mechanics.rest_m([flexor, extensor]).unwrap();
    assert!((sum - 0.32 - rest[0] - rest[1]).abs() < 1e-12);
    assert!(backend.joint(1).is_none());
}

#[test]
fn every_joule_and_every_period_is_accounted_for() {
    let rig = rig();
    let (mut late, mut punctual) = (started(&rig), started(&rig));
    let mut samples = [Sample::NONE; 3];
    let mut mean_j = [0.0; 3];
    for tick in 0..8000 {
        punctual.exchange(&duties(tick / 4 * 4), &mut samples).unwrap();
        for (channel, sum) in mean_j.iter_mut().enumerate() {
            *sum += punctual.truth(channel).unwrap().power_w * 1e-3;
        }
        if tick % 4 == 0 {
            // three periods pass under the duty just put out
            late.exchange(&duties(tick), &mut samples).unwrap();
            late.missed(3);
        }
    }
    assert_eq!(late.joint(0).unwrap().angle_rad(), punctual.joint(0).unwrap().angle_rad());
    for (channel, sum) in mean_j.into_iter().enumerate() {
        let energy = punctual.energy(channel).unwrap();
        assert!((sum / energy.heat_in_j - 1.0).abs() < 1e-9, "channel {channel}: {sum} of {energy:?}");
        assert!(energy.residual_j().abs() < 1e-6 * energy.heat_in_j, "{energy:?}");
    }
    let joint = punctual.joint(0).unwrap().energy();
    let moved = joint.wires_j[0].abs() + joint.damping_j;
    assert!(moved > 1e-3 && joint.residual_j().abs() < 2e-3 * moved, "{joint:?}");
}

#[test]
fn what_breaks_on_one_wire_is_felt_by_the_other() {
    let rig = rig();
    let (mut whole, mut broken) = (started(&rig), started(&rig));
    let mut samples = [Sample::NONE; 3];
    let mut run = |backend: &mut SimulatedRig, ticks: std::ops::Range<usize>| {
        ticks.for_each(|tick| backend.exchange(&duties(tick), &mut samples).unwrap());
        (backend.truth(0).unwrap(), backend.joint(0).unwrap().angle_rad())
    };
    assert_eq!(run(&mut whole, 0..3000), run(&mut broken, 0..3000));
    assert!(broken.faults().set(2, FaultKind::OpenWire));
    let (healthy, angle) = run(&mut whole, 3000..5000);
    let (pulled, turned) = run(&mut broken, 3000..5000);
    assert!(pulled.length_m < healthy.length_m - 5e-4, "the flexor lets go, the extensor shortens");
    assert!(turned < angle - 0.05, "{turned} of {angle}");
}

#[test]
fn a_pull_on_a_wires_end_turns_the_joint() {
    let rig = rig();
    let mut samples = [Sample::NONE; 3];
    let mut turned = |channel: usize| {
        let mut backend = started(&rig);
        backend.disturb(channel, &World { pull_n: 0.5, ..World::CALM });
        (0..3000).for_each(|tick| backend.exchange(&duties(tick), &mut samples).unwrap());
        backend.joint(0).unwrap().angle_rad()
    };
    let calm = turned(1);
    assert!(turned(0) > calm + 1e-3, "pulling at the extensor's end helps the flexor");
    assert!(turned(2) < calm - 1e-3, "and the other way round");
}
