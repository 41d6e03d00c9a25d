//! The differences between recorded and replayed output.

use sinew_ipc::{ChannelField, ChannelState, CycleHeader};

/// The published fields that a replay computes anew: everything but the samples it starts from and the backend's errors.
fn fields() -> impl Iterator<Item = &'static ChannelField> {
    ChannelState::FIELDS.iter().filter(|field| field.is_replay_output())
}

/// A place where two runs differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Number of the cycle.
    pub cycle: u64,
    /// Since the first cycle of the recording, s.
    pub time_s: f64,
    /// What was recorded.
    pub recorded: f64,
    /// What comes out now.
    pub replayed: f64,
}

/// How one field of one channel differs over a whole recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Cycles in which it differs by at least one bit; one NaN is like the other.
    pub cycles: u64,
    /// The largest difference, in the field's unit, over the cycles in which both are numbers; NaN without any.
    pub max: f64,
    /// RMS of the difference over those; NaN without any.
    pub rms: f64,
    /// Cycles in which only one of the two is a number.
    pub only_one: u64,
    /// The first of the cycles.
    pub first: Place,
}

/// Gathers the differences of one field of one channel.
#[derive(Debug, Clone, Copy, Default)]
struct Gathered {
    cycles: u64,
    only_one: u64,
    numbers: u64,
    squares: f64,
    max: f64,
    first: Option<Place>,
}

/// Lays replayed states beside recorded ones, cycle by cycle.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Of each channel and each of [`fields`].
    gathered: Vec<Vec<Gathered>>,
    cycles: u64,
    start_ns: Option<u64>,
}

impl Comparison {
    /// Of so many channels.
    pub fn new(channels: usize) -> Comparison {
        Comparison { gathered: vec![vec![Gathered::default(); fields().count()]; channels], cycles: 0, start_ns: None }
    }

    /// Adds a cycle.
    pub fn add(&mut self, head: &CycleHeader, recorded: &[ChannelState], replayed: &[ChannelState]) {
        let start_ns = *self.start_ns.get_or_insert(head.monotonic_ns);
        self.cycles += 1;
        for ((gathered, then), now) in self.gathered.iter_mut().zip(recorded).zip(replayed) {
            for (gathered, field) in gathered.iter_mut().zip(fields()) {
                let (recorded, replayed) = (field.of(then), field.of(now));
                // bit for bit, so that −0 is not 0; infinities are equal to themselves and have no difference
                let both = recorded.is_finite() && replayed.is_finite();
                gathered.numbers += u64::from(both);
                if recorded.to_bits() == replayed.to_bits() || (recorded.is_nan() && replayed.is_nan()) {
                    continue;
                }
                let time_s = head.monotonic_ns.saturating_sub(start_ns) as f64 * 1e-9;
                gathered.first.get_or_insert(Place { cycle: head.cycle, time_s, recorded, replayed });
                gathered.cycles += 1;
                if both {
                    let difference = (replayed - recorded).abs();
                    gathered.squares += difference * difference;
                    gathered.max = gathered.max.max(difference);
                } else {
                    gathered.only_one += 1;
                }
            }
        }
    }

    /// Cycles compared.
    pub fn cycles(&self) -> u64 {
        self.cycles
    }

    /// Whether everything is the same, bit for bit.
    pub fn is_identical(&self) -> bool {
        self.gathered.iter().flatten().all(|gathered| gathered.cycles == 0)
    }

    /// What differs in a channel, in the table's order.
    pub fn of_channel(&self, channel: usize) -> impl Iterator<Item = (&'static ChannelField, Difference)> {
        let gathered = self.gathered.get(channel).into_iter().flatten();
        fields().zip(gathered).filter_map(|(field, gathered)| {
            let number = |value: f64| if gathered.cycles > gathered.only_one { value } else { f64::NAN };
            let difference = Difference {
                cycles: gathered.cycles,
                max: number(gathered.max),
                rms: number((gathered.squares / gathered.numbers as f64).sqrt()),
                only_one: gathered.only_one,
                first: gathered.first?,
            };
            Some((field, difference))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bit_is_a_difference_and_a_nan_is_like_another() {
        let mut comparison = Comparison::new(2);
        let head = |cycle| CycleHeader { cycle, monotonic_ns: cycle * 1_000_000, missed: 0 };
        let then = ChannelState { temperature_c: 25.0, ..ChannelState::UNKNOWN };
        comparison.add(&head(5), &[then, then], &[then, then]);
        assert!(comparison.is_identical());
        let quiet = ChannelState { measured_length_m: -f64::NAN, ..then };
        comparison.add(&head(6), &[then, then], &[quiet, quiet]);
        assert!(comparison.is_identical(), "{comparison:?}");

        let bit = ChannelState { temperature_c: 25.0f64.next_up(), power_w: -0.0, mode: 3, ..then };
        comparison.add(&head(7), &[then, then], &[then, bit]);
        let measured = ChannelState { measured_length_m: 0.16, temperature_c: 28.0, ..then };
        comparison.add(&head(8), &[then, then], &[then, measured]);
        assert!(!comparison.is_identical());
        assert_eq!(comparison.of_channel(0).count(), 0);
        let found: Vec<(&str, Difference)> = comparison.of_channel(1).map(|(f, d)| (f.name, d)).collect();
        assert_eq!(
            found.iter().map(|(name, _)| *name).collect::<Vec<_>>(),
            ["measured_length_m", "temperature_c", "power_w", "mode"]
        );
        let (length, temperature) = (found[0].1, found[1].1);
        assert!(length.max.is_nan() && length.only_one == 1 && length.first.cycle == 8);
        assert_eq!((temperature.cycles, temperature.max, temperature.rms), (2, 3.0, 1.5));
        assert_eq!((temperature.first.cycle, temperature.first.time_s), (7, 2e-3));
        assert_eq!((found[2].1.cycles, found[2].1.max), (1, 0.0), "minus zero is another number");
    }
}
