//! Lines beside the PWM outputs: the one that switches the supply, and those of an emergency stop.
//!
//! A line is `chip/number` of a GPIO chip, or the path of a file of sysfs that holds its level (`/sys/class/gpio/gpio17/value`,
//! `/sys/class/leds/supply/brightness`). Source: the kernel's `Documentation/userspace-api/gpio/chardev.rst` (version 2 of
//! `/dev/gpiochipN`) and `Documentation/admin-guide/gpio/sysfs.rst`. A requested line belongs to whoever has the request open, here the
//! driver, and for the supply its guard too; when the last of them has closed it, the kernel frees the line, and its level from then on is
//! up to the chip's driver (most leave it as it is). So it is put off before, never by closing it.
//!
//! To set or to read is one ioctl, or one write or read of a file, without allocation and without a lock of our own.

use std::ffi::OsString;
use std::fmt;
use std::fs::{self, File};
use std::io;
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

use gpiocdev_uapi::v2::{self as uapi, LineConfig, LineFlags, LineRequest, LineValues, Offsets};
use rustix::io::Errno;

use crate::Error;
use crate::alone;
use crate::sysfs::{self, Attribute};

/// Who has our lines, as `gpioinfo` says it.
pub const CONSUMER: &str = "sinew";
/// How long a predecessor, or its guard, may take to release a line, and how often it is looked for.
const HANDOVER: Duration = Duration::from_secs(2);
const AGAIN: Duration = Duration::from_millis(10);

/// What a guard is told of the line: that there is none, or that its standard output is the request. Of a file it is told the level that is
/// off, the one that is on, and the path.
pub(crate) const NO_LINE: &str = "none";
const BY_STDOUT: &str = "request";

/// A GPIO chip.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chip {
    /// `gpiochip0`: its number depends on the order in which drivers were loaded.
    pub name: String,
    /// What its driver calls it, such as `pinctrl-bcm2711`; empty where this user may not open it.
    pub label: String,
    /// Name of its device, such as `1-0020`: stays the same.
    pub device: String,
    /// How many lines it has; `None` where this user may not open it.
    pub lines: Option<u32>,
    node: PathBuf,
}

/// All chips under a root, in the order of their numbers.
pub fn chips(root: &Path) -> Vec<Chip> {
    let nodes = root.join("dev");
    let chip = |name: String| {
        let node = nodes.join(&name);
        let info = File::open(&node).ok().and_then(|file| uapi::get_chip_info(&file).ok());
        let path = fs::canonicalize(root.join("sys/bus/gpio/devices").join(&name)).ok();
        let device = path.as_deref().and_then(Path::parent).and_then(|parent| parent.file_name()?.to_str());
        Chip {
            label: info.as_ref().map(|info| String::from(&info.label)).unwrap_or_default(),
            device: device.unwrap_or_default().into(),
            lines: info.map(|info| info.num_lines),
            name,
            node,
        }
    };
    let is_chip = |name: &String| name.strip_prefix("gpiochip").is_some_and(|number| number.parse::<u32>().is_ok());
    sysfs::names(&nodes).into_iter().filter(is_chip).map(chip).collect()
}

/// Where a line is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// A line of a chip.
    Chip(Chip, u32),
    /// A file that holds its level: `0` is low, anything else high.
    File(PathBuf),
}

/// Finds `chip/number` among the chips, or the file of a path, which is one below `root`.
///
/// # Errors
/// In words, with what there is.
pub fn find(root: &Path, chips: &[Chip], name: &str) -> Result<Place, String> {
    if let Some(below) = name.strip_prefix('/') {
        let path = root.join(below);
        return match path.is_file() {
            true => Ok(Place::File(path)),
            false => Err("there is no such file; a line of sysfs has to be exported before".into()),
        };
    }
    let Some((wanted, number)) = name.rsplit_once('/') else {
        return Err("expected a chip and the number of its line, such as \"gpiochip0/17\", or a file's path".into());
    };
    let bears = |chip: &&Chip| [&chip.name, &chip.label, &chip.device].into_iter().any(|name| name == wanted);
    let bearing: Vec<&Chip> = chips.iter().filter(bears).collect();
    let chip = match bearing[..] {
        [chip] => chip,
        [] => return Err(format!("there is no such GPIO chip; there is {}", listed(chips))),
        _ => return Err(format!("several GPIO chips bear that name, name one of them: {}", listed(chips))),
    };
    match number.parse() {
        Ok(number) if chip.lines.is_none_or(|lines| number < lines) => Ok(Place::Chip(chip.clone(), number)),
        _ => match chip.lines {
            Some(lines) => Err(format!("{} has lines 0 to {}", chip.name, i64::from(lines) - 1)),
            None => Err("expected the number of its line after the chip".into()),
        },
    }
}

