//! The choice of elements for a body that is given by its surfaces.

use serde::{Deserialize, Serialize};

use crate::quality::dihedral_quantile;
use crate::{
    Assembly, Curving, Grading, MeshError, Method, QuadraticMesh, Report, Settings, Surface, mesh, mesh_general,
    mesh_in_hexahedra, mesh_without_sheet, quadratic,
};

/// Columns whose volumes differ by more from the surfaces' give way to the general method, which follows round sides more closely.
const AUTO_VOLUME: f64 = 5e-3;

/// So do those with a smaller angle in any element, and in more than one of a thousand, degrees: a solver takes them, but at the price of its
/// conditioning.
// Columns of the study's tails have 1.4° and more; where layers part at a round side, 0.01°.
const AUTO_ANGLE: f64 = 1.0;
const AUTO_USUAL_ANGLE: f64 = 5.0;
/// And those farther from the surfaces than this part of an edge.
// Round sides of some edges are 0.05 off; the tip of a notch that no column meets, 0.15.
const AUTO_DISTANCE: f64 = 0.1;

/// Elements of second order that a body is meshed in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ElementChoice {
    /// Tetrahedra with edges of one length.
    Tetrahedra,
    /// Hexahedra where rows and levels divide the body, tetrahedra elsewhere.
    HexahedraWherePossible(Grading),
    /// Hexahedra or an error.
    Hexahedra(Grading),
}

/// The same choice as settings and cases name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ElementName {
    /// With edges of one length.
    #[default]
    Tetrahedra,
    /// Hexahedra sized by the thinnest wall where rows and levels divide the body, tetrahedra elsewhere.
    Auto,
    /// The same, or an error.
    Hexahedra,
}

impl ElementName {
    /// With a grading of hexahedra.
    pub fn graded(self, grading: Grading) -> ElementChoice {
        match self {
            Self::Tetrahedra => ElementChoice::Tetrahedra,
            Self::Auto => ElementChoice::HexahedraWherePossible(grading),
            Self::Hexahedra => ElementChoice::Hexahedra(grading),
        }
    }
}

/// A body meshed, its report, and what was refused before.
#[derive(Debug, Clone, PartialEq)]
pub struct Chosen {
    /// The mesh.
    pub solid: QuadraticMesh,
    /// Its report.
    pub report: Report,
    /// The middles that the general method moved onto the surfaces.
    pub curving: Option<Curving>,
    /// Why it is not in hexahedra where they were wished for.
    pub not_hexahedra: Option<MeshError>,
    /// Why it is not in columns where they were tried first.
    pub not_columns: Option<MeshError>,
}

/// Meshes a body with its sheet, if it has one, in the elements of choice and by the method of the settings.
///
/// # Errors
/// [`MeshError`] of the surfaces; of hexahedra where there is no other choice.
pub fn mesh_chosen(
    body: &Surface,
    spine: Option<&Surface>,
    set: &Settings,
    choice: ElementChoice,
) -> Result<Chosen, MeshError> {
    let not_hexahedra = match hexahedra_of_choice(body, spine, set, choice) {
        Some(Ok((solid, report))) => {
            let (curving, not_hexahedra, not_columns) = (None, None, None);
            return Ok(Chosen { solid, report, curving, not_hexahedra, not_columns });
        }
        Some(Err(why)) if matches!(choice, ElementChoice::Hexahedra(_)) => return Err(why),
        Some(Err(why)) => Some(why),
        None => None,
    };
    let chosen = mesh_assembly(&Assembly::of_body(body, spine), set, &|_| ())?;
    Ok(Chosen { not_hexahedra, ..chosen })
}

/// Hexahedra, or why there are none; nothing where tetrahedra are asked for.
fn hexahedra_of_choice(
    body: &Surface,
    spine: Option<&Surface>,
    set: &Settings,
    choice: ElementChoice,
) -> Option<Result<(QuadraticMesh, Report), MeshError>> {
    match choice {
        ElementChoice::Tetrahedra => None,
        ElementChoice::Hexahedra(grading) => Some(mesh_in_hexahedra(body, spine, set, &grading)),
        // Tetrahedra may follow the body more closely. Volumes do not decide: they are those of straight parts, 0.6 % off where the curved sides are
        // 0.1 % off.
        ElementChoice::HexahedraWherePossible(grading) => {
            Some(mesh_in_hexahedra(body, spine, set, &grading).and_then(|made| refuse_far(made, set)))
        }
    }
}

