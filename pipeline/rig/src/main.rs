//! `rig`: the virtual bench as a program.
//!
//! Stands on: its library. Never knows: anything else.

use std::process::ExitCode;

fn main() -> ExitCode {
    rig::command::run()
}
