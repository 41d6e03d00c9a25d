//! Bits for those who command: a request of any contents, and samples of any value, through the rules and the loop's own cycle.

use std::sync::LazyLock;

use sinew_backend::{Backend, BackendError, Sample};
use sinew_driver::commands::ChannelRules;
use sinew_driver::{Ask, Beat, Engine, Occurrence, Order};
use sinew_ipc::{ALL_CHANNELS, Command, DriverState, Mode, Snapshot};
use sinew_rig::Rig;
use sinew_sim_backend::SimulatedRig;

use crate::script::Script;

/// Two wires against springs and two in a joint.
const RIG: &str = r#"[rig]
name = "hostile"
rate_hz = 1000.0

[[channel]]
name = "left"
wire = { diameter_mm = 0.125, length_mm = 160.0 }
taps = { l0_mm = 0.0, ls_mm = 150.0 }
drive = { supply_v = 6.5, shunt_ohm = 0.1, switch_ohm = 0.02 }
load = { mass_kg = 0.08, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.4 }
limits = { maximum_duty = 0.5 }

[[channel]]
name = "right"
wire = { diameter_mm = 0.125, length_mm = 160.0 }
drive = { supply_v = 6.5 }
load = { mass_kg = 0.08, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.4 }

[[channel]]
name = "flexor"
wire = { diameter_mm = 0.125, length_mm = 160.0 }
drive.supply_v = 6.5

[[channel]]
name = "extensor"
wire = { diameter_mm = 0.125, length_mm = 160.0 }
drive.supply_v = 6.5

[[joint]]
name = "knee"
agonist = "flexor"
antagonist = "extensor"
radius_mm = 8.0
inertia_kg_mm2 = 2.5
"#;
const CHANNELS: usize = 4;
const PERIOD_NS: u64 = 1_000_000;
/// Cycles an input is worth at most: a few bytes must not take minutes.
const MOST_CYCLES: usize = 400;

/// Cycles of sound samples that are at hand: more than a converter may repeat itself.
const RECORDED: usize = 64;

/// A rig under control, its channels proved, and the rules of its desk.
struct Bench {
    engine: Engine,
    rules: Vec<ChannelRules>,
    /// Largest duty of each channel, and that of its sensing pulse.
    most: Vec<f64>,
    least: Vec<f64>,
    longest_lease_ns: u64,
    /// What simulated wires at rest under the sensing pulse showed.
    sound: Vec<Vec<Sample>>,
}

static BENCH: LazyLock<Bench> = LazyLock::new(|| Bench::new().unwrap_or_else(|error| panic!("a good rig: {error}")));

impl Bench {
    fn new() -> Result<Bench, Box<dyn std::error::Error>> {
        let rig = Rig::parse(RIG, "hostile.toml")?;
        let mut engine = Engine::at_rest(&rig, None)?;
        let mut wires = SimulatedRig::new(&rig)?;
        wires.start()?;
        let (mut duty, mut sound) = (vec![0.0; CHANNELS], Vec::new());
        for cycle in 1..=2 * RECORDED {
            let mut samples = vec![Sample::NONE; CHANNELS];
            wires.exchange(&duty, &mut samples)?;
            engine.cycle(Beat { now_ns: cycle as u64 * PERIOD_NS, missed: 0 }, Ok(()), &samples, &mut duty, |_| {});
            if cycle > RECORDED {
                sound.push(samples);
            }
        }
        let mut state = Snapshot::new(CHANNELS);
        engine.describe(0, DriverState::Running, &mut state);
        assert!(state.channels().iter().all(|channel| channel.mode() == Mode::Off), "not proved: {state:?}");
        Ok(Bench {
            engine,
            rules: ChannelRules::of(&rig)?,
            most: rig.channels.iter().map(|channel| channel.limits.max_duty).collect(),
            least: rig.channels.iter().map(|channel| channel.control.minimum_duty).collect(),
            longest_lease_ns: rig.channels.iter().map(|c| (c.limits.max_lease_s * 1e9) as u64).max().unwrap_or(0),
            sound,
        })
    }
}

