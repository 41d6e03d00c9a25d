//! Lines that behave like `drivers/gpio/gpiolib-sysfs.c`, exported for good; and what hangs on them.

use fuser::Errno;
use sinew_backend::StopInputs;
use sinew_rig::{EnableSignal, Polarity, Rig};

/// The line that switches the supply.
pub const ENABLE: u32 = 17;
/// The contact of the emergency stop.
pub const STOP: u32 = 27;
/// Its reset button.
pub const RESET: u32 = 22;

/// The path of a line's level, as a rig file says it.
pub fn value_file(line: u32) -> String {
    format!("/sys/class/gpio/gpio{line}/value")
}

/// One line.
#[derive(Debug, Clone, Default)]
pub struct Line {
    /// Whether it is put out.
    pub output: bool,
    /// Its level: high, or low.
    pub high: bool,
    /// Whether its chip fails: EIO for whoever reads or writes it.
    pub broken: bool,
    /// How often its level was written.
    pub writes: u64,
    /// How often its level has changed by that.
    pub edges: u64,
}

impl Line {
    /// What an attribute says; `None` where there is no such.
    pub fn show(&self, attribute: &str) -> Result<Option<String>, Errno> {
        Ok(Some(match attribute {
            "value" if self.broken => return Err(Errno::EIO),
            "value" => u8::from(self.high).to_string(),
            "direction" => if self.output { "out" } else { "in" }.into(),
            "active_low" => "0".into(),
            _ => return Ok(None),
        }))
    }

    /// What writing to an attribute does.
    pub fn store(&mut self, attribute: &str, text: &str) -> Result<(), Errno> {
        if self.broken {
            return Err(Errno::EIO);
        }
        let (output, high) = match (attribute, text) {
            ("value", _) if !self.output => return Err(Errno::EPERM),
            ("value", _) => (true, text.parse::<u64>().map_err(|_| Errno::EINVAL)? != 0),
            ("direction", "in") => (false, self.high),
            ("direction", "out" | "low") => (true, false),
            ("direction", "high") => (true, true),
            ("direction", _) => return Err(Errno::EINVAL),
            _ => return Err(Errno::EACCES),
        };
        self.writes += 1;
        self.edges += u64::from(high != self.high);
        (self.output, self.high) = (output, high);
        Ok(())
    }
}

/// The lines of a rig, and what hangs on them.
#[derive(Debug, Clone)]
pub(crate) struct Lines {
    enable: Line,
    stop: Line,
    reset: Line,
    signal: EnableSignal,
    on_is_low: bool,
    /// So many periods after the last edge the watchdog relay drops out.
    dropout_periods: u64,
    /// Periods since then, and the edges there had been.
    since_edge: u64,
    edges: u64,
    closed_is_low: bool,
}

impl Lines {
    pub fn new(rig: &Rig) -> Lines {
        let (enable, stop) = (&rig.backend.enable, &rig.backend.estop);
        let mut lines = Lines {
            enable: Line::default(),
            stop: Line::default(),
            reset: Line::default(),
            signal: enable.signal,
            on_is_low: enable.polarity == Polarity::Inversed,
            dropout_periods: (enable.dropout_s * rig.rate_hz).ceil().max(1.0) as u64,
            since_edge: u64::MAX,
            edges: 0,
            closed_is_low: stop.polarity == Polarity::Inversed,
        };
        // A contact that nobody has touched.
        lines.show_stop(StopInputs { is_closed: stop.fitted, is_reset_pressed: false });
        lines.unplug();
        lines
    }

    /// Without its chip, and before anybody has made an output of it, a resistor holds the enable line at the level that is off.
    pub fn unplug(&mut self) {
        self.enable = Line { high: self.on_is_low, edges: self.edges, ..Line::default() };
    }

    pub fn names(&self) -> Vec<String> {
        [ENABLE, RESET, STOP].map(|line| format!("gpio{line}")).into()
    }

    /// By the name of its folder.
    pub fn line(&self, name: &str) -> Option<&Line> {
        self.numbered(name.strip_prefix("gpio")?.parse().ok()?)
    }

    pub fn numbered(&self, number: u32) -> Option<&Line> {
        match number {
            ENABLE => Some(&self.enable),
            STOP => Some(&self.stop),
            RESET => Some(&self.reset),
            _ => None,
        }
    }

    pub fn numbered_mut(&mut self, number: u32) -> Option<&mut Line> {
        match number {
            ENABLE => Some(&mut self.enable),
            STOP => Some(&mut self.stop),
            RESET => Some(&mut self.reset),
            _ => None,
        }
    }

    /// The inputs have the level of what hangs on them.
    pub fn show_stop(&mut self, inputs: StopInputs) {
        self.stop.high = inputs.is_closed != self.closed_is_low;
        self.reset.high = inputs.is_reset_pressed != self.closed_is_low;
    }

    /// A period has passed for the watchdog relay.
    pub fn pass(&mut self) {
        self.since_edge = if self.enable.edges == self.edges { self.since_edge.saturating_add(1) } else { 0 };
        self.edges = self.enable.edges;
    }

    /// Whether the stages have their supply.
    pub fn has_supply(&self) -> bool {
        match self.signal {
            EnableSignal::None => true,
            EnableSignal::Level => self.enable.output && self.enable.high != self.on_is_low,
            EnableSignal::Pulses => self.since_edge <= self.dropout_periods,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_written_as_an_output_alone() {
        let mut line = Line::default();
        let refused = |result: Result<(), Errno>| result.unwrap_err().code();
        assert_eq!(refused(line.store("value", "1")), Errno::EPERM.code());
        line.store("direction", "high").unwrap();
        assert_eq!(line.show("value").unwrap().unwrap(), "1");
        line.store("value", "0").unwrap();
        assert_eq!((line.high, line.writes, line.edges), (false, 2, 2));
        assert_eq!(refused(line.store("value", "high")), Errno::EINVAL.code());
        line.broken = true;
        assert_eq!(refused(line.store("value", "1")), Errno::EIO.code());
        assert_eq!(line.show("value").unwrap_err().code(), Errno::EIO.code());
    }

    #[test]
    fn a_watchdog_relay_wants_edges() {
        let mut rig = Rig::hexapod();
        (rig.rate_hz, rig.backend.enable.signal, rig.backend.enable.dropout_s) = (100.0, EnableSignal::Pulses, 0.05);
        let mut lines = Lines::new(&rig);
        lines.pass();
        assert!(!lines.has_supply(), "there has been none");
        lines.enable.store("direction", "low").unwrap();
        for edge in 0..20 {
            lines.enable.store("value", if edge % 2 == 0 { "1" } else { "0" }).unwrap();
            lines.pass();
            assert!(lines.has_supply());
        }
        (0..5).for_each(|_| lines.pass());
        assert!(lines.has_supply());
        // the same level again is no edge
        lines.enable.store("value", "0").unwrap();
        lines.pass();
        assert!(!lines.has_supply());
    }
}
