//! Identify: the Young's moduli that minimise the misfit to quasi-static films. Paper: section V.
//!
//! The parameters are the logarithms of the solids' moduli over the card's nominal values. The result is that of the Gauss-Newton method; on
//! specimens chosen for comparison, every other method of `optimize` is run over the same bounds. The discrepancy between model and films is
//! estimated from the residuals of that result, and the error of the mesh on a finer one; both are in the uncertainty.

use optimize::optimisers::{self, gauss_newton, grid};

use super::assemble::Searches;
use super::discretisation::finer;
use super::fitting::{Card, Films, Fitting, Settings};
use super::mesh;
use crate::records::{Identified, Mesh};
use crate::subject::Specimen;
use diagnostics::{Diagnostic, Result};
use workflow::stage::{RawFile, Stage, StageContext};

/// The stage.
pub struct Identify;

impl Stage for Identify {
    type Settings = Settings;
    type Card = Card;
    type Needs = (Mesh, Films);
    type Makes = Identified;
    const DESCRIPTION: &'static str = "Young's moduli are identified from quasi-static motion";
    const VERSION: u32 = 19;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        mesh::Mesh::raw(of)
    }

    fn run(
        card: &Self::Card,
        set: &Settings,
        (mesh, films): Self::Needs,
        context: &dyn StageContext,
    ) -> Result<Identified> {
        let fitting = Fitting::new(card, set, &mesh, &films)?;
        let chosen = || optimisers::ALL.iter().filter(|member| fitting.compared || member.name == gauss_newton::NAME);
        let (mut records, mut best, mut grid) = (Vec::new(), None, Vec::new());
        for (i, member) in chosen().enumerate() {
            context.progress((i + 1) as f64 / (chosen().count() + 1) as f64, member.name);
            let began = context.seconds();
            let found = fitting.search(member)?;
            records.push(fitting.record(member.name, &found.history, context.seconds() - began));
            match member.name {
                grid::NAME => grid = found.evaluated,
                gauss_newton::NAME => best = Some(found),
                _ => {}
            }
        }
        let unlisted =
            || Diagnostic::new("identification needs gauss_newton", "`optimize` does not list it", "restore it");
        let best = best.ok_or_else(unlisted)?;
        let finer = finer(card, set, (&mesh, &films), context);
        let gradient_difference = fitting.compared.then(|| fitting.gradient_difference()).transpose()?;
        fitting.assemble(Searches { best, grid, records, finer }, gradient_difference, context)
    }
}
