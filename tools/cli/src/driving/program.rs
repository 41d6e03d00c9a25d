//! What a rig does while nobody commands it: `program` in its `[rig]`.

use std::path::Path;

use sinew_control::StrokeRange;
use sinew_driver::Program;
use sinew_rig::{NO_PROGRAM, Rig, STEPS, WALK, nearest};

use crate::commands::unknown_channel;
use crate::driving::score::Score;
use crate::driving::setpoint::Setpoint;
use crate::failure::Failure;

/// Time of one step of a rig that walks, and of a wire that goes up and down, s.
const STEP_S: f64 = 6.0;

/// In a sentence.
pub fn says(rig: &Rig) -> String {
    match rig.program.as_str() {
        NO_PROGRAM => {
            "it stands still until it is commanded (`sinew set`); `program = \"steps\"` in [rig] moves it".into()
        }
        STEPS => "its wires go up and down in turns, until they are commanded".into(),
        WALK => "it walks on the spot; a wire that is commanded does as it is told".into(),
        file => format!("it plays {file}; a wire that is commanded does as it is told"),
    }
}

/// What the wires do while nobody commands them.
pub fn of(rig: &Rig) -> Result<Option<Program>, Failure> {
    let channels = rig.channels.len();
    match rig.program.as_str() {
        NO_PROGRAM => Ok(None),
        STEPS => Ok(Some(Program::steps(channels, STEP_S))),
        WALK if channels.is_multiple_of(Program::WIRES_A_LEG) => Ok(Some(Program::tripod(channels, STEP_S))),
        WALK => {
            let what = format!(
                "{}: program \"{WALK}\" needs legs of {} wires, the rig has {channels}",
                rig.file(),
                Program::WIRES_A_LEG
            );
            Err(Failure::input(what).hint(format!("choose \"{STEPS}\", or a file of setpoints")))
        }
        file => {
            // beside the rig file, wherever that is read from
            let path = Path::new(rig.file()).parent().unwrap_or(Path::new("")).join(file);
            if !path.exists() {
                let words = [NO_PROGRAM, STEPS, WALK];
                let meant = nearest(file, words).map_or_else(String::new, |word| format!("did you mean \"{word}\"? "));
                let what = format!(
                    "{}: program \"{file}\" is none that is built in, and no file of that name is there",
                    rig.file()
                );
                return Err(Failure::input(what).hint(format!(
                    "{meant}it is one of {}, or a CSV file of setpoints beside the rig file",
                    words.join(", ")
                )));
            }
            played(rig, &path, &Score::read(&path)?).map(Some)
        }
    }
}

/// A file's setpoints as strokes: a program moves wires, and nothing else.
fn played(rig: &Rig, path: &Path, score: &Score) -> Result<Program, Failure> {
    let mut strokes = vec![vec![None; score.rows.len()]; rig.channels.len()];
    for (column, name) in score.channels.iter().enumerate() {
        let names = rig.channels.iter().map(|channel| channel.name.as_str());
        let (channel, _) =
            rig.channel(name).ok_or_else(|| unknown_channel(&path.display().to_string(), name, names))?;
        let range = StrokeRange::of(&rig.nominal_model(channel))
            .map_err(|error| Failure::input(format!("{}: {name}: {error}", rig.file())))?;
        let mut now = None;
        for (row, place) in score.rows.iter().zip(&mut strokes[channel]) {
            now = match row.setpoints[column] {
                None => now,
                Some(Setpoint::Off) => None,
                Some(Setpoint::Stroke(stroke)) => Some(stroke),
                Some(Setpoint::Way(way_m)) => Some(range.stroke(range.cold_m - way_m)),
                Some(Setpoint::Length(length_m)) => Some(range.stroke(length_m)),
                Some(Setpoint::Duty(_) | Setpoint::Force(_)) => {
                    let what =
                        format!("{}: {name} at {} s: a program moves by stroke or length", path.display(), row.time_s);
                    return Err(Failure::input(what).hint("play duties and forces with `sinew play`"));
                }
            };
            if let Some(stroke) = now.filter(|stroke| !(0.0..=1.0).contains(stroke)) {
                let asked = row.setpoints[column].unwrap_or(Setpoint::Stroke(stroke));
                let (low, high) = match asked {
                    Setpoint::Length(_) => (range.hot_m.min(range.cold_m), range.hot_m.max(range.cold_m)),
                    _ => (0.0, 1.0),
                };
                let (outside, nearest) = asked.outside(low, high, (range.cold_m - range.hot_m).abs());
                return Err(Failure::input(format!("{}:{}: {name}: {outside}", path.display(), row.line))
                    .hint(format!("the nearest is {nearest}; `sinew check` has the strokes")));
            }
            *place = now;
        }
    }
    Ok(Program::played(score.rows.iter().map(|row| row.time_s).collect(), strokes))
}
