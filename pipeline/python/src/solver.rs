//! Solvers of one body: made of a case or of arrays, and the facts about the body that Python needs.

use std::sync::{Arc, Mutex};

use fem::{Clamps, Interrupt, Options, RegionProperties, System};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rayon::ThreadPool;
use simulate::{Body, Loaded};

use crate::arrays::array;
use crate::case::{Case, refusal};
use crate::errors::{Kind, exception, raised, refused};
use crate::inputs::Inputs;
use crate::interrupt::{Signals, watched};
use crate::mesh::{Kinds, Mesh};

/// A solver with the inputs that it has.
pub(crate) struct Held {
    pub(crate) solver: fem::Solver,
    applied: Option<Inputs>,
}

impl Held {
    /// Sets the inputs of the next solve.
    pub(crate) fn apply(&mut self, inputs: Inputs) -> PyResult<()> {
        // Where one is refused, those before it are set: nothing is then known of the solver.
        let before = self.applied.take();
        inputs.apply(before.as_ref(), &mut self.solver)?;
        self.applied = Some(inputs);
        Ok(())
    }
}

/// A solver of one body.
#[pyclass(frozen, module = "softfish._core")]
pub(crate) struct Solver {
    held: Mutex<Held>,
    pub(crate) system: System,
    case: Option<OfCase>,
    /// Threads of its own; those that all solvers share where it has none.
    pool: Option<ThreadPool>,
}

/// What a solver knows of its case.
struct OfCase {
    case: Arc<simulate::case::Case>,
    /// 3 entries per node, N.
    forces: Vec<f64>,
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
        let of = |(region, name): (usize, &String)| {
            let known: Vec<&str> = fem::materials::ALL.iter().map(|law| law.name()).collect();
            let law = fem::materials::by_name(name).ok_or_else(|| {
                refused(
                    format!("there is no material `{name}`"),
                    format!("known are {}", known.join(", ")),
                    "name one of them",
                )
            })?;
            let (modulus, ratio) = (self.youngs_modulus[region], self.poissons_ratio[region]);
            Ok(RegionProperties::elastic(law, modulus, ratio, self.density[region]))
        };
        self.law.iter().enumerate().map(of).collect()
    }
}

impl Solver {
    fn new(system: System, solver: fem::Solver, case: Option<OfCase>) -> Self {
        Self { held: Mutex::new(Held { solver, applied: None }), system, case, pool: None }
    }

    /// The same on so many threads of its own. Each solve of a shared pool spreads over all of it: solvers that solve at once on as many
    /// threads of Python then wait for one another, which those with one thread each do not.
    fn on_threads(mut self, threads: Option<usize>) -> PyResult<Self> {
        let pool = |count| {
            let built = rayon::ThreadPoolBuilder::new().num_threads(count).build();
            built.map_err(|e| refused(format!("{count} threads cannot be had"), e.to_string(), "ask for fewer"))
        };
        self.pool = threads.map(pool).transpose()?;
        Ok(self)
    }

    /// Runs `solve` on the solver, with the interpreter's lock released and Ctrl-C watched.
    ///
    /// # Errors
    /// `BusyError` when another thread is in a solve; what `solve` returns; what a signal handler raised.
    pub(crate) fn run<T: Send>(
        &self,
        py: Python<'_>,
        inputs: Inputs,
        solve: impl FnOnce(&mut fem::Solver, &Signals) -> PyResult<T> + Send,
    ) -> PyResult<T> {
        let busy = || {
            let why = "a solver keeps one factor, and solves one problem at a time";
            exception(Kind::Busy, ["another thread is in a solve of this solver", why, "make a solver for each thread"])
        };
        let signals = Signals::new();
        let run = |interrupt: Interrupt| {
            let mut held = match self.held.try_lock() {
                Ok(held) => held,
                Err(std::sync::TryLockError::Poisoned(broken)) => broken.into_inner(),
                Err(std::sync::TryLockError::WouldBlock) => return Err(busy()),
            };
            held.apply(inputs)?;
            held.solver.set_interrupt(Some(interrupt));
            let solved = solve(&mut held.solver, &signals);
            held.solver.set_interrupt(None);
            solved
        };
        let solved = match &self.pool {
            None => py.detach(|| run(signals.interrupt())),
            // A signal is heard on the calling thread alone; a progress callback raises through `signals`.
            Some(pool) => watched(py, |ended| {
                let own = signals.clone();
                let interrupt: Interrupt = Arc::new(move || ended() || own.is_raised());
                pool.install(|| run(interrupt))
            }),
        };
        signals.outcome(solved)
    }

    pub(crate) fn inputs(&self, given: &Bound<'_, PyDict>) -> PyResult<Inputs> {
        Inputs::of(given, self.system.regions().len())
    }
}

