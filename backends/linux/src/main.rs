//! The guard as a program of its own, for programs that are not their own guard (`sinew` is).

use std::process::ExitCode;

fn main() -> ExitCode {
    sinew_linux_backend::guard::main(std::env::args_os().skip(1))
}
