//! Rows of the bench as a table: `rows [PLANT|-] [CONTROLLER|-] [ESTIMATOR|-] [SEEDS] [scoring]`; with `scoring` on the seeds that are
//! scored with and with every plant, else on those to develop with.

use sinew_bench::{Figures, Filter, Plan, run, score};

/// The highest frequency up to which the sines are followed within 1 % of the stroke, RMS, Hz; 0 where none is.
fn band_hz(figures: &Figures) -> f64 {
    let followed = figures.tracking.iter().take_while(|one| one.rms_percent < 1.0);
    followed.last().map_or(0.0, |one| one.frequency_hz)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words = |i: usize| -> Vec<String> {
        let list = arguments.get(i).filter(|word| *word != "-");
        list.map(|word| word.split(',').map(Into::into).collect()).unwrap_or_default()
    };
    let seeds = arguments.get(3).map_or(1, |word| word.parse().expect("a number of seeds"));
    let filter = Filter { plants: words(0), controllers: words(1), estimators: words(2) };
    let plan = match arguments.get(4).map(String::as_str) {
        None => Plan::quick(seeds),
        Some("scoring") => Plan::full(seeds),
        Some(other) => panic!("`scoring` or nothing, not {other}"),
    };
    let ran = run(&plan.only(&filter), &|_| ());
    println!(
        "{:<24} {:<30} {:<22} {:<10} {:>6} {:>6} {:>6} {:>5} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6}",
        "plant",
        "controller",
        "estimator",
        "sensing",
        "up",
        "down",
        "sett",
        "over",
        "worst",
        "steady",
        "cycle",
        "0.25Hz",
        "1 Hz",
        "<1%Hz",
        "T K",
        "draft",
        "T@1s",
        "pull",
        "J",
        "swit/s",
        "score"
    );
    for ran in &ran {
        let row = &ran.row;
        let Some(f) = &row.figures else {
            println!("{:<24} {:<30} {:<22} refused: {:?}", row.plant, row.controller, row.estimator, row.refused);
            continue;
        };
        println!(
            "{:<24} {:<30} {:<22} {:<10} {:>6.2} {:>6.2} {:>6.2} {:>5.2} {:>6.2} {:>6.2} {:>6.2} {:>6.2} {:>6.2} {:>6.2} {:>6.2} {:>6.2} {:>6.1} {:>6.2} {:>6.2} {:>6.1} {:>6.2} {}",
            row.plant,
            row.controller,
            row.estimator,
            row.sensing,
            f.ratio_up.unwrap_or(f64::NAN),
            f.ratio_down.unwrap_or(f64::NAN),
            f.settled,
            f.overshoot_percent,
            f.overshoot_worst_percent,
            f.steady_rms_percent,
            f.limit_cycle_percent,
            f.tracking_percent(0.25),
            f.tracking_percent(1.0),
            band_hz(f),
            f.temperature_rms_k,
            f.draught.deviation_percent,
            f.draught.temperature_error_k,
            f.load_step.deviation_percent,
            f.energy_j,
            f.switchings_per_s,
            score::of_row(row).unwrap_or(f64::NAN),
            f.faults.join(", "),
        );
    }
    let rows: Vec<_> = ran.into_iter().map(|ran| ran.row).collect();
    for place in score::ranking(&rows) {
        println!("{:.3} {} {} {}", place.score, place.controller, place.estimator, place.sensing);
    }
}
