//! A program that wants what it may not have, for the tests: `sinew-test-intruder TASK …`. It knows nothing of sinew's library: an
//! intruder would not use it.
//!
//! - `glass SOCKET`: is let in at a gate, and then tries every way of writing to the memory it was handed. Says what it tried and
//!   what came of it; exit code 1 when anything succeeded.
//! - `files PATH …`: tries to open each of these, and what is in them, for reading and for writing; exit code 1 when anything opened.
//! - `rubbish SOCKET SECONDS SEED`: sends rubbish, half-right requests and floods, on connection after connection; says how much.
//! - `squat FOLDER RIG`: stands at a door with another one's name, until it is killed.
//! - `litter FOLDER COUNT PREFIX TARGET`: puts so many files, folders, pipes and links to TARGET there, and holds locks on whatever of others' and
//!   of sinew's name it can open, until it is killed.
//! - `take PATH …`: makes these folders, open to everybody, before somebody else does.
//! - `chase SECONDS`: watches /dev/shm, and for every file of a run makes others that bear that run's name and could be its next ones.

use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rustix::fs::{FallocateFlags, SealFlags};
use rustix::io::Errno;
use rustix::mm::{MapFlags, MprotectFlags, ProtFlags};
use rustix::net::{
    AddressFamily, RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendFlags, SocketAddrUnix, SocketFlags,
    SocketType,
};
use std::fs::{File, OpenOptions};
use std::io::{IoSliceMut, Write};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, AsRawFd, OwnedFd};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    let succeeded = match words[..] {
        ["glass", socket] => glass(socket),
        ["files", ref paths @ ..] => paths.iter().map(|path| files(Path::new(path))).sum(),
        ["rubbish", socket, seconds, seed] => {
            rubbish(socket, seconds.parse().expect("seconds"), seed.parse().expect("a seed"))
        }
        ["squat", folder, rig] => squat(folder, rig),
        ["litter", folder, count, prefix, target] => {
            litter(Path::new(folder), count.parse().expect("a number"), prefix, target)
        }
        ["take", ref paths @ ..] => paths.iter().map(|path| take(path)).sum(),
        ["chase", seconds] => chase(seconds.parse().expect("seconds")),
        _ => panic!("no such task: {words:?}"),
    };
    if succeeded == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn socket() -> OwnedFd {
    rustix::net::socket_with(AddressFamily::UNIX, SocketType::SEQPACKET, SocketFlags::CLOEXEC, None).expect("a socket")
}

/// Knocks; the first words and the memory that came with them.
fn enter(path: &str) -> Result<(OwnedFd, Vec<u8>, Option<OwnedFd>), Errno> {
    let socket = socket();
    rustix::net::connect(&socket, &SocketAddrUnix::new(path)?)?;
    let mut bytes = [0; 4096];
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut beside = RecvAncillaryBuffer::new(&mut space);
    let got = rustix::net::recvmsg(&socket, &mut [IoSliceMut::new(&mut bytes)], &mut beside, RecvFlags::CMSG_CLOEXEC)?;
    let memory = beside.drain().find_map(|message| match message {
        RecvAncillaryMessage::ScmRights(mut descriptors) => descriptors.next(),
        _ => None,
    });
    Ok((socket, bytes[..got.bytes].to_vec(), memory))
}

/// Says what was tried and what came of it; 1 when it succeeded.
fn tried<T, E: std::fmt::Display>(what: &str, result: Result<T, E>) -> usize {
    match result {
        Ok(_) => {
            println!("{what}: SUCCEEDED");
            1
        }
        Err(error) => {
            println!("{what}: {error}");
            0
        }
    }
}

fn glass(path: &str) -> usize {
    let (_socket, welcome, memory) = enter(path).expect("let in");
    let memory = memory.unwrap_or_else(|| panic!("nothing handed over: {welcome:?}"));
    let bytes = rustix::fs::fstat(&memory).expect("its size").st_size as usize;
    println!("handed {bytes} bytes");
    let mut done = ways_to_write("handed", &memory, bytes);
    for path in [format!("/proc/self/fd/{}", memory.as_raw_fd()), format!("/dev/fd/{}", memory.as_raw_fd())] {
        match OpenOptions::new().read(true).write(true).open(&path) {
            // Opening is no harm by itself: it is writing that counts.
            Ok(again) => done += ways_to_write(&path, &again, bytes),
            Err(error) => println!("{path}: {error}"),
        }
    }
    done
}

