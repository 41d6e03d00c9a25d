//! `sinew tune`: the λ with which each channel's sliding surface stays reachable, from the wire's power and cooling and its uncertainty.

use std::fmt::Write as _;

use serde::Serialize;
use sinew_control::{Holding, Limits, Reach, ReachConfig, default_lambda};
use sinew_physics::{DriveKind, Load, WireModel};
use sinew_rig::{Channel, Rig};

use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;

/// Runs the command.
pub fn tune(args: &args::Tune) -> Outcome {
    let mut rig = super::load_rig(Some(&args.rig))?;
    let chosen: Vec<usize> = match &args.channel {
        Some(name) => {
            let chosen = super::choose_channel(&rig, Some(name))?;
            rig.channel(&chosen.name).map(|(index, _)| index).into_iter().collect()
        }
        None => (0..rig.channels.len()).collect(),
    };
    let tuned: Vec<Tuned> = chosen.iter().map(|index| Tuned::of(&rig, *index, args)).collect::<Result<_, _>>()?;

    let mut written = Vec::new();
    if args.write {
        for (index, tuned) in chosen.iter().zip(&tuned) {
            if let Some(lambda) = tuned.to_write() {
                rig.channels[*index].control.lambda_per_s = Some(lambda);
                written.push(tuned.name.as_str());
            }
        }
        if !written.is_empty() {
            output::write_file(&args.rig, rig.to_toml())?;
        }
    }
    match args.json {
        true => output::print_json(&Answer {
            schema: "sinew.tune/1",
            rig: &rig.name,
            uncertainty: args.uncertainty,
            strokes: [args.range.0, args.range.1],
            cool_freely: args.cool_freely,
            channels: &tuned,
            written: &written,
        })?,
        false => output::print(table(&tuned, args))?,
    }
    for tuned in &tuned {
        for warning in &tuned.warnings {
            output::note(format_args!("warning: {}: {warning}", tuned.name));
        }
    }
    if args.write {
        let there = args.rig.display();
        match written.len() {
            0 => output::note(format_args!("nothing written: {there} stays as it is")),
            _ => output::note(format_args!("written: {there} ({})", written.join(", "))),
        }
    }
    Ok(())
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Answer<'a> {
    schema: &'static str,
    rig: &'a str,
    uncertainty: f64,
    strokes: [f64; 2],
    cool_freely: bool,
    channels: &'a [Tuned],
    written: &'a [&'a str],
}

/// Largest λ of each kind, 1/s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Rates {
    heating_per_s: Option<f64>,
    cooling_per_s: Option<f64>,
    load_per_s: f64,
}

impl From<Limits> for Rates {
    fn from(limits: Limits) -> Rates {
        let Limits { heating_per_s, cooling_per_s, load_per_s } = limits;
        Rates { heating_per_s, cooling_per_s, load_per_s }
    }
}

/// How fast a channel's surface can be between two strokes, with its parameters wrong by a share.
pub fn reach_of(channel: &Channel, model: &WireModel, range: (f64, f64), uncertainty: f64) -> Reach {
    let limits = &channel.limits;
    let config = ReachConfig {
        least_duty: channel.control.minimum_duty,
        most_duty: limits.max_duty,
        max_power_w: limits.max_power_w,
        from_stroke: range.0,
        to_stroke: range.1,
        uncertainty,
    };
    Reach::new(model, config)
}

/// One channel's answer.
#[derive(Debug, Serialize)]
struct Tuned {
    name: String,
    algorithm: String,
    /// Whether the algorithm has a λ at all.
    uses_lambda: bool,
    max_power_w: f64,
    /// What is in force without a change.
    now_per_s: f64,
    now_is_default: bool,
    /// The λ to take; absent where none keeps the surface reachable.
    lambda_per_s: Option<f64>,
    /// How much larger it could be with the parameters as modelled.
    margin: Option<f64>,
    as_modelled: Rates,
    worst_case: Rates,
    /// At that λ in the worst case, shares of the power while shortening and of the cooling while lengthening; more than 1 for the cooling
    /// means that the wire cools freely until it is near.
    power_share: Option<f64>,
    cooling_share: Option<f64>,
    warnings: Vec<String>,
}

impl Tuned {
    fn of(rig: &Rig, index: usize, args: &args::Tune) -> Result<Tuned, Failure> {
        let channel = &rig.channels[index];
        let model = rig.nominal_model(index);
        let place = format!("{}: channel \"{}\"", rig.file(), channel.name);
        if model.drive.kind != DriveKind::Pwm {
            return Err(Failure::input(format!("{place}: its drive is not \"pwm\""))
                .hint("only a wire heated by pulses has a controller; set [channel.drive] kind = \"pwm\""));
        }
        if !matches!(model.load, Load::SpringMassDamper { .. }) {
            return Err(Failure::input(format!("{place}: its load is imposed"))
                .hint("a controller needs a load that moves; set [channel.load] kind = \"spring_mass_damper\""));
        }
        let limits = &channel.limits;
        let reach = reach_of(channel, &model, args.range, args.uncertainty);
        let of = |limits: Limits| if args.cool_freely { limits.shortening_per_s() } else { limits.both_per_s() };
        let (nominal, worst) = (reach.as_modelled(), reach.worst_case());
        let lambda_per_s = of(worst).map(round_down);
        let shares = lambda_per_s.map(|lambda| reach.shares(lambda));
        let algorithm = sinew_rig::word(channel, "channel.control", "algorithm").unwrap_or_default();
        let uses_lambda = channel.control.algorithm.takes("lambda_per_s");
        let default = default_lambda(&model, limits.max_power_w.min(limits.max_duty * channel.full_power_w())).value;
        let mut tuned = Tuned {
            name: channel.name.clone(),
            algorithm,
            uses_lambda,
            max_power_w: limits.max_power_w,
            now_per_s: channel.control.lambda_per_s.unwrap_or(default),
            now_is_default: channel.control.lambda_per_s.is_none(),
            lambda_per_s,
            margin: lambda_per_s.and_then(|lambda| of(nominal).map(|nominal| nominal / lambda)),
            as_modelled: nominal.into(),
            worst_case: worst.into(),
            power_share: shares.map(|shares| shares.heating),
            cooling_share: shares.map(|shares| shares.cooling).filter(|share| share.is_finite()),
            warnings: Vec::new(),
        };
        tuned.warn(&worst, &reach.holding(), args);
        Ok(tuned)
    }

