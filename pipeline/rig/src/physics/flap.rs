//! Flapping: a tail in air or water under the pressures of both sides, in the coordinates that it was reduced to.
//!
//! Stands on: `fem`'s reduced march (BDF2, the rate of the elastic force as damping), the water. Never knows: what is commanded.

use fem::{Drive, March, Scheme, Still};
use lab::card::Side;
use nalgebra::{DMatrix, DVector};
use shape::tail::Tail;
use si::{Hertz, Metre, Newton, Pascal, Point2, Point3, Second};

use super::line::CentreLine;
use super::training;
use super::water::{Fluid, Push, Water};
use super::{Body, Ladder, Motion, Quasistatic, Stairs};
use crate::fault::Fault;
use crate::valve::Trace;

/// A body in the coordinates of the shapes that it was trained on.
pub struct Swimmer<'a> {
    /// The whole body.
    pub body: &'a Body,
    /// Its coordinates.
    pub reduced: fem::Reduced,
    /// Its centre line.
    pub line: CentreLine,
    rest_line: Vec<Point2>,
    /// (stations × 2) × coordinates.
    rows: DMatrix<f64>,
    /// Coordinates × (nodes × 3), m.
    modes: Vec<Vec<f32>>,
    /// Σ m x of the whole tail by coordinate, kg m.
    moments: DVector<f64>,
    /// Its own equilibria on the rungs of both ladders (left, right).
    rests: [Vec<DVector<f64>>; 2],
}

/// What differs from trial to trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// The water, where there is some.
    pub fluid: Option<Fluid>,
    /// The silicone's moduli against those at the reference temperature, no unit.
    pub softening: f64,
}

/// A motion, and how it pulled on its holder.
pub struct Flap<'a> {
    swimmer: &'a Swimmer<'a>,
    start: Second,
    rate: Hertz,
    shapes: Vec<DVector<f64>>,
    /// On the holder, forwards; and of it what is the water's thrust, N.
    pulls: Vec<(Newton, Newton)>,
}

impl<'a> Swimmer<'a> {
    /// Trains on `ladders` (left, right) and on the shapes of [`training`]. `tick` is called after each equilibrium.
    ///
    /// # Errors
    /// [`Fault`] when an equilibrium is not found.
    pub fn train(
        body: &'a Body,
        tail: &Tail,
        clamp: Metre,
        ladders: &[Ladder; 2],
        tick: &(dyn Fn() + Sync),
    ) -> Result<Self, Fault> {
        let line = CentreLine::of(tail, body, clamp);
        let pulled = training::shapes(body, &line, ladders, tick)?;
        let climbed = ladders.iter().flat_map(|ladder| ladder.shapes.iter().skip(1).step_by(2));
        let shapes: Vec<&[f64]> = climbed.chain(&pulled).map(Vec::as_slice).collect();
        let by = fem::Reduction { coordinates: shapes.len() * 4 / 5, tolerance: 5e-4, ..fem::Reduction::default() };
        let reduced = body.system.reduce(&shapes, &by).map_err(|e| Fault::at("the reduced body", e))?;
        let (rest_line, rows) = (line.rest(body), line.rows(&reduced));
        let unit = |k: usize| DVector::from_fn(reduced.coordinates(), |i, _| f64::from(u8::from(i == k)));
        let mode = |k: usize| reduced.displacement(&unit(k)).into_iter().map(|u| u as f32).collect::<Vec<f32>>();
        let modes: Vec<Vec<f32>> = (0..reduced.coordinates()).map(mode).collect();
        let halves = if body.mesh.half { 2.0 } else { 1.0 };
        let moment = |mode: &Vec<f32>| {
            let x = body.system.node_masses().iter().zip(mode.iter().step_by(3));
            halves * x.map(|(m, u)| m * f64::from(*u)).sum::<f64>()
        };
        let moments = DVector::from_iterator(modes.len(), modes.iter().map(moment));
        let rests = |side: Side, ladder: &Ladder| rests(body, &reduced, side, &ladder.pressures);
        let rests = [rests(Side::Left, &ladders[0])?, rests(Side::Right, &ladders[1])?];
        Ok(Self { body, reduced, line, rest_line, rows, modes, moments, rests })
    }

