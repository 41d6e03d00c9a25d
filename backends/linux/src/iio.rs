//! IIO by sysfs: enumerates the converters, the names of their inputs and their scales.
//!
//! Source: the kernel's `Documentation/ABI/testing/sysfs-bus-iio`. A voltage in mV (a current in mA) is
//! (`_raw` + `_offset`) · `_scale`; where there is no `_raw`, `_input` is that value itself. Scale and offset are an input's own
//! (`in_voltage0_scale`) or its type's (`in_voltage_scale`).

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::scan::Format;
use crate::sysfs;

/// From the milli-units of IIO to V and A.
const MILLI: f64 = 1e-3;

/// A device with analogue inputs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Device {
    /// `iio:device0`: its number depends on the order in which drivers were loaded.
    pub number: String,
    /// What its driver calls it, such as `ina219`; several may have the same.
    pub name: String,
    /// What the board calls it; mostly empty.
    pub label: String,
    /// Its parent, such as `1-0041`: the chip on its bus, stays the same.
    pub parent: String,
    /// Its inputs of voltage and current, such as `in_voltage0`.
    pub inputs: Vec<String>,
    /// Whether it can be read from a buffer.
    pub buffered: bool,
    pub(crate) path: PathBuf,
    pub(crate) node: PathBuf,
}

/// All devices with inputs under a root, in the order of their numbers.
pub fn devices(root: &Path) -> Vec<Device> {
    let bus = root.join("sys/bus/iio/devices");
    let numbers = sysfs::names(&bus).into_iter().filter(|name| name.starts_with("iio:device"));
    let device = |number: String| {
        let path = bus.join(&number);
        let real = fs::canonicalize(&path).ok()?;
        let parent = real.parent().and_then(|parent| parent.file_name()?.to_str()).unwrap_or_default().to_string();
        let text = |file: &str| sysfs::text(&path.join(file)).unwrap_or_default();
        let input = |file: &String| {
            let input = file.strip_suffix("_raw").or(file.strip_suffix("_input"))?;
            (input.starts_with("in_voltage") || input.starts_with("in_current")).then(|| input.to_string())
        };
        let mut inputs: Vec<String> = sysfs::names(&path).iter().filter_map(input).collect();
        inputs.dedup();
        let buffered = path.join("buffer/enable").exists();
        let node = root.join("dev").join(&number);
        Some(Device { name: text("name"), label: text("label"), number, parent, inputs, buffered, path, node })
    };
    numbers.filter_map(device).filter(|device| !device.inputs.is_empty()).collect()
}

/// The triggers that are there, by name.
pub fn triggers(root: &Path) -> Vec<String> {
    let bus = root.join("sys/bus/iio/devices");
    let numbers = sysfs::names(&bus).into_iter().filter(|name| name.starts_with("trigger"));
    numbers.filter_map(|number| sysfs::text(&bus.join(number).join("name")).ok()).collect()
}

/// Finds `device:input` among the devices: the index of the device and the input's name.
///
/// # Errors
/// In words, with what there is.
pub fn find(devices: &[Device], name: &str) -> Result<(usize, String), String> {
    let Some((wanted, input)) = name.rsplit_once(':') else {
        return Err("expected a device and its input, such as \"ina219:in_voltage1\"".into());
    };
    let bears =
        |device: &Device| [&device.number, &device.name, &device.label, &device.parent].contains(&&wanted.to_string());
    let bearing: Vec<usize> = (0..devices.len()).filter(|&index| bears(&devices[index])).collect();
    let listed = |which: &mut dyn Iterator<Item = &Device>| {
        let each = |d: &Device| format!("{} ({} at {}: {})", d.number, d.name, d.parent, d.inputs.join(", "));
        let all = which.map(each).collect::<Vec<_>>().join("; ");
        if all.is_empty() { "none".to_string() } else { all }
    };
    let index = match bearing[..] {
        [index] => index,
        [] => return Err(format!("there is no such converter; there is {}", listed(&mut devices.iter()))),
        _ => {
            let several = listed(&mut bearing.iter().map(|&index| &devices[index]));
            return Err(format!("several converters bear that name, tell them apart by number or parent: {several}"));
        }
    };
    let device = &devices[index];
    if device.inputs.iter().any(|there| there == input) {
        Ok((index, input.to_string()))
    } else {
        Err(format!("{} has no such input; it has {}", device.number, device.inputs.join(", ")))
    }
}

/// What a raw value means: value = `gain` · raw + `offset`, in V or A.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    pub gain: f64,
    pub offset: f64,
}

impl Device {
    /// Whether this user may set its buffer up and read it. A node opened by another process is not a missing permission.
    pub fn is_open(&self) -> bool {
        let node =
            fs::File::open(&self.node).map_or_else(|error| error.kind() != ErrorKind::PermissionDenied, |_| true);
        let enable = self.path.join("buffer/enable");
        node && fs::OpenOptions::new().write(true).open(enable).is_ok()
    }

    /// The scale of an input's raw values.
    pub(crate) fn scale(&self, input: &str) -> Result<Scale, Error> {
        let scale: f64 = self.of_input(input, "scale")?.unwrap_or(1.0);
        let offset: f64 = self.of_input(input, "offset")?.unwrap_or(0.0);
        Ok(Scale { gain: scale * MILLI, offset: offset * scale * MILLI })
    }

    /// An input's file to read one conversion from, and its scale.
    pub(crate) fn direct(&self, input: &str) -> Result<(PathBuf, Scale), Error> {
        let raw = self.path.join(format!("{input}_raw"));
        if raw.exists() {
            return Ok((raw, self.scale(input)?));
        }
        Ok((self.path.join(format!("{input}_input")), Scale { gain: MILLI, offset: 0.0 }))
    }

    /// A number of the input's own, or else of all inputs of its type.
    fn of_input(&self, input: &str, what: &str) -> Result<Option<f64>, Error> {
        let kind = input.trim_end_matches(|c: char| c.is_ascii_digit());
        for name in [input, kind] {
            let path = self.path.join(format!("{name}_{what}"));
            if path.exists() {
                return sysfs::number(&path).map(Some);
            }
        }
        Ok(None)
    }

    /// The buffer's elements: name without `_en`, index, format.
    pub(crate) fn elements(&self) -> Result<Vec<(String, u32, Format)>, Error> {
        let folder = self.path.join("scan_elements");
        let element = |file: String| {
            let name = file.strip_suffix("_en")?.to_string();
            Some(self.element(&folder, name))
        };
        sysfs::names(&folder).into_iter().filter_map(element).collect()
    }

    fn element(&self, folder: &Path, name: String) -> Result<(String, u32, Format), Error> {
        let index = sysfs::number(&folder.join(format!("{name}_index")))?;
        let path = [name.as_str(), name.trim_end_matches(|c: char| c.is_ascii_digit())]
            .map(|name| folder.join(format!("{name}_type")))
            .into_iter()
            .find(|path| path.exists())
            .unwrap_or_else(|| folder.join(format!("{name}_type")));
        let found = sysfs::text(&path)?;
        let expected = "[be|le]:[s|u]bits/storagebits>>shift";
        let format = Format::parse(&found).ok_or(Error::Content { path, found, expected })?;
        Ok((name, index, format))
    }
}
