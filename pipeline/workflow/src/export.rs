//! Exports: files for another program in a folder of the user's, where nothing is overwritten that an export did not write.
//!
//! A list beside the files holds the BLAKE3 of each as it was written, so that an edited file is known from an untouched one.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result, input};

use crate::runner::write_atomically;

/// The name of the list.
const LIST: &str = ".exported.json";

/// Path of each file, from the export's folder with `/` between its parts → the hashes that it may have. There are two while a later
/// export is being written, so that one that is killed meanwhile has edited nothing.
type List = BTreeMap<String, BTreeSet<String>>;

/// A file of an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportedFile {
    /// From the export's folder, with `/` between its parts.
    pub path: String,
    /// Its content.
    pub content: Vec<u8>,
    /// Whether the user is meant to edit it: an edited one is kept, where any other refuses the export.
    pub is_template: bool,
}

impl ExportedFile {
    /// A file that is not meant to be edited.
    pub fn new(path: &str, content: impl Into<Vec<u8>>) -> Self {
        Self { path: path.to_owned(), content: content.into(), is_template: false }
    }

    /// A file that the user may edit.
    pub fn template(path: &str, content: impl Into<Vec<u8>>) -> Self {
        Self { is_template: true, ..Self::new(path, content) }
    }
}

/// Writes an export into `folder`, which is empty, holds an earlier export, or does not exist; returns the edited templates, which are kept.
///
/// # Errors
/// A [`Diagnostic`] before anything is written when the folder holds other files, or an earlier export that was edited; or when a file
/// cannot be read or written.
pub fn write(folder: &Path, files: &[ExportedFile]) -> Result<Vec<PathBuf>> {
    let earlier = read_list(folder)?;
    if earlier.is_none() {
        refuse_foreign_files(folder)?;
    }
    let earlier = earlier.unwrap_or_default();
    let is_edited = |file: &&ExportedFile| was_edited(folder, &file.path, &earlier);
    let (kept_templates, edited): (Vec<_>, Vec<_>) = files.iter().filter(is_edited).partition(|file| file.is_template);
    if let Some(first) = edited.first() {
        return Err(edited_file(&folder.join(&first.path), earlier.contains_key(&first.path)));
    }
    let written: Vec<&ExportedFile> = files.iter().filter(|file| !kept_templates.contains(file)).collect();
    let hashes = |file: &&ExportedFile| (file.path.clone(), BTreeSet::from([content_hash(&file.content)]));
    let mut later: List = written.iter().map(hashes).collect();
    for file in &kept_templates {
        later.extend(earlier.get_key_value(&file.path).map(|(path, hashes)| (path.clone(), hashes.clone())));
    }
    let mut acceptable = earlier.clone();
    for (path, hashes) in &later {
        acceptable.entry(path.clone()).or_default().extend(hashes.iter().cloned());
    }
    write_list(folder, &acceptable)?;
    for file in written {
        write_file(&folder.join(&file.path), &file.content)?;
    }
    remove_former_files(folder, &earlier, &later)?;
    write_list(folder, &later)?;
    Ok(kept_templates.iter().map(|file| folder.join(&file.path)).collect())
}

/// What stands in an export's text as a path.
///
/// # Errors
/// A [`Diagnostic`] when the path is no text: neither JSON nor TOML could hold it.
pub fn path_as_text(path: &Path) -> Result<String> {
    path.to_str().map(str::to_owned).ok_or_else(|| {
        let problem = format!("{path:?} cannot be written into an export");
        Diagnostic::new(problem, "the name is no text in UTF-8", "rename the folder, or choose another one")
    })
}

/// The list of an earlier export; none where there was no export.
fn read_list(folder: &Path) -> Result<Option<List>> {
    let path = folder.join(LIST);
    if path.symlink_metadata().is_err() {
        return Ok(None);
    }
    let not_understood = |reason: String| {
        Diagnostic::file(
            &path,
            "the list of an earlier export is not understood",
            reason,
            "move the folder away, or name another one",
        )
    };
    let text = input::read(&path, input::PAGE).map_err(|e| not_understood(e.to_string()))?;
    serde_json::from_slice(&text).map(Some).map_err(|e| not_understood(e.to_string()))
}

/// Holds that a folder without a list has nothing in it but folders of other exports.
fn refuse_foreign_files(folder: &Path) -> Result<()> {
    let entries = match fs::read_dir(folder) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        entries => entries.map_err(|e| write_error(folder, e))?,
    };
    let is_foreign = |path: &PathBuf| !path.join(LIST).is_file();
    match entries.flatten().map(|entry| entry.path()).filter(is_foreign).min() {
        None => Ok(()),
        Some(foreign) => Err(Diagnostic::file(
            folder,
            format!("the folder holds `{}`, which no export wrote", foreign.file_name().unwrap_or_default().display()),
            "an export overwrites nothing but an earlier, unedited export",
            "name a folder that is empty or does not exist, or move the other files away",
        )),
    }
}

/// Whether a file lies there with other bytes than an export wrote.
fn was_edited(folder: &Path, path: &str, earlier: &List) -> bool {
    let file = folder.join(path);
    if file.symlink_metadata().is_err() {
        return false;
    }
    let present = input::read(&file, input::MESH).map(|bytes| content_hash(&bytes));
    !present.is_ok_and(|hash| earlier.get(path).is_some_and(|hashes| hashes.contains(&hash)))
}

