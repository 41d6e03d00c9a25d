//! Both ends of the gate for other users: visitors of any kind before its porter, and a client in front of a driver of any kind.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::io::IoSlice;
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use rustix::net::{
    RecvFlags, SendAncillaryBuffer, SendAncillaryMessage, SendFlags, Shutdown, recv, send, sendmsg, shutdown,
};
use sinew_ipc::gateway::fuzzing::{self, MAX_UNANSWERED, Memory, PendingReply, TestListener};
use sinew_ipc::{Client, Command, CommandKind, DriverHealth, Error, MAX_CHANNELS, Reply, Terms};
use tempfile::TempDir;

use crate::script::Script;

/// Visitors of a script at once.
const VISITORS: usize = 6;
/// Steps a script is worth at most.
const MOST_STEPS: usize = 64;
/// Looks after which the porter has done everything there is to do.
const LOOKS: usize = 32;
const AT_ONCE: SendFlags = SendFlags::DONTWAIT.union(SendFlags::NOSIGNAL);
/// What the porter sends: his first words, and answers.
const WELCOME_BYTES: usize = 216;
const REPLY_BYTES: usize = size_of::<Reply>();

/// A gate, and somebody well-behaved inside who stays through all scripts.
struct Bench {
    listener: TestListener,
    good: OwnedFd,
    /// Number of the last request: no two are the same.
    sequence: u64,
    _dir: TempDir,
}

thread_local! {
    static BENCH: RefCell<Bench> =
        RefCell::new(Bench::open().unwrap_or_else(|error| panic!("a gate of one's own: {error}")));
}

impl Bench {
    fn open() -> Result<Bench, Box<dyn std::error::Error>> {
        let dir = tempfile::Builder::new().prefix("sinew-hostile-").tempdir()?;
        let mut listener = TestListener::open(dir.path())?;
        let good = listener.connect()?;
        assert!(listener.receive().is_none() && listener.clients() == 1);
        let mut bench = Bench { listener, good, sequence: 0, _dir: dir };
        bench.good_is_served();
        Ok(bench)
    }

    /// One request of the well-behaved visitor, there and back.
    fn good_is_served(&mut self) {
        self.sequence += 1;
        let command = off(self.sequence);
        let sent = send(&self.good, &fuzzing::request(Terms::default(), &[command]), AT_ONCE);
        assert!(sent.is_ok(), "who behaves was shown out: {sent:?}");
        let found = (0..LOOKS).find_map(|_| self.listener.receive());
        let Some((asked, answer)) = found else { panic!("his request is not heard") };
        assert_eq!(asked.iter().map(|command| command.sequence).collect::<Vec<_>>(), [self.sequence]);
        answer.send_replies(&taken(&asked));
        let mut bytes = [0; WELCOME_BYTES + 1];
        let answered = std::iter::from_fn(|| recv(&self.good, &mut bytes[..], RecvFlags::DONTWAIT).ok());
        assert!(answered.map(|(length, _)| length).last() == Some(REPLY_BYTES), "he is not answered");
    }
}

fn taken(commands: &[Command]) -> Vec<Reply> {
    commands.iter().map(|command| Reply::taken(command, 0.25)).collect()
}

fn off(sequence: u64) -> Command {
    Command { client: 1, sequence, channel: 0, kind: CommandKind::Off.code(), value: 0.0, hold_s: 0.0 }
}

/// Somebody at the gate.
struct Visitor {
    number: usize,
    socket: OwnedFd,
    /// Has sent something that is no request, or has hung up: nothing he asks for counts any more.
    out: bool,
}

