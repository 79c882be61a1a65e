//! Simulate: one case from its page to its tables and frames.
//!
//! `solid` finds the mesh, `body` hands it to `fem` with all that does not change, `push` says which nodes a load means, `statics`
//! and `dynamics` solve, `probes` and `frames` write. Beside the case lies then `<case>.out/` with `<case>.csv`, `frame_0000.vtu`, …
//! and `<case>.pvd`, which ParaView opens.
//!
//! Stands on: `case`, shape, fem. Never knows: a project, a specimen, a recording.

mod body;
mod dynamics;
mod frames;
mod materials;
mod probes;
mod push;
mod solid;
mod statics;
mod stress;

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::case::{Case, read};
use crate::fault::{Fault, Outcome};
pub(crate) use body::Body;
use frames::Frames;
use probes::Table;
pub(crate) use solid::{Loaded, load};

/// What a simulation says at its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Degrees of freedom.
    pub freedoms: usize,
    /// Levels or steps.
    pub solved: usize,
    /// Newton directions over all levels; none for motions, which do not count them.
    pub iterations: Option<usize>,
    /// Where the results lie.
    pub folder: PathBuf,
}

/// Simulates the case in the file `path` and writes into `out`, or beside the case.
///
/// # Errors
/// A [`Fault`]: the case or its mesh is refused, or a level or step cannot be found; what was found before is then written.
pub fn run(path: &Path, out: Option<&Path>, quiet: bool) -> Outcome<Summary> {
    let began = Instant::now();
    let case = read(path).map_err(Fault::from_tool)?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let parent = path.parent().unwrap_or(Path::new("."));
    let folder = out.map_or_else(|| parent.join(format!("{stem}.out")), Path::to_owned);
    let telling = Telling { stem: stem.clone(), quiet };
    let loaded = solid::load(&case, parent)?;
    loaded.notes.iter().for_each(|note| telling.line(note));
    let body = Body::new(&case, &loaded)?;
    body.notes.iter().for_each(|note| telling.line(note));
    std::fs::create_dir_all(&folder).map_err(|e| cannot_write(&folder, &e))?;
    let mut written =
        Written { table: Table::create(&case, &body, &folder, &stem)?, frames: Frames::begin(&folder, &stem)? };
    let solved = solve(&case, &body, &mut written, &telling)?;
    let summary = Summary { freedoms: body.system.freedoms(), folder, ..solved };
    telling.last(&summary, began.elapsed().as_secs_f64());
    Ok(summary)
}

fn solve(case: &Case, body: &Body, written: &mut Written, telling: &Telling) -> Outcome<Summary> {
    match (&case.statics, &case.dynamic) {
        (Some(set), _) => statics::solve(case, set, body, written, telling),
        (None, Some(set)) => dynamics::solve(case, set, body, written, telling),
        (None, None) => Err(Fault::new("nothing is asked for", "a case has [static] or [dynamic]", "add one of them")),
    }
}

/// What is written on the way.
struct Written {
    table: Table,
    frames: Frames,
}

/// What a person reads on the way.
struct Telling {
    stem: String,
    quiet: bool,
}

impl Telling {
    fn line(&self, text: &str) {
        if !self.quiet {
            eprintln!("{:<10} {text}", self.stem);
        }
    }

    fn last(&self, summary: &Summary, seconds: f64) {
        let Summary { freedoms, solved, folder, .. } = summary;
        let iterations = summary.iterations.map_or(String::new(), |count| format!("{count} iterations, "));
        let folder = folder.display();
        eprintln!("{:<10} {solved} solved, {freedoms} dofs, {iterations}{seconds:.1} s → {folder}", self.stem);
    }
}

fn cannot_write(path: &Path, error: &std::io::Error) -> Fault {
    let what = format!("{} cannot be written", path.display());
    Fault::new(what, error.to_string().to_lowercase(), "name another folder with --out")
}
