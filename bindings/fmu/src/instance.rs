//! One wire that another simulator steps: what it may do with it, and when.

use std::fmt;

use sinew_physics::{Inputs, Undefined, Wire};
use sinew_rig::Rig;

use crate::variables::{Role, Variable, variables};

/// A simulator's points in time and the wire's may differ by this much, s: rounding of many steps.
const ROUNDING_S: f64 = 1e-9;

/// Why something cannot be done, in words for the simulator's log.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal(pub String);

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

fn refuse<T>(why: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal(why.into()))
}

/// One wire of a rig that another simulator steps. Cloning it forks the simulation.
#[derive(Debug, Clone)]
pub struct Instance {
    rig: Rig,
    channel: usize,
    variables: Vec<Variable>,
    inputs: Inputs,
    /// From the end of the initialisation on.
    wire: Option<Wire>,
    time_s: f64,
    given: Box<Given>,
}

/// What it begins with, and goes back to.
#[derive(Debug, Clone)]
struct Given {
    rig: Rig,
    inputs: Inputs,
}

impl Instance {
    /// Of a channel of a rig file.
    ///
    /// # Errors
    /// A rig file that cannot be read, with its mistakes; a channel it does not have.
    pub fn new(rig: &str, file: &str, channel: &str) -> Result<Instance, Refusal> {
        let rig = Rig::parse(rig, file).map_err(|error| Refusal(error.to_string()))?;
        let Some((channel, _)) = rig.channel(channel) else {
            return refuse(format!("{file} has no channel {channel:?}"));
        };
        let inputs = rig.channels[channel].model.rest_inputs();
        let given = Box::new(Given { rig: rig.clone(), inputs });
        Ok(Instance { variables: variables(&rig, channel), rig, channel, inputs, wire: None, time_s: 0.0, given })
    }

    /// The value of a variable: inputs and parameters as they were set, outputs at the last point in time.
    ///
    /// # Errors
    /// No such variable, or one that has no value before the wire is initialised.
    pub fn get(&mut self, reference: u32) -> Result<f64, Refusal> {
        let Variable { name, role, .. } = self.variable(reference)?.clone();
        match role {
            Role::Independent => Ok(self.time_s),
            Role::Input(of) => Ok(*of(&mut self.inputs)),
            Role::Output(of) => match &self.wire {
                Some(wire) => Ok(of(&wire.outputs())),
                // what a wire would show that is initialised as things are set now
                None => Ok(of(&self.at_rest()?.outputs())),
            },
            Role::Parameter(key) => {
                self.rig.parameter(self.channel, key).ok_or_else(|| Refusal(format!("{name} has no value")))
            }
        }
    }

    /// Sets an input, or a parameter before the wire is initialised.
    ///
    /// # Errors
    /// No such variable, an output, a parameter that is set too late or to what no rig file may say, or what is no finite number.
    pub fn set(&mut self, reference: u32, value: f64) -> Result<(), Refusal> {
        let Variable { name, role, .. } = self.variable(reference)?.clone();
        if !value.is_finite() {
            return refuse(format!("{name} = {value} is no finite number"));
        }
        match role {
            Role::Input(of) => *of(&mut self.inputs) = value,
            Role::Parameter(_) if self.wire.is_some() => {
                return refuse(format!("{name} is fixed once the wire is initialised: reset the instance first"));
            }
            Role::Parameter(key) => {
                self.rig.set_parameter(self.channel, key, value).map_err(|error| Refusal(error.to_string()))?;
            }
            Role::Independent | Role::Output(_) => return refuse(format!("{name} is not to be set")),
        }
        Ok(())
    }

    /// The time the simulation begins at, s.
    ///
    /// # Errors
    /// No finite time, or an instance that has begun.
    pub fn begin(&mut self, start_s: f64) -> Result<(), Refusal> {
        if self.wire.is_some() || !start_s.is_finite() {
            return refuse(format!("it cannot begin at {start_s} s: it has begun already, or that is no time"));
        }
        self.time_s = start_s;
        Ok(())
    }

    /// Puts the wire at rest under the inputs as they were set.
    ///
    /// # Errors
    /// Parameters no wire can have.
    pub fn initialise(&mut self) -> Result<(), Refusal> {
        self.wire = Some(self.at_rest()?);
        Ok(())
    }