/// A script for up to six visitors and the desk: requests of any bits, rubbish, floods, descriptors on top, hanging up in any way, never
/// fetching an answer.
///
/// Whatever it is: what comes to the desk are requests that somebody inside has made and still waits for, each once, in his order, under the
/// number the kernel knows him by, and no more than his share at once; whoever sends anything else is shown out and nothing he sends later is
/// heard; when all have gone their seats are free; and another visitor is served as if nothing had been.
///
/// # Panics
/// Where the porter breaks a promise.
pub fn gate(bytes: &[u8]) {
    BENCH.with_borrow_mut(|bench| {
        let mut script = Script::new(bytes);
        let mut run = Run {
            bench,
            visitors: Vec::new(),
            numbers: 0,
            asked: BTreeMap::new(),
            heard: BTreeMap::new(),
            waiting: Vec::new(),
        };
        for _ in 0..MOST_STEPS {
            let Some(step) = script.step() else { break };
            run.step(step, &mut script);
        }
        let Run { waiting, visitors, .. } = run;
        drop(visitors);
        // An answer for somebody who has gone is nobody's loss.
        waiting.into_iter().for_each(|(_, commands, answer)| answer.send_replies(&taken(&commands)));
        let emptied = (0..LOOKS).any(|_| {
            bench.listener.receive();
            bench.listener.clients() == 1
        });
        assert!(emptied, "{} seats are taken by nobody", bench.listener.clients() - 1);
        while bench.listener.receive().is_some() {}
        bench.good_is_served();
    });
}

struct Run<'a> {
    bench: &'a mut Bench,
    visitors: Vec<Visitor>,
    numbers: usize,
    /// Requests that may be heard, by their number: whose they are.
    asked: BTreeMap<u64, usize>,
    /// The last one heard of each visitor.
    heard: BTreeMap<usize, u64>,
    waiting: Vec<(usize, Vec<Command>, PendingReply)>,
}

impl Run<'_> {
    fn step(&mut self, step: u8, script: &mut Script) {
        let whim = script.byte();
        let which = usize::from(whim) % self.visitors.len().max(1);
        match step % 8 {
            0 if self.visitors.len() < VISITORS => {
                let socket = self.bench.listener.connect().unwrap_or_else(|e| panic!("the door is shut: {e}"));
                self.visitors.push(Visitor { number: self.numbers, socket, out: false });
                self.numbers += 1;
            }
            // One or many at once, in time or too late, with descriptors on top or without.
            1 | 2 => {
                let late = step & 0x40 != 0;
                for _ in 0..=u32::from(step >> 3 & 7) * 3 {
                    let (sequence, request) = self.request(script, late);
                    self.send(which, &request, step & 0x80 != 0, sequence);
                }
            }
            3 => {
                let rubbish = script.bytes(usize::from(step >> 3) * 6);
                self.send(which, rubbish, step & 0x80 != 0, None);
            }
            4 => {
                // More than it is, less, or huge.
                let mut request = self.request(script, false).1;
                let length = [0, 1, 55, 57, 216, 217, 4000, 100_000][usize::from(step >> 3) % 8];
                request.resize(length, 0xa5);
                self.send(which, &request, false, None);
            }
            5 => {
                if let Some(visitor) = self.visitors.get_mut(which) {
                    let how = [Shutdown::Read, Shutdown::Write, Shutdown::Both][usize::from(step >> 3) % 3];
                    let _ = shutdown(&visitor.socket, how);
                    // Who has only stopped listening may ask until an answer cannot be brought.
                    visitor.out |= how != Shutdown::Read;
                }
            }
            6 if step & 0x08 == 0 => {
                if which < self.visitors.len() {
                    self.visitors.swap_remove(which);
                }
            }
            6 => {
                if let Some(visitor) = self.visitors.get(which) {
                    let mut bytes = [0; MAX_CHANNELS * REPLY_BYTES + 1];
                    while let Ok((length @ 1.., _)) = recv(&visitor.socket, &mut bytes[..], RecvFlags::DONTWAIT) {
                        let is_answer = length % REPLY_BYTES == 0 && length / REPLY_BYTES <= MAX_CHANNELS;
                        assert!(length == WELCOME_BYTES || is_answer, "the porter says {length} bytes");
                    }
                }
            }
            _ => {
                for _ in 0..=step >> 3 & 15 {
                    self.hear();
                }
                if step & 0x80 != 0 {
                    for (_, commands, answer) in self.waiting.drain(..) {
                        answer.send_replies(&taken(&commands));
                    }
                }
            }
        }
    }

    /// A request of any contents; and its number, where it is one that may be heard.
    fn request(&mut self, script: &mut Script, late: bool) -> (Option<u64>, Vec<u8>) {
        self.bench.sequence += 1;
        let sequence = self.bench.sequence;
        let any = |script: &mut Script| f64::from_bits(script.u64());
        let what = script.byte();
        let command = match what {
            0..128 => off(sequence),
            _ => Command {
                client: script.u64(),
                sequence,
                channel: script.u32(),
                kind: script.u32(),
                value: any(script),
                hold_s: any(script),
            },
        };
        // one, or as many as a request takes at the most
        let commands =
            vec![command; if what.is_multiple_of(4) { 1 + usize::from(script.byte()) % MAX_CHANNELS } else { 1 }];
        // those of a stream are refused with other words, and approach in any time
        let (over_s, stream) = if what.is_multiple_of(2) { (any(script), script.u64()) } else { (0.0, 0) };
        let terms = Terms { until_ns: if late { 1 } else { u64::MAX }, over_s, stream };
        // What only switches off is never too late.
        let is_heard = !late || Command::only_switch_off(&commands);
        (is_heard.then_some(sequence), fuzzing::request(terms, &commands))
    }

    /// Sends it, if he can. `request`: its number, where it is one that may be heard.
    fn send(&mut self, which: usize, bytes: &[u8], with_descriptors: bool, request: Option<u64>) {
        let Some(visitor) = self.visitors.get_mut(which) else { return };
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(2))];
        let mut beside = SendAncillaryBuffer::new(&mut space);
        let handed = [self.bench.good.as_fd(), self.bench.good.as_fd()];
        if with_descriptors {
            beside.push(SendAncillaryMessage::ScmRights(&handed));
        }
        if sendmsg(&visitor.socket, &[IoSlice::new(bytes)], &mut beside, AT_ONCE).is_err() || visitor.out {
            return;
        }
        match request {
            Some(sequence) => drop(self.asked.insert(sequence, visitor.number)),
            // Too late is no rubbish.
            None => visitor.out = !fuzzing::is_request(bytes),
        }
    }

    /// What comes to the desk.
    fn hear(&mut self) {
        let Some((commands, answer)) = self.bench.listener.receive() else { return };
        let command = commands[0];
        assert!(commands.iter().all(|other| (other.client, other.sequence) == (command.client, command.sequence)));
        assert_eq!(command.client >> 32, u64::from(std::process::id()), "under another's number");
        let Some(whose) = self.asked.remove(&command.sequence) else {
            panic!("nobody asked for it, or not any more, or twice: {command:?}");
        };
        let before = self.heard.insert(whose, command.sequence);
        assert!(before < Some(command.sequence), "out of order: {command:?} after {before:?}");
        self.waiting.push((whose, commands, answer));
        let his = self.waiting.iter().filter(|(number, ..)| *number == whose).count();
        assert!(his <= MAX_UNANSWERED, "{his} of one visitor are waiting");
    }
}