fn ways_to_write(name: &str, memory: &(impl AsFd + AsRawFd), bytes: usize) -> usize {
    let both = ProtFlags::READ | ProtFlags::WRITE;
    let mut file = File::from(memory.as_fd().try_clone_to_owned().expect("a descriptor"));
    let map = |how| {
        // SAFETY: a new mapping, never looked into.
        unsafe { rustix::mm::mmap(std::ptr::null_mut(), bytes, how, MapFlags::SHARED, memory, 0) }
    };
    let raised = map(ProtFlags::READ).and_then(|place| {
        // SAFETY: the mapping just made.
        unsafe { rustix::mm::mprotect(place, bytes, MprotectFlags::READ | MprotectFlags::WRITE) }
    });
    let hole = FallocateFlags::PUNCH_HOLE | FallocateFlags::KEEP_SIZE;
    [
        tried(&format!("{name}: map it for writing"), map(both)),
        tried(&format!("{name}: raise a mapping to writing"), raised),
        tried(&format!("{name}: write"), file.write_all(b"rubbish")),
        tried(&format!("{name}: pwrite"), rustix::io::pwrite(memory, b"rubbish", 0)),
        tried(&format!("{name}: cut it off"), rustix::fs::ftruncate(memory, 0)),
        tried(&format!("{name}: let it grow"), rustix::fs::ftruncate(memory, 2 * bytes as u64)),
        tried(&format!("{name}: punch a hole"), rustix::fs::fallocate(memory, hole, 0, 4096)),
        tried(&format!("{name}: seal it otherwise"), rustix::fs::fcntl_add_seals(memory, SealFlags::WRITE)),
    ]
    .iter()
    .sum()
}

fn files(path: &Path) -> usize {
    let name = path.display();
    let opened = tried(
        &format!("read {name}"),
        if path.is_dir() { std::fs::read_dir(path).map(drop) } else { File::open(path).map(drop) },
    ) + tried(
        &format!("write {name}"),
        if path.is_dir() {
            File::create(path.join("intruder")).map(drop)
        } else {
            OpenOptions::new().write(true).open(path).map(drop)
        },
    );
    let inside = std::fs::read_dir(path).into_iter().flatten().flatten();
    opened + inside.map(|entry| files(&entry.path())).sum::<usize>()
}

fn rubbish(path: &str, seconds: f64, seed: u64) -> usize {
    let mut random = SmallRng::seed_from_u64(seed);
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    let (mut doors, mut messages, mut shut) = (0, 0, 0);
    let flags = SendFlags::DONTWAIT | SendFlags::NOSIGNAL;
    while Instant::now() < end {
        let kept: Vec<OwnedFd> = (0..random.random_range(1..8)).filter_map(|_| enter(path).ok()).map(|e| e.0).collect();
        doors += kept.len();
        for _ in 0..random.random_range(1..200) {
            let Some(socket) = kept.get(random.random_range(0..kept.len().max(1))) else { break };
            let mut bytes = vec![0; if random.random_bool(0.5) { 56 } else { random.random_range(0..300) }];
            random.fill(&mut bytes[..]);
            if random.random_bool(0.8) && bytes.len() >= 56 {
                // A request in the right frame, with anything inside.
                bytes[..8].copy_from_slice(b"sinewask");
                bytes[8..16].fill(0xff);
                if random.random_bool(0.5) {
                    // Of a kind and for a channel there are.
                    bytes[32..36].copy_from_slice(&random.random_range(0..2u32).to_ne_bytes());
                    bytes[36..40].copy_from_slice(&random.random_range(0..7u32).to_ne_bytes());
                }
            }
            match rustix::net::send(socket, &bytes, flags) {
                Ok(_) => messages += 1,
                Err(Errno::AGAIN) => std::thread::sleep(Duration::from_millis(1)),
                Err(_) => shut += 1,
            }
        }
    }
    println!("rubbish {doors} {messages} {shut}");
    0
}

