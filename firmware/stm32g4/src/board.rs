//! What the firmware of the protocol asks of this board.

use embassy_stm32::Peri;
use embassy_stm32::adc::{Adc, SampleTime};
use embassy_stm32::gpio::{Input, Output};
use embassy_stm32::peripherals::{ADC1, PA0};
use sinew_firmware_common::line::send;
use sinew_front_end::{ChannelFault, Event, Hardware, RawSample, StopPins};
use sinew_front_end_board::nucleo::Pulses;
use sinew_front_end_board::{MIN_ON_NS, Plan, supply_code};

use crate::converter::Converter;
use crate::line;
use crate::outputs::Outputs;

/// Peripherals and pins.
pub struct Board {
    /// The wires' gates, the master switch, and the emergency stop that switches both off.
    pub outputs: Outputs,
    /// The converter.
    pub converter: Converter,
    /// The STM32's own one, for the supply.
    pub adc: Adc<'static, ADC1>,
    /// Its input.
    pub supply: Peri<'static, PA0>,
    /// The emergency stop's reset button: low = pressed.
    pub stop_reset: Input<'static>,
    /// On while outputs follow the driver.
    pub light: Output<'static>,
    /// Whether this configuration looks at the emergency stop.
    pub is_watched: bool,
}

impl Hardware for Board {
    const MIN_ON_NS: u64 = MIN_ON_NS as u64;

    fn begin_period(&mut self, duty: &[u16], period_ns: u32) {
        let (plan, pulses) = (Plan::new(duty, period_ns), Pulses::new(duty, period_ns));
        // What takes time comes first, and nothing comes between: an output is on when its end is certain.
        critical_section::with(|_| {
            self.outputs.load(&pulses);
            self.converter.load(plan);
            self.outputs.go();
        });
    }

    fn off(&mut self) {
        self.outputs.stop();
        self.converter.stop();
    }

    fn samples(&mut self, samples: &mut [RawSample]) {
        let supply = supply_code(self.adc.blocking_read(&mut self.supply, SampleTime::CYCLES47_5));
        self.converter.samples(supply, samples);
    }

    /// Whoever does not look at the emergency stop is told that the stages do not switch on.
    fn stage_fault(&mut self, _channel: usize) -> Option<ChannelFault> {
        (!self.is_watched && self.outputs.is_broken()).then_some(ChannelFault::Stage)
    }

    fn enable(&mut self, on: bool) {
        self.outputs.enable(on);
    }

    fn stop_inputs(&mut self) -> Option<StopPins> {
        self.is_watched = true;
        Some(StopPins { closed: self.outputs.is_closed(), reset_pressed: self.stop_reset.is_low() })
    }

    fn send(&mut self, frame: &[u8]) {
        send(frame);
        line::wake();
    }

    fn tell(&mut self, event: Event) {
        match event {
            // Everything is off: the moment to see whether the converter is still what it was, and, where the emergency stop is not
            // looked at, to forget that it was open.
            Event::Configured { .. } => {
                self.is_watched = false;
                self.outputs.is_closed();
                self.converter.configure();
            }
            Event::Running => self.light.set_high(),
            Event::Silent { .. } | Event::Off | Event::Stopped | Event::Refused(_) => self.light.set_low(),
            Event::Fault { .. } => {}
        }
    }
}
