//! Bodies from closed surfaces that are arrays: a body, inserts that displace it, and cavities.

use mesh::{Assembly, Detail, Method, QuadraticElements, Settings, Surface, mesh_assembly};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Reals, node_numbers, number_slice, numpy_array};
use crate::errors::{Kind, input_error, of_diagnostic};
use crate::interrupt::run_watched;
use diagnostics::Diagnostic;

/// Corners, 3 numbers each, m, and three corner numbers a face.
type Triangles<'py> = (Reals<'py>, Vec<i64>);

/// Envelope and shortest edges, m, and elements through a wall, each where it is asked for.
type Detailed = (Option<f64>, Option<f64>, Option<u32>);

fn closed_surface((points, faces): &Triangles<'_>) -> PyResult<Surface> {
    // length: Python hands over points × 3 and faces × 3
    let points: Vec<[f64; 3]> = number_slice("points", points)?.as_chunks().0.to_vec();
    let faces: Vec<[u32; 3]> = node_numbers(faces)?.as_chunks().0.to_vec();
    if let Some(face) = faces.iter().position(|face| face.iter().any(|corner| *corner as usize >= points.len())) {
        let what = format!("face {face} names a corner that there is not");
        return Err(input_error(what, format!("there are {} points", points.len()), "check the faces"));
    }
    Ok(Surface { points, faces })
}

/// Meshes a body with its inserts and cavities. Returns nodes, quadratic tetrahedra, the region of each, and what was changed of the surfaces.
#[pyfunction]
pub(crate) fn mesh_surfaces<'py>(
    py: Python<'py>,
    parts: (Triangles<'py>, Vec<Triangles<'py>>, Vec<Triangles<'py>>),
    edge: f64,
    how: (String, Detailed),
) -> PyResult<Bound<'py, PyDict>> {
    let (method, (envelope, smallest, layers)) = how;
    let method = match method.as_str() {
        "columns" => Method::Columns,
        "general" => Method::General,
        _ => Method::Auto,
    };
    let detail = Detail { envelope, smallest, layers };
    let body = closed_surface(&parts.0)?;
    let inserts = parts.1.iter().map(closed_surface).collect::<PyResult<Vec<_>>>()?;
    let cavities = parts.2.iter().map(closed_surface).collect::<PyResult<Vec<_>>>()?;
    let chosen = run_watched(py, move |_| {
        let assembly = Assembly { body: &body, inserts: inserts.iter().collect(), cavities: cavities.iter().collect() };
        let settings = Settings { method, use_symmetry: false, detail, ..Settings::new(edge) };
        mesh_assembly(&assembly, &settings, &|_| ()).map_err(|e| of_diagnostic(&Diagnostic::from(e), Kind::Mesh))
    })?;
    let mesh = chosen.solid;
    let QuadraticElements::Tetrahedra(elements) = &mesh.elements else {
        return Err(input_error("the mesh is of hexahedra", "bodies from surfaces are tetrahedra", "report this"));
    };
    let record = PyDict::new(py);
    record.set_item(
        "elements",
        PyArray1::from_iter(py, elements.iter().flatten().map(|node| i64::from(*node)).collect::<Vec<_>>()),
    )?;
    record.set_item(
        "regions",
        PyArray1::from_iter(py, mesh.regions.iter().map(|region| i64::from(*region)).collect::<Vec<_>>()),
    )?;
    record.set_item("repairs", chosen.report.repairs)?;
    record.set_item("nodes", numpy_array(py, mesh.nodes.into_flattened()))?;
    Ok(record)
}
