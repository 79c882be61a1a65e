//! The files of a folder by what they hold, whatever they are called.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};

/// What a file seems to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A film, or a folder of pictures.
    Film,
    /// A surface in STL.
    Surface,
    /// Text, perhaps a table.
    Text,
    /// Anything else.
    Other,
}

/// A file of the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Recording {
    /// Its path from the folder, with `/`.
    pub(super) name: String,
    pub(super) path: PathBuf,
    pub(super) kind: Kind,
}

/// Files that are looked at, at most: more are no folder of recordings.
const MOST: usize = 10_000;
/// Folders below folders, at most.
const DEEPEST: usize = 8;
/// Pictures that make a folder a recording of its own.
const PICTURES: usize = 3;

/// The recordings below a folder in the order of their names.
///
/// # Errors
/// A [`Diagnostic`] when it cannot be listed, or holds more than ten thousand files.
pub(super) fn list_recordings(folder: &Path) -> Result<Vec<Recording>> {
    let mut recordings = Vec::new();
    collect_recordings(folder, folder, DEEPEST, &mut recordings)?;
    recordings.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(recordings)
}

fn collect_recordings(top: &Path, folder: &Path, depth: usize, recordings: &mut Vec<Recording>) -> Result<()> {
    let unreadable = |e: std::io::Error| Diagnostic::io(folder, e, "name a folder of recordings");
    let entries = std::fs::read_dir(folder).map_err(unreadable)?;
    let paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|p| !is_hidden(p)).collect();
    if folder != top && paths.iter().filter(|path| ending_is(path, &["png", "jpg", "jpeg"])).count() >= PICTURES {
        recordings.push(named_recording(top, folder, Kind::Film));
        return Ok(());
    }
    for path in paths {
        if path.is_dir() {
            if depth > 0 {
                collect_recordings(top, &path, depth - 1, recordings)?;
            }
        } else if recordings.len() < MOST {
            let kind = file_kind(&path);
            recordings.push(named_recording(top, &path, kind));
        } else {
            let reason = format!("a folder of recordings has fewer than {MOST}");
            return Err(Diagnostic::new(
                format!("{} holds too many files", top.display()),
                reason,
                "name a folder below it",
            ));
        }
    }
    Ok(())
}

fn named_recording(top: &Path, path: &Path, kind: Kind) -> Recording {
    let relative = path.strip_prefix(top).unwrap_or(path);
    let parts: Vec<String> =
        relative.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
    Recording { name: parts.join("/"), path: path.to_owned(), kind }
}

fn is_hidden(path: &Path) -> bool {
    path.file_name().is_none_or(|name| name.to_string_lossy().starts_with('.'))
}

fn ending_is(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| endings.contains(&ending.as_str()))
}

/// By its first bytes, and where those do not say it, its ending.
fn file_kind(path: &Path) -> Kind {
    let mut head = Vec::new();
    let opened = std::fs::File::open(path).and_then(|file| {
        use std::io::Read;
        file.take(4096).read_to_end(&mut head)
    });
    let is_film =
        head.get(4..8) == Some(b"ftyp") || ending_is(path, &["mp4", "mov", "avi", "mkv", "m4v", "mts", "webm"]);
    match opened {
        Err(_) => Kind::Other,
        Ok(_) if is_film => Kind::Film,
        Ok(_) if ending_is(path, &["stl"]) => Kind::Surface,
        Ok(_) if ending_is(path, &["toml", "md", "pdf", "yaml", "yml", "json", "xml", "py", "m"]) => Kind::Other,
        Ok(_) if lab::log::decoded(even_part(head), path).is_ok() => Kind::Text,
        Ok(_) => Kind::Other,
    }
}

/// The bytes without a letter of UTF-8 or UTF-16 that was cut at their end.
fn even_part(mut head: Vec<u8>) -> Vec<u8> {
    while head.last().is_some_and(|byte| *byte >= 0x80) {
        head.pop();
    }
    head.truncate(head.len() / 2 * 2);
    head
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn files_are_told_by_their_bytes_and_hidden_ones_are_passed_over() {
        let folder = std::env::temp_dir().join(format!("recordings-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("a/frames")).unwrap();
        let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
        write("a/clip.dat", b"\0\0\0\x18ftypisom");
        write("b.txt", b"t,f\n0,1\n");
        write("c.STL", b"solid c\n");
        write("._b.txt", b"t,f\n0,1\n");
        write("d.bin", &[0, 1, 2, 255]);
        (0..3).for_each(|k| write(&format!("a/frames/{k}.png"), b"png"));
        let kinds: Vec<(String, Kind)> =
            list_recordings(&folder).unwrap().into_iter().map(|r| (r.name, r.kind)).collect();
        let expected = [
            ("a/clip.dat", Kind::Film),
            ("a/frames", Kind::Film),
            ("b.txt", Kind::Text),
            ("c.STL", Kind::Surface),
            ("d.bin", Kind::Other),
        ];
        assert_eq!(kinds, expected.map(|(name, kind)| (name.to_owned(), kind)));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
