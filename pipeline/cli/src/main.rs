//! `study`: the pipeline's command line. Exit code 0 for success, 1 for bad input or drift, 2 for usage.

use std::process::ExitCode;

use clap::Parser;
use cli::commands::{self, PlanForm};
use cli::options::{Checked, Cli, Command, Exported, Place};
use cli::shell;

use diagnostics::{Result, next_move, output, processor};
use simulate::RunOptions;
use workflow::runner::Goal;
use workflow::settings;

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
    let (place, root, quiet) = (&cli.place, cli.place.root.as_path(), cli.place.quiet);
    match &cli.command {
        Command::Init { name, from } => commands::init_specimen(place, name, from.as_deref()),
        Command::Doctor { name } => commands::run_doctor(place, name.as_deref()),
        Command::Run { names, specimen, fresh } => commands::run_stages(place, &goal_of(names, specimen), *fresh),
        Command::Fig { name } | Command::Table { name } => commands::make_exhibit(place, name),
        Command::Make { records } => commands::make_records(place, records),
        Command::Publish { names } => commands::publish_exhibits(place, &goal_of(names, &None)),
        Command::Page => commands::write_page(place),
        Command::Plan { names, specimen, graph, schedule, times, json, recordings } => {
            let form = PlanForm::chosen([*times, *json, *recordings], schedule, graph.as_ref());
            commands::show_plan(place, &goal_of(names, specimen), &form)
        }
        Command::Why { name } => commands::explain_entry(place, name),
        Command::Simulate { case, out, certify, budget } => {
            let (out, budget) = (out.clone(), (*budget).into());
            let options = RunOptions { out, quiet, budget, ..RunOptions::default() };
            commands::simulate_case(case, options, *certify)
        }
        Command::Reduce(asked) => commands::reduce_case(asked, quiet),
        Command::Mesh(asked) => commands::mesh_surfaces(asked, quiet),
        Command::Fit { page, out } => commands::fit_page(root, page, out.as_deref()),
        Command::Fetch { page } => commands::fetch_recordings(root, page),
        Command::Force { page, out } => commands::evaluate_forces(page, out.as_deref()),
        Command::Calibrate(asked) => commands::calibrate_camera(asked),
        Command::Track(asked) => commands::track_film(asked, quiet),
        Command::Check { what: None, junit } => commands::check_records(place, junit.as_deref()),
        Command::Check { what: Some(Checked::Gradients { cases, steps }), .. } => {
            commands::check_gradients(root, cases, *steps, quiet)
        }
        Command::Paper => commands::typeset_paper(place),
        Command::Export { what } => run_export(place, what),
        Command::List => commands::list_entries(),
    }
}

fn run_export(place: &Place, what: &Exported) -> Result<bool> {
    match what {
        Exported::Snakemake { folder, only, marks } => {
            commands::export_snakemake(place, folder.as_ref(), &goal_of(only, &None), *marks)
        }
        Exported::Twin { name, folder } => commands::export_twin(place, name, folder.as_deref()),
        Exported::Completions { shell } => Ok(shell::print_completions(*shell)),
        Exported::Manual { folder } => shell::write_manual(folder),
    }
}

/// The named entries, of one specimen or of all.
fn goal_of(entries: &[String], group: &Option<String>) -> Goal {
    Goal { entries: entries.to_vec(), group: group.clone() }
}
