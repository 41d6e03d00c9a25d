//! Where the accounts are: a folder for each rig, a file for each wire, those of simulated wires apart.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use sinew_recording::{Part, Utc};

use crate::account::{Account, SCHEMA};
use crate::error::Error;

/// An account is a few kilobytes; what is larger is none.
const MOST_BYTES: u64 = 256 << 10;
/// Accounts of wires that were replaced, in a folder of this name.
const OLD: &str = "old";

/// A folder of accounts.
#[derive(Debug, Clone)]
pub struct Store {
    folder: PathBuf,
}

impl Store {
    /// In this folder, which need not be there.
    pub fn new(folder: impl Into<PathBuf>) -> Store {
        Store { folder: folder.into() }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn of_rig(&self, rig: &str, simulated: bool) -> PathBuf {
        self.folder.join(if simulated { "simulated" } else { "real" }).join(rig)
    }

    /// The file of a wire.
    pub fn path(&self, rig: &str, channel: &str, simulated: bool) -> PathBuf {
        self.of_rig(rig, simulated).join(format!("{channel}.json"))
    }

    /// The account of a wire; `None` where there is none.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Damaged`].
    pub fn read(&self, rig: &str, channel: &str, simulated: bool) -> Result<Option<Account>, Error> {
        let path = self.path(rig, channel, simulated);
        let Some(account) = read(&path)? else { return Ok(None) };
        if (account.rig.as_str(), account.channel.as_str(), account.simulated) != (rig, channel, simulated) {
            let reason = format!("it is that of {} of {}", account.channel, account.rig);
            return Err(Error::Damaged { path, reason });
        }
        Ok(Some(account))
    }

    /// Writes an account, whole or not at all.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn write(&self, account: &Account) -> Result<(), Error> {
        let path = self.path(&account.rig, &account.channel, account.simulated);
        let write = || {
            fs::create_dir_all(path.parent().unwrap_or(&self.folder))?;
            let (part, mut file) = Part::create(&path)?;
            file.write_all(serde_json::to_string_pretty(account)?.as_bytes())?;
            file.write_all(b"\n")?;
            part.publish(&file)
        };
        write().map_err(|reason: io::Error| Error::File { path: path.clone(), reason })
    }

    /// Moves the file of a wire aside, whatever is in it, and says where it is now; `None` where there is none.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn set_aside(&self, rig: &str, channel: &str, simulated: bool) -> Result<Option<PathBuf>, Error> {
        let path = self.path(rig, channel, simulated);
        let old = self.of_rig(rig, simulated).join(OLD);
        let aside = old.join(format!("{channel}-{}.json", Utc::now().fine_stamp()));
        let moved = || match fs::symlink_metadata(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
            Ok(_) => {
                fs::create_dir_all(&old)?;
                fs::rename(&path, &aside)?;
                Ok(Some(aside.clone()))
            }
        };
        moved().map_err(|reason| Error::File { path: path.clone(), reason })
    }

    /// Every account there is, by rig and channel, those of simulated wires last; what is wrong with one keeps its place.
    ///
    /// # Errors
    /// [`Error::File`] where a folder cannot be looked through.
    pub fn all(&self) -> Result<Vec<Result<Account, Error>>, Error> {
        let mut found = Vec::new();
        for kind in ["real", "simulated"] {
            for rig in names(&self.folder.join(kind))? {
                let folder = self.folder.join(kind).join(&rig);
                if !folder.is_dir() {
                    continue;
                }
                for name in names(&folder)?.into_iter().filter(|name| !name.starts_with('.')) {
                    let Some(channel) = name.strip_suffix(".json") else { continue };
                    found.extend(self.read(&rig, channel, kind == "simulated").transpose());
                }
            }
        }
        Ok(found)
    }
}

/// What is in a folder, in order; nothing where there is none.
fn names(folder: &Path) -> Result<Vec<String>, Error> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(|reason| Error::File { path: folder.into(), reason })?,
    };
    let mut names: Vec<String> = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    Ok(names)
}

/// Reads an account's file.
fn read(path: &Path) -> Result<Option<Account>, Error> {
    let damaged = |reason: String| Error::Damaged { path: path.into(), reason };
    let mut text = Vec::new();
    match File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(reason) => return Err(Error::File { path: path.into(), reason }),
        Ok(file) => {
            let read = file.take(MOST_BYTES + 1).read_to_end(&mut text);
            read.map_err(|reason| Error::File { path: path.into(), reason })?;
        }
    }
    if text.len() as u64 > MOST_BYTES {
        return Err(damaged(format!("it is larger than {} KiB", MOST_BYTES >> 10)));
    }
    // an account of another version is not taken apart by the rules of this one
    let value: serde_json::Value = serde_json::from_slice(&text).map_err(|error| damaged(error.to_string()))?;
    match value.get("schema").and_then(serde_json::Value::as_str) {
        Some(SCHEMA) => {}
        Some(other) => return Err(damaged(format!("it is of the version {other}, this program writes {SCHEMA}"))),
        None => return Err(damaged(format!("it lacks \"schema\": \"{SCHEMA}\""))),
    }
    let account: Account = serde_json::from_value(value).map_err(|error| damaged(error.to_string()))?;
    if account.is_sound() { Ok(Some(account)) } else { Err(damaged("it has numbers that none can have".into())) }
}

