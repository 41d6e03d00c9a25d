//! The AD7616. PIO 1 triggers its sweeps at their instants, whatever the processor is at: state machine 0 counts down and pulses CONVST,
//! state machine 1 follows BUSY and interrupts when a sweep is over. The interrupt reads the words and has them collected.

use core::cell::RefCell;

use critical_section::Mutex;
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::interrupt::{self, InterruptExt, Priority};
use embassy_rp::pac;
use embassy_rp::pac::pads::vals::Drive;
use embassy_rp::peripherals::{PIN_10, PIN_11, PIN_12, PIN_16, PIN_17, PIN_18, PIN_19, PIO1, SPI0};
use embassy_rp::pio::program::pio_asm;
use embassy_rp::pio::{Config, Direction, InterruptHandler, Pio};
use embassy_rp::{Peri, bind_interrupts};
use embassy_time::{Instant, Timer};
use sinew_front_end::RawSample;
use sinew_front_end_board::ad7616::{NOTHING, WORDS, configure};
use sinew_front_end_board::{Collector, Plan, pico};

use crate::outputs::forget;

bind_interrupts!(struct Irqs {
    PIO1_IRQ_0 => InterruptHandler<PIO1>;
});

/// `set pins, 0`.
const LOW: u16 = 0xe000;
/// State machines, and the flag by which the second one interrupts.
const TRIGGER: u8 = 1 << 0;
const FOLLOW: u8 = 1 << 1;
const SWEPT: u8 = 1 << 0;
/// Words the SPI takes without waiting.
const QUEUE: usize = 8;
/// SPI clock: 125 MHz / (2 × 4) = 15.6 MHz; the converter allows more, but half a clock has to be enough for its answer and both ends' pads.
const PRESCALE: u8 = 2;
const DIVIDE: u8 = 4;

static COLLECTOR: Mutex<RefCell<Collector>> = Mutex::new(RefCell::new(Collector::new()));

/// The pins and peripherals it stands on.
pub struct Pins {
    /// Trigger.
    pub pio: Peri<'static, PIO1>,
    /// SPI.
    pub spi: Peri<'static, SPI0>,
    /// CONVST, BUSY, RESET.
    pub control: (Peri<'static, PIN_10>, Peri<'static, PIN_11>, Peri<'static, PIN_12>),
    /// SDOA, CS, SCLK, SDI.
    pub lines: (Peri<'static, PIN_16>, Peri<'static, PIN_17>, Peri<'static, PIN_18>, Peri<'static, PIN_19>),
}

/// The converter.
pub struct Converter {
    /// Where the trigger's program begins.
    origin: u8,
    /// Whether its registers read back as they were written.
    answers: bool,
}

impl Converter {
    /// Resets and configures it.
    pub async fn new(of: Pins) -> Converter {
        let mut reset = Output::new(of.control.2, Level::Low);
        let busy = Input::new(of.control.1, Pull::Down);
        let mut pio = Pio::new(of.pio, Irqs);
        let trigger = pio_asm!(
            ".wrap_target",
            "    pull block",
            "    mov x, osr",
            "count:",
            "    jmp x-- count",
            "    set pins, 1 [15]",
            "    set pins, 0",
            ".wrap",
        );
        let follow = pio_asm!(".wrap_target", "wait 1 gpio 11", "wait 0 gpio 11", "irq set 0", ".wrap",);
        const { assert!(pico::BUSY == 11) };
        let trigger = pio.common.load_program(&trigger.program);
        let follow = pio.common.load_program(&follow.program);
        let convst = pio.common.make_pio_pin(of.control.0);
        let mut config = Config::default();
        config.use_program(&trigger, &[]);
        config.set_set_pins(&[&convst]);
        pio.sm0.set_config(&config);
        pio.sm0.set_pins(Level::Low, &[&convst]);
        pio.sm0.set_pin_dirs(Direction::Out, &[&convst]);
        let mut config = Config::default();
        config.use_program(&follow, &[]);
        pio.sm1.set_config(&config);

        // 16 bits, clock idle high, sampled at its first (falling) edge: the chip select in hardware then frames every word.
        for pin in [pico::SDOA, pico::CS, pico::SCLK, pico::SDI] {
            pac::PADS_BANK0.gpio(pin.into()).write(|w| {
                w.set_ie(true);
                w.set_schmitt(true);
                w.set_slewfast(true);
                w.set_drive(Drive::_8M_A);
            });
            pac::IO_BANK0.gpio(pin.into()).ctrl().write(|w| w.set_funcsel(1));
        }
        pac::SPI0.cpsr().write(|w| w.set_cpsdvsr(PRESCALE));
        pac::SPI0.cr0().write(|w| {
            w.set_dss(15);
            w.set_spo(true);
            w.set_scr(DIVIDE - 1);
        });
        pac::SPI0.cr1().write(|w| w.set_sse(true));

        // 1.2 µs of reset, 15 ms until it is configurable.
        Timer::after_micros(10).await;
        reset.set_high();
        Timer::after_millis(20).await;
        let mut converter = Converter { origin: trigger.origin, answers: false };
        core::mem::forget((pio, convst, trigger, follow, reset, busy, of.spi, of.lines));
        converter.stop();
        converter.configure();
        interrupt::PIO1_IRQ_1.set_priority(Priority::P0);
        pac::PIO1.irqs(1).inte().write(|w| w.set_sm0(true));
        // SAFETY: the handler is `PIO1_IRQ_1` below, and what it touches is there.
        unsafe { interrupt::PIO1_IRQ_1.enable() };
        converter
    }

