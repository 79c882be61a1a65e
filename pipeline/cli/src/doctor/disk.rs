//! Check of the free disk space.

use super::Look;
use super::finding::Finding;

/// Required free space, bytes: ten times that of a study of three actuators with its pages.
const ENOUGH: u64 = 2_000_000_000;

/// Finding on the free space of the disk with the recordings.
pub fn look(look: &Look) -> Option<Finding> {
    let raw = look.folders.raw();
    let place = look.folders.display(&raw);
    match fs4::available_space(&raw) {
        Ok(free) => judge(&place, free),
        Err(e) => Some(Finding::note(
            format!("the free space under {place} is not known"),
            e.to_string(),
            "look at it with the tools of your system",
        )),
    }
}

fn judge(place: &str, free: u64) -> Option<Finding> {
    let gigabytes = |bytes: u64| bytes as f64 / 1e9;
    let what = format!("the disk of {place} has {:.2} GB left", gigabytes(free));
    let why = format!("records, figures and pages need {:.0} GB", gigabytes(ENOUGH));
    (free < ENOUGH).then(|| Finding::fix(what, why, "free some, or move the project to another disk"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_is_named_when_it_is_nearly_full_and_only_then() {
        assert!(judge("data/raw", 5_000_000).is_some_and(|f| f.to_string().contains("0.01 GB left")));
        assert_eq!(judge("data/raw", 3 * ENOUGH), None);
    }
}
