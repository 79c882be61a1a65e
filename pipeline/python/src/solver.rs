//! Solvers of one body: made of a case or of arrays, and the facts about the body that Python needs.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use fem::{Clamps, Options, RegionProperties, System};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use simulate::{Body, Loaded, Loads};

use crate::arrays::numpy_array;
use crate::case::{Case, case_exception};
use crate::errors::{Kind, input_error, of_diagnostic, solve_exception, typed_exception};
use crate::inputs::Inputs;
use crate::interrupt::{Signals, run_watched, run_watched_by};
use crate::memory;
use crate::mesh::{Kinds, Mesh};
use crate::threads::OwnThreads;

/// A solver with the inputs that it has.
pub(crate) struct Held {
    pub(crate) solver: fem::Solver,
    applied: Option<Inputs>,
}

impl Held {
    /// Sets the inputs of the next solve.
    pub(crate) fn apply(&mut self, inputs: &Inputs) -> PyResult<()> {
        // Where one is refused, those before it are set: nothing is then known of the solver.
        let applied = self.applied.take();
        let set = inputs.set(applied.as_ref(), &mut self.solver);
        set.map_err(|diagnostic| of_diagnostic(&diagnostic, Kind::Input))?;
        self.applied = Some(inputs.clone());
        Ok(())
    }

    /// Moves the clamps to a `level` of the case, where there is one: that of an equilibrium solved before is not that of what follows.
    pub(crate) fn move_clamps(&mut self, case: Option<&OfCase>, level: f64) -> PyResult<()> {
        let outcome = case.map_or(Ok(()), |of| of.loads.move_clamps(&mut self.solver, level));
        outcome.map_err(|diagnostic| of_diagnostic(&diagnostic, Kind::Input))
    }
}

/// What a solve needs, on whatever thread it runs.
pub(crate) struct Shared {
    held: Mutex<Held>,
    pub(crate) system: System,
    pub(crate) case: Option<OfCase>,
    /// Threads of its own; those that all solvers share where it has none.
    own: Option<OwnThreads>,
    /// Whether the caller of the last solve had Ctrl-C, and did not wait for its end.
    abandoned: AtomicBool,
}

/// A solver of one body.
#[pyclass(frozen, module = "softfish._core")]
pub(crate) struct Solver {
    pub(crate) shared: Arc<Shared>,
}

/// What a solver knows of its case.
pub(crate) struct OfCase {
    pub(crate) case: Arc<simulate::case::Case>,
    pub(crate) loads: Loads,
    /// The chamber of the mesh that each chamber of the case is.
    numbers: Vec<usize>,
    probes: Vec<simulate::Probe>,
    notes: Vec<String>,
}

/// What the regions of a mesh are made of, region by region.
#[derive(FromPyObject)]
struct Materials {
    #[pyo3(item)]
    law: Vec<String>,
    #[pyo3(item)]
    youngs_modulus: Vec<f64>,
    #[pyo3(item)]
    poissons_ratio: Vec<f64>,
    #[pyo3(item)]
    density: Vec<f64>,
    #[pyo3(item)]
    mean_dilatation: Vec<bool>,
    #[pyo3(item)]
    lumped_mass: bool,
}

impl Materials {
    fn properties(&self) -> PyResult<Vec<RegionProperties>> {
        let properties_of = |(region, name): (usize, &String)| {
            let names: Vec<&str> = fem::materials::ALL.iter().map(|law| law.name()).collect();
            let law = fem::materials::by_name(name).ok_or_else(|| {
                input_error(
                    format!("there is no material `{name}`"),
                    format!("known are {}", names.join(", ")),
                    "name one of them",
                )
            })?;
            let (modulus, ratio) = (self.youngs_modulus[region], self.poissons_ratio[region]);
            Ok(RegionProperties::elastic(law, modulus, ratio, self.density[region]))
        };
        self.law.iter().enumerate().map(properties_of).collect()
    }
}

