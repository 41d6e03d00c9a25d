//! PWM by sysfs: enumerates the chips and drives one output.
//!
//! Source: the kernel's `Documentation/ABI/testing/sysfs-class-pwm`, `drivers/pwm/sysfs.c` and `drivers/pwm/core.c`. A channel
//! is exported by writing its number; then, of `period`, `duty_cycle` (both ns), `enable` and `polarity`, each write is applied
//! as a whole state and refused with EINVAL where it has no period or more duty than period. So the duty goes to zero before the
//! period changes, and the output is enabled last.
//!
//! Off means a duty of zero with the output enabled: what the pin of a disabled output does is up to the chip.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use rustix::io::Errno;

use crate::Error;
use crate::alone;
use crate::sysfs::{self, Attribute};

/// How long udev may take to hand a fresh export over to its group.
const UDEV: Duration = Duration::from_secs(2);

/// A chip with PWM outputs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chip {
    /// `pwmchip0`: its number depends on the order in which drivers were loaded.
    pub name: String,
    /// Name of its device, such as `1-0040`: stays the same.
    pub device: String,
    /// How many outputs it has.
    pub outputs: u32,
    /// Those that are exported.
    pub exported: Vec<u32>,
    pub(crate) path: PathBuf,
}

/// All chips under a root, in the order of their numbers.
pub fn chips(root: &Path) -> Vec<Chip> {
    let class = root.join("sys/class/pwm");
    let chip = |name: String| {
        let path = class.join(&name);
        let device = fs::canonicalize(path.join("device")).ok();
        let device = device.and_then(|path| Some(path.file_name()?.to_str()?.to_string())).unwrap_or_default();
        let outputs = sysfs::number(&path.join("npwm")).ok()?;
        let number = |name: &String| name.strip_prefix("pwm")?.parse().ok();
        let exported = sysfs::names(&path).iter().filter_map(number).collect();
        Some(Chip { name, device, outputs, exported, path })
    };
    sysfs::names(&class).into_iter().filter_map(chip).collect()
}

impl Chip {
    /// Whether this user may export its outputs.
    pub fn is_open(&self) -> bool {
        fs::OpenOptions::new().write(true).open(self.path.join("export")).is_ok()
    }
}

/// Finds `chip/number` among the chips.
///
/// # Errors
/// In words, with what there is.
pub fn find(chips: &[Chip], name: &str) -> Result<(Chip, u32), String> {
    let Some((wanted, number)) = name.rsplit_once('/') else {
        return Err("expected a chip and the number of its output, such as \"pwmchip0/1\"".into());
    };
    let bearing: Vec<&Chip> = chips.iter().filter(|chip| chip.name == wanted || chip.device == wanted).collect();
    let chip = match bearing[..] {
        [chip] => chip,
        [] => return Err(format!("there is no such chip; there is {}", listed(chips))),
        _ => return Err(format!("several chips belong to that device, name one of them: {}", listed(chips))),
    };
    match number.parse() {
        Ok(number) if number < chip.outputs => Ok((chip.clone(), number)),
        _ => Err(format!("{} has outputs 0 to {}", chip.name, i64::from(chip.outputs) - 1)),
    }
}

fn listed(chips: &[Chip]) -> String {
    let each =
        |chip: &Chip| format!("{} (device {}, outputs 0 to {})", chip.name, chip.device, i64::from(chip.outputs) - 1);
    if chips.is_empty() { "none".into() } else { chips.iter().map(each).collect::<Vec<_>>().join(", ") }
}

/// Makes an output appear in sysfs and returns its folder. One that a dead driver left exported is taken over.
pub(crate) fn export(chip: &Chip, number: u32) -> Result<PathBuf, Error> {
    let folder = chip.path.join(format!("pwm{number}"));
    if !folder.is_dir() {
        let exported = sysfs::write(&chip.path.join("export"), &number.to_string());
        // Another process may have exported it already; then the folder exists.
        if let Err(error) = exported
            && !folder.is_dir()
        {
            return Err(error);
        }
    }
    // udev changes the group of the files a moment after they appear.
    let deadline = Instant::now() + UDEV;
    loop {
        match Attribute::to_write(folder.join("duty_cycle")) {
            Ok(_) => return Ok(folder),
            Err(error) if Instant::now() > deadline => return Err(error),
            Err(_) => thread::sleep(Duration::from_millis(10)),
        }
    }
}

