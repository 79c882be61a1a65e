//! Targets of the fuzzer: every reader of files from outside, and of files that are written and read back, as a function of bytes.
//!
//! A target may refuse its input, but must not panic, hang or take memory without bound; a refusal must name the file. The seeds under
//! `seeds/TARGET` are small inputs, whole and broken, that `tests/seeds.rs` replays in every test run. `just fuzz TARGET SECONDS`
//! searches for more.
//!
//! Depends on the crates whose readers it calls.

use std::fmt::Display;
use std::path::Path;

use diagnostics::Diagnostic;
use mesh::foreign::{self, MeshFileError, RawMesh};
use optimize::network::Network;
use sysid::free_vibration::Page;
use sysid::{IdentifiedMaterials, inflation_test};
use track::Gray;
use track::board::any::any_board;
use track::board::charuco::Dictionary;
use track::board::{Target as Board, TargetKind};
use track::lens::opencv;
use track::video::Film;
use twin::Twin;

#[cfg(feature = "records")]
mod records;

/// One reader.
pub struct Target {
    /// Its name, and that of the folder of its seeds.
    pub name: &'static str,
    /// Feeds it with bytes.
    pub run: fn(&[u8]),
}

/// Every reader.
pub const TARGETS: &[Target] = &[
    Target { name: "mp4", run: mp4 },
    Target { name: "stl", run: stl },
    Target { name: "stl_pair", run: stl_pair },
    Target { name: "gmsh", run: |bytes| checked(foreign::gmsh(bytes)) },
    Target { name: "vtu", run: |bytes| checked(foreign::vtu(bytes)) },
    Target { name: "vtk", run: |bytes| checked(foreign::vtk(bytes)) },
    Target { name: "medit", run: |bytes| checked(foreign::medit(bytes)) },
    Target { name: "tetgen", run: tetgen },
    Target { name: "c3d", run: |bytes| named(lab::space::read(bytes, Path::new("input.c3d")), "input.c3d") },
    Target {
        name: "pressure",
        run: |bytes| {
            text(bytes, |t| named(lab::pressure::parse(t, Path::new(FILE), &["left".into(), "right".into()]), FILE))
        },
    },
    Target { name: "force", run: |bytes| text(bytes, |t| named(lab::force::parse(t, Path::new(FILE)), FILE)) },
    Target { name: "table", run: |bytes| text(bytes, |t| drop(lab::log::table::RawTable::new(t))) },
    Target { name: "board", run: board },
    Target { name: "card", run: |bytes| text(bytes, |t| named(lab::card::parse(t, Path::new(FILE)), FILE)) },
    Target { name: "case", run: |bytes| text(bytes, |t| named(simulate::case::parse(t, Path::new(FILE)), FILE)) },
    Target { name: "twin", run: twin },
    Target { name: "network", run: |bytes| in_file(Network::from_safetensors(bytes)) },
    Target {
        name: "camera",
        run: |bytes| text(bytes, |t| [false, true].iter().for_each(|fisheye| in_file(opencv::read(t, *fisheye)))),
    },
    #[cfg(feature = "records")]
    Target { name: "reduced", run: records::reduced },
    #[cfg(feature = "records")]
    Target { name: "record", run: records::scalars },
    Target { name: "page", run: |bytes| text(bytes, |t| named(Page::parse(t, Path::new(FILE)), FILE)) },
    Target {
        name: "inflation_page",
        run: |bytes| text(bytes, |t| named(inflation_test::Page::parse(t, Path::new(FILE)), FILE)),
    },
    Target {
        name: "force_page",
        run: |bytes| text(bytes, |t| named(instruments::force::check_page(t, Path::new(FILE)), FILE)),
    },
    Target {
        name: "materials",
        run: |bytes| text(bytes, |t| named(IdentifiedMaterials::parse(t, Path::new(FILE)), FILE)),
    },
    #[cfg(feature = "records")]
    Target { name: "settings", run: |bytes| text(bytes, records::settings) },
];

/// A picture of as many columns as its first byte says beside 60, in which every kind of board is looked for.
fn board(bytes: &[u8]) {
    let Some((first, levels)) = bytes.split_first() else { return };
    let width = 60 + usize::from(*first);
    let height = levels.len() / width;
    let picture = Gray { width, height, pixels: levels[..width * height].to_vec() };
    drop(any_board(&picture));
    let dictionary = Dictionary::opencv(4, 50);
    let kinds = [
        TargetKind::Checkerboard,
        TargetKind::Dots,
        TargetKind::AsymmetricDots,
        TargetKind::charuco(Some(0.03), Some(dictionary)),
    ];
    for kind in kinds {
        let rows = if kind == TargetKind::Checkerboard { 4 } else { 5 };
        drop(Board::new(kind, [7, rows], 0.04).find(&picture));
    }
}

