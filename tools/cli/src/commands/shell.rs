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
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    let Some(folder) = &args.out else { return one_page(&command, &args.command) };
    let failed = |error: std::io::Error| {
        Failure::own(format!("{}: cannot be written: {error}", folder.display()))
            .hint("choose a folder where you may write")
    };
    fs::create_dir_all(folder).map_err(failed)?;
    clap_mangen::generate_to(command, folder).map_err(failed)?;
    output::note(format_args!("written: {}, with a page for each command", folder.join("sinew.1").display()));
    Ok(())
}

/// The page of the command that these words name, to stdout.
fn one_page(of: &clap::Command, words: &[String]) -> Outcome {
    let mut command = of;
    for word in words {
        command = command.find_subcommand(word).ok_or_else(|| {
            Failure::input(format!("{} has no command `{word}`", command.get_bin_name().unwrap_or("sinew")))
                .hint("`sinew --help` lists the commands")
        })?;
    }
    let mut page = Vec::new();
    clap_mangen::Man::new(command.clone())
        .render(&mut page)
        .map_err(|error| Failure::own(format!("the page cannot be made: {error}")))?;
    output::print(String::from_utf8_lossy(&page))
}
