//! Free vibration tests: a body is held straight and released, under one or several loads. A ladder of laws is fitted to some of the
//! recordings and predicts the others.
//!
//! `page` describes the tests, `recorded` reads the recordings and `features` measures them; `condition` is the body under one load,
//! `laws` the ladder, `fitting` one fit, `ladder` all of them; `shown` writes table, metrics and figure, and `warnings` finds results that should not
//! be used as they are.

pub(crate) mod condition;
pub(crate) mod features;
mod fetch;
mod fitted_law;
pub(crate) mod fitting;
mod ladder;
mod laws;
pub(crate) mod page;
pub(crate) mod recorded;
mod shown;
#[cfg(test)]
pub(crate) mod testing;
mod warnings;

use std::path::{Path, PathBuf};

use diagnostics::Result;
use fem::Interrupt;
use rayon::prelude::*;

use condition::Condition;
use features::Features;
pub use fetch::fetch;
pub use fitted_law::FittedLaw;
use ladder::{Bench, LawResult};
pub use page::Page;
use recorded::Recorded;

/// Folder of the pages that come with the project.
const PAGES: &str = "pipeline/sysid/examples/real";

/// A page by its path, or by its name among those of the project at `root`.
pub fn page(root: &Path, asked: &Path) -> PathBuf {
    let named = root.join(PAGES).join(asked).with_extension("toml");
    if !asked.exists() && named.exists() { named } else { asked.to_owned() }
}

/// The results of a page.
pub struct Report {
    page: Page,
    recorded: Vec<Recorded>,
    measured: Vec<Features>,
    results: Vec<LawResult>,
}

/// Identifies the body of the page in the file `path`; recordings are looked for below `root`. Writes a table, metrics and a figure
/// into `out`, or beside the page. `interrupt` is asked during every solve and simulated motion, from any thread, whether to end.
///
/// # Errors
/// A [`diagnostics::Diagnostic`]: the page, a recording, a case or its mesh is refused, a shape or motion cannot be found, or it was interrupted.
pub fn run(root: &Path, path: &Path, out: Option<&Path>, interrupt: Option<Interrupt>) -> Result<(Report, PathBuf)> {
    let page = Page::read(path)?;
    evaluate_page(page, root, path, (out, interrupt)).map_err(|refused| refused.in_file_unless_named(path))
}

fn evaluate_page(
    page: Page,
    root: &Path,
    path: &Path,
    (out, interrupt): (Option<&Path>, Option<Interrupt>),
) -> Result<(Report, PathBuf)> {
    let recorded = recorded::read(&page, root)?;
    let measured = recorded.iter().map(|r| Features::of(&page, &r.fall)).collect::<Result<Vec<_>>>()?;
    let (cases, case_numbers) = page_cases(&page);
    let folder = path.parent().unwrap_or(Path::new("."));
    let condition = |case: &String| Condition::new(&page, &folder.join(case), interrupt.clone());
    let conditions: Vec<Condition> = cases.par_iter().map(condition).collect::<Result<_>>()?;
    let results = Bench { page: &page, recorded: &recorded, conditions: &conditions, of: case_numbers }.fit_all()?;
    let folder = out.map_or_else(|| path.with_extension("out"), Path::to_owned);
    let report = Report { page, recorded, measured, results };
    shown::write(&report, &folder)?;
    Ok((report, folder))
}

