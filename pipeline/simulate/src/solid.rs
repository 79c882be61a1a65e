//! The mesh of a case in the requested element order, with the names of its regions and chambers.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use mesh::foreign::{self, NamedSurface, RawMesh, Region};
use mesh::{Cavity, Solid, Surface};

use crate::case::{Case, Order, Source, Unit};
use crate::force_table::{self, ForceTable};
use crate::surfaces::Surfaces;
use diagnostics::{Diagnostic, Result, input};

/// A mesh with names.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The mesh.
    pub solid: Solid,
    /// By region.
    pub regions: Vec<Region>,
    /// The surfaces that the mesh file names or numbers.
    pub surfaces: Vec<NamedSurface>,
    /// By chamber.
    pub cavities: Vec<Cavity>,
    /// For each node of the file its number here, `u32::MAX` where no element uses it; empty where they are not those of a file.
    pub numbering: Vec<u32>,
    /// Warnings for the user.
    pub notes: Vec<String>,
    /// Forces on nodes, by the number of the load that names their file.
    pub tables: BTreeMap<usize, ForceTable>,
}

/// The mesh of a case that lies in `folder`.
///
/// # Errors
/// A [`Diagnostic`] that names the file, and the line, element or node in it.
pub fn load(case: &Case, folder: &Path) -> Result<Loaded> {
    let mesh = &case.mesh;
    let mut loaded = match &mesh.file {
        Some(file) => from_file(mesh, &folder.join(file))?,
        None => from_surfaces(mesh, folder)?,
    };
    let read = loaded.solid.nodes().len();
    if mesh.order == Some(Order::Linear) && loaded.solid.is_hexahedral() {
        let reason = "hexahedra are simulated with 20 nodes";
        return Err(Diagnostic::new("the order linear is not to be had", reason, "leave mesh.order away"));
    }
    loaded.solid = match mesh.order {
        Some(Order::Linear) => Solid::Linear(loaded.solid.to_linear()),
        Some(Order::Quadratic) => Solid::Quadratic(loaded.solid.to_quadratic()),
        None => loaded.solid,
    };
    if loaded.solid.nodes().len() != read {
        // of another order, nodes are numbered anew
        loaded.numbering.clear();
    }
    loaded.cavities = mesh::cavities(&loaded.solid);
    loaded.tables = tables(case, folder)?;
    Ok(loaded)
}

/// The tables of forces that a case in `folder` names, by the number of the load.
///
/// # Errors
/// A [`Diagnostic`] that names the file and the line in it.
pub fn tables(case: &Case, folder: &Path) -> Result<BTreeMap<usize, ForceTable>> {
    let mut tables = BTreeMap::new();
    for (number, load) in case.load.iter().enumerate() {
        if let Some(table) = &load.table {
            tables.insert(number, force_table::read_table(&folder.join(table))?);
        }
    }
    Ok(tables)
}

fn from_file(mesh: &Source, path: &Path) -> Result<Loaded> {
    let checked_mesh =
        raw_mesh(path)?.check(mesh.unit.metres(), mesh.half).map_err(|error| in_named_file(path, error))?;
    Ok(Loaded {
        solid: checked_mesh.solid,
        regions: checked_mesh.regions,
        surfaces: checked_mesh.surfaces,
        cavities: checked_mesh.cavities,
        numbering: checked_mesh.numbering,
        notes: checked_mesh.notes,
        tables: BTreeMap::new(),
    })
}

/// The content of a mesh file, before any check.
///
/// # Errors
/// As [`load`].
pub fn raw_mesh(path: &Path) -> Result<RawMesh> {
    let nodes = foreign::nodes_of(path).map(|nodes| mesh_bytes(&nodes)).transpose()?;
    foreign::read(path, &mesh_bytes(path)?, nodes.as_deref()).map_err(|error| in_named_file(path, error))
}

/// The surface in an STL file whose numbers have a unit.
///
/// # Errors
/// A [`Diagnostic`] that names the file.
pub fn read_surface(path: &Path, unit: Unit) -> Result<Surface> {
    mesh::stl::read(&mesh_bytes(path)?, unit.metres()).map_err(|error| in_named_file(path, error))
}

fn from_surfaces(mesh: &Source, folder: &Path) -> Result<Loaded> {
    let surface = |name: &str| read_surface(&folder.join(name), mesh.unit);
    let body = surface(mesh.body.as_deref().unwrap_or_default())?;
    let spine = mesh.spine.as_deref().map(surface).transpose()?;
    let (solid, notes) = Surfaces { source: mesh, body: &body, spine: spine.as_ref() }.solid()?;
    let regions = named_regions(&solid, spine.is_some());
    let (surfaces, cavities, numbering) = Default::default();
    Ok(Loaded { solid, regions, surfaces, cavities, numbering, notes, tables: BTreeMap::new() })
}

/// The body, and the spine if there is one.
fn named_regions(solid: &Solid, has_spine: bool) -> Vec<Region> {
    let linear = solid.clone().to_linear();
    let region = |(tag, name): (u16, &str)| Region {
        tag: tag.into(),
        name: Some(name.to_owned()),
        elements: solid.regions().iter().filter(|region| **region == tag).count(),
        volume: linear.region_volume(tag),
    };
    let parts = [(mesh::BODY, "body"), (mesh::SPINE, "spine")];
    parts.into_iter().take(1 + usize::from(has_spine)).map(region).collect()
}

fn mesh_bytes(path: &Path) -> Result<Vec<u8>> {
    input::read(path, input::MESH).map_err(|e| {
        let message = format!("{} cannot be read", path.display());
        Diagnostic::new(
            message,
            e.to_string().to_lowercase(),
            "name a file that lies beside the case, or below its folder",
        )
    })
}

fn in_named_file(path: &Path, error: impl std::error::Error + Send + Sync + 'static) -> Diagnostic {
    let path: PathBuf = path.components().collect();
    Diagnostic::from(error).in_file(&path)
}
