//! A reading of the machine's clocks beside each other, and what became of them between two readings.

use std::fmt;

use crate::mapped::{Mapped, Span};

/// What the clocks of a machine showed at one instant.
///
/// On Linux system time, TAI and boot time are CLOCK_MONOTONIC and an offset each: they run at one rate, which the system's time
/// synchronisation adjusts for all of them together. Only setting the clock changes the first two offsets, and only a suspension the third.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reading {
    /// The instant, CLOCK_MONOTONIC, ns: the clock of every stamp of a driver.
    pub monotonic_ns: u64,
    /// System time then, ns since 1970 (UTC).
    pub system_ns: i64,
    /// What [`Reading::system_ns`] is off by at the most beside CLOCK_MONOTONIC, ns.
    pub system_error_ns: u64,
    /// What TAI is ahead of UTC by, s; `None` where the system does not know it (its offset is 0).
    pub tai_offset_s: Option<i32>,
    /// Boot time (CLOCK_BOOTTIME), ns: goes on while the machine is suspended.
    pub boottime_ns: u64,
    /// What that is off by at the most, ns.
    pub boottime_error_ns: u64,
    /// The machine's counter as nobody corrects it (CLOCK_MONOTONIC_RAW), ns.
    pub raw_ns: u64,
    /// What that is off by at the most, ns.
    pub raw_error_ns: u64,
    /// What system time itself is off from UTC by at the most, as the system's synchronisation says, ns; `None` where it is not synchronised.
    pub utc_error_ns: Option<u64>,
}

impl Reading {
    /// System time of a driver's stamp, ns since 1970 (UTC), as the clock is set at this reading.
    pub fn system(&self, monotonic_ns: u64) -> Mapped<i64> {
        let since = monotonic_ns.wrapping_sub(self.monotonic_ns) as i64;
        Mapped { ns: self.system_ns.saturating_add(since), error_ns: self.system_error_ns }
    }

    /// TAI of a driver's stamp, ns since 1970 (TAI); `None` where the system does not know it.
    pub fn tai(&self, monotonic_ns: u64) -> Option<Mapped<i64>> {
        let ahead_ns = i64::from(self.tai_offset_s?) * 1_000_000_000;
        let system = self.system(monotonic_ns);
        Some(Mapped { ns: system.ns.saturating_add(ahead_ns), ..system })
    }

    /// Boot time of a driver's stamp, ns, if the machine was not suspended between it and this reading.
    pub fn boottime(&self, monotonic_ns: u64) -> Mapped<u64> {
        let since = monotonic_ns.wrapping_sub(self.monotonic_ns) as i64;
        Mapped { ns: self.boottime_ns.saturating_add_signed(since), error_ns: self.boottime_error_ns }
    }

    /// The driver's stamp of a moment of system time, ns since 1970 (UTC), as the clock is set at this reading.
    pub fn driver_at_system(&self, system_ns: i64) -> Mapped<u64> {
        let since = system_ns.saturating_sub(self.system_ns);
        Mapped { ns: self.monotonic_ns.saturating_add_signed(since), error_ns: self.system_error_ns }
    }

    /// What became of the clocks from this reading to a later one.
    pub fn change_to(&self, later: &Reading) -> Change {
        let passed_ns = later.monotonic_ns.saturating_sub(self.monotonic_ns);
        let differ = |from: i128, to: i128| {
            let by = to - from - i128::from(passed_ns);
            i64::try_from(by).unwrap_or(if by < 0 { i64::MIN } else { i64::MAX })
        };
        let stepped = differ(self.system_ns.into(), later.system_ns.into());
        let slept = differ(self.boottime_ns.into(), later.boottime_ns.into());
        let slewed = -differ(self.raw_ns.into(), later.raw_ns.into());
        let ppm = |ns: f64| if passed_ns > 0 { 1e6 * ns / passed_ns as f64 } else { f64::NAN };
        Change {
            passed_ns,
            step_ns: stepped,
            step_error_ns: self.system_error_ns + later.system_error_ns,
            suspended_ns: if slept.unsigned_abs() > self.boottime_error_ns + later.boottime_error_ns {
                slept
            } else {
                0
            },
            slew_ppm: ppm(slewed as f64),
            slew_error_ppm: ppm((self.raw_error_ns + later.raw_error_ns) as f64),
            tai_offset_changed: self.tai_offset_s != later.tai_offset_s,
        }
    }
}