fn listed(chips: &[Chip]) -> String {
    if chips.is_empty() { "none".into() } else { chips.iter().map(Chip::to_string).collect::<Vec<_>>().join(", ") }
}

impl fmt::Display for Chip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.lines {
            Some(lines) => write!(f, "{} ({}, device {}, {lines} lines)", self.name, self.label, self.device),
            None => write!(f, "{} (device {}, not open to this user)", self.name, self.device),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Chip(chip, number) => write!(f, "line {number} of {chip}"),
            Place::File(path) => path.display().fmt(f),
        }
    }
}

impl Place {
    /// Who besides this user may set the line, in words; `None` where nobody may.
    pub(crate) fn others(&self) -> Option<String> {
        match self {
            Place::Chip(chip, _) => alone::others(&chip.node),
            Place::File(path) => alone::others(path),
        }
    }

    /// Who has the line now, and `None` where it is free. Nothing is requested and nothing put out. A file does not tell.
    ///
    /// # Errors
    /// It is not there, or not open to this user: to be written where it is an `output`.
    pub fn user(&self, output: bool) -> Result<Option<String>, Error> {
        match self {
            Place::Chip(chip, number) => {
                let file = File::open(&chip.node).map_err(|error| Error::file(&chip.node, "open", error))?;
                let info = uapi::get_line_info(&file, *number);
                let info =
                    info.map_err(|error| Error::file(&chip.node, format!("look at line {number}"), errno(&error)))?;
                let consumer = String::from(&info.consumer);
                let named = if consumer.is_empty() { "a nameless program or driver".into() } else { consumer };
                Ok(info.flags.contains(LineFlags::USED).then_some(named))
            }
            Place::File(path) if output => Attribute::to_write(path.clone()).map(|_| None),
            Place::File(path) => Attribute::to_read(path.clone()).map(|_| None),
        }
    }
}

fn errno(error: &uapi::Error) -> Errno {
    match error {
        uapi::Error::Os(errno) => Errno::from_raw_os_error(errno.0),
        uapi::Error::UnderRead(_) => Errno::IO,
    }
}

/// Requests lines of one chip, active low where `inversed`.
fn request(chip: &Chip, numbers: &[u32], inversed: bool, flags: LineFlags) -> Result<File, Error> {
    let flags = if inversed { flags | LineFlags::ACTIVE_LOW } else { flags };
    let mut config = LineConfig { flags, ..LineConfig::default() };
    if flags.contains(LineFlags::OUTPUT) {
        // Inactive from the moment it is an output.
        config.add_values(&LineValues { bits: 0, mask: (1 << numbers.len()) - 1 });
    }
    let request = LineRequest {
        offsets: Offsets::from_slice(numbers),
        consumer: CONSUMER.into(),
        config,
        num_lines: numbers.len() as u32,
        ..LineRequest::default()
    };
    let file = File::open(&chip.node).map_err(|error| Error::file(&chip.node, "open", error))?;
    let since = Instant::now();
    loop {
        match uapi::get_line(&file, request.clone()).map_err(|error| errno(&error)) {
            Ok(file) => return Ok(file),
            Err(Errno::BUSY) if since.elapsed() < HANDOVER => thread::sleep(AGAIN),
            Err(errno) => {
                let which = numbers.iter().map(u32::to_string).collect::<Vec<_>>().join(" and ");
                return Err(Error::file(&chip.node, format!("request line {which}"), errno));
            }
        }
    }
}

/// A line that is put out.
#[derive(Debug)]
pub(crate) enum Output {
    /// A request of one line; the kernel knows which level is active.
    Line(File),
    /// A file, with the level that is off and the one that is on.
    File { attribute: Attribute, off: u64, on: u64 },
}

impl Output {
    /// Opens it. A line of a chip is requested, and off from here on; a file is not written to before [`Output::set_up`].
    pub fn open(place: &Place, inversed: bool) -> Result<Output, Error> {
        match place {
            Place::Chip(chip, number) => request(chip, &[*number], inversed, LineFlags::OUTPUT).map(Output::Line),
            Place::File(path) => {
                let attribute = Attribute::to_write(path.clone())?;
                // A light's full brightness may be more than 1, and some take anything less for a dimmed one.
                let high = sysfs::number(&path.with_file_name("max_brightness")).unwrap_or(1);
                let (off, on) = if inversed { (high, 0) } else { (0, high) };
                Ok(Output::File { attribute, off, on })
            }
        }
    }

    /// What a process that holds it too is told, and its standard output, by which it gets a request.
    pub fn hand_over(&self) -> Result<(Vec<OsString>, Stdio), io::Error> {
        match self {
            Output::Line(request) => Ok((vec![BY_STDOUT.into()], Stdio::from(request.try_clone()?))),
            Output::File { attribute, off, on } => {
                Ok((vec![off.to_string().into(), on.to_string().into(), attribute.path().into()], Stdio::null()))
            }
        }
    }

