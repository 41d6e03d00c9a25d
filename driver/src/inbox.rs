//! The way of orders from the desk into the loop.
//!
//! - **What switches off overtakes.** An `off` goes by a lane of its own, which the loop empties first; what was asked of its channel before
//!   it and still waits is answered *overtaken* and not carried out.
//! - **What is asked together runs together.** Setpoints for several channels are one piece in a lane of their own, of which the loop takes one
//!   in a cycle, all or none; it overtakes what still waits for its channels.
//! - **The newest of a stream wins.** A message of a stream of setpoints goes by the same lane; the desk takes back those before it that
//!   still wait, and the loop passes over what was taken back.
//! - **What is to be approached is asked again in every cycle**, a step further ([`Ramps`]).
//! - **A refused order never runs.** A request that waits for too long (for a loop that is held up) is answered *busy* only after it was
//!   taken back; what cannot be taken back any more has begun, and its answer is waited for. Both sides change one word of a request by
//!   one compare-and-swap: no lock, and nobody waits.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use sinew_ring::{Consumer, Producer, ring};

use crate::engine::Engine;
use crate::orders::{Answer, Ask, Event, Occurrence, Order};
use crate::ramps::Ramps;

/// Orders that may be on their way, in each lane; and requests for several channels.
const ORDERS: usize = 512;
const TOGETHERS: usize = 16;
/// Requests that may be under way.
const REQUESTS: usize = 2 * ORDERS + TOGETHERS;
/// Most orders taken in one cycle: a flood of commands is spread over cycles instead of making one late. Of those that switch off as many
/// as there can be channels.
const ORDERS_A_CYCLE: usize = 8;
const OFFS_A_CYCLE: usize = sinew_ipc::MAX_CHANNELS;

/// Orders of one request for several channels.
#[derive(Debug, Clone)]
struct Together {
    orders: [Order; sinew_ipc::MAX_CHANNELS],
    count: usize,
    /// The time in which they are approached, ns; 0: they hold at once.
    over_ns: u64,
}

impl Together {
    const NONE: Together = Together { orders: [Order::NONE; sinew_ipc::MAX_CHANNELS], count: 0, over_ns: 0 };

    fn orders(&self) -> &[Order] {
        &self.orders[..self.count]
    }
}

/// The desk's end.
#[derive(Debug)]
pub(crate) struct Outbox {
    orders: Producer<Order>,
    offs: Producer<Order>,
    togethers: Producer<Together>,
    tickets: Arc<Tickets>,
    last: u64,
}

/// The loop's end.
#[derive(Debug)]
pub(crate) struct Inbox {
    orders: Consumer<Order>,
    offs: Consumer<Order>,
    togethers: Consumer<Together>,
    tickets: Arc<Tickets>,
    ramps: Ramps,
}

/// Both ends of a new way.
pub(crate) fn way_in() -> (Outbox, Inbox) {
    let (give, orders) = ring([Order::NONE; ORDERS]);
    let (give_off, offs) = ring([Order::NONE; ORDERS]);
    let (give_together, togethers) = ring(vec![Together::NONE; TOGETHERS]);
    let tickets = Arc::new(Tickets::new(REQUESTS));
    let outbox = Outbox { orders: give, offs: give_off, togethers: give_together, tickets: tickets.clone(), last: 0 };
    (outbox, Inbox { orders, offs, togethers, tickets, ramps: Ramps::default() })
}

impl Outbox {
    /// Sends a request on its way, an order for each of its channels, all or none; its ticket. `None`: there is no room.
    pub fn send(&mut self, orders: impl ExactSizeIterator<Item = (usize, Ask, u64)>, is_off: bool) -> Option<u64> {
        let lane = if is_off { &mut self.offs } else { &mut self.orders };
        if lane.free() < orders.len() {
            return None;
        }
        let ticket = self.tickets.issue(self.last)?;
        self.last = ticket;
        for (channel, ask, hold_ns) in orders {
            // There is room: looked at above, and this is the only producer.
            lane.push(Order { ticket, channel, ask, hold_ns });
        }
        Some(ticket)
    }

