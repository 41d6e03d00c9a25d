//! How this crate uses iceoryx2: an instance of its own for each run of a driver, and the five services in it.
//!
//! Every run has its own prefix and root folder (see [`crate::run`]), so rigs and tests never see each other's nodes, looking
//! for dead ones stays cheap, and nothing left by a killed process can be in the way of another run. Dead clients are
//! cleared by the driver alone, on an ordinary thread, and not by whoever happens to open something.

use crate::{BatchHeader, ChannelState, Command, Error, Reply, RigLock, Terms};
use iceoryx2::node::Node;
use iceoryx2::port::client::Client as RequestPort;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::reader::{EntryHandle, Reader};
use iceoryx2::port::server::Server as ReplyPort;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::writer::{EntryHandleMut, Writer};
use iceoryx2::prelude::*;
use std::fmt::Debug;
use std::path::Path as FolderPath;

/// The variant of iceoryx2 whose ports may be shared between threads.
pub(crate) type Ipc = ipc_threadsafe::Service;
pub(crate) type IpcNode = Node<Ipc>;
pub(crate) type StateReader = Reader<Ipc, u64>;
pub(crate) type StatePort = Writer<Ipc, u64>;
pub(crate) type Entry<T> = EntryHandle<Ipc, u64, T>;
pub(crate) type EntryMut<T> = EntryHandleMut<Ipc, u64, T>;
pub(crate) type BatchPublisher = Publisher<Ipc, [ChannelState], BatchHeader>;
pub(crate) type BatchSubscriber = Subscriber<Ipc, [ChannelState], BatchHeader>;
pub(crate) type Batch = iceoryx2::sample::Sample<Ipc, [ChannelState], BatchHeader>;
pub(crate) type TickNotifier = Notifier<Ipc>;
pub(crate) type TickListener = Listener<Ipc>;
pub(crate) type Requests = RequestPort<Ipc, [Command], Terms, [Reply], ()>;
pub(crate) type Replies = ReplyPort<Ipc, [Command], Terms, [Reply], ()>;
pub(crate) type ActiveRequest = iceoryx2::active_request::ActiveRequest<Ipc, [Command], Terms, [Reply], ()>;
pub(crate) type PendingReplies = iceoryx2::pending_response::PendingResponse<Ipc, [Command], Terms, [Reply], ()>;

/// What must outlive every port: node first, then the hold on the rig's name, in the order they are dropped.
pub(crate) struct Run {
    pub(crate) node: IpcNode,
    pub(crate) lock: RigLock,
}

/// Keys of the blackboard.
pub(crate) const KEY_INFO: u64 = 0;
pub(crate) const KEY_SNAPSHOT: u64 = 1;
pub(crate) const KEY_STATS: u64 = 2;

/// Programs that may be connected at once.
pub(crate) const MAX_CLIENTS: usize = 256;
/// Streams that may be read at once.
pub(crate) const MAX_STREAMS: usize = 64;
/// Requests one client may have unanswered.
pub(crate) const MAX_ACTIVE_REQUESTS: usize = 16;

/// Wraps an error of iceoryx2.
pub(crate) fn failed<E: Debug>(what: &'static str) -> impl Fn(E) -> Error {
    move |e| Error::Service { what, reason: format!("{e:?}") }
}

/// The name of a service of the run with this key. The names of its files in `/dev/shm` are made of it, where anybody can see the run's, and
/// make files: what can be known before they are there is taken.
pub(crate) fn name(text: &'static str, key: &str) -> Result<ServiceName, Error> {
    ServiceName::new(&format!("{text}-{key}")).map_err(failed(text))
}

/// A node of the run's own iceoryx2 instance.
pub(crate) fn node(run: &str, run_dir: &FolderPath) -> Result<IpcNode, Error> {
    quiet();
    let wrong = |reason: String| Error::RuntimeDir { path: run_dir.to_path_buf(), reason };
    let mut config = Config::default();
    config.global.prefix = FileName::new(crate::run::prefix(run).as_bytes()).map_err(|e| wrong(format!("{e:?}")))?;
    let root = run_dir.to_str().ok_or_else(|| wrong("it is not UTF-8".into()))?;
    config.global.set_root_path(&Path::new(root.as_bytes()).map_err(|e| wrong(format!("{e:?}")))?);
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    NodeBuilder::new()
        .config(&config)
        // Signals are the program's business, not this library's.
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<Ipc>()
        .map_err(failed("node"))
}

/// Only errors of iceoryx2's are worth a line on a robot program's stderr; what matters of the rest comes back as [`Error`].
fn quiet() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| set_log_level(LogLevel::Error));
}
