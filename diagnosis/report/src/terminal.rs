//! The answer in about ten lines, for a terminal.

use sinew_diagnosis::{Diagnosis, FittedParameter, FoundEffect, Unknown, Verdict};
use sinew_plot::quantity::{chi, estimate, percent, probability, signed};

use crate::summary::{FAR_SIGMAS, Overall, largest_changes, sigmas};
use crate::words::{headline, list, places};

/// Narrower than this a terminal is not taken at its word.
const LEAST_WIDTH: usize = 40;
/// Windows and conditions named, and warnings printed; the page has them all.
const PLACES: usize = 1;
const WARNINGS: usize = 3;
/// Where the text begins, after its label.
const INDENT: usize = 9;

/// The answer of `diagnosis` for a terminal of `width` columns, with ANSI colours where `colour` is true.
/// Ends with a newline.
pub fn text(diagnosis: &Diagnosis, width: usize, colour: bool) -> String {
    let mut answer = Lines::new(width, colour);
    answer.headline(&headline(diagnosis), diagnosis.verdict, diagnosis.is_explained());
    answer.says("", &diagnosis.summary);
    answer.says("fit", &fit(diagnosis));
    if !diagnosis.verdict.is_complete() {
        answer.says("where", &place(diagnosis));
        for effect in &diagnosis.effects {
            answer.says("what", &found(effect));
        }
        if let Some(unknown) = &diagnosis.unknown {
            answer.says("unknown", &form(unknown));
        }
    }
    if let Some(curves) = &diagnosis.curves {
        answer.says("curves", &found(curves));
    }
    answer.says("remains", &remains(diagnosis));
    answer.says("param.", &parameters(diagnosis));
    answer.says("next", &diagnosis.next_experiment);
    answer.warnings(&diagnosis.warnings);
    answer.end()
}

fn fit(diagnosis: &Diagnosis) -> String {
    let Overall { as_given, recalibrated, improved } = Overall::of(diagnosis);
    format!(
        "chi on kept-back data {} as given, {} recalibrated, {} improved (1 = noise), p ≤ {}",
        chi(as_given),
        chi(recalibrated),
        chi(improved),
        probability(diagnosis.left.p_value).trim_start_matches("below ")
    )
}

fn place(diagnosis: &Diagnosis) -> String {
    let location = &diagnosis.location;
    let equation = location.equation.as_ref().map(|equation| match location.equation_scores.get(equation) {
        Some(score) => format!("the {equation} equation, which explains {}", percent(*score)),
        None => format!("the {equation} equation"),
    });
    equation.into_iter().chain(places(location, PLACES)).collect::<Vec<_>>().join("; ")
}

fn found(effect: &FoundEffect) -> String {
    let sizes = effect.parameters.iter().map(|(key, size)| {
        let (value, interval) = estimate(size.value, size.low, size.high, &size.unit);
        format!("{key} {value} [{interval}]")
    });
    let mut line = format!("{}: {}", effect.id, list(&sizes.collect::<Vec<_>>()));
    line += &format!(
        "; {} of what was wrong, {}; without it chi {}, p ≤ {}",
        percent(effect.share),
        effect.grade.says(),
        chi(effect.evidence.holdout_chi_before),
        probability(effect.evidence.p_value).trim_start_matches("below ")
    );
    if !effect.cannot_be_told_apart_from.is_empty() {
        line += &format!("; cannot be told apart from {}", list(&effect.cannot_be_told_apart_from));
    } else if let Some(rival) = effect.alternatives.first() {
        line += &format!("; next best {} leaves chi {}", rival.id, chi(rival.holdout_chi));
    }
    line
}

fn remains(diagnosis: &Diagnosis) -> String {
    let remains = &diagnosis.remains;
    let off = diagnosis.beyond_tolerance.iter().map(|off| format!("; {}", off.says));
    format!("chi {}, {}{}", chi(remains.chi), remains.looks_like.says(), off.collect::<String>())
}

