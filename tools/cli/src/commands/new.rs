//! `sinew new`: the first files of a bench.

use std::fmt::Write as _;
use std::io::{self, BufRead as _, IsTerminal as _};
use std::path::{Path, PathBuf};

use sinew_rig::{Rig, WIRE_KINDS, WireKind, nearest};
use sinew_starter::{Against, Bench, Language, Quantity, files};

use crate::args::{self, NamedLanguage};
use crate::failure::{Failure, Outcome};
use crate::output;

/// The wire where none is named: that of the built-in rig, as it is sold.
const USUAL_WIRE: &str = "flexinol-130-ht";
const USUAL_LENGTH: &str = "160mm";

/// `sinew new`.
pub fn new(args: &args::New) -> Outcome {
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from(&args.name));
    if folder.exists() {
        return Err(Failure::input(format!("{}: is there already", folder.display()))
            .hint("choose another name, or another folder with -o"));
    }
    // Before anything is asked: a name may say no more than a rig's may.
    let bench = Bench::of(&args.name, wire(USUAL_WIRE)?);
    checked(&bench)?;
    let bench = asked(args, bench)?;
    let language = language(args)?;
    checked(&bench)?;

    let files = files(&bench, &language, &output::json(&sinew_rig::schema())?);
    for file in &files {
        let path = folder.join(&file.path);
        let parent = path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(parent).map_err(|error| {
            Failure::own(format!("{}: cannot be made: {error}", parent.display()))
                .hint("choose a folder where you may write with -o")
        })?;
        output::write_file(&path, &file.text)?;
    }
    for doubt in bench.doubts() {
        output::note(format_args!("warning: {doubt}"));
    }
    output::print(next_steps(&bench, &folder, &language))
}

/// What comes next, in the order it is typed.
fn next_steps(bench: &Bench, folder: &Path, language: &Language) -> String {
    let Bench { name, channels, .. } = bench;
    let wires =
        if channels.len() == 1 { "the wire moves".into() } else { format!("the {} wires move", channels.len()) };
    let robot = match language {
        Language::Python => "python3 robot.py",
        Language::Rust { .. } => "cargo run",
    };
    let mut text = format!("{}: made. Next:\n\n", folder.display());
    for (command, what) in [
        (format!("cd {}", folder.display()), String::new()),
        (format!("sinew run {name}.toml"), format!("{wires} by simulation; Ctrl-C ends it")),
        (robot.into(), "in another terminal: your first robot program".into()),
        ("sinew scope".into(), "in a third: the wires in a browser".into()),
    ] {
        // writing to a String cannot fail
        let _ = match what.is_empty() {
            true => writeln!(text, "  {command}"),
            false => writeln!(text, "  {command:<28} # {what}"),
        };
    }
    text
}

/// The rig file of a bench has to be one, and one that can be driven: what is wrong with a name, say, is said as for any rig file.
fn checked(bench: &Bench) -> Outcome {
    let file = format!("{}.toml", bench.name);
    let wrong = |error: sinew_rig::Error| Failure::input(error).hint("change what you gave to `sinew new`");
    Rig::parse(&bench.rig_file(), &file).map_err(wrong)?.check_drivable().map_err(wrong)
}

fn language(args: &args::New) -> Result<Language, Failure> {
    let built = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    Ok(match args.language {
        NamedLanguage::Python => Language::Python,
        NamedLanguage::Rust => {
            let sources = args.sources.clone().unwrap_or(built);
            if !sources.join("ipc/Cargo.toml").is_file() {
                return Err(Failure::input(format!("{}: holds no sources of sinew", sources.display()))
                    .hint("name a checkout with --sources, or take --language python"));
            }
            Language::Rust { sources: sources.canonicalize().unwrap_or(sources) }
        }
    })
}

