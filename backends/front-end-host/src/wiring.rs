//! How the simulated board is wired, and what hangs at its terminals: whole, or wrong in the ways in which boards come off a bench.
//!
//! A wiring lies between the firmware and the simulated wires: which stage a gate's signal reaches, which inputs a channel reads, what
//! is at the terminals, what an input makes of its pin. The wires themselves, their supply and their resistances are
//! `sinew-sim-backend`'s; a wiring changes the rig that is given to it.

use std::fmt;

use rand::SeedableRng;
use rand::rngs::SmallRng;
use rand_distr::{Distribution, StandardNormal};
use sinew_backend::Sample;
use sinew_rig::{Adc, FaultKind, Rig};
use sinew_sim_backend::FaultHandle;

/// A front-end looks at a channel without duty after this share of the period.
const DARK_LOOK: f64 = 0.125;
/// An input that touches nothing drifts about this share of the supply, by this share.
const FLOATING: (f64, f64) = (0.25, 0.08);
/// What a stage that conducts badly has, Ω.
const WEAK_OHM: f64 = 5.0;
/// What bridges a wire, Ω.
const BRIDGE_OHM: f64 = 2.0;

/// What is at a channel's terminals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mount {
    /// The rig's wire, with its taps on it.
    Wire,
    /// Nothing; every tap's clip at the moving end's terminal.
    Nothing,
    /// A resistor, Ω; every tap's clip at the moving end's terminal.
    Resistor(f64),
}

/// An input of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// First tap.
    V1,
    /// Second tap.
    V2,
    /// Moving end.
    V3,
    /// Current.
    Current,
    /// Supply.
    Supply,
}

const INPUTS: [(&str, Input); 5] =
    [("v1", Input::V1), ("v2", Input::V2), ("v3", Input::V3), ("current", Input::Current), ("supply", Input::Supply)];

/// What can be wrong; channels by their place in the rig file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wrong {
    /// Each of two gates drives the other one's stage.
    Outputs(usize, usize),
    /// Each of two channels reads the other one's inputs.
    Senses(usize, usize),
    /// Both: what is called the one is the other.
    Channels(usize, usize),
    /// A shunt has so many times the resistance it should have.
    Shunt(usize, f64),
    /// A shunt is bridged: what flows is not seen.
    ShuntShorted(usize),
    /// The supply's divider is connected the wrong way round.
    SupplySenseReversed,
    /// The supply's divider is not connected.
    SupplySenseOpen,
    /// The supply is so many times what it should be.
    Supply(f64),
    /// A clip (1, 2, or 3 for the moving end's) touches nothing.
    TapMissing(usize, Input),
    /// The clips of both taps are exchanged.
    TapsSwapped(usize),
    /// The clips of the second tap and of the moving end are exchanged.
    TapAndEndSwapped(usize),
    /// A lead to a terminal, or its fuse, is open.
    LeadOpen(usize),
    /// The wire is broken.
    WireOpen(usize),
    /// The wire touches something that bridges it.
    WireBridged(usize),
    /// The wire's diameter is so many times what the rig file says.
    WireDiameter(usize, f64),
    /// The taps are so many times as far apart as the rig file says.
    TapDistance(usize, f64),
    /// A stage conducts whatever its gate is told.
    StageOn(usize),
    /// A stage never conducts.
    StageDead(usize),
    /// A stage conducts badly.
    StageWeak(usize),
    /// The enable line does not reach the master switch, which stays off.
    EnableOpen,
    /// The emergency stop's contact is one that closes when it is pressed.
    StopNormallyOpen,
    /// The emergency stop's contact is not connected.
    StopOpen,
    /// The emergency stop's contact is bridged.
    StopBridged,
    /// An input shows so many times what there is.
    Gain(usize, Input, f64),
    /// An input shows so much more than there is, V or A.
    Offset(usize, Input, f64),
}

