//! The simulated kernel: chips and converters wired to simulated wires, and their files.

use std::time::Duration;

use fuser::Errno;
use sinew_backend::{Backend, Sample};
use sinew_rig::Rig;
use sinew_sim_backend::{FaultHandle, SimulatedRig};

use crate::gpio::{Line, Lines};
use crate::iio::{Converter, Input};
use crate::pwm::{Chip, Output};

/// Outputs of a chip, as the PCA9685 has.
const OUTPUTS: usize = 16;
/// The trigger that can be chosen.
pub const TRIGGER: &str = "pwm-on-phase";

/// What a path is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Node {
    Folder(Vec<String>),
    Link(String),
    File,
    /// The character device of a converter.
    Device(usize),
}

/// When converters convert.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scans {
    /// Once in the on-phase of each period, triggered by it.
    OnPhase,
    /// So many times a period, at any moment of it.
    Free(usize),
}

/// Everything there is.
#[derive(Debug)]
pub struct Kernel {
    /// PWM chips.
    pub chips: Vec<Chip>,
    /// Converters, one for each wire.
    pub converters: Vec<Converter>,
    /// Lines, and what hangs on them.
    lines: Lines,
    /// What each write to a duty takes, as on a slow bus.
    pub write_takes: Duration,
    /// Whether the chips are no longer there.
    unplugged: bool,
    /// How often everything was plugged in: what was opened before answers ENODEV for good.
    plugged: u64,
    /// Wires, and what their converters make of their samples.
    rig: SimulatedRig,
    scans: Scans,
    supply_v: Vec<f64>,
    periods: u64,
    period_ns: u64,
    samples: Vec<Sample>,
}

impl Kernel {
    pub(crate) fn new(rig: &Rig, scans: Scans) -> Result<Kernel, sinew_sim_backend::Error> {
        let channels = rig.channels.len();
        let chip = |index: usize| Chip {
            device: format!("1-00{:02x}", 0x40 + index),
            outputs: vec![Output::default(); OUTPUTS],
        };
        let converter = |(index, channel): (usize, &sinew_rig::Channel)| {
            // Different widths, orders and signs, so that the layout of the scan matters.
            let input = |name: &str, index, bits: (u32, u32, u32), signed, big_endian, full, offset| Input {
                name: name.into(),
                index,
                bits,
                signed,
                big_endian,
                scale: full * 1e3 / f64::from(1u32 << bits.0),
                offset,
                enabled: false,
                raw: 0,
            };
            let full_v = 2.0 * channel.model.drive.supply_v;
            let inputs = vec![
                input("in_voltage0", 0, (16, 16, 0), false, false, full_v, 0),
                input("in_voltage1", 1, (24, 32, 8), false, true, full_v, 0),
                input("in_voltage2", 2, (20, 32, 4), true, false, 2.0 * full_v, -40),
                input("in_voltage3", 3, (12, 16, 4), false, true, full_v, 0),
                input("in_current0", 4, (24, 32, 0), true, true, 8.0 * channel.limits.max_current_a, 0),
            ];
            Converter::new("ads131", &format!("2-00{:02x}", 0x48 + index), inputs, scans == Scans::OnPhase)
        };
        let mut simulated = SimulatedRig::new(rig)?;
        // It has been on for long: from here on a period is a period.
        let _ = simulated.start();
        Ok(Kernel {
            chips: (0..channels.div_ceil(OUTPUTS)).map(chip).collect(),
            converters: rig.channels.iter().enumerate().map(converter).collect(),
            lines: Lines::new(rig),
            write_takes: Duration::ZERO,
            unplugged: false,
            plugged: 0,
            rig: simulated,
            scans,
            supply_v: rig.channels.iter().map(|channel| channel.model.drive.supply_v).collect(),
            periods: 0,
            period_ns: (1e9 / rig.rate_hz) as u64,
            samples: vec![Sample::NONE; channels],
        })
    }

    /// The output of a channel.
    pub fn output(&self, channel: usize) -> &Output {
        &self.chips[channel / OUTPUTS].outputs[channel % OUTPUTS]
    }

    /// A line, where there is one.
    pub fn line(&self, number: u32) -> Option<&Line> {
        self.lines.numbered(number)
    }

    /// The same, to break it.
    pub fn line_mut(&mut self, number: u32) -> Option<&mut Line> {
        self.lines.numbered_mut(number)
    }

    /// Whether the power stages have their supply.
    pub fn has_supply(&self) -> bool {
        self.lines.has_supply()
    }

