//! Typst with the fonts of the project, applied to one folder.

use std::fmt;
use std::path::{Path, PathBuf};

use typst::diag::SourceDiagnostic;
use typst::{World, WorldExt};
use typst_as_lib::TypstEngine;
use typst_layout::PagedDocument;

/// A compiled document.
pub struct Document {
    /// The PDF.
    pub pdf: Vec<u8>,
    /// Number of pages.
    pub pages: usize,
}

/// Why a paper could not be compiled.
#[derive(Debug)]
pub enum TypesetError {
    /// The resolved source does not exist.
    NotPrepared(PathBuf),
    /// A folder or font cannot be read.
    Unreadable {
        /// The folder.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The PDF cannot be written.
    Unwritable {
        /// The PDF.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The folder holds no font.
    NoFont(PathBuf),
    /// Errors and warnings of typst, each with file and line.
    Source(String),
}

impl fmt::Display for TypesetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotPrepared(path) => write!(
                f,
                "{} does not exist\n  why: the source has not been resolved\n  do:  run study paper",
                path.display()
            ),
            Self::Unreadable { path, source } => {
                write!(f, "{} cannot be read\n  why: {source}\n  do:  check its permissions", path.display())
            }
            Self::Unwritable { path, source } => write!(
                f,
                "{} cannot be written\n  why: {source}\n  do:  check the permissions and the free space",
                path.display()
            ),
            Self::NoFont(folder) => write!(
                f,
                "there is no font in {}\n  why: the paper uses its own fonts\n  do:  restore the folder",
                folder.display()
            ),
            Self::Source(messages) => f.write_str(messages),
        }
    }
}

impl std::error::Error for TypesetError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Unreadable { source, .. } | Self::Unwritable { source, .. } => Some(source),
            Self::NotPrepared(_) | Self::NoFont(_) | Self::Source(_) => None,
        }
    }
}

/// Every font in a folder, by name.
///
/// # Errors
/// When the folder cannot be read or holds no font.
pub fn read_fonts(folder: &Path) -> Result<Vec<Vec<u8>>, TypesetError> {
    let unreadable = |source: std::io::Error| TypesetError::Unreadable { path: folder.to_owned(), source };
    let entries = std::fs::read_dir(folder).map_err(unreadable)?;
    let mut places: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    places.sort();
    let fonts = places.iter().filter(|p| p.extension().is_some_and(|e| e == "ttf" || e == "otf"));
    let fonts: Vec<Vec<u8>> = fonts.map(std::fs::read).collect::<Result<_, _>>().map_err(unreadable)?;
    if fonts.is_empty() { Err(TypesetError::NoFont(folder.to_owned())) } else { Ok(fonts) }
}

/// Compiles `main` below `root`.
///
/// # Errors
/// All errors of the source, with file and line. Warnings are errors too: a missing font is only a warning of typst.
pub fn compile(root: &Path, main: &str, fonts: &[Vec<u8>]) -> Result<Document, TypesetError> {
    let font_files = typst_assets::fonts().map(<[u8]>::to_vec).chain(fonts.iter().cloned());
    let engine = TypstEngine::builder().fonts(font_files).with_file_system_resolver(root).build();
    let compiled = engine.with_world(main, |world| -> Result<Document, String> {
        let joined = |all: &[SourceDiagnostic]| {
            all.iter().map(|d| error_message(world, d)).collect::<Vec<_>>().join("\nerror: ")
        };
        let done = typst::compile::<PagedDocument>(world);
        let document = done.output.map_err(|errors| joined(&errors))?;
        if !done.warnings.is_empty() {
            return Err(joined(&done.warnings));
        }
        let pdf = typst_pdf::pdf(&document, &typst_pdf::PdfOptions::default()).map_err(|errors| joined(&errors))?;
        Ok(Document { pdf, pages: document.pages().len() })
    });
    compiled.map_err(|e| TypesetError::Source(e.to_string()))?.map_err(TypesetError::Source)
}

fn error_message(world: &dyn World, error: &SourceDiagnostic) -> String {
    let hints: String = error.hints.iter().map(|hint| format!("\n  do:  {}", hint.v)).collect();
    format!("{}{}{hints}", source_line(world, error).unwrap_or_default(), error.message)
}

/// `main.typ:12: `.
fn source_line(world: &dyn World, error: &SourceDiagnostic) -> Option<String> {
    let id = error.span.id()?;
    let source = world.source(id).ok()?;
    let start = world.range(error.span).map_or(0, |range| range.start);
    let line = source.lines().byte_to_line(start).unwrap_or(0) + 1;
    Some(format!("{}:{line}: ", id.vpath().get_without_slash()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder of its own with one page.
    fn folder(name: &str, page: &str) -> std::path::PathBuf {
        let folder = std::env::temp_dir().join(format!("typeset_{name}_{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("main.typ"), page).unwrap();
        folder
    }

    #[test]
    fn the_same_page_gives_the_same_bytes() {
        let root = folder("same", "= One\nTwo $x^2$.");
        let [first, second] = [0, 1].map(|_| compile(&root, "main.typ", &[]).unwrap());
        assert!(first.pages == 1 && first.pdf == second.pdf);
        std::fs::remove_dir_all(root).unwrap();
    }

    #[test]
    fn an_error_names_its_file_and_line() {
        let root = folder("error", "one\n#nothing");
        let error = compile(&root, "main.typ", &[]).err().unwrap().to_string();
        assert!(error.contains("main.typ:2: unknown variable: nothing"), "{error}");
        std::fs::remove_dir_all(root).unwrap();
    }

    #[test]
    fn a_missing_font_is_an_error() {
        let root = folder("font", "#set text(font: \"No Such Font\")\none");
        assert!(compile(&root, "main.typ", &[]).is_err());
        std::fs::remove_dir_all(root).unwrap();
    }
}
