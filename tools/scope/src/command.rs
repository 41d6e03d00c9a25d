//! What a page may ask of the driver and of the recorder.

use std::sync::PoisonError;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use sinew_ipc::{ALL_CHANNELS, CommandKind};
use tokio::sync::mpsc::OwnedPermit;

use crate::shared::{Shared, Way};
use sinew_server::Refusal;

/// Longest lease a page may ask for: it renews what it holds several times a second, so a page that is closed, or whose
/// computer sleeps, lets go within this time.
const LONGEST_HOLD: Duration = Duration::from_secs(3);

/// One request.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// A setpoint for so long: `length` in m, `stroke` 0..1, `duty` 0..1, `force` in N, `off`.
    Set { channel: u32, kind: Kind, value: f64, hold_s: f64 },
    /// Clear a channel's latched fault.
    Reset { channel: u32 },
    /// All channels off.
    AllOff,
    /// Start or end a recording.
    Record { on: bool },
}

/// Kinds of setpoint.
#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Length,
    Stroke,
    Duty,
    Force,
    Off,
}

/// What became of it.
#[derive(Serialize)]
pub struct Answer {
    kind: &'static str,
    id: u32,
    ok: bool,
    /// What was done, or why not and what to do.
    message: String,
}

impl Answer {
    /// To a page that has too many without an answer yet.
    pub fn too_many(id: u32) -> Answer {
        Answer { kind: "answer", id, ok: false, message: Refusal::RequestsUnanswered.words().into() }
    }
}

/// Does what was asked for, and puts what became of it into the place kept for it. The driver's answer is waited for elsewhere.
pub fn ask(way: &Way, may_command: bool, id: u32, what: Request, place: OwnedPermit<Answer>) {
    let answer = move |done: Result<String, String>| {
        let (ok, message) = match done {
            Ok(message) => (true, message),
            Err(message) => (false, message),
        };
        place.send(Answer { kind: "answer", id, ok, message });
    };
    if !may_command {
        way.entrance.traffic.refuse(Refusal::CommandsWithoutToken);
        let why = match &way.entrance.lock {
            _ if !way.shared.options.commands => "this scope only watches: it was started with --no-commands",
            None => "this page may only watch: open the address with the token that `sinew scope` printed",
            Some(_) => "pages on the network may only watch: the scope was started without --lan-commands",
        };
        return answer(Err(why.into()));
    }
    let shared = way.shared.clone();
    tokio::task::spawn_blocking(move || answer(carry_out(&shared, what)));
}

fn carry_out(shared: &Shared, what: Request) -> Result<String, String> {
    let client = shared.view().client.clone().ok_or("there is no driver to command");
    let (channel, kind, value, hold) = match what {
        Request::Record { on } => {
            let mut recorder = shared.recorder.lock().unwrap_or_else(PoisonError::into_inner);
            return if on { recorder.start() } else { recorder.stop() };
        }
        Request::Set { channel, kind, value, hold_s } => {
            let hold = Duration::try_from_secs_f64(hold_s).map_err(|_| "a hold is a number of seconds above 0")?;
            let hold = hold.clamp(Duration::from_millis(100), LONGEST_HOLD);
            match kind {
                Kind::Length => (channel, CommandKind::Length, value, hold),
                Kind::Stroke => (channel, CommandKind::Stroke, value, hold),
                Kind::Duty => (channel, CommandKind::Duty, value, hold),
                Kind::Force => (channel, CommandKind::Force, value, hold),
                // off holds until the next command
                Kind::Off => (channel, CommandKind::Off, 0.0, Duration::ZERO),
            }
        }
        Request::Reset { channel } => (channel, CommandKind::Reset, 0.0, Duration::ZERO),
        Request::AllOff => (ALL_CHANNELS, CommandKind::Off, 0.0, Duration::ZERO),
    };
    let client = client?;
    let name = client.channels().get(channel as usize).map_or("all channels", |info| info.name.as_str());
    client.command(channel, kind, value, hold).map(|_| format!("{name}: {}", kind.name())).map_err(|error| {
        let (message, remedy) = (error.message(), error.remedy());
        if remedy.is_empty() { message } else { format!("{message}; {remedy}") }
    })
}