    /// Sends setpoints on their way that are to be in force from the same cycle on or not at all, approached in a time, ns; their ticket. `None`:
    /// there is no room, or there are more than there can be channels.
    pub fn send_together(&mut self, orders: &[(usize, Ask, u64)], over_ns: u64) -> Option<u64> {
        if self.togethers.free() == 0 || orders.len() > sinew_ipc::MAX_CHANNELS {
            return None;
        }
        let ticket = self.tickets.issue(self.last)?;
        self.last = ticket;
        self.togethers.put(|together| {
            (together.count, together.over_ns) = (orders.len(), over_ns);
            for (place, &(channel, ask, hold_ns)) in together.orders.iter_mut().zip(orders) {
                *place = Order { ticket, channel, ask, hold_ns };
            }
        });
        Some(ticket)
    }

    /// Takes a request back; `false` where the loop has begun with it.
    pub fn take_back(&mut self, ticket: u64) -> bool {
        self.tickets.take_back(ticket)
    }

    /// A request was answered.
    pub fn end(&mut self, ticket: u64) {
        self.tickets.end(ticket);
    }
}

impl Inbox {
    /// Hands waiting orders to the engine, as many as a cycle takes; how many it took. In the loop: no allocation, no lock.
    #[inline]
    pub fn hand_over(&mut self, engine: &mut Engine, now_ns: u64, tell: &mut impl FnMut(Event)) -> u64 {
        let mut taken = 0;
        for _ in 0..OFFS_A_CYCLE {
            let Some(order) = self.offs.pop() else { break };
            taken += self.take(&order, engine, now_ns, tell);
        }
        taken += self.take_together(engine, now_ns, tell);
        for _ in 0..ORDERS_A_CYCLE {
            if self.orders.peek(|order| has_to_wait(order, engine)) == Some(true) {
                break;
            }
            let Some(order) = self.orders.pop() else { break };
            taken += self.take(&order, engine, now_ns, tell);
        }
        self.ramps.step(engine, now_ns);
        taken
    }

    /// One request for several channels.
    #[inline]
    fn take_together(&mut self, engine: &mut Engine, now_ns: u64, tell: &mut impl FnMut(Event)) -> u64 {
        let (tickets, ramps) = (&self.tickets, &mut self.ramps);
        // What was taken back takes no cycle.
        for _ in 0..TOGETHERS {
            let waits = |together: &Together| together.orders().iter().any(|order| has_to_wait(order, engine));
            if self.togethers.peek(waits) != Some(false) {
                return 0;
            }
            let taken = self.togethers.take(|together| {
                if !together.orders().first().is_some_and(|order| tickets.begin(order.ticket)) {
                    return 0;
                }
                let mut orders = together.orders;
                let orders = &mut orders[..together.count];
                if together.over_ns > 0 {
                    ramps.begin(orders, together.over_ns, engine, now_ns);
                }
                engine.take_together(orders, now_ns, |order, answer| tell(answered(order, answer, now_ns)));
                orders.len() as u64
            });
            match taken {
                Some(0) => {}
                taken => return taken.unwrap_or(0),
            }
        }
        0
    }

    #[inline]
    fn take(&mut self, order: &Order, engine: &mut Engine, now_ns: u64, tell: &mut impl FnMut(Event)) -> u64 {
        if !self.tickets.begin(order.ticket) {
            return 0;
        }
        if let Some(answer) = engine.take(order, now_ns) {
            tell(answered(order, answer, now_ns));
        }
        1
    }
}

/// Whether its channel has one in this cycle already: a recording has room for one.
#[inline]
fn has_to_wait(order: &Order, engine: &Engine) -> bool {
    engine.has_order(order.channel) && !engine.is_overtaken(order)
}

#[inline]
fn answered(order: &Order, answer: Answer, at_ns: u64) -> Event {
    let what = Occurrence::Answered { ticket: order.ticket, answer };
    Event { at_ns, channel: order.channel as u32, what }
}

/// The lowest bit of a slot's word: whether the loop has begun with the request; the ticket stands above it.
const BEGUN: u64 = 1;
/// A slot without a request. No ticket is 0.
const FREE: u64 = 0;

/// The requests under way, each in the slot of its ticket.
#[derive(Debug)]
struct Tickets {
    slots: Box<[AtomicU64]>,
}

impl Tickets {
    /// Room for so many at once.
    fn new(requests: usize) -> Tickets {
        Tickets { slots: (0..requests).map(|_| AtomicU64::new(FREE)).collect() }
    }

    fn slot(&self, ticket: u64) -> &AtomicU64 {
        &self.slots[(ticket % self.slots.len() as u64) as usize]
    }