/// A script for whoever commands and for the converter: requests of any bits, cycles with sound samples, with any samples, with
/// errors of the backend, and time that passes.
///
/// Whatever it is: every duty is a number from 0 to the channel's largest, that of a latched channel is 0 until it is reset, that of one that has
/// not proved itself is the sensing pulse at most; what the rules let through is finite and within its lease; and when nobody has said
/// anything for longer than the longest lease, nothing but the sensing pulse is left.
///
/// # Panics
/// Where one of these is broken.
pub fn command(bytes: &[u8]) {
    let bench = &*BENCH;
    let mut script = Script::new(bytes);
    let mut run = Run {
        bench,
        engine: bench.engine.clone(),
        now_ns: 1_000_000_000,
        cycles: 0,
        reset: [false; CHANNELS],
        state: Snapshot::new(CHANNELS),
    };
    while let Some(step) = script.step() {
        if run.cycles > MOST_CYCLES {
            break;
        }
        match step % 8 {
            0..=2 => run.ask(&request(&mut script, step), u64::from(step)),
            3 => (0..step >> 3).for_each(|_| run.cycle(0, Ok(()), None)),
            4 => {
                let samples: Vec<Sample> = (0..CHANNELS).map(|_| sample(&mut script)).collect();
                run.cycle(0, Ok(()), Some(&samples));
            }
            5 => {
                let error = BackendError::from_code(u32::from(step >> 3), u32::from(script.byte()));
                run.cycle(0, error.map_or(Ok(()), Err), None);
            }
            6 => run.cycle(u64::from(step >> 3), Ok(()), None),
            _ => run.now_ns = run.now_ns.saturating_add(PERIOD_NS << (step >> 3)),
        }
    }
    run.now_ns = run.now_ns.saturating_add(bench.longest_lease_ns);
    run.cycle(0, Ok(()), None);
    for (channel, state) in run.state.channels().iter().enumerate() {
        assert!(state.duty <= bench.least[channel], "channel {channel} is powered by nobody: {state:?}");
    }
}

struct Run {
    bench: &'static Bench,
    engine: Engine,
    now_ns: u64,
    cycles: usize,
    /// Channels that were reset since their fault was latched: they may prove themselves.
    reset: [bool; CHANNELS],
    state: Snapshot,
}

impl Run {
    /// What the desk does with a request, and the loop with what the desk lets through.
    fn ask(&mut self, command: &Command, ticket: u64) {
        let all = command.channel == ALL_CHANNELS;
        for channel in 0..CHANNELS {
            if !all && command.channel as usize % CHANNELS != channel {
                continue;
            }
            let Ok((ask, hold_s)) = self.bench.rules[channel].check(command) else { continue };
            assert!(hold_s >= 0.0 && hold_s * 1e9 <= self.bench.longest_lease_ns as f64, "{command:?}: {hold_s} s");
            let hold_ns = if hold_s > 0.0 { (hold_s * 1e9) as u64 } else { u64::MAX };
            if !self.engine.has_order(channel) {
                self.reset[channel] |= ask == Ask::Reset;
                self.engine.take(&Order { ticket, channel, ask, hold_ns }, self.now_ns);
            }
        }
    }

    fn cycle(&mut self, missed: u64, exchanged: Result<(), BackendError>, samples: Option<&[Sample]>) {
        let sound = &self.bench.sound[self.cycles % self.bench.sound.len()];
        self.now_ns += (1 + missed) * PERIOD_NS;
        self.cycles += 1;
        let mut duty = [f64::NAN; CHANNELS];
        let beat = Beat { now_ns: self.now_ns, missed };
        let reset = &mut self.reset;
        self.engine.cycle(beat, exchanged, samples.unwrap_or(sound), &mut duty, |event| {
            if let Occurrence::Tripped(_) = event.what {
                reset[event.channel as usize] = false;
            }
        });
        self.engine.describe(self.now_ns, DriverState::Running, &mut self.state);
        for (channel, (duty, state)) in duty.iter().zip(self.state.channels()).enumerate() {
            let most = match state.mode() {
                Mode::Fault if !self.reset[channel] => 0.0,
                Mode::Fault | Mode::Waiting => self.bench.least[channel],
                _ => self.bench.most[channel],
            };
            assert!((0.0..=most).contains(duty), "channel {channel}: {duty}, may have {most}: {state:?}");
            assert!(*duty == state.duty, "what is told is what is put out");
        }
    }
}

/// Any bits, or a number that may mean something.
fn number(script: &mut Script) -> f64 {
    match script.byte() {
        whim @ 0..64 => f64::from(whim) / 32.0,
        whim @ 64..128 => 0.145 + f64::from(whim - 64) * 0.0005,
        whim @ 128..192 => f64::from(whim - 128) * 0.25,
        _ => f64::from_bits(script.u64()),
    }
}

fn request(script: &mut Script, step: u8) -> Command {
    let whim = script.byte();
    let plain = step & 0x80 == 0;
    Command {
        client: 1,
        sequence: 1,
        channel: if whim & 0x80 == 0 { u32::from(whim) % 5 } else { ALL_CHANNELS },
        kind: if plain { u32::from(step >> 3) % 8 } else { script.u32() },
        value: number(script),
        hold_s: if plain { 0.0 } else { number(script) },
    }
}

fn sample(script: &mut Script) -> Sample {
    let [v1_v, v2_v, v3_v, current_a, supply_v] = std::array::from_fn(|_| number(script));
    Sample { v1_v, v2_v, v3_v, current_a, supply_v }
}
