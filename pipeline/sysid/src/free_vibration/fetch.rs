//! Download of published recordings from the source named in the page, with a check of their checksum.
//!
//! The transfer uses `curl`, found at run time, as other codecs use `ffmpeg`.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::page::{Page, Recording};
use super::recorded;
use diagnostics::{Diagnostic, Result};

/// Downloads the missing recordings of the page in the file `path` into the first of its folders below `root`; returns their places.
///
/// # Errors
/// A [`Diagnostic`] when there is no network, no `curl`, no source, or other bytes than the page expects.
pub fn fetch(root: &Path, path: &Path) -> Result<Vec<PathBuf>> {
    let page = Page::read(path)?;
    let own = |recording| match recorded::find(&page, recording, root) {
        Ok(there) => Ok(there),
        Err(_) => bring(&page, recording, root),
    };
    page.recording.iter().map(own).collect()
}

fn bring(page: &Page, recording: &Recording, root: &Path) -> Result<PathBuf> {
    let (Some(source), Some(file), Some(folder)) = (&recording.source, recording.files.last(), page.folders.first())
    else {
        let what = format!("a recording of `{}` has no source", page.name);
        return Err(Diagnostic::new(what, "the page names none", "ask those who recorded it"));
    };
    let place = root.join(folder).join(file);
    let unfinished = place.with_extension("unfinished");
    let lost = |e: std::io::Error| {
        Diagnostic::new(format!("{} cannot be written", place.display()), e, "correct the folder's permissions")
    };
    std::fs::create_dir_all(root.join(folder)).map_err(lost)?;
    let ended = Command::new("curl").args(["-fsSL", "--retry", "2", "-o"]).arg(&unfinished).arg(source).output();
    let why = match ended {
        Ok(output) if output.status.success() => None,
        Ok(output) => Some(String::from_utf8_lossy(&output.stderr).trim().to_owned()),
        Err(e) => Some(format!("curl cannot be run: {e}")),
    };
    if let Some(why) = why {
        let next = format!("download it elsewhere and put it at {}", place.display());
        return Err(Diagnostic::new(format!("{source} cannot be fetched"), why, next));
    }
    let bytes = std::fs::read(&unfinished).map_err(lost)?;
    let hash = blake3::hash(&bytes).to_hex().to_string();
    if recording.blake3.as_ref().is_some_and(|wanted| *wanted != hash) {
        let _ = std::fs::remove_file(&unfinished);
        let why = format!("its BLAKE3 is {hash}; the page has another");
        return Err(Diagnostic::new(format!("{source} is not what was published"), why, "ask its publisher"));
    }
    std::fs::rename(&unfinished, &place).map_err(lost)?;
    Ok(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_fetched_says_where_to_put_it_and_leaves_nothing_behind() {
        let root = std::env::temp_dir().join(format!("fetch-{}", std::process::id()));
        std::fs::create_dir_all(&root).unwrap();
        let page = include_str!("../../examples/real/beam_ds10.toml");
        let path = root.join("page.toml");
        std::fs::write(&path, page.replace("https://", "file:///nowhere/")).unwrap();
        let diagnostic = fetch(&root, &path).unwrap_err().to_string();
        let left = std::fs::read_dir(root.join("data/raw/beam_ds10")).unwrap().count();
        std::fs::remove_dir_all(&root).unwrap();
        assert!(
            diagnostic.contains("cannot be fetched") && diagnostic.contains("beam_gravity_a.c3d") && left == 0,
            "{diagnostic}"
        );
    }
}