    fn warn(&mut self, worst: &Limits, holding: &Holding, args: &args::Tune) {
        let less = match args.uncertainty > 0.0 {
            true => {
                format!(", or know it better than ±{:.0} % (identify, then --uncertainty)", 100.0 * args.uncertainty)
            }
            false => String::new(),
        };
        if worst.heating_per_s.is_none() {
            let Holding { needed_w, most_w, .. } = *holding;
            self.warnings.push(format!(
                "no λ keeps the surface reachable while the wire shortens: holding it short can take {needed_w:.2} W, and \
                 {most_w:.2} W may be all there is; give it more (supply_v, maximum_power_w), a thinner wire or a smaller --range{less}"
            ));
        }
        if worst.cooling_per_s.is_none() && !args.cool_freely {
            let Holding { loss_w, least_w, .. } = *holding;
            self.warnings.push(format!(
                "no λ keeps the surface reachable while the wire lengthens: at its long end it may lose only {loss_w:.3} W to the air, \
                 and sensing alone gives it {least_w:.3} W; take a smaller sensing_duty, cooler air, more load, an alloy that transforms at \
                 higher temperature or a smaller --range{less}; or let it cool freely (--cool-freely)"
            ));
        }
        if !self.uses_lambda {
            self.warnings.push(format!("algorithm \"{}\" has no λ; nothing to write", self.algorithm));
        }
    }

    /// What `--write` puts into the rig file.
    fn to_write(&self) -> Option<f64> {
        self.lambda_per_s.filter(|_| self.uses_lambda)
    }
}

/// Two digits, never more than the value.
fn round_down(value: f64) -> f64 {
    let unit = 10f64.powf(value.log10().floor() - 1.0);
    let text = format!("{:.6}", (value / unit + 1e-9).floor() * unit);
    text.parse().unwrap_or(value)
}

/// A table a channel, and the line to put into the rig file.
fn table(tuned: &[Tuned], args: &args::Tune) -> String {
    let mut text = String::new();
    let rate = |value: Option<f64>| value.map_or("none".to_string(), |value| format!("{value:.2}"));
    for t in tuned {
        let both = |r: &Rates| {
            let least = if args.cool_freely {
                r.heating_per_s
            } else {
                r.heating_per_s.zip(r.cooling_per_s).map(|(a, b)| a.min(b))
            };
            least.map(|least| least.min(r.load_per_s))
        };
        let _ = writeln!(
            text,
            "{}: {}, at most {:.2} W, strokes {:.0} to {:.0} %",
            t.name,
            t.algorithm,
            t.max_power_w,
            100.0 * args.range.0,
            100.0 * args.range.1
        );
        let _ = writeln!(text, "  largest λ, 1/s    heating  cooling     load  together");
        let worst = format!("every ±{:.0} %", 100.0 * args.uncertainty);
        for (name, r) in [("as modelled", &t.as_modelled), (worst.as_str(), &t.worst_case)] {
            let _ = writeln!(
                text,
                "  {name:<16} {:>8} {:>8} {:>8} {:>9}",
                rate(r.heating_per_s),
                rate(r.cooling_per_s),
                rate(Some(r.load_per_s)),
                rate(both(r))
            );
        }
        match (t.lambda_per_s, t.margin) {
            (Some(lambda), margin) => {
                let now = if t.now_is_default { "computed" } else { "in the rig file" };
                let _ = writeln!(
                    text,
                    "  lambda_per_s = {lambda}    # in [channel.control]; now {:.2} ({now})",
                    t.now_per_s
                );
                if let Some(margin) = margin {
                    let cooling = match t.cooling_share {
                        Some(share) if share <= 1.0 => format!("{:.0} % of the cooling", 100.0 * share),
                        _ => "all of the cooling, for longer".to_string(),
                    };
                    let _ = writeln!(
                        text,
                        "  margin: a factor {margin:.1} to what the model allows; in the worst case it takes {:.0} % of the power and {cooling}",
                        100.0 * t.power_share.unwrap_or(f64::NAN)
                    );
                }
            }
            (None, _) => {
                let _ = writeln!(text, "  no λ: see the warnings; now {:.2}", t.now_per_s);
            }
        }
        text.push('\n');
    }
    text.truncate(text.trim_end().len());
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_keeps_two_digits_and_never_rounds_up() {
        for (value, expected) in [(12.99, 12.0), (1.999, 1.9), (0.0349, 0.034), (3.0, 3.0), (456.0, 450.0), (0.1, 0.1)]
        {
            assert_eq!(round_down(value), expected);
        }
    }
}