/// The words, what follows them, and what they mean.
const WORDS: [(&str, &str, &str); 24] = [
    ("outputs", "A B", "each of two gates drives the other's stage"),
    ("senses", "A B", "each of two channels reads the other's inputs"),
    ("channels", "A B", "both: what is called A is B"),
    ("shunt", "A FACTOR", "a shunt has so many times its resistance"),
    ("shunt-shorted", "A", "a shunt is bridged"),
    ("supply-sense-reversed", "", "the supply's divider is connected the wrong way round"),
    ("supply-sense-open", "", "the supply's divider is not connected"),
    ("supply", "FACTOR", "the supply is so many times what it should be"),
    ("tap-missing", "A v1|v2|v3", "a clip touches nothing"),
    ("taps-swapped", "A", "the clips of V1 and V2 are exchanged"),
    ("tap-end-swapped", "A", "the clips of V2 and V3 are exchanged"),
    ("lead-open", "A", "a lead to a terminal, or its fuse, is open"),
    ("wire-open", "A", "the wire is broken"),
    ("wire-bridged", "A", "2 Ω bridge the wire"),
    ("wire-diameter", "A FACTOR", "another wire: so many times as thick"),
    ("tap-distance", "A FACTOR", "the taps are so many times as far apart"),
    ("stage-on", "A", "a stage conducts whatever its gate is told"),
    ("stage-dead", "A", "a stage never conducts"),
    ("stage-weak", "A", "a stage has 5 Ω"),
    ("enable-open", "", "the enable line does not reach the master switch"),
    ("stop-normally-open", "", "the emergency stop's contact closes when it is pressed"),
    ("stop-open", "", "the emergency stop's contact is not connected"),
    ("stop-bridged", "", "the emergency stop's contact is bridged"),
    ("gain|offset", "A v1|v2|v3|current|supply X", "an input shows X times as much, or X V (A) more"),
];

impl Wrong {
    /// What is meant by words such as `shunt left 0.2`; a channel by its name or its place in the rig file.
    ///
    /// # Errors
    /// What would have been right.
    pub fn parse(text: &str, rig: &Rig) -> Result<Wrong, String> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let Some((kind, rest)) = words.split_first() else { return Err(format!("nothing is said\n{}", Wrong::help())) };
        let channel = |at: usize| {
            let word = rest.get(at).ok_or_else(|| format!("{text}: a channel is missing"))?;
            let found = rig.channels.iter().position(|channel| channel.name == *word);
            let place = found.or_else(|| word.parse().ok().filter(|place| *place < rig.channels.len()));
            place.ok_or_else(|| format!("{text}: the rig has no channel {word}"))
        };
        let number = |at: usize| {
            let word = rest.get(at).ok_or_else(|| format!("{text}: a number is missing"))?;
            let value = word.parse().ok().filter(|value: &f64| value.is_finite());
            value.ok_or_else(|| format!("{text}: {word} is no number"))
        };
        let factor = |at: usize| {
            number(at).and_then(|factor| if factor > 0.0 { Ok(factor) } else { Err(format!("{text}: not above 0")) })
        };
        let input = |at: usize| {
            let found = INPUTS.iter().find(|(word, _)| Some(word) == rest.get(at)).map(|(_, input)| *input);
            found.ok_or_else(|| format!("{text}: an input is one of v1, v2, v3, current, supply"))
        };
        let two = |make: fn(usize, usize) -> Wrong| {
            let (a, b) = (channel(0)?, channel(1)?);
            if a == b { Err(format!("{text}: two channels are wanted")) } else { Ok((2, make(a, b))) }
        };
        let (taken, wrong) = match *kind {
            "outputs" => two(Wrong::Outputs),
            "senses" => two(Wrong::Senses),
            "channels" => two(Wrong::Channels),
            "shunt" => Ok((2, Wrong::Shunt(channel(0)?, factor(1)?))),
            "shunt-shorted" => Ok((1, Wrong::ShuntShorted(channel(0)?))),
            "supply-sense-reversed" => Ok((0, Wrong::SupplySenseReversed)),
            "supply-sense-open" => Ok((0, Wrong::SupplySenseOpen)),
            "supply" => Ok((1, Wrong::Supply(factor(0)?))),
            "tap-missing" => match input(1)? {
                Input::Current | Input::Supply => Err(format!("{text}: a clip is one of v1, v2, v3")),
                tap => Ok((2, Wrong::TapMissing(channel(0)?, tap))),
            },
            "taps-swapped" => Ok((1, Wrong::TapsSwapped(channel(0)?))),
            "tap-end-swapped" => Ok((1, Wrong::TapAndEndSwapped(channel(0)?))),
            "lead-open" => Ok((1, Wrong::LeadOpen(channel(0)?))),
            "wire-open" => Ok((1, Wrong::WireOpen(channel(0)?))),
            "wire-bridged" => Ok((1, Wrong::WireBridged(channel(0)?))),
            "wire-diameter" => Ok((2, Wrong::WireDiameter(channel(0)?, factor(1)?))),
            "tap-distance" => Ok((2, Wrong::TapDistance(channel(0)?, factor(1)?))),
            "stage-on" => Ok((1, Wrong::StageOn(channel(0)?))),
            "stage-dead" => Ok((1, Wrong::StageDead(channel(0)?))),
            "stage-weak" => Ok((1, Wrong::StageWeak(channel(0)?))),
            "enable-open" => Ok((0, Wrong::EnableOpen)),
            "stop-normally-open" => Ok((0, Wrong::StopNormallyOpen)),
            "stop-open" => Ok((0, Wrong::StopOpen)),
            "stop-bridged" => Ok((0, Wrong::StopBridged)),
            "gain" => Ok((3, Wrong::Gain(channel(0)?, input(1)?, factor(2)?))),
            "offset" => Ok((3, Wrong::Offset(channel(0)?, input(1)?, number(2)?))),
            _ => Err(format!("{kind}: is nothing that can be wrong\n{}", Wrong::help())),
        }?;
        match rest.len() == taken {
            true => Ok(wrong),
            false => Err(format!("{text}: says too much")),
        }
    }

    /// What can be said, a line each.
    pub fn help() -> String {
        let line = |(word, rest, about): &(&str, &str, &str)| format!("  {:<44} {about}", format!("{word} {rest}"));
        WORDS.iter().map(line).collect::<Vec<_>>().join("\n")
    }
}

