//! `sinew plot`: recordings as figures.

use std::path::Path;

use sinew_figures::{Error, Figure, Kind, Order, Source, gather};

use super::simulate::recording_failure;
use crate::args::{self, PlotKind};
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::Progress;

/// Stretches of all curves of a picture together, and of one: finer than a printer.
const PICTURE: (usize, usize) = (60_000, 1000);
/// The same of a page, which can be zoomed into: at most some ten megabytes.
const PAGE: (usize, usize) = (150_000, 25_000);

/// What a figure becomes.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Form {
    Svg,
    #[cfg(feature = "png")]
    Png,
    Html,
}

/// Runs the command.
pub fn plot(args: &args::Plot) -> Outcome {
    let form = form(&args.output)?;
    output::has_place(&args.output)?;
    let (from_s, to_s) = (args.from.unwrap_or(f64::NEG_INFINITY), args.to.unwrap_or(f64::INFINITY));
    if from_s.is_nan() || to_s.is_nan() || from_s >= to_s {
        return Err(Failure::input(format!("nothing lies from {from_s} to {to_s} s")).hint("--to is later than --from"));
    }
    let open = |path| Source::open(path, args.ignore_columns).map_err(failure);
    let sources: Vec<Source> = args.recordings.iter().map(|path| open(path)).collect::<Result<_, _>>()?;
    let (points, stretches) = if form == Form::Html { PAGE } else { PICTURE };
    let order = Order {
        kinds: kinds(&args.kind),
        insists: !args.kind.contains(&PlotKind::All),
        channels: args.channel.clone(),
        quantities: args.quantity.clone(),
        from_s,
        to_s,
        title: args.title.clone(),
        points,
        stretches,
    };
    let progress = Progress::new();
    let figure =
        gather(&sources, &order, &mut |done, total| progress.count("reading", done, total)).map_err(failure)?;
    progress.clear();
    figure.notes.iter().for_each(output::note);
    write(&figure, &args.output)?;
    let how = if form == Form::Html { ", for a browser" } else { "" };
    output::print(format_args!("{}: written{how}\n", args.output.display()))
}

/// Writes a figure in the form that its name asks for.
pub(super) fn write(figure: &Figure, path: &Path) -> Outcome {
    match form(path)? {
        Form::Svg => output::write_file(path, figure.svg()),
        Form::Html => output::write_file(path, figure.html()),
        #[cfg(feature = "png")]
        Form::Png => output::write_file(path, figure.png().map_err(failure)?),
    }
}

pub(super) fn form(path: &Path) -> Result<Form, Failure> {
    let ending = path.extension().and_then(|e| e.to_str()).map(str::to_lowercase);
    match ending.as_deref() {
        Some("svg") => Ok(Form::Svg),
        #[cfg(feature = "png")]
        Some("png") => Ok(Form::Png),
        #[cfg(not(feature = "png"))]
        Some("png") => Err(Failure::left_out(format_args!("{}: a figure as PNG", path.display()), "png")
            .also("it writes .svg and .html")),
        Some("html" | "htm") => Ok(Form::Html),
        _ => Err(Failure::input(format!("{}: what kind of file is that to be?", path.display()))
            .hint("end its name in .svg, .png or .html")),
    }
}

fn kinds(asked: &[PlotKind]) -> Vec<Kind> {
    if asked.contains(&PlotKind::All) {
        return Kind::ALL.to_vec();
    }
    let kind = |kind: &PlotKind| match kind {
        PlotKind::Hysteresis => Kind::Hysteresis,
        PlotKind::Resistance => Kind::Resistance,
        PlotKind::Tension => Kind::Tension,
        PlotKind::Phase => Kind::Phase,
        PlotKind::Lateness => Kind::Lateness,
        PlotKind::Time | PlotKind::All => Kind::Time,
    };
    asked.iter().map(kind).collect()
}

fn failure(error: Error) -> Failure {
    let remedy = error.remedy();
    let failure = match error {
        Error::Recording(error) => return recording_failure(error),
        Error::Picture { .. } => Failure::own(error),
        _ => Failure::input(error),
    };
    if remedy.is_empty() { failure } else { failure.hint(remedy) }
}