/// Removes what an earlier export wrote and a later one does not.
fn remove_former_files(folder: &Path, earlier: &List, later: &List) -> Result<()> {
    for path in earlier.keys().filter(|path| !later.contains_key(*path) && !was_edited(folder, path, earlier)) {
        let file = folder.join(path);
        if file.exists() {
            fs::remove_file(&file).map_err(|e| write_error(&file, e))?;
        }
    }
    Ok(())
}

fn write_list(folder: &Path, list: &List) -> Result<()> {
    write_file(&folder.join(LIST), &serde_json::to_vec_pretty(list)?)
}

fn write_file(path: &Path, content: &[u8]) -> Result<()> {
    write_atomically(path, content).map_err(|e| write_error(path, e))
}

fn content_hash(content: &[u8]) -> String {
    blake3::hash(content).to_hex().to_string()
}

fn edited_file(path: &Path, is_listed: bool) -> Diagnostic {
    let reason = if is_listed { "it was edited since an earlier export wrote it" } else { "no export wrote it" };
    Diagnostic::file(path, "the file would be overwritten", reason, "move it away, or export into another folder")
}

fn write_error(path: &Path, error: std::io::Error) -> Diagnostic {
    Diagnostic::io(path, error, "choose another folder or correct its permissions")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder that does not exist yet, removed at the end.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("export-{name}-{}", std::process::id()));
            let _ = fs::remove_dir_all(&path);
            Self(path)
        }

        fn write(&self, version: &str) -> Result<Vec<PathBuf>> {
            let contents = [("src/lib.rs", version), ("Cargo.toml", "[package]"), ("example.rs", version)];
            let file = |(path, text): (&str, &str)| ExportedFile {
                is_template: path == "example.rs",
                ..ExportedFile::new(path, text)
            };
            write(&self.0, &contents.map(file))
        }

        fn text(&self, file: &str) -> String {
            fs::read_to_string(self.0.join(file)).unwrap_or_default()
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn an_unedited_export_is_replaced_and_files_beside_it_stay() {
        let folder = Folder::new("replaced");
        folder.write("1").unwrap();
        fs::write(folder.0.join("Cargo.lock"), "built").unwrap();
        assert!(folder.write("2").unwrap().is_empty());
        assert_eq!(["src/lib.rs", "example.rs", "Cargo.lock"].map(|file| folder.text(file)), ["2", "2", "built"]);
    }

    #[test]
    fn a_folder_with_other_files_is_refused_and_left_as_it_is() {
        let folder = Folder::new("foreign");
        fs::create_dir_all(folder.0.join("workflow")).unwrap();
        fs::write(folder.0.join("workflow").join(LIST), "{}").unwrap();
        fs::write(folder.0.join("Cargo.toml"), "mine").unwrap();
        let refused = folder.write("1").unwrap_err().to_string();
        assert!(refused.contains("holds `Cargo.toml`, which no export wrote"), "{refused}");
        assert_eq!((folder.text("Cargo.toml").as_str(), folder.0.join("src").exists()), ("mine", false));
        fs::remove_file(folder.0.join("Cargo.toml")).unwrap();
        folder.write("1").unwrap();
    }

    #[test]
    fn an_edited_template_is_kept_and_any_other_edited_file_refuses_the_export() {
        let folder = Folder::new("edited");
        folder.write("1").unwrap();
        fs::write(folder.0.join("example.rs"), "mine").unwrap();
        for version in ["2", "3"] {
            assert_eq!(folder.write(version).unwrap(), [folder.0.join("example.rs")]);
        }
        assert_eq!((folder.text("example.rs").as_str(), folder.text("src/lib.rs").as_str()), ("mine", "3"));
        fs::write(folder.0.join("src/lib.rs"), "mine").unwrap();
        assert!(folder.write("4").unwrap_err().to_string().contains("edited since"));
        assert_eq!(folder.text("src/lib.rs"), "mine");
    }

    #[test]
    fn a_file_that_is_new_in_an_export_does_not_replace_one_that_lies_there() {
        let folder = Folder::new("new");
        folder.write("1").unwrap();
        fs::write(folder.0.join("build.rs"), "mine").unwrap();
        assert!(
            write(&folder.0, &[ExportedFile::new("build.rs", "2")]).unwrap_err().why.contains("no export wrote it")
        );
        write(&folder.0, &[ExportedFile::new("a.txt", "2")]).unwrap();
        assert!(!folder.0.join("Cargo.toml").exists(), "what the later export does not have is removed");
        assert_eq!(folder.text("build.rs"), "mine");
    }

    #[test]
    fn an_export_that_was_killed_is_no_edited_one() {
        let folder = Folder::new("killed");
        folder.write("1").unwrap();
        let earlier = read_list(&folder.0).unwrap().unwrap();
        folder.write("2").unwrap();
        let mut either = read_list(&folder.0).unwrap().unwrap();
        for (path, hashes) in earlier {
            either.entry(path).or_default().extend(hashes);
        }
        write_list(&folder.0, &either).unwrap();
        fs::write(folder.0.join("src/lib.rs"), "1").unwrap();
        folder.write("3").unwrap();
        fs::write(folder.0.join(LIST), "{").unwrap();
        assert!(folder.write("3").unwrap_err().to_string().contains("not understood"));
    }
}
