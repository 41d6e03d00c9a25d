//! The line that switches the supply of all power stages: `[backend.enable]`.

use super::linux::Polarity;
use crate::declare::rows::*;
use crate::value::MAX_PATH;

words! {
    /// What the enable line carries while the outputs may be powered.
    pub enum EnableSignal, default None {
        /// There is no enable line.
        None = "none",
        /// A level.
        Level = "level",
        /// A pulse train, an edge a period, for a watchdog relay: a driver that stands still lets it drop out.
        Pulses = "pulses",
    }
}

table! {
    "backend.enable":
    "A line that switches the supply of all power stages, beside their own gates: off before the first cycle and at every end. \
     See [wiring](wiring.md).";

    /// The line that switches the supply of all power stages.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Enable {
        /// What it carries while outputs may be powered: `level`, or `pulses` for a watchdog relay; `none`: there is no such line.
        signal: EnableSignal = "signal", EnableSignal::KIND, EnableSignal::DEFAULT;
        /// Where it is with kind `linux`: chip and line, such as `gpiochip0/17`, or the path of a file of sysfs. A front-end has a pin of its own for it.
        line: Option<String> = "line", text("a chip and its line", MAX_PATH),
            Computed("none: **required** with kind `linux` and a signal");
        /// Which level lets outputs be powered: high, or low.
        polarity: Polarity = "polarity", Polarity::KIND, Polarity::DEFAULT;
        /// So long after the last edge the simulated watchdog relay drops out, with `pulses`. Of a real one the driver counts on nothing.
        dropout_s: f64 = "dropout_ms", number(milli("ms"), 1.0, 10_000.0), Number(100.0);
        /// So long after it is switched on the supply stands at the stages: nothing is put out before.
        settle_s: f64 = "settle_ms", number(milli("ms"), 0.0, 10_000.0), Number(50.0);
    }
}