/// The different cases of a page, and which of them each recording has.
fn page_cases(page: &Page) -> (Vec<String>, Vec<usize>) {
    let (mut cases, mut case_numbers): (Vec<String>, Vec<usize>) = (Vec::new(), Vec::new());
    for recording in &page.recording {
        let case = recording.case.as_ref().unwrap_or(&page.case);
        let case_number = cases.iter().position(|known| known == case).unwrap_or_else(|| {
            cases.push(case.clone());
            cases.len() - 1
        });
        case_numbers.push(case_number);
    }
    (cases, case_numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fitting::Fit;
    use testing::examples as real;

    #[test]
    fn recordings_that_are_not_there_say_where_they_belong_and_how_to_fetch_them() {
        let nowhere = std::env::temp_dir().join("no-recordings-here");
        let diagnostic =
            run(&nowhere, &real().join("beam_ds10.toml"), None, None).err().map(|f| f.to_string()).unwrap_or_default();
        assert!(diagnostic.contains("study fetch beam_ds10") && diagnostic.contains("gravity_a.csv"), "{diagnostic}");
    }

    #[test]
    fn an_interrupt_ends_the_shapes_and_the_motions_of_a_condition() {
        use std::sync::Arc;
        use std::sync::atomic::{AtomicBool, Ordering};
        let page = Page::read(&real().join("beam_ds10.toml")).unwrap();
        let new = |interrupt: Interrupt| Condition::new(&page, &real().join(&page.case), Some(interrupt));
        let refused = new(Arc::new(|| true)).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(refused.contains("interrupt"), "{refused}");
        let asked = Arc::new(AtomicBool::new(false));
        let flag = asked.clone();
        let condition = new(Arc::new(move || flag.load(Ordering::Relaxed))).unwrap();
        let law = laws::LADDER[0].properties(&[2.7e5, 1e-3], 1.0).unwrap();
        assert!(condition.fall(&law, 0.05, &[0.0, 0.01, 0.02]).is_ok());
        asked.store(true, Ordering::Relaxed);
        let refused = condition.fall(&law, 0.05, &[0.0, 0.01]).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(refused.contains("interrupted"), "{refused}");
    }

    /// A law, its release included, comes back from displacements that it made itself.
    #[test]
    fn a_springpot_and_the_release_come_back_from_a_simulated_vibration() {
        let page = Page::read(&real().join("beam_ds10.toml")).unwrap();
        let condition = Condition::new(&page, &real().join(&page.case), None).unwrap();
        let law = laws::LADDER[3];
        let truth = [2.7e5, 0.05, 0.3];
        let none = Recorded {
            name: "made".into(),
            fall: si::Series::new(0.0, 100.0, vec![0.0; 400]).unwrap(),
            settled: vec![-6e-3],
        };
        let trial = fitting::Trial { recorded: &none, condition: &condition };
        let fall = fitting::predicted(&page, (law, &truth), 0.06, trial).unwrap();
        let made = Recorded { name: "made".into(), fall, settled: vec![-6e-3] };
        let trials = vec![fitting::Trial { recorded: &made, condition: &condition }];
        let fitted = Fit { page: &page, law, trials }.run().unwrap();
        for (found, exact) in fitted.values.iter().zip(truth) {
            assert!((found / exact - 1.0).abs() < 0.02, "{:?}", fitted.values);
        }
        assert!((fitted.at[3] - 0.06).abs() < 2e-3 && fitted.at[4].abs() < 1e-3, "{:?}", fitted.at);
        assert!(fitted.discrepancy < 1e-3, "{}", fitted.discrepancy);
    }

    #[test]
    fn recordings_share_the_case_of_the_page_or_have_their_own() {
        let (cases, of) = page_cases(&testing::page());
        assert_eq!((cases, of), (vec!["weight.toml".to_owned(), "light.toml".to_owned()], vec![0, 0, 1]));
    }

    /// The whole test of a page: recordings are read, every law is fitted, and all files are written.
    #[test]
    fn the_law_of_a_recorded_bar_is_found_among_all_and_predicts_the_recordings_that_were_left_out() {
        let folder = testing::folder("whole");
        let (report, out) = run(&folder, &folder.join("page.toml"), Some(&folder.join("out")), None).unwrap();
        let laws = report.laws();
        let springpot = laws.iter().find(|law| law.name == testing::TRUTH.0.name).unwrap();
        assert!(springpot.supported && springpot.criterion == 0.0, "{report}");
        for (p, truth) in testing::TRUTH.1.iter().enumerate() {
            let sigma = springpot.covariance[(p, p)].sqrt();
            assert!((springpot.mean[p] - truth).abs() < 4.0 * sigma && sigma < 0.05 * truth, "{springpot:?}");
        }
        assert!(report.recorded.iter().all(|recorded| recorded.fall.values().len() == 250));
        for result in &report.results {
            assert_eq!(result.left_out.iter().map(|row| row.used.clone()).collect::<Vec<_>>(), [[2], [0]]);
            let all = std::iter::once(&result.joint).chain(&result.left_out);
            assert!(all.flat_map(|row| &row.predictions).all(|p| p.fall.values().len() == 250));
        }
        let truth = &report.results[3];
        // two recordings of 2.5 s hold as many independent residuals as correlation times
        let fitted = &truth.joint.fitted;
        assert!((fitted.independent * fitted.correlation_time / 5.0 - 1.0).abs() < 1e-9, "{}", fitted.independent);
        assert!(truth.left_out_difference().unwrap() < 5e-3, "{report}");
        // what rounding to 0.02 mm leaves of 6.4 and 3.9 mm
        assert!((5e-4..2e-3).contains(&fitted.discrepancy), "{}", fitted.discrepancy);
        assert!(report.results[0].joint.fitted.discrepancy > 2.0 * truth.joint.fitted.discrepancy);
        let names = ["real_bar.csv", "real_bar.svg", "real_bar_materials.toml", "metrics.json"];
        assert!(names.iter().all(|name| out.join(name).is_file()));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
