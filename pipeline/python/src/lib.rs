//! The compiled part of the Python package `softfish`: meshes, cases and solvers of this project behind plain functions
//! on numpy arrays. Names, checks of arguments and documentation for users are in the package's Python files.
//!
//! Invariants: results are handed to numpy without a copy; every solve releases the interpreter's lock and ends when
//! Ctrl-C is pressed; every error, a panic included, becomes an exception of the package with what, why and what to do.

mod arrays;
mod camera;
mod case;
mod errors;
mod film;
mod fit;
mod inputs;
mod interrupt;
mod memory;
mod mesh;
mod mesh_copies;
mod motion;
mod path;
mod project;
mod reduced;
mod solver;
mod statics;
mod surfaces;
mod threads;
mod twin;

use pyo3::prelude::*;

/// The module `softfish._core`.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    threads::remember_process();
    module.add_class::<mesh::Mesh>()?;
    module.add_class::<case::Case>()?;
    module.add_class::<solver::Solver>()?;
    module.add_class::<motion::Trajectory>()?;
    module.add_class::<reduced::ReducedModel>()?;
    module.add_class::<twin::Twin>()?;
    module.add_class::<twin::TwinState>()?;
    module.add_function(wrap_pyfunction!(case::run_case, module)?)?;
    module.add_function(wrap_pyfunction!(camera::calibrate, module)?)?;
    module.add_function(wrap_pyfunction!(film::track, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::box_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(surfaces::mesh_surfaces, module)?)?;
    module.add_function(wrap_pyfunction!(project::require_record, module)?)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("MATERIALS", fem::materials::ALL.iter().map(|law| law.name()).collect::<Vec<_>>())
}
