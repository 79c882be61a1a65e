//! Copies of meshes of second-order hexahedra that were made from surfaces. Wedges among them name nodes twice, which is refused of a caller's
//! arrays; a copy holds the lists of a mesh that was checked when it was made.

use ::mesh::foreign::Region;
use ::mesh::{QuadraticElements, QuadraticFace, QuadraticMesh, Skin, Solid};
use numpy::PyArray1;
use pyo3::prelude::*;
use simulate::Loaded;

use crate::arrays::{Reals, number_slice, numpy_array};
use crate::errors::input_error;
use crate::mesh::{Kinds, Mesh};

/// Rows of node numbers.
type Rows = Vec<Vec<u32>>;
/// Tag, name, number of elements and volume (m³) of a region.
type RegionState = (i64, Option<String>, usize, f64);
/// The region of each element, the code and the nodes of each face of the skin, and the regions.
type Parts = (Vec<u16>, Vec<u32>, Rows, Vec<RegionState>);

fn damaged_copy(cause: impl AsRef<str>) -> PyErr {
    input_error("the copy of a mesh cannot be read", cause, "make the mesh again")
}

#[pymethods]
impl Mesh {
    /// Nodes (3 numbers each, m), elements and further lists of a mesh of second-order hexahedra from surfaces; none of other meshes.
    fn solid_state<'py>(&self, py: Python<'py>) -> Option<(Bound<'py, PyArray1<f64>>, Rows, Parts)> {
        let Kinds::Tetrahedra(loaded) = &*self.kinds else { return None };
        let Solid::Quadratic(solid) = &loaded.solid else { return None };
        let QuadraticElements::Hexahedra(hexahedra) = &solid.elements else { return None };
        let elements = hexahedra.iter().map(|nodes| nodes.to_vec()).collect();
        let codes = solid.skin.iter().map(|face| face.on.code()).collect();
        let region = |region: &Region| (region.tag, region.name.clone(), region.elements, region.volume);
        let regions = loaded.regions.iter().map(region).collect();
        let parts = (solid.regions.clone(), codes, solid.skin_rows(), regions);
        Some((numpy_array(py, solid.nodes.as_flattened().to_vec()), elements, parts))
    }

    /// The mesh of [`Mesh::solid_state`].
    #[staticmethod]
    fn of_solid_state(nodes: Reals<'_>, elements: Rows, parts: Parts, half: bool) -> PyResult<Self> {
        let (numbers, codes, faces, named) = parts;
        if codes.len() != faces.len() {
            return Err(damaged_copy("its skin has other numbers of codes and faces"));
        }
        let face = |(code, nodes): (u32, Vec<u32>)| QuadraticFace::from_row(&nodes, Skin::from_code(code)?);
        let skin: Option<Vec<QuadraticFace>> = codes.into_iter().zip(faces).map(face).collect();
        let solid = QuadraticMesh {
            nodes: number_slice("nodes", &nodes)?.as_chunks::<3>().0.to_vec(),
            elements: QuadraticElements::from_rows(&elements)
                .ok_or_else(|| damaged_copy("an element is no hexahedron"))?,
            regions: numbers,
            skin: skin.ok_or_else(|| damaged_copy("a face of its skin lies nowhere"))?,
            half,
        };
        if let Some(cause) = solid.fault() {
            return Err(damaged_copy(cause));
        }
        let region = |(tag, name, elements, volume)| Region { tag, name, elements, volume };
        let regions = named.into_iter().map(region).collect();
        let solid = Solid::Quadratic(solid);
        let (surfaces, numbering, notes, tables) = Default::default();
        Ok(Self::of(Loaded { cavities: ::mesh::cavities(&solid), solid, regions, surfaces, numbering, notes, tables }))
    }
}
