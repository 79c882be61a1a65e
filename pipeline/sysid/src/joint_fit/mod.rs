//! A joint fit: free vibration, inflation, tension, compression and relaxation of one material share its constants; each has its own release, geometry, pressure
//! and batch. Laws are compared by what they predict of whole conditions that were left out: a weight, a pressure, a test.
//!
//! `page` names the tests, `laws` the laws; `bars`, `arms` and `specimen` predict what was measured in each test, with derivatives by all
//! parameters; `fit` is one fit, `ladder` all of them, `scoreboard` what
//! each law predicts, `shown` writes the tables, `figure` draws the scoreboard.

mod arms;
mod bars;
mod figure;
mod fit;
mod ladder;
mod laws;
mod page;
mod parameters;
mod scoreboard;
mod shown;
mod specimen;
mod test;
mod uniaxial;

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result, output};

use arms::Arms;
use bars::Bars;
use ladder::{Bench, LawResult};
use page::Page;
use specimen::StressedSpecimen;
use test::Test;
use uniaxial::Kind;

/// The results of a page.
pub struct Report {
    page: Page,
    tests: Vec<Box<dyn Test>>,
    results: Vec<LawResult>,
    /// Laws that could not be fitted, with the cause.
    refused: Vec<(&'static str, String)>,
}

/// Whether the file `path` is the page of a joint fit, or of a test under one stress alone.
pub fn is_page(path: &Path) -> bool {
    page::kind(path).is_ok_and(|kind| kind == "joint" || Kind::named(&kind).is_some())
}

/// Fits the laws of the page in the file `path` to its tests; recordings are looked for below `root`. Writes tables, metrics and materials
/// into `out`, or beside the page.
///
/// # Errors
/// A [`Diagnostic`]: a page, a recording, a case or its mesh is refused, or no law can be fitted.
pub fn run(root: &Path, path: &Path, out: Option<&Path>) -> Result<(Report, PathBuf)> {
    let is_joint = Kind::named(&page::kind(path)?).is_none();
    let page = if is_joint { Page::read(path)? } else { specimen_alone(path)? };
    let report = evaluate(page, root, path).map_err(|refused| refused.in_file_unless_named(path))?;
    let folder = out.map_or_else(|| path.with_extension("out"), Path::to_owned);
    shown::write(&report, &folder)?;
    Ok((report, folder))
}

/// A test under one stress without others.
fn specimen_alone(path: &Path) -> Result<Page> {
    let specimen = uniaxial::Page::read(path)?;
    Ok(Page {
        test: "joint".to_owned(),
        name: specimen.name,
        tests: path.file_name().map(PathBuf::from).into_iter().collect(),
        laws: laws::LAWS.iter().map(|law| law.name.to_owned()).collect(),
        edge: 0.01,
        held_out: Vec::new(),
        pressures: Vec::new(),
    })
}

fn evaluate(page: Page, root: &Path, path: &Path) -> Result<Report> {
    let laws = page.laws();
    let mut materials: Vec<&'static str> = laws.iter().map(|law| law.material).collect();
    materials.dedup();
    let folder = path.parent().unwrap_or(Path::new("."));
    let open = |file: &PathBuf| -> Result<Box<dyn Test>> {
        let file = folder.join(file);
        Ok(match page::kind(&file)?.as_str() {
            "inflation" => Box::new(Arms::new(&file, root, &materials, &page)?),
            kind if Kind::named(kind).is_some() => Box::new(StressedSpecimen::new(&file, root)?),
            _ => Box::new(Bars::new(&file, root, &materials)?),
        })
    };
    let tests = page.tests.iter().map(open).collect::<Result<Vec<_>>>()?;
    let progress = |text: &str| output::note(format_args!("{text}"));
    let law_results = Bench { tests: &tests, held_out: &page.held_out, progress: &progress }.law_results(&laws);
    let (mut results, mut refused) = (Vec::new(), Vec::new());
    for (law, result) in law_results {
        match result {
            Ok(result) => results.push(result),
            Err(cause) => refused.push((law.name, cause.to_string())),
        }
    }
    if results.is_empty() {
        let cause = refused.first().map_or_else(String::new, |(law, cause)| format!("{law}: {cause}"));
        return Err(Diagnostic::new("no law can be fitted", cause, "correct the pages of its tests"));
    }
    Ok(Report { page, tests, results, refused })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = r#"
test = "tension"
name = "strip"
folders = ["."]
files = ["strip.csv"]
time = "t"
strain = "e"
stress = "s"
stress_unit = 1e3
measured_by = "crosshead"
fitted = [0.05, 1.0]
predicted = [1.4]
batch_sigma = 1e-3
"#;

    /// A strip that a law and a machine of known compliance made: its stress beyond what was fitted is predicted.
    #[test]
    fn a_strip_comes_back_with_the_compliance_of_its_machine() {
        let folder = std::env::temp_dir().join(format!("strip-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let law = laws::LAWS.iter().find(|law| law.name == "yeoh_c20").unwrap();
        let (modulus, compliance) = (2.4e5_f64, 2.5e-6);
        let constants = law.constants(&[modulus.ln(), 0.05_f64.ln(), 0.25, 1.0, 0.4]).unwrap();
        let material = specimen::material(law.material).unwrap();
        let row = |k: i32| {
            let (time, stretch) = (0.05 * f64::from(k), 1.0 + 0.01 * f64::from(k));
            let stress = uniaxial::uniaxial_stress(material, &constants, (stretch, [time, 0.0]));
            format!("{time},{},{}\n", stretch - 1.0 + compliance * stress, 1e-3 * stress)
        };
        let csv = "Machine,7\nt,e,s\n".to_owned() + &(1..200).map(row).collect::<String>();
        std::fs::write(folder.join("strip.csv"), csv).unwrap();
        std::fs::write(folder.join("page.toml"), PAGE).unwrap();
        let (report, out) = run(&folder, &folder.join("page.toml"), Some(&folder.join("out"))).unwrap();
        let result = report.results.iter().find(|result| result.law.name == law.name).unwrap();
        let point = &result.joint.point;
        assert!((point[6] / 2.5 - 1.0).abs() < 0.05, "{point:?}");
        assert!((point[0].exp() / modulus - 1.0).abs() < 0.05, "{point:?}");
        let extrapolated_stress = report.tests[0].conditions()[1].quantities[0].measured.unwrap();
        let (predicted, width) = &result.all[0][1].as_ref().unwrap()[0];
        assert!(
            (predicted.value / extrapolated_stress - 1.0).abs() < 0.02
                && (predicted.value - extrapolated_stress).abs() < *width
        );
        let text = report.to_string();
        assert!(text.contains("extrapolated") && text.contains("held out"), "{text}");
        assert!(["real_strip.csv", "real_strip_materials.toml", "metrics.json"].iter().all(|f| out.join(f).is_file()));
        std::fs::remove_dir_all(&folder).unwrap();
    }

    /// The fit of the law `name` to a recording with the rows `row` gives of times and stretches, of a page that differs as `changes` say.
    fn fitted_rows(
        folder: &str,
        name: &str,
        changes: &[(&str, &str)],
        rows: &[(f64, [f64; 2])],
        truth: &[f64],
    ) -> (Report, usize) {
        let folder = std::env::temp_dir().join(format!("{folder}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let law = laws::LAWS.iter().find(|law| law.name == name).unwrap();
        let (constants, material) = (law.constants(truth).unwrap(), specimen::material(law.material).unwrap());
        let row = |&(stretch, loaded): &(f64, [f64; 2])| {
            let stress = uniaxial::uniaxial_stress(material, &constants, (stretch, loaded));
            format!("{},{},{}\n", loaded[0] + loaded[1], stretch - 1.0, 1e-3 * stress)
        };
        let page =
            changes.iter().fold(PAGE.replace("crosshead", "extensometer"), |page, (from, to)| page.replace(from, to));
        std::fs::write(folder.join("strip.csv"), "t,e,s\n".to_owned() + &rows.iter().map(row).collect::<String>())
            .unwrap();
        std::fs::write(folder.join("page.toml"), page).unwrap();
        let (report, _) = run(&folder, &folder.join("page.toml"), Some(&folder.join("out"))).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        let result = report.results.iter().position(|result| result.law.name == name).unwrap();
        (report, result)
    }

    #[test]
    fn a_pressed_cylinder_gives_back_its_law() {
        let rows: Vec<(f64, [f64; 2])> =
            (1..60).map(|k| (1.0 - 0.01 * f64::from(k), [0.05 * f64::from(k), 0.0])).collect();
        let truth = [1.8e5_f64.ln(), 0.05_f64.ln(), 0.25, 1.0, 0.3];
        let changes = [("\"tension\"", "\"compression\""), ("[0.05, 1.0]", "[0.05, 0.4]"), ("[1.4]", "[0.55]")];
        let (report, result) = fitted_rows("pressed", "yeoh_c20", &changes, &rows, &truth);
        let result = &report.results[result];
        assert!((result.joint.point[0].exp() / 1.8e5 - 1.0).abs() < 0.02, "{:?}", result.joint.point);
        let measured = report.tests[0].conditions()[1].quantities[0].measured.unwrap();
        let (predicted, _) = &result.all[0][1].as_ref().unwrap()[0];
        assert!(measured > 0.0 && (predicted.value / measured - 1.0).abs() < 0.02, "{} {measured}", predicted.value);
    }

    #[test]
    fn a_held_strip_gives_back_its_spectrum() {
        let ramp = (0..=20).map(|k| (1.0 + 0.01 * f64::from(k), [0.01 * f64::from(k), 0.0]));
        let hold = (1..400).map(|k| (1.2, [0.2, 0.01 * 1.02_f64.powi(k)]));
        let truth = [2.2e5_f64.ln(), 0.08_f64.ln(), 0.3, 1.0];
        let changes = [("\"tension\"", "\"relaxation\""), ("[0.05, 1.0]", "[0.02, 10.0]"), ("[1.4]", "[20.0]")];
        let (report, result) =
            fitted_rows("held", "neo_hookean", &changes, &ramp.chain(hold).collect::<Vec<_>>(), &truth);
        let (result, quantities) = (&report.results[result], &report.tests[0].conditions()[1].quantities);
        let point = &result.joint.point;
        assert!((point[0].exp() / 2.2e5 - 1.0).abs() < 0.02 && (point[1] - truth[1]).abs() < 0.1, "{point:?}");
        assert!((point[2] - 0.3).abs() < 0.03, "{point:?}");
        let (predicted, _) = &result.all[0][1].as_ref().unwrap()[0];
        assert!((predicted.value / quantities[0].measured.unwrap() - 1.0).abs() < 0.01);
        assert_eq!(quantities[0].name, "stress at 20.000 s");
    }
}
