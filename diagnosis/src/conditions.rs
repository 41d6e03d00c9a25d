//! When and under which conditions the mismatch sits: windows in time, and cells of heating or cooling × temperature ×
//! martensite × stress × duty × cycle.

use crate::answer::{Condition, Map, Window};
use crate::data::{Data, Part};
use crate::fit::Fit;
use crate::residuals::Residuals;
use crate::simulate::State;

/// Share of the mismatch the windows are to hold.
const WINDOW_SHARE: f64 = 0.8;
/// Windows and conditions reported at most.
const MOST_WINDOWS: usize = 4;
const MOST_CONDITIONS: usize = 4;

/// The excess of each sample: Σ over sensors of r² − 1.
fn excess(data: &Data, residuals: &Residuals, run: usize) -> Vec<f64> {
    let n = data.runs[run].time_s.len();
    (0..n)
        .map(|row| {
            residuals[run]
                .iter()
                .map(|values| f64::from(values[row]))
                .filter(|r| !r.is_nan())
                .map(|r| r * r - 1.0)
                .sum()
        })
        .collect()
}

/// The shortest windows that hold most of what is left.
pub(crate) fn windows(data: &Data, residuals: &Residuals) -> Vec<Window> {
    let mut bins: Vec<(usize, usize, usize, f64)> = Vec::new();
    for (r, run) in data.runs.iter().enumerate() {
        let excess = excess(data, residuals, r);
        let width = (run.duration_s() / 60.0).max(0.5);
        let mut from = 0;
        for row in 0..=excess.len() {
            if row == excess.len() || run.time_s[row] - run.time_s[from] >= width {
                bins.push((r, from, row, excess[from..row].iter().sum()));
                from = row;
            }
            if row == excess.len() {
                break;
            }
        }
    }
    let total: f64 = bins.iter().map(|b| b.3.max(0.0)).sum();
    if total <= 0.0 {
        return Vec::new();
    }
    // the fullest bins until the share is reached, then neighbours joined
    let mut order: Vec<usize> = (0..bins.len()).filter(|i| bins[*i].2 > bins[*i].1).collect();
    order.sort_by(|a, b| {
        let density = |i: usize| bins[i].3 / (bins[i].2 - bins[i].1) as f64;
        density(*b).total_cmp(&density(*a))
    });
    let mut chosen = vec![false; bins.len()];
    let mut held = 0.0;
    for i in order {
        if held >= WINDOW_SHARE * total {
            break;
        }
        chosen[i] = true;
        held += bins[i].3.max(0.0);
    }
    // a gap of two bins is no gap
    for i in 1..bins.len().saturating_sub(1) {
        let same = |j: usize| bins.get(j).is_some_and(|b| b.0 == bins[i].0) && chosen.get(j) == Some(&true);
        if same(i - 1) && (same(i + 1) || same(i + 2)) {
            chosen[i] = true;
        }
    }
    let mut windows: Vec<Window> = Vec::new();
    let mut open: Option<(usize, usize, usize, f64)> = None;
    for (i, bin) in bins.iter().enumerate() {
        match (&mut open, chosen[i]) {
            (Some(o), true) if o.0 == bin.0 => {
                o.2 = bin.2;
                o.3 += bin.3;
            }
            (previous, now) => {
                if let Some(o) = previous.take() {
                    windows.push(window(data, o, total));
                }
                *previous = now.then_some(*bin);
            }
        }
    }
    windows.extend(open.map(|o| window(data, o, total)));
    windows.sort_by(|a, b| b.share.total_cmp(&a.share));
    windows.truncate(MOST_WINDOWS);
    windows
}

fn window(data: &Data, (r, from, to, sum): (usize, usize, usize, f64), total: f64) -> Window {
    let run = &data.runs[r];
    let end = if to < run.time_s.len() { run.time_s[to] } else { run.time_s[run.time_s.len() - 1] };
    Window { recording: run.name.clone(), start_s: run.time_s[from], end_s: end, share: (sum / total).clamp(0.0, 1.0) }
}

/// One way to divide the samples: name of each cell, and the cell of each sample.
struct Division {
    cells: Vec<String>,
    of: Vec<Vec<usize>>,
}