impl Mount {
    /// What is meant by `wire`, `nothing` or a resistor's value in Ω.
    pub fn parse(word: &str) -> Option<Mount> {
        match word {
            "wire" => Some(Mount::Wire),
            "nothing" => Some(Mount::Nothing),
            ohm => ohm.parse().ok().filter(|ohm: &f64| ohm.is_finite() && *ohm > 0.0).map(Mount::Resistor),
        }
    }
}

/// A board's wiring.
pub(crate) struct Wiring {
    wrong: Vec<Wrong>,
    mounts: Vec<Mount>,
    /// Of each channel as it really is.
    boards: Vec<Board>,
    random: SmallRng,
}

/// What stands behind a channel's stage.
struct Board {
    adc: Adc,
    supply_v: f64,
    /// Shunt, switch and leads, Ω.
    series_ohm: f64,
    has_taps: bool,
}

impl Wiring {
    /// The rig as it really is, for the simulation, and the wiring around it.
    pub fn new(rig: &Rig, wrong: &[Wrong], mounts: &[Mount], seed: u64) -> (Rig, Wiring) {
        let mut real = rig.clone();
        for wrong in wrong {
            match *wrong {
                Wrong::Supply(factor) => {
                    real.channels.iter_mut().for_each(|channel| channel.model.drive.supply_v *= factor);
                }
                Wrong::Shunt(at, factor) => real.channels[at].model.drive.shunt_ohm *= factor,
                Wrong::ShuntShorted(at) => real.channels[at].model.drive.shunt_ohm = 0.0,
                Wrong::WireDiameter(at, factor) => real.channels[at].model.geometry.diameter_m *= factor,
                Wrong::TapDistance(at, factor) => {
                    if let Some(taps) = &mut real.channels[at].model.taps {
                        taps.ls_m *= factor;
                    }
                }
                _ => {}
            }
        }
        let boards = real.channels.iter().enumerate().map(|(index, channel)| {
            let weak = wrong.contains(&Wrong::StageWeak(index));
            Board {
                adc: channel.adc,
                supply_v: channel.model.drive.supply_v,
                series_ohm: channel.model.outside_ohm() + if weak { WEAK_OHM } else { 0.0 },
                has_taps: channel.model.taps.is_some(),
            }
        });
        let boards = boards.collect();
        let mut mounts = mounts.to_vec();
        mounts.resize(rig.channels.len(), Mount::Wire);
        (real, Wiring { wrong: wrong.to_vec(), mounts, boards, random: SmallRng::seed_from_u64(seed) })
    }

