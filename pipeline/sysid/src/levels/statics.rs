//! What finds the equilibria of a model: its finite elements, or a reduced model that they have trained.
//!
//! Either is asked in its own unknowns, displacements of all nodes or reduced coordinates, so that paths and predictions are the same code
//! for both.

use std::sync::Arc;

use fem::{
    Equilibrium, Parameter, ReducedContact, ReducedEquilibrium, ReducedModel, ReducedSolver, Solver, StaticSettings,
};
use nalgebra::{DMatrix, DVector};
use si::{Pascal, Point2};

use crate::model::{BODY, Elastic, Model};
use diagnostics::{Diagnostic, Result};

/// An equilibrium in the unknowns of what found it.
#[derive(Debug, Clone)]
pub(crate) struct EquilibriumShape {
    /// Displacements of all nodes, m, 3 a node; or reduced coordinates.
    pub unknowns: Vec<f64>,
    /// Factorisations that it took.
    pub factorisations: usize,
}

/// What finds equilibria, one after the other; derivatives are those at the last one.
pub(crate) trait Statics: Send + Sync {
    /// Sets the constants.
    ///
    /// # Errors
    /// A [`Diagnostic`] when one is out of range.
    fn set_constants(&mut self, elastic: &Elastic) -> Result<()>;

    /// The equilibrium under `pressures` (one a chamber, Pa) near a shape `predicted` from known ones, of which `nearby` is the nearest.
    ///
    /// # Errors
    /// A [`Diagnostic`] where there is none.
    fn equilibrium_near(
        &mut self,
        pressures: &[Pascal],
        nearby: &[f64],
        predicted: &[f64],
        settings: &StaticSettings,
    ) -> Result<EquilibriumShape>;

    /// Derivatives of the unknowns by each parameter.
    ///
    /// # Errors
    /// A [`Diagnostic`] when no equilibrium was found before, or it is not stable.
    fn sensitivities(&mut self, parameters: &[Parameter]) -> Result<Vec<Vec<f64>>>;

    /// The derivative of a loss by E of every solid (1/Pa), from that by each marker's displacement (1/m).
    ///
    /// # Errors
    /// As [`Statics::sensitivities`].
    fn loss_by_moduli(&mut self, by_markers: &[Point2]) -> Result<Vec<f64>>;
}

/// In which unknowns the equilibria of a model are sought.
#[derive(Clone)]
pub(crate) enum Unknowns {
    /// Displacements of all nodes.
    Nodes(Model),
    /// Coordinates of a reduced model.
    Coordinates(Arc<ReducedShapes>),
}

/// A reduced model with the markers of the whole one.
pub(crate) struct ReducedShapes {
    model: Arc<ReducedModel>,
    regions: Vec<fem::RegionProperties>,
    contact: Option<Arc<ReducedContact>>,
    /// Displacement of each marker in the plane by coordinate: 2 markers × coordinates.
    markers: DMatrix<f64>,
}

impl ReducedShapes {
    /// Of the `reduced` model of `whole`, with contact between walls that came close to each other in one of the `shapes` (m, 3 a node).
    ///
    /// # Errors
    /// A [`Diagnostic`] when a shape is not one of this body.
    pub fn new(whole: &Model, reduced: ReducedModel, shapes: &[&[f64]]) -> Result<Self> {
        let contact = whole.system.reduced_contact(&reduced, shapes)?.map(Arc::new);
        let row = |spot: &mesh::Spot, axis: usize| {
            let mut row = DVector::zeros(reduced.coordinates());
            for &(node, weight) in &spot.weights {
                let of_node = DVector::from_iterator(row.len(), reduced.row(3 * node as usize + axis));
                row.axpy(weight, &of_node, 1.0);
            }
            row.transpose()
        };
        let rows: Vec<_> = whole.markers.iter().flat_map(|spot| [row(spot, 0), row(spot, 1)]).collect();
        let (regions, markers) = (whole.system.regions().to_vec(), DMatrix::from_rows(&rows));
        Ok(Self { regions, contact, markers, model: Arc::new(reduced) })
    }

    /// The coordinates nearest to a displacement of all nodes (m, 3 a node).
    pub fn projected(&self, displacement: &[f64]) -> Vec<f64> {
        self.model.projected(displacement).data.into()
    }
}

impl Unknowns {
    /// Their number.
    pub fn count(&self) -> usize {
        match self {
            Self::Nodes(model) => 3 * model.system.mesh().nodes.len(),
            Self::Coordinates(shapes) => shapes.model.coordinates(),
        }
    }

    /// A solver in them.
    pub fn solver(&self) -> Box<dyn Statics> {
        match self {
            Self::Nodes(model) => Box::new(WholeBody {
                solver: model.system.solver(),
                model: model.clone(),
                last: Equilibrium::default(),
            }),
            Self::Coordinates(shapes) => Box::new(ReducedBody {
                solver: ReducedSolver::new(Arc::clone(&shapes.model), shapes.regions.clone())
                    .in_contact(shapes.contact.clone()),
                shapes: Arc::clone(shapes),
                last: None,
            }),
        }
    }

