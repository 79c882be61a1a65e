//! The search of the solids' moduli and, where the softest one's law stiffens, of its stiffening: by the whole body, or in a reduced model that
//! the whole body certifies.
//!
//! A search of two to four parameters by the Gauss-Newton method needs three to five evaluations, and equilibria near known ones are cheaper
//! than what trains a reduced model for them: a thin tail of 38,649 unknowns and 14 levels is searched in 142 s by the whole body and in 403 s in
//! a reduced model, whose answer differs by 0.06 % (body) and 0.15 % (sheet). Reduced models pay where a search needs hundreds of evaluations,
//! as those of [`crate::TrainedBox`], or leaves the neighbourhood of what is known.
//!
//! The stiffening is identified before the moduli, whose search keeps it: the least misfit of both together is also the least one over the
//! moduli at that stiffening, and landscape and searches stay over two parameters as in the paper.

use std::time::Instant;

use optimize::Problem;
use optimize::optimisers::{self, gauss_newton};
use serde::{Deserialize, Serialize};

use crate::certified::{Certificate, Certified, CertifiedSearch, SearchDurations};
use crate::levels::{Derivatives, LevelSolver, SimulatedLevel};
use crate::loss::{Loss, SearchResult};
use crate::model::{BODY, Elastic};
use crate::search::feasible_start_bound;
use crate::stiffening::{Stiffened, StiffeningProblem};
use diagnostics::{Diagnostic, Result};

/// In what a search simulates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SearchModel {
    /// A reduced model, certified by the whole body.
    Reduced,
    /// The whole body at every point.
    Whole,
}

/// How moduli are searched.
#[derive(Debug, Clone)]
pub struct ModuliSearch {
    /// In what it simulates.
    pub model: SearchModel,
    /// Settings of the Gauss-Newton method.
    pub method: gauss_newton::Settings,
    /// Standard deviations of the prior of C₂₀/C₁₀ and C₃₀/C₁₀ about the nominal ones.
    pub stiffening_sigma: [f64; 2],
    /// Tolerance of an equilibrium of the whole body.
    pub static_tolerance: f64,
    /// Equilibria solved in parallel.
    pub parallel_solves: usize,
}

/// The least misfit.
pub struct Minimum {
    /// The search of the moduli at the stiffening that was found.
    pub moduli: SearchResult,
    /// Its names, start and bounds.
    pub problem: Problem,
    /// Moduli and stiffening found together; none where the law does not stiffen.
    pub stiffened: Option<Stiffened>,
    /// The whole body there.
    pub levels: Vec<SimulatedLevel>,
    /// How well the reduced model served; or why one that was asked for did not.
    pub certificate: Result<Certificate, String>,
    /// How long it took; the whole body is not trained.
    pub durations: SearchDurations,
    /// Time of all simulations of the search by the whole body with their derivatives over that of the equilibria alone.
    pub gradient_over_forward: f64,
}

/// What one search finds.
type Found = (SearchResult, Problem, Option<Stiffened>);

impl ModuliSearch {
    /// Searches the least misfit. The loss then has the stiffening that was found. `progress` is called with what is done.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a method cannot continue or there is no equilibrium.
    // A body that cannot be reduced, or whose answer the whole body does not have, is searched by the whole body: that takes longer, and the
    // record says why.
    pub fn minimise(&self, loss: &mut Loss, progress: &dyn Fn(&str)) -> Result<Minimum> {
        let nominal = loss.model.nominal.stiffening;
        let refused = match self.model {
            SearchModel::Whole => None,
            SearchModel::Reduced => match self.search_certified(loss, nominal, progress) {
                Ok(minimum) => return Ok(minimum),
                Err(diagnostic) => Some(diagnostic.what),
            },
        };
        progress("in the whole body");
        let began = Instant::now();
        let mut full_solver = loss.solver(self.static_tolerance, self.parallel_solves);
        let (elastic, (moduli, problem, stiffened)) = self.search_with(loss, nominal, &mut full_solver)?;
        let levels = full_solver.solve(&elastic, Derivatives::None)?;
        Ok(Minimum {
            moduli,
            problem,
            stiffened,
            levels,
            certificate: refused
                .map_or_else(|| Ok(Certificate::of_whole_body(full_solver.solve_totals().equilibria)), Err),
            durations: SearchDurations { training: 0.0, search: began.elapsed().as_secs_f64() },
            gradient_over_forward: full_solver.solve_totals().gradient_over_forward(),
        })
    }

    fn search_certified(&self, loss: &mut Loss, nominal: [f64; 2], progress: &dyn Fn(&str)) -> Result<Minimum> {
        let derivatives = match loss.is_stiffening() {
            true => Derivatives::StiffeningSensitivities,
            false => Derivatives::Sensitivities,
        };
        let certified_search = CertifiedSearch::new(loss.model.nominal.clone(), derivatives, &loss.misfit);
        let mut full_solver = loss.solver(self.static_tolerance, self.parallel_solves);
        let round = |number: usize| progress(&format!("in a reduced model, round {number}"));
        let Certified { found: (moduli, problem, stiffened), levels, certificate, durations, .. } =
            certified_search.run(&mut full_solver, &mut |solver| self.search_with(loss, nominal, solver), &round)?;
        let gradient_over_forward = full_solver.solve_totals().gradient_over_forward();
        Ok(Minimum {
            moduli,
            problem,
            stiffened,
            levels,
            certificate: Ok(certificate),
            durations,
            gradient_over_forward,
        })
    }

    /// Searches with one solver, from the `nominal` stiffening.
    fn search_with(&self, loss: &mut Loss, nominal: [f64; 2], solver: &mut LevelSolver) -> Result<(Elastic, Found)> {
        loss.model.nominal.stiffening = nominal;
        let mut bounds = loss.bounds();
        let mut problem = loss.problem(bounds.clone())?;
        let mut stiffened = None;
        if loss.is_stiffening() {
            // the stiffening decides how soft a body has an equilibrium
            let joint_problem = StiffeningProblem {
                model: &loss.model,
                misfit: &loss.misfit,
                moduli: &problem,
                prior_sigma: loss.body.materials[BODY].stiffening_sigma.unwrap_or(self.stiffening_sigma),
                method: self.method.clone(),
            };
            let joint_fit = joint_problem.identify(solver, &|_| ())?;
            loss.model.nominal.stiffening = joint_fit.ratios;
            problem = loss.problem_from(bounds.clamp(&joint_fit.at[..problem.names().len()]), bounds)?;
            stiffened = Some(joint_fit);
        } else {
            bounds.low[0] = feasible_start_bound(solver, &loss.model.nominal, &bounds)?;
            problem = loss.problem(bounds)?;
        }
        let mut settings = optimisers::Settings::default();
        settings.gauss_newton = self.method.clone();
        let moduli = loss.minimise(&problem, (gauss_newton_member()?, &settings), solver)?;
        Ok((loss.elastic(&moduli.history.best.at), (moduli, problem, stiffened)))
    }
}

fn gauss_newton_member() -> Result<&'static optimisers::Member> {
    optimisers::by_name(gauss_newton::NAME).ok_or_else(|| {
        Diagnostic::new("identification needs gauss_newton", "`optimize` does not list it", "restore it")
    })
}
