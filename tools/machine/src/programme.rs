//! A programme from a file: what heats the wire and where its end is, over time. What a diagnosis proposes to record next is one.

use sinew_recording::{Column, Recording};

use crate::wave::Quantity;

/// What a wire is driven by, row by row, from the first row on.
#[derive(Debug, Clone, PartialEq)]
pub struct Programme {
    name: String,
    /// Start of every row, s from the first.
    time_s: Vec<f64>,
    quantity: Quantity,
    /// In the quantity's unit, held from its row to the next.
    heat: Vec<f64>,
    course: Course,
}

/// What the wire's end does.
#[derive(Debug, Clone, PartialEq)]
enum Course {
    /// Elongation, m, straight from row to row.
    Position(Vec<f64>),
    /// Pull, N, held from its row to the next.
    Force(Vec<f64>),
    /// As the wire's own load pulls it.
    Left,
}

/// What is asked of the cross-head at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// This elongation, m.
    At(f64),
    /// This force, N.
    Pulled(f64),
    /// Nothing: the wire's own load pulls it.
    Left,
}

/// Why a file is no programme for a test machine.
#[derive(Debug, Clone, PartialEq)]
pub enum NoProgramme {
    /// It drives a switch from a supply, which the machine's amplifier has not.
    Switched,
    /// No column says what heats.
    Unheated,
    /// No column says where the wire's end is.
    Loose,
    /// This column moves the wire's end, which a running rig has nothing for.
    Moved(Column),
    /// It asks for more than a supply can be on for; at this time, s.
    BeyondOne(f64),
    /// A value is missing; in this column, at this time, s.
    Gap(Column, f64),
    /// A value is none that can be asked for: below zero.
    Negative(Column, f64),
}

impl std::fmt::Display for NoProgramme {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            NoProgramme::Switched => write!(f, "its duty is of a wire that a driver switches"),
            NoProgramme::Unheated => write!(f, "nothing in it says what heats the wire"),
            NoProgramme::Loose => write!(f, "nothing in it says where the wire's end is"),
            NoProgramme::Moved(column) => {
                write!(f, "{} moves the wire's end, which a running rig has nothing for", column.name())
            }
            NoProgramme::BeyondOne(time_s) => write!(f, "duty is above 1 at {time_s} s"),
            NoProgramme::Gap(column, time_s) => write!(f, "{} has no value at {time_s} s", column.name()),
            NoProgramme::Negative(column, time_s) => write!(f, "{} is below 0 at {time_s} s", column.name()),
        }
    }
}

impl std::error::Error for NoProgramme {}

impl NoProgramme {
    /// What to do.
    pub fn remedy(&self) -> &'static str {
        match self {
            NoProgramme::Switched => {
                "play it on a running rig (--rig NAME), which switches its wires; the test machine takes current_a or power_w"
            }
            NoProgramme::Unheated => {
                "give a column current_a, in A, or power_w, in W; for a running rig also duty, 0 to 1"
            }
            NoProgramme::Loose => "give a column position_m, elongation in m, or force_n, in N",
            NoProgramme::Moved(_) => {
                "take the column out: the rig's own load pulls the wire; the test machine (RIG.toml without --rig) moves it"
            }
            NoProgramme::BeyondOne(_) => "a duty is a share, 0 to 1",
            NoProgramme::Gap(..) => "give every row a value: inputs have no gaps",
            NoProgramme::Negative(..) => "a heater gives, and a wire pulls: 0 or more",
        }
    }
}