#[cfg(test)]
mod tests {
    use sinew_rig::Rig;

    use super::*;
    use crate::wire::{Sample, Wire};

    fn account(simulated: bool) -> Account {
        let rig = Rig::hexapod();
        let wire = Wire::of(&rig, 0);
        let mut account = Account::new(&rig.name, "wire", simulated, &wire);
        for k in 0..999 {
            let martensite = (f64::from(k) * 0.7).sin().abs();
            account.see(
                &wire,
                &Sample {
                    seconds: 1e-3,
                    powered: true,
                    power_w: 1.5,
                    martensite,
                    strain: 0.04 * martensite,
                    stress_pa: 123_456_789.1,
                    temperature_c: 90.0 + martensite,
                },
            );
        }
        account
    }

    /// Whether they are the same but for the last digits, which JSON does not keep.
    fn same(found: &Account, expected: &Account) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
        let (a, b) = (found.report(), expected.report());
        found.wire == expected.wire
            && (&found.rig, &found.channel, &found.since) == (&expected.rig, &expected.channel, &expected.since)
            && a.cycles == b.cycles
            && [(a.used.least, b.used.least), (a.used.middle, b.used.middle), (a.used.most, b.used.most)]
                .iter()
                .chain(&[(a.whole_cycles, b.whole_cycles), (a.hours_watched, b.hours_watched)])
                .all(|(a, b)| close(*a, *b))
    }

    #[test]
    fn an_account_comes_back_as_it_was_written_and_nothing_is_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        assert!(store.all().unwrap().is_empty());
        let (real, simulated) = (account(false), account(true));
        store.write(&simulated).unwrap();
        store.write(&real).unwrap();
        store.write(&real).unwrap();
        assert!(same(&store.read(&real.rig, "wire", false).unwrap().unwrap(), &real));
        assert_eq!(store.read(&real.rig, "other", false).unwrap(), None);
        let all: Vec<Account> = store.all().unwrap().into_iter().map(Result::unwrap).collect();
        assert!(all.len() == 2 && same(&all[0], &real) && same(&all[1], &simulated), "real ones first");
        let files: Vec<_> = fs::read_dir(store.path(&real.rig, "wire", false).parent().unwrap()).unwrap().collect();
        assert_eq!(files.len(), 1);
    }

    #[test]
    fn a_new_wire_leaves_the_old_account_where_it_can_be_found() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        let real = account(false);
        assert_eq!(store.set_aside(&real.rig, "wire", false).unwrap(), None);
        store.write(&real).unwrap();
        let aside = store.set_aside(&real.rig, "wire", false).unwrap().unwrap();
        assert!(same(&super::read(&aside).unwrap().unwrap(), &real));
        assert!(store.all().unwrap().is_empty());
        // even a damaged one is kept
        fs::write(store.path(&real.rig, "wire", false), "{").unwrap();
        let aside = store.set_aside(&real.rig, "wire", false).unwrap().unwrap();
        assert_eq!(fs::read_to_string(aside).unwrap(), "{");
    }

    #[test]
    fn what_is_damaged_is_said_with_its_place_and_stays() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        let real = account(false);
        store.write(&real).unwrap();
        let path = store.path(&real.rig, "wire", false);
        let good = fs::read_to_string(&path).unwrap();
        let spoilt = [
            String::new(),
            good[..good.len() / 2].to_string(),
            good.replace("/1\"", "/2\""),
            good.replace("\"cycles\":", "\"cycle\":"),
            good.replacen("\"watched_s\": ", "\"watched_s\": -", 1),
            good.replacen("\"channel\": \"wire\"", "\"channel\": \"other\"", 1),
            "[]".into(),
            format!("{good}{}", " ".repeat(300 << 10)),
        ];
        for text in spoilt {
            fs::write(&path, &text).unwrap();
            let error = store.read(&real.rig, "wire", false).unwrap_err();
            assert!(matches!(error, Error::Damaged { .. }) && error.is_input(), "{error}");
            assert!(error.to_string().contains("wire.json") && error.remedy().contains("--new-wire"));
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            assert!(store.all().unwrap()[0].is_err());
        }
    }
}
