//! What is known of the wires' heat, kept where it outlives the driver: a small record per physical output, whatever rig file and
//! channel it goes by.
//!
//! The loop writes it in every cycle, without a system call ([`sinew_page`]), so that it is as old as the driver's last cycle
//! however that one died. The next driver on the same output begins with it: what the wire had then, what its output can have given
//! it [in silence](sinew_backend::Backend::silence_s), and what it has lost since by its slowest law. A record that is damaged, of another
//! start of the machine, held by another driver or of an end without a confirmed zero is none.
//!
//! A record is this user's, and says nothing of what others do with the output. So it carries a mark that the output itself shows as long as nobody
//! else has used it ([`Backend::past`]): where it shows another one, or none, the record is none either.
//!
//! Without a record the wire is at its limit; but where the hardware vouches for how long nothing was put out, it was so then, and has
//! cooled since. It lies in memory and not on a disk: what was before the machine started is gone, and only the time since then counts.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use sinew_backend::clock::boottime_ns;
use sinew_backend::{Backend, Past, Unused, Zero};
use sinew_page::Page;

use crate::engine::Engine;
use crate::heat::Recalled;

/// Words of a record: which output, which start of the machine, when (ns on CLOCK_BOOTTIME), temperature at worst and at the least (°C),
/// account (J), the most its output gives (W), how its driver ended, what the output shows as long as nobody else uses it.
const WORDS: usize = 9;
/// How its driver ended: its outputs went to zero, by itself or by its silence.
const WENT_OUT: u64 = 1;
/// Not every output confirmed zero.
const UNCONFIRMED: u64 = 3;

/// The records of a driver's outputs; none for those that nothing outlives, or that cannot be kept.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    pages: Vec<Option<Kept>>,
    boot: u64,
    /// When the last cycle was kept, or what was known before the first one, ns on CLOCK_BOOTTIME.
    kept_ns: u64,
}

#[derive(Debug)]
struct Kept {
    page: Page<WORDS>,
    output: u64,
}

impl Memory {
    /// Opens the records of a backend's outputs. What cannot be kept is a warning: it costs time at the next start.
    pub fn of(backend: &impl Backend, channels: usize) -> Memory {
        let names: Vec<Option<String>> = (0..channels).map(|channel| backend.output_name(channel)).collect();
        if names.iter().all(Option::is_none) {
            return Memory::default();
        }
        match folder().and_then(|folder| Ok((Memory::open(&folder, &names), boot()?))) {
            Ok((pages, boot)) => Memory { pages, boot, kept_ns: 0 },
            Err(error) => {
                tracing::warn!(
                    "how hot the wires are cannot be remembered beyond this run ({error}); the next one takes them to be at their limit"
                );
                Memory::default()
            }
        }
    }

    fn open(folder: &Path, names: &[Option<String>]) -> Vec<Option<Kept>> {
        let open = |name: &String| {
            let output = hash(name.as_bytes());
            let path = folder.join(format!("{output:016x}"));
            let page = Page::open(&path).inspect_err(|error| {
                tracing::warn!("what {name} gives its wire cannot be remembered: {}: {error}", path.display());
            });
            Some(Kept { page: page.ok()?, output })
        };
        names.iter().map(|name| name.as_ref().and_then(open)).collect()
    }

    /// Tells the engine what is remembered, or else known of the outputs, right before the first cycle.
    pub fn recall(&mut self, engine: &mut Engine, backend: &impl Backend) {
        let now_ns = boottime_ns();
        self.kept_ns = now_ns;
        for channel in 0..engine.channels().len() {
            let kept = self.pages.get(channel).and_then(Option::as_ref);
            match Known::of(kept, &backend.past(channel), self.boot, now_ns) {
                Known::Recalled(recalled) => engine.recall(channel, &recalled),
                Known::Unused(since_s) => engine.was_unused(channel, since_s),
                Known::Nothing => {}
            }
        }
    }

    /// Keeps what is believed after a cycle. No system call, no allocation.
    #[inline]
    pub fn keep(&mut self, engine: &Engine, backend: &impl Backend) {
        if !self.pages.is_empty() {
            self.kept_ns = boottime_ns();
            self.write(engine, backend, WENT_OUT);
        }
    }

