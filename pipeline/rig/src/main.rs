//! The program `rig`.

use std::process::ExitCode;

fn main() -> ExitCode {
    rig::command::run()
}
