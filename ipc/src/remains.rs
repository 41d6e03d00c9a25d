//! What clients that are killed in the middle of something leave behind, and iceoryx2 (0.10) does not clear away with their nodes: it does
//! not know of it, or waits without end for it to be finished.

use std::collections::{BTreeSet, HashMap};
use std::fs::{self, Metadata};
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What belongs to a port, by the ends of its files' names: memory of its messages, of a connection of two of them, of an event, and the
/// event's socket.
const OF_PORTS: [&str; 4] = ["data", "connection", "event_mgmt", "event"];

/// Since when something has been as it is, as far as somebody looked.
#[derive(Debug, Default)]
pub(crate) struct Since(HashMap<PathBuf, Instant>);

impl Since {
    /// Which of those found now have been found for so long, every time.
    pub fn longer_than(&mut self, age: Duration, found: Vec<PathBuf>) -> Vec<PathBuf> {
        let now = Instant::now();
        self.0 = found.into_iter().map(|path| (path.clone(), self.0.get(&path).copied().unwrap_or(now))).collect();
        let old = self.0.iter().filter(|(_, since)| now.duration_since(**since) > age);
        old.map(|(path, _)| path.clone()).collect()
    }
}

/// Shared memory that is not finished: without a size, or not yet readable. Whoever opens one without a size waits for it to get one, in
/// iceoryx2 without end: the driver's own threads, and the clearing of the node that made it.
pub(crate) fn half_made(mut shared_memory: Vec<PathBuf>) -> Vec<PathBuf> {
    let is_half_made = |file: Metadata| file.len() == 0 || file.permissions().mode() & 0o400 == 0;
    shared_memory.retain(|path| fs::metadata(path).is_ok_and(is_half_made));
    shared_memory
}

/// Those of `files` that belong to a port nobody has marked as his. A port's mark is the first that is made of it and the last that is
/// removed; its connection has two. A client that dies between the making of a connection and its own entry there leaves one that
/// iceoryx2 takes for somebody else's.
pub(crate) fn unmarked(mut files: Vec<PathBuf>, prefix: &str, nodes: &Path) -> Vec<PathBuf> {
    // Read after the files were: what has been made since then is not among them.
    let Ok(marks) = marks(nodes, prefix) else { return Vec::new() };
    files.retain(|path| ports(path, prefix).iter().any(|port| !marks.contains(port)));
    files
}

/// All ports that are marked. All or an error: a mark that could not be read (no descriptor left) would make a living port nobody's.
fn marks(nodes: &Path, prefix: &str) -> io::Result<BTreeSet<u128>> {
    let mut marks = BTreeSet::new();
    for home in fs::read_dir(nodes)? {
        let home = home?;
        if !home.file_type()?.is_dir() {
            continue;
        }
        let entries = match fs::read_dir(home.path()) {
            Ok(entries) => entries,
            // Its node has gone meanwhile.
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            Err(error) => return Err(error),
        };
        for mark in entries {
            marks.extend(mark_of(&mark?.path(), prefix));
        }
    }
    Ok(marks)
}

/// The ports a file belongs to: `PREFIX[HASH_]PORT[_PORT].END`.
fn ports(path: &Path, prefix: &str) -> Vec<u128> {
    if !path.extension().and_then(|end| end.to_str()).is_some_and(|end| OF_PORTS.contains(&end)) {
        return Vec::new();
    }
    let name = path.file_stem().and_then(|name| name.to_str()).and_then(|name| name.strip_prefix(prefix));
    // A hash has forty hexadecimal digits: more than a number of 128 bits.
    name.into_iter().flat_map(|name| name.split('_')).filter_map(|part| part.parse().ok()).collect()
}

/// The port a file marks.
fn mark_of(path: &Path, prefix: &str) -> Option<u128> {
    path.file_name()?.to_str()?.strip_prefix(prefix)?.strip_suffix(".port_tag")?.parse().ok()
}

/// Removes what a client that is killed in the moment in which it writes a mark of itself (a tag of a service it opens, of a port) leaves: a
/// file that is not finished, still writable. iceoryx2 does not see such a file, cannot remove the node's folder for it, and does not
/// know the node any more from then on, whose place stays taken. The mark comes before what it marks, so it stands for nothing.
pub(crate) fn remove_unfinished(home: &Path) {
    for path in entries(home) {
        let unfinished = |file: Metadata| file.is_file() && file.permissions().mode() & 0o200 != 0;
        if fs::metadata(&path).is_ok_and(unfinished) {
            let _ = fs::remove_file(path);
        }
    }
}

/// What there is of nodes that iceoryx2 does not list, by their folders: those that died before they had a monitor, or without it.
pub(crate) fn unlisted(nodes: &Path, prefix: &str, listed: &BTreeSet<u128>) -> Vec<PathBuf> {
    let id = |path: &PathBuf| -> Option<u128> {
        let name = path.file_name()?.to_str()?;
        let name = name.strip_prefix(prefix).map_or(name, |file| file.split('.').next().unwrap_or(file));
        name.parse().ok()
    };
    let ids: BTreeSet<u128> = entries(nodes).iter().filter_map(id).collect();
    ids.difference(listed).map(|id| nodes.join(id.to_string())).collect()
}