    /// The driver has ended, with its outputs at zero or not. What is kept is as old as its last cycle: it may have been away since, its
    /// outputs as they were.
    pub fn end(&mut self, engine: &Engine, backend: &impl Backend, zero: Zero) {
        self.write(engine, backend, if zero == Zero::Confirmed { WENT_OUT } else { UNCONFIRMED });
    }

    #[inline]
    fn write(&mut self, engine: &Engine, backend: &impl Backend, state: u64) {
        for (index, (kept, channel)) in self.pages.iter_mut().zip(engine.channels()).enumerate() {
            let Some(kept) = kept else { continue };
            let Recalled { temperature_c, surely_c, account_j, given_w, .. } = channel.to_recall();
            let [temperature, least, account, most] = [temperature_c, surely_c, account_j, given_w].map(f64::to_bits);
            let mark = backend.mark(index);
            kept.page.write(&[kept.output, self.boot, self.kept_ns, temperature, least, account, most, state, mark]);
        }
    }
}

/// What there is to go by at a start.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Known {
    Recalled(Recalled),
    /// Nothing was put out for so long, s.
    Unused(f64),
    Nothing,
}

impl Known {
    fn of(kept: Option<&Kept>, past: &Past, boot: u64, now_ns: u64) -> Known {
        if let Some(recalled) = kept.and_then(|kept| kept.read(past.mark, boot, now_ns)) {
            return Known::Recalled(recalled);
        }
        match past.unused {
            Unused::For(seconds) => Known::Unused(seconds),
            // Whoever of this user's has used it since would have left a record, whatever has become of that.
            Unused::SinceStartOfMachine(after_s) if kept.is_some_and(|kept| kept.page.is_new()) => {
                Known::Unused((now_ns as f64 * 1e-9 - after_s).max(0.0))
            }
            Unused::SinceStartOfMachine(_) | Unused::Unknown => Known::Nothing,
        }
    }
}

impl Kept {
    /// What the record says, if it is one, and nobody else has used the output since.
    fn read(&self, shown: u64, boot: u64, now_ns: u64) -> Option<Recalled> {
        let [output, found_boot, at_ns, temperature, least, account, most, state, mark] = self.page.read()?;
        let is_ours = mark == shown && mark != 0;
        let account_j = f64::from_bits(account);
        let is_of_now = output == self.output && found_boot == boot && at_ns <= now_ns;
        let is_valid = is_ours && is_of_now && state != UNCONFIRMED && account_j.is_finite();
        let since_s = now_ns.saturating_sub(at_ns) as f64 * 1e-9;
        is_valid.then(|| Recalled {
            temperature_c: f64::from_bits(temperature),
            surely_c: f64::from_bits(least),
            account_j,
            given_w: f64::from_bits(most),
            since_s,
        })
    }
}

/// The folder of this user's records, closed to all others. One for all his drivers, whatever their runtime folders: they may use the same
/// outputs.
fn folder() -> io::Result<PathBuf> {
    sinew_ipc::own_folder_among(Path::new("/dev/shm"), "sinew-heat", 0o077).map_err(io::Error::other)
}

/// Which start of the machine this is.
fn boot() -> io::Result<u64> {
    Ok(hash(fs::read_to_string("/proc/sys/kernel/random/boot_id")?.trim().as_bytes()))
}

