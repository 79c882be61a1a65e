//! Options of `study reduce`: the ranges over which a reduced model of a case is trained.

use std::path::PathBuf;

use clap::Args;
use clap::builder::RangedU64ValueParser;

/// Options of `study reduce`.
#[derive(Debug, Clone, Args)]
pub struct ReduceCase {
    /// The case: a body on which nothing but pressures acts.
    pub case: PathBuf,
    /// A range of a modulus (Pa) or of a Poisson's ratio: E.body=1e5..3e5, nu.body=0.45..0.49. May be repeated.
    #[arg(long, value_name = "CONSTANT=LOW..HIGH")]
    pub over: Vec<simulate::NamedRange>,
    /// The range of a chamber's pressure, Pa, by its name in the case or its number: air=0..3e4. May be repeated.
    #[arg(long, value_name = "CHAMBER=LOW..HIGH", required = true)]
    pub pressure: Vec<simulate::NamedRange>,
    /// Largest difference of a node from the whole body, over the largest displacement.
    #[arg(long, default_value_t = 5e-3, value_parser = parse_tolerance)]
    pub tolerance: f64,
    /// Equilibria of the whole body that may teach it, at most.
    #[arg(long, default_value_t = 60, value_parser = RangedU64ValueParser::<usize>::from(1..=1000))]
    pub equilibria: usize,
    /// The file that is written, of safetensors.
    #[arg(long, value_name = "MODEL.safetensors")]
    pub out: PathBuf,
}

impl ReduceCase {
    /// What is reduced, and how well.
    pub fn options(&self, quiet: bool) -> simulate::ReduceOptions {
        let Self { case, over, pressure, tolerance, equilibria, out } = self.clone();
        simulate::ReduceOptions { case, over, pressures: pressure, tolerance, equilibria, out, quiet }
    }
}

fn parse_tolerance(text: &str) -> Result<f64, String> {
    let tolerance = text.parse().map_err(|_| "it is not a number".to_owned())?;
    let is_in_range = (1e-6..=0.5).contains(&tolerance);
    is_in_range.then_some(tolerance).ok_or_else(|| "it lies between 1e-6 and 0.5".to_owned())
}