    /// Breaks what the simulated wires break themselves.
    pub fn break_wires(&self, faults: &FaultHandle) {
        for wrong in &self.wrong {
            match *wrong {
                Wrong::WireOpen(at) => drop(faults.set(at, FaultKind::OpenWire)),
                Wrong::LeadOpen(at) => drop(faults.set(at, FaultKind::OpenWire)),
                Wrong::WireBridged(at) => drop(faults.set_sized(at, FaultKind::ShortedWire, BRIDGE_OHM)),
                // a stage that conducts by itself heats a wire that is there, and no other
                Wrong::StageOn(at) if self.mounts[at] == Mount::Wire => drop(faults.set(at, FaultKind::StageOn)),
                Wrong::StageWeak(at) => drop(faults.set_sized(at, FaultKind::StageWeak, WEAK_OHM)),
                _ => {}
            }
        }
    }

    pub fn wrong(&self) -> &[Wrong] {
        &self.wrong
    }

    pub fn mounts(&self) -> &[Mount] {
        &self.mounts
    }

    fn has(&self, wrong: Wrong) -> bool {
        self.wrong.contains(&wrong)
    }

    /// Where the signals of a channel go, and where its readings come from.
    fn exchanged(&self, channel: usize, is_output: bool) -> usize {
        self.wrong.iter().fold(channel, |at, wrong| match *wrong {
            Wrong::Outputs(a, b) if is_output && at == a => b,
            Wrong::Outputs(a, b) if is_output && at == b => a,
            Wrong::Senses(a, b) if !is_output && at == a => b,
            Wrong::Senses(a, b) if !is_output && at == b => a,
            Wrong::Channels(a, b) if at == a => b,
            Wrong::Channels(a, b) if at == b => a,
            _ => at,
        })
    }

    /// The duty of every stage, of what is asked of every channel.
    pub fn of_stages(&self, asked: &[f64]) -> Vec<f64> {
        let mut duty = vec![0.0; asked.len()];
        for (channel, asked) in asked.iter().enumerate() {
            duty[self.exchanged(channel, true)] = *asked;
        }
        for (stage, duty) in duty.iter_mut().enumerate() {
            if self.has(Wrong::StageDead(stage)) {
                *duty = 0.0;
            }
        }
        duty
    }

    /// What the wires get of that: nothing where none is mounted.
    pub fn of_wires(&self, stages: &[f64]) -> Vec<f64> {
        let mounted = |(duty, mount): (&f64, &Mount)| if *mount == Mount::Wire { *duty } else { 0.0 };
        stages.iter().zip(&self.mounts).map(mounted).collect()
    }

    /// Whether the enable line reaches the master switch.
    pub fn is_enabled(&self) -> bool {
        !self.has(Wrong::EnableOpen)
    }

    /// What the emergency stop's input shows of its contact.
    pub fn sees_closed(&self, is_closed: bool) -> bool {
        self.wrong.iter().fold(is_closed, |closed, wrong| match wrong {
            Wrong::StopNormallyOpen => !closed,
            Wrong::StopOpen => false,
            Wrong::StopBridged => true,
            _ => closed,
        })
    }

