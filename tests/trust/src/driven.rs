//! A driver's process on hardware whose outputs are measured independently of the driver, and a client of it: the fixture of
//! every fault of a hardware backend.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;
use std::time::Duration;

use rand::rngs::Xoshiro256PlusPlus;
use rustix::process::Signal;
use sinew_ipc::{Client, Fault, Mode};
use sinew_rig::Rig;

use crate::failure::{Failure, expect, unexpected};
use crate::kind::{Group, Kind, Trials, Unit, between};
use crate::lockstep::rig_text;
use crate::running::{LONG, Process, started, wait_for};
use crate::site::Site;

/// The wires' duty when the fault is injected, and the pulse that is output otherwise.
pub const DUTY: [f64; CHANNELS] = [0.1, 0.09];
/// See [`DUTY`].
pub const PULSE: f64 = 0.02;
/// Wires.
pub const CHANNELS: usize = 2;

/// Hardware of a driver that reports its own outputs.
pub trait Hardware: Sized {
    /// Where the faults of its kind are listed.
    const GROUP: Group;
    /// Rate of the loop, Hz. Slow: driver and hardware share a machine that may be busy.
    const RATE_HZ: f64;
    /// Duties closer than this are the same to it.
    const STEP: f64;

    /// The rig file of wires that are connected to it, made of one of wires that are not; `folder` is its own.
    fn wired(text: &str, folder: &Path) -> String;

    /// It, there for a driver of that file.
    ///
    /// # Errors
    /// What cannot be had on this machine.
    fn start(rig: &Rig, folder: &Path) -> Result<Self, Failure>;

    /// What is put out now, once something has been.
    fn put_out(&mut self) -> Option<[f64; CHANNELS]>;

    /// Whether all duties asked for are put out.
    fn is_driven(&mut self) -> bool {
        self.put_out().is_some_and(|put| put.iter().zip(DUTY).all(|(put, duty)| (put - duty).abs() < Self::STEP))
    }

    /// A try begins: only what is put out from now on counts.
    fn forget(&mut self) {}
}

/// Hardware and a driver, both at work until one of them is struck.
pub struct Bench<'s, H> {
    site: &'s Site,
    /// What the driver was started with.
    pub rig: Rig,
    file: PathBuf,
    driver: Option<Driven>,
    /// What it drives.
    pub hardware: H,
}

