//! What stands around a rig file and a shell: `sinew new`, `check`, `schema`, `completions`, `man`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use clap_complete::Shell;

use super::Laws;

/// `sinew new`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew new gripper                                          asks what lies on the bench
  sinew new gripper --wire flexinol-150-ht --length 160mm    one wire, with a spring that suits it
  sinew new arm --wire flexinol-100-lt --length 6in --weight 50g --supply 5V --channels biceps,triceps
  sinew new arm --language rust                              with a robot program in Rust

Lengths take mm, cm, m, in; weights g, kg, oz, lb, N; springs N/m, N/mm, g/mm. A new folder gets the rig file, which runs at once in simulation,
a robot program, and the settings by which editors complete and check the file. What is there already stays as it is.")]
pub struct New {
    /// Name of the rig: letters, digits, `-`, `_` and `.`. The folder and the rig file are called like it.
    #[arg(value_name = "NAME")]
    pub name: String,
    /// What the wires are sold as, such as flexinol-150-lt; a wrong name lists them all.
    #[arg(long, value_name = "KIND")]
    pub wire: Option<String>,
    /// How long they are when hot.
    #[arg(long, value_name = "LENGTH")]
    pub length: Option<String>,
    /// What hangs on each of them.
    #[arg(long, value_name = "WEIGHT", conflicts_with = "spring")]
    pub weight: Option<String>,
    /// The spring each of them pulls against; without it and `--weight` one is chosen.
    #[arg(long, value_name = "STIFFNESS")]
    pub spring: Option<String>,
    /// Voltage of the supply; without it one is chosen.
    #[arg(long, value_name = "VOLTAGE")]
    pub supply: Option<String>,
    /// Names of the wires.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pub channels: Vec<String>,
    /// What the robot program is written in.
    #[arg(long, value_name = "LANGUAGE", value_enum, default_value = "python")]
    pub language: NamedLanguage,
    /// A checkout of this project, for a robot program in Rust; without it, where this program was built.
    #[arg(long, value_name = "DIR")]
    pub sources: Option<PathBuf>,
    /// The folder to be made; without it, NAME.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Ask nothing: what is not given is chosen.
    #[arg(short, long)]
    pub yes: bool,
}

/// A language for robot programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum NamedLanguage {
    /// With the package `sinew`.
    Python,
    /// With the crate `sinew-ipc`.
    Rust,
}

/// `sinew check`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew check my-rig.toml
  sinew check my-rig.toml --json | jq '.channel[] | {name, stroke_mm}'

Every mistake is told at once, each with its line and what would be right; exit code 2 where there is one.")]
pub struct Check {
    /// The rig file.
    #[arg(value_name = "RIG.toml")]
    pub rig: PathBuf,
    /// As JSON ("sinew.check/1").
    #[arg(long)]
    pub json: bool,
    /// Laws of one's own.
    #[command(flatten)]
    pub laws: Laws,
}

/// `sinew schema`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew schema > rig.schema.json

An editor completes and checks by it: put `#:schema ./rig.schema.json` into the first line of the rig file (taplo, and VS Code with Even Better TOML).")]
pub struct Schema {}

/// `sinew completions`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew completions bash > ~/.local/share/bash-completion/completions/sinew
  sinew completions zsh > ~/.zfunc/_sinew
  sinew completions fish > ~/.config/fish/completions/sinew.fish")]
pub struct Completions {
    /// For which shell.
    pub shell: Shell,
}

/// `sinew man`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew man run | man -l -                               one page, to read
  sinew man --out ~/.local/share/man/man1 && man sinew-run")]
pub struct Man {
    /// The command whose page goes to stdout, such as `run` or `recording info`; without one, that of sinew itself.
    #[arg(value_name = "COMMAND", conflicts_with = "out")]
    pub command: Vec<String>,
    /// The folder for all pages, one for each command; made where it is missing.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}
