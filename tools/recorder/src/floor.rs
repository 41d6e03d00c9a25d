//! The floor of free disk space: how much room there is, a warning before it is too little, and the end when it is.
//!
//! A disk that is full stops whatever else writes to it, so a recording ends before that. It looks after each chunk, which is after
//! 4 MiB or a second.

use std::collections::VecDeque;
use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::fs::statvfs;
use rustix::io::Errno;

use crate::error::Error;
use crate::files;
use crate::warning::Warning;

/// Over so long the present rate is taken, and so long it takes to know one.
const RATE: Duration = Duration::from_secs(60);
const RATE_KNOWN: Duration = Duration::from_secs(5);
/// How often the free space is kept for the rate.
const STEP: Duration = Duration::from_secs(1);

/// Bytes free where a file is: [`free_bytes`], except in tests.
pub(crate) type Free<'a> = dyn Fn(&Path) -> io::Result<u64> + 'a;

/// Watches the free space of a recording's disk.
pub(crate) struct Floor<'a> {
    bytes: u64,
    free: &'a Free<'a>,
    /// What was free when, oldest first.
    history: VecDeque<(Instant, u64)>,
    warned: bool,
}

impl<'a> Floor<'a> {
    /// So many bytes stay free; 0 = none need to.
    pub(crate) fn new(bytes: u64, free: &'a Free<'a>) -> Floor<'a> {
        Floor { bytes, free, history: VecDeque::new(), warned: false }
    }

    /// Looks how much is free where this file is or is to be. A warning comes once, below twice the floor.
    ///
    /// # Errors
    /// [`Error::Floor`] when it is less than the floor.
    pub(crate) fn look(&mut self, path: &Path, now: Instant) -> Result<Option<Warning>, Error> {
        if self.bytes == 0 {
            return Ok(None);
        }
        let free = match (self.free)(path) {
            Ok(free) => free,
            // Better no floor than no recording; what cannot be known once is not asked for again.
            Err(reason) => {
                let floor = std::mem::take(&mut self.bytes);
                return Ok(Some(Warning::SpaceUnknown { path: path.into(), reason, floor }));
            }
        };
        if free < self.bytes {
            return Err(Error::Floor { path: path.into(), free, floor: self.bytes });
        }
        self.remember(free, now);
        // Who begins with little is told once there is a rate, or earlier when half of the way is gone.
        let left = free - self.bytes;
        let since = self.history.front().map_or(Duration::ZERO, |(then, _)| now.duration_since(*then));
        if self.warned || left >= self.bytes || (since < RATE_KNOWN && left >= self.bytes / 2) {
            return Ok(None);
        }
        self.warned = true;
        Ok(Some(Warning::LowSpace { path: path.into(), free, floor: self.bytes, lasts_s: self.lasts_s(left, now) }))
    }

    fn remember(&mut self, free: u64, now: Instant) {
        if self.history.back().is_none_or(|(then, _)| now.duration_since(*then) >= STEP) {
            self.history.push_back((now, free));
        }
        while self.history.len() > 1 && self.history.front().is_some_and(|(then, _)| now.duration_since(*then) > RATE) {
            self.history.pop_front();
        }
    }

    /// When the bytes above the floor are used up, s, at the rate at which they have become less, by whoever writes there; `None` where
    /// they do not, or it is not known yet.
    fn lasts_s(&self, left: u64, now: Instant) -> Option<f64> {
        let (then, before) = *self.history.front()?;
        let seconds = now.duration_since(then).as_secs_f64();
        let fallen = before.saturating_sub(self.bytes + left);
        (seconds >= RATE_KNOWN.as_secs_f64() && fallen > 0).then(|| left as f64 * seconds / fallen as f64)
    }
}

