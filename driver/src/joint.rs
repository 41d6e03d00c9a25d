//! Two channels that turn one joint: sensed separately, estimated and controlled together, and output
//! separately.
//!
//! A joint's two wires share one target. A length or stroke commanded to either is an angle of the joint; the
//! other wire's target is its length at that angle. A fault of one wire switches both off in the same cycle.

use sinew_control::{JointDemand, JointLaw, JointObserver};
use sinew_ipc::{ChannelState, Fault};
use sinew_rig::{Joint as RigJoint, Rig};
use sinew_sensing::Sample;

use crate::channel::{Channel, Happened, Target, Tick};
use crate::error::Error;
use crate::setup::{joint_algorithm, joint_settings};
use crate::supervisor::{Change, Permit};

/// One joint. Its channels are kept with all others.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Its channels, agonist first.
    pub(crate) channels: [usize; 2],
    observer: JointObserver,
    law: JointLaw,
    /// Whether the law was in charge in the last cycle: else it starts afresh.
    regulating: bool,
    /// Tension that was asked for, N; NaN = the rig file's.
    tension_n: f64,
    radius_m: f64,
    /// Lengths of both wires at angle 0, m.
    rest_m: [f64; 2],
}

impl Joint {
    /// A joint of a rig.
    ///
    /// # Errors
    /// [`Error::Rig`] where its numbers are not those of a joint, or its channels are not there.
    pub fn new(rig: &Rig, joint: &RigJoint) -> Result<Joint, Error> {
        let refuse = |reason: String| Error::Rig { place: format!("joint {}", joint.name), reason };
        let channels = rig.channels_of(joint).ok_or_else(|| refuse("one of its channels is not there".into()))?;
        let wires = channels.map(|index| &rig.channels[index]);
        let models = channels.map(|index| rig.nominal_model(index));
        let models = [&models[0], &models[1]];
        let observer = JointObserver::new(&joint.mechanics, models).map_err(|error| refuse(error.to_string()))?;
        let rest_m = joint.mechanics.rest_m(models).map_err(|error| refuse(error.to_string()))?;
        let settings = joint_settings(joint, wires);
        Ok(Joint {
            channels,
            observer,
            law: JointLaw::new(joint_algorithm(joint), models, &settings).map_err(|error| refuse(error.to_string()))?,
            regulating: false,
            tension_n: f64::NAN,
            radius_m: joint.mechanics.radius_m,
            rest_m: [0, 1].map(|side| models[side].geometry.length_m + rest_m[side]),
        })
    }

    /// Angle, rad, at which the wire of a side (0 = agonist) has a length, m.
    pub fn angle_rad(&self, side: usize, length_m: f64) -> f64 {
        let longer_m = length_m - self.rest_m[side];
        if side == 0 { -longer_m / self.radius_m } else { longer_m / self.radius_m }
    }

    /// The tension to bring a standing joint to, N; `None` = the rig file's.
    pub(crate) fn set_tension(&mut self, tension_n: Option<f64>) {
        self.tension_n = tension_n.unwrap_or(f64::NAN);
    }

    /// Length of the other wire, m, where the wire of `side` has `length_m`: together they are always as long.
    pub fn opposite_m(&self, side: usize, length_m: f64) -> f64 {
        self.rest_m[1 - side] + self.rest_m[side] - length_m
    }

    /// One cycle of both channels, as [`Channel::step`] is for one alone. `tripped` says which were switched off from
    /// outside in this cycle; `program` is the stroke a built-in program wants of the agonist, if there is one.
    #[inline]
    pub fn step(
        &mut self,
        wires: [&mut Channel; 2],
        samples: [&Sample; 2],
        tripped: [bool; 2],
        tick: &Tick,
        program: Option<f64>,
    ) -> [Happened; 2] {
        let mut happened = [Happened::default(); 2];
        let mut permits = [Permit::Off; 2];
        let seen = [wires[0].sense(samples[0], tick), wires[1].sense(samples[1], tick)];
        let believed = self.observer.update([&seen[0], &seen[1]]);
        for side in [0, 1] {
            wires[side].estimate = believed.wires[side];
            (permits[side], happened[side].change) = wires[side].supervise(samples[side], &believed.wires[side], tick);
        }
        for side in [0, 1] {
            let other = 1 - side;
            if (tripped[side] || matches!(happened[side].change, Some(Change::Tripped(_))))
                && let Some(change) = wires[other].trip(Fault::JointPartner)
            {
                happened[other].change = Some(change);
                permits[other] = Permit::Off;
            }
        }

        let opposite = program.map(|stroke| {
            let length_m = self.opposite_m(0, wires[0].stroke.length_m(stroke));
            wires[1].stroke.stroke(length_m)
        });
        happened[0].lapsed = wires[0].put_in_charge(permits[0], tick, program);
        happened[1].lapsed = wires[1].put_in_charge(permits[1], tick, opposite);

        let powered = permits == [Permit::Power; 2];
        let duties = match (wires[0].target, wires[1].target) {
            (Target::Length(reference_m), Target::Length(_)) | (Target::Force(reference_m), Target::Force(_))
                if powered =>
            {
                if !self.regulating {
                    self.law.reset();
                }
                let reference_rad = self.angle_rad(0, reference_m);
                let demand = JointDemand {
                    reference_rad,
                    tension_n: self.tension_n,
                    resistance_ohm: seen.map(|seen| seen.resistance_ohm),
                    dt_s: tick.dt_s,
                    estimate: believed,
                };
                self.law.duties(&demand).map(Some)
            }
            _ => [None; 2],
        };
        self.regulating = duties[0].is_some();
        for side in [0, 1] {
            let duty = wires[side].regulate_in_joint(permits[side], duties[side]);
            wires[side].put_out(duty, permits[side], tick);
            if self.regulating && self.law.is_limited() {
                wires[side].flags |= ChannelState::FLAG_LIMITED;
            }
        }
        happened
    }
}
