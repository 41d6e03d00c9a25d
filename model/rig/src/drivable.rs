//! What the driver needs of a rig beyond what `simulate` does.

use sinew_physics::{DriveKind, Load};

use crate::error::{Error, Problem, What};
use crate::notes::line_at;
use crate::tables::rig::Source;
use crate::tables::{BackendKind, MAX_DRIVEN_RATE_HZ, MIN_DRIVEN_RATE_HZ, Rig, of_channel};
use crate::tree::{self, Node, Tree};
use crate::value::wrong_number;

/// How long the stage of a simulated rig keeps its duty when nobody sends it another, s: longer than a loop is late on an ordinary
/// machine, and not much longer than a front-end's watchdog, or thin wires would be heated far more slowly than they will be there.
const SIMULATED_SILENCE_S: f64 = 0.02;
/// Periods of silence that whatever watches over outputs bears at least, whatever the rig file says: a loop that is late now and then
/// must not lose them.
pub const LEAST_SILENCE_PERIODS: f64 = 4.0;

impl Rig {
    /// The longest an output can stay as it is with a driver that is dead or stands still, s: what watches over it, by the kind of
    /// backend, then puts it to zero.
    pub fn silence_s(&self) -> f64 {
        let least_s = LEAST_SILENCE_PERIODS / self.rate_hz;
        match self.backend.kind {
            BackendKind::Simulated => SIMULATED_SILENCE_S.max(least_s),
            BackendKind::Linux => (f64::from(self.backend.linux.guard_ms) * 1e-3).max(least_s),
            BackendKind::Serial => f64::from(self.backend.serial.watchdog_periods) / self.rate_hz,
        }
    }

    /// Checks what the driver needs beyond what `simulate` does: a rate it can keep, wires it can heat by PWM and move, and
    /// numbers that a rig file could have said, for a program may have made this rig or changed it.
    ///
    /// # Errors
    /// [`Error::Invalid`] with every reason against it.
    pub fn check_drivable(&self) -> Result<(), Error> {
        let mut problems = Vec::new();
        let mut problem = |channel: Option<usize>, key: &str, what: What| {
            problems.push(Problem {
                file: self.source.file.clone(),
                line: line_of(&self.source, channel, key),
                channel: channel.map(|c| self.channels[c].name.clone()),
                key: key.to_string(),
                what,
            });
        };
        if !(MIN_DRIVEN_RATE_HZ..=MAX_DRIVEN_RATE_HZ).contains(&self.rate_hz) {
            let (found, low, high) = (self.rate_hz, MIN_DRIVEN_RATE_HZ, MAX_DRIVEN_RATE_HZ);
            problem(None, "rig.rate_hz", What::OutOfRange { found, low, high, defaulted: false });
        }
        for (index, channel) in self.channels.iter().enumerate() {
            for section in of_channel() {
                for (key, what) in section.keys().filter_map(|key| Some((key.name, wrong_number(key, channel)?))) {
                    problem(Some(index), format!("{}.{key}", section.local()).trim_start_matches('.'), what);
                }
            }
            if let DriveKind::Amplifier(_) = channel.model.drive.kind {
                // its heat accounts take a duty for the share of the period in which the measured current flows
                let message = "cannot be driven: the driver would take an amplifier's steady current for that of an on-phase, and believe \
                               less heat than there is; expected \"pwm\", or sinew simulate"
                    .into();
                problem(Some(index), "drive.kind", What::Contradiction { message });
            } else if channel.model.drive.kind != DriveKind::Pwm {
                let message = "cannot be driven: the driver heats by PWM only, expected \"pwm\"".into();
                problem(Some(index), "drive.kind", What::Contradiction { message });
            } else if channel.model.drive.supply_v <= 0.0 {
                let message = "is 0, expected the voltage the wire is driven from".into();
                problem(Some(index), "drive.supply_v", What::Contradiction { message });
            }
            let in_joint = self.joint_of(index).is_some();
            if !in_joint && !matches!(channel.model.load, Load::SpringMassDamper { .. }) {
                let message =
                    "cannot be driven: nothing moves, expected \"spring_mass_damper\" or a place in a [[joint]]".into();
                problem(Some(index), "load.kind", What::Contradiction { message });
            }
            if channel.control.minimum_duty <= 0.0 {
                let message = "is 0: without a current there is nothing to measure, expected more, such as 0.02".into();
                problem(Some(index), "control.sensing_duty", What::Contradiction { message });
            }
        }
        if problems.is_empty() { Ok(()) } else { Err(Error::Invalid { problems }) }
    }
}

/// The line of a channel's key in a rig's text, or of the nearest thing above it; for checks after reading.
pub(crate) fn line_of(source: &Source, channel: Option<usize>, path: &str) -> usize {
    let Ok(root) = tree::parse(source.text.strip_prefix('\u{feff}').unwrap_or(&source.text)) else { return 1 };
    let (mut line, mut table) = (1, &root);
    if let Some(index) = channel {
        let Some(Node { value: Tree::Array(channels), line: first }) = root.get("channel") else { return line };
        line = *first;
        let Some(Node { value: Tree::Table(t), line: header }) = channels.get(index) else { return line };
        (line, table) = (*header, t);
    }
    line_at(table, line, path.split('.').filter(|p| !p.is_empty()))
}