    /// Moves from rest at the start of `span` (s) while one `side` is filled and opened, beside the whole body's `ladder` on that side,
    /// the reference of its temperature.
    ///
    /// # Errors
    /// [`Fault`] when a step finds no motion.
    pub fn stairs(
        &'a self,
        side: Side,
        ladder: &'a Ladder,
        trace: Trace,
        span: [Second; 2],
        step: Second,
        fluid: Option<Fluid>,
    ) -> Result<Stairs<'a>, Fault> {
        let pressures = |t: Second| match side {
            Side::Left => [trace.at(t), 0.0],
            Side::Right => [0.0, trace.at(t)],
        };
        let flap = self.flap(span, step, &pressures, &Conditions { fluid, softening: 1.0 })?;
        let still = Quasistatic { rest: &self.body.mesh.nodes, ladder, trace };
        Ok(Stairs { still, flap, rests: &self.rests[usize::from(side == Side::Right)] })
    }

    /// Moves from rest at `start` until `end` (s) in steps of `step` (s), under the pressures (left, right; Pa) at any time.
    ///
    /// # Errors
    /// [`Fault`] when a step finds no motion.
    pub fn flap(
        &'a self,
        [start, end]: [Second; 2],
        step: Second,
        pressures: &dyn Fn(Second) -> [Pascal; 2],
        conditions: &Conditions,
    ) -> Result<Flap<'a>, Fault> {
        let count = ((end - start) / step).ceil() as usize;
        let march = March {
            step,
            scheme: Scheme::Bdf2,
            mass_damping: 0.0,
            stiffness_damping: self.body.stiffness_damping,
            ..March::default()
        };
        let drive = |t: Second| {
            let [left, right] = pressures(start + t);
            Drive { pressures: self.body.pressures(left, right) }
        };
        let scale = [conditions.softening, 1.0];
        let r = self.reduced.coordinates();
        let (mut shapes, mut speeds) = (vec![DVector::zeros(r)], vec![DVector::zeros(r)]);
        let mut keep = |q: &DVector<f64>, v: &DVector<f64>| {
            shapes.push(q.clone());
            speeds.push(v.clone());
        };
        let mut pushes = vec![Push::default()];
        let marched = match conditions.fluid {
            None => self.reduced.march(&march, &scale, &drive, &mut Still, count, &mut |_, q, v| keep(q, v)),
            Some(fluid) => {
                let water = Water::around(&self.line, fluid, &self.rest_line, &self.rows, self.body.mesh.half);
                let mut water = Followed { water, pushes: &mut pushes };
                self.reduced.march(&march, &scale, &drive, &mut water, count, &mut |_, q, v| keep(q, v))
            }
        };
        marched.map_err(|e| Fault::at(format!("motion between {start:.3} s and {end:.3} s"), e))?;
        pushes.resize(shapes.len(), Push::default());
        let pulls = self.pulls(&speeds, &pushes, 1.0 / step);
        Ok(Flap { swimmer: self, start, rate: 1.0 / step, shapes, pulls })
    }

    /// On the holder: what the water pushes, less what the tail's own mass keeps of it.
    fn pulls(&self, speeds: &[DVector<f64>], pushes: &[Push], rate: Hertz) -> Vec<(Newton, Newton)> {
        let momentum: Vec<f64> = speeds.iter().map(|v| self.moments.dot(v)).collect();
        let last = momentum.len() - 1;
        let gain = |i: usize| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
            (momentum[b] - momentum[a]) * rate / (b - a).max(1) as f64
        };
        pushes.iter().enumerate().map(|(i, push)| (push.forwards + gain(i), push.thrust)).collect()
    }
}

/// The reduced body's equilibria with `side` filled to rising `pressures` (Pa), the first of them 0.
fn rests(body: &Body, reduced: &fem::Reduced, side: Side, pressures: &[Pascal]) -> Result<Vec<DVector<f64>>, Fault> {
    let mut found = vec![DVector::zeros(reduced.coordinates())];
    for pressure in &pressures[1..] {
        let near = found.iter().rev().take(2).collect::<Vec<_>>();
        let guess = if let [last, before] = near[..] { last * 2.0 - before } else { found[0].clone() };
        let rest = reduced.equilibrium(&body.one_side(side, *pressure), &[1.0, 1.0], &guess);
        let place = || format!("the reduced body at rest under {:.0} mbar", pressure / si::MILLIBAR);
        found.push(rest.map_err(|e| Fault::at(place(), e))?);
    }
    Ok(found)
}

/// Water that notes its push after each step.
struct Followed<'a, 'b> {
    water: Water<'a>,
    pushes: &'b mut Vec<Push>,
}

