//! Meshes from arrays and files: tetrahedra with a skin and chambers, or hexahedra.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use ::mesh::Skin;
use ::mesh::foreign::{RawMesh, Region};
use diagnostics::Diagnostic;
use fem::Elements;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use simulate::Loaded;
use simulate::case::{Case, Order, Output, Source, Unit};

use crate::arrays::{Reals, array, node_numbers, slice};
use crate::errors::{Kind, of_diagnostic, refused};

/// What a body is meshed with.
pub(crate) enum Kinds {
    /// Tetrahedra.
    Tetrahedra(Loaded),
    /// Hexahedra, and the tags of their regions.
    Hexahedra(fem::Mesh, Vec<i64>),
}

/// A mesh.
#[pyclass(frozen, module = "softfish._core")]
pub(crate) struct Mesh {
    pub(crate) kinds: Arc<Kinds>,
}

/// The class of an error of a mesh.
fn refusal(diagnostic: &Diagnostic) -> PyErr {
    of_diagnostic(diagnostic, Kind::Mesh)
}

impl Mesh {
    pub(crate) fn of(loaded: Loaded) -> Self {
        Self { kinds: Arc::new(Kinds::Tetrahedra(loaded)) }
    }

    /// As the solver takes it.
    pub(crate) fn fem_mesh(&self) -> fem::Mesh {
        match &*self.kinds {
            Kinds::Tetrahedra(loaded) => {
                simulate::fem_mesh(&loaded.solid, &(0..loaded.cavities.len() as u16).collect::<Vec<_>>())
            }
            Kinds::Hexahedra(mesh, _) => mesh.clone(),
        }
    }
}

#[pymethods]
impl Mesh {
    /// From `nodes` (3 numbers each, m), `elements` (`each` nodes), the `tag` of each element, and names of tags.
    #[staticmethod]
    fn from_arrays(
        nodes: Reals<'_>,
        connectivity: (PyReadonlyArray1<'_, i64>, usize),
        tagged: (Vec<i64>, BTreeMap<i64, String>),
        half: bool,
    ) -> PyResult<Self> {
        let (elements, each) = connectivity;
        let (tags, names) = tagged;
        let points = slice("nodes", &nodes)?.as_chunks::<3>().0.to_vec();
        let contiguous =
            || refused("elements is not contiguous", "its rows do not lie one after the other", "pass a copy");
        let corners = node_numbers(elements.as_slice().map_err(|_| contiguous())?)?;
        let count = points.len();
        if let Some(node) = corners.iter().find(|&&node| node as usize >= count) {
            let (what, why) =
                (format!("an element names the node {node}"), format!("there are {count}, counted from 0"));
            return Err(refused(what, why, "check the elements"));
        }
        if each == 8 {
            return Ok(hexahedra(points, &corners, &tags));
        }
        let raw = RawMesh {
            node_labels: (0..count as u64).collect(),
            nodes: points,
            labels: (0..tags.len() as u64).collect(),
            corners,
            each,
            tags,
            names,
            ..RawMesh::default()
        };
        let found = raw.check(1.0, half).map_err(|error| refusal(&Diagnostic::from(error)))?;
        let (regions, notes) = (found.regions, found.notes);
        Ok(Self::of(Loaded {
            solid: found.solid,
            regions,
            surfaces: found.surfaces,
            cavities: found.cavities,
            notes,
            tables: Default::default(),
        }))
    }

    /// From a file that the command line reads, in metres or millimetres.
    #[staticmethod]
    fn read(path: PathBuf, millimetres: bool, order: Option<u8>, half: bool) -> PyResult<Self> {
        let file = path.file_name().map(|name| name.to_string_lossy().into_owned());
        let source = Source { file, body: None, spine: None, edge: None, ..source(millimetres, order, half) };
        loaded(source, path.parent().map(Into::into).unwrap_or_default())
    }

    /// From one or two closed surfaces in STL files, with edges of the length `edge`, m.
    #[staticmethod]
    fn from_surfaces(body: PathBuf, spine: Option<PathBuf>, edge: f64, options: (bool, bool)) -> PyResult<Self> {
        let (millimetres, half) = options;
        let name = |path: &PathBuf| std::path::absolute(path).map(|path| path.to_string_lossy().into_owned());
        let body = Some(name(&body)?);
        let spine = spine.as_ref().map(name).transpose()?;
        loaded(Source { file: None, body, spine, edge: Some(edge), ..source(millimetres, None, half) }, PathBuf::new())
    }

    /// Node positions, 3 numbers each, m.
    fn nodes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        array(py, self.fem_mesh().nodes.into_flattened())
    }