/// What became of the machine's clocks between two readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// Time between them, CLOCK_MONOTONIC, ns.
    pub passed_ns: u64,
    /// What the system's clock was set forward by (negative: back), ns.
    pub step_ns: i64,
    /// What that is off by at the most, ns: a smaller step is none that is known.
    pub step_error_ns: u64,
    /// How long the machine was suspended, ns.
    pub suspended_ns: i64,
    /// What CLOCK_MONOTONIC, and with it system time, ran faster than the machine's counter by, ppm: what the synchronisation corrected it by.
    pub slew_ppm: f64,
    /// What that is off by at the most, ppm.
    pub slew_error_ppm: f64,
    /// Whether the offset of TAI is another, or is known only now.
    pub tai_offset_changed: bool,
}

impl Change {
    /// The step of the system's clock, ns; `None` where there was none beyond the error.
    pub fn step(&self) -> Option<i64> {
        (self.step_ns.unsigned_abs() > self.step_error_ns).then_some(self.step_ns)
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.step() {
            Some(step) => write!(f, "the system clock was set {}", Moved(step))?,
            None => write!(f, "the system clock was not set")?,
        }
        if self.slew_error_ppm <= 10.0 {
            write!(f, "; it ran {:+.1} ± {:.1} ppm beside the machine's counter", self.slew_ppm, self.slew_error_ppm)?;
        }
        if self.suspended_ns != 0 {
            write!(f, "; the machine was suspended for {}", Span(self.suspended_ns.unsigned_abs()))?;
        }
        Ok(())
    }
}

/// A step of the system's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// It was set after this, CLOCK_MONOTONIC, ns.
    pub after_ns: u64,
    /// And before this.
    pub before_ns: u64,
    /// What it was set forward by (negative: back), ns.
    pub by_ns: i64,
}

/// Readings of one machine's clocks over some time, as a recording holds them: system time of any stamp in it, and what became of it meanwhile.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    readings: Vec<Reading>,
}

impl History {
    /// Of readings in any order; `None` without any.
    pub fn of(mut readings: Vec<Reading>) -> Option<History> {
        readings.sort_by_key(|reading| reading.monotonic_ns);
        (!readings.is_empty()).then_some(History { readings })
    }

    /// The readings, in order.
    pub fn readings(&self) -> &[Reading] {
        &self.readings
    }

    /// From the first to the last.
    pub fn change(&self) -> Change {
        let (first, last) = (&self.readings[0], &self.readings[self.readings.len() - 1]);
        first.change_to(last)
    }

    /// When the system's clock was set.
    pub fn steps(&self) -> impl Iterator<Item = Step> {
        self.readings.windows(2).filter_map(|pair| {
            let by_ns = pair[0].change_to(&pair[1]).step()?;
            Some(Step { after_ns: pair[0].monotonic_ns, before_ns: pair[1].monotonic_ns, by_ns })
        })
    }

    /// System time of a driver's stamp, ns since 1970 (UTC), as the clock was set then; `None` between two readings that it was set between.
    pub fn system(&self, monotonic_ns: u64) -> Option<Mapped<i64>> {
        let next = self.readings.partition_point(|reading| reading.monotonic_ns <= monotonic_ns);
        let (before, after) = (next.checked_sub(1).map(|at| &self.readings[at]), self.readings.get(next));
        match (before, after) {
            (Some(before), Some(after)) if before.change_to(after).step().is_some() => None,
            (Some(near), _) | (None, Some(near)) => Some(near.system(monotonic_ns)),
            (None, None) => None,
        }
    }

    /// For people, with times from this stamp on: how well system time was known, what its rate was corrected by, when it was set.
    pub fn said(&self, start_ns: u64) -> String {
        use std::fmt::Write as _;
        let first = &self.readings[0];
        let mut said = format!("system time ± {}", Span(first.system_error_ns));
        if let Some(error_ns) = first.utc_error_ns {
            let _ = write!(said, " (and that ± {} from UTC)", Span(error_ns));
        } else {
            said += " (not synchronised)";
        }
        let change = self.change();
        if change.slew_error_ppm <= 10.0 {
            let way = if change.slew_ppm < 0.0 { "slow" } else { "fast" };
            let _ = write!(
                said,
                "; it ran {:.1} ± {:.1} ppm {way} beside the machine's counter",
                change.slew_ppm.abs(),
                change.slew_error_ppm
            );
        }
        for step in self.steps() {
            let at_s = step.before_ns.saturating_sub(start_ns) as f64 * 1e-9;
            let _ = write!(said, "; set {} at {at_s:.1} s", Moved(step.by_ns));
        }
        if change.suspended_ns != 0 {
            let _ = write!(said, "; the machine was suspended for {}", Span(change.suspended_ns.unsigned_abs()));
        }
        said
    }
}

