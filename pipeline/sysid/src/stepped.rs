//! A reduced body as a [`Twin`], which evaluates eight cubature points at once and sums its tangent in single precision.

use fem::{ReducedRegion, Relaxation, Scheme};
use nalgebra::DVector;
use twin::{Chamber, Output, Region, Twin, TwinData, TwinError};

use crate::reduced::{ForcedMotion, ReducedBody};
use diagnostics::{Diagnostic, Result};

/// The laws that a twin evaluates.
const LAWS: [&str; 2] = ["neo_hookean", "yeoh"];
/// Coordinates and velocities after each step of a motion.
type States = Vec<(DVector<f64>, DVector<f64>)>;

/// Largest size of the last iteration of a step, relative to the largest shape: that of the reduced model's own integration, so that
/// differences of motions are as exact.
const TOLERANCE: f64 = 1e-8;

impl ReducedBody {
    /// Whether a twin evaluates its laws.
    pub fn has_twin(&self) -> bool {
        self.model().arrays().regions.iter().all(|region| LAWS.contains(&region.material.name()))
    }

    /// Its arrays, in air; `outputs` are the markers whose displacements are named, along x and y each. Of names, ranges and places at rest it knows
    /// none: solids and chambers are numbered, pressures are without limit.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a law is neither neo-Hookean nor Yeoh's.
    pub fn twin_data(&self, outputs: &[(&str, usize)]) -> Result<TwinData> {
        let (arrays, r) = (self.model().arrays(), self.coordinates());
        let constants: Vec<_> = self.constants().collect();
        let regions = arrays.regions.iter().map(|points| (points, constants[points.region]));
        let names = self.group_names(&|region| format!("solid{region}"));
        let chamber = |(number, (at_rest, [a, b, c])): (usize, &(f64, [&[f64]; 3]))| Chamber {
            name: format!("chamber{number}"),
            range: Chamber::UNLIMITED,
            at_rest: *at_rest,
            linear: a.to_vec(),
            quadratic: b.to_vec(),
            cubic: c.to_vec(),
        };
        let named = |(name, marker): &(&str, usize)| {
            let rows = self.rows(&[*marker]);
            let row = |k: usize| rows.row(k).iter().copied().collect();
            [("x", 0), ("y", 1)].map(|(axis, k)| Output { name: format!("{name}_{axis}"), row: row(k), at_rest: 0.0 })
        };
        Ok(TwinData {
            mass: arrays.mass.to_vec(),
            size: arrays.size,
            regions: regions
                .zip(names)
                .map(|((points, constants), name)| Ok(Region { name, ..twin_region(points, constants, r)? }))
                .collect::<Result<_>>()?,
            chambers: arrays.chambers.iter().enumerate().map(chamber).collect(),
            sections: Vec::new(),
            outputs: outputs.iter().flat_map(named).collect(),
            half: false,
            provenance: Vec::new(),
        })
    }

    /// Names of the groups of cubature points, after what each region is called: numbered where a region has several, as in hexahedra, whose
    /// groups integrate different shares of its moduli.
    pub fn group_names(&self, region_name: &dyn Fn(usize) -> String) -> Vec<String> {
        let regions: Vec<usize> = self.model().arrays().regions.iter().map(|points| points.region).collect();
        let numbered = |(group, &region): (usize, &usize)| {
            let number = regions[..group].iter().filter(|other| **other == region).count();
            let is_alone = regions.iter().filter(|other| **other == region).count() == 1;
            if is_alone { region_name(region) } else { format!("{}_{number}", region_name(region)) }
        };
        regions.iter().enumerate().map(numbered).collect()
    }
}

impl ForcedMotion<'_> {
    /// Whether a twin integrates by the same scheme.
    pub fn suits_a_twin(&self) -> bool {
        let set = self.settings;
        set.scheme == Scheme::Bdf2 && set.mass_damping == 0.0 && set.stiffness_damping == 0.0
    }

    /// The motion by the twin of these arrays: q and q̇ after each step; none where a step finds no motion.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the arrays are those of no tail.
    pub fn twin_states(&self, data: TwinData) -> Result<Option<States>> {
        let mut states = States::with_capacity(self.times.len());
        let twin = Twin::new(data)?.with_tolerance(TOLERANCE);
        let mut state = twin.start();
        for &time in self.times {
            let duration = time - state.time();
            match twin.step(&mut state, &(self.pressures)(time), duration) {
                Err(TwinError::NoConvergence { .. }) => return Ok(None),
                other => other?,
            }
            let [q, velocity] = [state.coordinates(), state.velocity()].map(DVector::from_column_slice);
            states.push((q, velocity));
        }
        Ok(Some(states))
    }
}

fn twin_region(
    reduced_region: &ReducedRegion,
    (scale, relaxation, ratios): (f64, &Relaxation, [f64; 2]),
    r: usize,
) -> Result<Region> {
    let name = reduced_region.material.name();
    if !LAWS.contains(&name) {
        return Err(Diagnostic::new(
            format!("a tail of the law `{name}` cannot be exported as a twin"),
            "a twin evaluates the neo-Hookean law and Yeoh's",
            "give solid.material = \"neo_hookean\" or \"yeoh\" on the card",
        ));
    }
    let moduli = reduced_region.moduli.scaled(scale).with_stiffening(ratios);
    // points × 9 × r to points × r × 9
    let transposed = |point: &[f64]| (0..9 * r).map(|index| point[index % 9 * r + index / 9]).collect::<Vec<_>>();
    Ok(Region {
        name: String::new(),
        mu: moduli.mu,
        lambda: moduli.lambda,
        stiffening: if reduced_region.material.is_stiffening() { moduli.stiffening } else { [0.0; 2] },
        branches: relaxation.branches().iter().map(|branch| [branch.strength, branch.time]).collect(),
        weights: reduced_region.weights.to_vec(),
        gradients: reduced_region.gradients.chunks_exact(9 * r).flat_map(transposed).collect(),
    })
}
