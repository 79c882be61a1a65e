//! The commands of `study`: each returns whether all of it succeeded.

use std::path::{Path, PathBuf};

use crate::meshing::options::MeshSurfaces;
use crate::options::{CalibrateCamera, Place, TrackFilm};
use crate::reducing::ReduceCase;
use crate::twin::ExportedTwin;
use diagnostics::{Diagnostic, Result, output};
use simulate::RunOptions;
use study::Runner;
use track::board::{Target, TargetKind};
use workflow::runner::{Goal, Options};
use workflow::snakemake::{self, Export, Workflow};

/// Creates a specimen, from a folder of recordings or empty.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn init_specimen(place: &Place, name: &str, from: Option<&Path>) -> Result<bool> {
    let (root, profile) = (&place.root, place.profile.into());
    output::line(match from {
        Some(folder) => crate::init::from_folder(root, profile, (name, folder))?,
        None => crate::init::run(root, profile, name)?,
    });
    Ok(true)
}

/// Checks specimens, or proposes the card of a folder of recordings.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn run_doctor(place: &Place, name: Option<&str>) -> Result<bool> {
    match name {
        Some(folder) if crate::proposal::is_folder(&place.root, place.profile.into(), folder) => {
            let (proposal, path) = crate::proposal::write(Path::new(folder))?;
            output::text(&proposal);
            output::line(format_args!("{}: fill in the lines marked FILL IN and check the others", path.display()));
            Ok(true)
        }
        _ => {
            let (runner, _) = open_study(place)?;
            let report = crate::doctor::run(&runner, name)?;
            output::text(&report);
            Ok(report.is_well())
        }
    }
}

/// Makes what is stale of a goal, and the page.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn run_stages(place: &Place, goal: &Goal, fresh: bool) -> Result<bool> {
    let (runner, diagnostics) = open_study(place)?;
    study::readable(&diagnostics, goal.group.as_deref())?;
    if !place.quiet {
        crate::pictures::left_out(&runner, goal).iter().for_each(output::note);
    }
    let summary = study::run(&runner, goal, fresh)?;
    study::page(&runner)?;
    Ok(print_others(&diagnostics, goal.group.as_deref()) & summary.is_complete())
}

/// Makes a figure or a table.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn make_exhibit(place: &Place, name: &str) -> Result<bool> {
    let (runner, diagnostics) = open_study(place)?;
    let goal = Goal { entries: vec![name.to_owned()], group: None };
    Ok(print_diagnostics(&diagnostics) & study::run(&runner, &goal, false)?.is_complete())
}

/// Makes records whose inputs are up to date.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn make_records(place: &Place, records: &[String]) -> Result<bool> {
    let (runner, diagnostics) = open_study(place)?;
    records.iter().try_for_each(|record| study::readable(&diagnostics, record.split('/').nth(1)))?;
    Ok(runner.make(records)?.is_complete())
}

/// Publishes the figures and tables of a goal.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn publish_exhibits(place: &Place, goal: &Goal) -> Result<bool> {
    let (runner, diagnostics) = open_study(place)?;
    output::line(study::publish(&runner, goal)?.display());
    Ok(print_diagnostics(&diagnostics))
}

/// Writes the page of the project.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn write_page(place: &Place) -> Result<bool> {
    let (runner, diagnostics) = open_study(place)?;
    output::line(study::page(&runner)?.display());
    let outdated = study::outdated(&runner)?;
    publish::outdated::in_words(&outdated).iter().for_each(output::line);
    Ok(print_diagnostics(&diagnostics) & outdated.is_empty())
}

