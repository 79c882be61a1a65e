//! A step of pressure that is held, as equilibria: a silicone that relaxes has the modulus of its creep, and inertia is left out, since what is
//! compared are means over a period of the ring-down.
//!
//! The same motion with inertia, by implicit Euler's method, costs three hundred times as much: ten to thirty seconds for each law, pressure and
//! recording of the arm. Both agree to a per cent (a test holds it).

use std::sync::Arc;

use fem::{Branch, Relaxation};
use si::{Metre, Pascal, Second};

use super::inflated::{Inflated, PRESSURE, Point, Shape, creep_elasticity};
use super::page::Supply;
use crate::IdentifiedMaterial;
use diagnostics::Result;

/// Times of a course, evenly in their logarithm.
const TIMES: usize = 24;

/// What an inflation does to the tip.
#[derive(Debug, Clone)]
pub(super) struct Course {
    /// Time since the step (s), and mean displacement of the compared markers along the page's axis (m).
    pub tip: Vec<(Second, Metre)>,
    /// Why it ended before its time: the wall balloons without bound.
    pub burst: Option<String>,
}

/// A step of pressure on a body of some material.
pub(super) struct Hold<'a> {
    pub body: &'a Inflated,
    pub material: &'a IdentifiedMaterial,
    pub supply: &'a Supply,
    /// Pa.
    pub pressure: Pascal,
}

impl Hold<'_> {
    /// The tip until the time `end` (s) after the step, by equilibria at the times `solved` (s); between them modulus and pressure differ by some
    /// per cent, and the tip is linear about the nearest. Equilibria are begun at those that are `known`, and added to them.
    ///
    /// # Errors
    /// A diagnostic when the spectrum is refused, or the body does not bear its weight.
    pub fn course(&self, end: Second, solved: &[Second], known: &mut Vec<Arc<Shape>>) -> Result<Course> {
        let branches: Vec<Branch> =
            self.material.branch.iter().map(|&[strength, time]| Branch { strength, time }).collect();
        let relaxation = Relaxation::maxwell(&branches)?;
        let mut ambient = self.point(&relaxation, f64::INFINITY);
        ambient[PRESSURE] = 0.0;
        let ambient_tip = self.body.remembered(&ambient, known)?.tip;
        let mut tip = vec![(0.0, 0.0)];
        let mut shapes = Vec::new();
        for &time in solved {
            match self.body.remembered(&self.point(&relaxation, time), known) {
                Ok(shape) => shapes.push((time, shape)),
                Err(refused) => return Ok(Course { tip, burst: Some(refused.to_string()) }),
            }
        }
        let begin = self.supply.rise;
        for k in 0..TIMES {
            let time = begin * (end / begin).powf(k as f64 / (TIMES - 1) as f64);
            tip.push((time, linear_tip(&shapes, time, &self.point(&relaxation, time)) - ambient_tip));
        }
        Ok(Course { tip, burst: None })
    }

    fn point(&self, relaxation: &Relaxation, time: Second) -> Point {
        let IdentifiedMaterial { youngs_modulus, stiffening, .. } = *self.material;
        let since_middle = self.supply.time_since_rise(time);
        let (modulus, [c20, c30]) = creep_elasticity((youngs_modulus, stiffening), relaxation, since_middle);
        [modulus, c20, c30, 0.0, self.supply.step_pressure(self.pressure, time)]
    }
}

/// At a point nearby, by the shape that is nearest in the logarithm of time, m.
fn linear_tip(shapes: &[(Second, Arc<Shape>)], time: Second, point: &Point) -> Metre {
    let distance = |(solved, _): &(Second, Arc<Shape>)| (solved / time).ln().abs();
    let nearest = shapes.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.map_or(f64::NAN, |(_, shape)| shape.linear_tip(point))
}
