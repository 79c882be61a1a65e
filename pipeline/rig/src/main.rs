//! The program `rig`.

use std::process::ExitCode;

fn main() -> ExitCode {
    diagnostics::processor::run(rig::command::run)
}