fn wire(name: &str) -> Result<&'static WireKind, Failure> {
    WireKind::of(name).ok_or_else(|| {
        let names = || WIRE_KINDS.iter().map(|kind| kind.name);
        let hint = match nearest(name, names()) {
            Some(near) => format!("did you mean {near}? There are: {}", names().collect::<Vec<_>>().join(", ")),
            None => format!("there are: {}", names().collect::<Vec<_>>().join(", ")),
        };
        let more = "; any other wire goes into the rig file by its diameter (docs/rig.md)";
        Failure::input(format!("no wire is known as {name:?}")).hint(hint + more)
    })
}

fn quantity(of: Quantity, option: &str, text: &str) -> Result<f64, Failure> {
    of.read(text).map_err(|malformed| Failure::input(format!("{option}: {malformed}")).hint(malformed.remedy()))
}

/// What the options say of a bench, and what its owner says where they say nothing and somebody is there to be asked.
fn asked(args: &args::New, bench: Bench) -> Result<Bench, Failure> {
    let mut ask = Ask { is_there: !args.yes && io::stdin().is_terminal() && io::stderr().is_terminal() };
    let wire = match &args.wire {
        Some(name) => wire(name)?,
        None => {
            ask.until("Which wire? (flexinol-25 to flexinol-510, -lt for 70 °C or -ht for 90 °C)", USUAL_WIRE, wire)?
        }
    };
    let length = |text: &str| quantity(Quantity::Length, "--length", text);
    let length_m = match &args.length {
        Some(text) => length(text)?,
        None => ask.until("How long is it when hot?", USUAL_LENGTH, length)?,
    };
    let against = |text: &str| -> Result<Against, Failure> {
        if text == "spring" {
            return Ok(Against::ChosenSpring);
        }
        match Quantity::Stiffness.read(text) {
            Ok(stiffness_n_per_m) => Ok(Against::Spring { stiffness_n_per_m }),
            Err(_) => Ok(Against::Weight { force_n: quantity(Quantity::Force, "--weight", text)? }),
        }
    };
    let against = match (&args.weight, &args.spring) {
        (Some(text), _) => Against::Weight { force_n: quantity(Quantity::Force, "--weight", text)? },
        (None, Some(text)) => Against::Spring { stiffness_n_per_m: quantity(Quantity::Stiffness, "--spring", text)? },
        (None, None) => ask.until("What does it pull against? (a weight such as 100g, a spring such as 150N/m, or `spring` for one that suits it)", "spring", against)?,
    };
    let volts = |text: &str| quantity(Quantity::Voltage, "--supply", text);
    let bench = Bench { wire, length_m, against, ..bench };
    let supply_v = match &args.supply {
        Some(text) => volts(text)?,
        None => ask.until("Which supply?", &format!("{}V", bench.supply_v()), volts)?,
    };
    let names = |text: &str| Ok(text.split(',').map(|name| name.trim().to_owned()).collect::<Vec<_>>());
    let channels = match args.channels.as_slice() {
        [] => ask.until("What are the wires called? (separated by commas)", "wire", names)?,
        given => given.to_vec(),
    };
    Ok(Bench { supply_v: Some(supply_v), channels, ..bench })
}

/// Somebody at a terminal, if there is one.
struct Ask {
    is_there: bool,
}

impl Ask {
    /// Asks until the answer can be read; an empty line, or nobody to be asked, means what is usual.
    fn until<T>(
        &mut self,
        question: &str,
        usual: &str,
        read: impl Fn(&str) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        while self.is_there {
            output::note(format_args!("{question} [{usual}]"));
            let mut line = String::new();
            let answered = io::stdin().lock().read_line(&mut line);
            match line.trim() {
                // the end of input: nobody is there any more
                _ if !matches!(answered, Ok(1..)) => self.is_there = false,
                "" => break,
                answer => match read(answer) {
                    Ok(value) => return Ok(value),
                    Err(failure) => output::note(failure),
                },
            }
        }
        read(usual)
    }
}
