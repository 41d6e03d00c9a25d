//! Steps with the state known exactly, compared with the bound: `exact [PLANT,…|-] [CONTROLLER,…]`.

use sinew_bench::{Choice, Family, Plant, exact_steps};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words = |i: usize| arguments.get(i).filter(|word| *word != "-").map(|word| word.split(',').collect::<Vec<_>>());
    let controllers = words(1).unwrap_or_else(|| vec!["model_predictive", "time_optimal"]);
    for plant in Plant::all() {
        let wanted = words(0).map_or(plant.family == Family::Known, |names| names.contains(&plant.name));
        if !wanted {
            continue;
        }
        for controller in &controllers {
            let choice = Choice::default().with(Some(controller), None, None);
            let steps = exact_steps(plant, &choice, &[0.4, 0.8, 0.4, 0.15, 0.3, 0.2]);
            print!("{:<12} {controller:<20}", plant.name);
            for step in steps.unwrap_or_else(|error| panic!("{error}")) {
                let ratio = step.ratio().unwrap_or(f64::NAN);
                print!(
                    "  {:>2.0}%: {ratio:.3} ({:.2} %, {:.2} %)",
                    100.0 * step.to,
                    100.0 * step.overshoot,
                    100.0 * step.rms
                );
            }
            println!();
        }
    }
}
