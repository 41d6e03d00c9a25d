//! What is to be known of a wire to reckon with its life, and what a state of it is.

use serde::{Deserialize, Serialize};
use sinew_ipc::ChannelState;
use sinew_physics::{Load, Material, WireModel, cold_length_m, formulas, hot_length_m};
use sinew_rig::Rig;

use crate::counter::Moment;

/// Two wires' sizes that differ by less are the same wire's: measured lengths are entered as they become known.
const SAME: f64 = 0.02;

/// Which wire it is, as far as a rig file says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Diameter, m.
    pub diameter_m: f64,
    /// Length, m.
    pub length_m: f64,
    /// The kind by its name (`wire.kind`); empty where it has none.
    pub kind: String,
}

impl Identity {
    /// Whether it may be the same wire.
    pub fn may_be(&self, other: &Identity) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= SAME * a.max(b);
        let kind = self.kind.is_empty() || other.kind.is_empty() || self.kind == other.kind;
        kind && near(self.diameter_m, other.diameter_m) && near(self.length_m, other.length_m)
    }
}

/// A wire, as an account reckons with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Wire {
    /// Which one.
    pub identity: Identity,
    /// Its material: where it is wholly austenite.
    pub material: Material,
    /// Its temperature must not be higher than this, °C.
    pub limit_c: f64,
    /// The duty that only measures.
    pub sensing_duty: f64,
    load: Load,
    area_m2: f64,
    /// The most its load pulls, at either end of its way, Pa: what is taken where nothing tells the stress.
    worst_pa: f64,
}

impl Wire {
    /// Of a channel of a rig, by its index.
    ///
    /// # Panics
    /// If there is no such channel.
    pub fn of(rig: &Rig, channel: usize) -> Wire {
        let of = &rig.channels[channel];
        // what wires of a joint pull against stands in the joint
        let model = rig.nominal_model(channel);
        let geometry = model.geometry;
        let identity = Identity {
            diameter_m: geometry.diameter_m,
            length_m: geometry.length_m,
            kind: of.wire_kind.map_or_else(String::new, |kind| kind.name.into()),
        };
        Wire {
            identity,
            material: model.material,
            limit_c: of.limits.max_temperature_c,
            sensing_duty: of.control.minimum_duty,
            load: model.load,
            area_m2: geometry.area_m2(),
            worst_pa: worst_pa(&model),
        }
    }

    /// Stress that its load pulls with at an elongation in m, Pa; NaN where the load is imposed, or the elongation not known.
    pub fn stress_pa(&self, elongation_m: f64) -> f64 {
        // not max: of 0 and NaN that makes 0
        self.load
            .pull_at_rest_n(elongation_m)
            .map_or(f64::NAN, |pull_n| pull_n.clamp(0.0, f64::INFINITY) / self.area_m2)
    }

    /// A published state of it, which held for so many seconds.
    pub fn sample(&self, state: &ChannelState, seconds: f64) -> Sample {
        let elongation_m = state.length_m - self.identity.length_m;
        Sample {
            seconds,
            powered: state.duty > self.sensing_duty,
            power_w: state.power_w,
            martensite: state.martensite,
            strain: elongation_m / self.identity.length_m,
            stress_pa: self.stress_pa(elongation_m),
            temperature_c: state.temperature_c,
        }
    }

    /// What is counted of a sample; `None` where neither phase nor strain is known.
    pub(crate) fn moment(&self, sample: &Sample) -> Option<Moment> {
        let whole = self.material.transformation_strain;
        let share = match (sample.martensite, sample.strain / whole) {
            (martensite, _) if martensite.is_finite() => martensite,
            (_, of_strain) if of_strain.is_finite() => of_strain,
            _ => return None,
        };
        let strain = if sample.strain.is_finite() { sample.strain } else { whole * share };
        let stress_pa = if sample.stress_pa.is_finite() { sample.stress_pa } else { self.worst_pa };
        let overheated = match sample.temperature_c.is_finite() {
            true => formulas::overheated(&self.material, sample.temperature_c, stress_pa),
            false => 0.0,
        };
        Some(Moment { share, strain, stress_pa, overheated })
    }
}

/// The most a load pulls at rest, Pa; that of table 3 where it is imposed from outside.
fn worst_pa(model: &WireModel) -> f64 {
    let lengths = [hot_length_m(model), cold_length_m(model)];
    let pulls = lengths.iter().flatten().filter_map(|m| model.load.pull_at_rest_n(m - model.geometry.length_m));
    let most_n = pulls.fold(f64::NAN, f64::max);
    if most_n.is_finite() { most_n.max(0.0) / model.geometry.area_m2() } else { formulas::LASTING_STRESS_PA }
}

/// A state of a wire. What is not known is NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// How long it held, s.
    pub seconds: f64,
    /// Whether it was heated, not just measured.
    pub powered: bool,
    /// Mean electrical power, W.
    pub power_w: f64,
    /// Martensite fraction.
    pub martensite: f64,
    /// Strain (L − L_0)/L_0.
    pub strain: f64,
    /// Stress, Pa.
    pub stress_pa: f64,
    /// Temperature, °C.
    pub temperature_c: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_that_was_measured_is_no_other_wire_and_a_thicker_one_is() {
        let wire = Identity { diameter_m: 0.125e-3, length_m: 0.16, kind: String::new() };
        assert!(wire.may_be(&Identity { length_m: 0.1611, kind: "flexinol-125-ht".into(), ..wire.clone() }));
        assert!(!wire.may_be(&Identity { diameter_m: 0.15e-3, ..wire.clone() }));
        assert!(!wire.may_be(&Identity { length_m: 0.2, ..wire.clone() }));
        let (lt, ht) = (Identity { kind: "a".into(), ..wire.clone() }, Identity { kind: "b".into(), ..wire });
        assert!(!lt.may_be(&ht));
    }

    #[test]
    fn what_is_not_known_is_taken_from_what_is_or_to_be_the_worst() {
        let rig = Rig::hexapod();
        let wire = Wire::of(&rig, 0);
        let unknown = Sample {
            seconds: 1.0,
            powered: true,
            power_w: f64::NAN,
            martensite: f64::NAN,
            strain: f64::NAN,
            stress_pa: f64::NAN,
            temperature_c: f64::NAN,
        };
        assert_eq!(wire.moment(&unknown), None);
        let strained = wire.moment(&Sample { strain: 0.02, ..unknown }).unwrap();
        assert!((strained.share - 0.02 / wire.material.transformation_strain).abs() < 1e-12);
        assert!(strained.stress_pa > 50e6 && strained.overheated == 0.0);
        // no place on its way pulls more
        for strain in [0.01, 0.02, 0.03] {
            assert!(wire.stress_pa(strain * wire.identity.length_m) <= strained.stress_pa);
        }
        assert!(wire.stress_pa(f64::NAN).is_nan());
    }
}
