//! The time of day by the calendar, for names of files and for people.

use std::fmt;

/// A moment by the calendar, in UTC.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Utc {
    year: u64,
    month: u64,
    day: u64,
    hour: u64,
    minute: u64,
    second: u64,
    millisecond: u64,
}

impl Utc {
    /// Of a moment in ns since 1970.
    pub fn of_unix_ns(unix_ns: u64) -> Utc {
        let seconds = unix_ns / 1_000_000_000;
        let (days, of_day) = (seconds / 86_400, seconds % 86_400);
        // civil from days, after Howard Hinnant: years begin in March, so that the leap day is the last one
        let shifted = days + 719_468;
        let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
        let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
        let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
        let shifted_month = (5 * day_of_year + 2) / 153;
        let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
        Utc {
            year: era * 400 + year_of_era + u64::from(month <= 2),
            month,
            day: day_of_year - (153 * shifted_month + 2) / 5 + 1,
            hour: of_day / 3600,
            minute: of_day / 60 % 60,
            second: of_day % 60,
            millisecond: unix_ns / 1_000_000 % 1000,
        }
    }

    /// Now.
    pub fn now() -> Utc {
        let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
        Utc::of_unix_ns(since.as_nanos() as u64)
    }

    /// For a file's name: `20260801-153012`.
    pub fn stamp(&self) -> String {
        let Utc { year, month, day, hour, minute, second, .. } = self;
        format!("{year:04}{month:02}{day:02}-{hour:02}{minute:02}{second:02}")
    }

    /// For the name of a file of which there may be several a second: `20260801T153012.345Z`. In the order of time when sorted.
    pub fn fine_stamp(&self) -> String {
        let Utc { year, month, day, hour, minute, second, millisecond } = self;
        format!("{year:04}{month:02}{day:02}T{hour:02}{minute:02}{second:02}.{millisecond:03}Z")
    }
}

impl fmt::Display for Utc {
    /// As people write it: `2026-11-22 05:10:20 UTC`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Utc { year, month, day, hour, minute, second, .. } = self;
        write!(f, "{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02} UTC")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_calendar() {
        let at = |seconds: u64| Utc::of_unix_ns(seconds * 1_000_000_000).to_string();
        assert_eq!(at(0), "1970-01-01 00:00:00 UTC");
        assert_eq!(at(951_782_399), "2000-02-28 23:59:59 UTC");
        assert_eq!(at(951_782_400), "2000-02-29 00:00:00 UTC");
        assert_eq!(at(1_700_000_000), "2023-11-14 22:13:20 UTC");
        assert_eq!(at(1_704_067_199), "2023-12-31 23:59:59 UTC");
        assert_eq!(at(4_107_542_400), "2100-03-01 00:00:00 UTC");
        let moment = Utc::of_unix_ns(1_785_598_212_345_678_901);
        assert_eq!((moment.stamp(), moment.fine_stamp()), ("20260801-153012".into(), "20260801T153012.345Z".into()));
    }
}
