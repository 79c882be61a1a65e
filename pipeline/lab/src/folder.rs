//! Specimens as folders: those under `data/raw`, and the paths of a card's files.

use std::path::{Path, PathBuf};

use crate::card::FixtureOf;
use crate::{Card, card};
use diagnostics::{Diagnostic, input};

/// The name of the card in its folder.
pub const CARD: &str = "specimen.toml";
/// The name of the hidden truth in the folder, where a virtual bench left one.
pub const TRUTH: &str = "truth.toml";

/// A specimen's folder and its card.
#[derive(Debug, Clone, PartialEq)]
pub struct Specimen {
    /// The folder.
    pub folder: PathBuf,
    /// Its card.
    pub card: Card,
}

impl Specimen {
    /// The specimen in `folder`, its card checked.
    ///
    /// # Errors
    /// As [`card::read`].
    pub fn open(folder: &Path) -> Result<Self, Diagnostic> {
        Ok(Self { folder: folder.to_owned(), card: card::read(&folder.join(CARD))? })
    }

    /// A file that the card names, as a path.
    pub fn file(&self, relative: &str) -> PathBuf {
        relative.split('/').fold(self.folder.clone(), |path, part| path.join(part))
    }

    /// Every file that the card names, with the key that names it, in the card's order.
    pub fn files(&self) -> Vec<(String, &str)> {
        let card = &self.card;
        let mut files = card.solid.files();
        if let Some(camera) = &card.camera {
            files.push(("camera.calibration".to_owned(), &camera.calibration));
            files.extend(camera.coefficients.iter().map(|lens| ("camera.coefficients".to_owned(), lens.as_str())));
        }
        for trial in &card.trial {
            files.extend(trial.video.iter().map(|video| (format!("video of trial `{}`", trial.id), video.as_str())));
            files.push((format!("pressure of trial `{}`", trial.id), &trial.pressure));
            files.extend(trial.force.iter().map(|force| (format!("force of trial `{}`", trial.id), force.as_str())));
        }
        for tracks in &card.tracks {
            files.push((format!("tracks of trial `{}`", tracks.trial), &tracks.file));
        }
        for fixture in &card.fixture {
            files.push((format!("force of fixture `{}`", fixture.id), &fixture.force));
            if let FixtureOf::Taps { hammer, .. } = &fixture.of {
                files.push((format!("hammer of fixture `{}`", fixture.id), hammer));
            }
        }
        files
    }

    /// One diagnostic for each file that the card names and that is not there, or is no file to be read.
    pub fn missing(&self) -> Vec<Diagnostic> {
        let diagnostic = |(key, file): (String, &str)| {
            let defect = self.file_defect(&key, file)?;
            let reason = format!("{} names it as {key}", self.folder.join(CARD).display());
            Some(Diagnostic::file(&self.file(file), defect, reason, "put it there, or correct the card"))
        };
        self.files().into_iter().filter_map(diagnostic).collect()
    }

    /// What is wrong with a file before it is read: it is missing, no regular file, or too large. A film may be a folder of pictures.
    fn file_defect(&self, key: &str, file: &str) -> Option<String> {
        let path = self.file(file);
        let is_film = key.starts_with("video") || key == "camera.calibration";
        match input::regular(&path) {
            Ok(length) if is_film || length <= input::MESH => None,
            Ok(_) => Some(format!("the file is larger than {} MiB", input::MESH >> 20)),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Some("the file is missing".into()),
            Err(_) if is_film && path.is_dir() => None,
            Err(e) => Some(format!("the file cannot be used: {e}")),
        }
    }
}

/// The folders under `raw` that hold a card, by name.
///
/// # Errors
/// [`Diagnostic`] when `raw` cannot be listed.
pub fn list(raw: &Path) -> Result<Vec<PathBuf>, Diagnostic> {
    let action = "put a specimen's folder there, or let `rig record` make one";
    let entries = std::fs::read_dir(raw).map_err(|e| Diagnostic::io(raw, e, action))?;
    let mut folders = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| Diagnostic::io(raw, e, action))?.path();
        let is_hidden = path.file_name().and_then(|n| n.to_str()).is_none_or(|n| n.starts_with('.'));
        if !is_hidden && path.join(CARD).is_file() {
            folders.push(path);
        }
    }
    folders.sort();
    Ok(folders)
}
