//! The serial line: LPUART1, which the Nucleo's ST-LINK carries over USB. Its queues are eight bytes; half of one is taken or filled at once.

use embassy_stm32::gpio::{AfType, AnyPin, OutputType, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac::LPUART1 as UART;
use embassy_stm32::{Peri, peripherals, rcc};
use sinew_firmware_common::line::{DOWN, UP};
use sinew_front_end_board::nucleo::{BAUD_HZ, CLOCK_MHZ, RX, TX};

use crate::give;

const QUEUE: usize = 8;
/// A threshold of four.
const HALF: u8 = 0b010;

/// Begins to speak.
pub fn start(tx: Peri<'static, AnyPin>, rx: Peri<'static, AnyPin>) {
    rcc::enable_and_reset::<peripherals::LPUART1>();
    give(tx, TX, AfType::output(OutputType::PushPull, Speed::High));
    give(rx, RX, AfType::input(Pull::Up));
    const DIVIDER: u64 = 256 * CLOCK_MHZ as u64 * 1_000_000 / BAUD_HZ as u64;
    const { assert!(DIVIDER >= 0x300 && DIVIDER <= u16::MAX as u64) };
    UART.brr().write(|w| w.set_brr(DIVIDER as u16));
    UART.cr3().write(|w| {
        w.set_rxftcfg(HALF);
        w.set_rxftie(true);
        w.set_txftcfg(HALF);
    });
    UART.cr1().write(|w| {
        w.set_fifoen(true);
        w.set_re(true);
        w.set_te(true);
        // What is less than half a queue is taken when the line is silent.
        w.set_idleie(true);
    });
    UART.cr1().modify(|w| w.set_ue(true));
    interrupt::LPUART1.set_priority(Priority::P0);
    // SAFETY: the handler is `LPUART1` below, and what it touches is there.
    unsafe { interrupt::LPUART1.enable() };
}

/// There is something to send.
pub fn wake() {
    critical_section::with(|_| UART.cr3().modify(|w| w.set_txftie(true)));
}

/// The queues are half full, half empty, or the line is silent.
#[embassy_stm32::interrupt]
fn LPUART1() {
    // Damaged bytes and lost ones are what the frames' checksums are for.
    UART.icr().write(|w| {
        w.set_pe(true);
        w.set_fe(true);
        w.set_ne(true);
        w.set_ore(true);
        w.set_idle(true);
    });
    let (mut bytes, mut count) = ([0; QUEUE], 0);
    for byte in &mut bytes {
        if !UART.isr().read().rxne() {
            break;
        }
        *byte = UART.rdr().read().dr() as u8;
        count += 1;
    }
    let mut rest = bytes.get(..count).unwrap_or_default();
    while !rest.is_empty()
        && let Ok(count) = DOWN.try_write(rest)
    {
        rest = rest.get(count..).unwrap_or_default();
    }
    if UART.cr3().read().txftie() {
        while UART.isr().read().txe() {
            let mut byte = [0];
            if UP.try_read(&mut byte).is_err() {
                UART.cr3().modify(|w| w.set_txftie(false));
                break;
            }
            UART.tdr().write(|w| w.set_dr(byte[0].into()));
        }
    }
}
