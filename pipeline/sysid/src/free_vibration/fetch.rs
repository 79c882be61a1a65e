//! Download of published recordings from the source named in the page, with a check of their checksum.
//!
//! The transfer uses `curl`, found at run time, as other codecs use `ffmpeg`.

use std::path::{Component, Path, PathBuf};
use std::process::Command;

use super::page::{Page, Recording};
use super::recorded;
use diagnostics::{Diagnostic, Result};

/// Options of `curl`: redirections stay on https, a stalled transfer ends, and no file is larger than a long recording (2 GiB).
const OPTIONS: [&str; 13] = [
    "-fsSL",
    "--retry",
    "2",
    "--proto",
    "=https",
    "--proto-redir",
    "=https",
    "--connect-timeout",
    "30",
    "--max-time",
    "1800",
    "--max-filesize",
    "2147483648",
];

/// Downloads the missing recordings of the page in the file `path` into the first of its folders below `root`; returns their places.
///
/// # Errors
/// A [`Diagnostic`] when there is no network, no `curl`, no source, or other bytes than the page expects.
pub fn fetch(root: &Path, path: &Path) -> Result<Vec<PathBuf>> {
    let page = Page::read(path)?;
    let locate = |recording: &Recording| match recorded::find(&page.name, &page.folders, &recording.files, root) {
        Ok(path) => Ok(path),
        Err(_) => Download::of(&page, recording, root)?.run(root),
    };
    page.recording.iter().map(locate).collect()
}

/// What is downloaded, from where to where; everything on a page is untrusted.
struct Download<'a> {
    source: &'a str,
    blake3: &'a str,
    place: PathBuf,
}

impl<'a> Download<'a> {
    /// The download of a recording that lies in none of the page's folders.
    fn of(page: &'a Page, recording: &'a Recording, root: &Path) -> Result<Self> {
        let refused = |message: String, reason: &str, action: &str| Err(Diagnostic::new(message, reason, action));
        let (Some(source), Some(file), Some(folder)) =
            (&recording.source, recording.files.last(), page.folders.first())
        else {
            let message = format!("a recording of `{}` has no source", page.name);
            return refused(message, "the page names none", "ask those who recorded it");
        };
        let Some(blake3) = recording.blake3.as_deref().filter(|hash| is_hash(hash)) else {
            let reason =
                "without the BLAKE3 of its bytes (64 hexadecimal digits) a file that was altered is not recognised";
            return refused(
                format!("the source {source:?} has no checksum"),
                reason,
                "add `blake3` to the [[recording]]",
            );
        };
        if !source.starts_with("https://") || source.contains(|c: char| c.is_whitespace() || c.is_control()) {
            let message = format!("the source {source:?} is not an https address");
            return refused(
                message,
                "recordings are downloaded from public sources only",
                "correct `source` on the page",
            );
        }
        let relative_path = folder.join(file);
        if !relative_path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) {
            let message = format!("{} lies outside of the project", relative_path.display());
            return refused(
                message,
                "downloads are written below the project's folder",
                "correct `folders` and `files` on the page",
            );
        }
        Ok(Self { source, blake3, place: root.join(relative_path) })
    }

    /// Downloads beside the place, compares the checksum, and only then puts the file there.
    fn run(&self, root: &Path) -> Result<PathBuf> {
        let unfinished = self.place.with_extension("unfinished");
        let ended = self
            .folder_within(root)
            .and_then(|()| self.transfer_file(&unfinished))
            .and_then(|()| self.accept_file(&unfinished));
        if ended.is_err() {
            // Where nothing was written there is nothing to remove.
            let _ = std::fs::remove_file(&unfinished);
        }
        ended.map(|()| self.place.clone())
    }

    /// Makes the folder, and refuses one that a link leads out of the project.
    fn folder_within(&self, root: &Path) -> Result<()> {
        let folder = self.place.parent().unwrap_or(root);
        std::fs::create_dir_all(folder).map_err(|e| self.write_failure(e))?;
        let [inner, outer] = [folder, root].map(Path::canonicalize);
        match inner.map_err(|e| self.write_failure(e))?.starts_with(outer.map_err(|e| self.write_failure(e))?) {
            true => Ok(()),
            false => Err(Diagnostic::new(
                format!("{} lies outside of the project", folder.display()),
                "a link leads out of it",
                "remove the link",
            )),
        }
    }

    fn transfer_file(&self, destination: &Path) -> Result<()> {
        let ended = Command::new("curl").args(OPTIONS).arg("-o").arg(destination).arg("--").arg(self.source).output();
        let reason = match ended {
            Ok(output) if output.status.success() => return Ok(()),
            Ok(output) => String::from_utf8_lossy(&output.stderr).trim().to_owned(),
            Err(e) => format!("curl cannot be run: {e}"),
        };
        let next = format!("download it elsewhere and put it at {}", self.place.display());
        Err(Diagnostic::new(format!("{} cannot be fetched", self.source), reason, next))
    }

    fn accept_file(&self, unfinished: &Path) -> Result<()> {
        let bytes = std::fs::read(unfinished).map_err(|e| self.write_failure(e))?;
        let hash = blake3::hash(&bytes).to_hex().to_string();
        if !hash.eq_ignore_ascii_case(self.blake3) {
            let reason = format!("its BLAKE3 is {hash}; the page has {}", self.blake3);
            return Err(Diagnostic::new(
                format!("{} is not what was published", self.source),
                reason,
                "ask its publisher",
            ));
        }
        std::fs::rename(unfinished, &self.place).map_err(|e| self.write_failure(e))
    }

    fn write_failure(&self, e: std::io::Error) -> Diagnostic {
        let message = format!("{} cannot be written", self.place.display());
        Diagnostic::new(message, &e, "correct the folder's permissions").caused_by(e)
    }
}

