//! How far long work is: one line on stderr where that is a terminal, and nothing otherwise.

use std::fmt::{self, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::log;

/// What a stage counts to.
const WHOLE: u64 = 1000;
/// How often a second it is drawn, at most.
const DRAWS_PER_S: u8 = 10;
/// Work that is done sooner shows nothing.
const SOON: Duration = Duration::from_millis(300);
/// With a stage that says how far it is, and with one that does not.
const MEASURED: &str = "{msg} {bar:24} {percent:>3} %{left}";
const UNMEASURED: &str = "{msg} … {elapsed}";

/// A line that is drawn over itself; several threads may tell it.
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// Nothing is shown yet.
    pub fn new() -> Progress {
        let is_shown = !log::is_quiet() && std::env::var_os("TERM").is_some_and(|term| term != "dumb");
        // a stderr that is no terminal hides it as well
        let target =
            if is_shown { ProgressDrawTarget::stderr_with_hz(DRAWS_PER_S) } else { ProgressDrawTarget::hidden() };
        Progress { bar: ProgressBar::with_draw_target(Some(WHOLE), target).with_style(style(UNMEASURED)) }
    }

    /// Says how far a stage is, 0..1; 0 where it does not say.
    pub fn tell(&self, stage: &str, share: f64) {
        if self.bar.is_hidden() || self.bar.elapsed() < SOON {
            return;
        }
        let is_new = self.bar.message() != stage;
        if is_new {
            self.bar.reset();
            self.bar.set_message(stage.to_string());
        }
        let place = place(share);
        let was_measured = self.bar.position() > 0;
        if is_new || was_measured != (place > 0) {
            self.bar.set_style(style(if place > 0 { MEASURED } else { UNMEASURED }));
        }
        self.bar.set_position(place);
    }

    /// The same in counts of something.
    pub fn count(&self, stage: &str, done: u64, all: u64) {
        self.tell(stage, done as f64 / all.max(1) as f64);
    }

    /// Takes the line away.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// Where the bar stands.
fn place(share: f64) -> u64 {
    (WHOLE as f64 * share.clamp(0.0, 1.0)) as u64
}

/// A template of ours; the bar's own where it were wrong, which a test excludes.
fn style(template: &str) -> ProgressStyle {
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    style.progress_chars("█▌ ").with_key("left", |state: &ProgressState, line: &mut dyn Write| {
        // a line that is not written is drawn the next time
        let _ = left(state.elapsed(), f64::from(state.fraction()), line);
    })
}

/// How much longer a stage takes if it goes on as it has on the whole: the library's own estimate goes by the last steps, and says that none
/// is left where they were large ones.
fn left(passed: Duration, share: f64, line: &mut dyn Write) -> fmt::Result {
    let left_s = passed.as_secs_f64() * (1.0 - share) / share;
    match left_s {
        s if !s.is_finite() || passed < SOON => Ok(()),
        s if s < 90.0 => write!(line, ", {:.0} s left", s.round().max(1.0)),
        s => write!(line, ", {:.0} min left", s / 60.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_that_is_none_stays_within_the_bar() {
        assert_eq!([0.0, 0.256, 7.0, -1.0, f64::NAN].map(place), [0, 256, WHOLE, 0, 0]);
    }

    #[test]
    fn what_is_left_goes_by_all_that_has_passed() {
        let said = |passed_s, share| {
            let mut line = String::new();
            left(Duration::from_secs_f64(passed_s), share, &mut line).unwrap();
            line
        };
        assert_eq!(said(7.0, 0.7), ", 3 s left");
        assert_eq!(said(60.0, 0.1), ", 9 min left");
        assert_eq!(said(5.0, 0.999), ", 1 s left", "never none");
        assert_eq!([said(0.1, 0.5), said(5.0, 0.0)], ["", ""], "too early to tell");
    }

    #[test]
    fn the_templates_are_right() {
        for template in [MEASURED, UNMEASURED] {
            ProgressStyle::with_template(template).expect("a template");
        }
    }
}