impl Programme {
    /// From a file's columns: `current_a` or `power_w`, and `position_m` or `force_n`; `time_s` counts from its first row.
    ///
    /// # Errors
    /// What is missing in it.
    pub fn of(recording: &Recording) -> Result<Programme, NoProgramme> {
        let heats = [(Column::CurrentA, Quantity::Current), (Column::PowerW, Quantity::Power)];
        let Some((column, quantity)) = heats.into_iter().find(|(column, _)| recording.get(*column).is_some()) else {
            let is_switched = recording.get(Column::Duty).is_some();
            return Err(if is_switched { NoProgramme::Switched } else { NoProgramme::Unheated });
        };
        let heat = values(recording, column, true)?;
        let course = if recording.get(Column::PositionM).is_some() {
            Course::Position(values(recording, Column::PositionM, false)?)
        } else if recording.get(Column::ForceN).is_some() {
            Course::Force(values(recording, Column::ForceN, true)?)
        } else {
            return Err(NoProgramme::Loose);
        };
        Ok(Programme { name: recording.name().into(), time_s: counted(recording), quantity, heat, course })
    }

    /// For a running rig, from `duty`, `power_w` or `current_a`, the first of them that is there. Its own load pulls the wire.
    ///
    /// # Errors
    /// What is missing in it, or too much.
    pub fn on_rig(recording: &Recording) -> Result<Programme, NoProgramme> {
        let heats =
            [(Column::Duty, Quantity::Duty), (Column::PowerW, Quantity::Power), (Column::CurrentA, Quantity::Current)];
        let there = |column: &Column| recording.get(*column).is_some();
        if let Some(column) = [Column::PositionM, Column::ForceN].into_iter().find(there) {
            return Err(NoProgramme::Moved(column));
        }
        let (column, quantity) = heats.into_iter().find(|(column, _)| there(column)).ok_or(NoProgramme::Unheated)?;
        let heat = values(recording, column, true)?;
        let beyond = heat.iter().zip(recording.time_s()).find(|(heat, _)| quantity == Quantity::Duty && **heat > 1.0);
        if let Some((_, time_s)) = beyond {
            return Err(NoProgramme::BeyondOne(*time_s));
        }
        Ok(Programme {
            name: recording.name().into(),
            time_s: counted(recording),
            quantity,
            heat,
            course: Course::Left,
        })
    }