/// Meshes a body with inserts and cavities in tetrahedra, by the method of the settings. `watch` hears of each step.
///
/// # Errors
/// [`MeshError`] of the surfaces, which names the part and the place.
pub fn mesh_assembly(assembly: &Assembly, set: &Settings, watch: &dyn Fn(&str)) -> Result<Chosen, MeshError> {
    match set.method {
        Method::Columns if !set.detail.is_usual() => Err(MeshError::Detail),
        Method::Columns => mesh_columns(assembly, set),
        Method::Auto if !set.detail.is_usual() => {
            Ok(Chosen { not_columns: Some(MeshError::Detail), ..mesh_anything(assembly, set, watch)? })
        }
        Method::General => mesh_anything(assembly, set, watch),
        Method::Auto => mesh_either(assembly, set, watch),
    }
}

/// In columns where they follow the body well, or by half; else by the general method, which meshes whole bodies alone.
fn mesh_either(assembly: &Assembly, set: &Settings, watch: &dyn Fn(&str)) -> Result<Chosen, MeshError> {
    // A limit closer than the columns' own: those of a round bellows were 0.53 % short of its volume and passed theirs
    // of 2 %.
    let close = Settings { volume_limit: set.volume_limit.min(AUTO_VOLUME), ..*set };
    let why = match mesh_columns(assembly, &close).and_then(|chosen| refuse_poor(chosen, set)) {
        Ok(chosen) => return Ok(chosen),
        // the general method would take as much
        Err(why @ (MeshError::TooLarge { .. } | MeshError::Settings { .. })) => return Err(why),
        Err(why) => why,
    };
    // half the unknowns are worth columns by their own limits
    if let Some(half) = set.use_symmetry.then(|| mesh_columns(assembly, set)).and_then(Result::ok)
        && half.solid.half
    {
        return Ok(half);
    }
    watch("no columns: the general method");
    Ok(Chosen { not_columns: Some(why), ..mesh_anything(assembly, set, watch)? })
}

/// A mesh as it is, unless the general method is there and follows the body more closely.
fn refuse_far(made: (QuadraticMesh, Report), set: &Settings) -> Result<(QuadraticMesh, Report), MeshError> {
    let (distance, limit) = (made.1.hausdorff_m, AUTO_DISTANCE * set.edge);
    if set.method == Method::Auto && distance > limit { Err(MeshError::Far { distance, limit }) } else { Ok(made) }
}

/// Columns as they are, unless their elements or their distance from the body are worse than the general method's.
fn refuse_poor(chosen: Chosen, set: &Settings) -> Result<Chosen, MeshError> {
    let min_dihedral_deg = chosen.report.min_dihedral_deg;
    if min_dihedral_deg < AUTO_ANGLE {
        return Err(MeshError::Slivers { degrees: min_dihedral_deg, limit: AUTO_ANGLE });
    }
    // Layers beside a sheet are flat on purpose, and bend alike at a third of the time; one contract for every body that
    // is meshed is worth more, and who wants columns asks for them.
    let usual_angle = dihedral_quantile(&chosen.solid.clone().into_corners(), 1e-3);
    if usual_angle < AUTO_USUAL_ANGLE {
        return Err(MeshError::Slivers { degrees: usual_angle, limit: AUTO_USUAL_ANGLE });
    }
    let Chosen { solid, report, curving, not_hexahedra, not_columns } = chosen;
    let (solid, report) = refuse_far((solid, report), set)?;
    Ok(Chosen { solid, report, curving, not_hexahedra, not_columns })
}

fn mesh_anything(assembly: &Assembly, set: &Settings, watch: &dyn Fn(&str)) -> Result<Chosen, MeshError> {
    let (solid, report, curving) = mesh_general(assembly, set, watch)?;
    Ok(Chosen { solid, report, curving: Some(curving), not_hexahedra: None, not_columns: None })
}

fn mesh_columns(assembly: &Assembly, set: &Settings) -> Result<Chosen, MeshError> {
    let (linear, report) = match (assembly.inserts.as_slice(), assembly.cavities.len()) {
        ([], 0) => mesh_without_sheet(assembly.body, set)?,
        ([spine], 0) => mesh(assembly.body, spine, set)?,
        (inserts, cavities) => return Err(MeshError::ManyParts { inserts: inserts.len(), cavities }),
    };
    Ok(Chosen { solid: quadratic(&linear), report, curving: None, not_hexahedra: None, not_columns: None })
}
