//! The judge of a prediction: the same cycle, with the wire stepped through time.

use sinew_physics::formulas::{WORKING_EXCESS_K, cooling_time_s};
use sinew_physics::{Error, Inputs, Wire};
use sinew_rig::Rig;

use crate::task::{CYCLES, Cycle, Task};

/// Steps in the wire's time constant; the shortest and longest of one, s.
const STEPS: f64 = 5000.0;
const SHORTEST_S: f64 = 1e-5;
const LONGEST_S: f64 = 1e-3;
/// A way that takes more of the wire's time constants ends nowhere.
const MOST_TIME_CONSTANTS: f64 = 60.0;
/// In this time a load that swings comes to rest, s.
const HELD_S: f64 = 2.0;

/// What the simulated wire did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Simulated {
    /// Stroke from rest to where the supervisor begins to hold back, or the supply is at its end, m.
    pub stroke_m: f64,
    /// Over the stroke asked for; `None`: it did not get there and back.
    pub cycle: Option<Cycle>,
}

/// Steps a rig's only wire through the task.
///
/// # Errors
/// A parameter outside its physical range.
pub fn simulate(rig: &Rig, task: &Task) -> Result<Simulated, Error> {
    let model = rig.nominal_model(0);
    let time_constant_s = cooling_time_s(model.heat_capacity_j_per_k(), model.loss_w_per_k(WORKING_EXCESS_K));
    let mut run = Run {
        wire: Wire::new(&model)?,
        rest: model.rest_inputs(),
        step_s: (time_constant_s / STEPS).clamp(SHORTEST_S, LONGEST_S),
        longest_s: MOST_TIME_CONSTANTS * time_constant_s,
        pull_n: 0.0,
        hottest_c: f64::NEG_INFINITY,
    };
    let mut heated = Run { wire: run.wire.clone(), ..run };
    heated.until(task.on_duty, |wire| wire.temperature_c() - task.derated_c);
    heated.hold(task.on_duty, task.derated_c);
    let stroke_m = task.cold_m - heated.wire.position_m();

    let there = |run: &mut Run| run.until(task.on_duty, |wire| task.short_m - wire.position_m());
    let back = |run: &mut Run| run.until(task.off_duty, |wire| wire.position_m() - task.long_m);
    let mut cycles = || {
        let first_s = there(&mut run)?;
        let mut cycle = None;
        for _ in 0..CYCLES {
            (run.pull_n, run.hottest_c) = (0.0, f64::NEG_INFINITY);
            let before_j = run.wire.energy().heat_in_j;
            let cooling_s = back(&mut run)?;
            let heating_s = there(&mut run)?;
            let heat_j = run.wire.energy().heat_in_j - before_j;
            let Run { pull_n, hottest_c, .. } = run;
            let power_w = heat_j / (heating_s + cooling_s);
            cycle = Some(Cycle { pull_n, heating_s, cooling_s, first_s, hottest_c, power_w });
        }
        cycle
    };
    Ok(Simulated { stroke_m, cycle: cycles() })
}

/// A wire on its way.
#[derive(Debug, Clone)]
struct Run {
    wire: Wire,
    rest: Inputs,
    step_s: f64,
    longest_s: f64,
    pull_n: f64,
    hottest_c: f64,
}

impl Run {
    /// Holds the wire at a temperature, or gives it this duty where it does not come to that, until its load has come to rest.
    fn hold(&mut self, duty: f64, temperature_c: f64) {
        for _ in 0..(HELD_S / self.step_s) as usize {
            let drive = if self.wire.temperature_c() < temperature_c { duty } else { 0.0 };
            self.wire.step(&Inputs { drive, ..self.rest }, self.step_s);
        }
    }

    /// How long it takes at this duty until something is no longer below 0, s.
    fn until(&mut self, duty: f64, above: impl Fn(&Wire) -> f64) -> Option<f64> {
        let inputs = Inputs { drive: duty, ..self.rest };
        let mut before = above(&self.wire);
        let mut time_s = 0.0;
        while time_s < self.longest_s {
            self.wire.step(&inputs, self.step_s);
            self.pull_n = self.pull_n.max(self.wire.tension_n());
            self.hottest_c = self.hottest_c.max(self.wire.temperature_c());
            let now = above(&self.wire);
            if now >= 0.0 {
                let share = if now > before { (now / (now - before)).clamp(0.0, 1.0) } else { 0.0 };
                return Some(time_s + self.step_s * (1.0 - share));
            }
            (before, time_s) = (now, time_s + self.step_s);
        }
        None
    }
}
