//! A reduced body as a [`Twin`], which steps by itself and many times faster than real time.

use diagnostics::Result;
use hydro::{Coefficients, SectionOfTail, Tail};
use nalgebra::{DMatrix, DVector};
use si::{Point2, Second};
use signal::resample::Samples;
use sysid::actuated::Actuation;
use sysid::{ForcedMotion, ReducedBody};
use twin::{Section, Twin, TwinData};

use crate::water::Water;

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

impl Surroundings<'_> {
    /// Integrates a motion of `body` in this water; `see` receives each new q and q̇.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when a step finds no motion.
    // By its twin, where there is one that finds every step, as `ReducedBody::integrate` does in air.
    pub fn integrate(
        &self,
        body: &ReducedBody,
        motion: &ForcedMotion,
        see: &mut dyn FnMut(&DVector<f64>, &DVector<f64>),
    ) -> Result<()> {
        if motion.suits_a_twin()
            && body.has_twin()
            && let Some(states) = motion.twin_states(twin_data(body, Some(self), &[])?)?
        {
            states.iter().for_each(|(q, velocity)| see(q, velocity));
            return Ok(());
        }
        let mut water = Water::around(self.tail, self.rows, self.by, self.half);
        body.integrate_in_fluid(motion, &mut water, see)
    }
}

/// The arrays of `body`, in air or in water; `outputs` are the markers whose displacements are named, along x and y each.
///
/// # Errors
/// A [`diagnostics::Diagnostic`] when a law is neither neo-Hookean nor Yeoh's.
pub fn twin_data(body: &ReducedBody, water: Option<&Surroundings>, outputs: &[(&str, usize)]) -> Result<TwinData> {
    let section_in_water = |water: &Surroundings| -> Vec<Section> {
        water.tail.sections().iter().map(|tail_section| twin_section(tail_section, water, body.coordinates())).collect()
    };
    let sections = water.map(section_in_water).unwrap_or_default();
    Ok(TwinData { sections, ..body.twin_data(outputs)? })
}

/// Displacement of a marker of `body` along x and y, m, by its twin in air or in water in steps of `step` seconds, as functions of the film's
/// time; none where a law is none that a twin has.
///
/// # Errors
/// A [`diagnostics::Diagnostic`] when a step finds no motion.
pub fn path(
    (body, water): (&ReducedBody, Option<&Surroundings>),
    marker: usize,
    step: Second,
    actuation: &Actuation,
) -> Result<Option<[Samples; 2]>> {
    if !body.has_twin() {
        return Ok(None);
    }
    let twin = Twin::new(twin_data(body, water, &[("marker", marker)])?)?;
    let (times, mut state, mut path) = (actuation.times(step), twin.start(), Vec::<Point2>::new());
    for &time in &times {
        let duration = time - state.time();
        twin.step(&mut state, &actuation.pressures(time), duration)?;
        path.push([twin.output(&state, 0), twin.output(&state, 1)]);
    }
    actuation.sample_path(&times, &path).map(Some)
}

/// A section of the tail in the coordinates.
fn twin_section(tail_section: &SectionOfTail, water: &Surroundings, r: usize) -> Section {
    let row = |weights: &[f64], k: usize| -> Vec<f64> {
        let weighted_sum =
            |m: usize| weights.iter().enumerate().map(|(mark, w)| w * water.rows[(2 * mark + k, m)]).sum();
        (0..r).map(weighted_sum).collect()
    };
    let row_pair = |weights: &[f64]| [row(weights, 0), row(weights, 1)].concat();
    let modelled_fraction = if water.half { 0.5 } else { 1.0 };
    let Coefficients { added, drag } = water.by;
    let coefficients =
        [added * tail_section.mass, drag * tail_section.drag, added * tail_section.sheds, added * tail_section.leaves]
            .map(|x| modelled_fraction * x);
    Section {
        slope: row_pair(&tail_section.weights.slope),
        value: row_pair(&tail_section.weights.value),
        by: coefficients,
    }
}