/// The name under which inputs are read.
const FILE: &str = "input";
/// Separates the two files of TetGen in one input.
const BETWEEN: u8 = 0;
/// Frames that are decoded: the decoder is not the reader under test.
const FRAMES: usize = 3;

/// The target of this name.
pub fn target(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}

fn text(bytes: &[u8], read: impl FnOnce(&str)) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        read(text);
    }
}

/// Holds that a refusal names the file and what to do.
fn named<T>(read: Result<T, impl Display>, file: &str) {
    if let Err(refusal) = read {
        let message = refusal.to_string();
        assert!(message.contains(file) && message.contains("do:"), "the refusal does not name {file}: {message}");
    }
}

/// The same of a reader whose caller adds the file.
fn in_file<T>(read: Result<T, impl std::error::Error + Send + Sync + 'static>) {
    named(read.map_err(|refusal| Diagnostic::from(refusal).in_file(Path::new(FILE))), FILE);
}

/// A tail that is read can be laid out and written again, to the same arrays.
fn twin(bytes: &[u8]) {
    match twin::file::parse(bytes, Path::new(FILE)) {
        Ok(data) => {
            let again = twin::file::bytes(&data).and_then(|bytes| twin::file::parse(&bytes, Path::new(FILE)));
            assert!(again.is_ok_and(|again| again == data), "the tail is not the one that was read");
            assert!(Twin::new(data).is_ok(), "the tail was read and cannot be laid out");
        }
        Err(refusal) => named::<()>(Err(refusal), FILE),
    }
}

/// A mesh that is read is also checked, as every caller does.
fn checked(read: Result<RawMesh, MeshFileError>) {
    if let Ok(raw) = read {
        drop(raw.clone().check_hexahedra(1.0, false));
        drop(raw.check(1.0, false));
    }
}

fn tetgen(bytes: &[u8]) {
    let middle = bytes.iter().position(|byte| *byte == BETWEEN).unwrap_or(bytes.len());
    checked(foreign::tetgen(&bytes[..middle], bytes.get(middle + 1..).unwrap_or_default()));
}

/// A body and an insert, parted by the first `|` line: meshed by the general method when both are small.
fn stl_pair(bytes: &[u8]) {
    const PARTED: &[u8] = b"\n|\n";
    let cut = bytes.windows(PARTED.len()).position(|window| window == PARTED);
    let (first, second) = cut.map_or((bytes, &[][..]), |at| (&bytes[..at], &bytes[at + PARTED.len()..]));
    let read = |bytes: &[u8]| mesh::stl::read(bytes, 1e-3).ok().filter(|surface| surface.faces.len() < 400);
    let Some(body) = read(first) else { return };
    let insert = read(second);
    // coarse, so that an input takes a fraction of a second
    let edge = body.length().max(insert.as_ref().map_or(0.0, mesh::Surface::length)) / 4.0;
    let set = mesh::Settings { method: mesh::Method::General, ..mesh::Settings::new(edge) };
    let parts = mesh::Assembly { body: &body, inserts: insert.iter().collect(), cavities: Vec::new() };
    if let Ok(chosen) = mesh::mesh_assembly(&parts, &set, &|_| ()) {
        let mesh = chosen.solid.into_corners();
        assert!((0..mesh.tets.len()).all(|tet| mesh.volume(tet) > 0.0), "an element is inverted");
    }
}

fn stl(bytes: &[u8]) {
    if let Ok(surface) = mesh::stl::read(bytes, 1e-3) {
        drop(surface.shells());
    }
}

/// A film is read from a file of its own, since its index is sought in it.
fn mp4(bytes: &[u8]) {
    let path = std::env::temp_dir().join(format!("fuzz-{}-{:?}.mp4", std::process::id(), std::thread::current().id()));
    if std::fs::write(&path, bytes).is_ok() {
        match Film::open(&path) {
            Ok(film) => film.take(FRAMES).for_each(drop),
            Err(refusal) => named::<()>(Err(refusal), "fuzz-"),
        }
    }
    // What could not be written needs not be removed.
    drop(std::fs::remove_file(&path));
}
