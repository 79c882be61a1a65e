//! `study`: the pipeline's command line. Exit code 0 for success, 1 for bad input or drift, 2 for usage.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use cli::options::{CalibrateCamera, Checked, Cli, Command, Exported, Place};
use cli::twin::ExportedTwin;
use diagnostics::{Diagnostic, Result, next_move, output, processor};
use simulate::RunOptions;
use study::Runner;
use track::board::{Target, TargetKind};
use workflow::runner::{Goal, Options};
use workflow::settings;
use workflow::snakemake::{self, Export, Workflow};

// A plan of thirty thousand records spends a third of its time in the allocator of glibc, whose threads ask the kernel for every page.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    processor::run(run_program)
}

fn run_program() -> ExitCode {
    let cli = Cli::parse();
    next_move::repeat_options(&place_options(&cli.place));
    match set_threads(cli.place.threads).and_then(|()| run_command(&cli)) {
        Ok(true) if !output::failed() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(diagnostic) => {
            output::note(format_args!("error: {diagnostic}"));
            ExitCode::FAILURE
        }
    }
}

/// The options by which a later command finds the same records, where they are not the defaults.
fn place_options(place: &Place) -> Vec<(&str, &str)> {
    let profile = settings::Profile::from(place.profile);
    let root = place.root.to_str().filter(|root| *root != ".").map(|root| ("--root", root));
    let profile = Some(profile.name()).filter(|_| profile != settings::Profile::Paper).map(|name| ("--profile", name));
    root.into_iter().chain(profile).collect()
}

/// Sets the number of threads of all parallel loops.
fn set_threads(number: Option<usize>) -> Result<()> {
    Ok(number.map_or(Ok(()), |number| rayon::ThreadPoolBuilder::new().num_threads(number).build_global())?)
}