/// The conditions that hold more of what is left than of the samples.
pub(crate) fn conditions(data: &Data, fit: &Fit, residuals: &Residuals) -> Vec<Condition> {
    let Some(states) = fit.states(data) else { return Vec::new() };
    let excess: Vec<Vec<f64>> = (0..data.runs.len()).map(|r| excess(data, residuals, r)).collect();
    let total: f64 = excess.iter().flatten().sum();
    let count: f64 = excess.iter().map(|e| e.len() as f64).sum();
    if total <= 0.0 {
        return Vec::new();
    }
    let divisions = divisions(data, &states);
    let mut found: Vec<(f64, Condition)> = Vec::new();
    let mut cell = |members: &[(usize, usize)]| {
        let (mut inside, mut samples) = (0.0, 0.0);
        for (r, excess) in excess.iter().enumerate() {
            for (row, e) in excess.iter().enumerate() {
                if members.iter().all(|(d, c)| divisions[*d].of[r][row] == *c) {
                    inside += e;
                    samples += 1.0;
                }
            }
        }
        let (share, of_time) = (inside / total, samples / count);
        // what stands out: much of the mismatch in little of the time
        if share > 0.2 && share > 1.3 * of_time {
            let when = members.iter().map(|(d, c)| divisions[*d].cells[*c].clone()).collect::<Vec<_>>().join(", ");
            let telling = share * (share / of_time.max(1e-6)).ln();
            found.push((telling, Condition { when, share: share.min(1.0), of_time }));
        }
    };
    // every cell, every two of different divisions, and every three of which the first is heating or cooling
    let cells: Vec<(usize, usize)> =
        divisions.iter().enumerate().flat_map(|(d, division)| (0..division.cells.len()).map(move |c| (d, c))).collect();
    for (i, first) in cells.iter().enumerate() {
        cell(&[*first]);
        for (j, second) in cells.iter().enumerate().skip(i + 1).filter(|(_, second)| second.0 > first.0) {
            cell(&[*first, *second]);
            if first.0 == 0 {
                for third in cells[j + 1..].iter().filter(|third| third.0 > second.0) {
                    cell(&[*first, *second, *third]);
                }
            }
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.truncate(MOST_CONDITIONS);
    found.into_iter().map(|(_, c)| c).collect()
}

fn divisions(data: &Data, states: &[Vec<State>]) -> Vec<Division> {
    let divide = |cells: Vec<String>, f: &dyn Fn(usize, usize, &State) -> usize| Division {
        of: states
            .iter()
            .enumerate()
            .map(|(r, states)| states.iter().enumerate().map(|(row, s)| f(r, row, s).min(cells.len() - 1)).collect())
            .collect(),
        cells,
    };
    let all = |f: &dyn Fn(&State) -> f64| -> Vec<f64> {
        let mut values: Vec<f64> = states.iter().flatten().map(f).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let quantile = |sorted: &[f64], q: f64| sorted[((sorted.len() - 1) as f64 * q) as usize];
    let in_bins = |edges: &[f64], unit: &str, digits: usize, name: &str| -> Vec<String> {
        let mut cells = vec![format!("{name} below {:.digits$} {unit}", edges[0])];
        cells.extend(edges.windows(2).map(|e| format!("{name} {:.digits$}–{:.digits$} {unit}", e[0], e[1])));
        cells.push(format!("{name} above {:.digits$} {unit}", edges[edges.len() - 1]));
        cells
    };
    let mut divisions =
        vec![divide(vec!["heating".into(), "cooling".into()], &|_, _, s| usize::from(s.warming_k < 0.0))];
    let temperatures = all(&|s| s.temperature_c);
    let (cold, hot) = (quantile(&temperatures, 0.02), quantile(&temperatures, 0.98));
    if hot - cold > 1.0 {
        let edges: Vec<f64> = (1..5).map(|i| cold + (hot - cold) * f64::from(i) / 5.0).collect();
        let place = edges.clone();
        divisions.push(divide(in_bins(&edges, "°C", 0, "temperature"), &move |_, _, s| {
            place.partition_point(|e| *e < s.temperature_c)
        }));
    }
    let phases = ["martensite below 0.1", "martensite 0.1–0.5", "martensite 0.5–0.9", "martensite above 0.9"];
    divisions.push(divide(phases.map(String::from).to_vec(), &|_, _, s| {
        [0.1, 0.5, 0.9].partition_point(|e| *e < s.martensite)
    }));
    let stresses = all(&|s| s.stress_pa * 1e-6);
    let (low, high) = (quantile(&stresses, 0.02), quantile(&stresses, 0.98));
    if high - low > 5.0 {
        let edges = [low + (high - low) / 3.0, low + (high - low) * 2.0 / 3.0];
        divisions.push(divide(in_bins(&edges, "MPa", 0, "stress"), &move |_, _, s| {
            edges.partition_point(|e| *e < s.stress_pa * 1e-6)
        }));
    }
    let drives: Vec<f64> = data.runs.iter().flat_map(|run| run.inputs.iter().map(|(i, _)| i.drive)).collect();
    let (least, most) = drives.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), d| (a.min(*d), b.max(*d)));
    if most > least {
        let middle = 0.5 * (least + most);
        divisions.push(divide(vec!["drive low".into(), "drive high".into()], &|r, row, _| {
            usize::from(data.runs[r].inputs[row].0.drive > middle)
        }));
    }
    // early or late, by the travel of the phase: what changes with every cycle
    let travel: Vec<Vec<f64>> = states
        .iter()
        .map(|states| {
            let mut sum = 0.0;
            let mut last = states.first().map_or(0.0, |s| s.martensite);
            states
                .iter()
                .map(|s| {
                    sum += (s.martensite - last).abs();
                    last = s.martensite;
                    0.5 * sum
                })
                .collect()
        })
        .collect();
    let cycles = travel.iter().filter_map(|t| t.last()).fold(0.0, |a: f64, b| a.max(*b));
    if cycles > 2.0 {
        let third = cycles / 3.0;
        let cells = vec![
            format!("cycles 0–{third:.0}"),
            format!("cycles {third:.0}–{:.0}", 2.0 * third),
            format!("cycles after {:.0}", 2.0 * third),
        ];
        divisions.push(divide(cells, &|r, row, _| (travel[r][row] / third) as usize));
    }
    divisions
}

/// chi over temperature × martensite, heating and cooling apart, before and after.
pub(crate) fn maps(data: &Data, fit: &Fit, before: &Residuals, after: &Residuals) -> Vec<Map> {
    let Some(states) = fit.states(data) else { return Vec::new() };
    let mut temperatures: Vec<f64> = states.iter().flatten().map(|s| s.temperature_c).collect();
    temperatures.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (temperatures.first(), temperatures.last()) else { return Vec::new() };
    let (low, high) = ((first / 5.0).floor() * 5.0, (last / 5.0).ceil() * 5.0);
    let columns = (((high - low) / 5.0) as usize).clamp(1, 24);
    let x_edges: Vec<f64> = (0..=columns).map(|i| low + (high - low) * i as f64 / columns as f64).collect();
    let y_edges: Vec<f64> = (0..=10).map(|i| f64::from(i) / 10.0).collect();
    ["heating", "cooling"]
        .into_iter()
        .enumerate()
        .map(|(direction, name)| {
            let chi = |residuals: &Residuals| -> Vec<Vec<f64>> {
                let mut sums = vec![vec![(0.0, 0.0); columns]; 10];
                for (r, states) in states.iter().enumerate() {
                    for (row, s) in states.iter().enumerate() {
                        if usize::from(s.warming_k < 0.0) != direction || data.runs[r].part[row] == Part::LeftOut {
                            continue;
                        }
                        let x = (((s.temperature_c - low) / (high - low).max(1e-9) * columns as f64) as usize)
                            .min(columns - 1);
                        let y = ((s.martensite * 10.0) as usize).min(9);
                        for values in &residuals[r] {
                            let v = f64::from(values[row]);
                            if !v.is_nan() {
                                sums[y][x].0 += v * v;
                                sums[y][x].1 += 1.0;
                            }
                        }
                    }
                }
                sums.into_iter()
                    .map(|row| {
                        row.into_iter()
                            .map(|(s, n): (f64, f64)| if n > 0.0 { (s / n).sqrt() } else { f64::NAN })
                            .collect()
                    })
                    .collect()
            };
            Map {
                x: format!("temperature while {name}, °C"),
                x_edges: x_edges.clone(),
                y: "martensite fraction".into(),
                y_edges: y_edges.clone(),
                before: chi(before),
                after: chi(after),
            }
        })
        .collect()
}

/// The window of an event, which counts from the first sample, with the share of what is left inside it, by recording.
pub(crate) fn share_in(data: &Data, residuals: &Residuals, start_s: f64, end_s: f64) -> Vec<Window> {
    let sums: Vec<Vec<f64>> = (0..data.runs.len()).map(|r| excess(data, residuals, r)).collect();
    let total: f64 = sums.iter().flatten().map(|e| e.max(0.0)).sum();
    data.runs
        .iter()
        .zip(&sums)
        .map(|(run, excess)| {
            let (start_s, end_s) = (run.time_s[0] + start_s, run.time_s[0] + end_s);
            let inside: f64 = run
                .time_s
                .iter()
                .zip(excess)
                .filter(|(t, _)| (start_s..=end_s).contains(*t))
                .map(|(_, e)| e.max(0.0))
                .sum();
            Window { recording: run.name.clone(), start_s, end_s, share: (inside / total.max(1e-300)).clamp(0.0, 1.0) }
        })
        .collect()
}
