//! Adjustable clocks for one process: a shim in C, compiled on demand and preloaded (`LD_PRELOAD`).

use std::fs::{self, File, OpenOptions};
use std::os::unix::fs::FileExt;
use std::path::PathBuf;
use std::process::Command;

use crate::failure::Failure;
use crate::running::How;
use crate::site::Site;

const SOURCE: &str = include_str!("../shim/clock.c");

/// The clocks of the processes that were started with [`Clocks::how`].
#[derive(Debug)]
pub struct Clocks {
    library: PathBuf,
    place: PathBuf,
    file: File,
}

impl Clocks {
    /// Clocks that show what they show.
    ///
    /// # Errors
    /// [`Failure::Impossible`] without a C compiler.
    pub fn new(site: &Site) -> Result<Clocks, Failure> {
        let folder = site.folder()?;
        let (source, library, place) = (folder.join("clock.c"), folder.join("clock.so"), folder.join("clocks"));
        fs::write(&source, SOURCE)?;
        let built = Command::new("cc").args(["-shared", "-fPIC", "-O2", "-o"]).arg(&library).arg(&source).output();
        match built {
            Ok(built) if built.status.success() => {}
            Ok(built) => return Err(Failure::Impossible(String::from_utf8_lossy(&built.stderr).into_owned())),
            Err(error) => return Err(Failure::Impossible(format!("no C compiler: {error}"))),
        }
        fs::write(&place, [0; 16])?;
        let file = OpenOptions::new().write(true).open(&place)?;
        Ok(Clocks { library, place, file })
    }

    /// Lets a driver be started with these clocks.
    pub fn how(&self) -> How<'static> {
        How { env: vec![("LD_PRELOAD", self.library.clone()), ("TRUST_CLOCKS", self.place.clone())], ..How::default() }
    }

    /// Sets the wall clock so many ns ahead.
    ///
    /// # Errors
    /// Where that cannot be written.
    pub fn set_wall_ns(&self, ahead: i64) -> Result<(), Failure> {
        Ok(self.file.write_all_at(&ahead.to_ne_bytes(), 0)?)
    }

    /// Lets the machine have been suspended for so many ns.
    ///
    /// # Errors
    /// Where that cannot be written.
    pub fn set_suspended_ns(&self, ahead: i64) -> Result<(), Failure> {
        Ok(self.file.write_all_at(&ahead.to_ne_bytes(), 8)?)
    }
}
