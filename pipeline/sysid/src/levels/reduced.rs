//! The levels of a solver in a reduced model that its own equilibria train.
//!
//! Shapes over moduli, Poisson's ratios, stiffening and pressure, through the buckle of a thin wall, lie close to a space of some thirty
//! dimensions. A search that follows load paths of the whole body at each of its points solves for the same shapes again and again; in this
//! space a level takes milliseconds. What the model leaves out is corrected at the point where the whole body was solved last, so that a
//! search ends where that body's own would.

use fem::{Mesh, ReductionSettings, RegionProperties, Snapshot};
use si::Point2;

use super::level::{Derivatives, LevelCorrection, PressureLevel, SimulatedLevel};
use super::solver::LevelSolver;
use super::statics::{ReducedShapes, Unknowns};
use crate::interpolation::spots_inside;
use crate::model::{BODY, Elastic};
use crate::surrogate::{KnownShape, Load, Slope, Surrogate};
use diagnostics::Result;

/// Coordinates at most, and the tolerance of the cubature: relative error of displacements.
const SETTINGS: ReductionSettings = ReductionSettings { coordinates: 44, least_share: 1e-10, tolerance: 3e-4 };
/// Equilibria whose loads are nearer to each other than this teach the same.
const APART: f64 = 0.02;

/// What was simulated on a mesh.
#[derive(Debug, Clone, Copy)]
pub struct SimulatedMesh<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The constants.
    pub elastic: &'a Elastic,
    /// The pressure levels.
    pub levels: &'a [PressureLevel],
    /// What came of each.
    pub simulated: &'a [SimulatedLevel],
}

impl LevelSolver {
    /// The same levels in a reduced model trained on the equilibria that this solver knows, with their derivatives.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when it knows none, or the body cannot be reduced.
    pub(crate) fn train_reduced(&self) -> Result<Self> {
        let training_shapes = self.known.newest_apart(APART);
        let regions: Vec<Vec<RegionProperties>> =
            training_shapes.iter().map(|shape| self.regions_under(&shape.load)).collect();
        let changes: Vec<Vec<Vec<f64>>> = training_shapes.iter().map(|shape| scaled_changes(shape)).collect();
        let training: Vec<Snapshot> = training_shapes
            .iter()
            .zip(regions.iter().zip(&changes))
            .map(|(shape, (regions, changes))| Snapshot { displacement: &shape.shape, regions, changes })
            .collect();
        let reduced = self.model().system.reduce_trained(&training, &SETTINGS)?;
        let displacements: Vec<&[f64]> = training.iter().map(|snapshot| snapshot.displacement).collect();
        let shapes = ReducedShapes::new(self.model(), reduced, &displacements)?;
        let mut coordinates = Surrogate::default();
        training_shapes.iter().rev().for_each(|shape| coordinates.add(projected_shape(shape, &shapes)));
        Ok(self.seeking(Unknowns::Coordinates(shapes.into()), coordinates))
    }

    /// Corrects the markers of each level, and their `derivatives`, by what those of the `whole` body, at the same constants, differ from its
    /// own.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when it finds no equilibrium there.
    // A search ends where the residuals along its own derivatives vanish: with the markers alone corrected, the modulus of a coarse tail was 0.3 %
    // off, and the interval of its sheet a tenth too narrow.
    pub(crate) fn correct_markers(
        &mut self,
        elastic: &Elastic,
        derivatives: Derivatives,
        whole: &[SimulatedLevel],
    ) -> Result<()> {
        self.corrections = Vec::new();
        let reduced_levels = self.solve(elastic, derivatives)?;
        let difference = |(whole, reduced): (&Point2, &Point2)| [whole[0] - reduced[0], whole[1] - reduced[1]];
        // length: the same markers
        let differences = |whole: &[Point2], reduced: &[Point2]| -> Vec<Point2> {
            whole.iter().zip(reduced).map(difference).collect()
        };
        let level_correction = |(whole, reduced): (&SimulatedLevel, &SimulatedLevel)| LevelCorrection {
            markers: differences(&whole.markers, &reduced.markers),
            // length: of the same parameters
            sensitivities: whole
                .sensitivities
                .iter()
                .zip(&reduced.sensitivities)
                .map(|(whole, reduced)| differences(whole, reduced))
                .collect(),
        };
        self.corrections = whole.iter().zip(&reduced_levels).map(level_correction).collect();
        Ok(())
    }

    /// Takes these `simulated` levels as guesses of its own at the same constants.
    pub(crate) fn add_guesses(&mut self, elastic: &Elastic, simulated: &[SimulatedLevel]) {
        for (level, simulated) in self.levels.iter().zip(simulated) {
            let load = Load::new(level.filled(), level.top(), elastic, self.unit);
            self.known.add(KnownShape::new(load, simulated.displacement.clone()));
        }
    }

    /// The same of levels that were simulated on another mesh of the body: their displacements, at the nodes of this one.
    pub fn add_guesses_of_mesh(&mut self, other: &SimulatedMesh) {
        let spots = spots_inside(other.mesh, &self.model().system.mesh().nodes);
        // length: both are the levels of one simulation
        for (level, simulated) in other.levels.iter().zip(other.simulated) {
            let (displacements, _) = simulated.displacement.as_chunks::<3>();
            let shape = spots.iter().flat_map(|spot| spot.at(displacements)).collect();
            let load = Load::new(level.filled(), level.top(), other.elastic, self.unit);
            self.known.add(KnownShape::new(load, shape));
        }
    }

    /// The regions of a body with this load; the modulus that all of its stresses share does not matter.
    fn regions_under(&self, load: &Load) -> Vec<RegionProperties> {
        let model = self.model();
        let (_, elastic) = load.constants(model.nominal.youngs_moduli[BODY], self.unit);
        let mut regions = model.system.regions().to_vec();
        for (region, (e, nu)) in regions.iter_mut().zip(elastic.youngs_moduli.iter().zip(&elastic.poissons_ratios)) {
            (region.youngs_modulus, region.poissons_ratio) = (*e, *nu);
        }
        regions[BODY].stiffening = elastic.stiffening;
        regions
    }
}

/// The changes of a shape by each coordinate of its load as far as a search may move it.
fn scaled_changes(shape: &KnownShape) -> Vec<Vec<f64>> {
    let scaled = |Slope { coordinate, slope }: &Slope| {
        let spread = shape.load.spread(*coordinate);
        slope.iter().map(|derivative| spread * derivative).collect()
    };
    shape.slopes.iter().map(scaled).collect()
}

/// A known shape in reduced coordinates.
fn projected_shape(shape: &KnownShape, onto: &ReducedShapes) -> KnownShape {
    let slope = |full: &Slope| Slope { coordinate: full.coordinate, slope: onto.projected(&full.slope) };
    KnownShape {
        load: shape.load.clone(),
        shape: onto.projected(&shape.shape),
        slopes: shape.slopes.iter().map(slope).collect(),
    }
}
