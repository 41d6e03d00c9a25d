//! From converters to samples: every device is read once a cycle, every channel picks its scan.

use std::fs::File;
use std::os::unix::fs::OpenOptionsExt;

use rustix::io::Errno;
use sinew_backend::Sample;
use sinew_rig::{LinuxInput, LinuxPhase, LinuxSampling};

use crate::Error;
use crate::iio::{Device, Scale};
use crate::scan::{Format, Layout};
use crate::settings::{ChannelSettings, Inputs};
use crate::sysfs::{self, Attribute};

/// Scans the kernel keeps for us: enough for a loop that is late by many periods. A power of two, because it would be rounded up
/// to one. When it is full the newest are dropped.
const KEPT: usize = 4096;

/// All converters of a rig and what each channel takes from them.
#[derive(Debug)]
pub(crate) struct Sampler {
    readers: Vec<Reader>,
    channels: Vec<Wired>,
    phase: LinuxPhase,
}

/// One device, open.
#[derive(Debug)]
enum Reader {
    Buffer(Buffer),
    Sysfs(Vec<Attribute>),
}

/// A device that fills a buffer by itself.
#[derive(Debug)]
struct Buffer {
    node: File,
    enable: Attribute,
    elements: Vec<(usize, Format)>,
    scan_bytes: usize,
    bytes: Vec<u8>,
    /// Scans that came since the last cycle, or why there are none.
    scans: Result<usize, Errno>,
}

/// A channel's inputs: in which reader, which of its elements, and what it means.
#[derive(Debug)]
struct Wired {
    inputs: Inputs<Option<Input>>,
    on_voltage_v: f64,
    on_current_a: f64,
}

#[derive(Debug, Clone, Copy)]
struct Input {
    reader: usize,
    element: usize,
    scale: Scale,
}

/// What the channels want of one device.
#[derive(Debug, Default)]
struct Wanted {
    inputs: Vec<String>,
}

impl Sampler {
    /// Opens the devices the channels name and sets their buffers going.
    pub fn open(
        devices: &[Device],
        channels: &[ChannelSettings],
        sampling: LinuxSampling,
        trigger: Option<&str>,
        phase: LinuxPhase,
    ) -> Result<Sampler, Error> {
        let mut wanted: Vec<Wanted> = devices.iter().map(|_| Wanted::default()).collect();
        let mut wired = Vec::new();
        for channel in channels {
            let mut find = |key, input: &LinuxInput| {
                let Some(wished) = &input.name else { return Ok(None) };
                let named = crate::iio::find(devices, wished);
                let (device, name) = named.map_err(|reason| Error::name(&channel.name, key, wished, reason))?;
                let scale = match sampling {
                    LinuxSampling::Buffer => devices[device].scale(&name)?,
                    LinuxSampling::Sysfs => devices[device].direct(&name)?.1,
                };
                let scale = Scale { gain: scale.gain * input.gain, offset: scale.offset * input.gain + input.offset };
                let inputs = &mut wanted[device].inputs;
                let element = inputs.iter().position(|there| *there == name).unwrap_or_else(|| {
                    inputs.push(name);
                    inputs.len() - 1
                });
                Ok(Some(Input { reader: device, element, scale }))
            };
            let inputs = channel.inputs.try_map(&mut find)?;
            if phase == LinuxPhase::Free {
                one_device(channel, &inputs, devices)?;
            }
            let (on_voltage_v, on_current_a) = (channel.on_voltage_v, channel.on_current_a);
            wired.push(Wired { inputs, on_voltage_v, on_current_a });
        }
        let mut readers = Vec::new();
        for (device, wanted) in devices.iter().zip(&wanted) {
            readers.push(match sampling {
                // of a device that no channel uses
                _ if wanted.inputs.is_empty() => Reader::Sysfs(Vec::new()),
                LinuxSampling::Buffer => Reader::Buffer(Buffer::open(device, &wanted.inputs, trigger)?),
                LinuxSampling::Sysfs => {
                    let open = |input: &String| Attribute::to_read(device.direct(input)?.0);
                    Reader::Sysfs(wanted.inputs.iter().map(open).collect::<Result<_, Error>>()?)
                }
            });
        }
        Ok(Sampler { readers, channels: wired, phase })
    }

    /// Fetches what the buffers hold. Before [`Sampler::sample`], once a cycle.
    pub fn fetch(&mut self) {
        for reader in &mut self.readers {
            if let Reader::Buffer(buffer) = reader {
                buffer.fetch();
            }
        }
    }

    /// A channel's sample of the period just past, in which it was `driven` or not.
    pub fn sample(&self, channel: usize, driven: bool) -> Result<Sample, Errno> {
        let Some(Wired { inputs, on_voltage_v, on_current_a }) = self.channels.get(channel) else {
            return Err(Errno::INVAL);
        };
        let Some(current) = inputs.current else { return Err(Errno::INVAL) };
        let held = self.phase == LinuxPhase::Synchronised && matches!(self.readers[current.reader], Reader::Sysfs(_));
        if held && !driven {
            // A sample-and-hold's value is of an earlier period; but a failing converter is reported.
            return self.read(current, 0).map(|_| Sample::NONE);
        }
        let on_phase = |sample: &Sample| sample.v3_v >= *on_voltage_v || sample.current_a >= *on_current_a;
        // With the gate closed no scan has to show an on-phase: what the newest shows is what flows nevertheless.
        let mut dark = Sample::NONE;
        let mut age = 0;
        loop {
            let read = |input: Option<Input>, age| match input {
                None => Ok(Some(f64::NAN)),
                Some(input) => self.read(input, age),
            };
            // Unless it may be any scan, the newest of each device is taken. No scan, no sample.
            let (Some(v1_v), Some(v2_v), Some(v3_v), Some(current_a)) =
                (read(inputs.v1, age)?, read(inputs.v2, age)?, read(inputs.v3, age)?, read(inputs.current, age)?)
            else {
                return Ok(dark);
            };
            let supply_v = read(inputs.supply, 0)?.unwrap_or(f64::NAN);
            let sample = Sample { v1_v, v2_v, v3_v, current_a, supply_v };
            if self.phase == LinuxPhase::Synchronised || on_phase(&sample) {
                return Ok(sample);
            }
            if age == 0 && !driven {
                dark = sample;
            }
            if matches!(self.readers[current.reader], Reader::Sysfs(_)) {
                return Ok(dark);
            }
            age += 1;
        }
    }