    /// The simulated wires.
    pub fn rig(&self) -> &SimulatedRig {
        &self.rig
    }

    /// What breaks the simulated wires.
    pub fn faults(&self) -> FaultHandle {
        self.rig.faults()
    }

    /// Takes chips, converters and lines away: their files vanish, what is open answers ENODEV, nothing is put out.
    pub fn unplug(&mut self) {
        self.unplugged = true;
        for converter in &mut self.converters {
            converter.gone = true;
        }
        for output in self.chips.iter_mut().flat_map(|chip| &mut chip.outputs) {
            *output = Output { changed: Some(std::time::Instant::now()), ..Output::default() };
        }
        self.lines.unplug();
    }

    /// Brings them back, as after a reset: nothing is exported, no buffer runs.
    pub fn plug_in(&mut self) {
        self.unplugged = false;
        self.plugged += 1;
        for converter in &mut self.converters {
            converter.reset();
        }
    }

    /// One period of PWM passes with the duties that are put out, and the converters convert.
    pub(crate) fn pass(&mut self) {
        let duty: Vec<f64> = (0..self.samples.len()).map(|channel| self.output(channel).duty()).collect();
        self.lines.pass();
        if self.lines.has_supply() {
            self.rig.restore();
        } else {
            self.rig.cut();
        }
        self.rig.put_out(&duty);
        if self.rig.exchange(&duty, &mut self.samples).is_err() {
            self.samples.fill(Sample::NONE);
        }
        if let Some(inputs) = self.rig.stop_inputs() {
            self.lines.show_stop(inputs);
        }
        self.periods += 1;
        let time_ns = (self.periods * self.period_ns).cast_signed();
        for (channel, converter) in self.converters.iter_mut().enumerate() {
            if converter.gone {
                continue;
            }
            let sample = self.samples[channel];
            let supply_v = if self.lines.has_supply() { self.supply_v[channel] } else { 0.0 };
            let off = Sample { v1_v: 0.0, v2_v: 0.0, v3_v: 0.0, current_a: 0.0, supply_v };
            // More than what is put out, where the stage conducts by itself.
            let on_share = self.rig.truth(channel).map_or(duty[channel], |truth| truth.duty);
            let convert = |converter: &mut Converter, sample: &Sample| {
                let values = [sample.v1_v, sample.v2_v, sample.v3_v, sample.supply_v, sample.current_a];
                for (input, value) in converter.inputs.iter_mut().zip(values) {
                    input.raw = input.convert(value);
                }
                converter.push(time_ns);
            };
            match self.scans {
                // Without an on-phase nothing triggers.
                Scans::OnPhase if duty[channel] > 0.0 && converter.trigger.as_deref() == Some(TRIGGER) => {
                    convert(converter, &sample);
                }
                Scans::OnPhase => {}
                Scans::Free(times) => {
                    for moment in 0..times {
                        let on = (moment as f64 + 0.5) / (times as f64) < on_share;
                        convert(converter, if on { &sample } else { &off });
                    }
                }
            }
        }
    }

    /// What is at a path, `""` being the root.
    pub(crate) fn node(&self, path: &str) -> Option<Node> {
        let parts: Vec<&str> = path.split('/').filter(|part| !part.is_empty()).collect();
        let folder = |names: &[&str]| Some(Node::Folder(names.iter().map(|name| name.to_string()).collect()));
        match parts[..] {
            [] => folder(&["sys", "dev"]),
            ["sys"] => folder(&["class", "bus", "devices"]),
            ["sys", "class"] => folder(&["pwm", "gpio"]),
            ["sys", "class", "gpio"] => {
                Some(Node::Folder(if self.unplugged { Vec::new() } else { self.lines.names() }))
            }
            ["sys", "class", "gpio", name] if !self.unplugged => {
                self.lines.line(name)?;
                folder(&["value", "direction", "active_low"])
            }
            ["sys", "class", "gpio", name, file] if !self.unplugged => {
                let shown = self.lines.line(name)?.show(file);
                (!matches!(shown, Ok(None))).then_some(Node::File)
            }
            ["sys", "class", "pwm"] => {
                let there = if self.unplugged { 0 } else { self.chips.len() };
                Some(Node::Folder((0..there).map(|chip| format!("pwmchip{}", chip * OUTPUTS)).collect()))
            }
            ["sys", "class", "pwm", name] => {
                let chip = self.chip(name)?;
                Some(Node::Link(format!("../../devices/i2c-1/{}/pwm/{name}", self.chips[chip].device)))
            }
            ["sys", "bus"] => folder(&["iio"]),
            ["sys", "bus", "iio"] => folder(&["devices"]),
            ["sys", "bus", "iio", "devices"] => {
                let devices = self.present().map(|device| format!("iio:device{device}"));
                Some(Node::Folder(devices.chain(["trigger0".to_string()]).collect()))
            }
            ["sys", "bus", "iio", "devices", "trigger0"] => folder(&["name"]),
            ["sys", "bus", "iio", "devices", "trigger0", "name"] => Some(Node::File),
            ["sys", "bus", "iio", "devices", name] => {
                let device = self.converter(name)?;
                Some(Node::Link(format!("../../../devices/i2c-2/{}/{name}", self.converters[device].parent)))
            }
            ["sys", "devices"] => folder(&["i2c-1", "i2c-2"]),
            ["sys", "devices", "i2c-1", ref rest @ ..] => self.pwm_node(rest),
            ["sys", "devices", "i2c-2", ref rest @ ..] => self.iio_node(rest),
            ["dev"] => Some(Node::Folder(self.present().map(|device| format!("iio:device{device}")).collect())),
            ["dev", name] => self.converter(name).map(Node::Device),
            _ => None,
        }
    }

