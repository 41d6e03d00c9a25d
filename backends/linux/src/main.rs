//! The guard as a separate program, for programs that do not contain it (`sinew` does).

use std::process::ExitCode;

fn main() -> ExitCode {
    sinew_linux_backend::guard::main(std::env::args_os().skip(1))
}
