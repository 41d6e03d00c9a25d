//! The bridge: a session of Zenoh, the thread that watches the driver, and the desk.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use sinew_bridge::Finder;
use sinew_bridge::watch::{latest_cycle, latest_figures, watch};
use sinew_ipc::Client;
use sinew_recording::session::{CYCLES, LOOP};
use sinew_threads::Thread;
use zenoh::bytes::Encoding;
use zenoh::query::Query;
use zenoh::{Session, Wait};

use crate::certificates::Certificates;
use crate::desk::Desk;
use crate::failure::{Failure, Outcome};
use crate::keys::is_name;
use crate::settings::{endpoint, settings};
use crate::stage::{Board, Stage, cdr};
use crate::station::{Station, channel};

/// The longest the main thread waits before it looks around.
const LOOK: Duration = Duration::from_millis(20);

/// What the bridge is told.
#[derive(Debug, Clone)]
pub struct Options {
    /// The rig whose driver is watched, through all its restarts.
    pub rig: String,
    /// Where to listen.
    pub listen: SocketAddr,
    /// Folder of certificates: then links are QUIC, and for those alone who have one.
    pub certificates: Option<PathBuf>,
    /// Whose certificates may command.
    pub commanders: Vec<String>,
    /// At most so many cycles a second, Hz.
    pub rate_hz: Option<f64>,
}

/// A bridge that listens.
pub struct Bridge {
    station: Arc<Station>,
    session: Session,
    finder: Finder,
    stage: Stage,
    board: Board,
    desk: Desk,
    endpoint: String,
    rate_hz: Option<f64>,
}

impl Bridge {
    /// Checks what it is told, and listens.
    ///
    /// # Errors
    /// Names that are none, commanders without certificates, an address that cannot be had.
    pub fn open(options: &Options) -> Result<Bridge, Failure> {
        let Options { rig, listen, certificates, commanders, rate_hz } = options;
        let finder = Finder::new(rig)?;
        if let Some(bad) = commanders.iter().find(|name| !is_name(name)) {
            return Err(Failure::input(format_args!("--commander {bad}: no name of a certificate"))
                .hint("it is the name that `sinew-zenoh certificates` was given"));
        }
        if certificates.is_none() && !commanders.is_empty() {
            return Err(Failure::input("commands are taken over TLS alone, by who has a certificate").hint(
                format_args!(
                    "make some with `sinew-zenoh certificates FOLDER {}`, then give --certificates FOLDER",
                    commanders.join(" ")
                ),
            ));
        }
        if listen.port() == 0 {
            return Err(
                Failure::input(format_args!("--listen {listen}: no port")).hint("name one; Zenoh's usual one is 7447")
            );
        }
        let certificates = certificates.as_deref().map(Certificates::open).transpose()?;
        let station = Arc::new(Station::new(rig));
        let settings = settings(&station.keys, *listen, certificates.as_ref(), commanders)?;
        let endpoint = endpoint(*listen, certificates.as_ref());
        let session = zenoh::open(settings).wait().map_err(|error| {
            // behind it stand places in Zenoh's sources
            let error = error.to_string();
            let reason = error.split(" at /").next().unwrap_or_default();
            Failure::input(format_args!("{endpoint} cannot be listened at: {reason}"))
                .hint("choose another address with --listen; with --certificates, see that the files are those of one authority")
        })?;
        answer_looks(&session, &station)?;
        let stage = Stage::open(&session, station.clone())?;
        let board = Board::open(&session, station.clone())?;
        let desk = Desk::open(&session, station.clone(), commanders)?;
        Ok(Bridge { station, session, finder, stage, board, desk, endpoint, rate_hz: *rate_hz })
    }

    /// Where it listens, as Zenoh writes it.
    pub fn endpoint(&self) -> &str {
        &self.endpoint
    }

    /// How it does, to be read at any time.
    pub fn station(&self) -> Arc<Station> {
        self.station.clone()
    }