fn form(unknown: &Unknown) -> String {
    let fit = format!("chi {} → {}", chi(unknown.holdout_chi_before), chi(unknown.holdout_chi_after));
    if unknown.form.is_empty() {
        format!("in the {} equation, no closed form found; {fit}", unknown.equation)
    } else {
        let unit = if unknown.unit == "1" { String::new() } else { format!(" (in {})", unknown.unit) };
        format!("in the {} equation, empirically {}{unit}; {fit}", unknown.equation, unknown.form)
    }
}

fn parameters(diagnosis: &Diagnosis) -> String {
    let far: Vec<String> = largest_changes(diagnosis, 3).into_iter().map(|(key, p)| change(key, p)).collect();
    if far.is_empty() { "none moved by as much as its prior allows".into() } else { far.join("; ") }
}

fn change(key: &str, parameter: &FittedParameter) -> String {
    let (value, interval) = estimate(parameter.value, parameter.low, parameter.high, &parameter.unit);
    let sigmas = sigmas(parameter);
    let flag = if sigmas.abs() > FAR_SIGMAS { ", far from its prior" } else { "" };
    let given = sinew_plot::quantity::number(parameter.given);
    format!("{key} {given} → {value} [{interval}] ({} σ{flag})", signed((10.0 * sigmas).round() / 10.0))
}

/// Lines as they are put together.
pub(crate) struct Lines {
    lines: String,
    width: usize,
    colour: bool,
}

impl Lines {
    pub(crate) fn new(width: usize, colour: bool) -> Lines {
        Lines { lines: String::new(), width: width.max(LEAST_WIDTH), colour }
    }

    pub(crate) fn headline(&mut self, text: &str, verdict: Verdict, is_explained: bool) {
        let shade = match verdict {
            Verdict::Agrees | Verdict::ParametersOff if is_explained => "1;32",
            Verdict::Agrees | Verdict::ParametersOff | Verdict::PhysicsMissing => "1;33",
            Verdict::UnknownPhysics => "1;35",
        };
        for line in wrapped(text, self.width) {
            let line = self.painted(&line, shade);
            self.lines += &line;
            self.lines.push('\n');
        }
    }

    /// The first warnings, and how many more there are.
    pub(crate) fn warnings(&mut self, warnings: &[String]) {
        for warning in warnings.iter().take(WARNINGS) {
            self.says("warning", warning);
        }
        if warnings.len() > WARNINGS {
            self.says("warning", &format!("and {} more, in the report", warnings.len() - WARNINGS));
        }
    }

    pub(crate) fn end(self) -> String {
        self.lines
    }

    /// A label and what it says, wrapped beside it; nothing where it says nothing.
    pub(crate) fn says(&mut self, label: &str, text: &str) {
        for (i, line) in wrapped(text, self.width - INDENT).iter().enumerate() {
            let label = if i == 0 { label } else { "" };
            let padding = " ".repeat(INDENT - label.len().min(INDENT));
            let label = self.painted(label, if label == "warning" { "33" } else { "2" });
            self.lines += &format!("{label}{padding}{line}\n");
        }
    }

    fn painted(&self, text: &str, shade: &str) -> String {
        if self.colour && !text.is_empty() { format!("\x1b[{shade}m{text}\x1b[0m") } else { text.into() }
    }
}

/// Words on lines of at most `width` characters; a longer word has a line of its own. Control characters, which could
/// command the terminal, count as spaces.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|w| !w.is_empty()) {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_wrap_and_control_characters_do_not_reach_the_terminal() {
        assert_eq!(wrapped("a bb\u{1b}[31m ccc", 5), ["a bb", "[31m", "ccc"]);
        assert_eq!(wrapped("", 5), Vec::<String>::new());
        assert_eq!(wrapped("overlong x", 3), ["overlong", "x"]);
    }
}