    /// The other end of [`Output::hand_over`]: takes what it is told of off the arguments. `None` where it is told of no line.
    pub fn take_over(arguments: &mut impl Iterator<Item = OsString>) -> Result<Option<Output>, String> {
        let word = arguments.next().unwrap_or_default();
        if word == NO_LINE {
            return Ok(None);
        }
        if word == BY_STDOUT {
            let request = io::stdout().as_fd().try_clone_to_owned();
            return request.map(|request| Some(Output::Line(request.into()))).map_err(|error| error.to_string());
        }
        let number = |word: Option<OsString>| word.and_then(|word| word.to_str()?.parse().ok());
        match (number(Some(word)), number(arguments.next()), arguments.next()) {
            (Some(off), Some(on), Some(path)) => {
                let attribute = Attribute::to_write(path.into()).map_err(|error| error.to_string())?;
                Ok(Some(Output::File { attribute, off, on }))
            }
            _ => Err("nothing is said of the enable line".into()),
        }
    }

    /// Makes an output of it, and puts it off.
    pub fn set_up(&self) -> Result<(), Error> {
        if let Output::File { attribute, off, .. } = self {
            let direction = attribute.path().with_file_name("direction");
            // Lines of sysfs only; made an output by "low" or "high" it has that level at once.
            if sysfs::text(&direction).is_ok_and(|direction| direction == "in") {
                sysfs::write(&direction, if *off == 0 { "low" } else { "high" })?;
            }
        }
        self.put(false).map_err(|errno| match self {
            Output::Line(_) => Error::file(Path::new("the enable line"), "put off", errno),
            Output::File { attribute, .. } => Error::file(attribute.path(), "put off", errno),
        })
    }

    /// Its file, where it is one.
    pub fn attribute(&self) -> Option<&Attribute> {
        match self {
            Output::Line(_) => None,
            Output::File { attribute, .. } => Some(attribute),
        }
    }

    /// Puts it on or off.
    #[inline]
    pub fn put(&self, on: bool) -> Result<(), Errno> {
        match self {
            Output::Line(request) => {
                let values = LineValues { bits: on.into(), mask: 1 };
                uapi::set_line_values(request, &values).map_err(|error| errno(&error))
            }
            Output::File { attribute, off, on: level } => attribute.write(if on { *level } else { *off }),
        }
    }
}

/// A line that is read, or two of one chip.
#[derive(Debug)]
enum Input {
    Lines(File, u64),
    File(Attribute, bool),
}

impl Input {
    fn open(place: &Place, inversed: bool, beside: Option<u32>) -> Result<Input, Error> {
        match place {
            Place::Chip(chip, number) => {
                // What is open, or a broken lead, is pulled to the level that is not active. Chips that cannot leave it out without a word.
                let pull = if inversed { LineFlags::BIAS_PULL_UP } else { LineFlags::BIAS_PULL_DOWN };
                let numbers: Vec<u32> = [*number].into_iter().chain(beside).collect();
                let file = request(chip, &numbers, inversed, LineFlags::INPUT | pull)?;
                Ok(Input::Lines(file, (1 << numbers.len()) - 1))
            }
            Place::File(path) => Ok(Input::File(Attribute::to_read(path.clone())?, inversed)),
        }
    }

    /// Which of its lines are active, the first in bit 0.
    #[inline]
    fn read(&self) -> Result<u64, Errno> {
        match self {
            Input::Lines(request, mask) => {
                let mut values = LineValues { bits: 0, mask: *mask };
                uapi::get_line_values(request, &mut values).map_err(|error| errno(&error))?;
                Ok(values.bits & mask)
            }
            Input::File(attribute, inversed) => Ok(u64::from((attribute.read()? != 0.0) != *inversed)),
        }
    }
}

/// The inputs of an emergency stop.
#[derive(Debug)]
pub(crate) struct Contact {
    contact: Input,
    /// Where it is not read together with the contact.
    reset: Option<Input>,
}

impl Contact {
    pub fn open(contact: &Place, reset: Option<&Place>, inversed: bool) -> Result<Contact, Error> {
        let beside = match (contact, reset) {
            (Place::Chip(chip, _), Some(Place::Chip(other, number))) if chip.name == other.name => Some(*number),
            _ => None,
        };
        let alone = reset.filter(|_| beside.is_none());
        Ok(Contact {
            contact: Input::open(contact, inversed, beside)?,
            reset: alone.map(|place| Input::open(place, inversed, None)).transpose()?,
        })
    }

    /// Whether the contact is closed, and whether the reset button is pressed.
    #[inline]
    pub fn read(&self) -> Result<(bool, bool), Errno> {
        let lines = self.contact.read()?;
        let pressed = match &self.reset {
            Some(reset) => reset.read()? & 1,
            None => lines >> 1,
        };
        Ok((lines & 1 != 0, pressed != 0))
    }
}
