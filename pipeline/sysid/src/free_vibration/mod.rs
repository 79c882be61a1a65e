//! Free vibration test: a body is held straight and released. Its static deflection gives Young's modulus, the decay of the vibration
//! its damping; frequency and first amplitude are not used and are predicted.
//!
//! `page` describes the test, `recorded` reads the recordings, `simulated` is the finite-element model, `shown` writes a table and a
//! figure, and `warnings` finds results that should not be used as they are.

mod fetch;
mod page;
mod recorded;
mod shown;
mod simulated;
mod warnings;

use std::path::{Path, PathBuf};

use si::{Pascal, Second, Series};

use diagnostics::Result;
pub use fetch::fetch;
pub use page::Page;
use recorded::{FreeVibration, Recorded};
use simulated::{Bench, Found};

/// Folder of the pages that come with the project.
const PAGES: &str = "pipeline/sysid/examples/real";

/// A page by its path, or by its name among those of the project at `root`.
pub fn page(root: &Path, asked: &Path) -> PathBuf {
    let named = root.join(PAGES).join(asked).with_extension("toml");
    if !asked.exists() && named.exists() { named } else { asked.to_owned() }
}

/// Relative tolerance of the simulated against the measured decay rate.
const AS_FAST: f64 = 0.02;
/// Maximum number of corrections.
const TURNS: usize = 4;

/// Results with one material law.
pub(crate) struct ByLaw {
    /// Its name.
    pub law: String,
    /// From the static deflection.
    pub found: Found,
    /// β that reproduces the measured decay, s.
    pub beta: Second,
    /// The predicted vibration.
    pub vibration: FreeVibration,
    /// Its displacement along the page's axis, m.
    pub fall: Series,
}

/// The results of a page.
pub struct Report {
    page: Page,
    recorded: Vec<Recorded>,
    vibrations: Vec<FreeVibration>,
    laws: Vec<ByLaw>,
}

/// Identifies the body of the page in the file `path`; recordings are looked for below `root`. Writes a table and a figure into
/// `out`, or beside the page.
///
/// # Errors
/// A [`diagnostics::Diagnostic`]: the page, a recording, the case or its mesh is refused, or a shape or motion cannot be found.
pub fn run(root: &Path, path: &Path, out: Option<&Path>) -> Result<(Report, PathBuf)> {
    let page = Page::read(path)?;
    let recorded = recorded::read(&page, root)?;
    let vibrations = recorded.iter().map(|r| recorded::vibration(&page, &r.fall)).collect::<Result<Vec<_>>>()?;
    let bench = Bench::new(&page, path.parent().unwrap_or(Path::new(".")))?;
    let decay = vibrations.iter().map(|s| s.decay).sum::<f64>() / vibrations.len() as f64;
    let laws = page.laws.iter().map(|law| by_law(&bench, law, &recorded, decay)).collect::<Result<Vec<_>>>()?;
    let folder = out.map_or_else(|| path.with_extension("out"), Path::to_owned);
    let report = Report { page, recorded, vibrations, laws };
    shown::write(&report, &folder)?;
    Ok((report, folder))
}

fn by_law(bench: &Bench, law: &str, recorded: &[Recorded], decay: f64) -> Result<ByLaw> {
    let settled: Vec<Vec<f64>> = recorded.iter().map(|r| r.settled.clone()).collect();
    let found = bench.fit(law, &settled)?;
    let (beta, fall, vibration) = damped(bench, law, found.youngs_modulus, decay)?;
    Ok(ByLaw { law: law.to_owned(), found, beta, vibration, fall })
}

/// β with which the simulated vibration decays at `decay` (1/s): δ = β ω² / 2, corrected by the simulated decay.
fn damped(bench: &Bench, law: &str, e: Pascal, decay: f64) -> Result<(Second, Series, FreeVibration)> {
    let page = bench.page;
    let first = bench.release(law, e, 0.0)?;
    let omega = std::f64::consts::TAU * recorded::vibration(page, &first)?.frequency;
    let mut beta = 2.0 * decay / (omega * omega);
    for _ in 1..TURNS {
        let fall = bench.release(law, e, beta)?;
        let vibration = recorded::vibration(page, &fall)?;
        if (vibration.decay / decay - 1.0).abs() < AS_FAST {
            return Ok((beta, fall, vibration));
        }
        beta *= decay / vibration.decay.max(0.1 * decay);
    }
    let fall = bench.release(law, e, beta)?;
    let vibration = recorded::vibration(page, &fall)?;
    Ok((beta, fall, vibration))
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
        let seen = recorded::vibration(&page, &fall).unwrap();
        let found = bench.fit("neo_hookean", &[vec![-6.4434e-3 * 277.53e3 / e; 2]]).unwrap();
        // the deflection of a bar that bends by a fifteenth of its length is proportional to 1 / E to some tenths of a per cent
        assert!((found.youngs_modulus / e - 1.0).abs() < 5e-3, "{found:?}");
        let (again, _, vibration) = damped(&bench, "neo_hookean", e, seen.decay).unwrap();
        assert!((again / beta - 1.0).abs() < 2.0 * AS_FAST, "{again}");
        assert!((vibration.frequency / seen.frequency - 1.0).abs() < 2e-3, "{vibration:?} {seen:?}");
    }

    #[test]
    fn recordings_that_are_not_there_say_where_they_belong_and_how_to_fetch_them() {
        let nowhere = std::env::temp_dir().join("no-recordings-here");
        let diagnostic =
            run(&nowhere, &real().join("beam_ds10.toml"), None).err().map(|f| f.to_string()).unwrap_or_default();
        assert!(diagnostic.contains("study fetch beam_ds10") && diagnostic.contains("gravity_a.csv"), "{diagnostic}");
    }
}
