//! The wires' outputs: one state machine of PIO 0 each. It makes one pulse a count it is given and then waits for the next with its pin
//! low, whatever becomes of the processor.

use embassy_rp::gpio::Level;
use embassy_rp::pac;
use embassy_rp::pac::io::vals::Outover;
use embassy_rp::peripherals::{PIN_2, PIN_3, PIN_4, PIN_5, PIO0};
use embassy_rp::pio::program::pio_asm;
use embassy_rp::pio::{Config, Direction, InterruptHandler, Pio, StateMachine};
use embassy_rp::{Peri, bind_interrupts};
use sinew_front_end_board::{CHANNELS, pico};

bind_interrupts!(struct Irqs {
    PIO0_IRQ_0 => InterruptHandler<PIO0>;
});

const ALL: u8 = (1 << CHANNELS) - 1;
/// `set pins, 0`.
const LOW: u16 = 0xe000;

/// The four outputs.
pub struct Outputs {
    /// Where the program begins: `jmp` to there is its number.
    origin: u8,
}

impl Outputs {
    /// All off.
    pub fn new(
        pio: Peri<'static, PIO0>,
        gates: (Peri<'static, PIN_2>, Peri<'static, PIN_3>, Peri<'static, PIN_4>, Peri<'static, PIN_5>),
    ) -> Outputs {
        let mut pio = Pio::new(pio, Irqs);
        let program = pio_asm!(
            ".wrap_target",
            "    pull block",
            "    mov x, osr",
            "    set pins, 1",
            "on:",
            "    jmp x-- on",
            "    set pins, 0",
            ".wrap",
        );
        let program = pio.common.load_program(&program.program);
        let pins = [
            pio.common.make_pio_pin(gates.0),
            pio.common.make_pio_pin(gates.1),
            pio.common.make_pio_pin(gates.2),
            pio.common.make_pio_pin(gates.3),
        ];
        fn set_up<const SM: usize>(
            machine: &mut StateMachine<'static, PIO0, SM>,
            program: &embassy_rp::pio::LoadedProgram<'static, PIO0>,
            pin: &embassy_rp::pio::Pin<'static, PIO0>,
        ) {
            let mut config = Config::default();
            config.use_program(program, &[]);
            config.set_set_pins(&[pin]);
            machine.set_config(&config);
            machine.set_pins(Level::Low, &[pin]);
            machine.set_pin_dirs(Direction::Out, &[pin]);
        }
        set_up(&mut pio.sm0, &program, &pins[0]);
        set_up(&mut pio.sm1, &program, &pins[1]);
        set_up(&mut pio.sm2, &program, &pins[2]);
        set_up(&mut pio.sm3, &program, &pins[3]);
        let outputs = Outputs { origin: program.origin };
        // Dropped, they would give up their pins; they are driven by their registers from here on.
        core::mem::forget((pio, pins, program));
        outputs.stop();
        outputs
    }

    /// Off, with the pulses of a period ready for [`Outputs::go`].
    pub fn load(&self, pulses: &[Option<u32>; CHANNELS]) {
        self.stop();
        for (machine, pulse) in pulses.iter().enumerate() {
            if let Some(count) = *pulse {
                pac::PIO0.txf(machine).write_value(count);
            }
        }
    }

    /// The period: all pulses begin at once.
    pub fn go(&self) {
        pac::PIO0.ctrl().write(|w| w.set_sm_enable(ALL));
    }

    /// All off, and nothing left to be put out.
    pub fn stop(&self) {
        critical_section::with(|_| {
            pac::PIO0.ctrl().write(|w| w.set_sm_restart(ALL));
            for machine in (0..CHANNELS).map(|machine| pac::PIO0.sm(machine)) {
                machine.instr().write(|w| w.set_instr(LOW));
                machine.instr().write(|w| w.set_instr(self.origin.into()));
                forget(machine);
            }
        });
    }
}

/// Empties a state machine's queues: joining and parting them does.
pub fn forget(machine: pac::pio::StateMachine) {
    machine.shiftctrl().modify(|w| w.set_fjoin_rx(!w.fjoin_rx()));
    machine.shiftctrl().modify(|w| w.set_fjoin_rx(!w.fjoin_rx()));
}

/// Everything off by the pins themselves, with nothing else of the firmware whole. Only a reset ends it.
pub fn cut() {
    pac::PIO0.ctrl().write_value(Default::default());
    for pin in pico::GATES.into_iter().chain([pico::ENABLE]) {
        pac::IO_BANK0.gpio(pin.into()).ctrl().modify(|w| w.set_outover(Outover::LOW));
    }
}
