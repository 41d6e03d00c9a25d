//! A converter that behaves like `drivers/iio/industrialio-buffer.c` and its kfifo.

use std::collections::VecDeque;

use fuser::Errno;

/// How an element is stored, and what the kernel says of it.
#[derive(Debug, Clone)]
pub struct Input {
    /// `in_voltage0`.
    pub name: String,
    /// Its place in the scan.
    pub index: u32,
    /// Bits of its value and of its storage, and its shift.
    pub bits: (u32, u32, u32),
    /// Two's complement.
    pub signed: bool,
    /// Most significant byte first.
    pub big_endian: bool,
    /// mV or mA a step.
    pub scale: f64,
    /// Steps to be added before.
    pub offset: i64,
    /// Whether it is enabled for the buffer.
    pub enabled: bool,
    /// The last conversion, in steps.
    pub raw: i64,
}

impl Input {
    /// `_type`.
    pub fn kind(&self) -> String {
        let (endian, sign) = (if self.big_endian { "be" } else { "le" }, if self.signed { 's' } else { 'u' });
        let (bits, storage, shift) = self.bits;
        format!("{endian}:{sign}{bits}/{storage}>>{shift}")
    }

    /// What it converts a value (V or A) to; NaN is no signal.
    pub fn convert(&self, value: f64) -> i64 {
        let value = if value.is_finite() { value } else { 0.0 };
        let steps = (value * 1e3 / self.scale).round() as i64 - self.offset;
        let bits = self.bits.0;
        if self.signed {
            steps.clamp(-(1 << (bits - 1)), (1 << (bits - 1)) - 1)
        } else {
            steps.clamp(0, (1 << bits) - 1)
        }
    }

    fn bytes(&self) -> usize {
        (self.bits.1 / 8) as usize
    }

    fn store(&self, scan: &mut Vec<u8>) {
        scan.resize(scan.len().next_multiple_of(self.bytes()), 0);
        let word = (self.raw.cast_unsigned() << (64 - self.bits.0) >> (64 - self.bits.0)) << self.bits.2;
        if self.big_endian {
            scan.extend_from_slice(&word.to_be_bytes()[8 - self.bytes()..]);
        } else {
            scan.extend_from_slice(&word.to_le_bytes()[..self.bytes()]);
        }
    }
}

/// A device with a buffer.
#[derive(Debug, Clone)]
pub struct Converter {
    /// What its driver calls it.
    pub name: String,
    /// The chip on its bus.
    pub parent: String,
    /// Its inputs.
    pub inputs: Vec<Input>,
    /// Whether scans carry the time.
    pub timestamp: bool,
    /// Scans that may wait.
    pub length: usize,
    /// Scans a blocking reader waits for.
    pub watermark: usize,
    /// Whether the buffer runs.
    pub enabled: bool,
    /// The trigger it is set to; `None` in a device that needs none.
    pub trigger: Option<String>,
    /// Whether a process has its node open.
    pub open: bool,
    /// Whether it is no longer there.
    pub gone: bool,
    /// Whether its bus fails: EIO for every conversion.
    pub broken: bool,
    /// Scans that found no room.
    pub dropped: u64,
    waiting: VecDeque<Vec<u8>>,
}

impl Converter {
    /// A device at rest.
    pub fn new(name: &str, parent: &str, inputs: Vec<Input>, trigger: bool) -> Converter {
        Converter {
            name: name.into(),
            parent: parent.into(),
            inputs,
            timestamp: false,
            length: 2,
            watermark: 1,
            enabled: false,
            trigger: trigger.then(String::new),
            open: false,
            gone: false,
            broken: false,
            dropped: 0,
            waiting: VecDeque::new(),
        }
    }

    /// As it is when its driver has just found it.
    pub fn reset(&mut self) {
        let (inputs, trigger) = (std::mem::take(&mut self.inputs), self.trigger.is_some());
        let inputs = inputs.into_iter().map(|input| Input { enabled: false, ..input }).collect();
        *self = Converter::new(&self.name, &self.parent, inputs, trigger);
    }

    /// A scan is complete: it waits for a reader, or is dropped where there is no room. The newest is dropped, as the kernel does.
    pub fn push(&mut self, time_ns: i64) {
        if !self.enabled {
            return;
        }
        // a kfifo holds a power of two
        if self.waiting.len() >= self.length.next_power_of_two() {
            self.dropped += 1;
            return;
        }
        let mut scan = Vec::new();
        let mut order: Vec<&Input> = self.inputs.iter().filter(|input| input.enabled).collect();
        order.sort_by_key(|input| input.index);
        let mut largest = 1;
        for input in order {
            input.store(&mut scan);
            largest = largest.max(input.bytes());
        }
        if self.timestamp {
            scan.resize(scan.len().next_multiple_of(8), 0);
            scan.extend_from_slice(&time_ns.to_le_bytes());
            largest = 8;
        }
        scan.resize(scan.len().next_multiple_of(largest), 0);
        self.waiting.push_back(scan);
    }

