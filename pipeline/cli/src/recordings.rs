//! Which recordings of the bench a goal needs: what `rig record` takes, so that one figure does not wait for every trial.

use std::collections::BTreeSet;

use diagnostics::Result;
use study::Runner;
use workflow::runner::Goal;

/// The trials, the fixture's logs and the calibrations that the records of a goal read, as SPECIMEN/PART; the specimen's name alone where its truth is
/// read, which is written last.
///
/// # Errors
/// A [`diagnostics::Diagnostic`] when the goal is unknown.
pub(crate) fn needed_recordings(runner: &Runner, goal: &Goal) -> Result<BTreeSet<String>> {
    let jobs = runner.jobs_of(goal)?;
    let raw_files = jobs.iter().filter_map(|job| job.inputs.as_ref().ok()).flat_map(|inputs| &inputs.raw);
    let needed: BTreeSet<String> = raw_files.filter_map(|file| recording_of(&file.path)).collect();
    let is_whole = |name: &str| name.split_once('/').is_some_and(|(specimen, _)| needed.contains(specimen));
    Ok(needed.iter().filter(|name| !is_whole(name)).cloned().collect())
}

/// The recording to which a raw file belongs; none of a solid, which is written with the card.
fn recording_of(path: &str) -> Option<String> {
    let mut parts = path.split('/');
    let specimen = parts.next()?;
    match (parts.next()?, parts.next()) {
        ("cad", _) => None,
        ("camera", _) => Some(format!("{specimen}/calibration")),
        ("trials", Some(trial)) => Some(format!("{specimen}/{trial}")),
        _ => Some(specimen.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_belongs_to_its_trial_or_to_the_whole_recording() {
        for (path, recording) in [
            ("nemo/trials/static_left/video.mp4", Some("nemo/static_left")),
            ("nemo/cad/body.stl", None),
            ("nemo/camera/calibration.mp4", Some("nemo/calibration")),
            ("nemo/truth.toml", Some("nemo")),
            ("nemo/truth/static_left.csv", Some("nemo")),
            ("nemo", None),
        ] {
            assert_eq!(recording_of(path).as_deref(), recording, "{path}");
        }
    }
}
