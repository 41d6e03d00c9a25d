//! The AD7616. TIM2, which TIM1 starts with a period, triggers its sweeps at their instants, whatever the processor is at; that BUSY falls is
//! an interrupt, which writes the next instant, reads the words and has them collected.

use core::cell::RefCell;

use critical_section::Mutex;
use embassy_stm32::gpio::{AfType, AnyPin, Input, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac::spi::vals::{Br, Cpha, Cpol, Ds, Frxth, Mstr};
use embassy_stm32::pac::timer::vals::{Ocm, Sms, Ts};
use embassy_stm32::pac::{EXTI, SPI2 as SPI, SYSCFG, TIM2 as TRIGGER};
use embassy_stm32::{Peri, peripherals, rcc};
use embassy_time::{Instant, Timer};
use sinew_front_end::RawSample;
use sinew_front_end_board::ad7616::{NOTHING, WORDS, configure};
use sinew_front_end_board::nucleo::{ADC_RESET, BUSY, CONVST, CS, SCLK, SDI, SDOA, trigger};
use sinew_front_end_board::{Collector, Plan};

use crate::{give, here};

/// TIM2's output that is CONVST: the fourth, the second of its second register of modes.
const OUTPUT: usize = 3;
/// Words that the SPI takes without waiting.
const QUEUE: usize = 2;

/// The present period: what came of it, and what is still to be swept.
static PERIOD: Mutex<RefCell<(Collector, Plan, usize)>> = Mutex::new(RefCell::new((Collector::new(), Plan::NONE, 0)));

/// The converter.
pub struct Converter {
    /// Whether its registers read back as they were written.
    answers: bool,
}

impl Converter {
    /// Resets and configures it; of CONVST, BUSY, RESET, and CS, SCLK, SDOA, SDI.
    pub async fn new(
        convst: Peri<'static, AnyPin>,
        busy: Peri<'static, AnyPin>,
        reset: Peri<'static, AnyPin>,
        lines: [Peri<'static, AnyPin>; 4],
    ) -> Converter {
        let mut reset = Output::new(here(reset, ADC_RESET), Level::Low, Speed::Low);
        let busy = Input::new(here(busy, BUSY), Pull::Down);
        rcc::enable_and_reset::<peripherals::TIM2>();
        rcc::enable_and_reset::<peripherals::SPI2>();
        TRIGGER.smcr().write(|w| {
            // Trigger 0 is TIM1.
            w.set_ts(Ts::ITR0);
            w.set_sms(Sms::COMBINED_RESET_TRIGGER);
        });
        set(Ocm::FORCE_INACTIVE);
        TRIGGER.ccer().write(|w| w.set_cce(OUTPUT, true));
        let fast = AfType::output(OutputType::PushPull, Speed::VeryHigh);
        give(convst, CONVST, fast);
        let [cs, sclk, sdoa, sdi] = lines;
        give(cs, CS, fast);
        give(sclk, SCLK, fast);
        give(sdoa, SDOA, AfType::input(Pull::None));
        give(sdi, SDI, fast);
        // 16 bits at 15 MHz, clock idle high, sampled at its first (falling) edge: the chip select in hardware then frames every word. The
        // converter allows more, but half a clock has to be enough for its answer and both ends' pads.
        SPI.cr2().write(|w| {
            w.set_ds(Ds::BITS16);
            w.set_frxth(Frxth::HALF);
            w.set_ssoe(true);
            w.set_nssp(true);
        });
        SPI.cr1().write(|w| {
            w.set_mstr(Mstr::MASTER);
            w.set_cpol(Cpol::IDLE_HIGH);
            w.set_cpha(Cpha::FIRST_EDGE);
            w.set_br(Br::DIV8);
            w.set_spe(true);
        });

        // 1.2 µs of reset, 15 ms until it is configurable.
        Timer::after_micros(10).await;
        reset.set_high();
        Timer::after_millis(20).await;
        core::mem::forget((reset, busy));
        let mut converter = Converter { answers: false };
        converter.configure();
        const LINE: usize = BUSY.number as usize;
        SYSCFG.exticr(LINE / 4).modify(|w| w.set_exti(LINE % 4, BUSY.port));
        EXTI.ftsr(0).modify(|w| w.set_line(LINE, true));
        EXTI.imr(0).modify(|w| w.set_line(LINE, true));
        const { assert!(LINE == 1, "its interrupt is below") };
        interrupt::EXTI1.set_priority(Priority::P1);
        // SAFETY: the handler is `EXTI1` below, and what it touches is there.
        unsafe { interrupt::EXTI1.enable() };
        converter
    }

    /// Writes its registers and reads them back; to be called while nothing is swept. One that does not answer is not triggered.
    pub fn configure(&mut self) {
        self.answers = configure(transfer);
    }

    /// The sweeps of a period that begins with TIM1's; none where it does not answer.
    pub fn load(&self, plan: Plan) {
        self.stop();
        let plan = if self.answers { plan } else { Plan::NONE };
        let now_us = Instant::now().as_micros();
        critical_section::with(|cs| {
            let (collector, planned, next) = &mut *PERIOD.borrow_ref_mut(cs);
            collector.begin(plan, now_us);
            (*planned, *next) = (plan, 0);
            arm(planned, next);
        });
    }

    /// No more sweeps. One that has begun goes on, and belongs to nobody.
    pub fn stop(&self) {
        critical_section::with(|cs| {
            set(Ocm::FORCE_INACTIVE);
            TRIGGER.cr1().modify(|w| w.set_cen(false));
            TRIGGER.cnt().write_value(0);
            let (collector, planned, _) = &mut *PERIOD.borrow_ref_mut(cs);
            collector.begin(Plan::NONE, 0);
            *planned = Plan::NONE;
        });
    }

    /// What the period's sweeps gave. Waits for the last one, some 40 µs: it ends at the instant at which it is asked for.
    pub fn samples(&self, supply: u16, samples: &mut [RawSample]) {
        while {
            let now_us = Instant::now().as_micros();
            critical_section::with(|cs| PERIOD.borrow_ref(cs).0.is_near(now_us))
        } {}
        critical_section::with(|cs| PERIOD.borrow_ref(cs).0.samples(supply, samples));
    }
}

/// What CONVST does.
fn set(mode: Ocm) {
    TRIGGER.ccmr_output(OUTPUT / 2).modify(|w| w.set_ocm(OUTPUT % 2, mode));
}

/// CONVST low, and high at the next instant of a plan, where there is one.
fn arm(plan: &Plan, next: &mut usize) {
    set(Ocm::FORCE_INACTIVE);
    if let Some(sweep) = plan.sweeps().get(*next) {
        *next += 1;
        TRIGGER.ccr(OUTPUT).write_value(trigger(sweep.at_ns));
        set(Ocm::ACTIVE_ON_MATCH);
    }
}

/// Sends a word, and gives what came meanwhile.
fn transfer(word: u16) -> u16 {
    SPI.dr16().write_value(word);
    while !SPI.sr().read().rxne() {}
    SPI.dr16().read()
}

/// A sweep is over.
#[embassy_stm32::interrupt]
fn EXTI1() {
    EXTI.pr(0).write(|w| w.set_line(BUSY.number.into(), true));
    critical_section::with(|cs| {
        let (_, plan, next) = &mut *PERIOD.borrow_ref_mut(cs);
        arm(plan, next);
    });
    let mut words = [0; WORDS];
    for _ in 0..QUEUE {
        SPI.dr16().write_value(NOTHING);
    }
    for (index, word) in words.iter_mut().enumerate() {
        while !SPI.sr().read().rxne() {}
        *word = SPI.dr16().read();
        if index + QUEUE < WORDS {
            SPI.dr16().write_value(NOTHING);
        }
    }
    critical_section::with(|cs| PERIOD.borrow_ref_mut(cs).0.swept(&words, Instant::now().as_micros()));
}
