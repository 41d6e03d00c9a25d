//! What the firmware of the protocol asks of this board.

use embassy_rp::adc::{Adc, Blocking, Channel};
use embassy_rp::gpio::{Input, Output};
use sinew_firmware_common::line;
use sinew_front_end::{Event, Hardware, RawSample, StopPins};
use sinew_front_end_board::{CHANNELS, MIN_ON_NS, Plan, pico, supply_code};

use crate::converter::Converter;
use crate::outputs::Outputs;

/// Peripherals and pins.
pub struct Board {
    /// The wires' gates.
    pub outputs: Outputs,
    /// The converter.
    pub converter: Converter,
    /// The RP2040's own one, for the supply.
    pub adc: Adc<'static, Blocking>,
    /// Its input.
    pub supply: Channel<'static>,
    /// The master switch.
    pub enable: Output<'static>,
    /// The emergency stop's contact: low = closed.
    pub stop: Input<'static>,
    /// Its reset button: low = pressed.
    pub stop_reset: Input<'static>,
    /// On while outputs follow the driver.
    pub light: Output<'static>,
}

impl Hardware for Board {
    const MIN_ON_NS: u64 = MIN_ON_NS as u64;

    fn begin_period(&mut self, duty: &[u16], period_ns: u32) {
        let plan = Plan::new(duty, period_ns);
        let mut pulses = [None; CHANNELS];
        for (pulse, duty) in pulses.iter_mut().zip(duty) {
            *pulse = pico::pulse(*duty, period_ns);
        }
        // What takes time comes first, so that pulses and conversions begin together; and nothing comes between: an output is on when
        // its end is certain.
        critical_section::with(|_| {
            let plan = self.converter.load(plan);
            self.outputs.load(&pulses);
            self.outputs.go();
            self.converter.go(plan);
        });
    }

    fn off(&mut self) {
        self.outputs.stop();
        self.converter.stop();
    }

    fn samples(&mut self, samples: &mut [RawSample]) {
        let supply = self.adc.blocking_read(&mut self.supply).map_or(sinew_front_end::NOT_SAMPLED, supply_code);
        self.converter.samples(supply, samples);
    }

    fn enable(&mut self, on: bool) {
        self.enable.set_level(on.into());
    }

    fn stop_inputs(&mut self) -> Option<StopPins> {
        Some(StopPins { closed: self.stop.is_low(), reset_pressed: self.stop_reset.is_low() })
    }

    fn send(&mut self, frame: &[u8]) {
        line::send(frame);
    }

    fn tell(&mut self, event: Event) {
        match event {
            // Everything is off: the moment to see whether the converter is still what it was.
            Event::Configured { .. } => self.converter.configure(),
            Event::Running => self.light.set_high(),
            Event::Silent { .. } | Event::Off | Event::Stopped | Event::Refused(_) => self.light.set_low(),
            Event::Fault { .. } => {}
        }
    }
}
