//! False trips of the supervisor. Runs rigs through an hour (or the seconds given) of ordinary operation on the simulated
//! clock, with the converter's noise, draughts, drifting air temperature and supply, and counts the faults. Beside it: how far the published
//! temperatures are over and under the true ones.
//!
//! `cargo run -p sinew-lockstep --example false_trips -- 3600` prints the table of `docs/supervisor.md`; it ends with 1 if
//! anything has tripped.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use sinew_driver::{Ask, Program};
use sinew_ipc::ChannelState;
use sinew_lockstep::Lockstep;
use sinew_rig::{Rig, SamplingCircuit};
use sinew_sim_backend::World;

/// What happens to the world and to a channel's task changes about so often, s.
const CHANGE_S: f64 = 2.0;

/// A small generator, the same for the same seed.
struct Dice(u64);

impl Dice {
    /// Evenly in 0 .. 1.
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// What a run came to.
struct Outcome {
    trips: String,
    count: usize,
    derated: f64,
    dark: f64,
    /// Published less true temperature, K, in every look.
    over_k: Vec<f64>,
    wall_s: f64,
}

impl Outcome {
    /// What this share of the looks does not exceed, K; sorts them.
    fn over_in_k(&mut self, share: f64) -> f64 {
        let place = (share * (self.over_k.len().saturating_sub(1)) as f64).round() as usize;
        self.over_k.sort_unstable_by(f64::total_cmp);
        self.over_k.get(place).copied().unwrap_or(f64::NAN)
    }
}

/// A joint's two wires on 12 V.
fn joints(pairs: usize) -> Result<Rig, Box<dyn Error>> {
    let mut text = String::from("[rig]\nname = \"joints\"\n");
    for pair in 0..pairs {
        for wire in ["flexor", "extensor"] {
            text += &format!(
                "[[channel]]\nname = \"{wire}{pair}\"\nwire = {{ diameter_mm = 0.05, length_mm = 160.0 }}\ntaps = {{ ls_mm = 150.0 }}\n\
                 drive = {{ supply_v = 12.0, shunt_ohm = 0.1, switch_ohm = 0.02 }}\n"
            );
        }
        text += &format!(
            "[[joint]]\nname = \"joint{pair}\"\nagonist = \"flexor{pair}\"\nantagonist = \"extensor{pair}\"\n\
             radius_mm = 8.0\ninertia_kg_mm2 = 2.5\n"
        );
    }
    Ok(Rig::parse(&text, "joints.toml")?)
}

/// The hexapod with every channel's supply and current on one input.
fn sharing(mut rig: Rig) -> Rig {
    for channel in &mut rig.channels {
        channel.adc.circuit = SamplingCircuit::Shared;
        // the off-phase in which the supply is seen must last
        channel.limits.max_duty = channel.limits.max_duty.min(1.0 - channel.control.minimum_duty);
    }
    rig
}

/// Work of all kinds: minutes of walking, and steps, ramps, holds, rests and plain duties in between.
fn work(rig: &Rig, seconds: f64, program: Option<Program>, seed: u64) -> Result<Outcome, Box<dyn Error>> {
    let started = Instant::now();
    let mut bench = Lockstep::new(rig, program)?;
    let mut dice = Dice(seed);
    let channels = rig.channels.len();
    let (mut derated, mut dark) = (0u64, 0u64);
    let mut over_k = Vec::new();
    let mut air_k = 0.0;
    bench.run_s(0.1);
    while bench.time_s() < seconds {
        // Doors, windows, sun, other consumers of the supply.
        air_k = (air_k + 2.0 * (dice.roll() - 0.5)).clamp(-8.0, 8.0);
        let supply = 0.93 + 0.12 * dice.roll();
        for channel in 0..channels {
            let draught = if dice.roll() < 0.3 { 0.5 * dice.roll() } else { 0.0 };
            bench.backend().disturb(channel, &World { ambient_k: air_k, draught, supply, ..World::CALM });
            match (10.0 * dice.roll()) as u32 {
                // half of them go on with what they do: the program, or a hold
                0..5 => {}
                5..8 => {
                    bench.move_to(channel, dice.roll());
                }
                8 => {
                    bench.ask(channel, Ask::Duty(0.3 * dice.roll()));
                }
                _ => {
                    bench.ask(channel, Ask::Off);
                }
            }
        }
        let until = bench.period() + ((0.5 + dice.roll()) * CHANGE_S * rig.rate_hz) as u64;
        while bench.period() < until {
            bench.run(100);
            for channel in 0..channels {
                let flags = bench.state(channel).flags;
                let budgets = ChannelState::FLAG_HEAT_BUDGET | ChannelState::FLAG_TEMPERATURE_BUDGET;
                derated += u64::from(flags & budgets != 0);
                dark += u64::from(flags & ChannelState::FLAG_DARK != 0);
                let true_c = bench.wires().wire(channel).map_or(f64::NAN, |wire| wire.temperature_c());
                over_k.push(bench.state(channel).temperature_c - true_c);
            }
        }
    }
    let looks = (bench.period() / 100 * channels as u64) as f64;
    let trips = bench.trips();
    let first: Vec<String> = trips
        .iter()
        .take(5)
        .map(|trip| {
            format!(
                "{} of {} at {:.1} s",
                trip.fault.flag(),
                rig.channels[trip.channel].name,
                trip.period as f64 / rig.rate_hz
            )
        })
        .collect();
    Ok(Outcome {
        trips: first.join(", "),
        count: trips.len(),
        derated: derated as f64 / looks,
        dark: dark as f64 / looks,
        over_k,
        wall_s: started.elapsed().as_secs_f64(),
    })
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let seconds = match std::env::args().nth(1) {
        Some(text) => text.parse().map_err(|_| format!("{text:?} is no number of seconds, such as 3600"))?,
        None => 3600.0,
    };
    println!(
        "| rig | channels | simulated, s | false trips | derated | dark | published over the truth: median, 95 %, most | most under | took, s |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|"
    );
    let hexapod = Rig::hexapod();
    let walk = Some(Program::tripod(hexapod.channels.len(), 6.0));
    let runs = [
        ("hexapod, walking and commanded", hexapod.clone(), walk.clone(), 1),
        ("the same, shared inputs", sharing(hexapod), walk, 2),
        ("four joints, 0.05 mm", joints(4)?, None, 3),
    ];
    let mut all = 0;
    for (name, rig, program, seed) in runs {
        let mut outcome = work(&rig, seconds, program, seed)?;
        let [median_k, most_k, worst_k, least_k] = [0.5, 0.95, 1.0, 0.0].map(|share| outcome.over_in_k(share));
        println!(
            "| {name} | {} | {seconds} | {} | {:.2} % | {:.3} % | {median_k:.1} / {most_k:.1} / {worst_k:.1} K | {:.1} K | {:.0} |",
            rig.channels.len(),
            outcome.count,
            100.0 * outcome.derated,
            100.0 * outcome.dark,
            -least_k,
            outcome.wall_s
        );
        if outcome.count > 0 {
            eprintln!("{name}: {}", outcome.trips);
        }
        all += outcome.count;
    }
    Ok(if all == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
