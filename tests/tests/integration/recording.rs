//! A running driver recorded by another process: nothing lost, whatever happens to the recorder, the driver or the disk; and
//! where something is, it says exactly what.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use sinew_ipc::ChannelState;
use sinew_recording::session::{Ended, Head, Session, check};
use sinew_tests::{Driver, Process, RATE_HZ, Rig, recorded_so_far, run, sinew, wait_for, wait_until};

const CHANNELS: [&str; 4] = ["left", "right", "Back.1", "back_1"];

/// `sinew record` into a file of the test's, not started yet.
fn record(rig: &Rig, file: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(sinew());
    command.arg("record").arg(file).args(["--rig", &rig.name, "--json"]).args(more);
    command
}

/// All cycles of a recording: number and bytes.
fn cycles(path: &Path) -> BTreeMap<u64, (Head, Vec<u8>)> {
    let session = Session::open(path).unwrap_or_else(|e| panic!("{e}"));
    let mut found = BTreeMap::new();
    let mut cycles = session.cycles();
    while let Some(cycle) = cycles.next().unwrap_or_else(|e| panic!("{e}")) {
        found.insert(cycle.head.cycle, (cycle.head, cycle.bytes().to_vec()));
    }
    found
}

fn number(value: &Value, key: &str) -> u64 {
    value[key].as_u64().unwrap_or_else(|| panic!("{key}: {value:#}"))
}

/// Expects a recording that is whole, with cycles one after the other but for the gaps it lists.
fn assert_whole(path: &Path) -> BTreeMap<u64, (Head, Vec<u8>)> {
    run(["recording".as_ref(), "doctor".as_ref(), path.as_os_str()]).expect(0);
    let cycles = cycles(path);
    let (first, last) = (cycles.keys().next().unwrap(), cycles.keys().next_back().unwrap());
    let ending = Session::open(path).unwrap().ending().cloned().expect("an end");
    let inside = ending.gaps.iter().filter(|gap| gap.from > *first).map(|gap| gap.cycles()).sum::<u64>();
    assert_eq!(last - first + 1, cycles.len() as u64 + inside, "{ending:?}");
    cycles
}

/// Expects a recording about as long as it was asked to be, in which every period ran or was missed by the driver.
fn assert_lasts(report: &Value, seconds: f64) {
    let lasted = report["seconds"].as_f64().unwrap();
    assert!(lasted <= seconds && lasted > 0.5 * seconds, "{report:#}");
    let periods = number(report, "cycles") + number(report, "lost") + number(report, "missed");
    assert!(periods.abs_diff((lasted * RATE_HZ) as u64 + 1) <= 2, "{report:#}");
}

/// Waits until the first chunk of cycles is in the file.
fn wait_for_a_chunk(path: &Path) {
    wait_until("a chunk of the recording", || !recorded_so_far(path).is_empty());
}

