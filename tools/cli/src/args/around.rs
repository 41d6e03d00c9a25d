//! What stands around a rig file and a shell: `sinew check`, `schema`, `completions`, `man`.

use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

use super::Laws;

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
  sinew man --out ~/.local/share/man/man1 && man sinew-run")]
pub struct Man {
    /// The folder for the pages, one for each command; made where it is missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}