    /// The file's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How long it takes, s: to the end of its last row, which is as long as the one before.
    pub fn duration_s(&self) -> f64 {
        match self.time_s[..] {
            [.., before, last] => 2.0 * last - before,
            _ => 0.0,
        }
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    /// What its heat is counted in.
    pub fn quantity(&self) -> Quantity {
        self.quantity
    }

    /// The heat at a time, in the quantity's unit.
    pub fn heat_at(&self, time_s: f64) -> f64 {
        self.heat[self.row_at(time_s)]
    }

    /// The most heat, in the quantity's unit.
    pub fn most_heat(&self) -> f64 {
        self.heat.iter().copied().fold(0.0, f64::max)
    }

    /// Where the wire's end is to be at a time.
    pub fn end_at(&self, time_s: f64) -> End {
        let row = self.row_at(time_s);
        match &self.course {
            Course::Left => End::Left,
            Course::Force(newton) => End::Pulled(newton[row]),
            Course::Position(elongation_m) => {
                let next = (row + 1).min(elongation_m.len() - 1);
                let (from_s, to_s) = (self.time_s[row], self.time_s[next]);
                let share = if to_s > from_s { ((time_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0) } else { 0.0 };
                End::At(elongation_m[row] + share * (elongation_m[next] - elongation_m[row]))
            }
        }
    }

    /// The longest elongation it asks for, m; 0 where it asks for forces.
    pub fn longest_m(&self) -> f64 {
        match &self.course {
            Course::Position(elongation_m) => elongation_m.iter().copied().fold(0.0, f64::max),
            Course::Force(_) | Course::Left => 0.0,
        }
    }

    /// The largest force it asks for, N; 0 where it asks for elongations.
    pub fn largest_n(&self) -> f64 {
        match &self.course {
            Course::Force(newton) => newton.iter().copied().fold(0.0, f64::max),
            Course::Position(_) | Course::Left => 0.0,
        }
    }

    /// The row in force at a time.
    fn row_at(&self, time_s: f64) -> usize {
        self.time_s.partition_point(|start_s| *start_s <= time_s + 1e-9).saturating_sub(1)
    }
}

/// Times from the first row on, s.
fn counted(recording: &Recording) -> Vec<f64> {
    let first_s = recording.time_s().first().copied().unwrap_or(0.0);
    recording.time_s().iter().map(|time_s| time_s - first_s).collect()
}

/// All values of a column.
fn values(recording: &Recording, column: Column, is_positive: bool) -> Result<Vec<f64>, NoProgramme> {
    let values = recording.get(column).unwrap_or(&[]).to_vec();
    for (value, time_s) in values.iter().zip(recording.time_s()) {
        if !value.is_finite() {
            return Err(NoProgramme::Gap(column, *time_s));
        }
        if is_positive && *value < 0.0 {
            return Err(NoProgramme::Negative(column, *time_s));
        }
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(columns: &[(Column, [f64; 3])]) -> Recording {
        let mut recording = Recording::new("next.csv", vec![5.0, 5.5, 6.0]).unwrap();
        columns.iter().for_each(|(column, values)| recording.set(*column, values.to_vec()).unwrap());
        recording
    }

    #[test]
    fn heat_is_held_and_positions_are_joined() {
        let of = recording(&[(Column::CurrentA, [0.1, 0.3, 0.2]), (Column::PositionM, [0.0, 1e-3, 1e-3])]);
        let programme = Programme::of(&of).unwrap();
        assert_eq!((programme.duration_s(), programme.rows(), programme.quantity()), (1.5, 3, Quantity::Current));
        assert_eq!([0.0, 0.49, 0.5, 1.4].map(|t| programme.heat_at(t)), [0.1, 0.1, 0.3, 0.2]);
        assert_eq!(programme.end_at(0.25), End::At(0.5e-3));
        assert_eq!(programme.end_at(1.4), End::At(1e-3));
        assert_eq!((programme.longest_m(), programme.largest_n(), programme.most_heat()), (1e-3, 0.0, 0.3));
    }

    #[test]
    fn a_running_rig_takes_duties_and_moves_no_end() {
        let of = recording(&[(Column::Duty, [0.0, 0.5, 1.0]), (Column::PowerW, [1.0; 3])]);
        let programme = Programme::on_rig(&of).unwrap();
        assert_eq!(
            (programme.quantity(), programme.most_heat(), programme.end_at(0.3)),
            (Quantity::Duty, 1.0, End::Left)
        );
        let refused = |columns: &[(Column, [f64; 3])]| Programme::on_rig(&recording(columns)).unwrap_err();
        let moved = [(Column::PowerW, [0.1; 3]), (Column::ForceN, [1.0; 3])];
        assert_eq!(refused(&moved), NoProgramme::Moved(Column::ForceN));
        assert_eq!(refused(&[(Column::Duty, [0.1, 1.2, 0.1])]), NoProgramme::BeyondOne(5.5));
        assert_eq!(refused(&[(Column::TemperatureC, [30.0; 3])]), NoProgramme::Unheated);
    }

    #[test]
    fn what_is_no_programme_is_refused_in_words() {
        let refused = |columns: &[(Column, [f64; 3])]| Programme::of(&recording(columns)).unwrap_err();
        assert_eq!(refused(&[(Column::Duty, [0.1; 3])]), NoProgramme::Switched);
        assert_eq!(refused(&[(Column::PositionM, [0.0; 3])]), NoProgramme::Unheated);
        assert_eq!(refused(&[(Column::PowerW, [0.1; 3])]), NoProgramme::Loose);
        let gap = [(Column::PowerW, [0.1; 3]), (Column::ForceN, [1.0, f64::NAN, 1.0])];
        assert_eq!(refused(&gap), NoProgramme::Gap(Column::ForceN, 5.5));
        let negative = [(Column::CurrentA, [0.1, 0.1, -0.1]), (Column::ForceN, [1.0; 3])];
        assert_eq!(refused(&negative), NoProgramme::Negative(Column::CurrentA, 6.0));
    }
}
