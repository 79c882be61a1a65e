//! Meshes from arrays and files: tetrahedra with a skin and chambers, or hexahedra.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use ::mesh::Skin;
use ::mesh::foreign::{ForeignMesh, HexahedralMesh, NamedSurface, RawMesh, Region};
use ::mesh::{Detail, ElementName, Method};
use diagnostics::Diagnostic;
use fem::Elements;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use simulate::Loaded;
use simulate::case::{Case, Order, Output, Source, Unit};

use crate::arrays::{Reals, check_length, node_numbers, number_slice, numpy_array};
use crate::errors::{Kind, input_error, of_diagnostic};
use crate::interrupt::run_watched;
use crate::memory;

/// What a body is meshed with.
pub(crate) enum Kinds {
    /// Tetrahedra.
    Tetrahedra(Loaded),
    /// Hexahedra.
    Hexahedra(HexahedralMesh),
}

impl Kinds {
    fn regions(&self) -> &[Region] {
        match self {
            Self::Tetrahedra(loaded) => &loaded.regions,
            Self::Hexahedra(mesh) => &mesh.regions,
        }
    }
}

/// A surface of a mesh of hexahedra: its tag, its name, and the corners of its sides.
type Sides = (i64, Option<String>, Vec<[u32; 4]>);

/// Faces of surfaces (3 node numbers each, 4 of hexahedra), the tag of each, and names of tags.
type Surfaces<'py> = (PyReadonlyArray1<'py, i64>, Vec<i64>, BTreeMap<i64, String>);

/// A mesh.
#[pyclass(frozen, module = "softfish._core")]
#[derive(Clone)]
pub(crate) struct Mesh {
    pub(crate) kinds: Arc<Kinds>,
    /// For each node of the caller's arrays its number here, `u32::MAX` where no element uses it; empty where they are not those of arrays or of a file.
    numbering: Arc<Vec<u32>>,
    /// Of hexahedra; the surfaces of tetrahedra are those of their mesh.
    sides: Arc<Vec<Sides>>,
}

/// The class of an error of a mesh.
fn mesh_exception(diagnostic: &Diagnostic) -> PyErr {
    of_diagnostic(diagnostic, Kind::Mesh)
}

impl Mesh {
    pub(crate) fn of(loaded: Loaded) -> Self {
        let numbering = loaded.numbering.clone();
        Self::with_numbering(Kinds::Tetrahedra(loaded), numbering)
    }

    fn with_numbering(kinds: Kinds, numbering: Vec<u32>) -> Self {
        Self { kinds: Arc::new(kinds), numbering: Arc::new(numbering), sides: Arc::default() }
    }

    /// A draft in a unit of length (m), checked.
    fn checked_mesh(raw: RawMesh, unit: f64, half: bool) -> Result<Self, Diagnostic> {
        if is_hexahedral(&raw) {
            let mesh = raw.check_hexahedra(unit, half)?;
            let numbering = mesh.numbering.clone();
            return Ok(Self::with_numbering(Kinds::Hexahedra(mesh), numbering));
        }
        let ForeignMesh { solid, regions, surfaces, cavities, numbering, notes } = raw.check(unit, half)?;
        let tables = Default::default();
        Ok(Self::of(Loaded { solid, regions, surfaces, cavities, numbering, notes, tables }))
    }

    /// With surfaces whose node numbers are those of the caller's arrays; a side of nodes that were dropped is left out.
    fn with_sides(self, sides: Vec<Sides>) -> Self {
        let number = |node: &u32| self.numbering.get(*node as usize).copied().unwrap_or(*node);
        let renumbered_side =
            |side: &[u32; 4]| Some(side.map(|node| number(&node))).filter(|side| !side.contains(&u32::MAX));
        let renumbered = |(tag, name, all): Sides| (tag, name, all.iter().filter_map(renumbered_side).collect());
        let sides = Arc::new(sides.into_iter().map(renumbered).collect());
        Self { sides, ..self }
    }

