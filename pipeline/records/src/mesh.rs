//! Mesh: the specimen's solid in elements of second order, its chambers, and its markers as material points.

use mesh::{QuadraticElements, QuadraticFace, QuadraticMesh, Skin, Solid, Spot};
use serde::{Deserialize, Serialize};
use si::CubicMetre;
use sysid::{Attached, Body, Model};

use super::inconsistent_file;
use crate::subject::Specimen;
use workflow::columns::Columns;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// A meshed specimen.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Nodes, elements, regions and skin; a half model where the surfaces are symmetric about z = 0.
    pub solid: QuadraticMesh,
    /// The card's chambers, in its order.
    pub chambers: Vec<Cavity>,
    /// The card's markers on the skin, in its order.
    pub markers: Vec<Spot>,
    /// The nodes of the surface that the card's clamp names; empty of a clamp by its place.
    pub clamped: Vec<u32>,
    /// Quality of the mesh.
    pub quality: Quality,
}

/// Which cavity of the skin is which chamber of the card.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cavity {
    /// The chamber's name on the card.
    pub name: String,
    /// The index of its faces on the skin.
    pub skin: u16,
    /// Its volume, both halves, m³.
    pub volume_m3: CubicMetre,
}

/// Measures of mesh quality.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Degrees of freedom before clamping.
    pub dofs: usize,
    /// Whether the surfaces are symmetric and only z ≥ 0 is meshed.
    pub half: bool,
    /// Smallest angle between two faces of an element, degrees.
    pub min_dihedral_deg: f64,
    /// Largest distance between the surfaces and the mesh, m.
    pub hausdorff_m: f64,
    /// Volume of body and sheet in the mesh over their volume in the STL files, less one; empty of a mesh file.
    pub volume_error: Vec<f64>,
    /// Largest distance of a marker on the card from the skin, m.
    pub marker_distance_m: f64,
    /// Why a body of surfaces is in tetrahedra where hexahedra were wished for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_hexahedra: Option<String>,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    chambers: Vec<Cavity>,
    quality: Quality,
    markers: Vec<Vec<(u32, f64)>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    clamped: Vec<u32>,
}

impl Mesh {
    /// The model of the specimen with the card's `body`.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when a material is unknown or the simulator refuses the mesh.
    pub fn model(&self, body: &Body) -> diagnostics::Result<Model> {
        let attached = Attached { chambers: &self.skin_codes(), clamped: &self.clamped };
        Model::new(&Solid::Quadratic(self.solid.clone()), attached, self.markers.clone(), body)
    }

    /// The skin index of each chamber, in the order of the card.
    pub fn skin_codes(&self) -> Vec<u16> {
        self.chambers.iter().map(|c| c.skin).collect()
    }
}

