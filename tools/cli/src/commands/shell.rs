//! `sinew completions` and `sinew man`: the command line as a shell and a manual know it, from its own description.

use std::fs;

use clap::CommandFactory;

use crate::args::{self, Cli};
use crate::failure::{Failure, Outcome};
use crate::output;

/// `sinew completions`.
pub fn completions(args: &args::Completions) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "sinew", &mut script);
    output::print(String::from_utf8_lossy(&script))
}

/// `sinew man`.
pub fn man(args: &args::Man) -> Outcome {
    let failed = |error: std::io::Error| {
        Failure::own(format!("{}: cannot be written: {error}", args.out.display()))
            .hint("choose a folder where you may write")
    };
    fs::create_dir_all(&args.out).map_err(failed)?;
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    clap_mangen::generate_to(command, &args.out).map_err(failed)?;
    output::note(format_args!("written: {}, with a page for each command", args.out.join("sinew.1").display()));
    Ok(())
}
