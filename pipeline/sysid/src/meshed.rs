//! The mesh of a specimen with one region a solid, the softest first: from STL files, or from a file of another mesher.

use std::path::Path;

use diagnostics::{Diagnostic, Result};
use lab::card;
use mesh::foreign::{self, NamedSurface, Region};
use mesh::{Cavity, ElementChoice, QuadraticMesh, Settings, Solid, Spot, Surface, quality};
use serde::Serialize;
use si::{Metre, Point3};

/// A solid of the card and its region in the mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedRegion {
    /// The solid's name.
    pub solid: String,
    /// The name or the tag of its region in a mesh file.
    pub region: String,
}

/// A mesh and its quality.
#[derive(Debug, Clone, PartialEq)]
pub struct Meshed {
    /// Regions in the order of the solids.
    pub solid: QuadraticMesh,
    /// The surfaces that the mesh file names or numbers.
    pub surfaces: Vec<NamedSurface>,
    /// By chamber of the skin.
    pub cavities: Vec<Cavity>,
    /// Smallest angle between two faces of an element, degrees.
    pub min_dihedral_deg: f64,
    /// Largest distance between the surfaces and the mesh, m; 0 of a mesh file.
    pub hausdorff_m: Metre,
    /// Volume of each solid in the mesh over its volume in the STL files, less one; empty of a mesh file.
    pub volume_error: Vec<f64>,
    /// Why a body of surfaces is not in hexahedra, or not in columns, where these were tried first.
    pub not_hexahedra: Option<String>,
}

impl NamedRegion {
    /// Of every solid on a card.
    pub fn all(solids: &card::Solids) -> Vec<Self> {
        let region = |s: &card::Part| Self { solid: s.name.clone(), region: s.region().to_owned() };
        solids.parts.iter().map(region).collect()
    }
}

impl Meshed {
    /// From the surface of a body, and of the plane sheet in it where there is one.
    ///
    /// # Errors
    /// A [`Diagnostic`] when they cannot be meshed.
    pub fn of_surfaces(
        (body, spine): (&Surface, Option<&Surface>),
        settings: &Settings,
        elements: ElementChoice,
        order: &[NamedRegion],
    ) -> Result<Self> {
        let mesh::Chosen { mut solid, report, not_hexahedra, not_columns, .. } =
            mesh::mesh_chosen(body, spine, settings, elements)?;
        let number = |name: &str| order.iter().position(|region| region.solid == name).unwrap_or(0) as u16;
        let region_numbers = [number(card::BODY), number(card::SPINE)];
        solid.regions.iter_mut().for_each(|region| *region = region_numbers[usize::from(*region)]);
        let error = |mesh: f64, stl: f64| mesh / stl - 1.0;
        let body = error(report.volume_body, report.volume_body_stl);
        let sheet = spine.map(|_| error(report.volume_spine, report.volume_spine_stl));
        Ok(Self {
            cavities: mesh::cavities(&Solid::Quadratic(solid.clone())),
            solid,
            surfaces: Vec::new(),
            min_dihedral_deg: report.min_dihedral_deg,
            hausdorff_m: report.hausdorff_m,
            volume_error: std::iter::once(body).chain(sheet).collect(),
            not_hexahedra: not_hexahedra.or(not_columns).map(|refusal| Diagnostic::from(refusal).to_string()),
        })
    }

    /// From the `bytes` of a mesh file, and of the file of its nodes where it has one, in a `unit` (m).
    ///
    /// # Errors
    /// A [`Diagnostic`] when the file or the mesh in it is defective, or its regions are not those of the card.
    pub fn of_file(
        file: &Path,
        (bytes, nodes): (&[u8], Option<&[u8]>),
        unit: Metre,
        solids: &[NamedRegion],
    ) -> Result<Self> {
        let checked = foreign::read(file, bytes, nodes)?.check(unit, false)?;
        let numbers = solid_numbers(&checked.regions, solids)?;
        let linear = checked.solid.clone().to_linear();
        let mut solid = checked.solid.to_quadratic();
        solid.regions.iter_mut().for_each(|region| *region = numbers[usize::from(*region)]);
        Ok(Self {
            cavities: checked.cavities,
            solid,
            surfaces: checked.surfaces,
            min_dihedral_deg: quality::dihedral_range(&linear).0,
            hausdorff_m: 0.0,
            volume_error: Vec::new(),
            not_hexahedra: None,
        })
    }
}

impl Meshed {
    /// The skin index of the chamber `name`, which holds `point` (m).
    ///
    /// # Errors
    /// A [`Diagnostic`] with the centres of all cavities, when none holds the point.
    pub fn chamber(&self, name: &str, point: Point3) -> Result<u16> {
        let centres = || self.cavities.iter().map(|c| format_millimetres(c.centroid)).collect::<Vec<_>>().join("; ");
        mesh::chamber_at(&self.solid, point).ok_or_else(|| {
            Diagnostic::new(
                format!("chamber `{name}` is not where the card says, at {}", format_millimetres(point)),
                format!("the body has {} closed cavities and none holds that point", self.cavities.len()),
                format!("give a point inside one; their centres are {}", centres()),
            )
        })
    }