impl Record for Mesh {
    type Of = Specimen;
    const STAGE: &'static str = "mesh";

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let solid = &self.solid;
        let axis = |k: usize| solid.nodes.iter().map(|n| n[k]).collect();
        let nodes = Columns::default().numbers("x_m", axis(0)).numbers("y_m", axis(1)).numbers("z_m", axis(2));
        let regions = solid.regions.iter().map(|&r| u32::from(r)).collect();
        let elements = Columns::default().counts("region", regions).rows("n", solid.elements.iter());
        let skin_codes = Columns::default().counts("on", solid.skin.iter().map(|f| f.on.code()).collect());
        let sides = solid.skin_rows();
        let skin = skin_codes.rows("n", sides.iter().map(Vec::as_slice));
        let markers = self.markers.iter().map(|m| m.weights.clone()).collect();
        let (chambers, quality, clamped) = (self.chambers.clone(), self.quality.clone(), self.clamped.clone());
        let scalars = Scalars { chambers, quality, markers, clamped };
        RecordFiles::default()
            .table("nodes.parquet", &nodes)?
            .table(&format!("{}.parquet", solid.elements.name()), &elements)?
            .table("skin.parquet", &skin)?
            .scalars("mesh.json", &scalars)
            .map(|files| files.file("mesh.vtu", mesh::vtu::write(solid).into_bytes()))
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let scalars: Scalars = files.read_scalars("mesh.json")?;
        let nodes = files.read_table("nodes.parquet")?;
        let hexahedra = files.contents().any(|(name, _)| name == HEXAHEDRA);
        let name = if hexahedra { HEXAHEDRA } else { TETRAHEDRA };
        let (listed, skin) = (files.read_table(name)?, files.read_table("skin.parquet")?);
        let region = |region: u32| u16::try_from(region).map_err(|e| inconsistent_file(name, e.to_string()));
        let code = || {
            inconsistent_file("skin.parquet", "a face lies on a skin that there is not, or has other than 6 or 8 nodes")
        };
        let face = |(skin_code, nodes): (u32, Vec<u32>)| {
            QuadraticFace::from_row(&nodes, Skin::from_code(skin_code).ok_or_else(code)?).ok_or_else(code)
        };
        let elements = QuadraticElements::from_rows(&listed.read_rows("n"));
        let (x, y, z) = (nodes.f64("x_m")?, nodes.f64("y_m")?, nodes.f64("z_m")?);
        let solid = QuadraticMesh {
            // length: columns of one table are equally long
            nodes: x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect(),
            elements: elements.ok_or_else(|| inconsistent_file(name, "an element has other than 10 or 20 nodes"))?,
            regions: listed.u32("region")?.into_iter().map(region).collect::<Result<_, _>>()?,
            // length: columns of one table are equally long
            skin: skin.u32("on")?.into_iter().zip(skin.read_rows("n")).map(face).collect::<Result<_, RecordError>>()?,
            half: scalars.quality.half,
        };
        let named = scalars.markers.iter().flatten().map(|(node, _)| node).chain(&scalars.clamped);
        let unknown_node = named.copied().find(|node| *node as usize >= solid.nodes.len());
        let unknown_node =
            unknown_node.map(|node| format!("a marker or the clamp is at node {node}, which there is not"));
        if let Some(cause) = solid.fault().or(unknown_node) {
            return Err(inconsistent_file("mesh.json", cause));
        }
        Ok(Self {
            solid,
            chambers: scalars.chambers,
            markers: scalars.markers.into_iter().map(|weights| Spot { weights }).collect(),
            clamped: scalars.clamped,
            quality: scalars.quality,
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |quantity: &str| format!("mesh.{subject}.{quantity}");
        vec![
            Metric::new(id("tets"), self.solid.elements.len() as f64, ""),
            Metric::new(id("dofs"), self.quality.dofs as f64, ""),
            Metric::new(id("min_dihedral_deg"), self.quality.min_dihedral_deg, "°"),
            Metric::new(id("hausdorff_mm"), 1e3 * self.quality.hausdorff_m, "mm"),
        ]
    }

    fn summary(&self) -> String {
        let half = if self.quality.half { "half model, " } else { "" };
        let (elements, dofs) = (self.solid.elements.len(), self.quality.dofs);
        let kind = self.solid.elements.name();
        let refused = self.quality.not_hexahedra.as_deref().and_then(|reasons| reasons.lines().next());
        let refused = refused.map(|reason| format!("; no hexahedra: {reason}")).unwrap_or_default();
        let (angle, distance) = (self.quality.min_dihedral_deg, 1e3 * self.quality.hausdorff_m);
        format!(
            "{half}{elements} {kind}, {dofs} dofs, smallest angle {angle:.1}°, surface distance {distance:.2} mm{refused}"
        )
    }
}

/// The tables of elements.
const TETRAHEDRA: &str = "tetrahedra.parquet";
const HEXAHEDRA: &str = "hexahedra.parquet";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_survives_its_record() {
        let solid = QuadraticMesh {
            nodes: (0..10).map(|i| [0.1 * f64::from(i), 0.0, 1.0]).collect(),
            elements: QuadraticElements::Tetrahedra(vec![std::array::from_fn(|i| i as u32)]),
            regions: vec![1],
            skin: vec![QuadraticFace::triangle([0, 1, 2, 4, 5, 6], Skin::Chamber(3))],
            half: true,
        };
        let quality = Quality {
            dofs: 30,
            half: true,
            min_dihedral_deg: 5.0,
            hausdorff_m: 1e-4,
            volume_error: vec![0.0; 2],
            marker_distance_m: 0.0,
            not_hexahedra: None,
        };
        let chambers = vec![Cavity { name: "left".into(), skin: 3, volume_m3: 1e-6 }];
        let mesh =
            Mesh { solid, chambers, markers: vec![Spot { weights: vec![(2, 1.0)] }], clamped: vec![0, 2], quality };
        assert_eq!(Mesh::from_files(&mesh.to_files().unwrap()).unwrap(), mesh);
        let mut damaged = [mesh.clone(), mesh.clone(), mesh.clone(), mesh.clone()];
        damaged[0].solid.elements =
            QuadraticElements::Tetrahedra(vec![std::array::from_fn(|i| if i == 3 { 10 } else { i as u32 })]);
        damaged[1].markers[0].weights[0].0 = 10;
        damaged[2].solid.nodes[4][1] = f64::NAN;
        damaged[3].clamped.push(10);
        for mesh in damaged {
            let error = Mesh::from_files(&mesh.to_files().unwrap()).unwrap_err().to_string();
            assert!(error.contains("mesh.json") && error.contains("node"), "{error}");
        }
    }
}