/// What a plan shows.
pub enum PlanForm<'a> {
    /// Seconds by stage.
    Times,
    /// Durations with so many workers.
    Schedule(&'a [usize]),
    /// The records that would be made.
    Records,
    /// The same for a program.
    Json,
    /// The recordings that they read.
    Recordings,
    /// The graph as a tree.
    Tree,
    /// The graph as a drawing in a file.
    Drawing(&'a Path),
}

impl<'a> PlanForm<'a> {
    /// By the options of the command line, of which one is given at most.
    pub fn chosen(
        [times, json, recordings]: [bool; 3],
        schedule: &'a [usize],
        graph: Option<&'a Option<PathBuf>>,
    ) -> Self {
        match graph {
            _ if !schedule.is_empty() => Self::Schedule(schedule),
            _ if times => Self::Times,
            _ if json => Self::Json,
            _ if recordings => Self::Recordings,
            None => Self::Records,
            Some(None) => Self::Tree,
            Some(Some(file)) => Self::Drawing(file),
        }
    }
}

/// Prints or draws what would be made.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn show_plan(place: &Place, goal: &Goal, form: &PlanForm) -> Result<bool> {
    let (runner, diagnostics) = open_study(place)?;
    study::readable(&diagnostics, goal.group.as_deref())?;
    match form {
        PlanForm::Times => output::line(runner.times(goal)?),
        PlanForm::Schedule(workers) => output::line(runner.schedule(goal, workers)?),
        PlanForm::Records => output::line(runner.plan(goal)?),
        PlanForm::Json => output::line(runner.plan_json(goal)?),
        PlanForm::Recordings => crate::recordings::needed_recordings(&runner, goal)?.iter().for_each(output::line),
        PlanForm::Tree => output::line(runner.tree(goal)?),
        PlanForm::Drawing(file) => std::fs::write(file, study::plan_svg(&runner, goal)?).map_err(|e| {
            Diagnostic::new(format!("{} cannot be written", file.display()), e, "choose another place for the drawing")
        })?,
    }
    Ok(print_others(&diagnostics, goal.group.as_deref()))
}

/// Prints what makes an entry stale.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn explain_entry(place: &Place, name: &str) -> Result<bool> {
    let (runner, diagnostics) = open_study(place)?;
    output::line(runner.why(name)?);
    Ok(print_diagnostics(&diagnostics))
}

/// Simulates a case, with a certificate of its mesh or an estimate.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn simulate_case(case: &Path, options: RunOptions, certify: bool) -> Result<bool> {
    match certify {
        true => simulate::certify(case, options)?.1.iter().for_each(output::line),
        false => simulate::run_with_estimate(case, options).map(|_| ())?,
    }
    Ok(true)
}

/// Reduces a case to a real-time model.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn reduce_case(asked: &ReduceCase, quiet: bool) -> Result<bool> {
    output::line(simulate::reduce(&asked.options(quiet))?);
    Ok(true)
}

/// Meshes surfaces.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn mesh_surfaces(asked: &MeshSurfaces, quiet: bool) -> Result<bool> {
    output::text(crate::meshing::run(asked, quiet)?.report);
    Ok(true)
}

/// Fits the laws of a page, whatever its kind of test.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn fit_page(root: &Path, page: &Path, out: Option<&Path>) -> Result<bool> {
    let page = sysid::free_vibration::page(root, page);
    if sysid::joint_fit::is_page(&page) {
        let (report, folder) = sysid::joint_fit::run(root, &page, out)?;
        output::line(format_args!("{report}results: {}", folder.display()));
    } else if sysid::inflation_test::is_page(&page) {
        let (report, folder) = sysid::inflation_test::run(root, &page, out)?;
        output::line(format_args!("{report}results: {}", folder.display()));
    } else {
        let (report, folder) = sysid::free_vibration::run(root, &page, out, None)?;
        output::line(format_args!("{report}results: {}", folder.display()));
    }
    Ok(true)
}

/// Downloads the recordings of a page.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn fetch_recordings(root: &Path, page: &Path) -> Result<bool> {
    let page = sysid::free_vibration::page(root, page);
    for recording in sysid::free_vibration::fetch(root, &page)? {
        output::line(recording.display());
    }
    Ok(true)
}

/// Evaluates the force logs of a page.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn evaluate_forces(page: &Path, out: Option<&Path>) -> Result<bool> {
    let (report, folder) = instruments::force::run(page, out)?;
    output::line(format_args!("{report}results: {}", folder.display()));
    Ok(true)
}

