//! `sinew conceal` and `sinew reveal`.

use std::path::PathBuf;

use clap::Args;

/// `sinew conceal`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew conceal riddle                                        something, or nothing: whatever the dice say
  sinew conceal riddle --effect mechanical.friction --level 10
  sinew conceal riddle --effect thermal.draught --effect kinetic.lag --recordings 2
  sinew conceal riddle --nothing                              does the diagnosis find what is not there?
  sinew conceal --list

The recording is made by a simulator that shares no code with the one the diagnosis fits with: another form of the equations, another integrator, its
own sensors; the same that judges the diagnosis in docs/proof.md. The folder gets what a laboratory would have, rig.toml and recording.csv, and
answer.sealed: what is true, in an envelope. The envelope keeps a glance from reading it and no more; its seal, which is printed, shows
that nobody has changed it since. Then `sinew diagnose`, and `sinew reveal` sets what was hidden beside what was found.")]
pub struct Conceal {
    /// The folder to be made.
    #[arg(value_name = "FOLDER", required_unless_present = "list")]
    pub folder: Option<PathBuf>,
    /// What is hidden: an effect of the catalogue by its id, up to three of them, or one from outside it by its name.
    #[arg(long = "effect", value_name = "NAME", conflicts_with = "nothing")]
    pub effects: Vec<String>,
    /// Hide nothing: only the parameters are off, within their tolerances.
    #[arg(long)]
    pub nothing: bool,
    /// How much is to be left of it once all parameters are refitted, in units of the noise: 1 is faint, 3 plain, 10 obvious. Without it, 3 or 10.
    #[arg(long, value_name = "L", value_parser = level, allow_negative_numbers = true, conflicts_with = "nothing")]
    pub level: Option<f64>,
    /// What everything random comes from, 0 to 4294967295: the same seed, the same files. Without it, one that nobody is told before the envelope is open.
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,
    /// How many recordings there are, under different programmes.
    #[arg(long, value_name = "1|2", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub recordings: u8,
    /// What can be hidden, and nothing else.
    #[arg(long, conflicts_with = "folder")]
    pub list: bool,
}

/// `sinew reveal`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew reveal riddle
  sinew reveal riddle --answer elsewhere --seal 6b1f…     what was diagnosed there, and the seal that was printed
  sinew reveal riddle --json | jq .right

Right and wrong are told by the rules by which docs/proof.md counts.")]
pub struct Reveal {
    /// A folder of `sinew conceal`.
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Where `sinew diagnose` wrote its answer; without it, FOLDER/answer, if it is there.
    #[arg(long, value_name = "DIR")]
    pub answer: Option<PathBuf>,
    /// The seal that `sinew conceal` printed, or its beginning: another envelope is refused.
    #[arg(long, value_name = "SHA256")]
    pub seal: Option<String>,
    /// As JSON ("sinew.reveal/1").
    #[arg(long)]
    pub json: bool,
}

/// From half the noise to thirty times it.
fn level(text: &str) -> Result<f64, String> {
    let level = text.parse().ok().filter(|level: &f64| (0.5..=30.0).contains(level));
    level.ok_or_else(|| "0.5 to 30, in units of the noise".to_string())
}