/// A step for people.
struct Moved(i64);

impl fmt::Display for Moved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} by {}", if self.0 < 0 { "back" } else { "forward" }, Span(self.0.unsigned_abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: Reading = Reading {
        monotonic_ns: 5_000_000_000,
        system_ns: 1_700_000_000_000_000_000,
        system_error_ns: 30,
        tai_offset_s: Some(37),
        boottime_ns: 7_000_000_000,
        boottime_error_ns: 30,
        raw_ns: 4_900_000_000,
        raw_error_ns: 50,
        utc_error_ns: None,
    };

    fn after(seconds: u64) -> Reading {
        let ns = seconds * 1_000_000_000;
        Reading {
            monotonic_ns: START.monotonic_ns + ns,
            system_ns: START.system_ns + ns as i64,
            boottime_ns: START.boottime_ns + ns,
            raw_ns: START.raw_ns + ns,
            ..START
        }
    }

    #[test]
    fn a_stamp_is_mapped_both_ways() {
        let at = START.system(6_000_000_001);
        assert_eq!((at.ns, at.error_ns), (1_700_000_001_000_000_001, 30));
        assert_eq!(START.driver_at_system(at.ns).ns, 6_000_000_001);
        assert_eq!(START.system(4_000_000_000).ns, 1_699_999_999_000_000_000, "before the reading");
        assert_eq!(START.tai(5_000_000_000).unwrap().ns, 1_700_000_037_000_000_000);
        assert_eq!(Reading { tai_offset_s: None, ..START }.tai(5_000_000_000), None);
        assert_eq!(START.boottime(4_999_999_999).ns, 6_999_999_999);
    }

    #[test]
    fn a_step_a_slew_and_a_suspension_are_told_apart() {
        let nothing = START.change_to(&after(100));
        assert_eq!((nothing.step(), nothing.suspended_ns, nothing.slew_ppm), (None, 0, 0.0));
        let stepped = START.change_to(&Reading { system_ns: after(100).system_ns + 1_200_000_000, ..after(100) });
        assert_eq!(stepped.step(), Some(1_200_000_000));
        assert!(stepped.to_string().contains("set forward by 1.200 s"), "{stepped}");
        // both run at one rate: a slew is seen beside the raw counter alone, and never is a step
        let slewed = START.change_to(&Reading { raw_ns: after(100).raw_ns - 1_400_000, ..after(100) });
        assert!(slewed.step().is_none() && (slewed.slew_ppm - 14.0).abs() < 1e-9, "{slewed:?}");
        let slept = START.change_to(&Reading { boottime_ns: after(100).boottime_ns + 3_000_000_000, ..after(100) });
        assert_eq!((slept.step(), slept.suspended_ns), (None, 3_000_000_000));
        let within = START.change_to(&Reading { system_ns: after(100).system_ns + 55, ..after(100) });
        assert_eq!(within.step(), None, "what the readings are off by is no step");
    }

    #[test]
    fn a_history_knows_system_time_on_either_side_of_a_step() {
        let stepped = |seconds, raw_ns: i64| Reading {
            system_ns: after(seconds).system_ns + 1_200_000_000,
            raw_ns: after(seconds).raw_ns.saturating_add_signed(raw_ns),
            ..after(seconds)
        };
        let history = History::of(vec![stepped(34, -476_000), after(33), START, stepped(100, -1_400_000)]).unwrap();
        let at = |ns: u64| history.system(START.monotonic_ns + ns).map(|at| at.ns - START.system_ns);
        assert_eq!(at(10_000_000_000), Some(10_000_000_000));
        assert_eq!(at(33_500_000_000), None);
        assert_eq!(at(60_000_000_000), Some(61_200_000_000));
        assert_eq!(at(200_000_000_000), Some(201_200_000_000), "after the last one");
        let steps: Vec<Step> = history.steps().collect();
        assert_eq!((steps.len(), steps[0].by_ns), (1, 1_200_000_000));
        let said = history.said(START.monotonic_ns);
        let expected = "system time ± 30 ns (not synchronised); it ran 14.0 ± 0.0 ppm fast beside the machine's counter; \
                        set forward by 1.200 s at 34.0 s";
        assert_eq!(said, expected);
        assert!(History::of(Vec::new()).is_none());
    }
}