    fn named_sides<'py>(&self, py: Python<'py>) -> Vec<(i64, Option<String>, Bound<'py, PyArray1<i64>>)> {
        let named = |(tag, name, all): &Sides| {
            let corners = all.as_flattened().iter().map(|&node| i64::from(node)).collect();
            (*tag, name.clone(), PyArray1::from_vec(py, corners))
        };
        self.sides.iter().map(named).collect()
    }

    /// As the solver takes it.
    pub(crate) fn fem_mesh(&self) -> fem::Mesh {
        match &*self.kinds {
            Kinds::Tetrahedra(loaded) => {
                simulate::fem_mesh(&loaded.solid, &(0..loaded.cavities.len() as u16).collect::<Vec<_>>())
            }
            Kinds::Hexahedra(mesh) => fem::Mesh {
                nodes: mesh.nodes.clone(),
                elements: hexahedral_elements(mesh),
                regions: mesh.numbers.clone(),
                chambers: mesh.walls.iter().map(|walls| chamber_of_walls(walls)).collect(),
                symmetry_plane_z: mesh.half,
            },
        }
    }
}

#[pymethods]
impl Mesh {
    /// From nodes (3 numbers each, m), elements and the nodes of each; the tag of each element, and names of tags; whether it is a half model,
    /// and surfaces where there are some.
    #[staticmethod]
    fn from_arrays(
        py: Python<'_>,
        arrays: (Reals<'_>, PyReadonlyArray1<'_, i64>, usize),
        tagged: (Vec<i64>, BTreeMap<i64, String>),
        options: (bool, Option<Surfaces<'_>>),
    ) -> PyResult<Self> {
        let (nodes, elements, each) = arrays;
        let ((tags, names), (half, surfaces)) = (tagged, options);
        let points = number_slice("nodes", &nodes)?.as_chunks::<3>().0.to_vec();
        let corners = numbers_below("elements", &elements, points.len())?;
        let mut raw = RawMesh {
            node_labels: (0..points.len() as u64).collect(),
            nodes: points,
            labels: (0..tags.len() as u64).collect(),
            corners,
            each,
            tags,
            names,
            ..RawMesh::default()
        };
        check_length("elements", raw.corners.len(), each * raw.labels.len())?;
        check_length("regions", raw.tags.len(), raw.labels.len())?;
        let mut sides = Vec::new();
        if let Some((faces, tags, names)) = surfaces {
            let corners = numbers_below("surfaces", &faces, raw.nodes.len())?;
            if is_hexahedral(&raw) {
                check_length("surfaces", corners.len(), 4 * tags.len())?;
                sides = sides_by_tag(corners.as_chunks::<4>().0, &tags, &names);
            } else {
                check_length("surfaces", corners.len(), 3 * tags.len())?;
                raw.triangles = corners.as_chunks::<3>().0.iter().copied().zip(tags).collect();
                raw.surface_names = names;
            }
        }
        run_watched(py, move |_| {
            let mesh = Self::checked_mesh(raw, 1.0, half).map_err(|diagnostic| mesh_exception(&diagnostic))?;
            Ok(mesh.with_sides(sides))
        })
    }

    /// From a file that the command line reads, in a unit of length and of an order where one is asked for; hexahedra as well.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf, numbers: (String, Option<u8>), half: bool) -> PyResult<Self> {
        let (unit, order) = (unit_named(&numbers.0)?, numbers.1);
        run_watched(py, move |_| {
            let hexahedra = simulate::raw_mesh(&path).ok().filter(is_hexahedral);
            if let Some(raw) = hexahedra {
                let of_file = |diagnostic: Diagnostic| mesh_exception(&diagnostic.in_file_unless_named(&path));
                let own_order = if raw.each == 8 { 1 } else { 2 };
                if order.is_some_and(|order| order != own_order) {
                    let reason = format!("its elements of {} nodes are of order {own_order}", raw.each);
                    return Err(input_error(
                        format!("order is {} for a file of hexahedra", 3 - own_order),
                        reason,
                        "leave order out, or save tetrahedra",
                    ));
                }
                return Self::checked_mesh(raw, unit.metres(), half).map_err(of_file);
            }
            let file = path.file_name().map(|name| name.to_string_lossy().into_owned());
            let source = Source { file, body: None, spine: None, edge: None, ..file_source(unit, order, half) };
            load_source(source, path.parent().map(Into::into).unwrap_or_default())
        })
    }