    fn present(&self) -> impl Iterator<Item = usize> {
        (0..self.converters.len()).filter(|&device| !self.converters[device].gone)
    }

    fn chip(&self, name: &str) -> Option<usize> {
        let number: usize = name.strip_prefix("pwmchip")?.parse().ok()?;
        let chip = number / OUTPUTS;
        (!self.unplugged && number.is_multiple_of(OUTPUTS) && chip < self.chips.len()).then_some(chip)
    }

    fn converter(&self, name: &str) -> Option<usize> {
        let device: usize = name.strip_prefix("iio:device")?.parse().ok()?;
        self.converters.get(device).is_some_and(|converter| !converter.gone).then_some(device)
    }

    fn pwm_node(&self, parts: &[&str]) -> Option<Node> {
        if self.unplugged {
            return None;
        }
        let Some((device, rest)) = parts.split_first() else {
            return Some(Node::Folder(self.chips.iter().map(|chip| chip.device.clone()).collect()));
        };
        let index = self.chips.iter().position(|chip| chip.device == *device)?;
        let name = format!("pwmchip{}", index * OUTPUTS);
        let exported = |number: &str| {
            let number: usize = number.strip_prefix("pwm")?.parse().ok()?;
            self.chips[index].outputs.get(number).filter(|output| output.exported)
        };
        match *rest {
            [] => Some(Node::Folder(vec!["pwm".into()])),
            ["pwm"] => Some(Node::Folder(vec![name])),
            ["pwm", chip] if chip == name => {
                let mut names: Vec<String> = ["export", "unexport", "npwm", "device"].map(String::from).into();
                names.extend((0..OUTPUTS).map(|n| format!("pwm{n}")).filter(|n| exported(n).is_some()));
                Some(Node::Folder(names))
            }
            ["pwm", chip, "device"] if chip == name => Some(Node::Link("../..".into())),
            ["pwm", chip, "export" | "unexport" | "npwm"] if chip == name => Some(Node::File),
            ["pwm", chip, number] if chip == name => {
                exported(number)?;
                Some(Node::Folder(["period", "duty_cycle", "enable", "polarity"].map(String::from).into()))
            }
            ["pwm", chip, number, attribute] if chip == name => exported(number)?.show(attribute).map(|_| Node::File),
            _ => None,
        }
    }

    fn iio_node(&self, parts: &[&str]) -> Option<Node> {
        let Some((parent, rest)) = parts.split_first() else {
            return Some(Node::Folder(self.present().map(|device| self.converters[device].parent.clone()).collect()));
        };
        let index = self.present().find(|&device| self.converters[device].parent == *parent)?;
        let (converter, name) = (&self.converters[index], format!("iio:device{index}"));
        let shown = |folder, file| !matches!(converter.show(folder, file), Ok(None));
        match *rest {
            [] => Some(Node::Folder(vec![name])),
            [device] if device == name => {
                let mut names = converter.files("");
                names.extend(["buffer", "scan_elements"].map(String::from));
                names.extend(converter.trigger.as_ref().map(|_| "trigger".to_string()));
                Some(Node::Folder(names))
            }
            [device, "trigger"] if device == name && converter.trigger.is_none() => None,
            [device, folder @ ("buffer" | "scan_elements" | "trigger")] if device == name => {
                Some(Node::Folder(converter.files(folder)))
            }
            [device, file] if device == name => shown("", file).then_some(Node::File),
            [device, folder, file] if device == name => shown(folder, file).then_some(Node::File),
            _ => None,
        }
    }

