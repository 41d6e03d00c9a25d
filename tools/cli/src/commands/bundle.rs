//! A diagnosis in one archive: what went in, what was asked, what came out, and of which version; another laboratory repeats it with
//! `sinew repeat`.
//!
//! Files in it have places of their own (`inputs/`, `answer/`), so that nobody needs the folders of whoever made it. The command in it
//! names those places; which paths they had when it was typed stands beside them.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{Cursor, Read, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sinew_recording::Utc;
use sinew_report::Source;
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::fitting::{command, sha256};
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;

/// What says what the archive is.
const MANIFEST: &str = "bundle.json";
/// The same for whoever opens it by hand.
const README: &str = "README.txt";
/// Its layout.
const SCHEMA: &str = "sinew.bundle/1";
/// Where what went in lies.
const INPUTS: &str = "inputs";
/// Where the answer lies.
const ANSWER: &str = "answer";
/// More files, or larger ones, are no bundle: an hour at a kilohertz is a twentieth of it as text.
const MOST_FILES: usize = 1000;
const MOST_BYTES: u64 = 8 << 30;

/// `bundle.json`.
#[derive(Debug, Serialize, Deserialize)]
pub struct Manifest {
    schema: String,
    /// Version and commit of the program that answered.
    pub version: String,
    /// When.
    date: String,
    /// The command as it was typed.
    typed: String,
    /// Its words, for the places in the archive; without `sinew`, and without where to write.
    pub words: Vec<String>,
    /// Every file but this one and the README, by its place.
    files: BTreeMap<String, Entry>,
}

/// A file of the archive.
#[derive(Debug, Serialize, Deserialize)]
struct Entry {
    sha256: String,
    /// Its path when the command was typed; of what went in.
    #[serde(skip_serializing_if = "Option::is_none")]
    typed: Option<String>,
}

/// A recording that went in, and of which channel, where the command says so.
pub struct Given<'a> {
    /// `CHANNEL=` before the path.
    pub channel: Option<&'a str>,
    /// Its file.
    pub path: &'a Path,
}

impl<'a> Given<'a> {
    /// One of the only channel there is.
    pub fn of(path: &'a PathBuf) -> Given<'a> {
        Given { channel: None, path }
    }
}

/// An archive that is to be written, or was read.
pub struct Bundle {
    /// What it says of itself.
    pub manifest: Manifest,
    files: Vec<(String, Vec<u8>)>,
}

impl Bundle {
    /// Finds out before the work, not after it, that the archive that is asked for has no place.
    pub fn can_be_written(args: &args::Diagnose) -> Outcome {
        let Some(path) = &args.bundle else { return Ok(()) };
        if path.exists() {
            return Err(Failure::input(format!("{}: is there already", path.display()))
                .hint("choose another --bundle: nothing is overwritten"));
        }
        output::has_place(path)?;
        output::can_become_folder(folder_of(path))
    }

