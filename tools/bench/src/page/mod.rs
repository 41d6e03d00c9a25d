//! The page: ranking with reasons, the thesis' findings, steps, sines, estimates, misjudged plants, every row.

mod estimates;
mod laws;
mod ranking;
mod rows;
mod view;

use maud::html;
use sinew_plot::{Ink, Panels, Section, Sheet, TWO_IN_A_ROW};

use self::view::{DRAWN, HALF, REACHABLE, View, WIDE, words};
use crate::Ran;
use crate::answer::Answer;
use crate::row::Row;

/// The page: `report.html`.
pub fn page(answer: &Answer, ran: &[Ran]) -> String {
    let view = View::of(answer, ran);
    let sections = vec![
        Section::unlisted(ranking::winner(&view)),
        Section::new("ranking", "Ranking", ranking::ranking(&view)),
        Section::new("findings", "Findings", ranking::findings(answer)),
        Section::new("steps", "Steps", laws::steps(&view)),
        Section::new("sines", "Sines", laws::sines(&view)),
        Section::new("estimates", "Estimates", estimates::estimates(&view)),
        Section::new("misjudged", "Misjudged", laws::misjudged(&view)),
        Section::new("joints", "Joints", laws::joints(answer)),
        Section::new("sensing", "Sensing", estimates::measured(&answer.sensing)),
        Section::new("bound", "Bound", laws::bound()),
        Section::new("rows", "Rows", rows::rows(answer)),
        Section::new("again", "Reproduce", rows::again(answer)),
    ];
    Sheet {
        title: "sinew bench control".into(),
        class: "agrees",
        heading: html! { "Every controller and estimator on the same plants" },
        sections,
    }
    .page()
    .into_string()
}

/// The pictures of the documentation, each with the name of its file.
pub fn pictures(answer: &Answer, ran: &[Ran]) -> Vec<(&'static str, String)> {
    let view = View::of(answer, ran);
    let laws = view.laws();
    let legend = |laws: &[&Row]| -> Vec<(Ink, String)> {
        laws.iter().map(|row| (view.ink_of_law(row), words(&row.controller))).collect()
    };
    let drawn = &laws[..laws.len().min(DRAWN)];
    let steps = Panels {
        title: String::new(),
        row: TWO_IN_A_ROW,
        legend: [(Ink::Measured, "reference".to_owned())].into_iter().chain(legend(drawn)).collect(),
        panels: view.step_plots(drawn, HALF),
    };
    let reach = [(Ink::Measured, REACHABLE.to_owned())].into_iter().filter(|_| !view.reachable.0.is_empty());
    let sines = Panels {
        title: String::new(),
        row: TWO_IN_A_ROW,
        legend: reach.chain(legend(&laws)).collect(),
        panels: vec![("Error on sines".into(), view.sine_plot(&laws, WIDE))],
    };
    let estimators = view.estimators(view.indifferent());
    let draughts = Panels {
        title: String::new(),
        row: TWO_IN_A_ROW,
        legend: [(Ink::Measured, "true temperature".to_owned())]
            .into_iter()
            .chain(estimators.iter().enumerate().map(|(i, row)| (Ink::Series(i as u8), words(&row.estimator))))
            .collect(),
        panels: view.draught_plots(&estimators, HALF),
    };
    let drawings = [("steps.svg", steps), ("sines.svg", sines), ("draught.svg", draughts)];
    drawings
        .into_iter()
        .filter(|(_, panels)| !panels.panels.is_empty())
        .map(|(name, panels)| (name, panels.draw().into_string()))
        .collect()
}