    /// Steps the wire from this time on, s, under the inputs as they were set.
    ///
    /// # Errors
    /// Before it is initialised; from another time than it is at; a step that is no positive time; a formula of a law of one's
    /// own that is no number where the wire went.
    pub fn step(&mut self, from_s: f64, step_s: f64) -> Result<(), Refusal> {
        let Some(wire) = &mut self.wire else { return refuse("the wire is not initialised yet") };
        let rounding_s = ROUNDING_S * (1.0 + self.time_s.abs());
        if (from_s - self.time_s).abs() > rounding_s {
            return refuse(format!("a step from {from_s} s, but the wire is at {} s", self.time_s));
        }
        if !(step_s.is_finite() && step_s > 0.0) {
            return refuse(format!("a step of {step_s} s"));
        }
        wire.step(&self.inputs, step_s);
        self.time_s = from_s + step_s;
        match wire.undefined() {
            None => Ok(()),
            Some(Undefined { law, time_s }) => refuse(format!("the formula of {law} is no number at {time_s} s")),
        }
    }

    /// As it was made.
    pub fn reset(&mut self) {
        let Given { rig, inputs } = &*self.given;
        (self.rig, self.inputs, self.wire, self.time_s) = (rig.clone(), *inputs, None, 0.0);
    }

    /// The time it is at, s.
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    fn at_rest(&self) -> Result<Wire, Refusal> {
        let model = &self.rig.channels[self.channel].model;
        Wire::with_inputs(model, &self.inputs).map_err(|error| Refusal(error.to_string()))
    }

    fn variable(&self, reference: u32) -> Result<&Variable, Refusal> {
        let found = self.variables.get(reference as usize);
        found.ok_or_else(|| Refusal(format!("there is no variable {reference}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_rig::HEXAPOD_TOML;

    fn wire() -> (Instance, impl Fn(&str) -> u32) {
        let instance = Instance::new(HEXAPOD_TOML, "hexapod", "front_left_coxa").unwrap();
        let names: Vec<String> = instance.variables.iter().map(|variable| variable.name.clone()).collect();
        (instance, move |name: &str| names.iter().position(|n| n == name).expect(name) as u32)
    }

    #[test]
    fn a_heated_wire_shortens_as_the_model_itself_does() {
        let (mut instance, of) = wire();
        instance.set(of("duty"), 0.3).unwrap();
        instance.begin(2.0).unwrap();
        instance.initialise().unwrap();
        let rig = Rig::hexapod();
        let model = &rig.channels[0].model;
        let inputs = Inputs { drive: 0.3, ..model.rest_inputs() };
        let mut alone = Wire::with_inputs(model, &inputs).unwrap();
        let cold = instance.get(of("position_m")).unwrap();
        for step in 0..300 {
            instance.step(2.0 + f64::from(step) * 0.01, 0.01).unwrap();
            alone.step(&inputs, 0.01);
            assert_eq!(instance.get(of("position_m")).unwrap(), alone.outputs().position_m);
        }
        assert!(instance.get(of("position_m")).unwrap() < cold - 1e-3);
        assert!((instance.get(of("time")).unwrap() - 5.0).abs() < 1e-9);
    }

    #[test]
    fn a_fork_goes_its_own_way_and_a_reset_begins_anew() {
        let (mut instance, of) = wire();
        let cold = instance.get(of("temperature_c")).unwrap();
        instance.set(of("duty"), 0.5).unwrap();
        instance.set(of("material.convection_w_per_m2_k"), 60.0).unwrap();
        instance.initialise().unwrap();
        instance.step(0.0, 0.5).unwrap();
        let mut fork = instance.clone();
        fork.set(of("duty"), 0.0).unwrap();
        instance.step(0.5, 0.1).unwrap();
        fork.step(0.5, 0.1).unwrap();
        assert!(fork.get(of("temperature_c")).unwrap() < instance.get(of("temperature_c")).unwrap());
        instance.reset();
        assert_eq!(instance.get(of("temperature_c")).unwrap(), cold);
        assert_ne!(instance.get(of("material.convection_w_per_m2_k")).unwrap(), 60.0);
    }

    #[test]
    fn what_cannot_be_is_refused_in_words() {
        let (mut instance, of) = wire();
        let refused = |result: Result<(), Refusal>, words: &str| {
            let said = result.expect_err(words).to_string();
            assert!(said.contains(words), "{said}");
        };
        refused(instance.step(0.0, 0.1), "not initialised");
        refused(instance.set(of("position_m"), 0.1), "not to be set");
        refused(instance.set(of("duty"), f64::NAN), "no finite number");
        refused(instance.set(of("material.density_kg_per_m3"), -1.0), "density_kg_per_m3");
        refused(instance.set(9999, 0.0), "no variable 9999");
        instance.initialise().unwrap();
        refused(instance.set(of("material.density_kg_per_m3"), 6000.0), "fixed");
        refused(instance.step(1.0, 0.1), "a step from 1 s");
        refused(instance.step(0.0, 0.0), "a step of 0 s");
        refused(Instance::new(HEXAPOD_TOML, "hexapod", "tail").map(drop), "no channel \"tail\"");
        refused(Instance::new("[rig]\n", "empty", "tail").map(drop), "empty");
    }
}
