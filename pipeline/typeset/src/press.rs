//! The press: typst with the fonts of the project, on one folder.
//!
//! Stands on: typst, typst-as-lib, typst-pdf. Never knows: which paper it is.

use std::path::Path;

use typst::diag::SourceDiagnostic;
use typst::{World, WorldExt};
use typst_as_lib::TypstEngine;
use typst_layout::PagedDocument;

/// A paper, set.
pub struct Set {
    /// Its bytes.
    pub pdf: Vec<u8>,
    /// How many pages it has.
    pub pages: usize,
}

/// Every font in a folder, by name.
///
/// # Errors
/// Words, when the folder cannot be read or holds no font.
pub fn fonts(folder: &Path) -> Result<Vec<Vec<u8>>, String> {
    let unreadable = |e: std::io::Error| format!("{} cannot be read\n  why: {e}", folder.display());
    let entries = std::fs::read_dir(folder).map_err(unreadable)?;
    let mut places: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    places.sort();
    let fonts = places.iter().filter(|p| p.extension().is_some_and(|e| e == "ttf" || e == "otf"));
    let fonts: Vec<Vec<u8>> = fonts.map(std::fs::read).collect::<Result<_, _>>().map_err(unreadable)?;
    if fonts.is_empty() { Err(format!("there is no font in {}", folder.display())) } else { Ok(fonts) }
}

/// Sets `main` below `root`.
///
/// # Errors
/// Words: every fault of the source, with its file and line. A warning is a fault too: a font that is missing leaves holes.
pub fn set(root: &Path, main: &str, fonts: &[Vec<u8>]) -> Result<Set, String> {
    let all = typst_assets::fonts().map(<[u8]>::to_vec).chain(fonts.iter().cloned());
    let engine = TypstEngine::builder().fonts(all).with_file_system_resolver(root).build();
    let set = engine.with_world(main, |world| {
        let told = |all: &[SourceDiagnostic]| all.iter().map(|d| words(world, d)).collect::<Vec<_>>().join("\nerror: ");
        let done = typst::compile::<PagedDocument>(world);
        let document = done.output.map_err(|faults| told(&faults))?;
        if !done.warnings.is_empty() {
            return Err(told(&done.warnings));
        }
        let pdf = typst_pdf::pdf(&document, &typst_pdf::PdfOptions::default()).map_err(|faults| told(&faults))?;
        Ok(Set { pdf, pages: document.pages().len() })
    });
    set.map_err(|e| e.to_string())?
}

fn words(world: &dyn World, fault: &SourceDiagnostic) -> String {
    let hints: String = fault.hints.iter().map(|hint| format!("\n  do:  {}", hint.v)).collect();
    format!("{}{}{hints}", place(world, fault).unwrap_or_default(), fault.message)
}

/// `main.typ:12: `.
fn place(world: &dyn World, fault: &SourceDiagnostic) -> Option<String> {
    let id = fault.span.id()?;
    let source = world.source(id).ok()?;
    let start = world.range(fault.span).map_or(0, |range| range.start);
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
        let [first, second] = [0, 1].map(|_| set(&root, "main.typ", &[]).unwrap());
        assert!(first.pages == 1 && first.pdf == second.pdf);
        std::fs::remove_dir_all(root).unwrap();
    }

    #[test]
    fn a_fault_names_its_page_and_line() {
        let root = folder("fault", "one\n#nothing");
        let fault = set(&root, "main.typ", &[]).err().unwrap();
        assert!(fault.contains("main.typ:2: unknown variable: nothing"), "{fault}");
        std::fs::remove_dir_all(root).unwrap();
    }

    #[test]
    fn a_font_that_is_missing_is_a_fault() {
        let root = folder("font", "#set text(font: \"No Such Font\")\none");
        assert!(set(&root, "main.typ", &[]).is_err());
        std::fs::remove_dir_all(root).unwrap();
    }
}