    /// A file's owner, folder within it and name: what stands after the device.
    fn place<'a>(&self, path: &'a str) -> Option<Place<'a>> {
        let parts: Vec<&'a str> = path.split('/').collect();
        match parts[..] {
            ["sys", "bus", "iio", "devices", "trigger0", "name"] => Some(Place::Trigger),
            ["sys", "class", "gpio", name, file] if !self.unplugged => {
                let number = name.strip_prefix("gpio")?.parse().ok()?;
                self.lines.numbered(number).map(|_| Place::Line(number, file))
            }
            ["sys", "devices", "i2c-1", _, "pwm", chip, ref rest @ ..] => match *rest {
                [file] => Some(Place::Chip(self.chip(chip)?, file)),
                [output, file] => {
                    let number = output.strip_prefix("pwm")?.parse().ok()?;
                    Some(Place::Output(self.chip(chip)?, number, file))
                }
                _ => None,
            },
            ["sys", "devices", "i2c-2", _, device, ref rest @ ..] => match *rest {
                [file] => Some(Place::Converter(self.converter(device)?, "", file)),
                [folder, file] => Some(Place::Converter(self.converter(device)?, folder, file)),
                _ => None,
            },
            _ => None,
        }
    }

    /// Opens a file; what comes back goes with each read and write of it.
    pub(crate) fn open(&mut self, path: &str) -> Result<u64, Errno> {
        match self.node(path) {
            Some(Node::Device(device)) => {
                let converter = &mut self.converters[device];
                if converter.open {
                    return Err(Errno::EBUSY);
                }
                converter.open = true;
                Ok(self.plugged)
            }
            Some(_) => Ok(self.plugged),
            None => Err(Errno::ENODEV),
        }
    }

    pub(crate) fn close(&mut self, path: &str, handle: u64) {
        if handle == self.plugged
            && let Some(device) = path.strip_prefix("dev/iio:device").and_then(|number| number.parse::<usize>().ok())
            && let Some(converter) = self.converters.get_mut(device)
        {
            converter.open = false;
        }
    }

    pub(crate) fn read(&mut self, path: &str, handle: u64, offset: usize, size: usize) -> Result<Vec<u8>, Errno> {
        if handle != self.plugged {
            return Err(Errno::ENODEV);
        }
        if let Some(Node::Device(device)) = self.node(path) {
            return self.converters[device].read(size);
        }
        let text = match self.place(path).ok_or(Errno::ENODEV)? {
            Place::Trigger => Some(TRIGGER.to_string()),
            Place::Chip(_, "npwm") => Some(OUTPUTS.to_string()),
            Place::Chip(..) => return Err(Errno::EACCES),
            Place::Output(chip, number, file) => {
                self.chips[chip].outputs.get(number).and_then(|output| output.show(file))
            }
            Place::Converter(device, folder, file) => self.converters[device].show(folder, file)?,
            Place::Line(number, file) => self.lines.numbered(number).ok_or(Errno::ENODEV)?.show(file)?,
        };
        let text = text.ok_or(Errno::ENODEV)?.trim_end().to_string() + "\n";
        let bytes = text.as_bytes();
        Ok(bytes[offset.min(bytes.len())..bytes.len().min(offset + size)].to_vec())
    }

    pub(crate) fn write(&mut self, path: &str, handle: u64, text: &str) -> Result<(), Errno> {
        if handle != self.plugged {
            return Err(Errno::ENODEV);
        }
        match self.place(path).ok_or(Errno::ENODEV)? {
            Place::Trigger => Err(Errno::EACCES),
            Place::Chip(chip, file) => self.chips[chip].store(file, text),
            Place::Output(chip, number, file) => {
                std::thread::sleep(self.write_takes);
                self.chips[chip].outputs.get_mut(number).ok_or(Errno::ENODEV)?.store(file, text)
            }
            Place::Converter(device, folder, file) => {
                self.converters[device].store(folder, file, text, &[TRIGGER.to_string()])
            }
            Place::Line(number, file) => self.lines.numbered_mut(number).ok_or(Errno::ENODEV)?.store(file, text),
        }
    }
}

enum Place<'a> {
    Trigger,
    Chip(usize, &'a str),
    Output(usize, usize, &'a str),
    Converter(usize, &'a str, &'a str),
    Line(u32, &'a str),
}