    /// Writes its registers and reads them back; to be called while nothing is swept. One that does not answer is not triggered.
    pub fn configure(&mut self) {
        self.answers = configure(transfer);
    }

    /// The sweeps of a period, ready for [`Converter::go`]; none where it does not answer.
    pub fn load(&self, plan: Plan) -> Plan {
        let plan = if self.answers { plan } else { Plan::NONE };
        self.stop();
        for count in pico::triggers(&plan) {
            pac::PIO1.txf(0).write_value(count);
        }
        plan
    }

    /// The period: its sweeps count from now.
    pub fn go(&self, plan: Plan) {
        pac::PIO1.ctrl().write(|w| w.set_sm_enable(TRIGGER | FOLLOW));
        let now_us = Instant::now().as_micros();
        critical_section::with(|cs| COLLECTOR.borrow_ref_mut(cs).begin(plan, now_us));
    }

    /// No more sweeps. One that has begun goes on, and belongs to nobody.
    pub fn stop(&self) {
        critical_section::with(|cs| {
            pac::PIO1.ctrl().write(|w| {
                w.set_sm_enable(FOLLOW);
                w.set_sm_restart(TRIGGER);
            });
            let machine = pac::PIO1.sm(0);
            machine.instr().write(|w| w.set_instr(LOW));
            machine.instr().write(|w| w.set_instr(self.origin.into()));
            forget(machine);
            COLLECTOR.borrow_ref_mut(cs).begin(Plan::NONE, 0);
        });
    }

    /// What the period's sweeps gave. Waits for the last one, some 40 µs: it ends at the instant at which it is asked for.
    pub fn samples(&self, supply: u16, samples: &mut [RawSample]) {
        while {
            let now_us = Instant::now().as_micros();
            critical_section::with(|cs| COLLECTOR.borrow_ref(cs).is_near(now_us))
        } {}
        critical_section::with(|cs| COLLECTOR.borrow_ref(cs).samples(supply, samples));
    }
}

/// Sends a word, and gives what came meanwhile.
fn transfer(word: u16) -> u16 {
    pac::SPI0.dr().write(|w| w.set_data(word));
    while !pac::SPI0.sr().read().rne() {}
    pac::SPI0.dr().read().data()
}

/// A sweep is over.
#[embassy_rp::interrupt]
fn PIO1_IRQ_1() {
    pac::PIO1.irq().write(|w| w.set_irq(SWEPT));
    let mut words = [0; WORDS];
    for _ in 0..QUEUE {
        pac::SPI0.dr().write(|w| w.set_data(NOTHING));
    }
    for (index, word) in words.iter_mut().enumerate() {
        while !pac::SPI0.sr().read().rne() {}
        *word = pac::SPI0.dr().read().data();
        if index + QUEUE < WORDS {
            pac::SPI0.dr().write(|w| w.set_data(NOTHING));
        }
    }
    critical_section::with(|cs| COLLECTOR.borrow_ref_mut(cs).swept(&words, Instant::now().as_micros()));
}
