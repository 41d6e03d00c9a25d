//! Configures a channel from the rig file: sensor, observer, check of the taps, law, estimator; and the law of a joint.

use sinew_control::{
    AlgorithmKind, EstimatorKind, JointAlgorithmKind, JointGains, JointSettings, Modulation, PidGains, Priming,
    Segment, Settings, StrokeRange,
};
use sinew_physics::formulas::{SURELY_HOT_K, WORKING_EXCESS_K, heating_power_w, logit, resistance_ohm, stress_shift_k};
use sinew_physics::{Load, WireModel};
use sinew_rig::{
    Algorithm as RigAlgorithm, Channel as RigChannel, Estimator as RigEstimator, Joint as RigJoint,
    JointAlgorithm as RigJointAlgorithm, RapidHeating, SamplingCircuit, Sensing,
};
use sinew_sensing::{
    Bounds, Converter, Drive, LengthSensor, LengthSensorConfig, Method, ObserverConfig, ResistanceLine, SlideConfig,
    SlideWatch, WireEnd,
};

/// What a rig file says of a channel's law.
pub fn settings(channel: &RigChannel) -> Settings {
    let control = &channel.control;
    Settings {
        kind: AlgorithmKind::ALL[control.algorithm as usize],
        lambda_per_s: control.lambda_per_s,
        minimum_duty: control.minimum_duty,
        maximum_duty: channel.limits.max_duty,
        hold_band_m: None,
        modulation: Modulation::Switched,
        pid: Some(PidGains {
            proportional_per_m: control.pi_proportional_per_m,
            integral_per_m_s: control.pi_integral_per_m_s,
            derivative_s_per_m: control.pid_derivative_s_per_m,
            filter_s: PidGains::FILTER_S,
            tracking_s: PidGains::TRACKING_S,
        }),
        relay_band_m: control.relay_band_m,
        heat_loss_feedforward: control.heat_loss_feedforward,
        segment: Segment { digit: control.segment - 1, digits: control.segments },
        rapid_heating: match control.rapid_heating {
            RapidHeating::Off => None,
            RapidHeating::Temperature => Some(Priming::Temperature),
            RapidHeating::Resistance => Some(Priming::Resistance),
        },
    }
}

/// What a rig file says of a joint's law; its wires agonist first.
pub fn joint_settings(joint: &RigJoint, wires: [&RigChannel; 2]) -> JointSettings {
    JointSettings {
        gains: JointGains {
            proportional_per_m: joint.proportional_per_m,
            integral_per_m_s: joint.integral_per_m_s,
            derivative_s_per_m: joint.derivative_s_per_m,
        },
        joint: joint.mechanics,
        minimum_tension_n: joint.min_tension_n,
        tension_n: joint.tension_n,
        maximum_tension_n: joint.max_tension_n,
        minimum_duty: wires.map(|wire| wire.control.minimum_duty),
        maximum_duty: wires.map(|wire| wire.limits.max_duty),
    }
}

/// The law that a rig file asks for a joint.
pub fn joint_algorithm(joint: &RigJoint) -> JointAlgorithmKind {
    JointAlgorithmKind::ALL[joint.algorithm as usize]
}

/// The estimator that a rig file asks for.
pub fn estimator(channel: &RigChannel) -> EstimatorKind {
    EstimatorKind::ALL[channel.control.estimator as usize]
}

// The rig file's laws and estimators are those of `control` in the same order, so they are matched by index.
const _: () = {
    let mut i = 0;
    assert!(
        RigAlgorithm::ALL.len() == AlgorithmKind::ALL.len(),
        "the rig file lacks a law: run SINEW_BLESS=1 cargo test -p sinew-control"
    );
    while i < RigAlgorithm::ALL.len() {
        let (word, algorithm) = RigAlgorithm::ALL[i];
        assert!(algorithm as usize == i && is_same(word, AlgorithmKind::ALL[i].word()), "a law of another word");
        i += 1;
    }
    let mut i = 0;
    assert!(
        RigJointAlgorithm::ALL.len() == JointAlgorithmKind::ALL.len(),
        "the rig file lacks a law of a joint: run SINEW_BLESS=1 cargo test -p sinew-control"
    );
    while i < RigJointAlgorithm::ALL.len() {
        let (word, algorithm) = RigJointAlgorithm::ALL[i];
        assert!(
            algorithm as usize == i && is_same(word, JointAlgorithmKind::ALL[i].word()),
            "a joint's law of another word"
        );
        i += 1;
    }
    let mut i = 0;
    assert!(
        RigEstimator::ALL.len() == EstimatorKind::ALL.len(),
        "the rig file lacks an estimator: run SINEW_BLESS=1 cargo test -p sinew-control"
    );
    while i < RigEstimator::ALL.len() {
        let (word, estimator) = RigEstimator::ALL[i];
        assert!(estimator as usize == i && is_same(word, EstimatorKind::ALL[i].word()), "an estimator of another word");
        i += 1;
    }
};

