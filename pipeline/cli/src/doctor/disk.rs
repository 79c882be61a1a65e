//! Check of the free disk space.

use super::Project;
use super::finding::Finding;

/// Required free space, bytes: ten times that of a study of three actuators with its pages.
const ENOUGH: u64 = 2_000_000_000;

/// Finding on the free space of the disk with the recordings.
pub(crate) fn disk_finding(project: &Project) -> Option<Finding> {
    let folder = project.folders.raw();
    let folder_path = project.folders.display(&folder);
    match fs4::available_space(&folder) {
        Ok(free_bytes) => space_finding(&folder_path, free_bytes),
        Err(e) => Some(Finding::note(
            format!("the free space under {folder_path} is not known"),
            e.to_string(),
            "look at it with the tools of your system",
        )),
    }
}

fn space_finding(folder_path: &str, free_bytes: u64) -> Option<Finding> {
    let gigabytes = |bytes: u64| bytes as f64 / 1e9;
    let defect = format!("the disk of {folder_path} has {:.2} GB left", gigabytes(free_bytes));
    let reason = format!("records, figures and pages need {:.0} GB", gigabytes(ENOUGH));
    (free_bytes < ENOUGH).then(|| Finding::fix(defect, reason, "free some, or move the project to another disk"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_is_named_when_it_is_nearly_full_and_only_then() {
        assert!(space_finding("data/raw", 5_000_000).is_some_and(|f| f.to_string().contains("0.01 GB left")));
        assert_eq!(space_finding("data/raw", 3 * ENOUGH), None);
    }
}