    /// What every channel reads, of what was sampled of the wires. `is_live`: the stages have a supply.
    pub fn read(&mut self, asked: &[f64], stages: &[f64], is_live: bool, wires: &[Sample]) -> Vec<Sample> {
        (0..asked.len()).map(|channel| self.read_one(channel, asked, stages, is_live, wires)).collect()
    }

    fn read_one(&mut self, channel: usize, asked: &[f64], stages: &[f64], is_live: bool, wires: &[Sample]) -> Sample {
        let at = self.exchanged(channel, false);
        let look = if asked[channel] > 0.0 { asked[channel] } else { DARK_LOOK };
        let conducts = is_live && (stages[at] >= look || self.has(Wrong::StageOn(at)));
        let board = &self.boards[at];
        let ohm = match self.mounts[at] {
            Mount::Resistor(ohm) if !self.has(Wrong::LeadOpen(at)) => ohm,
            Mount::Resistor(_) | Mount::Nothing | Mount::Wire => f64::INFINITY,
        };
        let current_a = board.supply_v / (ohm + board.series_ohm);
        let terminal_v = if ohm.is_finite() { current_a * ohm } else { board.supply_v };
        let (volts, amps, has_taps) =
            if conducts { (terminal_v, current_a, board.has_taps) } else { (0.0, 0.0, board.has_taps) };
        let mut sample = match self.mounts[at] {
            // a wire's own converters see it in the dark as well, whatever heats it
            Mount::Wire if conducts || at == channel => wires[at],
            _ => {
                let tap_v = if has_taps { self.noisy(at, volts) } else { f64::NAN };
                let other_v = if has_taps { self.noisy(at, volts) } else { f64::NAN };
                let noise_a = self.boards[at].adc.current_noise_a;
                Sample {
                    v1_v: tap_v,
                    v2_v: other_v,
                    v3_v: self.noisy(at, volts),
                    current_a: amps + noise_a * self.draw(),
                    supply_v: wires[at].supply_v,
                }
            }
        };
        self.spoil(channel, at, &mut sample);
        sample
    }

    /// What the inputs make of their pins.
    fn spoil(&mut self, channel: usize, at: usize, sample: &mut Sample) {
        for index in 0..self.wrong.len() {
            match self.wrong[index] {
                Wrong::Shunt(of, factor) if of == at => sample.current_a *= factor,
                Wrong::ShuntShorted(of) if of == at => {
                    sample.current_a = self.boards[at].adc.current_noise_a * self.draw()
                }
                Wrong::SupplySenseReversed | Wrong::SupplySenseOpen => {
                    sample.supply_v = self.boards[at].adc.supply_noise_v * self.draw();
                }
                Wrong::TapMissing(of, tap) if of == at => {
                    let level_v = self.boards[at].supply_v * (FLOATING.0 + FLOATING.1 * self.draw());
                    *pin(sample, tap) = level_v;
                }
                Wrong::TapsSwapped(of) if of == at => std::mem::swap(&mut sample.v1_v, &mut sample.v2_v),
                Wrong::TapAndEndSwapped(of) if of == at => std::mem::swap(&mut sample.v2_v, &mut sample.v3_v),
                Wrong::Gain(of, input, factor) if of == channel => *pin(sample, input) *= factor,
                Wrong::Offset(of, input, more) if of == channel => *pin(sample, input) += more,
                _ => {}
            }
        }
    }

    fn noisy(&mut self, at: usize, volts: f64) -> f64 {
        volts + self.boards[at].adc.voltage_noise_v * self.draw()
    }

    fn draw(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }
}

fn pin(sample: &mut Sample, input: Input) -> &mut f64 {
    match input {
        Input::V1 => &mut sample.v1_v,
        Input::V2 => &mut sample.v2_v,
        Input::V3 => &mut sample.v3_v,
        Input::Current => &mut sample.current_a,
        Input::Supply => &mut sample.supply_v,
    }
}

impl fmt::Debug for Wiring {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Wiring").field("wrong", &self.wrong).field("mounts", &self.mounts).finish_non_exhaustive()
    }
}