#[test]
fn every_cycle_is_recorded_bit_for_bit_with_the_rig_and_the_loops_figures() {
    let rig = Rig::bench(&CHANNELS, "");
    let (driver, client) = Driver::ready(&rig);
    let mut stream = client.stream().unwrap();
    let file = rig.file("walk.mcap");
    let mut recorder = Process::start(&mut record(&rig, &file, &["--for", "2.5"]));
    let mut seen = Vec::new();
    let mut look = || {
        while let Some(cycle) = stream.next().unwrap() {
            seen.push((*cycle.header, cycle.channels.to_vec()));
        }
        stream.lost() as usize
    };
    wait_until("the recording to end", || {
        look();
        recorder.ended().is_some()
    });
    let lost_here = look();
    let report = recorder.finish().expect(0).json();
    assert_eq!((number(&report, "lost"), report["ended"].as_str()), (0, Some("complete")), "{report:#}");
    let recorded = assert_whole(&file);
    assert_eq!(number(&report, "cycles"), recorded.len() as u64);
    assert_lasts(&report, 2.5);

    let mut compared = 0;
    for (header, channels) in &seen {
        if let Some((head, bytes)) = recorded.get(&header.cycle) {
            assert_eq!((head.monotonic_ns, head.missed), (header.monotonic_ns, header.missed));
            assert_eq!(bytes, ChannelState::bytes_of(channels), "cycle {}", head.cycle);
            compared += 1;
        }
    }
    assert!(
        compared + lost_here >= recorded.len() && compared > recorded.len() / 4,
        "{compared} of {}",
        recorded.len()
    );

    let session = Session::open(&file).unwrap();
    assert_eq!(session.layout().channels, CHANNELS);
    let about = session.about();
    assert_eq!((about.rig.as_str(), about.rate_hz, about.simulated), (rig.name.as_str(), RATE_HZ, true));
    assert_eq!(about.rig_toml.as_deref(), Some(fs::read_to_string(rig.path()).unwrap().as_str()));
    let figures = session.loop_figures().unwrap();
    assert!(figures.len() >= 2, "{figures:?}");
    let last = figures.last().unwrap();
    assert!(last.cycles > 0 && last.lateness.count.iter().sum::<u64>() > 0 && last.allocations == 0, "{last:?}");
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().as_secs();
    assert!(now.abs_diff(about.started_unix_ns / 1_000_000_000) < 600);

    let info = run(["recording".as_ref(), "info".as_ref(), file.as_os_str(), "--json".as_ref()]).expect(0).json();
    assert_eq!(number(&info, "cycles"), recorded.len() as u64);
    assert_eq!((info["rig"].as_str(), info["lost"].as_u64()), (Some(rig.name.as_str()), Some(0)), "{info:#}");
    in_python(&file, &recorded);
    driver.stop();
}

/// Reads the recording with what Python users have, where that is installed, and compares the numbers.
fn in_python(file: &Path, recorded: &BTreeMap<u64, (Head, Vec<u8>)>) {
    const PROGRAM: &str = r#"
import json, struct, sys
try:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory
except ImportError:
    sys.exit(77)
bits = lambda x: struct.unpack("<Q", struct.pack("<d", x))[0]
with open(sys.argv[1], "rb") as f:
    reader = make_reader(f, decoder_factories=[DecoderFactory()], validate_crcs=True)
    out = {"cycles": [], "metadata": {}, "events": 0, "loop": 0}
    for schema, channel, message, m in reader.iter_decoded_messages():
        if channel.topic == "/cycles":
            out["cycles"].append([m.cycle, m.monotonic_ns, message.log_time, message.sequence, bits(m.left.length_m),
                                  bits(m.back_1_2.duty), m.back_1_2.mode])
        else:
            out["events" if channel.topic == "/events" else "loop"] += 1
    for record in reader.iter_metadata():
        out["metadata"][record.name] = record.metadata
    out["rig"] = [a.data.decode() for a in reader.iter_attachments() if a.name == "rig.toml"]
json.dump(out, sys.stdout)
"#;
    let ran = Command::new("python3").args(["-c", PROGRAM]).arg(file).output();
    let ran = match ran {
        Ok(ran) if ran.status.code() != Some(77) => ran,
        _ => return eprintln!("skipped: no mcap and mcap-ros2-support for Python"),
    };
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let found: Value = serde_json::from_slice(&ran.stdout).unwrap();
    let session = Session::open(file).unwrap();
    let about = session.about();
    let rows = found["cycles"].as_array().unwrap();
    assert_eq!(rows.len(), recorded.len());
    let f64_at = |bytes: &[u8], channel: usize, field: usize| {
        let at = channel * size_of::<ChannelState>() + 8 * field;
        u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
    };
    // NaN comes back as a NaN, its bits are Python's business
    let same = |a: u64, b: u64| a == b || (f64::from_bits(a).is_nan() && f64::from_bits(b).is_nan());
    for (row, (head, bytes)) in rows.iter().zip(recorded.values()) {
        let get = |i: usize| row[i].as_u64().unwrap();
        assert_eq!((get(0), get(1)), (head.cycle, head.monotonic_ns));
        assert_eq!((get(2), get(3)), (about.unix_ns(head.monotonic_ns), head.cycle & 0xffff_ffff));
        assert!(same(get(4), f64_at(bytes, 0, 0)), "{row} {head:?}");
        // `Back.1` is called back_1, so that `back_1` has to be called otherwise
        assert!(same(get(5), f64_at(bytes, 3, 5)), "{row} {head:?}");
        let mode = 3 * size_of::<ChannelState>() + 18 * 8;
        assert_eq!(get(6), u64::from(u32::from_le_bytes(bytes[mode..mode + 4].try_into().unwrap())));
    }
    assert_eq!(found["metadata"]["sinew"]["rig"].as_str(), Some(about.rig.as_str()));
    assert_eq!(found["metadata"]["sinew"]["channel.back_1_2"], "back_1");
    assert_eq!(found["metadata"]["sinew.end"]["lost"], "0");
    assert_eq!(found["rig"][0].as_str(), about.rig_toml.as_deref());
    assert!(found["loop"].as_u64() >= Some(2));
}

