//! The wires' outputs, the four of TIM1, and the master switch, the first of TIM8.
//!
//! TIM1 counts a period once and stops (one-pulse mode). Each output is on from its beginning to its compare value, and the compare values
//! that come into force at its end are 0: an output is off then, and stays so until the next period is written, whatever becomes of the
//! processor.
//!
//! The contact of the emergency stop is the break input of both timers: open, it takes their outputs low without the processor and without a
//! clock, and neither lets them on again by itself. So do the processor's lock-up, a supply below 2.9 V, a memory that is not what was
//! written to it, and a crystal that stands still. What of this is set up is locked until the next reset.

use embassy_stm32::gpio::{AfType, AnyPin, Flex, OutputType, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac::timer::TimAdv;
use embassy_stm32::pac::timer::vals::{Bkp, Lock, Mms, Ocm, Ossi, Ossr, Urs};
use embassy_stm32::{Peri, pac, peripherals, rcc};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use sinew_front_end_board::CHANNELS;
use sinew_front_end_board::nucleo::{self, Pulses};

use crate::{attach, give};

const GATES: TimAdv = pac::TIM1;
const MASTER: TimAdv = pac::TIM8;
/// The voltage detector at 2.9 V.
const DETECTOR_2_9_V: u8 = 6;

/// A break that nobody has looked at.
static BROKEN: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Until the emergency stop, or whatever else is a break, has switched off.
pub async fn stopped() {
    BROKEN.wait().await;
}

/// The four outputs and the master switch.
pub struct Outputs {
    /// The emergency stop's contact, which both timers see: low = closed.
    stop: [Flex<'static>; 2],
}

impl Outputs {
    /// All off; of their pins, and the two by which the emergency stop comes in.
    pub fn new(
        gates: [Peri<'static, AnyPin>; CHANNELS],
        enable: Peri<'static, AnyPin>,
        stop: [Peri<'static, AnyPin>; 2],
    ) -> Outputs {
        rcc::enable_and_reset::<peripherals::TIM1>();
        rcc::enable_and_reset::<peripherals::TIM8>();
        pac::PWR.cr2().modify(|w| {
            w.set_pls(DETECTOR_2_9_V);
            w.set_pvde(true);
        });
        pac::SYSCFG.cfgr2().write(|w| {
            w.set_cll(true);
            w.set_spl(true);
            w.set_pvdl(true);
            w.set_eccl(true);
        });
        pac::RCC.cr().modify(|w| w.set_csson(true));
        let [stop, stop_enable] = stop;
        let contact = AfType::input(Pull::Up);
        let stop = [attach(stop, nucleo::STOP, contact), attach(stop_enable, nucleo::STOP_ENABLE, contact)];

        GATES.cr1().write(|w| {
            w.set_opm(true);
            w.set_arpe(true);
            w.set_urs(Urs::COUNTER_ONLY);
        });
        // What starts it starts the converter's trigger.
        GATES.cr2().write(|w| w.set_mms(Mms::ENABLE));
        for output in 0..CHANNELS {
            GATES.ccmr_output(output / 2).modify(|w| {
                w.set_ocm(output % 2, Ocm::PWM_MODE1);
                w.set_ocpe(output % 2, true);
            });
        }
        MASTER.ccmr_output(0).modify(|w| w.set_ocm(0, Ocm::FORCE_ACTIVE));
        MASTER.ccer().write(|w| w.set_cce(0, true));
        GATES.ccer().write(|w| (0..CHANNELS).for_each(|output| w.set_cce(output, true)));
        for timer in [GATES, MASTER] {
            timer.bdtr().write(|w| {
                w.set_bke(0, true);
                // Open is high, and so is a broken lead.
                w.set_bkp(0, Bkp::ACTIVE_HIGH);
                // Off is low, and not let go of.
                w.set_ossi(Ossi::IDLE_LEVEL);
                w.set_ossr(Ossr::IDLE_LEVEL);
                w.set_aoe(false);
                w.set_lock(Lock::LEVEL3);
            });
        }
        let fast = AfType::output(OutputType::PushPull, Speed::High);
        for (pin, of) in gates.into_iter().zip(nucleo::GATES) {
            give(pin, of, fast);
        }
        give(enable, nucleo::ENABLE, fast);
        interrupt::TIM1_BRK_TIM15.set_priority(Priority::P2);
        // SAFETY: the handler is `TIM1_BRK_TIM15` below, and what it touches is there.
        unsafe { interrupt::TIM1_BRK_TIM15.enable() };
        GATES.dier().write(|w| w.set_bie(true));
        Outputs { stop }
    }

    /// Off, with the pulses of a period ready for [`Outputs::go`].
    pub fn load(&self, pulses: &Pulses) {
        self.stop();
        GATES.psc().write_value(pulses.prescaler);
        GATES.arr().write(|w| w.set_arr(pulses.reload));
        for (output, compare) in pulses.compare.into_iter().enumerate() {
            GATES.ccr(output).write(|w| w.set_ccr(compare));
        }
        GATES.egr().write(|w| w.set_ug(true));
        // And at its end:
        for output in 0..CHANNELS {
            GATES.ccr(output).write(|w| w.set_ccr(0));
        }
    }

    /// The period. It counts before anything is on, so that the end of what is on is certain; then all pulses begin at once. After a break they
    /// do not.
    pub fn go(&self) {
        GATES.cr1().modify(|w| w.set_cen(true));
        if !self.is_broken() {
            GATES.bdtr().modify(|w| w.set_moe(true));
        }
    }

    /// All off.
    pub fn stop(&self) {
        GATES.bdtr().modify(|w| w.set_moe(false));
        GATES.cr1().modify(|w| w.set_cen(false));
    }

    /// The master switch. After a break it does not go on.
    pub fn enable(&self, on: bool) {
        MASTER.bdtr().modify(|w| w.set_moe(on && !self.is_broken()));
    }

    /// Whether the emergency stop's contact is closed, and was since this was last asked. Asked while it is closed, this forgets that it was open:
    /// outputs may go on again, but only with the next period, and the master switch only when it is switched on.
    pub fn is_closed(&self) -> bool {
        let was_broken = self.is_broken();
        let closed = self.stop.iter().all(Flex::is_low);
        if closed && was_broken {
            for timer in [GATES, MASTER] {
                // Bits of it are cleared by 0.
                timer.sr().write(|w| {
                    w.0 = !0;
                    w.set_bif(0, false);
                    w.set_sbif(false);
                });
            }
            // A break that lasts wakes nobody again.
            GATES.dier().write(|w| w.set_bie(!self.is_broken()));
        }
        closed && !was_broken
    }

    /// Whether a break has switched off and nobody has cleared it.
    pub fn is_broken(&self) -> bool {
        [GATES, MASTER].iter().any(|timer| {
            let flags = timer.sr().read();
            flags.bif(0) || flags.sbif()
        })
    }
}

/// A break: all is off already; the loop is woken, and told of no other until it has looked.
#[embassy_stm32::interrupt]
fn TIM1_BRK_TIM15() {
    GATES.dier().write(|w| w.set_bie(false));
    BROKEN.signal(());
}

/// Everything off by the timers themselves, with nothing else of the firmware whole. Nobody switches on again before the next reset.
pub fn cut() {
    for timer in [GATES, MASTER] {
        timer.bdtr().modify(|w| w.set_moe(false));
    }
}
