//! Solid: the mesh that a case names, in the order that it asks for, with what its regions and chambers are.
//!
//! Stands on: `case`, shape. Never knows: a material, a load.

use std::path::{Path, PathBuf};

use shape::foreign::{self, Draft, Malformed, Region};
use shape::{Cavity, Solid, Surface};

use crate::case::{Case, Order, Source};
use crate::fault::{Fault, Outcome};

/// What is said of surfaces whose half would do.
const HALF: &str = "the surfaces are symmetric about z = 0: where clamps and loads are so too, their half z ≥ 0 would do (half = true)";

/// A mesh with names.
pub(crate) struct Loaded {
    pub solid: Solid,
    /// By region.
    pub regions: Vec<Region>,
    /// By chamber.
    pub cavities: Vec<Cavity>,
    pub notes: Vec<String>,
}

/// The mesh of a case that lies in `folder`.
///
/// # Errors
/// A [`Fault`] that names the file, and the line, element or node in it.
pub(crate) fn load(case: &Case, folder: &Path) -> Outcome<Loaded> {
    let mesh = &case.mesh;
    let mut loaded = match &mesh.file {
        Some(file) => from_file(mesh, &folder.join(file))?,
        None => from_surfaces(mesh, folder)?,
    };
    loaded.solid = match mesh.order {
        Some(Order::Linear) => Solid::Linear(loaded.solid.lowered()),
        Some(Order::Quadratic) => Solid::Quadratic(loaded.solid.raised()),
        None => loaded.solid,
    };
    loaded.cavities = shape::cavities(&loaded.solid);
    Ok(loaded)
}

fn from_file(mesh: &Source, path: &Path) -> Outcome<Loaded> {
    let draft = draft(path)?.map_err(|fault| named(path, &fault))?;
    let found = draft.check(mesh.unit.metres(), mesh.half).map_err(|fault| named(path, &fault))?;
    Ok(Loaded { solid: found.solid, regions: found.regions, cavities: found.cavities, notes: found.notes })
}

fn draft(path: &Path) -> Outcome<Result<Draft, Malformed>> {
    let bytes = bytes(path)?;
    match path.extension().and_then(|word| word.to_str()) {
        Some("msh") => Ok(foreign::gmsh(&bytes)),
        Some("vtu") => Ok(foreign::vtu(&bytes)),
        Some("mesh") => Ok(foreign::medit(&bytes)),
        Some("ele") => Ok(foreign::tetgen(&self::bytes(&path.with_extension("node"))?, &bytes)),
        other => Err(Fault::new(
            format!("{} is of an unknown kind (.{})", path.display(), other.unwrap_or_default()),
            "meshes are read from .msh, .vtu, .mesh and .ele",
            "save the mesh in one of these formats",
        )),
    }
}

fn from_surfaces(mesh: &Source, folder: &Path) -> Outcome<Loaded> {
    let surface = |name: &str| -> Outcome<Surface> {
        let path = folder.join(name);
        shape::stl::read(&bytes(&path)?, mesh.unit.metres()).map_err(|fault| named(&path, &fault))
    };
    let body = surface(mesh.body.as_deref().unwrap_or_default())?;
    let spine = mesh.spine.as_deref().map(surface).transpose()?;
    let edge = mesh.edge.unwrap_or_default();
    let meshed = |use_symmetry: bool| {
        let set = shape::Settings { use_symmetry, ..shape::Settings::new(edge) };
        let made = match &spine {
            Some(spine) => shape::mesh(&body, spine, &set),
            None => shape::mesh_alone(&body, &set),
        };
        made.map(|(mesh, _)| mesh).map_err(Fault::from_tool)
    };
    let mut linear = meshed(true)?;
    let mut notes = Vec::new();
    if mesh.half && !linear.half {
        let why = "the surfaces are not symmetric about z = 0";
        return Err(Fault::new("no half model can be made", why, "set half = false, or move the surfaces"));
    }
    if linear.half && !mesh.half {
        notes.push(HALF.to_owned());
        linear = meshed(false)?;
    }
    let region = |(tag, name): (u16, &str)| Region {
        tag: tag.into(),
        name: Some(name.to_owned()),
        elements: linear.regions.iter().filter(|region| **region == tag).count(),
        volume: linear.region_volume(tag),
    };
    let parts = [(shape::BODY, "body"), (shape::SPINE, "spine")];
    let regions = parts.into_iter().take(1 + usize::from(spine.is_some())).map(region).collect();
    let solid = Solid::Quadratic(Solid::Linear(linear).raised());
    Ok(Loaded { solid, regions, cavities: Vec::new(), notes })
}

fn bytes(path: &Path) -> Outcome<Vec<u8>> {
    std::fs::read(path).map_err(|e| {
        let what = format!("{} cannot be read", path.display());
        Fault::new(what, e.to_string().to_lowercase(), "name a file that lies beside the case, or below its folder")
    })
}

fn named(path: &Path, fault: &dyn std::fmt::Display) -> Fault {
    let path: PathBuf = path.components().collect();
    Fault::from_tool(format!("{}: {fault}", path.display()))
}