#[test]
fn a_killed_recorder_leaves_all_complete_chunks_and_recover_makes_a_whole_file() {
    let rig = Rig::bench(&CHANNELS, "");
    let (driver, _) = Driver::ready(&rig);
    let file = rig.file("killed.mcap");
    let recorder = Process::start(&mut record(&rig, &file, &["--compression", "zstd"]));
    // a chunk is a second long
    let complete = wait_for("two chunks of the recording", || {
        Some(recorded_so_far(&file)).filter(|cycles| cycles.len() as f64 > 1.5 * RATE_HZ)
    });
    recorder.kill();
    let before = fs::read(&file).unwrap();

    let left = cycles(&file);
    assert!(complete.iter().all(|cycle| left.contains_key(cycle)), "{} of {}", left.len(), complete.len());
    let doctor = run(["recording".as_ref(), "doctor".as_ref(), file.as_os_str()]).expect(1);
    assert!(doctor.stderr.contains("recording recover"), "{doctor:?}");
    let recovered =
        run(["recording".as_ref(), "recover".as_ref(), file.as_os_str(), "--json".as_ref()]).expect(0).json();
    assert_eq!(number(&recovered, "lost"), 0, "{recovered:#}");
    let mended = PathBuf::from(recovered["file"].as_str().unwrap());
    assert_eq!(mended, rig.file("killed-recovered.mcap"));
    assert_eq!(assert_whole(&mended), left);
    assert_eq!(fs::read(&file).unwrap(), before, "the damaged file stays as it is");
    assert_eq!(Session::open(&mended).unwrap().ending().unwrap().ended, Some(Ended::Recovered));
    // nothing is replaced unasked
    run(["recording".as_ref(), "recover".as_ref(), file.as_os_str()]).refused(&["is there already", "--force"]);
    driver.stop();
}

#[test]
fn a_recorder_that_stands_still_too_long_says_how_much_it_lost_and_where() {
    let rig = Rig::bench(&CHANNELS, "");
    let (driver, client) = Driver::ready(&rig);
    let file = rig.file("stalled.mcap");
    let recorder = Process::start(&mut record(&rig, &file, &[]));
    wait_for_a_chunk(&file);
    recorder.signal(libc::SIGSTOP);
    let from = client.latest().cycle;
    // the stream holds two seconds
    wait_until("more cycles than the stream holds", || client.latest().cycle > from + (3.5 * RATE_HZ) as u64);
    recorder.signal(libc::SIGCONT);
    let resumed = client.latest().cycle;
    wait_until("cycles from after the stop", || recorded_so_far(&file).last().is_some_and(|last| *last > resumed));
    recorder.signal(libc::SIGTERM);
    let ended = recorder.finish().expect(3);
    let report = ended.json();
    let lost = number(&report, "lost");
    assert!(lost > (0.5 * RATE_HZ) as u64, "{report:#}");
    assert!(ended.stderr.contains(&format!("{lost} cycles were lost")), "{}", ended.stderr);
    // exactly those that are not there
    let there = assert_whole(&file);
    let (first, last) = (*there.keys().next().unwrap(), *there.keys().next_back().unwrap());
    let missing: Vec<u64> = (first..=last).filter(|cycle| !there.contains_key(cycle)).collect();
    let listed: Vec<u64> = report["gaps"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|gap| {
            let end = |i: usize| gap[i].as_u64().unwrap();
            end(0)..=end(1)
        })
        .collect();
    assert_eq!((listed.len() as u64, &listed), (lost, &missing));
    let session = Session::open(&file).unwrap();
    let told: u64 =
        session.events().unwrap().iter().filter(|e| e.kind == "gap").map(|e| e.to_cycle - e.from_cycle + 1).sum();
    assert_eq!((told, session.ending().unwrap().lost), (lost, lost));
    driver.stop();
}

