//! A reduced body as a [`Twin`], which steps by itself and many times faster than real time.

use diagnostics::{Diagnostic, Result};
use fem::{ReducedRegion, Relaxation};
use hydro::{Coefficients, SectionOfTail, Tail};
use nalgebra::DMatrix;
use si::{Point2, Second};
use signal::resample::Samples;
use sysid::ReducedBody;
use sysid::actuated::Actuation;
use twin::{Chamber, Region, Section, Twin, TwinData};

/// The laws that a twin evaluates.
const LAWS: [&str; 2] = ["neo_hookean", "yeoh"];

/// Still water around a reduced body.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// The tail in slender-body theory.
    pub tail: &'a Tail,
    /// Rows of the tail's stations, (stations × 2) × coordinates, m.
    pub rows: &'a DMatrix<f64>,
    /// Ratios to theory.
    pub by: Coefficients,
    /// Whether half of the body is modelled, which bears half of the force.
    pub half: bool,
}

/// The arrays of `body`, in air or in water; `outputs` are the markers whose displacements are named, along x and y each.
///
/// # Errors
/// A [`Diagnostic`] when a law is neither neo-Hookean nor Yeoh's.
pub fn twin_data(body: &ReducedBody, water: Option<&Surroundings>, outputs: &[(&str, usize)]) -> Result<TwinData> {
    let reduced = body.model();
    let arrays = reduced.arrays();
    let r = reduced.coordinates();
    let regions = arrays.regions.iter().zip(body.constants());
    let chamber = |(at_rest, [a, b, c]): &(f64, [&[f64]; 3])| Chamber {
        at_rest: *at_rest,
        linear: a.to_vec(),
        quadratic: b.to_vec(),
        cubic: c.to_vec(),
    };
    let section = |water: &Surroundings| -> Vec<Section> {
        water.tail.sections().iter().map(|of| section(of, water, r)).collect()
    };
    let named = |(name, marker): &(&str, usize)| {
        let rows = body.rows(&[*marker]);
        ["x", "y"]
            .into_iter()
            .enumerate()
            .map(|(k, axis)| (format!("{name}_{axis}"), row(&rows, k)))
            .collect::<Vec<_>>()
    };
    Ok(TwinData {
        mass: arrays.mass.to_vec(),
        size: arrays.size,
        regions: regions.map(|(of, constants)| region(of, constants, r)).collect::<Result<_>>()?,
        chambers: arrays.chambers.iter().map(chamber).collect(),
        sections: water.map(section).unwrap_or_default(),
        outputs: outputs.iter().flat_map(named).collect(),
    })
}

/// Whether a twin evaluates the laws of a body.
pub fn has_twin(body: &ReducedBody) -> bool {
    body.model().arrays().regions.iter().all(|region| LAWS.contains(&region.material.name()))
}

/// Displacement of a marker of `body` along x and y, m, by its twin in air or in water in steps of `step` seconds, as functions of the film's
/// time; none where a law is none that a twin has.
///
/// # Errors
/// A [`Diagnostic`] when a step finds no motion.
pub fn path(
    (body, water): (&ReducedBody, Option<&Surroundings>),
    marker: usize,
    step: Second,
    actuation: &Actuation,
) -> Result<Option<[Samples; 2]>> {
    if !has_twin(body) {
        return Ok(None);
    }
    let twin = Twin::new(twin_data(body, water, &[("marker", marker)])?)?;
    let (times, mut state, mut path) = (actuation.times(step), twin.start(), Vec::<Point2>::new());
    for &time in &times {
        let duration = time - state.time();
        twin.step(&mut state, &actuation.pressures(time), duration)?;
        path.push([twin.output(&state, 0), twin.output(&state, 1)]);
    }
    actuation.sampled(&times, &path).map(Some)
}

fn row(rows: &DMatrix<f64>, number: usize) -> Vec<f64> {
    rows.row(number).iter().copied().collect()
}

fn region(of: &ReducedRegion, (scale, relaxation, ratios): (f64, &Relaxation, [f64; 2]), r: usize) -> Result<Region> {
    let name = of.material.name();
    if !LAWS.contains(&name) {
        return Err(Diagnostic::new(
            format!("a tail of the law `{name}` cannot be exported as a twin"),
            "a twin evaluates the neo-Hookean law and Yeoh's",
            "give solid.material = \"neo_hookean\" or \"yeoh\" on the card",
        ));
    }
    let moduli = of.moduli.scaled(scale).with_stiffening(ratios);
    // points × 9 × r to points × r × 9
    let transposed = |point: &[f64]| (0..9 * r).map(|at| point[at % 9 * r + at / 9]).collect::<Vec<_>>();
    Ok(Region {
        mu: moduli.mu,
        lambda: moduli.lambda,
        stiffening: if of.material.is_stiffening() { moduli.stiffening } else { [0.0; 2] },
        branches: relaxation.branches().iter().map(|branch| [branch.strength, branch.time]).collect(),
        weights: of.weights.to_vec(),
        gradients: of.gradients.chunks_exact(9 * r).flat_map(transposed).collect(),
    })
}

/// A section of the tail in the coordinates.
fn section(of: &SectionOfTail, water: &Surroundings, r: usize) -> Section {
    let row = |weights: &[f64], k: usize| -> Vec<f64> {
        let sum = |m: usize| weights.iter().enumerate().map(|(mark, w)| w * water.rows[(2 * mark + k, m)]).sum();
        (0..r).map(sum).collect()
    };
    let both = |weights: &[f64]| [row(weights, 0), row(weights, 1)].concat();
    let share = if water.half { 0.5 } else { 1.0 };
    let Coefficients { added, drag } = water.by;
    let by = [added * of.mass, drag * of.drag, added * of.sheds, added * of.leaves].map(|x| share * x);
    Section { slope: both(&of.weights.slope), value: both(&of.weights.value), by }
}
