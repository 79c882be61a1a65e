//! `study`: the pipeline's command line. Exit code 0 when all is made, 1 for bad input or drift, 2 for usage.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use study::cli::{Checked, Cli, Command};
use study::fault::{Fault, Outcome};
use study::runner::{Goal, Runner, Tally};

fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(&cli) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(fault) => {
            eprintln!("{fault}");
            ExitCode::FAILURE
        }
    }
}

/// Does what is asked; says whether all of it went well.
fn run(cli: &Cli) -> Outcome<bool> {
    let open = || study::open(&cli.place.root, cli.place.profile.into(), cli.place.quiet, cli.place.jobs);
    match &cli.command {
        Command::Init { name } => {
            let begun = study::init::run(&cli.place.root, cli.place.profile.into(), name)?;
            println!("{begun}");
            Ok(true)
        }
        Command::Doctor { name } => {
            let (runner, _) = open()?;
            let told = study::doctor::run(&runner, name.as_deref())?;
            print!("{told}");
            Ok(told.is_well())
        }
        Command::Run { names, specimen, fresh } => {
            let (runner, faults) = open()?;
            let goal = Goal { entries: names.clone(), specimen: specimen.clone() };
            let tally = runner.run(&goal, *fresh)?;
            runner.page()?;
            Ok(tell(&faults) & well(tally))
        }
        Command::Fig { name } | Command::Table { name } => {
            let (runner, faults) = open()?;
            Ok(tell(&faults) & well(runner.run(&Goal { entries: vec![name.clone()], specimen: None }, false)?))
        }
        Command::Page => {
            let (runner, faults) = open()?;
            println!("{}", runner.page()?.display());
            Ok(tell(&faults))
        }
        Command::Plan { names, specimen } => {
            let (runner, faults) = open()?;
            println!("{}", runner.plan(&Goal { entries: names.clone(), specimen: specimen.clone() })?);
            Ok(tell(&faults))
        }
        Command::Why { name } => {
            let (runner, faults) = open()?;
            println!("{}", runner.why(name)?);
            Ok(tell(&faults))
        }
        Command::Simulate { case, out } => {
            study::simulate::run(case, out.as_deref(), cli.place.quiet)?;
            Ok(true)
        }
        Command::Track(asked) => {
            let summary = study::follow::run(asked)?;
            if !cli.place.quiet {
                println!("{summary}");
            }
            Ok(true)
        }
        Command::Check { what: None } => check(&open()?.0),
        Command::Check { what: Some(Checked::Gradients { cases, steps }) } => {
            certify(&cli.place.root, cases, *steps, cli.place.quiet)
        }
        Command::Paper => {
            let (runner, faults) = open()?;
            let place = study::paper(&runner)?;
            if !cli.place.quiet {
                println!("{}", runner.folders.tell(&place));
            }
            Ok(tell(&faults))
        }
        Command::List => {
            print!("{}", study::story());
            Ok(true)
        }
    }
}

fn check(runner: &Runner) -> Outcome<bool> {
    let checked = study::check(runner)?;
    println!("{}", checked.text);
    Ok(!checked.drifted)
}

/// Certifies every case, and says whether all of them hold.
fn certify(root: &Path, cases: &[PathBuf], steps: usize, quiet: bool) -> Outcome<bool> {
    let cases = if cases.is_empty() { study::certify::examples(root)? } else { cases.to_vec() };
    let mut hold = true;
    for case in &cases {
        let certificate = study::certify::run(case, steps)?;
        hold &= certificate.holds();
        if !quiet || !certificate.holds() {
            println!("{certificate}");
        }
    }
    Ok(hold)
}

fn tell(faults: &[Fault]) -> bool {
    faults.iter().for_each(|fault| eprintln!("{fault}"));
    faults.is_empty()
}

fn well(tally: Tally) -> bool {
    tally.failed == 0 && tally.skipped == 0
}