#[test]
fn the_drivers_end_completes_the_recording() {
    for (signal, ended) in [(libc::SIGTERM, "driver_stopped"), (libc::SIGKILL, "driver_died")] {
        let rig = Rig::bench(&CHANNELS, "");
        let (driver, _) = Driver::ready(&rig);
        let file = rig.file("end.mcap");
        let recorder = Process::start(&mut record(&rig, &file, &[]));
        wait_for_a_chunk(&file);
        driver.process.signal(signal);
        let report = recorder.finish().expect(0).json();
        assert_eq!((report["ended"].as_str(), number(&report, "lost")), (Some(ended), 0), "{report:#}");
        let there = assert_whole(&file);
        assert_eq!(number(&report, "cycles"), there.len() as u64);
    }
}

#[test]
fn a_full_disk_is_one_error_and_what_is_complete_stays() {
    let rig = Rig::bench(&CHANNELS, "");
    let (driver, _) = Driver::ready(&rig);
    let file = rig.file("full.mcap");
    let mut command = record(&rig, &file, &["--compression", "none"]);
    // SAFETY: setrlimit is a plain system call and may be called between fork and exec.
    unsafe {
        command.pre_exec(|| {
            let most = libc::rlimit { rlim_cur: 1_500_000, rlim_max: 1_500_000 };
            match libc::setrlimit(libc::RLIMIT_FSIZE, &most) {
                0 => Ok(()),
                _ => Err(std::io::Error::last_os_error()),
            }
        });
    }
    let ended = Process::start(&mut command).finish().expect(1);
    let report = ended.json();
    let (cycles, not_written) = (number(&report, "cycles"), number(&report, "not_written"));
    assert!(not_written > 0 && cycles > 0 && report["ended"] == "unwritable", "{report:#}");
    assert_eq!(ended.stderr.matches("error: ").count(), 1, "{}", ended.stderr);
    for word in ["full.mcap", "cannot be written", "too large", &format!("{not_written} cycles are not written")] {
        assert!(ended.stderr.contains(word), "{word}: {}", ended.stderr);
    }
    let checkup = check(&file, |_, _| {}).unwrap();
    assert!(checkup.is_whole() && checkup.cycles == cycles, "{checkup:?}");
    assert_eq!(Session::open(&file).unwrap().ending().unwrap().ended, Some(Ended::Unwritable));
    driver.stop();
}

