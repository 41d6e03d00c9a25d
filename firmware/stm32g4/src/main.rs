//! The front-end's firmware on a NUCLEO-G474RE: `docs/board.md` is the board around it, `docs/front-end.md` what it speaks.
//!
//! What outputs do is `sinew-front-end`'s, when and how is `sinew-front-end-board`'s; here are the STM32's peripherals.
#![no_std]
#![no_main]

mod board;
mod converter;
mod line;
mod outputs;

use core::panic::PanicInfo;

use embassy_executor::Spawner;
use embassy_stm32::adc::{Adc, AdcConfig};
use embassy_stm32::gpio::{AfType, AnyPin, Flex, Input, Level, Output, Pin as _, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::rcc::mux::Adcsel;
use embassy_stm32::rcc::{Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk};
use embassy_stm32::time::Hertz;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Config, Peri, pac};
use sinew_front_end::ResetCause;
use sinew_front_end_board::nucleo::{self, CLOCK_MHZ, NAME, ResetFlags, reset_cause};
use sinew_front_end_board::{WATCHDOG_NS, identification, version};

use crate::board::Board;
use crate::converter::Converter;
use crate::outputs::{Outputs, cut};

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_stm32::init(clocks());
    let reset = why_reset();
    // From here on whoever stands still is reset, and fed only below, by the loop that polls.
    let mut watchdog = IndependentWatchdog::new(p.IWDG, WATCHDOG_NS / 1000);
    watchdog.unleash();
    // The line first, since eight bytes of it wait; then the interrupt that reads the converter, which nothing else holds up but critical
    // sections.
    interrupt::TIM3.set_priority(Priority::P3);

    let outputs = Outputs::new(
        [p.PC0.into(), p.PC1.into(), p.PC2.into(), p.PC3.into()],
        p.PC6.into(),
        [p.PB10.into(), p.PB7.into()],
    );
    let stop_reset = Input::new(here(p.PC4.into(), nucleo::STOP_RESET), Pull::Up);
    let light = Output::new(here(p.PA5.into(), nucleo::LED), Level::Low, Speed::Low);
    line::start(p.PA2.into(), p.PA3.into());
    let lines = [p.PB12.into(), p.PB13.into(), p.PB14.into(), p.PB15.into()];
    let converter = Converter::new(p.PB11.into(), p.PB1.into(), p.PB2.into(), lines).await;
    let adc = Adc::new(p.ADC1, AdcConfig::default());
    let mut board = Board { outputs, converter, adc, supply: p.PA0, stop_reset, light, is_watched: false };

    let version =
        version(env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH"));
    let who = identification(NAME, version, nucleo::serial([0, 1, 2].map(|n| pac::UID.uid(n).read())), reset);
    sinew_firmware_common::run(who, &mut board, || watchdog.pet(), async |_: &mut Board| outputs::stopped().await).await
}

/// 120 MHz by the Nucleo's crystal of 24 MHz: an eighth of it is the converter's clock.
fn clocks() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(Hse { freq: Hertz::mhz(24), mode: HseMode::Oscillator });
    config.rcc.pll = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV6,
        mul: PllMul::MUL60,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    const { assert!(24 / 6 * 60 / 2 == CLOCK_MHZ) };
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.hsi48 = None;
    config.rcc.mux.adc12sel = Adcsel::SYS;
    config
}

/// A pin, which has to be the one of the table.
fn here(pin: Peri<'static, AnyPin>, of: nucleo::Pin) -> Peri<'static, AnyPin> {
    assert!(pin.port() == of.port && pin.pin() == of.number);
    pin
}

/// A pin of the table, which the peripheral that the table names has.
fn attach(pin: Peri<'static, AnyPin>, of: nucleo::Pin, kind: AfType) -> Flex<'static> {
    let mut pin = Flex::new(here(pin, of));
    pin.set_as_af_unchecked(of.function.expect("the table says which function"), kind);
    pin
}

/// The same, for ever.
fn give(pin: Peri<'static, AnyPin>, of: nucleo::Pin, kind: AfType) {
    core::mem::forget(attach(pin, of, kind));
}

/// The flags gather until they are cleared.
fn why_reset() -> ResetCause {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    reset_cause(ResetFlags {
        watchdog: flags.iwdgrstf() || flags.wwdgrstf(),
        software: flags.sftrstf(),
        other: flags.oblrstf() || flags.lpwrrstf(),
        supply: flags.borrstf(),
    })
}

/// Off by the timers, then the watchdog resets.
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

/// The clock has failed: the timers' break has switched off already. Whatever else comes and nobody has asked for.
#[cortex_m_rt::exception]
unsafe fn DefaultHandler(_: i16) {
    cut();
    loop {
        cortex_m::asm::nop();
    }
}
