//! The wires of a rig driven by recordings of one run, one a channel, as they act on each other.

use sinew_physics::{DriveKind, Inputs, Outputs, Surroundings, Wire, drawn_meanwhile_a};
use sinew_rig::Rig;

use crate::error::{Error, What};
use crate::recording::Recording;

/// What the wires of a rig do under the inputs of recordings of one run, by recording and row: the inputs as the rig
/// has them, and what the sensors would have shown. Each recording is of the channel with the index beside it; they
/// have their times in common. A neighbour (`thermal.neighbour`) and who else draws from a supply
/// (`electrical.supply_sag`) act as they are at the end of the row before. A channel that no recording is of does not
/// act.
///
/// # Errors
/// As [`Recording::simulated`]; other times than those of the first.
pub fn simulated_together(rig: &Rig, run: &[(usize, &Recording)]) -> Result<Vec<Vec<(Inputs, Outputs)>>, Error> {
    let Some((_, first)) = run.first() else { return Ok(Vec::new()) };
    let mut wires = Vec::with_capacity(run.len());
    let mut inputs = Vec::with_capacity(run.len());
    for (channel, recording) in run {
        let Some(channel) = rig.channels.get(*channel) else {
            return Err(Error::new(
                recording.name(),
                What::NoSuchChannel { found: *channel, channels: rig.channels.len() },
            ));
        };
        if recording.time_s() != first.time_s() {
            return Err(Error::new(recording.name(), What::OtherTimes { than: first.name().to_string() }));
        }
        let rows: Vec<(Inputs, f64)> = recording.inputs_for(&channel.model)?.collect();
        let rest = rows.first().map_or(channel.model.rest_inputs(), |(inputs, _)| *inputs);
        let impossible = |error| Error::new(recording.name(), What::Impossible { error });
        wires.push(Wire::with_inputs(&channel.model, &rest).map_err(impossible)?);
        inputs.push(rows.into_iter());
    }
    let place = |channel: usize| run.iter().position(|(of, _)| *of == channel);
    let neighbours: Vec<Option<usize>> = run.iter().map(|(c, _)| rig.neighbour_of(*c).and_then(place)).collect();
    let at_supply: Vec<Vec<usize>> =
        run.iter().map(|(c, _)| rig.at_supply_of(*c).filter_map(place).collect()).collect();
    let mut seen: Vec<Vec<(Inputs, Outputs)>> = run.iter().map(|_| Vec::with_capacity(first.len())).collect();
    while let Some(row) = inputs.iter_mut().map(Iterator::next).collect::<Option<Vec<(Inputs, f64)>>>() {
        let draws: Vec<[f64; 2]> = (0..run.len())
            .map(|i| {
                let (given, _) = row[i];
                match rig.channels[run[i].0].model.drive.kind {
                    DriveKind::Pwm => [given.drive, wires[i].current_a()],
                    DriveKind::Current => [1.0, given.drive],
                    DriveKind::Amplifier(_) => [1.0, wires[i].current_a()],
                    DriveKind::Power | DriveKind::Temperature => [0.0, 0.0],
                }
            })
            .collect();
        let warm: Vec<f64> = wires.iter().map(Wire::temperature_c).collect();
        for (i, wire) in wires.iter_mut().enumerate() {
            let (given, dt_s) = row[i];
            let around = Surroundings {
                neighbour_c: neighbours[i].map(|neighbour| warm[neighbour]),
                others_a: at_supply[i].iter().map(|j| drawn_meanwhile_a(draws[i][0], draws[*j][0], draws[*j][1])).sum(),
            };
            around.warm(wire);
            wire.step(&around.acting_on(&rig.channels[run[i].0].model, given), dt_s);
            if let Some(undefined) = wire.undefined() {
                let what = What::Undefined { law: undefined.law, time_s: undefined.time_s };
                return Err(Error::new(run[i].1.name(), what));
            }
            seen[i].push((given, wire.outputs()));
        }
    }
    Ok(seen)
}
