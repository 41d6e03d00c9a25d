//! One case diagnosed, in a process of its own: what it took in time and memory is its own, and a crash ends nothing
//! else.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::process::{Resource, Rlimit, setrlimit};
use rustix::time::{ClockId, clock_gettime};
use sinew_concealed::generator::case::Answer;
use sinew_concealed::reported::{Reported, Took};
use sinew_diagnosis::{Diagnosis, Settings, diagnose};
use sinew_recording::{Options, Recording};
use sinew_rig::{Catalogue, Rig};

use crate::frozen;
use crate::holdout;

/// The diagnosis' own random numbers start here, whatever the case.
const DIAGNOSIS_SEED: u64 = 1;

/// Reads one of a case's recordings as the command line does.
pub fn read(rig: &Rig, path: &Path) -> Result<Recording, sinew_recording::Error> {
    let model = rig.channels.first().map(|channel| &channel.model);
    sinew_recording::read(path, &Options { columns: Some(&rig.recording.columns), model, ..Options::default() })
}

/// Lets this process compute for no longer than `limit` on each of `threads`: SIGXCPU ends it then.
///
/// # Errors
/// The system's.
pub fn compute_at_most(limit: Duration, threads: usize) -> Result<(), Box<dyn Error>> {
    let seconds = limit.as_secs().saturating_mul(threads as u64);
    let most = Rlimit { current: Some(seconds), maximum: None };
    Ok(setrlimit(Resource::Cpu, most)?)
}

/// Time the threads of this process have computed, s.
fn computing_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Diagnoses the case in `folder` on `threads` threads; leaves `diagnosis.json`, `improved.toml` and `said.json` there.
///
/// # Errors
/// What kept it from writing. A diagnosis that refuses its input is an answer, and no error.
pub fn diagnose_case(folder: &Path, threads: usize) -> Result<Reported, Box<dyn Error>> {
    let answer: Answer = serde_json::from_slice(&fs::read(folder.join("answer.json"))?)?;
    let started = Instant::now();
    let reached = reach(folder, threads);
    let took =
        Took { seconds: started.elapsed().as_secs_f64(), computing_s: computing_s(), memory_mib: peak_memory_mib() };
    let mut reported = match reached {
        Ok((diagnosis, improved)) => {
            let json = serde_json::to_string_pretty(&diagnosis)? + "\n";
            fs::write(folder.join("diagnosis.json"), &json)?;
            fs::write(folder.join("improved.toml"), improved.to_toml())?;
            let mut reported = Reported::read(json.as_bytes())?;
            // judged on what a user would have: the file as written
            let after = Rig::load(&folder.join("improved.toml")).map_err(|e| e.to_string());
            match after.and_then(|rig| Ok((read(&rig, &folder.join("held.csv.gz")).map_err(|e| e.to_string())?, rig))) {
                Ok((held, rig)) => reported.held = holdout::chi(&rig, &held, &answer.noise).map(|(_, all)| all),
                Err(error) => reported.trouble = error,
            }
            reported
        }
        Err(error) => Reported::refused(&error),
    };
    (reported.took, reported.program) = (took, frozen::program().map_err(|e| e.to_string())?);
    fs::write(folder.join("said.json"), serde_json::to_string_pretty(&reported)? + "\n")?;
    Ok(reported)
}

fn reach(folder: &Path, threads: usize) -> Result<(Diagnosis, Rig), String> {
    let laws = folder.join("laws.toml");
    let laws = if laws.exists() { Catalogue::load(&laws).map_err(|e| e.to_string())? } else { Catalogue::default() };
    let rig = Rig::load_with(&folder.join("rig.toml"), &laws).map_err(|e| e.to_string())?;
    let mut recordings = Vec::new();
    for name in ["train.csv.gz", "beside.csv.gz"] {
        let path = folder.join(name);
        if path.exists() {
            recordings.push(read(&rig, &path).map_err(|e| e.to_string())?);
        }
    }
    let settings = Settings { seed: DIAGNOSIS_SEED, jobs: threads, thorough: false, progress: &|_, _| {} };
    let outcome = diagnose(&rig, 0, &recordings, &[], &settings).map_err(|e| e.to_string())?;
    Ok((outcome.diagnosis, outcome.improved))
}

/// The high-water mark of this process, MiB; 0 where the system does not say.
fn peak_memory_mib() -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|rest| rest.split_whitespace().next()?.parse::<f64>().ok()).map_or(0.0, |kib| kib / 1024.0)
}
