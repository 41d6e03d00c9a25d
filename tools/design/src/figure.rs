//! The compromise between force and bandwidth as the wire's diameter changes (fig. 69): by the rules, and as predicted.

use sinew_plot::{Drawing, Ink, Panels, TWO_IN_A_ROW, Trace, extent};

use crate::design::Design;

const FORCE: (&str, &str) = ("Useful force of one wire", "N");
const BANDWIDTH: (&str, &str) = ("Bandwidth", "Hz");
const DIAMETER: (&str, &str) = ("Diameter", "mm");
const RULES: Ink = Ink::Series(0);
const PREDICTED: Ink = Ink::Series(1);
const CHOSEN: Ink = Ink::Series(2);

/// Force against bandwidth, and each against the diameter, as a picture of its own.
pub fn compromise(designs: &[Design], chosen: Option<&Design>) -> String {
    type Number = fn(&Design) -> f64;
    let force: Number = |design| design.sizing.wire.useful_force_n();
    let by_rules: Number = |design| 1.0 / design.sizing.cycle_s();
    let predicted: Number = |design| design.prediction.map_or(f64::NAN, |said| 1.0 / said.cycle.cycle_s());
    let diameter: Number = |design| design.sizing.wire.diameter_m * 1e3;
    let line = |ink, x: Number, y: Number| {
        let (x, y) = (designs.iter().map(x).collect(), designs.iter().map(y).collect());
        Trace { ink, x, y }
    };
    // where the chosen wire is, from the lowest line to the highest
    let drawing = |x, y: (&'static str, &'static str), mut traces: Vec<Trace>, at: Number| {
        let ends = extent(traces.iter().flat_map(|trace| trace.y.iter().copied()));
        if let (Some(one), Some((low, high))) = (chosen, ends) {
            traces.push(Trace { ink: CHOSEN, x: vec![at(one); 2], y: vec![low, high] });
        }
        Drawing { name: y.0, unit: y.1, x, decades: (true, true), traces }
    };
    let drawings = [
        drawing(BANDWIDTH, FORCE, vec![line(RULES, by_rules, force), line(PREDICTED, predicted, force)], predicted),
        drawing(
            DIAMETER,
            BANDWIDTH,
            vec![line(RULES, diameter, by_rules), line(PREDICTED, diameter, predicted)],
            diameter,
        ),
        drawing(DIAMETER, FORCE, vec![line(RULES, diameter, force)], diameter),
    ];
    let mut legend = vec![(RULES, "by the rules".to_string()), (PREDICTED, "predicted".to_string())];
    legend.extend(chosen.map(|one| (CHOSEN, format!("chosen: {:.3} mm", one.sizing.wire.diameter_m * 1e3))));
    let panels = drawings.iter().map(Drawing::plot).collect();
    Panels { title: "Force and bandwidth over diameter".into(), legend, row: TWO_IN_A_ROW, panels }.draw().into_string()
}