    /// Serves until `stop` says so; then everything that commanders hold is put off.
    ///
    /// # Errors
    /// No thread is to be had, or the one that watches has died.
    pub fn serve(self, stop: impl Fn() -> bool) -> Outcome {
        let Bridge { station, session, finder, mut stage, mut board, mut desk, rate_hz, .. } = self;
        let watcher = {
            let over = station.clone();
            let start = Thread::Watcher.start().ends_when(move || over.is_over());
            let watching = start.spawn(move || watch(&mut stage, finder, rate_hz));
            watching.map_err(|error| Failure::own(format_args!("no thread is to be had: {error}")))?
        };
        let mut looked = Ok(());
        while looked.is_ok() && !stop() && !watcher.is_finished() {
            desk.serve(LOOK);
            looked = board.look(&session);
        }
        // first: the rest may take its time
        desk.close();
        station.stop.store(true, Ordering::Relaxed);
        let is_watched = watcher.join().is_ok_and(|watched| watched.is_some());
        if let Err(error) = session.close().wait() {
            tracing::debug!("the session ends with {error}");
        }
        looked?;
        let died = || {
            let words = format!("the thread that {} has died", Thread::Watcher.row().does);
            Failure::own(words).hint("start it again, and please report this")
        };
        is_watched.then_some(()).ok_or_else(died)
    }
}

/// Answers who wants to know how it is now. Nothing here waits: the latest state is copied out of shared memory.
fn answer_looks(session: &Session, station: &Arc<Station>) -> Outcome {
    let keys = &station.keys;
    type Make = fn(&Station) -> Option<Vec<u8>>;
    fn of(station: &Station, make: impl Fn(&Client) -> Vec<u8>) -> Option<Vec<u8>> {
        station.client().map(|client| make(&client))
    }
    let answers: [(String, Encoding, Make); 4] = [
        (keys.info(), Encoding::APPLICATION_JSON, |station| Some(station.info().to_string().into_bytes())),
        (keys.bridge(), Encoding::APPLICATION_JSON, |station| Some(station.figures().to_string().into_bytes())),
        (keys.topic(CYCLES), cdr(CYCLES), |station| of(station, latest_cycle)),
        (keys.topic(LOOP), cdr(LOOP), |station| of(station, |client| latest_figures(client).encode())),
    ];
    for (key, encoding, make) in answers {
        let station = station.clone();
        let asked = move |query: Query| match make(&station) {
            Some(message) => sent(query.reply(query.key_expr().clone(), message).encoding(encoding.clone()).wait()),
            None => sent(query.reply_err(format!("no driver of {} runs", station.rig)).wait()),
        };
        let queryable = session.declare_queryable(key.clone()).complete(true).callback(asked);
        queryable.background().wait().map_err(|error| Failure::own(format_args!("{key}: {error}")))?;
    }

    let (key, station) = (keys.channel("*"), station.clone());
    let asked = move |query: Query| {
        let Some(client) = station.client() else {
            return sent(query.reply_err(format!("no driver of {} runs", station.rig)).wait());
        };
        for (number, info) in client.channels().iter().enumerate() {
            let Ok(key) = zenoh::key_expr::KeyExpr::try_from(station.keys.channel(info.name.as_str())) else {
                continue;
            };
            if let (true, Some(state)) = (query.key_expr().intersects(&key), channel(&client, number)) {
                sent(query.reply(key, state.to_string()).encoding(Encoding::APPLICATION_JSON).wait());
            }
        }
    };
    let queryable = session.declare_queryable(key.clone()).complete(true).callback(asked);
    queryable.background().wait().map_err(|error| Failure::own(format_args!("{key}: {error}")))
}

fn sent(sent: zenoh::Result<()>) {
    if let Err(error) = sent {
        tracing::debug!("an answer is lost: {error}");
    }
}