    /// From one or two closed surfaces in STL files, with edges of the length `edge`, m.
    #[staticmethod]
    fn from_surfaces(
        py: Python<'_>,
        files: (PathBuf, Option<PathBuf>),
        edge: f64,
        options: (String, bool),
    ) -> PyResult<Self> {
        let (body, spine) = files;
        let (unit, half) = (unit_named(&options.0)?, options.1);
        let name = |path: &PathBuf| std::path::absolute(path).map(|path| path.to_string_lossy().into_owned());
        let body = Some(name(&body)?);
        let spine = spine.as_ref().map(name).transpose()?;
        let source = Source { file: None, body, spine, edge: Some(edge), ..file_source(unit, None, half) };
        run_watched(py, move |_| load_source(source, PathBuf::new()))
    }

    /// Node positions, 3 numbers each, m.
    fn nodes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numpy_array(py, self.fem_mesh().nodes.into_flattened())
    }

    /// Node numbers of all elements, and nodes of each.
    fn elements<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<i64>>, usize) {
        let elements = self.fem_mesh().elements;
        let each = elements.nodes_each();
        let node_numbers =
            (0..elements.len()).flat_map(|element| elements.nodes(element).iter().map(|&node| i64::from(node)));
        (PyArray1::from_iter(py, node_numbers.collect::<Vec<_>>()), each)
    }

    /// The region of each element.
    fn regions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        PyArray1::from_iter(py, self.fem_mesh().regions.into_iter().map(i64::from).collect::<Vec<_>>())
    }

    /// The name of each region: the file's, or `region_` and its tag.
    pub(crate) fn region_names(&self) -> Vec<String> {
        let name = |region: &Region| region.name.clone().unwrap_or_else(|| format!("region_{}", region.tag));
        self.kinds.regions().iter().map(name).collect()
    }

    /// The tag of each region, and whether the file names it.
    fn region_tags(&self) -> Vec<(i64, bool)> {
        self.kinds.regions().iter().map(|region| (region.tag, region.name.is_some())).collect()
    }

    /// The surfaces that the file names or numbers: tag, name, and node numbers of the corners of their triangles, of hexahedra of their sides.
    fn surfaces<'py>(&self, py: Python<'py>) -> Vec<(i64, Option<String>, Bound<'py, PyArray1<i64>>)> {
        let Kinds::Tetrahedra(loaded) = &*self.kinds else { return self.named_sides(py) };
        let elements: Vec<&[u32]> = (0..loaded.solid.len()).map(|element| loaded.solid.element(element)).collect();
        let corners = |surface: &NamedSurface| -> Vec<i64> {
            let triangles = surface.triangles(elements.iter().copied());
            triangles.iter().flatten().map(|&node| i64::from(node)).collect()
        };
        let named =
            |surface: &NamedSurface| (surface.tag, surface.name.clone(), PyArray1::from_vec(py, corners(surface)));
        loaded.surfaces.iter().map(named).collect()
    }

    /// For each node of the caller's arrays its number here, −1 where no element uses it; empty where they are not those of arrays or of a file.
    fn numbering<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let number = |&node: &u32| if node == u32::MAX { -1 } else { i64::from(node) };
        PyArray1::from_iter(py, self.numbering.iter().map(number).collect::<Vec<_>>())
    }

    /// It with the numbering and the notes of the mesh that it is a copy of.
    fn noted(&self, numbering: PyReadonlyArray1<'_, i64>, notes: Vec<String>) -> PyResult<Self> {
        let contiguous = |_| input_error("numbering is not contiguous", "its numbers are apart", "pass a copy");
        let numbers = numbering.as_slice().map_err(contiguous)?;
        let numbering = numbers.iter().map(|&number| u32::try_from(number).unwrap_or(u32::MAX)).collect();
        let kinds = match &*self.kinds {
            Kinds::Tetrahedra(loaded) => Kinds::Tetrahedra(Loaded { notes, ..loaded.clone() }),
            Kinds::Hexahedra(mesh) => Kinds::Hexahedra(HexahedralMesh { notes, ..mesh.clone() }),
        };
        Ok(Self { sides: self.sides.clone(), ..Self::with_numbering(kinds, numbering) })
    }

    /// Whether it is the half z ≥ 0 of a symmetric body.
    fn half(&self) -> bool {
        match &*self.kinds {
            Kinds::Tetrahedra(loaded) => loaded.solid.half(),
            Kinds::Hexahedra(mesh) => mesh.half,
        }
    }

    /// Volume (m³, of a half model of the half) and centroid of each chamber.
    pub(crate) fn chambers(&self) -> Vec<(f64, [f64; 3])> {
        match &*self.kinds {
            Kinds::Tetrahedra(loaded) => {
                loaded.cavities.iter().map(|cavity| (cavity.volume, cavity.centroid)).collect()
            }
            Kinds::Hexahedra(mesh) => {
                let pressurised = mesh.chambers.iter().take(mesh.walls.len());
                pressurised.map(|chamber| (chamber.cavity.volume, chamber.cavity.centroid)).collect()
            }
        }
    }

    /// Node numbers of the corners of the outer skin's triangles; sides of hexahedra are cut into two.
    fn skin<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let corners: Vec<i64> = match &*self.kinds {
            Kinds::Tetrahedra(loaded) => {
                let outer = loaded.solid.faces().into_iter().filter(|(_, on)| *on == Skin::Outer);
                outer
                    .flat_map(|(nodes, _)| nodes[..3].iter().map(|&node| i64::from(node)).collect::<Vec<_>>())
                    .collect()
            }
            Kinds::Hexahedra(mesh) => {
                let two = |[a, b, c, d]: &[u32; 4]| [*a, *b, *c, *a, *c, *d];
                mesh.skin.iter().flat_map(two).map(i64::from).collect()
            }
        };
        PyArray1::from_vec(py, corners)
    }

    /// What was repaired or noticed when it was read.
    fn notes(&self) -> Vec<String> {
        match &*self.kinds {
            Kinds::Tetrahedra(loaded) => loaded.notes.clone(),
            Kinds::Hexahedra(mesh) => mesh.notes.clone(),
        }
    }
}

