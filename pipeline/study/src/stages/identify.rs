//! Identify: the Young's moduli that minimise the misfit to quasi-static films. Paper: section V.
//!
//! The parameters are the logarithms of the solids' moduli over the card's nominal values, searched by the Gauss-Newton method; how other
//! methods do on the same loss is shown by [`super::method_comparison`]. The discrepancy between model and films is estimated from the
//! residuals of the result, and the error of the mesh on a finer one; both are in the uncertainty.

use super::discretisation::finer_model;
use super::fitting::{Card, Films, Fitting, Settings};
use super::mesh;
use diagnostics::Result;
use records::subject::Specimen;
use records::{Identified, Mesh};
use workflow::stage::{RawFile, Stage, StageContext};

/// The stage.
pub struct Identify;

impl Stage for Identify {
    type Settings = Settings;
    type Card = Card;
    type Needs = (Mesh, Films);
    type Makes = Identified;
    const DESCRIPTION: &'static str = "Young's moduli are identified from quasi-static motion";
    const VERSION: u32 = 27;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        mesh::Mesh::raw(of)
    }

    fn run(
        card: &Self::Card,
        set: &Settings,
        (mesh, films): Self::Needs,
        context: &dyn StageContext,
    ) -> Result<Identified> {
        let mut fitting = Fitting::new(card, set, &mesh, &films)?;
        let minimum = fitting.minimise(context)?;
        fitting.check_direction(&minimum)?;
        fitting.assemble_record(&minimum, finer_model(card, set, (&mesh, &films), context), context)
    }
}