/// Runs the command; returns whether all of it succeeded.
fn run_command(cli: &Cli) -> Result<bool> {
    let open = || open_study(&cli.place);
    match &cli.command {
        Command::Init { name, from } => {
            let (root, profile) = (&cli.place.root, cli.place.profile.into());
            output::line(match from {
                Some(folder) => cli::init::from_folder(root, profile, (name, folder))?,
                None => cli::init::run(root, profile, name)?,
            });
            Ok(true)
        }
        Command::Doctor { name: Some(name) }
            if cli::proposal::is_folder(&cli.place.root, cli.place.profile.into(), name) =>
        {
            let (proposal, path) = cli::proposal::write(Path::new(name))?;
            output::text(&proposal);
            output::line(format_args!("{}: fill in the lines marked FILL IN and check the others", path.display()));
            Ok(true)
        }
        Command::Doctor { name } => {
            let (runner, _) = open()?;
            let report = cli::doctor::run(&runner, name.as_deref())?;
            output::text(&report);
            Ok(report.is_well())
        }
        Command::Run { names, specimen, fresh } => {
            let (runner, diagnostics) = open()?;
            study::readable(&diagnostics, specimen.as_deref())?;
            let goal = Goal { entries: names.clone(), group: specimen.clone() };
            if !cli.place.quiet {
                cli::pictures::left_out(&runner, &goal).iter().for_each(output::note);
            }
            let summary = study::run(&runner, &goal, *fresh)?;
            study::page(&runner)?;
            Ok(print_others(&diagnostics, specimen.as_deref()) & summary.is_complete())
        }
        Command::Fig { name } | Command::Table { name } => {
            let (runner, diagnostics) = open()?;
            let goal = Goal { entries: vec![name.clone()], group: None };
            Ok(print_diagnostics(&diagnostics) & study::run(&runner, &goal, false)?.is_complete())
        }
        Command::Make { records } => {
            let (runner, diagnostics) = open()?;
            records.iter().try_for_each(|record| study::readable(&diagnostics, record.split('/').nth(1)))?;
            Ok(runner.make(records)?.is_complete())
        }
        Command::Publish { names } => {
            let (runner, diagnostics) = open()?;
            let goal = Goal { entries: names.clone(), group: None };
            output::line(study::publish(&runner, &goal)?.display());
            Ok(print_diagnostics(&diagnostics))
        }
        Command::Page => {
            let (runner, diagnostics) = open()?;
            output::line(study::page(&runner)?.display());
            let outdated = study::outdated(&runner)?;
            publish::outdated::in_words(&outdated).iter().for_each(output::line);
            Ok(print_diagnostics(&diagnostics) & outdated.is_empty())
        }
        Command::Plan { names, specimen, graph, schedule, times } => {
            let (runner, diagnostics) = open()?;
            study::readable(&diagnostics, specimen.as_deref())?;
            let goal = Goal { entries: names.clone(), group: specimen.clone() };
            match schedule.is_empty() {
                true if *times => output::line(runner.times(&goal)?),
                true => print_plan(&runner, &goal, graph.as_ref())?,
                false => output::line(runner.schedule(&goal, schedule)?),
            }
            Ok(print_others(&diagnostics, specimen.as_deref()))
        }
        Command::Why { name } => {
            let (runner, diagnostics) = open()?;
            output::line(runner.why(name)?);
            Ok(print_diagnostics(&diagnostics))
        }
        Command::Simulate { case, out, certify, budget } => {
            let (out, budget) = (out.clone(), (*budget).into());
            let options = RunOptions { out, quiet: cli.place.quiet, budget, ..RunOptions::default() };
            match certify {
                true => simulate::certify(case, options)?.1.iter().for_each(output::line),
                false => simulate::run_with(case, options).map(|_| ())?,
            }
            Ok(true)
        }
        Command::Reduce(asked) => {
            output::line(simulate::reduce(&asked.options(cli.place.quiet))?);
            Ok(true)
        }
        Command::Mesh(asked) => {
            output::text(cli::meshing::run(asked, cli.place.quiet)?.report);
            Ok(true)
        }
        Command::Fit { page, out } => {
            let page = sysid::free_vibration::page(&cli.place.root, page);
            if sysid::joint_fit::is_page(&page) {
                let (report, folder) = sysid::joint_fit::run(&cli.place.root, &page, out.as_deref())?;
                output::line(format_args!("{report}results: {}", folder.display()));
            } else if sysid::inflation_test::is_page(&page) {
                let (report, folder) = sysid::inflation_test::run(&cli.place.root, &page, out.as_deref())?;
                output::line(format_args!("{report}results: {}", folder.display()));
            } else {
                let (report, folder) = sysid::free_vibration::run(&cli.place.root, &page, out.as_deref(), None)?;
                output::line(format_args!("{report}results: {}", folder.display()));
            }
            Ok(true)
        }
        Command::Fetch { page } => {
            let page = sysid::free_vibration::page(&cli.place.root, page);
            for recording in sysid::free_vibration::fetch(&cli.place.root, &page)? {
                output::line(recording.display());
            }
            Ok(true)
        }
        Command::Force { page, out } => {
            let (report, folder) = instruments::force::run(page, out.as_deref())?;
            output::line(format_args!("{report}results: {}", folder.display()));
            Ok(true)
        }
        Command::Calibrate(asked) => {
            let request = calibration_request(asked);
            let camera = instruments::calibrate::camera(&request, None)?;
            output::line(camera.summary(&request.out.unwrap_or_default()));
            Ok(true)
        }
        Command::Track(asked) => {
            let tracked = cli::track::run(asked)?;
            if !cli.place.quiet {
                output::line(&tracked.summary);
            }
            Ok(tracked.complete)
        }
        Command::Check { what: None, junit } => {
            let (runner, diagnostics) = open_without_specimens(&cli.place)?;
            Ok(check_records(&runner, junit.as_deref())? & print_diagnostics(&diagnostics))
        }
        Command::Check { what: Some(Checked::Gradients { cases, steps }), .. } => {
            check_gradients(&cli.place.root, cases, *steps, cli.place.quiet)
        }
        Command::Paper => {
            // the paper profile is set from what is tracked where nothing was recorded
            let (runner, diagnostics) = open_without_specimens(&cli.place)?;
            let pdf_path = study::paper(&runner)?;
            if !cli.place.quiet {
                output::line(runner.folders.display(&pdf_path));
            }
            Ok(print_diagnostics(&diagnostics))
        }
        Command::Export { what: Exported::Snakemake { folder, only, marks } } => {
            let (runner, diagnostics) = open()?;
            let goal = Goal { entries: only.clone(), group: None };
            match (marks, folder) {
                (true, Some(folder)) => snakemake::update(&runner, folder, &goal)?,
                _ => {
                    let (folder, program) = (folder.clone(), std::env::current_exe()?);
                    let Workflow { folder, kept } = snakemake::export(&runner, &Export { folder, program, goal })?;
                    print_export(&folder, &kept);
                }
            }
            Ok(print_diagnostics(&diagnostics))
        }
        Command::Export { what: Exported::Twin { name, folder } } => {
            let (runner, diagnostics) = open()?;
            study::readable(&diagnostics, Some(name))?;
            let ExportedTwin { folder, kept } = cli::twin::export(&runner, name, folder.as_deref())?;
            print_export(&folder, &kept);
            Ok(print_diagnostics(&diagnostics))
        }
        Command::List => {
            output::text(study::description());
            Ok(true)
        }
    }
}