/// The same in every build and on every machine: FNV-1a.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use sinew_backend::{BackendError, Sample};
    use sinew_rig::Rig;

    use super::*;

    struct Mute;

    impl Backend for Mute {
        fn channels(&self) -> usize {
            1
        }
        fn start(&mut self) -> Result<(), BackendError> {
            Ok(())
        }
        fn exchange(&mut self, _: &[f64], _: &mut [Sample]) -> Result<(), BackendError> {
            Ok(())
        }
        fn silence_s(&self) -> Option<f64> {
            Some(0.1)
        }
        fn stop(&mut self) -> Zero {
            Zero::Confirmed
        }
    }

    const BOOT: u64 = 7;
    const SECOND_NS: u64 = 1_000_000_000;
    const SHOWN: Past = Past { mark: 5, unused: Unused::Unknown };

    fn kept(folder: &Path, name: &str) -> Kept {
        Kept { page: Page::open(&folder.join(name)).unwrap(), output: 1 }
    }

    /// A record of 60 to 80 °C and 0.5 J, with 2 W, ten seconds after the machine's start.
    fn written(kept: &mut Kept, state: u64, mark: u64) {
        let [temperature, least, account, most] = [80.0f64, 60.0, 0.5, 2.0].map(f64::to_bits);
        kept.page.write(&[1, BOOT, 10 * SECOND_NS, temperature, least, account, most, state, mark]);
    }

    #[test]
    fn a_record_is_believed_as_long_as_nobody_else_has_used_its_output() {
        let folder = tempfile::tempdir_in("/dev/shm").unwrap();
        let mut kept = kept(folder.path(), "output");
        let of = |kept: &Kept, past: Past, boot: u64, now_s: u64| Known::of(Some(kept), &past, boot, now_s * SECOND_NS);
        assert_eq!(of(&kept, SHOWN, BOOT, 20), Known::Nothing, "nothing was written");
        written(&mut kept, WENT_OUT, 5);
        let recalled = Recalled { temperature_c: 80.0, surely_c: 60.0, account_j: 0.5, given_w: 2.0, since_s: 10.0 };
        assert_eq!(of(&kept, SHOWN, BOOT, 20), Known::Recalled(recalled));
        assert_eq!(of(&kept, Past { mark: 6, ..SHOWN }, BOOT, 20), Known::Nothing, "another session");
        assert_eq!(of(&kept, Past::UNKNOWN, BOOT, 20), Known::Nothing, "an output that does not tell");
        assert_eq!(of(&kept, SHOWN, BOOT + 1, 20), Known::Nothing, "another start of the machine");
        assert_eq!(of(&kept, SHOWN, BOOT, 5), Known::Nothing, "of the future");
        written(&mut kept, UNCONFIRMED, 5);
        assert_eq!(of(&kept, SHOWN, BOOT, 20), Known::Nothing, "nobody knows whether it is off");
        written(&mut kept, WENT_OUT, 0);
        assert_eq!(of(&kept, Past::UNKNOWN, BOOT, 20), Known::Nothing, "two that do not tell are not the same");
        // Whoever used it, the hardware says for how long nobody has.
        let unused = Past { mark: 6, unused: Unused::For(3.0) };
        assert_eq!(of(&kept, unused, BOOT, 20), Known::Unused(3.0));
        assert_eq!(Known::of(None, &unused, BOOT, 20 * SECOND_NS), Known::Unused(3.0));
    }

    #[test]
    fn an_end_in_order_is_remembered_as_of_the_last_cycle() {
        let folder = tempfile::tempdir_in("/dev/shm").unwrap();
        let engine = Engine::new(&Rig::hexapod(), None).unwrap();
        let mut memory = Memory { pages: vec![Some(kept(folder.path(), "output"))], boot: BOOT, kept_ns: 0 };
        memory.keep(&engine, &Mute);
        let last_ns = memory.kept_ns;
        std::thread::sleep(Duration::from_millis(20));
        memory.end(&engine, &Mute, Zero::Confirmed);
        let [_, _, at_ns, .., state, _] = memory.pages[0].as_ref().unwrap().page.read().unwrap();
        assert_eq!(
            (at_ns, state),
            (last_ns, WENT_OUT),
            "a driver that is away before it ends heats as one that is killed"
        );
        memory.end(&engine, &Mute, Zero::Unconfirmed);
        let [.., state, _] = memory.pages[0].as_ref().unwrap().page.read().unwrap();
        assert_eq!(state, UNCONFIRMED);
    }

    #[test]
    fn across_a_start_of_the_machine_only_the_time_since_then_counts_and_only_without_a_record() {
        let folder = tempfile::tempdir_in("/dev/shm").unwrap();
        let since = Past { mark: 0, unused: Unused::SinceStartOfMachine(2.0) };
        let mut kept = kept(folder.path(), "output");
        let Known::Unused(since_s) = Known::of(Some(&kept), &since, BOOT, 30 * SECOND_NS) else {
            panic!("a new record")
        };
        assert!((since_s - 28.0).abs() < 1e-9, "{since_s}");
        assert_eq!(Known::of(Some(&kept), &since, BOOT, SECOND_NS), Known::Unused(0.0));
        assert_eq!(Known::of(None, &since, BOOT, 30 * SECOND_NS), Known::Nothing, "a record that could not be opened");
        written(&mut kept, WENT_OUT, 5);
        drop(kept);
        let kept = self::kept(folder.path(), "output");
        assert_eq!(Known::of(Some(&kept), &since, BOOT, 30 * SECOND_NS), Known::Nothing, "it was used");
    }
}
