//! Surfaces of a case meshed: the choice of elements and of half a body, and what is said about it.

use mesh::{Chosen, ElementName, Grading, Method, QuadraticElements, QuadraticMesh, Settings, Skin, Solid, Surface};
use si::{CubicMetre, MILLIMETRE, Metre};

use crate::case::Source;
use diagnostics::{Diagnostic, Result};

/// The note on symmetric surfaces that could be simulated as a half model.
const HALF: &str = "the surfaces are symmetric about z = 0: where clamps and loads are so too, their half z ≥ 0 would do (half = true)";

/// The surfaces of a case, in metres.
pub(super) struct Surfaces<'a> {
    pub source: &'a Source,
    pub body: &'a Surface,
    pub spine: Option<&'a Surface>,
}

impl Surfaces<'_> {
    /// The mesh, and notes for the user.
    ///
    /// # Errors
    /// A [`Diagnostic`] that names the files.
    pub fn solid(&self) -> Result<(Solid, Vec<String>)> {
        let (mut chosen, mut notes) = self.meshed(true)?;
        let half = self.source.half;
        if half && !chosen.solid.half {
            let reason = match &chosen.not_columns {
                None if self.source.method != Method::General => "the surfaces are not symmetric about z = 0",
                _ => "the general method meshes whole bodies alone",
            };
            return Err(Diagnostic::new("no half model can be made", reason, "set half = false, or move the surfaces"));
        }
        if chosen.solid.half && !half {
            (chosen, notes) = self.meshed(false)?;
            notes.insert(0, HALF.to_owned());
        }
        notes.extend(chosen.report.repairs.iter().cloned());
        notes.push(mesh_text(&chosen.solid));
        let refusals =
            [("tetrahedra, not hexahedra", chosen.not_hexahedra), ("general, not in columns", chosen.not_columns)];
        let refusals = refusals.into_iter().filter_map(|(instead, why)| Some((instead, why?)));
        notes.extend(refusals.map(|(instead, why)| format!("{instead}: {}", Diagnostic::from(why).what)));
        Ok((Solid::Quadratic(chosen.solid), notes))
    }

    /// In the elements of the case; where it does not say which, in hexahedra that suit the body. With a note where they do not.
    fn meshed(&self, use_symmetry: bool) -> Result<(Chosen, Vec<String>)> {
        let chosen = self.meshed_in(self.source.chosen_elements(), use_symmetry)?;
        let unsuited = self.unsuited_hexahedra(&chosen.solid).filter(|_| self.source.elements.is_none());
        let Some(reason) = unsuited else { return Ok((chosen, Vec::new())) };
        let tetrahedral = self.meshed_in(ElementName::Tetrahedra, use_symmetry)?;
        Ok((tetrahedral, vec![format!("tetrahedra, not hexahedra: {reason}")]))
    }

    fn meshed_in(&self, elements: ElementName, use_symmetry: bool) -> Result<Chosen> {
        let source = self.source;
        let settings = Settings { method: source.method, detail: source.detail, ..Settings::new(self.edge()) };
        let settings = Settings { use_symmetry, ..settings };
        let files: Vec<&str> = source.body.iter().chain(&source.spine).map(String::as_str).collect();
        let choice = elements.graded(Grading::COARSE.finer(source.finer));
        mesh::mesh_chosen(self.body, self.spine, &settings, choice)
            .map_err(|e| Diagnostic::from(e).while_doing(files.join(" with ")))
    }

    fn edge(&self) -> Metre {
        self.source.edge.unwrap_or_default() / self.source.finer
    }

    /// Why hexahedra, which are sized by the walls of chambers, are none of the edge that is asked for.
    fn unsuited_hexahedra(&self, solid: &QuadraticMesh) -> Option<String> {
        let QuadraticElements::Hexahedra(hexahedra) = &solid.elements else { return None };
        if !solid.skin.iter().any(|face| matches!(face.on, Skin::Chamber(_))) {
            return Some("it has no chamber whose wall would size them".to_owned());
        }
        let parts = solid.clone().into_corners();
        let volume: CubicMetre = (0..parts.tets.len()).map(|part| parts.volume(part)).sum();
        let length = (volume / hexahedra.len() as f64).cbrt();
        let text = || {
            let millimetres = length / MILLIMETRE;
            format!("sized by the walls they would be longer than mesh.edge, {millimetres:.1} mm in the mean")
        };
        (length > self.edge()).then(text)
    }
}

/// How many elements of which kind, and what they are sized by.
fn mesh_text(solid: &QuadraticMesh) -> String {
    let elements = &solid.elements;
    let size = match elements {
        QuadraticElements::Hexahedra(_) => {
            "sized by the thinnest wall (tails with thin walls bend within 4 % of finer ones)"
        }
        QuadraticElements::Tetrahedra(_) => "with edges of mesh.edge",
    };
    format!("meshed in {} {} of second order, {size}", elements.len(), elements.name())
}
