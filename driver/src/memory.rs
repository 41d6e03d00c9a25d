//! What is known of the wires' heat, kept where it outlives the driver: a small record per physical output, whatever rig file and
//! channel it goes by.
//!
//! The loop writes it in every cycle, without a system call ([`sinew_page`]), so that it is as old as the driver's last cycle
//! however that one died. The next driver on the same output begins with it: what the wire had then, what its output can have given
//! it [in silence](sinew_backend::Backend::silence_s), and what it has lost since by its slowest law. A record that is damaged, from
//! before the machine started, held by another driver or of an end without a confirmed zero is none: the wire is at its limit.
//!
//! It lies in memory and not on a disk, so that it is gone with the machine, and what another user does with the same outputs it
//! does not know.

use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use sinew_backend::clock::boottime_ns;
use sinew_backend::{Backend, Zero};
use sinew_page::{Page, is_memory};

use crate::engine::Engine;
use crate::heat::Recalled;

/// Words of a record: which output, which start of the machine, when (ns on CLOCK_BOOTTIME), temperature at worst (°C), account (J),
/// the most its output gives (W), how its driver ended.
const WORDS: usize = 7;
/// Of the last word.
const RUNNING: u64 = 1;
const ENDED: u64 = 2;
const UNCONFIRMED: u64 = 3;

/// The records of a driver's outputs; none for those that nothing outlives, or that cannot be kept.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    pages: Vec<Option<Kept>>,
    boot: u64,
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
            Ok((pages, boot)) => Memory { pages, boot },
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

    /// Tells the engine what is remembered, right before the first cycle.
    pub fn recall(&self, engine: &mut Engine) {
        let now_ns = boottime_ns();
        for (channel, kept) in self.pages.iter().enumerate() {
            let recalled = kept.as_ref().and_then(|kept| kept.read(self.boot, now_ns));
            if let Some(recalled) = recalled {
                engine.recall(channel, &recalled);
            }
        }
    }

    /// Keeps what is believed after a cycle. No system call, no allocation.
    #[inline]
    pub fn keep(&mut self, engine: &Engine) {
        if !self.pages.is_empty() {
            self.write(engine, RUNNING);
        }
    }

    /// The driver has ended, with its outputs at zero or not.
    pub fn end(&mut self, engine: &Engine, zero: Zero) {
        self.write(engine, if zero == Zero::Confirmed { ENDED } else { UNCONFIRMED });
    }

    #[inline]
    fn write(&mut self, engine: &Engine, state: u64) {
        let now_ns = boottime_ns();
        for (kept, channel) in self.pages.iter_mut().zip(engine.channels()) {
            let Some(kept) = kept else { continue };
            let heat = channel.heat();
            let [temperature, account, most] =
                [heat.temperature_c(), heat.account_j(), channel.most_given_w()].map(f64::to_bits);
            kept.page.write(&[kept.output, self.boot, now_ns, temperature, account, most, state]);
        }
    }
}

impl Kept {
    /// What the record says, if it is one.
    fn read(&self, boot: u64, now_ns: u64) -> Option<Recalled> {
        let [output, found_boot, at_ns, temperature, account, most, state] = self.page.read()?;
        let is_valid = output == self.output && found_boot == boot && at_ns <= now_ns && state != UNCONFIRMED;
        let since_s = now_ns.saturating_sub(at_ns) as f64 * 1e-9;
        is_valid.then(|| Recalled {
            temperature_c: f64::from_bits(temperature),
            account_j: f64::from_bits(account),
            given_w: if state == ENDED { 0.0 } else { f64::from_bits(most) },
            since_s,
        })
    }
}

/// The folder of this user's records, closed to all others: in the runtime folder where that lies in memory, else in `/dev/shm`.
fn folder() -> io::Result<PathBuf> {
    let runtime = sinew_ipc::runtime_dir().map_err(io::Error::other)?;
    let path = if is_memory(&runtime) {
        runtime.join("heat")
    } else {
        let user = fs::metadata(&runtime)?.uid();
        let place = hash(runtime.as_os_str().as_encoded_bytes());
        PathBuf::from(format!("/dev/shm/sinew-heat-{user}-{place:016x}"))
    };
    sinew_ipc::own_folder(&path, 0o077).map_err(|reason| io::Error::other(format!("{}: {reason}", path.display())))?;
    Ok(path)
}

/// Which start of the machine this is.
fn boot() -> io::Result<u64> {
    Ok(hash(fs::read_to_string("/proc/sys/kernel/random/boot_id")?.trim().as_bytes()))
}

/// The same in every build and on every machine: FNV-1a.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}