    /// A read of `/dev/iio:deviceN` that does not block.
    pub fn read(&mut self, size: usize) -> Result<Vec<u8>, Errno> {
        if self.broken {
            return Err(Errno::EIO);
        }
        let Some(scan) = self.waiting.front().map(Vec::len) else { return Err(Errno::EAGAIN) };
        if size < scan {
            return Err(Errno::EINVAL);
        }
        let count = (size / scan).min(self.waiting.len());
        Ok(self.waiting.drain(..count).flatten().collect())
    }

    /// What a file in the device's folder says; `None` where there is no such file.
    pub fn show(&self, folder: &str, file: &str) -> Result<Option<String>, Errno> {
        let input = |suffix: &str| self.inputs.iter().find(|input| file.strip_suffix(suffix) == Some(&input.name));
        let flag = |on: bool| u8::from(on).to_string();
        Ok(match (folder, file) {
            ("", "name") => Some(self.name.clone()),
            ("", _) => {
                if let Some(input) = input("_raw") {
                    if self.enabled {
                        return Err(Errno::EBUSY);
                    }
                    if self.broken {
                        return Err(Errno::EIO);
                    }
                    Some(input.raw.to_string())
                } else if let Some(input) = input("_scale") {
                    Some(format!("{:.9}", input.scale))
                } else {
                    input("_offset").filter(|input| input.offset != 0).map(|input| input.offset.to_string())
                }
            }
            ("buffer", "enable") => Some(flag(self.enabled)),
            ("buffer", "length") => Some(self.length.to_string()),
            ("buffer", "watermark") => Some(self.watermark.to_string()),
            ("buffer", "data_available") => Some(self.waiting.len().to_string()),
            ("trigger", "current_trigger") => self.trigger.clone(),
            ("scan_elements", "in_timestamp_en") => Some(flag(self.timestamp)),
            ("scan_elements", "in_timestamp_index") => Some(self.inputs.len().to_string()),
            ("scan_elements", "in_timestamp_type") => Some("le:s64/64>>0".into()),
            ("scan_elements", _) => {
                let enabled = input("_en").map(|input| flag(input.enabled));
                let index = input("_index").map(|input| input.index.to_string());
                enabled.or(index).or(input("_type").map(Input::kind))
            }
            _ => None,
        })
    }

    /// The files of a folder.
    pub fn files(&self, folder: &str) -> Vec<String> {
        let of_inputs = |suffixes: &[&str]| -> Vec<String> {
            self.inputs.iter().flat_map(|input| suffixes.iter().map(move |s| format!("{}{s}", input.name))).collect()
        };
        let mut files: Vec<String> = match folder {
            "" => of_inputs(&["_raw", "_scale", "_offset"]),
            "scan_elements" => of_inputs(&["_en", "_index", "_type"]),
            _ => Vec::new(),
        };
        let fixed: &[&str] = match folder {
            "" => &["name"],
            "buffer" => &["enable", "length", "watermark", "data_available"],
            "trigger" => &["current_trigger"],
            "scan_elements" => &["in_timestamp_en", "in_timestamp_index", "in_timestamp_type"],
            _ => &[],
        };
        files.extend(fixed.iter().map(|name| name.to_string()));
        files.retain(|file| !matches!(self.show(folder, file), Ok(None)));
        files
    }

    /// What writing to a file does.
    pub fn store(&mut self, folder: &str, file: &str, text: &str, triggers: &[String]) -> Result<(), Errno> {
        let number = || text.parse::<usize>().map_err(|_| Errno::EINVAL);
        let flag = || match text {
            "0" | "n" => Ok(false),
            "1" | "y" => Ok(true),
            _ => Err(Errno::EINVAL),
        };
        if self.enabled && (folder, file) != ("buffer", "enable") {
            return Err(Errno::EBUSY);
        }
        match (folder, file) {
            ("buffer", "enable") => {
                let on = flag()?;
                let wanted = self.timestamp || self.inputs.iter().any(|input| input.enabled);
                if on && !self.enabled {
                    if !wanted || self.length == 0 || self.trigger.as_deref() == Some("") {
                        return Err(Errno::EINVAL);
                    }
                    self.waiting.clear();
                }
                self.enabled = on;
            }
            ("buffer", "length") => self.length = number()?,
            ("buffer", "watermark") => match number()? {
                0 => return Err(Errno::EINVAL),
                watermark if watermark > self.length => return Err(Errno::EINVAL),
                watermark => self.watermark = watermark,
            },
            ("trigger", "current_trigger") if self.trigger.is_some() => {
                if !text.is_empty() && !triggers.iter().any(|there| there == text) {
                    return Err(Errno::EINVAL);
                }
                self.trigger = Some(text.into());
            }
            ("scan_elements", "in_timestamp_en") => self.timestamp = flag()?,
            ("scan_elements", _) => {
                let name = file.strip_suffix("_en").ok_or(Errno::EACCES)?;
                let on = flag()?;
                self.inputs.iter_mut().find(|input| input.name == name).ok_or(Errno::EACCES)?.enabled = on;
            }
            _ => return Err(Errno::EACCES),
        }
        Ok(())
    }
}
