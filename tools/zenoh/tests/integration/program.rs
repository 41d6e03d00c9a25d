//! The program itself: what it refuses, where it listens, and that it ends when it cannot do its work.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use sinew_tests::{Driver, Rig, checkout, wait_until};
use sinew_threads::{STRIKE_FILE, Thread};

use crate::world::{bridge, bridge_by, certificates, free_port, program, run};

/// Sockets of this process: of which kind, and where.
fn sockets(pid: u32) -> Vec<(&'static str, String)> {
    let links = fs::read_dir(format!("/proc/{pid}/fd")).expect("it runs").flatten();
    let inodes: Vec<String> = links
        .filter_map(|entry| fs::read_link(entry.path()).ok())
        .filter_map(|to| Some(to.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.to_string()))
        .collect();
    let of = |kind: &'static str| {
        let table = fs::read_to_string(format!("/proc/{pid}/net/{kind}")).unwrap_or_default();
        let rows: Vec<(String, String)> = table
            .lines()
            .skip(1)
            .map(|line| line.split_whitespace().collect::<Vec<_>>())
            .map(|cells| (cells[1].to_string(), cells[9].to_string()))
            .collect();
        rows.into_iter().filter(|(_, inode)| inodes.contains(inode)).map(move |(at, _)| (kind, at)).collect::<Vec<_>>()
    };
    ["tcp", "tcp6", "udp", "udp6"].into_iter().flat_map(of).collect()
}

#[test]
fn a_bridge_listens_at_one_place_and_looks_for_nobody_and_a_driver_has_no_socket() {
    let rig = Rig::bench(&["left"], "");
    let driver = Driver::start(&rig);
    let (bridge, endpoint) = bridge(&rig, &[]);
    let port: u16 = endpoint.rsplit(':').next().expect("a port").parse().expect("a number");
    wait_until("the bridge to be at work", || bridge.resources().threads > 3);
    // 127.0.0.1 as the kernel writes it
    assert_eq!(sockets(bridge.pid()), [("tcp", format!("0100007F:{port:04X}"))]);
    assert_eq!(sockets(driver.pid()), []);
    bridge.signal(libc::SIGTERM);
    bridge.finish().expect(0);
    driver.stop();
}

#[test]
fn what_cannot_be_is_refused_with_a_remedy() {
    let rig = Rig::bench(&["left"], "");
    let taken = format!("127.0.0.1:{}", free_port());
    let mut other = sinew_tests::Process::start(program().args(["--rig", &rig.name, "--listen", &taken]));
    other.wait_for_word("\n");
    run(&["--rig", &rig.name, "--listen", &taken]).refused(&[&taken, "--listen"]);
    run(&["--rig", &rig.name, "--listen", "127.0.0.1:0"]).refused(&["no port"]);
    run(&["--rig", "no such rig"]).refused(&["no such rig"]);
    for bad in [&["--listen", "nowhere"][..], &["--rate", "0"], &["--for", "-1"], &["--commander"]] {
        assert_eq!(run(bad).code, Some(2), "{bad:?}");
    }
    let help = run(&["--help"]).expect(0);
    assert!(help.stdout.contains("Examples:") && help.stdout.contains("--commander"), "{help:?}");
    // files of another authority, or none
    let folder = certificates(&rig, "keys", &["anna"]);
    let path = folder.to_str().expect("a plain path");
    run(&["certificates", path, "anna"]).refused(&["anna", "already"]);
    run(&["certificates", path, "a/b"]).refused(&["a/b"]);
    fs::write(folder.join("bridge.key"), "nonsense").expect("ours");
    let listen = format!("127.0.0.1:{}", free_port());
    run(&["--rig", &rig.name, "--listen", &listen, "--certificates", path])
        .refused(&["cannot be listened at", "authority"]);
    other.kill();
}

#[test]
fn a_bridge_whose_watcher_dies_ends() {
    if !cfg!(debug_assertions) {
        eprintln!("skipped: this program was built without debug assertions, and its threads cannot be struck");
        return;
    }
    let rig = Rig::bench(&["left"], "");
    let driver = Driver::start(&rig);
    for way in ["panic", "end"] {
        let file = rig.file("strike");
        let _ = fs::remove_file(&file);
        let (bridge, _) = bridge_by(program().env(STRIKE_FILE, &file), &rig, &[]);
        fs::write(rig.file("part"), format!("{} {way}\n", Thread::Watcher.row().name)).expect("ours");
        fs::rename(rig.file("part"), &file).expect("ours");
        let finished = bridge.finish().expect(1);
        assert!(finished.stderr.contains("watches the driver"), "{finished:?}");
    }
    driver.stop();
}

/// Driver and bridge share memory by iceoryx2, so both need the same.
#[test]
fn the_lock_files_have_the_same_iceoryx2() {
    let versions = |lock: &Path| {
        let text = fs::read_to_string(lock).unwrap_or_else(|e| panic!("{}: {e}", lock.display()));
        let lines: Vec<&str> = text.lines().collect();
        let named = lines.windows(2).filter(|pair| pair[0].starts_with("name = \"iceoryx2"));
        named.map(|pair| (pair[0].to_string(), pair[1].to_string())).collect::<BTreeMap<_, _>>()
    };
    let ours = versions(&Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.lock"));
    assert!(!ours.is_empty());
    assert_eq!(ours, versions(&checkout().join("Cargo.lock")));
}