impl<'s, H: Hardware> Bench<'s, H> {
    fn start(site: &'s Site, kind: &str) -> Result<Bench<'s, H>, Failure> {
        // A file system may be mounted over the hardware's own folder.
        let (file, folder) = (site.folder()?.join("rig.toml"), site.folder()?);
        let text = rig_text(&site.name(kind), CHANNELS, H::RATE_HZ, 7, "");
        fs::write(&file, H::wired(&text, &folder))?;
        let rig = Rig::load(&file).map_err(|error| Failure::Unexpected(error.to_string()))?;
        let hardware = H::start(&rig, &folder)?;
        Ok(Bench { site, rig, file, driver: None, hardware })
    }

    /// The driver of this try.
    ///
    /// # Errors
    /// None was started, or it was killed.
    pub fn driver(&self) -> Result<&Driven, Failure> {
        self.driver.as_ref().ok_or_else(|| Failure::Unexpected("there is no driver".into()))
    }

    /// Kills the driver; its client is left.
    ///
    /// # Errors
    /// As [`Bench::driver`].
    pub fn kill_driver(&mut self) -> Result<Client, Failure> {
        let Some(Driven { mut process, client }) = self.driver.take() else { return unexpected("there is no driver") };
        process.signal(Signal::KILL)?;
        process.finish()?;
        Ok(client)
    }

    /// Gets both wires driven, by a new driver if need be, and by resets alone wherever a fault is latched; the outputs show it.
    fn at_work(&mut self) -> Result<(), Failure> {
        wait_for("both wires at work", || {
            let driver = match &mut self.driver {
                Some(driver) => driver,
                none => none.insert(Driven::start(self.site, &self.file, &self.rig.name)?),
            };
            if self.hardware.is_driven() {
                return Ok(Some(()));
            }
            driver.ask_for(&DUTY)?;
            Ok(None)
        })
    }

    /// Both wires at work, at a random moment of a period.
    fn ready(&mut self, rng: &mut Xoshiro256PlusPlus) -> Result<(), Failure> {
        wait_for("both wires to stay at work", || {
            self.at_work()?;
            thread::sleep(Duration::from_secs_f64(between(rng, 3.0, 5.0) / H::RATE_HZ));
            Ok(self.hardware.is_driven().then_some(()))
        })?;
        self.hardware.forget();
        Ok(())
    }
}

/// A kind whose tries share the hardware, and a driver as long as it lives. Each try ends with both wires at work again.
pub fn struck<H: Hardware>(
    name: &'static str,
    injected: &'static str,
    within_ms: f64,
    faults: &'static [Fault],
    one: impl Fn(&mut Bench<H>, &mut Xoshiro256PlusPlus) -> Result<f64, Failure> + Send + Sync + 'static,
) -> Kind {
    Kind {
        name,
        group: H::GROUP,
        injected,
        expected: "",
        within: within_ms,
        unit: Unit::Milliseconds,
        lost: "the power of all until their reset",
        faults,
        carry_out: Box::new(move |site: &Site, trials: &mut Trials| {
            let mut bench = Bench::start(site, name)?;
            trials.each(|rng| {
                bench.ready(rng)?;
                let reaction = one(&mut bench, rng)?;
                bench.at_work()?;
                Ok(reaction)
            })
        }),
    }
}

/// A driver and its client.
pub struct Driven {
    /// The driver.
    pub process: Process,
    /// The client.
    pub client: Client,
}

impl Driven {
    /// A driver of a rig file, called `rig`.
    ///
    /// # Errors
    /// One that does not start.
    pub fn start(site: &Site, file: &Path, rig: &str) -> Result<Driven, Failure> {
        let mut command = Command::new(site.itself()?);
        command.arg("drive").arg(file).arg(site.folder()?.join("log")).args(["--for", "3600"]);
        let (process, client) = started(site, &mut command, rig)?;
        Ok(Driven { process, client })
    }

    /// Asks each channel for its duty, after a reset wherever a fault is latched. What is refused now is asked for again by the
    /// next call.
    ///
    /// # Errors
    /// A driver that has ended.
    pub fn ask_for(&mut self, duty: &[f64]) -> Result<(), Failure> {
        if let Some(status) = self.process.ended()? {
            return unexpected(format!("the driver ended with {status}: {}", self.process.said()));
        }
        for (number, (channel, duty)) in self.client.latest().channels().iter().zip(duty).enumerate() {
            match channel.mode() {
                Mode::Fault => drop(self.client.reset(&format!("wire{number}"))),
                Mode::Duty if channel.asked == *duty => {}
                Mode::Waiting => {}
                _ => drop(self.client.set_duty(&format!("wire{number}"), *duty, LONG)),
            }
        }
        thread::sleep(Duration::from_millis(20));
        Ok(())
    }

    /// Waits until all channels are latched, by one of these.
    ///
    /// # Errors
    /// When they are not, or by something else.
    pub fn latched(&self, by: &[Fault]) -> Result<(), Failure> {
        let found = wait_for("the fault", || {
            let state = self.client.latest();
            let faults: Vec<Fault> = state.channels().iter().filter_map(|channel| channel.fault()).collect();
            Ok((faults.len() == state.channels().len()).then_some(faults))
        })?;
        expect(found.iter().all(|fault| by.contains(fault)), || format!("latched: {found:?}"))
    }

    /// Waits until all channels are latched and the driver finds the whole backend gone. What the machine was late with may have
    /// been the first cause, and that one stays.
    ///
    /// # Errors
    /// As [`Driven::latched`].
    pub fn latched_by_the_backend(&self) -> Result<(), Failure> {
        wait_for("the driver to miss its backend", || {
            Ok(self.client.latest().channels().iter().all(|channel| channel.backend != 0).then_some(()))
        })?;
        self.latched(&[Fault::Backend, Fault::NoSample, Fault::CycleOverrun])
    }
}