/// Node numbers below `count`.
///
/// # Errors
/// `InputError` where one is not.
fn numbers_below(name: &str, values: &PyReadonlyArray1<'_, i64>, count: usize) -> PyResult<Vec<u32>> {
    let contiguous = |_| input_error(format!("{name} is not contiguous"), "its rows are apart", "pass a copy");
    let numbers = node_numbers(values.as_slice().map_err(contiguous)?)?;
    match numbers.iter().find(|&&node| node as usize >= count) {
        None => Ok(numbers),
        Some(node) => {
            let reason = format!("there are {count}, counted from 0");
            Err(input_error(format!("`{name}` names the node {node}"), reason, "check its numbers"))
        }
    }
}

/// Sides with the tag of each, as surfaces in rising order of their tags.
fn sides_by_tag(sides: &[[u32; 4]], tags: &[i64], names: &BTreeMap<i64, String>) -> Vec<Sides> {
    let mut by_tag: BTreeMap<i64, Vec<[u32; 4]>> = BTreeMap::new();
    // length: the caller has compared both
    sides.iter().zip(tags).for_each(|(side, tag)| by_tag.entry(*tag).or_default().push(*side));
    by_tag.into_iter().map(|(tag, all)| (tag, names.get(&tag).cloned(), all)).collect()
}

fn is_hexahedral(raw: &RawMesh) -> bool {
    [8, 20].contains(&raw.each)
}

fn hexahedral_elements(mesh: &HexahedralMesh) -> Elements {
    if mesh.middles.is_empty() {
        return Elements::Hexahedra(mesh.hexahedra.clone());
    }
    Elements::QuadraticHexahedra(mesh.twenty_nodes().collect())
}

fn chamber_of_walls(walls: &[[u32; 8]]) -> fem::Chamber {
    fem::Chamber { faces: fem::Faces::QuadraticQuadrilaterals(walls.to_vec()) }
}

