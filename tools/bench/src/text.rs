//! The result as text for a terminal.

use std::fmt::Write as _;

use crate::Answer;
use crate::row::{Figures, Row};
use crate::score;

/// Places of the ranking that are shown.
const PLACES: usize = 12;

/// The ranking, the rows of the best on the first plant, and the findings.
pub fn text(answer: &Answer) -> String {
    let mut out = String::new();
    // writing to a String cannot fail
    let _ =
        writeln!(out, "{} rows on {} plants, {} seeds\n", answer.rows.len(), answer.plants.len(), answer.seeds.len());
    let _ = writeln!(
        out,
        "{:<5} {:<36} {:<21} {:<10} {:>6} {:>9}",
        "score", "controller", "estimator", "sensing", "known", "misjudged"
    );
    for place in answer.ranking.iter().take(PLACES) {
        let _ = writeln!(
            out,
            "{:<5.2} {:<36} {:<21} {:<10} {:>6.2} {:>9.2}",
            place.score, place.controller, place.estimator, place.sensing, place.known, place.misjudged
        );
    }
    if answer.ranking.len() > PLACES {
        let _ = writeln!(out, "      … {} more", answer.ranking.len() - PLACES);
    }
    let best = answer.plants.first().map(|about| about.plant).unwrap_or_default();
    let _ = writeln!(
        out,
        "\non {best}: settling over its bound up and down, overshoot, steady error, tracking at 0.25 and 1 Hz (% of stroke)"
    );
    for place in answer.ranking.iter().take(PLACES) {
        let same = |row: &&Row| {
            row.plant == best
                && (&row.controller, &row.estimator, &row.sensing)
                    == (&place.controller, &place.estimator, &place.sensing)
        };
        for row in answer.rows.iter().filter(same) {
            let _ = writeln!(out, "{}", line(row));
        }
    }
    let _ = writeln!(out);
    for finding in &answer.findings {
        let mark = match finding.reproduced {
            Some(true) => "yes",
            Some(false) => "no",
            None => "–",
        };
        let _ = writeln!(out, "{mark:<4} {}\n     {}", finding.finding, finding.here);
    }
    out
}

fn line(row: &Row) -> String {
    let name = format!("{:<36} {:<21} {:<10}", row.controller, row.estimator, row.sensing);
    let ratio = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.2}"));
    match &row.figures {
        None => format!("{name} refused: {}", row.refused.as_deref().unwrap_or("")),
        Some(figures @ Figures { ratio_up, ratio_down, overshoot_percent, steady_rms_percent, .. }) => format!(
            "{name} {:>6} {:>6} {overshoot_percent:>7.2} {steady_rms_percent:>7.2} {:>7.2} {:>7.2}  score {:.2}{}",
            ratio(*ratio_up),
            ratio(*ratio_down),
            figures.tracking_percent(0.25),
            figures.tracking_percent(1.0),
            score::of_row(row).unwrap_or(f64::NAN),
            if figures.faults.is_empty() { String::new() } else { format!("  {}", figures.faults.join(", ")) },
        ),
    }
}