/// What an output shows as it stands: period, polarity, and whether it is enabled, mixed into one number. Whoever drives it sets them, so that
/// one who sets them otherwise is noticed. `None` where it is not exported, or not at zero.
pub(crate) fn mark(chip: &Chip, number: u32) -> Option<u64> {
    let folder = chip.path.join(format!("pwm{number}"));
    let whole = |name: &str| sysfs::number::<u64>(&folder.join(name)).ok();
    if whole("duty_cycle")? != 0 {
        return None;
    }
    let inversed = sysfs::text(&folder.join("polarity")).is_ok_and(|polarity| polarity == "inversed");
    let all = [whole("period")?, whole("enable")?, u64::from(inversed)];
    Some(
        all.into_iter().fold(0x9e37_79b9_7f4a_7c15, |mark: u64, one| (mark ^ one).wrapping_mul(0x0000_0100_0000_01b3))
            | 1,
    )
}

/// Who besides this user may drive an output, in words; `None` where nobody may.
pub(crate) fn others(chip: &Chip, number: u32) -> Option<String> {
    let folder = chip.path.join(format!("pwm{number}"));
    ["duty_cycle", "period", "enable"].into_iter().find_map(|name| alone::others(&folder.join(name)))
}

/// Whether it is exported.
pub(crate) fn is_exported(chip: &Chip, number: u32) -> bool {
    chip.path.join(format!("pwm{number}")).is_dir()
}

/// An exported output, at zero until it is given a duty.
#[derive(Debug)]
pub(crate) struct Output {
    duty: Attribute,
    period_ns: u64,
    /// What was last written, ns; `None` = not known.
    on_ns: Option<u64>,
}

impl Output {
    /// Sets an output up: zero, polarity, period, enabled.
    pub fn set_up(folder: &Path, period_ns: u64, inversed: bool) -> Result<Output, Error> {
        let duty = Attribute::to_write(folder.join("duty_cycle"))?;
        let period = Attribute::to_write(folder.join("period"))?;
        let enable = Attribute::to_write(folder.join("enable"))?;
        let set = |attribute: &Attribute, value| {
            attribute.write(value).map_err(|errno| Error::file(attribute.path(), format!("write {value}"), errno))
        };
        let before: u64 = sysfs::number(period.path())?;
        if before > 0 {
            set(&duty, 0)?;
        }
        let polarity = folder.join("polarity");
        let wanted = if inversed { "inversed" } else { "normal" };
        // Chips that know one polarity only have no such file, or refuse to write to it: read first.
        if sysfs::text(&polarity).map_or(inversed, |found| found != wanted) {
            // It can only be changed with a period, and on many chips only while disabled.
            set(&enable, 0)?;
            set(&period, period_ns)?;
            sysfs::write(&polarity, wanted)?;
        }
        if before != period_ns {
            set(&period, period_ns)?;
        }
        set(&duty, 0)?;
        set(&enable, 1)?;
        // What the chip made of it: some round to their clock.
        let period_ns = sysfs::number::<u64>(period.path())?.max(1);
        Ok(Output { duty, period_ns, on_ns: Some(0) })
    }

    /// Puts a duty out, 0 ..= 1; nothing is written where it is what the chip has already.
    #[inline]
    pub fn put(&mut self, duty: f64) -> Result<(), Errno> {
        let on_ns = ((duty * self.period_ns as f64).round() as u64).min(self.period_ns);
        if self.on_ns == Some(on_ns) {
            return Ok(());
        }
        self.on_ns = None;
        self.duty.write(on_ns)?;
        self.on_ns = Some(on_ns);
        Ok(())
    }

    /// Another process wrote to it: the next duty is written whatever it is.
    pub fn forget(&mut self) {
        self.on_ns = None;
    }
}