fn unit_named(name: &str) -> PyResult<Unit> {
    match name {
        "m" => Ok(Unit::M),
        "mm" => Ok(Unit::Mm),
        "cm" => Ok(Unit::Cm),
        "inch" => Ok(Unit::Inch),
        _ => Err(input_error(format!("`unit` is {name}"), "known are m, mm, cm and inch", "name one of them")),
    }
}

fn file_source(unit: Unit, order: Option<u8>, half: bool) -> Source {
    let order = order.map(|order| if order == 1 { Order::Linear } else { Order::Quadratic });
    Source {
        file: None,
        body: None,
        spine: None,
        edge: None,
        unit,
        order,
        elements: Some(ElementName::Tetrahedra),
        method: Method::Auto,
        detail: Detail::default(),
        half,
        finer: 1.0,
    }
}

fn load_source(mesh: Source, folder: PathBuf) -> PyResult<Mesh> {
    let (clamp, chamber, load, mass) = Default::default();
    let (contact, statics, dynamic, output) = (None, None, None, Output::default());
    let (gravity, region) = ([0.0; 3], Vec::new());
    let case = Case { gravity, mesh, region, clamp, chamber, load, mass, contact, statics, dynamic, output };
    simulate::load(&case, &folder).map(Mesh::of).map_err(|diagnostic| mesh_exception(&diagnostic))
}

/// Bytes that a cell of a box takes while its mesh is made and checked: twice what was measured on 30³ cells.
const LINEAR_CELL: f64 = 3e3;
const QUADRATIC_CELL: f64 = 6e3;
const HEXAHEDRON: f64 = 1e3;
const QUADRATIC_HEXAHEDRON: f64 = 4e3;

/// Makes a box of a size (m) of so many cells.
type MakeBox = fn([f64; 3], [usize; 3]) -> fem::Mesh;

fn quadratic_hexahedra(size: [f64; 3], cells: [usize; 3]) -> fem::Mesh {
    let scaled = move |at: [f64; 3]| std::array::from_fn(|axis| size[axis] * at[axis]);
    fem::box_mesh::quadratic_hexahedra(cells, false, scaled, |_| Some(0))
}

/// A box [0, size] (m) of `cells` grid cells along each axis: `kind` is `linear`, `quadratic`, `hexahedra` or `quadratic_hexahedra`. Returns
/// nodes, elements and the number of nodes of each.
#[pyfunction]
pub(crate) fn box_mesh<'py>(
    py: Python<'py>,
    size: [f64; 3],
    cells: [usize; 3],
    kind: &str,
) -> PyResult<Bound<'py, PyDict>> {
    fem::box_mesh::check(size, cells).map_err(|error| mesh_exception(&error.into()))?;
    let (make, bytes): (MakeBox, f64) = match kind {
        "linear" => (fem::box_mesh::linear, LINEAR_CELL),
        "quadratic" => (fem::box_mesh::quadratic, QUADRATIC_CELL),
        "hexahedra" => (fem::box_mesh::hexahedra, HEXAHEDRON),
        "quadratic_hexahedra" => (quadratic_hexahedra, QUADRATIC_HEXAHEDRON),
        _ => {
            let kinds = "known are linear, quadratic, hexahedra, quadratic_hexahedra";
            return Err(input_error(format!("there is no mesh of `{kind}`"), kinds, "name one"));
        }
    };
    let count: usize = cells.iter().product();
    memory::require_free(&format!("a box of {count} cells"), bytes * count as f64)?;
    let mesh = run_watched(py, move |_| Ok(make(size, cells)))?;
    let each = mesh.elements.nodes_each();
    let node_numbers = (0..mesh.elements.len()).flat_map(|element| mesh.elements.nodes(element).to_vec());
    let record = PyDict::new(py);
    record.set_item("elements", PyArray1::from_vec(py, node_numbers.map(i64::from).collect()))?;
    record.set_item("each", each)?;
    record.set_item("nodes", numpy_array(py, mesh.nodes.into_flattened()))?;
    Ok(record)
}