fn calibration_request(asked: &CalibrateCamera) -> instruments::calibrate::Request {
    let kind = match asked.charuco {
        Some(dictionary) => TargetKind::charuco(asked.marker, Some(dictionary)),
        None if asked.asymmetric_dots => TargetKind::AsymmetricDots,
        None if asked.dots => TargetKind::Dots,
        None => TargetKind::Checkerboard,
    };
    instruments::calibrate::Request {
        source: asked.source.clone(),
        target: Target::new(kind, [asked.columns, asked.rows], asked.square),
        fisheye: asked.fisheye,
        every: asked.every,
        out: Some(asked.out.clone().unwrap_or_else(|| instruments::calibrate::beside(&asked.source))),
    }
}

/// Prints where an export lies and what of it was kept.
fn print_export(folder: &Path, kept: &[PathBuf]) {
    kept.iter().for_each(|path| output::note(format_args!("kept as it was edited: {}", path.display())));
    output::line(folder.display());
}

fn runner_options(place: &Place) -> Options {
    let Place { quiet, jobs, memory, keep_going, min_free_memory, .. } = *place;
    Options { quiet, jobs, memory, keep_going, min_free_memory }
}

fn open_study(place: &Place) -> Result<(Runner, Vec<Diagnostic>)> {
    study::open(&place.root, place.profile.into(), runner_options(place))
}

/// The same where nothing needs to have been recorded.
fn open_without_specimens(place: &Place) -> Result<(Runner, Vec<Diagnostic>)> {
    study::open_without_specimens(&place.root, place.profile.into(), runner_options(place))
}

/// Prints the plan, as a list or a tree, or draws it.
fn print_plan(runner: &Runner, goal: &Goal, graph: Option<&Option<PathBuf>>) -> Result<()> {
    match graph {
        None => output::line(runner.plan(goal)?),
        Some(None) => output::line(runner.tree(goal)?),
        Some(Some(file)) => std::fs::write(file, study::plan_svg(runner, goal)?).map_err(|e| {
            Diagnostic::new(format!("{} cannot be written", file.display()), e, "choose another place for the drawing")
        })?,
    }
    Ok(())
}

fn check_records(runner: &Runner, junit: Option<&Path>) -> Result<bool> {
    let checked = study::check(runner)?;
    if let Some(file) = junit {
        let written = std::fs::write(file, &checked.junit);
        written.map_err(|e| Diagnostic::io(file, e, "choose another place for the report"))?;
    }
    output::line(checked.text);
    Ok(checked.holds)
}

/// Checks the gradients of every case and reduced tail; returns whether all of them pass.
fn check_gradients(root: &Path, cases: &[PathBuf], steps: usize, quiet: bool) -> Result<bool> {
    let is_twin = |path: &&PathBuf| path.extension().is_some_and(|ending| ending == cli::twin::ENDING);
    let (twins, named): (Vec<&PathBuf>, Vec<&PathBuf>) = cases.iter().partition(is_twin);
    let examples = if cases.is_empty() { simulate::gradient_check::examples(root)? } else { Vec::new() };
    let mut hold = true;
    let mut see = |holds: bool, report: &dyn std::fmt::Display| {
        hold &= holds;
        if !quiet || !holds {
            output::line(report);
        }
    };
    for case in named.into_iter().chain(&examples) {
        let report = simulate::gradient_check::run(case, steps)?;
        see(report.holds(), &report);
    }
    for report in cli::twin::check_gradients(&twins, cases.is_empty(), steps)? {
        see(report.holds(), &report);
    }
    Ok(hold)
}

/// Prints the diagnostics; returns whether there was none.
fn print_diagnostics(diagnostics: &[Diagnostic]) -> bool {
    diagnostics.iter().for_each(|diagnostic| output::note(format_args!("error: {diagnostic}")));
    diagnostics.is_empty()
}

/// The same where one specimen was asked for, whose own card could be read: the cards of others are mentioned and stop nothing.
fn print_others(diagnostics: &[Diagnostic], specimen: Option<&str>) -> bool {
    if specimen.is_none() {
        return print_diagnostics(diagnostics);
    }
    diagnostics.iter().for_each(|diagnostic| output::note(format_args!("another specimen is left out: {diagnostic}")));
    true
}