impl fem::Around for Followed<'_, '_> {
    fn force(&self, at: &fem::Moment) -> DVector<f64> {
        self.water.force(at)
    }

    fn accept(&mut self, at: &fem::Moment) {
        self.water.accept(at);
        self.pushes.push(self.water.push);
    }
}

impl Flap<'_> {
    /// Steps kept.
    pub fn steps(&self) -> usize {
        self.shapes.len() - 1
    }

    /// Straight between steps, nothing beyond.
    fn between(&self, t: Second, of: impl Fn(&(Newton, Newton)) -> Newton) -> Newton {
        let place = (t - self.start) * self.rate;
        let at = |i: f64| if i < 0.0 { 0.0 } else { self.pulls.get(i as usize).map_or(0.0, &of) };
        let share = place - place.floor();
        at(place.floor()) * (1.0 - share) + at(place.floor() + 1.0) * share
    }

    /// Coordinates × (nodes × 3), m.
    pub(super) fn modes(&self) -> &[Vec<f32>] {
        &self.swimmer.modes
    }

    /// Coordinates at time `t` (s): straight between steps, the first before them, the last after.
    pub(super) fn coordinates(&self, t: Second) -> DVector<f64> {
        let last = self.shapes.len() - 1;
        let place = ((t - self.start) * self.rate).clamp(0.0, last as f64);
        let first = (place.floor() as usize).min(last.saturating_sub(1));
        let share = place - first as f64;
        &self.shapes[first] * (1.0 - share) + &self.shapes[(first + 1).min(last)] * share
    }
}

impl Motion for Flap<'_> {
    fn nodes(&self, t: Second) -> Vec<Point3> {
        let (nodes, moved) = (&self.swimmer.body.mesh.nodes, moved(&self.swimmer.modes, &self.coordinates(t)));
        let (moved, _) = moved.as_chunks::<3>();
        let node = |(x, u): (&Point3, &[f32; 3])| [0, 1, 2].map(|axis| x[axis] + f64::from(u[axis]));
        nodes.iter().zip(moved).map(node).collect()
    }

    fn seen(&self, t: Second, of: &[u32]) -> Vec<Point3> {
        let mut nodes = self.swimmer.body.mesh.nodes.clone();
        for (node, u) in of.iter().zip(moved_of(&self.swimmer.modes, &self.coordinates(t), of)) {
            nodes[*node as usize].iter_mut().zip(u).for_each(|(x, u)| *x += f64::from(u));
        }
        nodes
    }

    fn pull(&self, t: Second) -> Newton {
        self.between(t, |pull| pull.0)
    }

    fn thrust(&self, t: Second) -> Newton {
        self.between(t, |pull| pull.1)
    }
}

/// Displacements of all nodes, nodes × 3, m.
pub(super) fn moved(modes: &[Vec<f32>], q: &DVector<f64>) -> Vec<f32> {
    let mut moved = vec![0.0; modes.first().map_or(0, Vec::len)];
    for (mode, q) in modes.iter().zip(q.iter()) {
        moved.iter_mut().zip(mode).for_each(|(moved, u)| *moved += *q as f32 * u);
    }
    moved
}

/// Displacements of the nodes `of`, m: the same sums as [`moved`] in the same order, so the same numbers.
pub(super) fn moved_of(modes: &[Vec<f32>], q: &DVector<f64>, of: &[u32]) -> Vec<[f32; 3]> {
    let mut moved = vec![[0.0; 3]; of.len()];
    for (mode, q) in modes.iter().zip(q.iter()) {
        let (mode, _) = mode.as_chunks::<3>();
        for (moved, node) in moved.iter_mut().zip(of) {
            moved.iter_mut().zip(mode[*node as usize]).for_each(|(moved, u)| *moved += *q as f32 * u);
        }
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nodes_that_a_film_sees_are_moved_as_all_nodes_are() {
        let mode = |m: usize| (0..15).map(|k| ((7 * k + 3 * m) % 11) as f32 / 7.0 - 0.6).collect::<Vec<f32>>();
        let (modes, q) = ((0..4).map(mode).collect::<Vec<_>>(), DVector::from_vec(vec![0.31, -1.7, 0.05, 2.2]));
        let (all, of) = (moved(&modes, &q), [0, 2, 4]);
        for (some, node) in moved_of(&modes, &q, &of).iter().zip(of) {
            assert_eq!(some[..], all[3 * node as usize..][..3]);
        }
    }
}
