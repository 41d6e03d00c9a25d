//! A driver's process whose outputs somebody else sees, and a client of it: what the hardware backends are struck with.

use std::path::Path;
use std::process::Command;
use std::thread;
use std::time::Duration;

use sinew_ipc::{Client, Fault, Mode};

use crate::kind::{Failure, expect, unexpected};
use crate::running::{LONG, Process, started, wait_for};
use crate::site::Site;

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
