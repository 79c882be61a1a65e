//! `study`: the pipeline's command line. Exit code 0 when all is made, 1 for bad input or drift, 2 for usage.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use study::cli::{Checked, Cli, Command, Place};
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
    let open = || open(&cli.place);
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
        Command::Plan { names, specimen, graph } => {
            let (runner, faults) = open()?;
            plan(&runner, &Goal { entries: names.clone(), specimen: specimen.clone() }, graph.as_ref())?;
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
        Command::Fit { page, out } => {
            let page = study::released::page(&cli.place.root, page);
            let (report, folder) = study::released::run(&cli.place.root, &page, out.as_deref())?;
            println!("{report}results: {}", folder.display());
            Ok(true)
        }
        Command::Fetch { page } => {
            let page = study::released::page(&cli.place.root, page);
            for place in study::released::fetch(&cli.place.root, &page)? {
                println!("{}", place.display());
            }
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

fn open(place: &Place) -> Outcome<(Runner, Vec<Fault>)> {
    let (mut runner, faults) = study::open(&place.root, place.profile.into(), place.quiet, place.jobs)?;
    (runner.keep_going, runner.spare) = (place.keep_going, place.spare);
    Ok((runner, faults))
}

/// Prints the plan, as a list or a tree, or draws it.
fn plan(runner: &Runner, goal: &Goal, graph: Option<&Option<PathBuf>>) -> Outcome<()> {
    match graph {
        None => println!("{}", runner.plan(goal)?),
        Some(None) => println!("{}", runner.tree(goal)?),
        Some(Some(file)) => std::fs::write(file, runner.drawing(goal)?).map_err(|e| {
            Fault::new(format!("{} cannot be written", file.display()), e, "choose another place for the drawing")
        })?,
    }
    Ok(())
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
