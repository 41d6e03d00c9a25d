//! The latch of an emergency stop.
//!
//! ```text
//!   latched --- contact closed, and then reset: by its own input, or at the driver's terminal --> released
//!      ^                                                                                            |
//!      '------------------- contact open, or nothing known of it, for one period -------------------'
//! ```
//!
//! It begins latched: nobody has shown yet that the contact works. No client resets it; being reset permits and starts nothing: every
//! channel stays off with its fault until it is reset in turn.

use sinew_backend::{Backend, StopInputs};

use crate::engine::Engine;

/// Whether the emergency stop holds everything off.
#[derive(Debug, Clone, Copy, Default)]
pub struct EmergencyStop {
    /// Whether the backend has one.
    is_fitted: bool,
    is_latched: bool,
    /// Whether the reset input was seen released since it has been latched: a button that is jammed, or bridged, resets nothing.
    was_released: bool,
}

impl EmergencyStop {
    /// Takes what its inputs show in a cycle, `None` where there is none, and whether it was reset at the terminal since the last one. Gives
    /// whether it holds everything off. Constant time.
    #[inline]
    pub fn look(&mut self, inputs: Option<StopInputs>, reset_at_terminal: bool) -> bool {
        let Some(inputs) = inputs else {
            // One that was there and shows nothing any more is as good as open.
            self.is_latched = self.is_fitted;
            return self.is_latched;
        };
        let StopInputs { is_closed, is_reset_pressed } = inputs;
        if !self.is_fitted || !is_closed {
            (self.is_fitted, self.is_latched, self.was_released) = (true, true, !is_reset_pressed);
            return true;
        }
        if self.is_latched {
            let by_input = is_reset_pressed && self.was_released;
            self.is_latched = !(by_input || reset_at_terminal);
            self.was_released |= !is_reset_pressed;
        }
        self.is_latched
    }
}

/// What stands above all outputs, between engine and backend: the emergency stop, and the switch of the supply.
#[derive(Debug, Clone, Copy, Default)]
pub struct SupplySwitch {
    stop: EmergencyStop,
    is_cut: bool,
}

impl SupplySwitch {
    /// Before the first exchange: where there is an emergency stop, nothing is supplied until it was reset.
    pub fn begin(&mut self, backend: &mut impl Backend) {
        self.is_cut = backend.stop_inputs().is_some();
        if self.is_cut {
            backend.cut();
        }
    }

    /// Between exchange and cycle: tells the engine of the emergency stop.
    #[inline]
    pub fn look(&mut self, backend: &impl Backend, engine: &mut Engine, reset_at_terminal: bool) {
        engine.hold(self.stop.look(backend.stop_inputs(), reset_at_terminal));
    }

    /// After the cycle: takes the supply, or gives it back, as the engine wants it.
    #[inline]
    pub fn switch(&mut self, engine: &Engine, backend: &mut impl Backend) {
        if engine.must_cut() {
            backend.cut();
        } else if self.is_cut {
            backend.restore();
        }
        self.is_cut = engine.must_cut();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOSED: Option<StopInputs> = Some(StopInputs { is_closed: true, is_reset_pressed: false });
    const OPEN: Option<StopInputs> = Some(StopInputs { is_closed: false, is_reset_pressed: false });
    const PRESSED: Option<StopInputs> = Some(StopInputs { is_closed: true, is_reset_pressed: true });

    #[test]
    fn a_rig_without_one_is_never_held() {
        let mut stop = EmergencyStop::default();
        assert!(!stop.look(None, false) && !stop.look(None, true));
    }

    #[test]
    fn it_begins_latched_and_is_left_by_its_input_or_the_terminal_alone() {
        let mut stop = EmergencyStop::default();
        assert!(stop.look(CLOSED, true), "in its first cycle nothing has been shown yet");
        assert!(stop.look(CLOSED, false));
        assert!(!stop.look(CLOSED, true));
        assert!(!stop.look(CLOSED, false));
        assert!(stop.look(OPEN, false) && stop.look(OPEN, true), "open is open");
        assert!(stop.look(CLOSED, false), "closing it resets nothing");
        assert!(!stop.look(PRESSED, false));
        assert!(!stop.look(PRESSED, false) && !stop.look(CLOSED, false));
    }

    #[test]
    fn a_jammed_button_resets_nothing() {
        let mut stop = EmergencyStop::default();
        assert!((0..10).all(|_| stop.look(PRESSED, false)), "pressed before anything was latched");
        assert!(stop.look(CLOSED, false));
        assert!(!stop.look(PRESSED, false));
        let open_and_pressed = Some(StopInputs { is_closed: false, is_reset_pressed: true });
        assert!(stop.look(open_and_pressed, false) && stop.look(PRESSED, false));
    }

    #[test]
    fn inputs_that_are_gone_are_open() {
        let mut stop = EmergencyStop::default();
        stop.look(CLOSED, false);
        assert!(!stop.look(CLOSED, true));
        assert!(stop.look(None, false) && stop.look(None, true) && stop.look(CLOSED, false));
    }
}