fn squat(folder: &str, rig: &str) -> usize {
    let socket = socket();
    let address = SocketAddrUnix::new(format!("{folder}/{rig}.sock")).expect("a short path");
    rustix::net::bind(&socket, &address).expect("a place");
    let door = format!("{folder}/{rig}.sock");
    std::fs::set_permissions(door, std::os::unix::fs::PermissionsExt::from_mode(0o777)).expect("his own");
    rustix::net::listen(&socket, 8).expect("a socket");
    println!("squatting");
    std::thread::sleep(Duration::from_secs(120));
    1
}

fn litter(folder: &Path, count: usize, prefix: &str, target: &str) -> usize {
    let mode = |mode| std::os::unix::fs::PermissionsExt::from_mode(mode);
    for number in 0..count {
        let path = folder.join(format!("{prefix}{number:05}.dynamic"));
        match number % 5 {
            0 => drop(File::create(&path).and_then(|_| std::fs::set_permissions(&path, mode(0)))),
            1 => drop(std::fs::write(&path, "rubbish")),
            2 => drop(std::fs::create_dir(&path).and_then(|()| std::fs::write(path.join("users"), "rubbish"))),
            3 => drop(std::os::unix::fs::symlink(target, &path)),
            _ => drop(rustix::fs::mknodat(
                rustix::fs::CWD,
                &path,
                rustix::fs::FileType::Fifo,
                rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR,
                0,
            )),
        }
    }
    println!("littered");
    let mut held: Vec<(std::path::PathBuf, File, Instant)> = Vec::new();
    let inode =
        |found: std::io::Result<std::fs::Metadata>| found.ok().map(|it| std::os::unix::fs::MetadataExt::ino(&it));
    loop {
        // What was opened while it was being made is worth something only if it stays what others use.
        held.retain(|(path, file, since)| {
            let is_used = inode(std::fs::metadata(path)) == inode(file.metadata());
            if is_used && since.elapsed() > Duration::from_secs(1) {
                println!("holds {}", path.display());
            }
            is_used
        });
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let is_own = |found: std::fs::Metadata| {
                std::os::unix::fs::MetadataExt::uid(&found) == rustix::process::geteuid().as_raw()
            };
            let is_theirs = entry.file_name().to_string_lossy().starts_with("sinew")
                && entry.file_type().is_ok_and(|kind| kind.is_file())
                && !entry.metadata().is_ok_and(is_own);
            if let Some(file) = is_theirs.then(|| File::open(entry.path()).ok()).flatten() {
                let _ = rustix::fs::flock(&file, rustix::fs::FlockOperation::NonBlockingLockExclusive);
                held.push((entry.path(), file, Instant::now()));
            }
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn take(path: &str) -> usize {
    std::fs::create_dir(path).expect("he is the first");
    std::fs::set_permissions(path, std::os::unix::fs::PermissionsExt::from_mode(0o777)).expect("his own");
    0
}

fn chase(seconds: f64) -> usize {
    const ENDS: [&str; 7] =
        ["dynamic", "data", "connection", "event", "event_mgmt", "blackboard_mgmt", "blackboard_data"];
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    // For every run the hashes of its services, which are told by the first file of each, and those of the runs before.
    let (mut runs, mut hashes) = (std::collections::BTreeSet::new(), std::collections::BTreeSet::new());
    let mut seen = std::collections::HashSet::new();
    let mut made = 0;
    println!("chasing");
    while Instant::now() < end {
        for entry in std::fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if !seen.insert(name.clone()) {
                continue;
            }
            let parts: Vec<&str> = name.split(['_', '.']).collect();
            let ["sinew", run, hash, ..] = parts[..] else { continue };
            runs.insert(run.to_string());
            let is_new = hashes.insert(hash.to_string());
            for hash in hashes.iter().filter(|one| !is_new || *one == hash || runs.len() > 1) {
                for end in ENDS {
                    let trap = format!("sinew_{run}_{hash}.{end}");
                    if seen.insert(trap.clone()) && File::create_new(Path::new("/dev/shm").join(trap)).is_ok() {
                        made += 1;
                    }
                }
            }
        }
    }
    println!("made {made}");
    0
}
