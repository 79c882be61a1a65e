//! `study doctor FOLDER`: a card proposed from a folder of recordings of which nothing is known but the files themselves.
//!
//! Films and logs are told by what they hold, not by their names: the film of the calibration by its board, a log by its columns, a pair by
//! the time for which the lamp is on in both, or where a film shows none, by its motion. Each guess has its evidence and is certain, likely or unsure; what no file says is a question.

mod card;
mod columns;
mod experiment;
mod files;
mod film;
mod guess;
mod lag;
mod lamp;
mod logs;
mod motion;
mod pairing;
mod solids;
mod trials;

use std::fmt;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use diagnostics::{Diagnostic, Result};
use files::{Kind, Recording};
use film::Footage;
pub use guess::{Confidence, Guess};
use logs::Log;
use solids::Solid;
use workflow::runner::Folders;
use workflow::settings::Profile;

/// A proposed card.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// Every guess and question.
    pub guesses: Vec<Guess>,
    /// The card's text.
    pub card: String,
    /// Files that the card names, relative to the folder.
    pub files: Vec<String>,
}

impl fmt::Display for Proposal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.guesses.iter().try_for_each(|guess| writeln!(f, "{guess}"))?;
        let count = |confidence: Confidence| {
            self.guesses.iter().filter(|guess| guess.value.is_some() && guess.confidence == confidence).count()
        };
        let questions = self.guesses.iter().filter(|guess| guess.value.is_none()).count();
        let [certain, likely, unsure] = [Confidence::Certain, Confidence::Likely, Confidence::Unsure].map(count);
        writeln!(f, "{certain} certain, {likely} likely, {unsure} unsure guesses, {questions} questions")
    }
}

/// What the files of a folder hold.
struct Contents {
    films: Vec<Footage>,
    logs: Vec<Log>,
    solids: Vec<Solid>,
    remarks: Vec<Guess>,
}

/// Whether a word names a folder of recordings, and not a specimen of the project.
pub(crate) fn is_folder(root: &Path, profile: Profile, word: &str) -> bool {
    Path::new(word).is_dir() && !Folders::new(root, profile).raw_file(word).is_dir()
}

/// Looks at the files of `folder` and proposes the card of a specimen of this `name`.
///
/// # Errors
/// A [`Diagnostic`] when the folder cannot be listed or holds neither a film nor a log.
pub fn propose(folder: &Path, name: &str) -> Result<Proposal> {
    let recordings = files::list_recordings(folder)?;
    let contents = contents(&recordings);
    if contents.films.is_empty() && contents.logs.is_empty() {
        let reason = format!("none of its {} files is a film or a table of numbers that is read", recordings.len());
        let action = "name a folder of recordings: films, logs and STL files";
        return Err(Diagnostic::new(format!("{} holds no recordings", folder.display()), reason, action));
    }
    Ok(card::proposal(&contents, name))
}

/// Proposes the card of a folder and writes it there as `specimen.toml`; returns the proposal and the card's path.
///
/// # Errors
/// A [`Diagnostic`] as of [`propose`], or when there is a card already, which is never overwritten.
pub fn write(folder: &Path) -> Result<(Proposal, PathBuf)> {
    let path = folder.join(lab::folder::CARD);
    if path.exists() {
        let reason = "a card is never overwritten";
        let action = "put the folder under data/raw and run study doctor with its name, or move the card away";
        return Err(Diagnostic::new(format!("{} exists already", path.display()), reason, action));
    }
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let stem = absolute.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let name = if lab::card::is_name(&stem) { stem } else { "specimen".to_owned() };
    let proposal = propose(folder, &name)?;
    let unwritable = |e| Diagnostic::io(&path, e, "check the permissions of its folder");
    std::fs::write(&path, &proposal.card).map_err(unwritable)?;
    Ok((proposal, path))
}

fn contents(recordings: &[Recording]) -> Contents {
    let recordings_of =
        |kind: Kind| recordings.iter().filter(move |recording| recording.kind == kind).collect::<Vec<_>>();
    let mut remarks = Vec::new();
    let mut read = |recording: &Recording, diagnostic: Diagnostic| {
        let evidence = format!("it is not read: {}; {}", diagnostic.what, diagnostic.why);
        remarks.push(Guess::question(&recording.name, evidence));
    };
    let footage: Vec<_> =
        recordings_of(Kind::Film).into_par_iter().map(|recording| (recording, film::read_footage(recording))).collect();
    let mut films = Vec::new();
    for (recording, result) in footage {
        result.map_or_else(|diagnostic| read(recording, diagnostic), |film| films.push(film));
    }
    let mut tables = Vec::new();
    for recording in recordings_of(Kind::Text) {
        match logs::log(recording) {
            Ok(log) => tables.extend(log),
            Err(diagnostic) => read(recording, diagnostic),
        }
    }
    let solids = recordings_of(Kind::Surface).into_iter().filter_map(solids::solid).collect();
    Contents { films, logs: tables, solids, remarks }
}
