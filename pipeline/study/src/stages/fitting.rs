//! The identification problem: pressure levels of all films of a specimen, the model, and the bounds of both moduli.

use optimize::Residuals;
use optimize::optimisers::gauss_newton;
use serde::{Deserialize, Serialize};
use si::{Metre, Point2, Second};

use super::mesh;
use super::plateaus::{held_times, pressure_levels};
use super::walls::WallGauge;
use diagnostics::{Diagnostic, Result};
use records::selections::IdentificationTrials;
use records::subject::Specimen;
use records::{Markers, Mesh, Motion, NoiseModel};
use sysid::{Body, Discrepancy, Loss, Minimum, Misfit, ModuliSearch, SearchModel};
use workflow::stage::StageContext;
use workflow::subject::Part;

/// `[identify]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// In what the search simulates: `whole`, or `reduced`, certified by the whole body at its end.
    pub(super) model: SearchModel,
    /// The fraction at the end of each hold that counts as settled, 0 to 1.
    pub(super) settled_fraction: f64,
    /// The shortest hold that counts, s.
    pub(super) shortest_hold: Second,
    /// Standard deviation of the model discrepancy by which a displacement is weighed in the search, m.
    pub(super) discrepancy: Metre,
    /// Standard deviation of the common scale error of all displacements of a film by which they are weighed, no unit.
    pub(super) scale_sigma: f64,
    /// The middle of the prior of the discrepancy that the residuals show: standard deviation of a chamber's scale, no unit.
    pub(super) prior_scale_sigma: f64,
    /// Of the deviation of the shape, over the displacement, no unit.
    pub(super) prior_shape_sigma: f64,
    /// Distance over which that deviation is correlated, over the specimen's length.
    pub(super) prior_correlation_length: f64,
    /// Logarithm of the ratio of pressures over which it is correlated.
    pub(super) prior_correlation_log_pressure: f64,
    /// Target length of an edge of the finer mesh on which the discretisation error is estimated, m.
    pub(super) fine_edge: Metre,
    /// Standard deviations of the prior of C₂₀/C₁₀ and C₃₀/C₁₀ about the card's, where the softest solid's law stiffens and the card has none
    /// of its own; no unit.
    pub(super) stiffening_sigma: [f64; 2],
    /// Gauss-Newton's simulations at most.
    pub(super) gauss_newton_iterations: usize,
    /// Tolerance of a step: a search has converged when no logarithm of a modulus changes by more.
    pub(super) step_tolerance: f64,
    /// Tolerance of an equilibrium: Newton has converged when no node moves by more than this fraction of the specimen's size.
    pub(super) static_tolerance: f64,
    /// Equilibria solved in parallel.
    pub(super) parallel_solves: usize,
}

impl Settings {
    /// The discrepancy before it is estimated, of a specimen of this length.
    fn prior_discrepancy(&self, length: Metre) -> Discrepancy {
        Discrepancy {
            scale_sigma: self.prior_scale_sigma,
            film_sigma: self.scale_sigma,
            shape_sigma: self.prior_shape_sigma,
            correlation_length_m: self.prior_correlation_length * length,
            correlation_log_pressure: self.prior_correlation_log_pressure,
        }
    }
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    pub(super) name: String,
    pub(super) mesh: mesh::Card,
    pub(super) body: Body,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        Self { name: of.card.name.clone(), mesh: Part::part_of(of), body: Body::of(&of.card) }
    }
}

/// Model and data of one identification.
pub(crate) struct Fitting<'a> {
    pub(super) set: &'a Settings,
    pub(super) loss: Loss<'a>,
    pub(super) noise: NoiseModel,
    /// Time after loading to which the moduli belong, s.
    pub(super) modulus_time: Second,
    /// Trial and rest places of each level.
    pub(super) origins: Vec<(String, Vec<Point2>)>,
}

/// The films of a specimen: motion, and the markers with the contributions to their covariance.
pub type Films = (IdentificationTrials<Motion>, IdentificationTrials<Markers>);

impl<'a> Fitting<'a> {
    /// The levels of all films, the model, and the bounds of the search.
    ///
    /// # Errors
    /// A [`Diagnostic`] when there is no film, a film holds no pressure, or the simulator refuses the mesh.
    pub fn new(card: &'a Card, set: &'a Settings, mesh: &'a Mesh, films: &Films) -> Result<Self> {
        let (mut levels_of_films, mut origins, mut counts, mut hold_times) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for ((trial, motion), (_, markers)) in films.0.0.iter().zip(&films.1.0) {
            let levels = pressure_levels(motion, markers, set.settled_fraction, set.shortest_hold)
                .map_err(|d| d.while_doing(&trial.0))?;
            origins.extend(levels.iter().map(|_| (trial.0.clone(), motion.rest.clone())));
            counts.push(levels.len());
            hold_times.extend(held_times(motion, set.settled_fraction, set.shortest_hold));
            levels_of_films.extend(levels);
        }
        if levels_of_films.is_empty() {
            return Err(no_film(&card.name));
        }
        let model = mesh.model(&card.body)?.with_markers_at(&mesh.solid, &card.body, &mean_rest(&films.0));
        let noise = NoiseModel { discrepancy_m: set.discrepancy, scale_sigma: set.scale_sigma };
        let misfit = Misfit::new(levels_of_films, &counts, &noise, card.body.length)?;
        let loss = Loss { body: &card.body, model, misfit, gauge: WallGauge::new(mesh).of_levels() };
        let modulus_time = hold_times.iter().sum::<Second>() / hold_times.len().max(1) as f64;
        Ok(Self { set, loss, noise, modulus_time, origins })
    }

    /// The discrepancy that the residuals of a search show.
    pub(super) fn estimated_discrepancy(&self, (residuals, parameters): (&Residuals, usize)) -> Result<Discrepancy> {
        Discrepancy::estimated(
            &self.loss.misfit,
            residuals,
            parameters,
            &self.set.prior_discrepancy(self.loss.body.length),
        )
    }

    /// Searches moduli and stiffening by the Gauss-Newton method.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the method cannot continue.
    pub fn minimise(&mut self, context: &dyn StageContext) -> Result<Minimum> {
        let Settings { model, stiffening_sigma, static_tolerance, parallel_solves, .. } = *self.set;
        let method = gauss_newton::Settings {
            step_tolerance: self.set.step_tolerance,
            iterations: self.set.gauss_newton_iterations,
            ..gauss_newton::Settings::default()
        };
        let search = ModuliSearch { model, method, stiffening_sigma, static_tolerance, parallel_solves };
        search.minimise(&mut self.loss, &|how| context.progress(0.5, how))
    }
}

/// Measured positions of the markers at rest: the mean over films, m.
pub(crate) fn mean_rest(films: &IdentificationTrials<Motion>) -> Vec<Point2> {
    let count = films.0.len().max(1) as f64;
    let first = films.0.first().map(|(_, m)| m.rest.len()).unwrap_or_default();
    let mean = |m: usize, k: usize| films.0.iter().map(|(_, motion)| motion.rest[m][k]).sum::<f64>() / count;
    (0..first).map(|m| [mean(m, 0), mean(m, 1)]).collect()
}

fn no_film(name: &str) -> Diagnostic {
    Diagnostic::new(
        format!("`{}` has no trial to identify from", name),
        "no [[trial]] on its card has role = \"identify\"",
        "give a staircase that role",
    )
}
