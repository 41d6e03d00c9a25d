//! The front-end's firmware on a Raspberry Pi Pico: `docs/board.md` is the board around it, `docs/front-end.md` what it speaks.
//!
//! What outputs do is `sinew-front-end`'s, when and how is `sinew-front-end-board`'s; here are the RP2040's peripherals.
#![no_std]
#![no_main]

mod board;
mod converter;
mod line;
mod outputs;

use core::panic::PanicInfo;

use embassy_executor::Spawner;
use embassy_rp::adc::{Adc, Channel, Config};
use embassy_rp::flash::{Blocking, Flash};
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::interrupt::{self, InterruptExt, Priority};
use embassy_rp::pac;
use embassy_rp::watchdog::Watchdog;
use embassy_time::Duration;
use sinew_front_end::ResetCause;
use sinew_front_end_board::pico::{NAME, reset_cause};
use sinew_front_end_board::{WATCHDOG_NS, identification, version};
use static_cell::StaticCell;

use crate::board::Board;
use crate::converter::{Converter, Pins};
use crate::outputs::{Outputs, cut};

const FLASH_BYTES: usize = 2 * 1024 * 1024;

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = embassy_rp::init(Default::default());
    let reset = why_reset();
    // From here on whoever stands still is reset, and fed only below, by the loop that polls.
    let patience = Duration::from_nanos(WATCHDOG_NS.into());
    let mut watchdog = Watchdog::new(p.WATCHDOG);
    watchdog.start(patience);
    // Nothing holds up the interrupt that reads the converter but critical sections.
    interrupt::TIMER_IRQ_0.set_priority(Priority::P3);

    let enable = Output::new(p.PIN_6, Level::Low);
    let outputs = Outputs::new(p.PIO0, (p.PIN_2, p.PIN_3, p.PIN_4, p.PIN_5));
    let stop = Input::new(p.PIN_7, Pull::Up);
    let stop_reset = Input::new(p.PIN_8, Pull::Up);
    let light = Output::new(p.PIN_25, Level::Low);

    let serial = serial_number(Flash::new_blocking(p.FLASH));
    static SERIAL: StaticCell<[u8; 16]> = StaticCell::new();
    line::start(p.USB, hexadecimal(serial, SERIAL.init([0; 16])), spawner);

    let converter = Converter::new(Pins {
        pio: p.PIO1,
        spi: p.SPI0,
        control: (p.PIN_10, p.PIN_11, p.PIN_12),
        lines: (p.PIN_16, p.PIN_17, p.PIN_18, p.PIN_19),
    })
    .await;
    let (adc, supply) = (Adc::new_blocking(p.ADC, Config::default()), Channel::new_pin(p.PIN_26, Pull::None));
    let mut board = Board { outputs, converter, adc, supply, enable, stop, stop_reset, light };

    let version =
        version(env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH"));
    let who = identification(NAME, version, serial, reset);
    let feed = || watchdog.feed(patience);
    sinew_firmware_common::run(who, &mut board, feed, async |board: &mut Board| opens(&mut board.stop).await).await
}

/// Until the emergency stop's contact opens. While it is open the firmware looks at it by itself, several times a period.
async fn opens(stop: &mut Input<'static>) {
    if stop.is_high() {
        core::future::pending().await
    } else {
        stop.wait_for_high().await;
    }
}

fn why_reset() -> ResetCause {
    let reason = pac::WATCHDOG.reason().read();
    let chip = pac::VREG_AND_CHIP_RESET.chip_reset().read();
    reset_cause(reason.timer(), reason.force(), chip.had_por(), chip.had_run(), chip.had_psm_restart())
}

/// The flash's, since the RP2040 has none of its own.
fn serial_number(mut flash: Flash<'static, embassy_rp::peripherals::FLASH, Blocking, FLASH_BYTES>) -> u64 {
    let mut serial = [0; 8];
    flash.blocking_unique_id(&mut serial).map_or(0, |()| u64::from_be_bytes(serial))
}

fn hexadecimal(number: u64, text: &'static mut [u8; 16]) -> &'static str {
    for (index, digit) in text.iter_mut().enumerate() {
        let value = (number >> (60 - 4 * index) & 0xf) as u8;
        *digit = if value < 10 { b'0' + value } else { b'a' + value - 10 };
    }
    core::str::from_utf8(text).unwrap_or("")
}

/// Off by the pins, then the watchdog resets.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    cut();
    loop {
        cortex_m::asm::nop();
    }
}

#[cortex_m_rt::exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    cortex_m::interrupt::disable();
    cut();
    loop {
        cortex_m::asm::nop();
    }
}