#[test]
fn files_follow_each_other_without_a_gap() {
    let rig = Rig::bench(&CHANNELS, "");
    let (driver, _) = Driver::ready(&rig);
    let by_time = rig.file("time.mcap");
    let by_size = rig.file("size.mcap");
    let time = Process::start(&mut record(&rig, &by_time, &["--max-time", "1s", "--for", "2.5"]));
    let size =
        Process::start(&mut record(&rig, &by_size, &["--max-size", "1MB", "--compression", "none", "--for", "4"]));
    for (recorder, seconds, most) in [(time, 2.5, u64::MAX), (size, 4.0, 1_000_000)] {
        let report = recorder.finish().expect(0).json();
        let files: Vec<PathBuf> =
            report["files"].as_array().unwrap().iter().map(|file| file.as_str().unwrap().into()).collect();
        assert!(files.len() >= 2, "{report:#}");
        let mut all = BTreeMap::new();
        for (part, file) in files.iter().enumerate() {
            assert!(fs::metadata(file).unwrap().len() <= most, "{}", file.display());
            let session = Session::open(file).unwrap();
            let ended = if part + 1 == files.len() { Ended::Complete } else { Ended::Rotated };
            assert_eq!(session.ending().unwrap().ended, Some(ended));
            assert_eq!(session.about().extra["part"], part.to_string());
            assert!(session.about().rig_toml.is_some());
            let cycles = assert_whole(file);
            assert!(all.keys().next_back().is_none_or(|last| last + 1 == *cycles.keys().next().unwrap()));
            all.extend(cycles);
        }
        assert_eq!(number(&report, "cycles"), all.len() as u64);
        assert_lasts(&report, seconds);
    }
    driver.stop();
}

#[test]
fn the_last_files_of_a_recording_are_kept() {
    let rig = Rig::bench(&CHANNELS, "");
    let (driver, _) = Driver::ready(&rig);
    let file = rig.file("night.mcap");
    let other = rig.file("night-2026.txt");
    fs::write(&other, "precious").unwrap();
    let asked = ["--max-time", "1s", "--keep-files", "2", "--for", "4.5"];
    let report = Process::start(&mut record(&rig, &file, &asked)).finish().expect(0).json();
    let files: Vec<PathBuf> =
        report["files"].as_array().unwrap().iter().map(|file| file.as_str().unwrap().into()).collect();
    let removed = number(&report, "removed_files");
    assert!(files.len() == 2 && removed >= 2 && !file.exists() && other.exists(), "{report:#}");
    let there = fs::read_dir(file.parent().unwrap()).unwrap().map(|entry| entry.unwrap().path());
    let mut there: Vec<PathBuf> = there.filter(|path| path.extension().is_some_and(|end| end == "mcap")).collect();
    there.sort();
    assert_eq!(there, files);
    let mut kept = assert_whole(&files[0]);
    let last = assert_whole(&files[1]);
    assert_eq!(kept.keys().next_back().unwrap() + 1, *last.keys().next().unwrap());
    kept.extend(last);
    assert_eq!(number(&report, "cycles"), number(&report, "removed_cycles") + kept.len() as u64);
    // a second one would meet the files that are left
    rig.ask(&["record", file.to_str().unwrap(), "--max-time", "1s", "--keep-files", "2"]).refused(&[
        files[0].to_str().unwrap(),
        "is there already",
        "--force",
    ]);
    driver.stop();
}

#[test]
fn with_less_free_than_is_to_stay_free_nothing_is_begun() {
    let rig = Rig::bench(&["left"], "");
    let (driver, _) = Driver::ready(&rig);
    let file = rig.file("walk.mcap");
    fs::write(&file, "precious").unwrap();
    let text = file.to_str().unwrap();
    // no disk has that
    let refused = rig.ask(&["record", text, "--force", "--keep-free", "900000000GB"]).expect(1);
    for word in ["walk.mcap", "are free on its disk", "hint: ", "make room", "--keep-free"] {
        assert!(refused.stderr.contains(word), "{word}: {}", refused.stderr);
    }
    assert_eq!(fs::read_to_string(&file).unwrap(), "precious");
    driver.stop();
}