    /// Node numbers of all elements, and nodes of each.
    fn elements<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<i64>>, usize) {
        let elements = self.fem_mesh().elements;
        let each = elements.nodes_each();
        let all = (0..elements.len()).flat_map(|element| elements.nodes(element).iter().map(|&node| i64::from(node)));
        (PyArray1::from_iter(py, all.collect::<Vec<_>>()), each)
    }

    /// The region of each element.
    fn regions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        PyArray1::from_iter(py, self.fem_mesh().regions.into_iter().map(i64::from).collect::<Vec<_>>())
    }

    /// The name of each region: the file's, or `region_` and its tag.
    pub(crate) fn region_names(&self) -> Vec<String> {
        let unnamed = |tag: &i64| format!("region_{tag}");
        match &*self.kinds {
            Kinds::Tetrahedra(loaded) => {
                let name = |region: &Region| region.name.clone().unwrap_or_else(|| unnamed(&region.tag));
                loaded.regions.iter().map(name).collect()
            }
            Kinds::Hexahedra(_, tags) => tags.iter().map(unnamed).collect(),
        }
    }

    /// Volume (m³, of a half model of the half) and centroid of each chamber.
    pub(crate) fn chambers(&self) -> Vec<(f64, [f64; 3])> {
        match &*self.kinds {
            Kinds::Tetrahedra(loaded) => {
                loaded.cavities.iter().map(|cavity| (cavity.volume, cavity.centroid)).collect()
            }
            Kinds::Hexahedra(..) => Vec::new(),
        }
    }

    /// Node numbers of the corners of the outer skin's triangles.
    fn skin<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let corners: Vec<i64> = match &*self.kinds {
            Kinds::Tetrahedra(loaded) => {
                let outer = loaded.solid.faces().into_iter().filter(|(_, on)| *on == Skin::Outer);
                outer
                    .flat_map(|(nodes, _)| nodes[..3].iter().map(|&node| i64::from(node)).collect::<Vec<_>>())
                    .collect()
            }
            Kinds::Hexahedra(..) => Vec::new(),
        };
        PyArray1::from_vec(py, corners)
    }

    /// What was repaired or noticed when it was read.
    fn notes(&self) -> Vec<String> {
        match &*self.kinds {
            Kinds::Tetrahedra(loaded) => loaded.notes.clone(),
            Kinds::Hexahedra(..) => Vec::new(),
        }
    }
}

/// Hexahedra with regions in rising order of their tags.
fn hexahedra(nodes: Vec<[f64; 3]>, corners: &[u32], tags: &[i64]) -> Mesh {
    let mut known = tags.to_vec();
    known.sort_unstable();
    known.dedup();
    let number = |tag: &i64| known.binary_search(tag).unwrap_or_default() as u16;
    let mesh = fem::Mesh {
        nodes,
        elements: Elements::Hexahedra(corners.as_chunks::<8>().0.to_vec()),
        regions: tags.iter().map(number).collect(),
        chambers: Vec::new(),
        symmetry_plane_z: false,
    };
    Mesh { kinds: Arc::new(Kinds::Hexahedra(mesh, known)) }
}

fn source(millimetres: bool, order: Option<u8>, half: bool) -> Source {
    let order = order.map(|order| if order == 1 { Order::Linear } else { Order::Quadratic });
    let unit = if millimetres { Unit::Mm } else { Unit::M };
    Source { file: None, body: None, spine: None, edge: None, unit, order, half }
}

fn loaded(mesh: Source, folder: PathBuf) -> PyResult<Mesh> {
    let (clamp, chamber, load, mass) = Default::default();
    let (contact, statics, dynamic, output) = (None, None, None, Output::default());
    let (gravity, region) = ([0.0; 3], Vec::new());
    let case = Case { gravity, mesh, region, clamp, chamber, load, mass, contact, statics, dynamic, output };
    simulate::load(&case, &folder).map(Mesh::of).map_err(|diagnostic| refusal(&diagnostic))
}

/// A box [0, size] (m) of `cells` grid cells along each axis: `kind` is `linear`, `quadratic` or `hexahedra`. Returns
/// nodes, elements and the number of nodes of each.
#[pyfunction]
pub(crate) fn box_mesh<'py>(
    py: Python<'py>,
    size: [f64; 3],
    cells: [usize; 3],
    kind: &str,
) -> PyResult<Bound<'py, PyDict>> {
    fem::box_mesh::check(size, cells).map_err(|error| refusal(&error.into()))?;
    let mesh = match kind {
        "linear" => fem::box_mesh::linear(size, cells),
        "quadratic" => fem::box_mesh::quadratic(size, cells),
        "hexahedra" => fem::box_mesh::hexahedra(size, cells),
        _ => {
            return Err(refused(
                format!("there is no mesh of `{kind}`"),
                "known are linear, quadratic, hexahedra",
                "name one",
            ));
        }
    };
    let each = mesh.elements.nodes_each();
    let all = (0..mesh.elements.len()).flat_map(|element| mesh.elements.nodes(element).to_vec());
    let made = PyDict::new(py);
    made.set_item("elements", PyArray1::from_vec(py, all.map(i64::from).collect()))?;
    made.set_item("each", each)?;
    made.set_item("nodes", array(py, mesh.nodes.into_flattened()))?;
    Ok(made)
}