#[pymethods]
impl Solver {
    /// Of a case, on its own mesh or on a given one.
    #[staticmethod]
    fn of_case(py: Python<'_>, case: &Case, mesh: &Mesh, threads: Option<usize>) -> PyResult<Self> {
        let Kinds::Tetrahedra(loaded) = &*mesh.kinds else {
            let why = "places of a case are found on a skin of triangles";
            return Err(refused(
                "a case cannot use a mesh of hexahedra",
                why,
                "make the solver of the mesh: Solver.of_mesh",
            ));
        };
        py.detach(|| of_case(case, loaded))?.on_threads(threads)
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
            |_| refused("clamped is not contiguous", "its rows do not lie one after the other", "pass a copy");
        for (node, axes) in clamped.as_slice().map_err(contiguous)?.as_chunks::<3>().0.iter().enumerate() {
            if axes.contains(&true) {
                clamps.constrain(node as u32, *axes);
            }
        }
        let system = py.detach(|| System::with(mesh.fem_mesh(), regions, clamps, options)).map_err(raised)?;
        let solver = system.solver();
        Self::new(system, solver, None).on_threads(threads)
    }

    /// Numbers of degrees of freedom, nodes, elements and chambers.
    fn sizes(&self) -> [usize; 4] {
        let mesh = self.system.mesh();
        [self.system.dofs(), mesh.nodes.len(), mesh.elements.len(), mesh.chambers.len()]
    }

    /// Properties of the regions as the body was made: law, E (Pa), ν, ρ (kg/m³).
    fn properties(&self) -> Vec<(&'static str, f64, f64, f64)> {
        let of = |is: &RegionProperties| (is.material.name(), is.youngs_modulus, is.poissons_ratio, is.density);
        self.system.regions().iter().map(of).collect()
    }

    /// Region of each element.
    fn element_regions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        PyArray1::from_vec(py, self.system.mesh().regions.iter().map(|&region| i64::from(region)).collect())
    }

    /// What the case says: `forces`, `gravity`, `chambers` (name and number), `points` (name, nodes, weights), `levels`,
    /// `load_steps`, `tolerance`, `dynamic` and `notes`; none without a case.
    fn case_data<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(of) = &self.case else { return Ok(None) };
        let data = PyDict::new(py);
        data.set_item("forces", array(py, of.forces.clone()))?;
        data.set_item("gravity", array(py, of.case.gravity.to_vec()))?;
        let names = of.case.chamber.iter().zip(&of.numbers).enumerate();
        let named =
            names.map(|(i, (chamber, &number))| (chamber.name.clone().unwrap_or(format!("chamber_{i}")), number));
        data.set_item("chambers", named.collect::<Vec<_>>())?;
        let points = PyList::empty(py);
        for probe in &of.probes {
            let (nodes, weights): (Vec<i64>, Vec<f64>) = probe.weights.iter().map(|&(n, w)| (i64::from(n), w)).unzip();
            points.append((&probe.name, PyArray1::from_vec(py, nodes), array(py, weights)))?;
        }
        data.set_item("points", points)?;
        data.set_item("notes", &of.notes)?;
        if let Some(set) = &of.case.statics {
            data.set_item("levels", &set.levels)?;
            data.set_item("load_steps", set.load_steps)?;
            data.set_item("tolerance", set.tolerance)?;
        }
        if let Some(set) = &of.case.dynamic {
            let dynamic = PyDict::new(py);
            dynamic.set_item("duration", set.duration)?;
            dynamic.set_item("step", set.step)?;
            dynamic.set_item("scheme", format!("{:?}", set.scheme))?;
            dynamic.set_item("mass_damping", set.mass_damping)?;
            dynamic.set_item("stiffness_damping", set.stiffness_damping)?;
            data.set_item("dynamic", dynamic)?;
        }
        Ok(Some(data))
    }

    /// The case's pressures at each of `times` (s), or at the level of a static case: one per chamber of the mesh, Pa.
    fn case_pressures<'py>(&self, py: Python<'py>, times: Vec<f64>, level: Option<f64>) -> Bound<'py, PyArray1<f64>> {
        let count = self.system.mesh().chambers.len();
        let at = |value: &dyn Fn(&simulate::case::Chamber) -> f64| {
            let mut pressures = vec![0.0; count];
            if let Some(of) = &self.case {
                of.case
                    .chamber
                    .iter()
                    .zip(&of.numbers)
                    .for_each(|(chamber, &number)| pressures[number] = value(chamber));
            }
            pressures
        };
        let all = match level {
            Some(level) => at(&|chamber| chamber.pressure.at_level(level)),
            None => times.iter().flat_map(|&time| at(&|chamber| chamber.pressure.at(time))).collect(),
        };
        array(py, all)
    }
}

fn of_case(case: &Case, loaded: &Loaded) -> PyResult<Solver> {
    let of = &case.case;
    let body = Body::new(of, loaded).map_err(|diagnostic| refusal(&diagnostic))?;
    let solver = body.solver(of).map_err(|diagnostic| refusal(&diagnostic))?;
    let probes = simulate::probes(of, &body).map_err(|diagnostic| refusal(&diagnostic))?;
    let notes = loaded.notes.iter().chain(&body.notes).cloned().collect();
    let Body { system, forces, numbers, .. } = body;
    let kept = OfCase { case: of.clone(), forces, numbers, probes, notes };
    Ok(Solver::new(system, solver, Some(kept)))
}