/// Calibrates a camera from pictures of a target.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn calibrate_camera(asked: &CalibrateCamera) -> Result<bool> {
    let request = calibration_request(asked);
    let camera = instruments::calibrate::camera(&request, None)?;
    output::line(camera.summary(&request.out.unwrap_or_default()));
    Ok(true)
}

/// Tracks the markers of a film.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn track_film(asked: &TrackFilm, quiet: bool) -> Result<bool> {
    let tracked = crate::track::run(asked)?;
    if !quiet {
        output::line(&tracked.summary);
    }
    Ok(tracked.complete)
}

/// Prepares the paper and typesets it.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn typeset_paper(place: &Place) -> Result<bool> {
    // the paper profile is set from what is tracked where nothing was recorded
    let (runner, diagnostics) = open_without_specimens(place)?;
    let pdf_path = study::paper(&runner)?;
    if !place.quiet {
        output::line(runner.folders.display(&pdf_path));
    }
    Ok(print_diagnostics(&diagnostics))
}

/// Writes the workflow, or sets the marks of one that was written into `folder`.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn export_snakemake(place: &Place, folder: Option<&PathBuf>, goal: &Goal, marks: bool) -> Result<bool> {
    let (runner, diagnostics) = open_study(place)?;
    match (marks, folder) {
        (true, Some(folder)) => snakemake::update(&runner, folder, goal)?,
        _ => {
            let (folder, program, goal) = (folder.cloned(), std::env::current_exe()?, goal.clone());
            let Workflow { folder, kept } = snakemake::export(&runner, &Export { folder, program, goal })?;
            print_export(&folder, &kept);
        }
    }
    Ok(print_diagnostics(&diagnostics))
}

/// Exports the real-time model of a specimen.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn export_twin(place: &Place, name: &str, folder: Option<&Path>) -> Result<bool> {
    let (runner, diagnostics) = open_study(place)?;
    study::readable(&diagnostics, Some(name))?;
    let ExportedTwin { folder, kept } = crate::twin::export(&runner, name, folder)?;
    print_export(&folder, &kept);
    Ok(print_diagnostics(&diagnostics))
}

/// Prints the stages, figures and tables.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn list_entries() -> Result<bool> {
    output::text(study::description());
    Ok(true)
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

/// Compares records with expected and published values.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn check_records(place: &Place, junit: Option<&Path>) -> Result<bool> {
    let (runner, diagnostics) = open_without_specimens(place)?;
    let checked = study::check(&runner)?;
    if let Some(file) = junit {
        let written = std::fs::write(file, &checked.junit);
        written.map_err(|e| Diagnostic::io(file, e, "choose another place for the report"))?;
    }
    output::line(checked.text);
    Ok(checked.holds & print_diagnostics(&diagnostics))
}

/// Checks the gradients of every case and reduced tail; returns whether all of them pass.
///
/// # Errors
/// A [`Diagnostic`] of what stopped it.
pub fn check_gradients(root: &Path, cases: &[PathBuf], steps: usize, quiet: bool) -> Result<bool> {
    let is_twin = |path: &&PathBuf| path.extension().is_some_and(|ending| ending == crate::twin::ENDING);
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
    for report in crate::twin::check_gradients(&twins, cases.is_empty(), steps)? {
        see(report.holds(), &report);
    }
    Ok(hold)
}

/// Prints the diagnostics; returns whether there was none.
fn print_diagnostics(diagnostics: &[Diagnostic]) -> bool {
    diagnostics.iter().for_each(|diagnostic| output::note(format_args!("error: {diagnostic}")));
    diagnostics.is_empty()
}

/// The same where one specimen was asked for, whose own card could be read: the cards of others are mentioned and stop
/// nothing.
fn print_others(diagnostics: &[Diagnostic], specimen: Option<&str>) -> bool {
    if specimen.is_none() {
        return print_diagnostics(diagnostics);
    }
    diagnostics.iter().for_each(|diagnostic| output::note(format_args!("another specimen is left out: {diagnostic}")));
    true
}
