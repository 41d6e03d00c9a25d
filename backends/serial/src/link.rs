//! Identifies the front-end on a line and configures it.

use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use sinew_front_end::{
    Decoder, Error as FrameError, Frame, Identification, MAX_BODY, MAX_FRAME, Refusal, VERSION, decode, encode,
    encode_hello,
};

use crate::error::Error;
use crate::plan::{Plan, Scale, name};
use crate::port::Port;

/// How long a front-end may take to answer, all in all, and after how long it is asked again.
const PATIENCE: Duration = Duration::from_millis(1000);
const ASK_AGAIN: Duration = Duration::from_millis(100);
/// How long a line may be another process's before that is an error, and after how long it is tried again.
const LET_GO: Duration = Duration::from_millis(500);
const TRY_AGAIN: Duration = Duration::from_millis(10);

/// Tells the questions of one connection from those of another.
static CONNECTIONS: AtomicU32 = AtomicU32::new(1);

/// A line with a configured front-end on it.
#[derive(Debug)]
pub(crate) struct Link {
    pub port: Port,
    /// Who had driven its outputs last, before this connection, and for how long nobody had, s.
    pub user: u32,
    pub unused_s: f64,
}

/// Opens the line, finds the front-end, checks and configures it.
pub(crate) fn connect(plan: &Plan) -> Result<(Link, Identification, Vec<Scale>), Error> {
    let port = open(plan)?;
    // Whatever the previous state, all outputs are off during the identification.
    put(plan, &port, &Frame::Off)?;
    let nonce = std::process::id().rotate_left(16).wrapping_add(CONNECTIONS.fetch_add(1, Ordering::Relaxed));
    let who = ask(plan, &port, &Frame::Hello { nonce }, |frame| match frame {
        Frame::Identification(who) if who.nonce == nonce => Some(*who),
        _ => None,
    })?;
    let scales = plan.check(&who)?;
    let session = plan.session;
    let configure = Frame::Configure(plan.configure());
    let refusal = ask(plan, &port, &configure, |frame| match frame {
        Frame::Configured { session: of, refusal } if *of == session => Some(*refusal),
        _ => None,
    })?;
    match refusal {
        None => {
            let (user, unused_s) = (who.user, f64::from(who.unused_ms) * 1e-3);
            Ok((Link { port, user, unused_s }, who, scales))
        }
        Some(refusal) => {
            let what = match refusal {
                Refusal::Channels => "that many channels",
                Refusal::Period => "this period",
                Refusal::Silence => "so long a silence",
                Refusal::Features => "this enable line or emergency stop",
            };
            let reason = format!("refuses {what}");
            Err(Error::Unfit { port: plan.port.clone(), front_end: name(&who), reason })
        }
    }
}

/// Opens the line. A driver that was killed holds its own for a while yet: its memory is locked, and the kernel takes that
/// apart first.
fn open(plan: &Plan) -> Result<Port, Error> {
    let began = Instant::now();
    loop {
        match Port::open(&plan.port, plan.baud_hz) {
            Err(Error::Taken { .. }) if began.elapsed() < LET_GO => thread::sleep(TRY_AGAIN),
            opened => return opened,
        }
    }
}

fn put(plan: &Plan, port: &Port, frame: &Frame) -> Result<(), Error> {
    let mut line = [0; MAX_FRAME];
    let length = encode(frame, &mut line).unwrap_or(0);
    write(plan, port, &line[..length])
}

fn write(plan: &Plan, port: &Port, bytes: &[u8]) -> Result<(), Error> {
    port.write(bytes).map(drop).map_err(|error| failed(plan, error))
}

/// Asks in the versions before this one, whose front-ends drop what they do not understand: an answer tells which it is.
fn ask_the_old(plan: &Plan, port: &Port, nonce: u32) -> Result<(), Error> {
    let mut line = [0; MAX_FRAME];
    (1..VERSION).try_for_each(|version| {
        let length = encode_hello(version, nonce, &mut line).unwrap_or(0);
        write(plan, port, &line[..length])
    })
}

fn failed(plan: &Plan, error: rustix::io::Errno) -> Error {
    Error::Line { port: plan.port.clone(), error: error.into() }
}

/// Sends a frame until one comes that answers it.
fn ask<T>(plan: &Plan, port: &Port, frame: &Frame, answer: impl Fn(&Frame) -> Option<T>) -> Result<T, Error> {
    let mut decoder = Decoder::<MAX_BODY>::new();
    let (began, mut asked) = (Instant::now(), None::<Instant>);
    let mut buffer = [0; 512];
    while began.elapsed() < PATIENCE {
        if asked.is_none_or(|asked| asked.elapsed() >= ASK_AGAIN) {
            put(plan, port, frame)?;
            // One that understands has had its time.
            if let (Frame::Hello { nonce }, Some(_)) = (frame, asked) {
                ask_the_old(plan, port, *nonce)?;
            }
            asked = Some(Instant::now());
        }
        let wait = Timespec { tv_sec: 0, tv_nsec: 10_000_000 };
        let mut fds = [PollFd::new(port, PollFlags::IN)];
        poll(&mut fds, Some(&wait)).map_err(|error| failed(plan, error))?;
        let count = port.read(&mut buffer).map_err(|error| failed(plan, error))?;
        for byte in &buffer[..count] {
            match decoder.push(*byte).map(|body| body.and_then(decode)) {
                Some(Ok(frame)) => {
                    if let Some(answer) = answer(&frame) {
                        return Ok(answer);
                    }
                }
                // Its checksum is right.
                Some(Err(FrameError::Version { found })) => {
                    return Err(Error::Version { port: plan.port.clone(), found });
                }
                Some(Err(_)) | None => {}
            }
        }
    }
    Err(Error::Silent { port: plan.port.clone() })
}
