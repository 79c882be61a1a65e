//! The study's part of the page: origin of the data, what is not up to date, and the inflated tails in three dimensions.

use std::collections::{BTreeMap, BTreeSet};

use diagnostics::Result;
use publish::outdated;
use publish::page::{Body, Surface};
use publish::page_file::Contents;
use si::{MILLIBAR, Point3};
use sysid::surfaces::{Bounds, Surfaces};
use workflow::needs::{RecordReader, id};
use workflow::record::Record;
use workflow::runner::{Goal, Store};

use crate::{Runner, live};
use records::subject::Specimen;
use records::{Inflation, Mesh};

/// Above this number of faces, curved faces are drawn flat: drawing them one by one is too slow.
const MAX_FACES: usize = 24_000;

/// Note and bodies.
///
/// # Errors
/// A [`diagnostics::Diagnostic`] when a record is not what this version writes.
pub(crate) fn page_contents(runner: &Runner) -> Result<Contents> {
    let outdated = outdated::records(runner, &Goal::default())?;
    let note = outdated::in_words(&outdated).map_or_else(String::new, |words| format!(" {words}."));
    Ok(Contents {
        note: origin_of_data(runner) + &note,
        bodies: inflated_bodies(runner)?,
        tails: live::live_tails(runner)?,
    })
}

/// The specimens and the origin of their data.
fn origin_of_data(runner: &Runner) -> String {
    let specimens = &runner.universe.specimens;
    let names: Vec<&str> = specimens.iter().map(|s| s.card.name.as_str()).collect();
    let of_bench = |s: &&Specimen| s.card.origin == lab::card::Origin::VirtualBench;
    let origin = match specimens.iter().filter(of_bench).count() {
        0 => "",
        n if n == names.len() => " All data are from the virtual bench; nothing was measured.",
        _ => " Some of the data are from the virtual bench.",
    };
    format!("Specimens: {}; profile: {}.{origin}", names.join(", "), runner.profile.name())
}

/// The tails that have been inflated.
fn inflated_bodies(runner: &Runner) -> Result<Vec<Body>> {
    let store = Store::new(&runner.folders);
    let mut bodies = Vec::new();
    for specimen in &runner.universe.specimens {
        let files = (store.files(&id::<Mesh>(specimen)), store.files(&id::<Inflation>(specimen)));
        let (Ok(mesh), Ok(inflation)) = files else { continue };
        bodies.push(inflated_body(&specimen.card.name, &Mesh::from_files(&mesh)?, &Inflation::from_files(&inflation)?));
    }
    Ok(bodies)
}

/// A specimen's skin at rest and in every shape.
fn inflated_body(name: &str, mesh: &Mesh, inflation: &Inflation) -> Body {
    let fine = Surfaces::fine_triangles(&mesh.solid);
    let count = fine.values().map(Vec::len).sum::<usize>();
    let faces = if count > MAX_FACES { Surfaces::coarse_triangles(&mesh.solid) } else { fine };
    let moved_nodes: BTreeSet<u32> = inflation.nodes.iter().copied().collect();
    let moves = |f: &&[u32; 3]| f.iter().all(|n| moved_nodes.contains(n));
    let faces: Vec<(Bounds, Vec<[u32; 3]>)> =
        faces.iter().map(|(bounds, triangles)| (*bounds, triangles.iter().filter(moves).copied().collect())).collect();
    let used_nodes: BTreeSet<u32> =
        faces.iter().flat_map(|(_, triangles)| triangles.iter().flatten().copied()).collect();
    let index_of_node: BTreeMap<u32, u32> = used_nodes.iter().enumerate().map(|(i, &n)| (n, i as u32)).collect();
    let numbered = |triangles: Vec<[u32; 3]>| triangles.into_iter().map(|f| f.map(|n| index_of_node[&n])).collect();
    let pick = |nodes: &[Point3]| used_nodes.iter().map(|&n| nodes[n as usize]).collect::<Vec<Point3>>();
    let shapes = inflation.shapes.iter().map(|s| pick(&inflation.moved(mesh, s)));
    let surface = |(bounds, triangles): (Bounds, Vec<[u32; 3]>)| Surface {
        colour: bounds.colour(),
        inside: bounds.is_cut() || matches!(bounds, Bounds::Chamber(_)),
        faces: numbered(triangles),
    };
    Body {
        name: name.into(),
        half: mesh.solid.half,
        levels: std::iter::once(0.0).chain(inflation.shapes.iter().map(|s| s.pressure() / MILLIBAR)).collect(),
        points: std::iter::once(pick(&mesh.solid.nodes)).chain(shapes).collect(),
        surfaces: faces.into_iter().map(surface).collect(),
    }
}