impl Shared {
    /// The solver, unless another thread is in a solve of it.
    ///
    /// # Errors
    /// `BusyError`
    fn lock_solver(&self) -> PyResult<MutexGuard<'_, Held>> {
        match self.held.try_lock() {
            Ok(held) => Ok(held),
            Err(TryLockError::Poisoned(broken)) => Ok(broken.into_inner()),
            // a solve that Ctrl-C ended is soon over
            Err(TryLockError::WouldBlock) if self.abandoned.load(Ordering::Relaxed) => {
                Ok(self.held.lock().unwrap_or_else(PoisonError::into_inner))
            }
            Err(TryLockError::WouldBlock) => {
                let reason = "a solver keeps one factor, and solves one problem at a time";
                let message = "another thread is in a solve of this solver";
                Err(typed_exception(Kind::Busy, [message, reason, "make a solver for each thread"]))
            }
        }
    }

    fn solve<T: Send>(
        &self,
        signals: &Signals,
        solve: impl FnOnce(&mut Held, &Signals) -> PyResult<T> + Send,
    ) -> PyResult<T> {
        let run = || {
            let mut held = self.lock_solver()?;
            self.abandoned.store(false, Ordering::Relaxed);
            held.solver.set_interrupt(Some(signals.interrupt()));
            let solved = solve(&mut held, signals);
            held.solver.set_interrupt(None);
            solved
        };
        match &self.own {
            None => run(),
            Some(own) => own.install(run),
        }
    }

    /// Numbers of degrees of freedom, nodes, elements and chambers.
    pub(crate) fn size_counts(&self) -> [usize; 4] {
        let mesh = self.system.mesh();
        [self.system.dofs(), mesh.nodes.len(), mesh.elements.len(), mesh.chambers.len()]
    }

    /// A further solver of the body, with these inputs and the gas of its sealed chambers.
    ///
    /// # Errors
    /// A diagnostic where an input is refused.
    pub(crate) fn further_solver(&self, inputs: &Inputs) -> diagnostics::Result<fem::Solver> {
        let mut solver = self.system.solver();
        for (number, ambient) in self.case.iter().flat_map(OfCase::sealed_chambers) {
            solver.set_sealed(number, Some(ambient))?;
        }
        inputs.set(None, &mut solver)?;
        Ok(solver)
    }
}

impl OfCase {
    fn sealed_chambers(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let named = self.case.chamber.iter().zip(&self.numbers);
        named.filter_map(|(chamber, &number)| Some((number, chamber.sealed_in?)))
    }
}

impl Solver {
    fn new(system: System, solver: fem::Solver, case: Option<OfCase>, threads: Option<usize>) -> PyResult<Self> {
        // Each solve of a shared pool spreads over all of it: solvers that solve at once on as many threads of Python then wait for one
        // another, which those with one thread each do not.
        let own = threads.map(OwnThreads::new).transpose()?;
        let held = Mutex::new(Held { solver, applied: None });
        let abandoned = AtomicBool::new(false);
        Ok(Self { shared: Arc::new(Shared { held, system, case, own, abandoned }) })
    }

    /// Runs `solve` on the solver with these inputs, with the interpreter's lock released and Ctrl-C watched.
    ///
    /// # Errors
    /// `BusyError` when another thread is in a solve; what `solve` returns; what a signal handler raised.
    pub(crate) fn run<T: Send + 'static>(
        &self,
        py: Python<'_>,
        inputs: Inputs,
        solve: impl FnOnce(&mut fem::Solver, &Signals) -> PyResult<T> + Send + 'static,
    ) -> PyResult<T> {
        let shared = self.shared.clone();
        self.run_held(py, move |held, signals| {
            held.apply(&inputs)?;
            held.move_clamps(shared.case.as_ref(), 1.0)?;
            solve(&mut held.solver, signals)
        })
    }

    /// As [`Solver::run`], for what sets inputs itself.
    ///
    /// # Errors
    /// As [`Solver::run`].
    pub(crate) fn run_held<T: Send + 'static>(
        &self,
        py: Python<'_>,
        solve: impl FnOnce(&mut Held, &Signals) -> PyResult<T> + Send + 'static,
    ) -> PyResult<T> {
        let shared = self.shared.clone();
        let signals = Signals::default();
        let outcome = run_watched_by(py, &signals, move |signals| shared.solve(signals, solve));
        self.shared.abandoned.fetch_or(signals.is_left(), Ordering::Relaxed);
        outcome
    }

    pub(crate) fn inputs(&self, given: &Bound<'_, PyDict>) -> PyResult<Inputs> {
        Inputs::of(given, self.shared.system.regions().len())
    }
}

