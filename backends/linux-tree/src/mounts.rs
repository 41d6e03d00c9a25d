//! Unmounting for good: a process with an open file keeps that file only, and mounts left by a killed process
//! are removed by the next one.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use rustix::io::Errno;
use rustix::mount::{UnmountFlags, unmount};

/// What a tree's mount is called in the table of mounts, before the id of its process.
const NAME: &str = "sinew-linux-tree-";

/// The name of this process's mounts.
pub(crate) fn name() -> String {
    format!("{NAME}{}", std::process::id())
}

/// Takes a mount away, whoever still has files open in it. Without the right to, nothing happens.
pub(crate) fn take_away(root: &Path) {
    let _ = unmount(root, UnmountFlags::DETACH);
}

/// Takes away the mounts of trees whose process is gone.
pub(crate) fn clear() -> io::Result<()> {
    for root in left_behind(&fs::read_to_string("/proc/self/mounts")?) {
        // A process of another namespace has no folder in our `/proc`, but its tree answers.
        if rustix::fs::stat(&root).is_err_and(|errno| errno == Errno::NOTCONN) {
            take_away(&root);
        }
    }
    Ok(())
}

/// Where a table of mounts has trees of processes that are no more.
fn left_behind(table: &str) -> Vec<PathBuf> {
    let root = |line: &str| {
        let mut words = line.split(' ');
        let id: u32 = words.next()?.strip_prefix(NAME)?.parse().ok()?;
        let alive = Path::new("/proc").join(id.to_string()).exists();
        // Blanks and the like are written as their octal code; a tree with such a name stays.
        words.next().filter(|root| !alive && !root.contains('\\')).map(PathBuf::from)
    };
    table.lines().filter_map(root).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_trees_of_the_dead_are_left_behind() {
        let alive = std::process::id();
        // Larger than any process id of Linux.
        let table = format!(
            "/dev/vda / ext4 rw 0 0\n{NAME}{alive} /tmp/alive fuse rw 0 0\n{NAME}4194305 /tmp/dead fuse rw 0 0\n\
             {NAME}4194305 /tmp/with\\040blank fuse rw 0 0\n{NAME}x /tmp/x fuse rw 0 0\nsinew-linux-tree\n\n"
        );
        assert_eq!(left_behind(&table), [Path::new("/tmp/dead")]);
    }
}
