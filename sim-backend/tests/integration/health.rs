//! Sensing detects the faults the virtual rig injects: both sides of the converter together.

use sinew_backend::{Backend, Sample};
use sinew_physics::{cold_length_m, hot_length_m};
use sinew_rig::{FaultKind, Rig, SamplingCircuit};
use sinew_sensing::{Converter, Health, LengthSensor, LengthSensorConfig, Method, WireEnd};
use sinew_sim_backend::SimulatedRig;

/// The sensor of the hexapod's first wire, from the rig file alone.
fn sensor(rig: &Rig) -> LengthSensor {
    let channel = &rig.channels[0];
    let (model, adc) = (&channel.model, &channel.adc);
    let taps = model.taps.unwrap();
    let area = model.geometry.area_m2();
    let (hot_m, cold_m) = (hot_length_m(model).unwrap(), cold_length_m(model).unwrap());
    let m = &model.material;
    let hot_ohm = (m.austenite_resistivity_ohm_m + 80.0 * m.austenite_resistivity_slope_ohm_m_per_k) * hot_m / area;
    let cold_ohm = m.martensite_resistivity_ohm_m * cold_m / area;
    let converter = Converter {
        // bits over 0 to the range there, over both signs here
        bits: adc.bits + 1,
        voltage_range_v: adc.voltage_range_v,
        current_range_a: adc.current_range_a,
        voltage_noise_v: adc.voltage_noise_v,
        current_noise_a: adc.current_noise_a,
    };
    let method = Method::DualMeasurement { l0_m: taps.l0_m, ls_m: taps.ls_m };
    let supply = model.drive.supply_v;
    let hot = WireEnd { resistance_ohm: hot_ohm, length_m: hot_m };
    let cold = WireEnd { resistance_ohm: cold_ohm, length_m: cold_m };
    let config = LengthSensorConfig::for_wire(method, area, supply, hot, cold, converter);
    let drive = &model.drive;
    let config = match adc.circuit {
        SamplingCircuit::SeparateTaps => config,
        SamplingCircuit::Shared => config.sharing(drive.shunt_ohm + drive.switch_ohm, drive.lead_ohm),
    };
    LengthSensor::new(config).unwrap()
}

struct Bench {
    backend: SimulatedRig,
    sensor: LengthSensor,
    duty: Vec<f64>,
    samples: Vec<Sample>,
}

impl Bench {
    fn new(circuit: SamplingCircuit) -> Bench {
        let mut rig = Rig::hexapod();
        for channel in &mut rig.channels {
            channel.adc.circuit = circuit;
        }
        let mut backend = SimulatedRig::new(&rig).unwrap();
        backend.start().unwrap();
        let channels = backend.channels();
        Bench { backend, sensor: sensor(&rig), duty: vec![0.02; channels], samples: vec![Sample::NONE; channels] }
    }

    fn period(&mut self) -> sinew_sensing::Reading {
        self.backend.exchange(&self.duty, &mut self.samples).unwrap();
        self.sensor.read(&self.samples[0])
    }
}

const CIRCUITS: [SamplingCircuit; 2] = [SamplingCircuit::SeparateTaps, SamplingCircuit::Shared];

#[test]
fn a_whole_cycle_of_a_healthy_wire_is_measured_without_a_gap() {
    CIRCUITS.into_iter().for_each(whole_cycle);
}

fn whole_cycle(circuit: SamplingCircuit) {
    let mut bench = Bench::new(circuit);
    bench.period();
    let mut worst = 0.0f64;
    let mut squares = 0.0;
    let mut expected = 0.0;
    for i in 0..8000 {
        bench.duty.fill(if i < 3000 { 0.4 } else { 0.02 });
        let reading = bench.period();
        assert_eq!(reading.health, Health::Ok, "period {i}: {:?}", bench.samples[0]);
        let truth = bench.backend.truth(0).unwrap();
        let error = reading.length_m - truth.length_m;
        worst = worst.max(error.abs() / reading.length_sigma_m);
        squares += error * error;
        expected += reading.length_sigma_m * reading.length_sigma_m;
    }
    // the sensor's own idea of its noise is that of the simulated converter
    let ratio = (squares / expected).sqrt();
    assert!((0.97..1.03).contains(&ratio), "{ratio}");
    assert!(worst < 6.0, "{worst} sigma");
}

#[test]
fn every_fault_is_recognised_and_none_passes_as_a_length() {
    CIRCUITS.into_iter().for_each(every_fault);
}

fn every_fault(circuit: SamplingCircuit) {
    // Of a shared input it is the input itself that touches nothing.
    let third: &[Health] = match circuit {
        SamplingCircuit::SeparateTaps => &[Health::ProbeLost, Health::ShortedWire],
        SamplingCircuit::Shared => &[Health::SupplyDip],
    };
    let cases: [(FaultKind, f64, &[Health]); 9] = [
        (FaultKind::OpenWire, 0.0, &[Health::OpenWire]),
        (FaultKind::ShortedWire, 0.05, &[Health::ShortedWire]),
        (FaultKind::ProbeLost, 1.0, &[Health::ProbeLost]),
        (FaultKind::ProbeLost, 2.0, &[Health::ProbeLost]),
        (FaultKind::ProbeLost, 3.0, third),
        (FaultKind::SupplyDip, 0.5, &[Health::SupplyDip]),
        (FaultKind::AdcSaturated, 0.0, &[Health::Saturated, Health::ShortedWire]),
        (FaultKind::AdcNan, 0.0, &[Health::NoSample]),
        (FaultKind::ContactResistance, 2.0, &[Health::OutOfRange, Health::ProbeLost]),
    ];
    for (kind, size, verdicts) in cases {
        let mut bench = Bench::new(circuit);
        for i in 0..1500 {
            bench.duty.fill(if i < 700 { 0.4 } else { 0.1 });
            bench.period();
        }
        bench.backend.faults().set_sized(0, kind, size);
        let mut passed = 0;
        for i in 0..2000 {
            let reading = bench.period();
            if (kind, size) == (FaultKind::ProbeLost, 1.0) && reading.health.is_ok() {
                // A floating first tap can wander through where it belongs; then it does little harm.
                let error_m = reading.length_m - bench.backend.truth(0).unwrap().length_m;
                assert!(error_m.abs() < 0.5e-3, "period {i}: {reading:?}");
                passed += 1;
                continue;
            }
            assert!(
                verdicts.contains(&reading.health),
                "{kind:?} {size}, period {i}: {reading:?} {:?}",
                bench.samples[0]
            );
        }
        assert!(passed <= 20, "{passed} of 2000 pass");
        bench.backend.faults().clear_all();
        let reading = bench.period();
        assert_eq!(reading.health, Health::Ok, "{kind:?} mended: {:?}", bench.samples[0]);
    }
}

#[test]
fn a_frozen_converter_is_recognised_within_the_sensors_own_limit() {
    for circuit in CIRCUITS {
        let mut bench = Bench::new(circuit);
        for _ in 0..100 {
            bench.period();
        }
        bench.backend.faults().set(0, FaultKind::AdcStuck);
        let limit = bench.sensor.stuck_after().all.expect("noise gives a limit");
        assert!(limit <= 5, "{circuit:?}: {limit} periods");
        for i in 0..limit + 10 {
            let health = bench.period().health;
            assert_eq!(health == Health::Stuck, i + 1 >= limit, "{circuit:?}: period {i} of {limit}: {health}");
        }
    }
}