#[test]
fn what_cannot_be_recorded_is_refused_before_anything_is_written() {
    let rig = Rig::bench(&["left"], "");
    let file = rig.file("a.mcap");
    let text = file.to_str().unwrap();
    let nobody = rig.ask(&["record", text]);
    assert!(matches!(nobody.code, Some(1 | 2)) && nobody.stderr.contains("sinew run"), "{nobody:?}");
    let (driver, _) = Driver::ready(&rig);
    rig.ask(&["record", rig.file("no/such/a.mcap").to_str().unwrap()]).refused(&["there is no folder"]);
    rig.ask(&["record", text, "--max-size", "12"]).refused(&["500MB or 1GB"]);
    rig.ask(&["record", text, "--keep-free", "12"]).refused(&["500MB or 1GB, or 0"]);
    rig.ask(&["record", text, "--keep-files", "1", "--max-time", "1s"]).refused(&["--keep-files"]);
    rig.ask(&["record", text, "--keep-files", "3"]).refused(&["is one file", "--max-time"]);
    rig.ask(&["record", text, "--keep-size", "1GB", "--max-size", "1GB"]).refused(&["at least 2.00 GB"]);
    rig.ask(&["record", text, "--compression", "gzip"]).refused(&["gzip", "lz4"]);
    assert!(!file.exists());
    fs::write(&file, "precious").unwrap();
    rig.ask(&["record", text, "--for", "0.2"]).refused(&["is there already", "--force"]);
    assert_eq!(fs::read_to_string(&file).unwrap(), "precious");
    rig.ask(&["record", text, "--for", "0.2", "--force"]).expect(0);
    assert_whole(&file);
    for args in [["recording", "info"], ["recording", "doctor"], ["recording", "recover"]] {
        run(args.iter().chain(&[rig.path().to_str().unwrap()])).refused(&["rig.toml", "MCAP"]);
    }
    driver.stop();
}

/// On a disk that is really small, in a mount namespace of the test's own: it is said before the floor is reached, and the recording ends
/// above it with a whole file. Takes root.
#[test]
fn a_recording_ends_at_the_floor_of_a_small_disk_and_says_so_before() {
    const DISK_KB: u64 = 6_000;
    const FLOOR_KB: u64 = 2_000;
    /// What the end of a file takes: its last chunk and its summary.
    const ENDING_KB: u64 = 1_000;
    let wires: Vec<String> = (0..8).map(|number| format!("wire{number}")).collect();
    let rig = Rig::bench(&wires.iter().map(String::as_str).collect::<Vec<_>>(), "");
    let (driver, client) = Driver::ready(&rig);
    let (disk, copy) = (rig.file("disk"), rig.file("copy.mcap"));
    fs::create_dir(&disk).unwrap();
    let script = format!(
        "mount -t tmpfs -o size={DISK_KB}k tmpfs \"$1\" || exit 99\n\
         \"$0\" record \"$1/session.mcap\" --rig \"$3\" --keep-free {FLOOR_KB}kB --compression none --for 120\n\
         code=$?; stat -f -c 'free %a %S' \"$1\"; cp \"$1/session.mcap\" \"$2\"; exit $code"
    );
    let mut command = Command::new("unshare");
    command.args(["-m", "sh", "-c", &script]).arg(sinew()).arg(&disk).arg(&copy).arg(&rig.name);
    let ended = Process::start(&mut command).finish();
    if ended.code == Some(99) || ended.stderr.contains("unshare:") {
        eprintln!("skipped: no file system may be mounted here: {}", ended.stderr.trim());
        return;
    }
    let ended = ended.expect(1);
    let said = |word: &str| ended.stderr.find(word).unwrap_or_else(|| panic!("{word:?} is not said: {ended:?}"));
    let warned = said("are free on its disk, and the recording ends when it is less than 2.0 MB");
    assert!(warned < said("error: "), "{ended:?}");
    said("less than the 2.0 MB that stay free");
    said("nothing is lost");
    let free = ended.stdout.lines().find_map(|line| line.strip_prefix("free ")).expect("what is free");
    let free: Vec<u64> = free.split(' ').map(|number| number.parse().unwrap()).collect();
    let free_kb = free[0] * free[1] / 1000;
    assert!(free_kb > FLOOR_KB - ENDING_KB && free_kb < FLOOR_KB, "{free_kb} kB are free: {ended:?}");
    assert_whole(&copy);
    // The driver has not noticed.
    let cycle = client.latest().cycle;
    wait_until("cycles", || client.latest().cycle > cycle + 20);
    driver.stop();
}