/// Removes what is left of a node that died before it had said anything of itself, or after it had taken that back: its details and its
/// monitor. With marks in its folder it still owns something, and stays.
pub(crate) fn remove_rest(nodes: &Path, home: &Path, prefix: &str) {
    let details = |path: &PathBuf| path.extension().is_some_and(|end| end == "details");
    let all = entries(home);
    if !all.iter().all(details) {
        return;
    }
    for path in all {
        let _ = fs::remove_file(path);
    }
    if fs::remove_dir(home).is_err_and(|e| e.kind() != io::ErrorKind::NotFound) {
        return;
    }
    let Some(id) = home.file_name().and_then(|id| id.to_str()) else { return };
    let prefix = format!("{prefix}{id}.");
    for path in entries(nodes) {
        if path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(&prefix)) {
            let _ = fs::remove_file(path);
        }
    }
}

/// What is in a folder, as far as it can be read.
pub(crate) fn entries(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PREFIX: &str = "sinew_abc_";
    const HASH: &str = "b9fc73e5c1f646968758453273c6c65cb372831b";

    fn file(folder: &Path, name: String) -> PathBuf {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "x").unwrap();
        path
    }

    #[test]
    fn what_comes_and_goes_is_never_old() {
        let mut since = Since::default();
        let (a, b) = (PathBuf::from("/a"), PathBuf::from("/b"));
        assert!(since.longer_than(Duration::from_millis(20), vec![a.clone(), b.clone()]).is_empty());
        std::thread::sleep(Duration::from_millis(30));
        assert!(since.longer_than(Duration::from_millis(20), vec![]).is_empty());
        assert!(since.longer_than(Duration::from_millis(20), vec![a.clone()]).is_empty());
        std::thread::sleep(Duration::from_millis(30));
        assert_eq!(since.longer_than(Duration::from_millis(20), vec![a.clone(), b]), [a]);
    }

    #[test]
    fn a_connection_is_somebodys_as_long_as_both_its_ports_are_marked() {
        let folder = tempfile::tempdir().unwrap();
        let nodes = folder.path().join("nodes");
        file(&nodes, format!("1/{PREFIX}77.port_tag"));
        let mark = file(&nodes, format!("2/{PREFIX}88.port_tag"));
        let shared: Vec<PathBuf> = [
            format!("{PREFIX}{HASH}_77_88.connection"),
            format!("{PREFIX}{HASH}_77.data"),
            format!("{PREFIX}{HASH}_88.event_mgmt"),
            format!("{PREFIX}88.event"),
            // Of services, which have no mark, of others, and of no port.
            format!("{PREFIX}{HASH}_99.dynamic"),
            format!("sinew_other_{HASH}_99.data"),
            format!("{PREFIX}{HASH}.data"),
        ]
        .map(|name| folder.path().join(name))
        .into();
        assert_eq!(unmarked(shared.clone(), PREFIX, &nodes), Vec::<PathBuf>::new());
        // Nothing is nobody's as long as not every mark could be read.
        assert_eq!(unmarked(shared.clone(), PREFIX, &folder.path().join("elsewhere")), Vec::<PathBuf>::new());
        fs::remove_file(mark).unwrap();
        assert_eq!(unmarked(shared.clone(), PREFIX, &nodes), [&shared[0], &shared[2], &shared[3]].map(Clone::clone));
    }

    #[test]
    fn nodes_nobody_lists_go_unless_they_still_own_something() {
        let folder = tempfile::tempdir().unwrap();
        let nodes = folder.path();
        // Alive; died before its monitor, in the middle of it, and after it; dead with a mark that is left.
        file(nodes, format!("1/{PREFIX}node.details"));
        file(nodes, format!("{PREFIX}1.node_monitor"));
        file(nodes, format!("2/{PREFIX}node.details"));
        file(nodes, format!("3/{PREFIX}node.details"));
        file(nodes, format!("{PREFIX}3.node_monitor_context"));
        file(nodes, format!("{PREFIX}4.node_monitor_owner_lock"));
        file(nodes, format!("5/{PREFIX}77.port_tag"));
        fs::create_dir(nodes.join("6")).unwrap();
        let found = unlisted(nodes, PREFIX, &BTreeSet::from([1]));
        assert_eq!(found, ["2", "3", "4", "5", "6"].map(|id| nodes.join(id)));
        for home in found {
            remove_rest(nodes, &home, PREFIX);
        }
        let left: BTreeSet<PathBuf> = entries(nodes).into_iter().collect();
        let stay = ["1".to_string(), format!("{PREFIX}1.node_monitor"), "5".to_string()];
        assert_eq!(left, stay.iter().map(|name| nodes.join(name)).collect());
    }
}
