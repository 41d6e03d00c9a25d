//! The tree as a file system in user space: each look at a file asks the simulated kernel.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use fuser::{
    BsdFileFlags, Errno, FileAttr, FileHandle, FileType, Filesystem, FopenFlags, Generation, INodeNo, LockOwner,
    OpenFlags, ReplyAttr, ReplyData, ReplyDirectory, ReplyEmpty, ReplyEntry, ReplyOpen, ReplyWrite, Request, TimeOrNow,
    WriteFlags,
};

use crate::kernel::{Kernel, Node};

/// Nothing may be kept: every look counts.
const NOT_KEPT: Duration = Duration::ZERO;

/// The file system; paths get their inode when they are first looked up.
pub(crate) struct Files {
    pub kernel: Arc<Mutex<Kernel>>,
    pub inodes: Mutex<Inodes>,
}

#[derive(Default)]
pub(crate) struct Inodes {
    paths: Vec<String>,
    numbers: HashMap<String, u64>,
}

impl Inodes {
    fn number(&mut self, path: &str) -> u64 {
        if path.is_empty() {
            return 1;
        }
        if let Some(number) = self.numbers.get(path) {
            return *number;
        }
        self.paths.push(path.into());
        let number = self.paths.len() as u64 + 1;
        self.numbers.insert(path.into(), number);
        number
    }

    fn path(&self, inode: INodeNo) -> String {
        let number = u64::from(inode);
        number.checked_sub(2).and_then(|index| self.paths.get(index as usize)).cloned().unwrap_or_default()
    }
}

impl Files {
    fn kernel(&self) -> std::sync::MutexGuard<'_, Kernel> {
        self.kernel.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn path(&self, inode: INodeNo) -> String {
        self.inodes.lock().unwrap_or_else(PoisonError::into_inner).path(inode)
    }

    fn attributes(&self, path: &str) -> Option<FileAttr> {
        let node = self.kernel().node(path)?;
        let number = self.inodes.lock().unwrap_or_else(PoisonError::into_inner).number(path);
        let (kind, perm, size) = match &node {
            Node::Folder(_) => (FileType::Directory, 0o755, 0),
            Node::Link(target) => (FileType::Symlink, 0o777, target.len() as u64),
            // as in sysfs, whatever it says
            Node::File | Node::Device(_) => (FileType::RegularFile, 0o644, 4096),
        };
        Some(FileAttr {
            ino: INodeNo(number),
            size,
            blocks: 0,
            atime: UNIX_EPOCH,
            mtime: UNIX_EPOCH,
            ctime: UNIX_EPOCH,
            crtime: UNIX_EPOCH,
            kind,
            perm,
            nlink: 1,
            uid: 0,
            gid: 0,
            rdev: 0,
            blksize: 4096,
            flags: 0,
        })
    }
}

impl Filesystem for Files {
    fn lookup(&self, _: &Request, parent: INodeNo, name: &OsStr, reply: ReplyEntry) {
        let folder = self.path(parent);
        let name = name.to_str().unwrap_or_default();
        let path = if folder.is_empty() { name.to_string() } else { format!("{folder}/{name}") };
        match self.attributes(&path) {
            Some(attributes) => reply.entry(&NOT_KEPT, &attributes, Generation(0)),
            None => reply.error(Errno::ENOENT),
        }
    }

    fn getattr(&self, _: &Request, inode: INodeNo, _: Option<FileHandle>, reply: ReplyAttr) {
        match self.attributes(&self.path(inode)) {
            Some(attributes) => reply.attr(&NOT_KEPT, &attributes),
            None => reply.error(Errno::ENOENT),
        }
    }

    // Shells truncate before they write; sysfs takes no notice.
    fn setattr(
        &self,
        _: &Request,
        inode: INodeNo,
        _: Option<u32>,
        _: Option<u32>,
        _: Option<u32>,
        _: Option<u64>,
        _: Option<TimeOrNow>,
        _: Option<TimeOrNow>,
        _: Option<SystemTime>,
        _: Option<FileHandle>,
        _: Option<SystemTime>,
        _: Option<SystemTime>,
        _: Option<SystemTime>,
        _: Option<BsdFileFlags>,
        reply: ReplyAttr,
    ) {
        match self.attributes(&self.path(inode)) {
            Some(attributes) => reply.attr(&NOT_KEPT, &attributes),
            None => reply.error(Errno::ENOENT),
        }
    }

    fn readlink(&self, _: &Request, inode: INodeNo, reply: ReplyData) {
        match self.kernel().node(&self.path(inode)) {
            Some(Node::Link(target)) => reply.data(target.as_bytes()),
            _ => reply.error(Errno::EINVAL),
        }
    }

    fn readdir(&self, _: &Request, inode: INodeNo, _: FileHandle, offset: u64, mut reply: ReplyDirectory) {
        let path = self.path(inode);
        let Some(Node::Folder(names)) = self.kernel().node(&path) else { return reply.error(Errno::ENOTDIR) };
        for (index, name) in names.iter().enumerate().skip(offset as usize) {
            let below = if path.is_empty() { name.clone() } else { format!("{path}/{name}") };
            if let Some(attributes) = self.attributes(&below)
                && reply.add(attributes.ino, index as u64 + 1, attributes.kind, name)
            {
                break;
            }
        }
        reply.ok();
    }

    fn open(&self, _: &Request, inode: INodeNo, _: OpenFlags, reply: ReplyOpen) {
        let opened = self.kernel().open(&self.path(inode));
        match opened {
            Ok(handle) => reply.opened(FileHandle(handle), FopenFlags::FOPEN_DIRECT_IO),
            Err(errno) => reply.error(errno),
        }
    }

    fn release(
        &self,
        _: &Request,
        inode: INodeNo,
        handle: FileHandle,
        _: OpenFlags,
        _: Option<LockOwner>,
        _: bool,
        reply: ReplyEmpty,
    ) {
        self.kernel().close(&self.path(inode), handle.0);
        reply.ok();
    }

    fn read(
        &self,
        _: &Request,
        inode: INodeNo,
        handle: FileHandle,
        offset: u64,
        size: u32,
        _: OpenFlags,
        _: Option<LockOwner>,
        reply: ReplyData,
    ) {
        let read = self.kernel().read(&self.path(inode), handle.0, offset as usize, size as usize);
        match read {
            Ok(bytes) => reply.data(&bytes),
            Err(errno) => reply.error(errno),
        }
    }

    fn write(
        &self,
        _: &Request,
        inode: INodeNo,
        handle: FileHandle,
        _: u64,
        data: &[u8],
        _: WriteFlags,
        _: OpenFlags,
        _: Option<LockOwner>,
        reply: ReplyWrite,
    ) {
        let text = String::from_utf8_lossy(data);
        // sysfs forgives one newline
        let text = text.strip_suffix('\n').unwrap_or(&text);
        let written = self.kernel().write(&self.path(inode), handle.0, text);
        match written {
            Ok(()) => reply.written(data.len() as u32),
            Err(errno) => reply.error(errno),
        }
    }
}