/// Bytes an ordinary user may still write to the disk where this file is, or is to be. Quotas are not in it.
///
/// # Errors
/// The system's; also where the file system does not say.
pub(crate) fn free_bytes(path: &Path) -> io::Result<u64> {
    let found = match statvfs(path) {
        Err(Errno::NOENT) => statvfs(files::folder(path)),
        found => found,
    }?;
    match found.f_blocks {
        // a file system without a size: many of those in user space
        0 => Err(io::Error::other("the file system does not say")),
        _ => Ok(found.f_bavail.saturating_mul(found.f_frsize)),
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    const MB: u64 = 1_000_000;

    #[test]
    fn it_warns_once_below_twice_the_floor_and_ends_below_it() {
        let free = Cell::new(1000 * MB);
        let reading = |_: &Path| Ok(free.get());
        let mut floor = Floor::new(100 * MB, &reading);
        let started = Instant::now();
        let mut warnings = Vec::new();
        // 5 MB a second
        for second in 0..=180 {
            free.set((1000 - 5 * second) * MB);
            let found = floor.look(Path::new("a.mcap"), started + Duration::from_secs(second)).unwrap();
            warnings.extend(found.map(|warning| (second, warning)));
        }
        let [(second, Warning::LowSpace { free: found, floor: 100_000_000, lasts_s: Some(lasts_s), .. })] =
            &warnings[..]
        else {
            panic!("{warnings:?}")
        };
        assert_eq!((*second, *found), (161, 195 * MB));
        assert!((lasts_s - 19.0).abs() < 1e-6, "{lasts_s}");
        // exactly the floor is still enough
        assert_eq!(free.get(), 100 * MB);
        free.set(100 * MB - 1);
        let error = floor.look(Path::new("a.mcap"), started + Duration::from_secs(181)).unwrap_err();
        assert!(matches!(error, Error::Floor { free: 99_999_999, floor: 100_000_000, .. }), "{error}");
    }

    #[test]
    fn who_begins_with_little_is_told_the_time_left_as_soon_as_it_is_known() {
        let free = Cell::new(190 * MB);
        let reading = |_: &Path| Ok(free.get());
        let started = Instant::now();
        let at = |floor: &mut Floor, second, mb| {
            free.set(mb * MB);
            floor.look(Path::new("a.mcap"), started + Duration::from_secs(second)).unwrap()
        };
        let mut floor = Floor::new(100 * MB, &reading);
        assert!(at(&mut floor, 0, 190).is_none() && at(&mut floor, 4, 182).is_none());
        let warning = at(&mut floor, 5, 180);
        assert!(matches!(warning, Some(Warning::LowSpace { lasts_s: Some(40.0), .. })), "{warning:?}");
        // falls too fast for that
        let mut floor = Floor::new(100 * MB, &reading);
        assert!(at(&mut floor, 0, 190).is_none());
        let warning = at(&mut floor, 1, 149);
        assert!(matches!(warning, Some(Warning::LowSpace { lasts_s: None, .. })), "{warning:?}");
        // does not fall at all
        let mut floor = Floor::new(100 * MB, &reading);
        assert!(at(&mut floor, 0, 190).is_none());
        let warning = at(&mut floor, 5, 190);
        assert!(matches!(warning, Some(Warning::LowSpace { lasts_s: None, .. })), "{warning:?}");
    }

    #[test]
    fn a_file_system_that_does_not_say_is_recorded_to_with_one_warning() {
        let reading = |_: &Path| Err(io::Error::other("it does not say"));
        let mut floor = Floor::new(MB, &reading);
        let found = floor.look(Path::new("a.mcap"), Instant::now()).unwrap();
        assert!(matches!(found, Some(Warning::SpaceUnknown { floor: MB, .. })), "{found:?}");
        assert!(floor.look(Path::new("a.mcap"), Instant::now()).unwrap().is_none());
    }

    #[test]
    fn without_a_floor_nobody_looks() {
        let reading = |_: &Path| panic!("asked");
        assert!(Floor::new(0, &reading).look(Path::new("a.mcap"), Instant::now()).unwrap().is_none());
    }

    #[test]
    fn free_space_is_known_for_a_file_that_is_not_there_yet() {
        let folder = tempfile::tempdir().unwrap();
        assert!(free_bytes(&folder.path().join("a.mcap")).unwrap() > 0);
        assert!(free_bytes(Path::new("a-file-that-is-not-there.mcap")).is_ok());
        assert!(free_bytes(&folder.path().join("no/such/a.mcap")).is_err());
    }
}
