//! `study export twin`: the identified and reduced tail of a specimen for a controller, with the crate that steps it; and the check of
//! its gradients.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};
use study::Runner;
use twin::gradient_check::{self, TwinGradientReport};
use workflow::export::ExportedFile;

/// The arrays' file, and the page that describes it.
const ARRAYS: &str = "tail.safetensors";
const PAGE: &str = "tail.txt";

/// The folder of the crate's example, which a user takes as a beginning.
const EXAMPLES: &str = "examples/";

/// Ending of the arrays' file.
pub(crate) const ENDING: &str = "safetensors";

/// Reports on the gradients of the tails in `files`, and on those of the example in air and in water where it is asked for.
///
/// # Errors
/// A [`Diagnostic`] when a file cannot be read or a step is not found.
pub fn check_gradients(files: &[&PathBuf], example: bool, steps: usize) -> Result<Vec<TwinGradientReport>> {
    let mut reports = Vec::new();
    for file in files {
        reports.push(gradient_check::run(&file.display().to_string(), &twin::file::read(file)?, steps)?);
    }
    for (name, wet) in [("reduced beam in air", false), ("reduced beam in water", true)] {
        if example {
            reports.push(gradient_check::run(name, &twin::example::beam(wet), steps)?);
        }
    }
    Ok(reports)
}

/// A tail that was exported.
pub struct ExportedTwin {
    /// Its folder.
    pub folder: PathBuf,
    /// The example, where the user has edited it: it is kept.
    pub kept: Vec<PathBuf>,
}

/// Writes the arrays, the page that describes them, and the crate by itself.
///
/// # Errors
/// A [`Diagnostic`] when there is no such specimen, one of its records is missing or stale, the folder holds what no export wrote, or a file
/// cannot be written.
pub fn export(runner: &Runner, name: &str, folder: Option<&Path>) -> Result<ExportedTwin> {
    let specimens = &runner.universe.specimens;
    let specimen = specimens.iter().find(|specimen| specimen.card.name == name).ok_or_else(|| {
        let names: Vec<&str> = specimens.iter().map(|specimen| &*specimen.card.name).collect();
        let reason = format!("there are {}", names.join(", "));
        Diagnostic::new(format!("there is no specimen `{name}`"), reason, "name one of these")
    })?;
    let data = study::live::specimen_twin(runner, specimen, None)?;
    let folder = folder.map_or_else(|| runner.folders.base().join("twin").join(name), Path::to_owned);
    let data_files = [ExportedFile::new(ARRAYS, twin::file::bytes(&data)?), ExportedFile::new(PAGE, data.page()?)];
    let sources = twin::package::files().into_iter().map(|(path, text)| match path.starts_with(EXAMPLES) {
        true => ExportedFile::template(path, text),
        false => ExportedFile::new(path, text),
    });
    let edited_files = workflow::export::write(&folder, &data_files.into_iter().chain(sources).collect::<Vec<_>>())?;
    Ok(ExportedTwin { folder, kept: edited_files })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_damaged_file_is_refused_with_its_name_and_the_array() {
        let path = std::env::temp_dir().join(format!("damaged-{}.{ENDING}", std::process::id()));
        let mut transposed = twin::file::bytes(&twin::example::beam(false)).unwrap();
        let at = transposed.windows(8).position(|eight| eight == b"[80,7,9]").unwrap();
        transposed[at..at + 8].copy_from_slice(b"[80,9,7]");
        fs::write(&path, transposed).unwrap();
        let refused = check_gradients(&[&path], false, 3).unwrap_err().to_string();
        fs::remove_file(&path).unwrap();
        assert!(refused.contains(&path.display().to_string()) && refused.contains("`region0.gradients`"), "{refused}");
    }

    #[test]
    fn the_example_s_gradients_are_checked_in_air_and_in_water_and_a_file_s_own_by_its_name() {
        let path = std::env::temp_dir().join(format!("tail-{}.{ENDING}", std::process::id()));
        fs::write(&path, twin::file::bytes(&twin::example::beam(false)).unwrap()).unwrap();
        let examples = check_gradients(&[], true, 3).unwrap();
        let own = check_gradients(&[&path], false, 3).unwrap();
        fs::remove_file(&path).unwrap();
        assert!(examples.iter().chain(&own).all(|report| report.holds()));
        let text: Vec<String> = examples.iter().chain(&own).map(ToString::to_string).collect();
        assert_eq!(text.len(), 3);
        assert!(text[0].contains("reduced beam in air") && text[1].contains("reduced beam in water"), "{text:?}");
        assert!(text[2].contains(&path.display().to_string()), "{}", text[2]);
    }
}