    /// An input `age` scans before its device's newest; `None` where there is no such scan.
    #[inline]
    fn read(&self, input: Input, age: usize) -> Result<Option<f64>, Errno> {
        let raw = match &self.readers[input.reader] {
            Reader::Buffer(buffer) => match buffer.value(input.element, age)? {
                Some(raw) => raw,
                None => return Ok(None),
            },
            Reader::Sysfs(attributes) => attributes.get(input.element).ok_or(Errno::INVAL)?.read()?,
        };
        Ok(Some(input.scale.gain * raw + input.scale.offset))
    }
}

/// With scans of any moment, those of two devices are of different moments and say nothing together.
fn one_device(channel: &ChannelSettings, inputs: &Inputs<Option<Input>>, devices: &[Device]) -> Result<(), Error> {
    let Some(current) = inputs.current else { return Ok(()) };
    let keys = [
        ("v1", inputs.v1, &channel.inputs.v1),
        ("v2", inputs.v2, &channel.inputs.v2),
        ("v3", inputs.v3, &channel.inputs.v3),
    ];
    for (key, input, settings) in keys {
        if let (Some(input), Some(name)) = (input, &settings.name)
            && input.reader != current.reader
        {
            let reason = format!(
                "with phase = \"free\" it has to be on the converter of the current, {}, to be of the same moment",
                devices[current.reader].number
            );
            return Err(Error::name(&channel.name, key, name, reason));
        }
    }
    Ok(())
}

impl Buffer {
    /// Enables the wanted elements alone, and the buffer.
    fn open(device: &Device, wanted: &[String], trigger: Option<&str>) -> Result<Buffer, Error> {
        let folder = device.path.join("scan_elements");
        let enable = Attribute::to_write(device.path.join("buffer/enable"))?;
        let set = |on: u64| enable.write(on).map_err(|e| Error::file(enable.path(), format!("write {on}"), e));
        // First the node, which one process can have open at a time: no other process' running buffer is stopped by mistake.
        let node =
            File::options().read(true).custom_flags(rustix::fs::OFlags::NONBLOCK.bits() as i32).open(&device.node);
        let node = node.map_err(|error| Error::file(&device.node, "open to read", error))?;
        // A dead driver's buffer may still run, and nothing can be set while it does.
        set(0)?;
        let there = device.elements()?;
        for (name, ..) in &there {
            let on = if wanted.contains(name) { "1" } else { "0" };
            sysfs::write(&folder.join(format!("{name}_en")), on)?;
        }
        // Drivers may sample in fixed sets only, but then drop the inputs not enabled.
        let elements = wanted.iter().map(|name| {
            let found = there.iter().find(|(there, ..)| there == name);
            found.map(|(_, index, format)| (*index, *format)).ok_or_else(|| Error::Content {
                path: folder.clone(),
                found: name.clone(),
                expected: "an input that can be read from the buffer; sampling = \"sysfs\" reads the others",
            })
        });
        let elements: Vec<(u32, Format)> = elements.collect::<Result<_, Error>>()?;
        let Layout { offsets, bytes: scan_bytes } = Layout::of(&elements);
        let current_trigger = device.path.join("trigger/current_trigger");
        if let Some(trigger) = trigger
            && current_trigger.exists()
        {
            sysfs::write(&current_trigger, trigger)?;
        }
        sysfs::write(&device.path.join("buffer/length"), &KEPT.to_string())?;
        // Not all have one; without blocking it makes no difference.
        let _ = sysfs::write(&device.path.join("buffer/watermark"), "1");
        set(1)?;
        let elements = offsets.into_iter().zip(elements.into_iter().map(|(_, format)| format)).collect();
        let bytes = vec![0; 2 * KEPT * scan_bytes];
        Ok(Buffer { node, enable, elements, scan_bytes, bytes, scans: Ok(0) })
    }

    #[inline]
    fn fetch(&mut self) {
        self.scans = match rustix::io::read(&self.node, &mut self.bytes[..]) {
            // A full buffer has dropped its newest scans: what it holds is of long ago.
            Ok(count) if count >= KEPT * self.scan_bytes => Ok(0),
            Ok(count) => Ok(count / self.scan_bytes),
            Err(Errno::AGAIN) => Ok(0),
            Err(errno) => Err(errno),
        };
    }

    #[inline]
    fn value(&self, element: usize, age: usize) -> Result<Option<f64>, Errno> {
        let scans = self.scans?;
        let (Some(scan), Some((offset, format))) = (scans.checked_sub(age + 1), self.elements.get(element)) else {
            return Ok(None);
        };
        let value = format.value(&self.bytes[scan * self.scan_bytes + offset..]);
        Ok(value.map(|value| value as f64))
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // An unused converter is stopped.
        let _ = self.enable.write(0);
    }
}
