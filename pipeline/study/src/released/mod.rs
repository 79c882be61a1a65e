//! Released: a body of one's own that was held straight and let go. Where it settles says its Young's modulus, how its swing dies
//! its damping; how fast it swings, and how deep it falls first, was never used, and is foretold.
//!
//! `page` says what there is, `recorded` reads it, `simulated` does the same by finite elements, `shown` lays out a table and a
//! figure.
//!
//! Stands on: its members. Never knows: a specimen, a stage.

mod fetch;
mod page;
mod recorded;
mod shown;
mod simulated;

use std::path::{Path, PathBuf};

use si::{Pascal, Second, Series};

use crate::fault::{Fault, Outcome};
pub use fetch::fetch;
use page::Page;
use recorded::{Recorded, Swing};
use simulated::{Bench, Found};

/// Where the pages lie that come with the project.
const PAGES: &str = "pipeline/study/examples/real";

/// A page by its path, or by its name among those of the project at `root`.
pub fn page(root: &Path, asked: &Path) -> PathBuf {
    let named = root.join(PAGES).join(asked).with_extension("toml");
    if !asked.exists() && named.exists() { named } else { asked.to_owned() }
}

/// The simulated swing dies as fast as the measured one within this share.
const AS_FAST: f64 = 0.02;
/// Turns at that.
const TURNS: usize = 4;

/// What was found with one law.
pub struct ByLaw {
    /// Its name.
    pub law: String,
    /// By where the body settles.
    pub found: Found,
    /// β with which the swing dies as it was seen, s.
    pub beta: Second,
    /// The swing that was foretold.
    pub swing: Swing,
    /// Its fall, m.
    pub fall: Series,
}

/// Everything that a page led to.
pub struct Report {
    page: Page,
    recorded: Vec<Recorded>,
    swings: Vec<Swing>,
    laws: Vec<ByLaw>,
}

/// Identifies the body of the page in the file `path`; recordings are looked for below `root`. Writes a table and a figure into
/// `out`, or beside the page.
///
/// # Errors
/// A [`Fault`]: the page, a recording, the case or its mesh is refused, or a shape or motion cannot be found.
pub fn run(root: &Path, path: &Path, out: Option<&Path>) -> Outcome<(Report, PathBuf)> {
    let page = Page::read(path).map_err(Fault::from_tool)?;
    let recorded = recorded::read(&page, root)?;
    let swings = recorded.iter().map(|r| recorded::swing(&page, &r.fall)).collect::<Outcome<Vec<_>>>()?;
    let bench = Bench::new(&page, path.parent().unwrap_or(Path::new(".")))?;
    let decay = swings.iter().map(|s| s.decay).sum::<f64>() / swings.len() as f64;
    let laws = page.laws.iter().map(|law| by_law(&bench, &page, law, &recorded, decay)).collect::<Outcome<Vec<_>>>()?;
    let folder = out.map_or_else(|| path.with_extension("out"), Path::to_owned);
    let report = Report { page, recorded, swings, laws };
    shown::write(&report, &folder)?;
    Ok((report, folder))
}

fn by_law(bench: &Bench, page: &Page, law: &str, recorded: &[Recorded], decay: f64) -> Outcome<ByLaw> {
    let settled: Vec<Vec<f64>> = recorded.iter().map(|r| r.settled.clone()).collect();
    let found = bench.fit(law, &settled)?;
    let (beta, fall, swing) = damped(bench, page, law, found.youngs_modulus, decay)?;
    Ok(ByLaw { law: law.to_owned(), found, beta, swing, fall })
}

/// β with which the simulated swing decays at `decay` (1/s): δ = β ω² / 2, corrected by what the march shows.
fn damped(bench: &Bench, page: &Page, law: &str, e: Pascal, decay: f64) -> Outcome<(Second, Series, Swing)> {
    let first = bench.release(law, e, 0.0)?;
    let omega = std::f64::consts::TAU * recorded::swing(page, &first)?.frequency;
    let mut beta = 2.0 * decay / (omega * omega);
    for _ in 1..TURNS {
        let fall = bench.release(law, e, beta)?;
        let swing = recorded::swing(page, &fall)?;
        if (swing.decay / decay - 1.0).abs() < AS_FAST {
            return Ok((beta, fall, swing));
        }
        beta *= decay / swing.decay.max(0.1 * decay);
    }
    let fall = bench.release(law, e, beta)?;
    let swing = recorded::swing(page, &fall)?;
    Ok((beta, fall, swing))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn real() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/real")
    }

    #[test]
    fn a_modulus_and_a_damping_come_back_from_a_simulated_release() {
        let page = Page::read(&real().join("beam_ds10.toml")).unwrap();
        let bench = Bench::new(&page, &real()).unwrap();
        let (e, beta) = (3.1e5, 3e-3);
        let fall = bench.release("neo_hookean", e, beta).unwrap();
        let seen = recorded::swing(&page, &fall).unwrap();
        let found = bench.fit("neo_hookean", &[vec![-6.4434e-3 * 277.53e3 / e; 2]]).unwrap();
        // the fall of a bar that bends by a fifteenth of its length is as 1 / E to some tenths of a per cent
        assert!((found.youngs_modulus / e - 1.0).abs() < 5e-3, "{found:?}");
        let (again, _, swing) = damped(&bench, &page, "neo_hookean", e, seen.decay).unwrap();
        assert!((again / beta - 1.0).abs() < 2.0 * AS_FAST, "{again}");
        assert!((swing.frequency / seen.frequency - 1.0).abs() < 2e-3, "{swing:?} {seen:?}");
    }

    #[test]
    fn recordings_that_are_not_there_say_where_they_belong_and_how_to_fetch_them() {
        let nowhere = std::env::temp_dir().join("no-recordings-here");
        let fault =
            run(&nowhere, &real().join("beam_ds10.toml"), None).err().map(|f| f.to_string()).unwrap_or_default();
        assert!(fault.contains("study fetch beam_ds10") && fault.contains("gravity_a.csv"), "{fault}");
    }
}