/// Whether two words are the same; at compile time, where `==` is not to be had.
const fn is_same(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut i = 0;
    while i < one.len() && i < other.len() && one[i] == other[i] {
        i += 1;
    }
    i == one.len() && i == other.len()
}

/// One end of a wire's stroke, seen electrically.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ends {
    pub wire: WireEnd,
    pub current_a: f64,
}

impl Ends {
    pub fn of(model: &WireModel, hot: bool, length_m: f64) -> Ends {
        let m = &model.material;
        let resistivity = if hot {
            m.austenite_resistivity(m.austenite_temperature_c + SURELY_HOT_K)
        } else {
            m.martensite_resistivity(model.ambient_c)
        };
        let resistance_ohm = resistance_ohm(resistivity, length_m, model.geometry.area_m2());
        Ends { wire: WireEnd { resistance_ohm, length_m }, current_a: model.drive.on_current_a(resistance_ohm) }
    }

    pub fn power_w(&self) -> f64 {
        heating_power_w(1.0, self.current_a, self.wire.resistance_ohm)
    }
}

/// How far the wire may be from the rig file before the watch over its taps is wrong: heat capacity (with what else is heated)
/// and temperatures of transformation above ambient, relative; the loss to the air, as factors; the measured power.
const SLIDE_CAPACITY: f64 = 0.15;
const SLIDE_TEMPERATURE: f64 = 0.2;
const SLIDE_LOSS: Bounds = Bounds { least: 0.5, most: 2.0 };
const SLIDE_POWER: f64 = 0.05;

/// The watch over the taps. `None` where there are none, where something else than the channel's own load pulls at the wire
/// (in a joint the partner can hold it still however hot it is), or where the air is so warm that nothing can be told.
pub(crate) fn slide_watch(channel: &RigChannel, model: &WireModel, stroke: &StrokeRange) -> Option<SlideWatch> {
    let load @ Load::SpringMassDamper { .. } = channel.model.load else { return None };
    if channel.control.sensing != Sensing::Dual || model.taps.is_none() {
        return None;
    }
    let (m, area_m2) = (&model.material, model.geometry.area_m2());
    let shift_k = |length_m: f64| {
        let pull_n = load.pull_at_rest_n(length_m - model.geometry.length_m).unwrap_or(0.0);
        stress_shift_k(m.stress_shift_k_per_pa, pull_n.max(0.0)) / area_m2
    };
    // The curves at 90 % of the way, by eq. 20, at the end of the stroke where the stress is in the way.
    let tail = logit(0.1);
    let (hot_k, cold_k) = (shift_k(stroke.hot_m), shift_k(stroke.cold_m));
    let short_c = m.austenite_temperature_c + hot_k.max(cold_k) + tail / m.heating_steepness_per_k;
    let long_c = m.martensite_temperature_c + hot_k.min(cold_k) - tail / m.cooling_steepness_per_k;
    let above = |temperature_c: f64, share: f64| model.ambient_c + (1.0 + share) * (temperature_c - model.ambient_c);
    let (capacity, loss) = (model.heat_capacity_j_per_k(), model.loss_w_per_k(WORKING_EXCESS_K));
    SlideWatch::new(SlideConfig {
        hot_length_m: stroke.hot_m,
        cold_length_m: stroke.cold_m,
        surely_short_c: above(short_c, SLIDE_TEMPERATURE),
        surely_long_c: above(long_c, -SLIDE_TEMPERATURE),
        ambient_c: model.ambient_c,
        hottest_c: channel.limits.max_temperature_c,
        heat_capacity_j_per_k: Bounds {
            least: (1.0 - SLIDE_CAPACITY) * capacity,
            most: (1.0 + SLIDE_CAPACITY) * capacity,
        },
        loss_w_per_k: Bounds { least: SLIDE_LOSS.least * loss, most: SLIDE_LOSS.most * loss },
        power_error: SLIDE_POWER,
    })
    .ok()
}