    /// Writes the archive of a diagnosis that has been made, where one is asked for: what was fitted and what was held out, its inputs as they
    /// were read for it, and its answer by names.
    pub fn keep(
        args: &args::Diagnose,
        recordings: [Vec<Given<'_>>; 2],
        sources: &[Source],
        answer: &[(PathBuf, &str)],
    ) -> Outcome {
        let Some(path) = &args.bundle else { return Ok(()) };
        Bundle::of(args, recordings, sources, answer)?.write(path)
    }

    fn of(
        args: &args::Diagnose,
        recordings: [Vec<Given<'_>>; 2],
        sources: &[Source],
        answer: &[(PathBuf, &str)],
    ) -> Result<Bundle, Failure> {
        let mut inputs = Inputs { sources, files: Vec::new() };
        let words = words(args, &recordings, &mut inputs)?;
        let mut files = Vec::new();
        let mut entries = BTreeMap::new();
        for Input { place, typed, sha256, bytes } in inputs.files {
            entries.insert(place.clone(), Entry { sha256, typed: Some(typed) });
            files.push((place, bytes));
        }
        for (path, text) in answer {
            let place =
                format!("{ANSWER}/{}", path.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/"));
            entries.insert(place.clone(), Entry { sha256: sha256(text.as_bytes()), typed: None });
            files.push((place, text.as_bytes().to_vec()));
        }
        let manifest = Manifest {
            schema: SCHEMA.into(),
            version: args::VERSION.into(),
            date: Utc::now().to_string(),
            typed: command(),
            words,
            files: entries,
        };
        Ok(Bundle { manifest, files })
    }

    /// Writes it, whole or not at all.
    fn write(&self, path: &Path) -> Outcome {
        let packed = self.packed().map_err(|error| Failure::own(format!("{}: {error}", path.display())))?;
        output::write_file(path, packed)
    }

    /// The bytes of the archive.
    fn packed(&self) -> Result<Vec<u8>, ZipError> {
        let manifest = serde_json::to_string_pretty(&self.manifest).map_err(std::io::Error::from)? + "\n";
        let readme = self.readme();
        let words = [(MANIFEST, manifest.as_bytes()), (README, readme.as_bytes())];
        let files = self.files.iter().map(|(place, bytes)| (place.as_str(), &bytes[..]));
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).large_file(true);
        for (name, bytes) in words.into_iter().chain(files) {
            zip.start_file(name, options)?;
            zip.write_all(bytes)?;
        }
        Ok(zip.finish()?.into_inner())
    }

    /// Reads one, and refuses what is none, or is not as it was made.
    pub fn read(path: &Path) -> Result<Bundle, Failure> {
        let refused = |what: &str| {
            Failure::input(format!("{}: {what}", path.display()))
                .hint("take the archive as `sinew diagnose --bundle` wrote it")
        };
        let file = File::open(path).map_err(|error| {
            Failure::input(format!("{}: cannot be read: {error}", path.display()))
                .hint("name an archive that `sinew diagnose --bundle` wrote")
        })?;
        let mut zip = ZipArchive::new(file).map_err(|_| refused("is no archive, or not a whole one"))?;
        if zip.len() > MOST_FILES {
            return Err(refused(&format!("has {} files, more than {MOST_FILES}", zip.len())));
        }
        let mut left = MOST_BYTES;
        let mut files = Vec::new();
        for index in 0..zip.len() {
            let mut entry = zip.by_index(index).map_err(|error| refused(&format!("is damaged: {error}")))?;
            // Only places inside the folder it is unpacked to.
            let Some(place) = entry.enclosed_name().and_then(|place| place.to_str().map(str::to_string)) else {
                return Err(refused(&format!("{:?} is no place inside it", entry.name())));
            };
            let mut bytes = Vec::new();
            let read = entry.by_ref().take(left + 1).read_to_end(&mut bytes);
            read.map_err(|error| refused(&format!("{place}: is damaged: {error}")))?;
            left = left.checked_sub(bytes.len() as u64).ok_or_else(|| refused("is larger than any bundle"))?;
            files.push((place, bytes));
        }
        let manifest =
            files.iter().find(|(place, _)| place == MANIFEST).ok_or_else(|| refused(&format!("has no {MANIFEST}")))?;
        let manifest: Manifest =
            serde_json::from_slice(&manifest.1).map_err(|error| refused(&format!("{MANIFEST}: {error}")))?;
        if manifest.schema != SCHEMA {
            return Err(Failure::input(format!("{}: is {}, not {SCHEMA}", path.display(), manifest.schema))
                .hint("repeat it with the version that made it, which its README.txt names"));
        }
        files.retain(|(place, _)| place != MANIFEST && place != README);
        let there: BTreeMap<&str, &[u8]> = files.iter().map(|(place, bytes)| (place.as_str(), &bytes[..])).collect();
        for (place, entry) in &manifest.files {
            let Some(bytes) = there.get(place.as_str()) else { return Err(refused(&format!("{place} is missing"))) };
            if sha256(bytes) != entry.sha256 {
                return Err(refused(&format!("{place} is not as it was put in")));
            }
        }
        if let Some(stray) = there.keys().find(|place| !manifest.files.contains_key(**place)) {
            return Err(refused(&format!("{stray} does not belong to it")));
        }
        Ok(Bundle { manifest, files })
    }

    /// Puts what went in into a folder.
    pub fn unpack_inputs(&self, folder: &Path) -> std::io::Result<()> {
        for (place, bytes) in self.files.iter().filter(|(place, _)| place.starts_with(INPUTS)) {
            let path = folder.join(place);
            path.parent().map_or(Ok(()), fs::create_dir_all)?;
            fs::write(path, bytes)?;
        }
        Ok(())
    }

    /// Of every file that went in, its place and the path it had when the command was typed.
    pub fn renamed(&self) -> impl Iterator<Item = (&str, &str)> {
        self.manifest.files.iter().filter_map(|(place, entry)| Some((place.as_str(), entry.typed.as_deref()?)))
    }

    /// A file of the answer, by its name.
    pub fn answer(&self, name: &str) -> Option<&[u8]> {
        let wanted = format!("{ANSWER}/{name}");
        self.files.iter().find(|(place, _)| *place == wanted).map(|(_, bytes)| &bytes[..])
    }

    fn readme(&self) -> String {
        let Manifest { version, date, typed, .. } = &self.manifest;
        let mut text = format!(
            "A diagnosis by sinew {version}, {date}:\n\n  {typed}\n\n\
             {INPUTS}/ is what went in, {ANSWER}/ what came out; open {ANSWER}/report.html in a browser. {MANIFEST} has the \
             SHA-256 of every file.\nTo make it again and have the two answers compared:\n\n  sinew repeat THIS.zip\n\n"
        );
        for (place, entry) in &self.manifest.files {
            if let Some(typed) = &entry.typed {
                text += &format!("{place} was {typed}\n");
            }
        }
        text
    }
}

/// The folder of a file.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// What goes in, each file once.
struct Inputs<'a> {
    sources: &'a [Source],
    files: Vec<Input>,
}

/// A file that goes in.
struct Input {
    /// Its place in the archive.
    place: String,
    /// Its path as typed.
    typed: String,
    sha256: String,
    bytes: Vec<u8>,
}

impl Inputs<'_> {
    /// The place of a file in the archive.
    fn place(&mut self, path: &Path) -> Result<String, Failure> {
        let typed = path.display().to_string();
        if let Some(there) = self.files.iter().find(|there| there.typed == typed) {
            return Ok(there.place.clone());
        }
        let bytes =
            fs::read(path).map_err(|error| Failure::input(format!("{typed}: cannot be read again: {error}")))?;
        let sha256 = sha256(&bytes);
        let was = self.sources.iter().find(|source| source.path == typed);
        if was.is_none_or(|source| source.sha256 != sha256) {
            return Err(Failure::input(format!("{typed}: has changed since it was diagnosed"))
                .hint("the answer is written, the bundle is not: run it again while the files stay as they are"));
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_free = |place: &String| self.files.iter().all(|there| there.place != *place);
        let numbered = (2..).map(|number| format!("{INPUTS}/{number}/{name}"));
        let place = std::iter::once(format!("{INPUTS}/{name}")).chain(numbered).find(is_free).unwrap_or_default();
        self.files.push(Input { place: place.clone(), typed, sha256, bytes });
        Ok(place)
    }

    fn given(&mut self, given: &Given<'_>) -> Result<String, Failure> {
        let place = self.place(given.path)?;
        Ok(given.channel.map_or_else(|| place.clone(), |channel| format!("{channel}={place}")))
    }
}

/// The words of a command that asks the same of the files in the archive. How many threads, and what goes to stdout, is no part of it.
fn words(
    args: &args::Diagnose,
    [fitted, held_out]: &[Vec<Given<'_>>; 2],
    inputs: &mut Inputs<'_>,
) -> Result<Vec<String>, Failure> {
    // Every field, so that a new option is not forgotten here.
    let args::Diagnose { fitting, out: _, holdout: _, thorough, picture, whole_rig, bundle: _ } = args;
    let args::Fitting { rig, recordings: _, channel, ignore_columns, seed, jobs: _, json: _, laws } = fitting;
    let args::Laws { catalogue } = laws;
    let mut words = vec!["diagnose".to_string(), inputs.place(rig)?];
    for given in fitted {
        words.push(inputs.given(given)?);
    }
    words.push(format!("--seed={seed}"));
    if let Some(channel) = channel {
        words.push(format!("--channel={channel}"));
    }
    for given in held_out {
        words.push(format!("--holdout={}", inputs.given(given)?));
    }
    if let Some(catalogue) = catalogue {
        words.push(format!("--catalogue={}", inputs.place(catalogue)?));
    }
    let flags = [
        ("--ignore-columns", ignore_columns),
        ("--thorough", thorough),
        ("--picture", picture),
        ("--whole-rig", whole_rig),
    ];
    words.extend(flags.into_iter().filter(|(_, is_set)| **is_set).map(|(flag, _)| flag.to_string()));
    Ok(words)
}