    /// Displacement of each marker in the plane, m.
    pub fn markers(&self, unknowns: &[f64]) -> Vec<Point2> {
        match self {
            Self::Nodes(model) => model.markers.iter().map(|spot| Model::in_plane(spot, unknowns)).collect(),
            Self::Coordinates(shapes) => {
                let displacements = &shapes.markers * DVector::from_column_slice(unknowns);
                displacements
                    .as_slice()
                    .chunks_exact(2)
                    .map(|displacement| [displacement[0], displacement[1]])
                    .collect()
            }
        }
    }

    /// Displacement of every node, m, 3 a node.
    pub fn displacement(&self, unknowns: &[f64]) -> Vec<f64> {
        match self {
            Self::Nodes(_) => unknowns.to_vec(),
            Self::Coordinates(shapes) => shapes.model.displacement(&DVector::from_column_slice(unknowns)),
        }
    }
}

/// All nodes of the finite elements.
struct WholeBody {
    solver: Solver,
    model: Model,
    last: Equilibrium,
}

impl Statics for WholeBody {
    fn set_constants(&mut self, elastic: &Elastic) -> Result<()> {
        elastic.apply(&mut self.solver)
    }

    fn equilibrium_near(
        &mut self,
        pressures: &[Pascal],
        nearby: &[f64],
        predicted: &[f64],
        settings: &StaticSettings,
    ) -> Result<EquilibriumShape> {
        self.last = self.solver.equilibrium_near(pressures, nearby, predicted, settings)?;
        let Equilibrium { displacement, factorisations, .. } = &self.last;
        Ok(EquilibriumShape { unknowns: displacement.clone(), factorisations: *factorisations })
    }

    // A factor of its own: the one that Newton's method left would need some ten iterations for each parameter.
    fn sensitivities(&mut self, parameters: &[Parameter]) -> Result<Vec<Vec<f64>>> {
        if parameters.len() > 1 {
            self.solver.factorise_at(&self.last)?;
        }
        parameters.iter().map(|&parameter| Ok(self.solver.sensitivity(&self.last, parameter)?)).collect()
    }

    fn loss_by_moduli(&mut self, by_markers: &[Point2]) -> Result<Vec<f64>> {
        let mut by_displacement = vec![0.0; self.last.displacement.len()];
        for (spot, gradient) in self.model.markers.iter().zip(by_markers) {
            for &(node, weight) in &spot.weights {
                (0..2).for_each(|axis| by_displacement[3 * node as usize + axis] += weight * gradient[axis]);
            }
        }
        let regions = self.solver.adjoint(&self.last, &by_displacement)?;
        Ok(regions.iter().map(|region| region.youngs_modulus).collect())
    }
}

/// Coordinates of a reduced model.
struct ReducedBody {
    solver: ReducedSolver,
    shapes: Arc<ReducedShapes>,
    last: Option<ReducedEquilibrium>,
}

impl ReducedBody {
    fn last_equilibrium(&self) -> Result<&ReducedEquilibrium> {
        self.last.as_ref().ok_or_else(|| {
            let reason = "no equilibrium was solved for before";
            Diagnostic::new("a reduced body has no derivatives yet", reason, "report it with the card")
        })
    }
}

impl Statics for ReducedBody {
    fn set_constants(&mut self, elastic: &Elastic) -> Result<()> {
        for (region, (e, nu)) in elastic.youngs_moduli.iter().zip(&elastic.poissons_ratios).enumerate() {
            self.solver.set_elastic(region, *e, *nu)?;
        }
        Ok(self.solver.set_stiffening(BODY, elastic.stiffening)?)
    }

    // A step of a reduced body costs milliseconds: tolerance and iterations are its own.
    fn equilibrium_near(
        &mut self,
        pressures: &[Pascal],
        nearby: &[f64],
        predicted: &[f64],
        _: &StaticSettings,
    ) -> Result<EquilibriumShape> {
        let [nearby, predicted] = [nearby, predicted].map(DVector::from_column_slice);
        let equilibrium = self.solver.equilibrium_near(pressures, &nearby, &predicted)?;
        let unknowns = equilibrium.coordinates.data.as_vec().clone();
        self.last = Some(equilibrium);
        Ok(EquilibriumShape { unknowns, factorisations: 0 })
    }

    fn sensitivities(&mut self, parameters: &[Parameter]) -> Result<Vec<Vec<f64>>> {
        let last = self.last_equilibrium()?;
        let sensitivity = |parameter: &Parameter| Ok(self.solver.sensitivity(last, *parameter)?.data.into());
        parameters.iter().map(sensitivity).collect()
    }

    fn loss_by_moduli(&mut self, by_markers: &[Point2]) -> Result<Vec<f64>> {
        let by_markers = DVector::from_iterator(2 * by_markers.len(), by_markers.iter().flatten().copied());
        let by_coordinates = self.shapes.markers.tr_mul(&by_markers);
        let moduli: Vec<Parameter> = (0..self.shapes.regions.len()).map(Parameter::YoungsModulus).collect();
        Ok(self.solver.adjoint(self.last_equilibrium()?, &by_coordinates, &moduli)?)
    }
}