    /// Markers, by name, place (m) and diameter (m), as means over their discs, and the largest distance of one from the skin, m.
    ///
    /// # Errors
    /// A [`Diagnostic`] when one lies farther from the skin than `limit` (m).
    pub fn markers<'a>(
        &self,
        markers: impl Iterator<Item = (&'a str, Point3, Option<Metre>)>,
        limit: Metre,
    ) -> Result<(Vec<Spot>, Metre)> {
        let (mut spots, mut worst) = (Vec::new(), 0.0_f64);
        for (name, position, diameter) in markers {
            let (spot, distance) = mesh::embed_mark(&self.solid, position, diameter);
            if distance > limit {
                return Err(Diagnostic::new(
                    format!("marker `{name}` at {} is not on the skin", format_millimetres(position)),
                    format!(
                        "it lies {:.2} mm off; the limit is {:.2} mm (study.toml, [mesh] marker_distance_limit)",
                        1e3 * distance,
                        1e3 * limit
                    ),
                    "correct its place on the card: metres, in the frame of the STL files",
                ));
            }
            spots.push(spot);
            worst = worst.max(distance);
        }
        Ok((spots, worst))
    }

    /// The nodes of a surface that a clamp names.
    ///
    /// # Errors
    /// A [`Diagnostic`] with the surfaces that there are, when it is none of them or no face of the body lies on it.
    pub fn clamped(&self, surface: &str) -> Result<Vec<u32>> {
        let named = foreign::surface(&self.surfaces, surface)?;
        let nodes = named.nodes(self.solid.elements.iter());
        if nodes.is_empty() {
            let message = format!("the surface `{surface}` has no face of the body");
            let action = "make the faces of the body that are clamped a physical surface, and save the mesh again";
            return Err(Diagnostic::new(message, "none of its triangles is a side of an element", action));
        }
        Ok(nodes)
    }
}

fn format_millimetres(point: Point3) -> String {
    format!("({:.2}, {:.2}, {:.2}) mm", 1e3 * point[0], 1e3 * point[1], 1e3 * point[2])
}

/// The place of each region of a file among the solids, of which each must have one.
fn solid_numbers(regions: &[Region], solids: &[NamedRegion]) -> Result<Vec<u16>> {
    let called = |region: &Region, word: &str| region.name.as_deref() == Some(word) || region.tag.to_string() == word;
    let region_names = || regions.iter().map(region_label).collect::<Vec<_>>().join(", ");
    for solid in solids {
        if !regions.iter().any(|region| called(region, &solid.region)) {
            let message = format!("the mesh has no region `{}` for solid.{}", solid.region, solid.solid);
            return Err(Diagnostic::new(
                message,
                format!("its regions are {}", region_names()),
                "correct region of the solid on the card",
            ));
        }
    }
    let solid_number = |region: &Region| {
        let mine: Vec<usize> = (0..solids.len()).filter(|&k| called(region, &solids[k].region)).collect();
        match mine.as_slice() {
            [solid] => Ok(*solid as u16),
            several => Err(Diagnostic::new(
                format!("{} solids on the card belong to region {} of the mesh", several.len(), region_label(region)),
                format!("every region has one material; its regions are {}", region_names()),
                "give each region one [solid.NAME] with region = its name or tag",
            )),
        }
    };
    regions.iter().map(solid_number).collect()
}

/// A region as the file calls it.
fn region_label(region: &Region) -> String {
    match &region.name {
        Some(name) => format!("`{name}` ({})", region.tag),
        None => region.tag.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn region(tag: i64, name: Option<&str>) -> Region {
        Region { tag, name: name.map(str::to_owned), elements: 1, volume: 1e-6 }
    }

    fn solid(name: &str, region: &str) -> NamedRegion {
        NamedRegion { solid: name.into(), region: region.into() }
    }

    #[test]
    fn regions_are_found_by_name_or_tag_in_the_order_of_the_solids() {
        let regions = [region(3, Some("plate")), region(7, None)];
        assert_eq!(solid_numbers(&regions, &[solid("rubber", "7"), solid("sheet", "plate")]).unwrap(), [1, 0]);
    }

    #[test]
    fn a_region_without_a_solid_and_a_solid_without_a_region_are_refused() {
        let regions = [region(3, Some("plate")), region(7, None)];
        let one = solid_numbers(&regions, &[solid("sheet", "plate")]).unwrap_err();
        assert!(one.what.contains("0 solids on the card belong to region 7"), "{one}");
        let other = solid_numbers(&regions, &[solid("sheet", "plate"), solid("rubber", "9")]).unwrap_err();
        assert!(other.what.contains("no region `9`") && other.why.contains("`plate` (3), 7"), "{other}");
    }
}