/// The memory of a driver as it should be.
static BOARD: LazyLock<Vec<u8>> =
    LazyLock::new(|| fuzzing::board(2, 5).unwrap_or_else(|error| panic!("a good board: {error}")));
/// Words at its beginning that decide what the rest means.
const FIRST_WORDS: usize = 16;

/// A driver of any kind, as it looks to a client: first words, memory with any words in it changed or all of it anything, answers.
///
/// Whatever it is: the client is refused with a reason and a remedy, or everything it can be asked comes to an end without a panic, within the
/// bounds that were promised; and when the driver's end of the socket closes, it says so.
///
/// # Panics
/// Where the client breaks a promise.
pub fn visit(bytes: &[u8]) {
    let mut script = Script::new(bytes);
    let flags = script.byte();
    let good_words = fuzzing::welcome();
    let words = if flags & 1 == 0 { good_words } else { damaged_words(good_words, &mut script) };
    let most = usize::from(flags >> 6);
    let answers: Vec<Vec<u8>> = (0..most).map(|_| answer(&mut script)).collect();
    let answers: Vec<&[u8]> = answers.iter().map(Vec::as_slice).collect();
    let memory = match flags >> 1 & 3 {
        0 => None,
        1 => {
            let words = usize::from(script.byte());
            Some(script.bytes(8 * words).to_vec())
        }
        _ => Some(BOARD.clone()),
    };
    let memory = memory.map(|bytes| Memory::of(&bytes).unwrap_or_else(|error| panic!("some memory: {error}")));
    let words_of = |memory: &Option<Memory>, script: &mut Script| memory.iter().for_each(|m| poke(m.words(), script));
    words_of(&memory, &mut script);
    match fuzzing::client(&words, memory.as_ref(), &answers) {
        Err(error) => assert!(!error.message().is_empty() && !error.remedy().is_empty(), "{error:?}"),
        Ok((client, driver)) => {
            look_at_all_of(&client, || words_of(&memory, &mut script));
            match client.command(0, CommandKind::Stroke, 0.5, Duration::ZERO) {
                Ok(reply) => assert_eq!(reply.sequence, 1, "an answer to something else"),
                Err(error) => assert!(!error.to_string().is_empty()),
            }
            drop(driver);
            let health = client.health();
            assert!(matches!(health, DriverHealth::Died | DriverHealth::Stopped), "nobody is there: {health:?}");
            let gone = client.command(0, CommandKind::Off, 0.0, Duration::ZERO);
            assert!(matches!(gone, Err(Error::DriverGone { .. })), "{gone:?}");
        }
    }
}

