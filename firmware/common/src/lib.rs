//! What the firmwares have in common beside the protocol and the board: the loop that polls, and the two ends of the serial line.
#![no_std]

pub mod line;

use embassy_futures::select::{Either3, select3};
use embassy_time::{Duration, Instant, Timer};
use sinew_front_end::{Firmware, Hardware, Identification};
use static_cell::StaticCell;

/// Longest time between two polls, for the watchdog.
const NAP: Duration = Duration::from_millis(20);

/// Runs a board, once: takes what comes down the line, and polls when it is due, when `stop` is over, and at least every 20 ms. `feed` is
/// the watchdog's: whoever stands still elsewhere does not feed it.
pub async fn run<B: Hardware>(
    who: Identification,
    board: &mut B,
    mut feed: impl FnMut(),
    mut stop: impl AsyncFnMut(&mut B),
) -> ! {
    static FIRMWARE: StaticCell<Firmware> = StaticCell::new();
    let firmware = FIRMWARE.init(Firmware::new(who));
    let mut packet = [0; line::PACKET];
    loop {
        feed();
        let now = Instant::now();
        let nap = now + NAP;
        let due = firmware.poll(nanoseconds(now), board).map_or(nap, |due_ns| {
            // Rounded up: a tick early there is nothing to do yet.
            nap.min(Instant::from_micros(due_ns.div_ceil(1000)))
        });
        match select3(line::DOWN.read(&mut packet), Timer::at(due), stop(board)).await {
            Either3::First(count) => {
                let now_ns = nanoseconds(Instant::now());
                firmware.poll(now_ns, board);
                firmware.receive(packet.get(..count).unwrap_or_default(), now_ns, board);
            }
            Either3::Second(()) | Either3::Third(()) => {}
        }
    }
}

fn nanoseconds(at: Instant) -> u64 {
    at.as_micros() * 1000
}