fn is_hash(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The diagnostic of a fetch with the page that comes along, one text replaced by another, and the files it left.
    fn refused(name: &str, from: &str, to: &str) -> (String, usize) {
        let root = std::env::temp_dir().join(format!("fetch-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&root).unwrap();
        let page = include_str!("../../examples/real/beam_ds10.toml");
        let path = root.join("page.toml");
        std::fs::write(&path, page.replace(from, to).replace("\"../shared/real/beam_ds10\"", "\"nowhere\"")).unwrap();
        let diagnostic = fetch(&root, &path).unwrap_err().to_string();
        let left = std::fs::read_dir(root.join("data/raw/beam_ds10")).map_or(0, Iterator::count);
        std::fs::remove_dir_all(&root).unwrap();
        (diagnostic, left)
    }

    #[test]
    fn what_cannot_be_fetched_says_where_to_put_it_and_leaves_nothing_behind() {
        // Nothing listens at this port of this machine.
        let (diagnostic, left) = refused("port", "https://", "https://127.0.0.1:9/");
        assert!(
            diagnostic.contains("cannot be fetched") && diagnostic.contains("beam_gravity_a.c3d") && left == 0,
            "{diagnostic}"
        );
    }

    #[test]
    fn a_page_reaches_neither_other_folders_nor_local_files_nor_the_options_of_the_transfer() {
        let cases = [
            ("above", "\"data/raw/beam_ds10\"", "\"../victim\"", "outside of the project"),
            ("absolute", "\"data/raw/beam_ds10\"", "\"/tmp/victim\"", "outside of the project"),
            ("local", "https://", "file:///etc/", "not an https address"),
            ("option", "https://", "-K/some/", "not an https address"),
            ("plain", "https://", "http://", "not an https address"),
            ("hash", "blake3 = \"be05", "# \"", "has no checksum"),
            ("short", "blake3 = \"be05", "blake3 = \"", "has no checksum"),
        ];
        for (name, from, to, expected) in cases {
            let (diagnostic, left) = refused(name, from, to);
            assert!(diagnostic.contains(expected) && diagnostic.contains("do:"), "{diagnostic}");
            assert_eq!(left, 0);
        }
    }
}