fn damaged_words(mut words: Vec<u8>, script: &mut Script) -> Vec<u8> {
    for _ in 0..1 + script.byte() % 8 {
        let at = usize::from(script.byte()) % words.len();
        words[at] = script.byte();
    }
    let length = script.byte();
    if length & 1 != 0 {
        words.resize(usize::from(length), 0);
    }
    words
}

fn answer(script: &mut Script) -> Vec<u8> {
    let whim = script.byte();
    let mut bytes = script.bytes(if whim & 0x80 == 0 { REPLY_BYTES } else { usize::from(whim & 0x7f) }).to_vec();
    if whim & 1 == 0 && bytes.len() >= 8 {
        // to the first request
        bytes[..8].copy_from_slice(&1u64.to_ne_bytes());
    }
    bytes
}

/// Changes words of a driver's memory, as a driver gone mad might.
fn poke(memory: &[AtomicU64], script: &mut Script) {
    for _ in 0..script.byte() % 16 {
        let step = script.byte();
        let first = step & 1 == 0;
        let at = if first { usize::from(script.byte()) % FIRST_WORDS } else { usize::from(script.u16()) };
        let word = &memory[at % memory.len()];
        let before = word.load(Ordering::Relaxed);
        let value = match step >> 1 & 7 {
            0 => u64::MAX,
            1 => 0,
            2 => before.wrapping_add(1),
            3 => before.wrapping_sub(1),
            4 => u64::from(script.byte()),
            5 => 1 << (script.byte() % 64),
            _ => script.u64(),
        };
        word.store(value, Ordering::Relaxed);
    }
}

/// Everything a client can be asked, with `change` of the driver's memory in between.
fn look_at_all_of(client: &Client, mut change: impl FnMut()) {
    assert!(client.is_foreign());
    let info = client.info();
    assert!(info.channels().len() <= MAX_CHANNELS);
    let names: BTreeSet<String> = client.channels().iter().map(|channel| channel.name.to_string()).collect();
    assert!(names.len() <= MAX_CHANNELS);
    for name in &names {
        assert!(client.channel(name).is_ok_and(|index| index < client.channels().len()), "{name:?}");
    }
    let _ = (info.rig.to_string(), client.rig_text().map(|text| text.map(|text| text.len())));
    let latest = client.latest();
    assert!(latest.channels().len() <= MAX_CHANNELS);
    for channel in latest.channels() {
        let _ = (channel.mode(), channel.fault());
    }
    let stats = client.loop_stats();
    for histogram in [&stats.lateness, &stats.cycle_time, &stats.period] {
        let _ = (histogram.quantile(0.5), histogram.quantile(0.999), histogram.max());
    }
    let _ = (client.age(), client.health(), client.is_alive(), client.wait(Duration::ZERO));
    let mut faults = client.faults();
    let changes = std::iter::from_fn(|| faults.poll()).take(2 * MAX_CHANNELS + 1).count();
    assert!(changes <= MAX_CHANNELS, "{changes} changes in one look");
    let mut stream = client.stream().unwrap_or_else(|error| panic!("a stream needs nothing of the driver: {error}"));
    for _ in 0..8 {
        change();
        let cycles = std::iter::from_fn(|| match stream.next() {
            Ok(Some(cycle)) => Some(cycle.channels.len()),
            Ok(None) | Err(_) => None,
        });
        assert!(cycles.take(100).all(|channels| channels <= MAX_CHANNELS));
        assert!(client.latest().channels().len() <= MAX_CHANNELS);
    }
    let _ = (stream.received(), stream.lost());
}