#[pymethods]
impl Solver {
    /// Of a case, on its own mesh or on a given one.
    #[staticmethod]
    fn of_case(py: Python<'_>, case: &Case, mesh: &Mesh, threads: Option<usize>) -> PyResult<Self> {
        let (folder, case, kinds) = (case.case_folder(), case.case.clone(), mesh.kinds.clone());
        run_watched(py, move |_| match &*kinds {
            Kinds::Tetrahedra(loaded) => {
                // A mesh that was given has no tables: they are the case's.
                let tables = simulate::tables(&case, &folder).map_err(|diagnostic| case_exception(&diagnostic))?;
                of_case(case, &Loaded { tables, ..loaded.clone() }, threads)
            }
            Kinds::Hexahedra(_) => {
                let reason = "hexahedra of a case are those of a file, which become 20-node ones as they are read";
                let act = "name the file in the case's mesh, or make the solver of the mesh: Solver.of_mesh";
                Err(input_error("a case cannot use a given mesh of hexahedra", reason, act))
            }
        })
    }

    /// Of a mesh with materials by region; what is clamped (3 truth values per node), and the threads of its own.
    #[staticmethod]
    fn of_mesh(
        py: Python<'_>,
        mesh: &Mesh,
        materials: Materials,
        options: (PyReadonlyArray1<'_, bool>, Option<usize>),
    ) -> PyResult<Self> {
        let (clamped, threads) = options;
        let regions = materials.properties()?;
        let Materials { mean_dilatation, lumped_mass, .. } = materials;
        let options = Options { lumped_mass, mean_dilatation, ..Options::default() };
        let mut clamps = Clamps::none();
        let contiguous =
            |_| input_error("clamped is not contiguous", "its rows do not lie one after the other", "pass a copy");
        for (node, axes) in clamped.as_slice().map_err(contiguous)?.as_chunks::<3>().0.iter().enumerate() {
            if axes.contains(&true) {
                clamps.constrain(node as u32, *axes);
            }
        }
        let mesh = mesh.clone();
        run_watched(py, move |_| {
            let system = System::with(mesh.fem_mesh(), regions, clamps, options).map_err(solve_exception)?;
            check_memory(&system)?;
            let solver = system.solver();
            Self::new(system, solver, None, threads)
        })
    }

    /// Numbers of degrees of freedom, nodes, elements and chambers.
    fn sizes(&self) -> [usize; 4] {
        self.shared.size_counts()
    }

    /// Whether each component of the displacement is free, 3 per node.
    fn free<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        PyArray1::from_vec(py, self.shared.system.free_components())
    }

    /// Refuses inputs that are out of range.
    fn check(&self, py: Python<'_>, inputs: &Bound<'_, PyDict>) -> PyResult<()> {
        let inputs = self.inputs(inputs)?;
        self.run(py, inputs, |_, _| Ok(()))
    }

    /// Properties of the regions as the body was made: law, E (Pa), ν, ρ (kg/m³).
    fn properties(&self) -> Vec<(&'static str, f64, f64, f64)> {
        let facts = |is: &RegionProperties| (is.material.name(), is.youngs_modulus, is.poissons_ratio, is.density);
        self.shared.system.regions().iter().map(facts).collect()
    }