pub(crate) fn sensor(channel: &RigChannel, hot: WireEnd, cold: WireEnd) -> Result<LengthSensor, sinew_sensing::Error> {
    let model = &channel.model;
    let method = match (channel.control.sensing, model.taps) {
        (Sensing::Dual, Some(taps)) => Method::DualMeasurement { l0_m: taps.l0_m, ls_m: taps.ls_m },
        _ => Method::Resistance { line: ResistanceLine::through(hot, cold)? },
    };
    let adc = &channel.adc;
    let converter = Converter {
        // The rig file's range is 0 to full scale, the sensor's minus to plus: one bit more has the same step.
        bits: (adc.bits + 1).min(32),
        voltage_range_v: adc.voltage_range_v,
        current_range_a: adc.current_range_a,
        voltage_noise_v: adc.voltage_noise_v,
        current_noise_a: adc.current_noise_a,
    };
    let area_m2 = model.geometry.area_m2();
    let mut config = LengthSensorConfig::for_wire(method, area_m2, model.drive.supply_v, hot, cold, converter);
    // The rig file's limits are what a length may show; but never so short that a lost second tap (V2 = V3) would pass.
    let lost_tap_m = match method {
        Method::DualMeasurement { l0_m, ls_m } => 0.5 * (hot.length_m.min(cold.length_m) + l0_m + ls_m),
        Method::Resistance { .. } => 0.0,
    };
    config.min_length_m = channel.limits.min_length_m.max(lost_tap_m);
    config.max_length_m = channel.limits.max_length_m;
    let drive = &model.drive;
    LengthSensor::new(match adc.circuit {
        SamplingCircuit::SeparateTaps => config,
        SamplingCircuit::Shared => config.sharing(drive.low_ohm(), drive.lead_ohm),
    })
}

/// The observer of a wire's motion, by what it moves; `sigma_m` is the standard deviation of a measured length, m.
pub(crate) fn observer_of(model: &WireModel, sigma_m: f64) -> ObserverConfig {
    match model.load {
        Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, .. } if mass_kg > 0.0 => {
            // The wire's own stiffness changes with its phase by a factor of three: the softer end, where ω is lowest.
            let own = model.cold_stiffness_n_per_m();
            // The speed per duty is left at zero: inside the hysteresis duty hardly moves the wire, and "better too small".
            let drive = Drive::of_load(mass_kg, damping_n_s_per_m, spring_n_per_m + own, 0.0);
            ObserverConfig::with_drive(sigma_m, drive)
        }
        _ => ObserverConfig { length_sigma_m: sigma_m, ..ObserverConfig::default() },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A word of the rig file chooses the law that calls itself so, and what it says of the law arrives there.
    #[test]
    fn words_of_the_rig_file_are_those_of_the_laws() {
        let mut channel = sinew_rig::Rig::hexapod().channels.swap_remove(0);
        let mut chosen = Vec::new();
        for (word, algorithm) in RigAlgorithm::ALL {
            channel.control.algorithm = algorithm;
            let kind = settings(&channel).kind;
            assert_eq!(kind.word(), word);
            chosen.push(kind);
        }
        assert!(AlgorithmKind::ALL.iter().all(|kind| chosen.contains(kind)), "{chosen:?}");

        let plain = settings(&channel);
        assert_eq!((plain.rapid_heating, plain.heat_loss_feedforward, plain.relay_band_m), (None, None, None));
        // The defaults of the rig file and those of the laws are the same.
        let stroke = StrokeRange::of(&channel.model).unwrap().stroke_m();
        let (said, own) = (plain.pid.unwrap(), PidGains::for_stroke(stroke));
        for (said, own) in [
            (said.proportional_per_m, own.proportional_per_m),
            (said.integral_per_m_s, own.integral_per_m_s),
            (said.derivative_s_per_m, own.derivative_s_per_m),
        ] {
            assert!((said / own - 1.0).abs() < 0.01, "{said} {own}");
        }
        channel.control.rapid_heating = RapidHeating::Resistance;
        channel.control.heat_loss_feedforward = Some(true);
        channel.control.relay_band_m = Some(1e-4);
        let told = settings(&channel);
        assert_eq!(told.rapid_heating, Some(Priming::Resistance));
        assert_eq!((told.heat_loss_feedforward, told.relay_band_m), (Some(true), Some(1e-4)));
    }

    #[test]
    fn words_of_the_rig_file_are_those_of_the_estimators() {
        let mut channel = sinew_rig::Rig::hexapod().channels.swap_remove(0);
        let mut chosen = Vec::new();
        for (_, kind) in RigEstimator::ALL {
            channel.control.estimator = kind;
            let word = sinew_rig::word(&channel, "channel.control", "estimator");
            assert_eq!(word.as_deref(), Some(estimator(&channel).word()));
            chosen.push(estimator(&channel));
        }
        let words: Vec<&str> = chosen.iter().map(|kind| kind.word()).collect();
        assert_eq!(words, sinew_rig::words("channel.control", "estimator"));
        assert_eq!(chosen, EstimatorKind::ALL);
    }
}