    /// A ticket after `last` for a new request; `None` where as many are under way as there is room for. For the desk alone.
    fn issue(&self, last: u64) -> Option<u64> {
        let ticket = (1..=self.slots.len() as u64)
            .map(|next| last + next)
            .find(|ticket| self.slot(*ticket).load(Ordering::Relaxed) == FREE)?;
        self.slot(ticket).store(ticket << 1, Ordering::Release);
        Some(ticket)
    }

    /// Whether an order of this ticket may run: not once it was taken back. Of a request for several channels all may, or none.
    /// For the loop: constant time, no lock.
    #[inline]
    fn begin(&self, ticket: u64) -> bool {
        let (waits, begun) = (ticket << 1, ticket << 1 | BEGUN);
        match self.slot(ticket).compare_exchange(waits, begun, Ordering::AcqRel, Ordering::Acquire) {
            Ok(_) => true,
            Err(found) => found == begun,
        }
    }

    /// Takes a request back: `true`, and none of its orders will run; `false`, and the loop has begun with it. For the desk.
    fn take_back(&self, ticket: u64) -> bool {
        self.slot(ticket).compare_exchange(ticket << 1, FREE, Ordering::AcqRel, Ordering::Acquire).is_ok()
    }

    /// Ends a request that was answered, or never sent. For the desk.
    fn end(&self, ticket: u64) {
        self.slot(ticket).store(FREE, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channel::Target;
    use crate::orders::Beat;
    use sinew_backend::{BackendError, ChannelFault};
    use sinew_rig::Rig;

    fn engine() -> Engine {
        let wire = |name: &str| {
            format!(
                "[[channel]]\nname = \"{name}\"\nwire = {{ diameter_mm = 0.125, length_mm = 160.0 }}\n\
                 drive = {{ supply_v = 6.5, shunt_ohm = 0.1 }}\nload = {{ mass_kg = 0.2 }}\n"
            )
        };
        let text = ["[rig]\nname = \"bench\"\nrate_hz = 50.0\n".to_string(), wire("left"), wire("right")].concat();
        let rig = Rig::parse(&text, "bench.toml").unwrap_or_else(|e| panic!("{e}"));
        Engine::at_rest(&rig, None).unwrap()
    }

    /// What the loop answers in one cycle, by ticket.
    fn cycle(inbox: &mut Inbox, engine: &mut Engine, at: u64) -> Vec<(u64, Answer)> {
        let mut answers = Vec::new();
        inbox.hand_over(engine, at, &mut |event| {
            if let Occurrence::Answered { ticket, answer } = event.what {
                answers.push((ticket, answer));
            }
        });
        let samples = [sinew_sensing::Sample::NONE; 2];
        engine.cycle(Beat { now_ns: at, missed: 0 }, Ok(()), &samples, &mut [0.0; 2], |_| {});
        answers
    }

    #[test]
    fn off_overtakes_what_was_asked_before_it_and_nothing_of_that_runs() {
        let (mut outbox, mut inbox) = way_in();
        let mut engine = engine();
        let duty = |channel| [(channel, Ask::Duty(0.5), u64::MAX)].into_iter();
        let before: Vec<u64> = (0..16).map(|_| outbox.send(duty(0), false).unwrap()).collect();
        let off = outbox.send([(0, Ask::Off, u64::MAX), (1, Ask::Off, u64::MAX)].into_iter(), true).unwrap();
        let other = outbox.send(duty(1), false).unwrap();
        let after = outbox.send(duty(0), false).unwrap();

        let mut answers = cycle(&mut inbox, &mut engine, 0);
        assert_eq!(answers[..2], [(off, Answer::Done), (off, Answer::Done)], "in the first cycle, before all others");
        for at in 1..5 {
            answers.extend(cycle(&mut inbox, &mut engine, at));
        }
        let of = |ticket: &u64| answers.iter().find(|(found, _)| found == ticket).map(|(_, answer)| *answer);
        assert!(before.iter().all(|ticket| of(ticket) == Some(Answer::Overtaken)), "{answers:?}");
        assert_eq!((of(&other), of(&after)), (Some(Answer::Done), Some(Answer::Done)), "asked for later");
    }

    #[test]
    fn what_is_asked_together_runs_in_one_cycle_or_not_at_all() {
        let (mut outbox, mut inbox) = way_in();
        let mut engine = engine();
        let duty = |share: f64| [(0, Ask::Duty(share), u64::MAX), (1, Ask::Duty(share), u64::MAX)];
        let alone = |channel| [(channel, Ask::Duty(0.9), u64::MAX)].into_iter();
        let wanted = |engine: &Engine| [0, 1].map(|channel: usize| engine.channels()[channel].target);

        let before = outbox.send(alone(1), false).unwrap();
        let both = outbox.send_together(&duty(0.3), 0).unwrap();
        let done = [(both, Answer::Done), (both, Answer::Done), (before, Answer::Overtaken)];
        assert_eq!(cycle(&mut inbox, &mut engine, 0), done, "what waited for one of its channels is overtaken");
        assert_eq!(wanted(&engine), [Target::Duty(0.3); 2]);

        // one of them is in no state for it
        let samples = [sinew_sensing::Sample::NONE; 2];
        let broken = Err(BackendError::Channel { channel: 1, fault: ChannelFault::Stage });
        engine.cycle(Beat { now_ns: 1, missed: 0 }, broken, &samples, &mut [0.0; 2], |_| {});
        let refused = outbox.send_together(&duty(0.5), 0).unwrap();
        let latched = Answer::Latched(sinew_ipc::Fault::Backend);
        assert_eq!(cycle(&mut inbox, &mut engine, 1), [(refused, Answer::WithOthers), (refused, latched)]);
        assert_eq!(wanted(&engine)[0], Target::Duty(0.3), "nothing of it was carried out");

        // overtaken by an off, and taken back
        let late = outbox.send_together(&duty(0.6), 0).unwrap();
        let off = outbox.send([(0, Ask::Off, u64::MAX)].into_iter(), true).unwrap();
        let gone = outbox.send_together(&duty(0.7), 0).unwrap();
        assert!(outbox.take_back(gone));
        let mut answers = cycle(&mut inbox, &mut engine, 2);
        answers.extend(cycle(&mut inbox, &mut engine, 3));
        assert_eq!(answers, [(off, Answer::Done), (late, Answer::Overtaken), (late, latched)]);
        assert_eq!(wanted(&engine)[0], Target::Idle);
    }

    #[test]
    fn what_was_taken_back_never_runs() {
        let (mut outbox, mut inbox) = way_in();
        let mut engine = engine();
        let late = outbox.send([(0, Ask::Duty(0.5), u64::MAX)].into_iter(), false).unwrap();
        assert!(outbox.take_back(late), "the desk has answered busy");
        assert_eq!(cycle(&mut inbox, &mut engine, 0), []);
        assert!(engine.channels()[0].target_m().is_nan() && !engine.has_order(0));
        let begun = outbox.send([(0, Ask::Duty(0.5), u64::MAX)].into_iter(), false).unwrap();
        assert_eq!(cycle(&mut inbox, &mut engine, 1), [(begun, Answer::Done)]);
        assert!(!outbox.take_back(begun), "what has begun is answered by what comes of it");
    }

    #[test]
    fn a_request_runs_or_is_taken_back_and_never_both() {
        let tickets = Tickets::new(2);
        let first = tickets.issue(0).unwrap();
        let second = tickets.issue(first).unwrap();
        assert_eq!(tickets.issue(second), None, "both slots are taken");
        assert!(tickets.begin(first) && tickets.begin(first), "for every channel it is meant for");
        assert!(!tickets.take_back(first));
        assert!(tickets.take_back(second));
        assert!(!tickets.begin(second));
        tickets.end(first);
        let third = tickets.issue(second).unwrap();
        assert!(third > second);
        assert!(!tickets.begin(first) && !tickets.begin(second), "whoever has their slots now");
        assert!(tickets.begin(third));
    }

    #[test]
    fn two_threads_never_both_get_it() {
        const REQUESTS: u64 = 20_000;
        let tickets = Arc::new(Tickets::new(8));
        let (give, take) = std::sync::mpsc::sync_channel::<u64>(0);
        let loops = tickets.clone();
        let runner = std::thread::spawn(move || take.iter().map(|ticket| loops.begin(ticket)).collect::<Vec<_>>());
        let mut taken_back = Vec::new();
        let mut last = 0;
        for _ in 0..REQUESTS {
            last = tickets.issue(last).unwrap();
            give.send(last).unwrap();
            taken_back.push(tickets.take_back(last));
            tickets.end(last);
        }
        drop(give);
        let ran = runner.join().unwrap();
        assert!(ran.iter().zip(&taken_back).all(|(ran, back)| !(*ran && *back)));
    }
}