    /// Region of each element.
    fn element_regions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        PyArray1::from_vec(py, self.shared.system.mesh().regions.iter().map(|&region| i64::from(region)).collect())
    }

    /// Whether a clamp of the case is displaced.
    fn moves_clamps(&self) -> bool {
        self.shared.case.as_ref().is_some_and(|of| !of.loads.prescribed.is_empty())
    }

    /// What the case says: `forces`, `gravity`, `chambers` (name and number), `points` (name, nodes, weights), `levels`,
    /// `load_steps`, `tolerance`, `dynamic` and `notes`; none without a case.
    fn case_data<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(of) = &self.shared.case else { return Ok(None) };
        let data = PyDict::new(py);
        data.set_item("forces", numpy_array(py, of.loads.forces.clone()))?;
        data.set_item("gravity", numpy_array(py, of.case.gravity.to_vec()))?;
        let names = of.case.chamber.iter().zip(&of.numbers).enumerate();
        let named =
            names.map(|(i, (chamber, &number))| (chamber.name.clone().unwrap_or(format!("chamber_{i}")), number));
        data.set_item("chambers", named.collect::<Vec<_>>())?;
        let points = PyList::empty(py);
        for probe in &of.probes {
            let (nodes, weights): (Vec<i64>, Vec<f64>) = probe.weights.iter().map(|&(n, w)| (i64::from(n), w)).unzip();
            points.append((&probe.name, PyArray1::from_vec(py, nodes), numpy_array(py, weights)))?;
        }
        data.set_item("points", points)?;
        data.set_item("notes", &of.notes)?;
        if let Some(set) = &of.case.statics {
            data.set_item("levels", &set.levels)?;
            data.set_item("load_steps", set.load_steps)?;
            data.set_item("tolerance", set.tolerance)?;
            data.set_item("follows_path", set.arc_length.is_some())?;
            data.set_item("budget", budget_limits(set.budget()))?;
        }
        if let Some(set) = &of.case.dynamic {
            let dynamic = PyDict::new(py);
            dynamic.set_item("duration", set.duration)?;
            dynamic.set_item("step", set.step)?;
            dynamic.set_item("scheme", format!("{:?}", set.scheme))?;
            dynamic.set_item("mass_damping", set.mass_damping)?;
            dynamic.set_item("stiffness_damping", set.stiffness_damping)?;
            dynamic.set_item("adaptive", set.adaptive.map(|of| (of.tolerance, of.shortest, of.longest)))?;
            dynamic.set_item("starts_at_rest", set.start == simulate::case::Start::Rest)?;
            data.set_item("budget", budget_limits(set.budget()))?;
            data.set_item("dynamic", dynamic)?;
        }
        Ok(Some(data))
    }

    /// The case's pressures at each of `times` (s), or at the level of a static case: one per chamber of the mesh, Pa.
    fn case_pressures<'py>(&self, py: Python<'py>, times: Vec<f64>, level: Option<f64>) -> Bound<'py, PyArray1<f64>> {
        let none = vec![0.0; self.shared.size_counts()[3]];
        let case = self.shared.case.as_ref();
        let pressures = match level {
            Some(level) => case.map_or(none, |of| of.loads.pressures_at_level(level)),
            None => times.iter().flat_map(|&t| case.map_or(none.clone(), |of| of.loads.pressures_at(t))).collect(),
        };
        numpy_array(py, pressures)
    }
}

/// Limits as Python has them: iterations, cut-backs and seconds.
type Limits = (Option<usize>, Option<usize>, Option<f64>);

fn budget_limits(of: simulate::Budget) -> Limits {
    (of.max_iterations, of.max_cutbacks, of.timeout)
}

/// The factor of the tangent is the largest part of a solver; it is counted twice, with what is kept beside it.
fn check_memory(system: &System) -> PyResult<()> {
    let (tangent, factor) = system.entries();
    memory::require_free(
        &format!("a solver of {} degrees of freedom", system.dofs()),
        8.0 * (2.0 * factor as f64 + 3.0 * tangent as f64),
    )
}

fn of_case(case: Arc<simulate::case::Case>, loaded: &Loaded, threads: Option<usize>) -> PyResult<Solver> {
    if loaded.solid.half() && case.gravity[2] != 0.0 {
        let reason = "gravity along z breaks the symmetry about z = 0";
        return Err(typed_exception(
            Kind::Case,
            ["gravity on a half model has a part along z", reason, "mesh the whole body"],
        ));
    }
    let body = Body::new(&case, loaded).map_err(|diagnostic| case_exception(&diagnostic))?;
    check_memory(&body.system)?;
    let solver = body.solver(&case).map_err(|diagnostic| case_exception(&diagnostic))?;
    let probes = simulate::probes(&case, &body).map_err(|diagnostic| case_exception(&diagnostic))?;
    let notes = loaded.notes.iter().chain(&body.notes).cloned().collect();
    let loads = body.loads(&case);
    let Body { system, numbers, .. } = body;
    Solver::new(system, solver, Some(OfCase { case, loads, numbers, probes, notes }), threads)
}
