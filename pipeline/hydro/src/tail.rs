//! A tail in motion: from markers on its centre line to the terms of its thrust, each with its derivatives.
//!
//! Sections lie at the middles of equal lengths between clamp and trailing edge, each with its depth; integrals along the
//! tail are sums over them (midpoint rule).

use si::{KilogramPerCubicMetre, Metre, Point2};

use crate::line::{CentreLine, Weights};
use crate::{Section, ValueWithGradient, elongated, resistive};

/// Why stations do not define a tail.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "marks at {marks:?} m between a clamp at {clamp} m and an edge at {edge} m are not on a centre line\n  why: they must rise from the clamp to the edge\n  do:  correct the markers or the clamp on the card"
)]
pub struct TailError {
    clamp: Metre,
    edge: Metre,
    marks: Vec<Metre>,
}

/// Stations along a tail, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stations<'a> {
    /// End of the clamp.
    pub clamp: Metre,
    /// Markers, rising from the clamp.
    pub marks: &'a [Metre],
    /// Trailing edge.
    pub edge: Metre,
    /// End of the fin behind the trailing edge; the edge itself where there is none.
    pub end: Metre,
}

/// A tail by its sections.
#[derive(Debug, Clone, PartialEq)]
pub struct Tail {
    density: KilogramPerCubicMetre,
    sections: Vec<Slice>,
    edge: Slice,
    /// Sections of the fin behind its trailing edge: they have added mass and drag, but no flux leaves there. Without them the estimated
    /// added mass and drag were twice too large.
    behind: Vec<Slice>,
    marks: usize,
}

/// A section as [`Tail::water_force`] sums it, by theory and for a drag coefficient of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionOfTail<'a> {
    /// Weights of the markers there.
    pub weights: &'a Weights,
    /// Added mass, kg.
    pub mass: f64,
    /// Drag over the square of the normal velocity, kg/m.
    pub drag: f64,
    /// The part of the added mass whose momentum flux acts along the slope, kg: all, or none behind the trailing edge.
    pub sheds: f64,
    /// Added mass per length whose momentum flux leaves here, kg/m: at the trailing edge alone.
    pub leaves: f64,
}

impl<'a> SectionOfTail<'a> {
    fn without_length(slice: &'a Slice) -> Self {
        Self { weights: &slice.weights, mass: 0.0, drag: 0.0, sheds: 0.0, leaves: 0.0 }
    }
}

#[derive(Debug, Clone, PartialEq)]
struct Slice {
    weights: Weights,
    depth: Metre,
    length: Metre,
}

/// A term of the thrust and its derivatives by every mark's displacement (per m) and velocity (per m/s): marks × 2 each.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Term {
    /// N, or N s for a momentum.
    pub value: f64,
    /// By displacement.
    pub by_displacement: Vec<Point2>,
    /// By velocity.
    pub by_velocity: Vec<Point2>,
}

/// The terms of the thrust.
#[derive(Debug, Clone, PartialEq)]
pub struct Terms {
    /// ½ m ẏ² at the trailing edge: the paper's, N.
    pub trailing_edge: Term,
    /// Lighthill's terms at the trailing edge, N.
    pub edge_flux: Term,
    /// ∫ m w n_x da, N s: its rate is the rest of Lighthill's thrust.
    pub momentum: Term,
    /// Drag of all sections for a coefficient of one, N.
    pub drag: Term,
}

/// The force of still water on the marks: the force is `force` less the rate in time of `momentum`; marks × 2 each.
#[derive(Debug, Clone, PartialEq)]
pub struct Water {
    /// Momentum of the water that moves with the tail, N s.
    pub momentum: Vec<Point2>,
    /// Force by momentum flux and drag, N.
    pub force: Vec<Point2>,
}

/// Coefficients of the water's force relative to theory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// Ratio of the added mass to that of elongated-body theory, no unit.
    pub added: f64,
    /// Normal drag coefficient, no unit: about 2 for a plate in a stream.
    pub drag: f64,
}

impl Tail {
    /// A tail cut before its trailing edge into `count` sections whose depth (m) at a place (m) is `depth`.
    ///
    /// # Errors
    /// [`TailError`] when the marks do not rise from the clamp to the end.
    pub fn new(
        density: KilogramPerCubicMetre,
        stations: &Stations,
        count: usize,
        depth: &dyn Fn(Metre) -> Metre,
    ) -> Result<Self, TailError> {
        let Stations { clamp, marks, edge, end } = *stations;
        let error = || TailError { clamp, edge: end, marks: marks.to_vec() };
        let line = CentreLine::new(clamp, marks).filter(|_| marks.iter().all(|m| *m <= end)).ok_or_else(error)?;
        let slices = |start: Metre, stop: Metre, count: usize| -> Vec<Slice> {
            let length = (stop - start) / count as f64;
            // The midpoint rule has half the error constant of the trapezoidal rule, and no section lies at the clamp,
            // where all weights vanish, or at the edge, whose flux is added apart.
            let middles = (0..count).map(|i| start + (i as f64 + 0.5) * length);
            middles.map(|a| Slice { weights: line.at(a), depth: depth(a), length }).collect()
        };
        let length = (edge - clamp) / count as f64;
        let behind = slices(edge, end, ((end - edge) / length).ceil().max(0.0) as usize);
        let edge_slice = Slice { weights: line.at(edge), depth: depth(edge), length };
        Ok(Self { density, sections: slices(clamp, edge, count), edge: edge_slice, behind, marks: marks.len() })
    }

    /// The terms while the marks are displaced by `displacement` (m) and move with `velocity` (m/s), a pair a mark.
    pub fn terms(&self, displacement: &[Point2], velocity: &[Point2]) -> Terms {
        let mass = |slice: &Slice| elongated::virtual_mass(self.density, slice.depth);
        let at_edge = |force: fn(f64, &Section) -> ValueWithGradient| {
            let mut term = self.zero_term();
            self.edge.add_force(&mut term, displacement, velocity, &|s| force(mass(&self.edge), s));
            term
        };
        let (mut momentum, mut drag) = (self.zero_term(), self.zero_term());
        for slice in &self.sections {
            slice.add_force(&mut momentum, displacement, velocity, &|s| {
                elongated::momentum(mass(slice), s).scaled(slice.length)
            });
            slice.add_force(&mut drag, displacement, velocity, &|s| {
                resistive::drag(self.density, slice.depth, s).scaled(slice.length)
            });
        }
        Terms {
            trailing_edge: at_edge(elongated::trailing_edge),
            edge_flux: at_edge(elongated::edge_thrust),
            momentum,
            drag,
        }
    }

    /// The force of still water on the marks while they move so: virtual work of the sections by the marks' displacements.
    ///
    /// f = −∂(m w n)/∂t + ∂(m u w n − ½ m w² r')/∂a − ½ ρ c s |w| w n      \[lighthill1971\], \[taylor1952\]
    ///
    /// The flux term is integrated by parts, so that the flux through the trailing edge acts there. The time derivative of the first
    /// term is taken by the caller.
    pub fn water_force(&self, displacement: &[Point2], velocity: &[Point2], coefficients: Coefficients) -> Water {
        let mut water = Water { momentum: vec![[0.0; 2]; self.marks], force: vec![[0.0; 2]; self.marks] };
        let front = self.sections.iter().map(|slice| (slice, true));
        for (slice, sheds) in front.chain(self.behind.iter().map(|slice| (slice, false))) {
            let section = slice.section_at(displacement, velocity);
            let mass = coefficients.added * elongated::virtual_mass(self.density, slice.depth);
            let drag = resistive::force(self.density, slice.depth, &section).map(|f| coefficients.drag * f);
            let momentum = elongated::momentum_vector(mass, &section);
            let flux = if sheds { elongated::flux_vector(mass, &section) } else { [0.0; 2] };
            let Weights { value, slope } = &slice.weights;
            for (mark, k) in (0..self.marks).flat_map(|m| [(m, 0), (m, 1)]) {
                water.momentum[mark][k] += slice.length * value[mark] * momentum[k];
                water.force[mark][k] += slice.length * (value[mark] * drag[k] - slope[mark] * flux[k]);
            }
        }
        let edge = self.edge.section_at(displacement, velocity);
        let edge_flux =
            elongated::flux_vector(coefficients.added * elongated::virtual_mass(self.density, self.edge.depth), &edge);
        for (mark_force, weight) in water.force.iter_mut().zip(&self.edge.weights.value) {
            (0..2).for_each(|k| mark_force[k] += weight * edge_flux[k]);
        }
        water
    }

    /// Its sections with what they have by theory; the trailing edge is the last.
    pub fn sections(&self) -> Vec<SectionOfTail<'_>> {
        let edge = SectionOfTail { leaves: self.added_mass(&self.edge), ..SectionOfTail::without_length(&self.edge) };
        let front = self.sections.iter().map(|slice| SectionOfTail {
            sheds: slice.length * self.added_mass(slice),
            ..self.section_without_flux(slice)
        });
        front.chain(self.behind.iter().map(|slice| self.section_without_flux(slice))).chain([edge]).collect()
    }

    /// A section that sheds nothing.
    fn section_without_flux<'a>(&self, slice: &'a Slice) -> SectionOfTail<'a> {
        let (mass, drag) = (slice.length * self.added_mass(slice), 0.5 * self.density * slice.depth * slice.length);
        SectionOfTail { mass, drag, ..SectionOfTail::without_length(slice) }
    }

    /// Virtual mass per length, kg/m.
    fn added_mass(&self, slice: &Slice) -> f64 {
        elongated::virtual_mass(self.density, slice.depth)
    }

    fn zero_term(&self) -> Term {
        Term { value: 0.0, by_displacement: vec![[0.0; 2]; self.marks], by_velocity: vec![[0.0; 2]; self.marks] }
    }
}

impl Slice {
    fn section_at(&self, displacement: &[Point2], velocity: &[Point2]) -> Section {
        let weighted_sum =
            |weights: &[f64], marks: &[Point2], k: usize| weights.iter().zip(marks).map(|(w, m)| w * m[k]).sum::<f64>();
        let Weights { value, slope } = &self.weights;
        // Not normalised: the tail keeps its length, so |r'| differs from 1 by the interpolation alone, and the
        // derivative by a displacement stays a constant weight.
        let tangent = [1.0 + weighted_sum(slope, displacement, 0), weighted_sum(slope, displacement, 1)];
        Section { tangent, velocity: [weighted_sum(value, velocity, 0), weighted_sum(value, velocity, 1)] }
    }

    /// Adds the `force` of this section to a term.
    fn add_force(
        &self,
        term: &mut Term,
        displacement: &[Point2],
        velocity: &[Point2],
        force: &dyn Fn(&Section) -> ValueWithGradient,
    ) {
        let Weights { value, slope } = &self.weights;
        let section_force = force(&self.section_at(displacement, velocity));
        term.value += section_force.value;
        for mark in 0..value.len() {
            for k in 0..2 {
                term.by_displacement[mark][k] += slope[mark] * section_force.by_tangent[k];
                term.by_velocity[mark][k] += value[mark] * section_force.by_velocity[k];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn tail(count: usize) -> Tail {
        Tail::new(1000.0, &Stations { clamp: 0.01, marks: &[0.05, 0.07, 0.09], edge: 0.11, end: 0.11 }, count, &|a| {
            0.06 - 0.2 * a
        })
        .unwrap()
    }

    const FREE: Coefficients = Coefficients { added: 1.0, drag: 0.0 };
    const MOVED: [Point2; 3] = [[-1e-3, 5e-3], [-3e-3, 12e-3], [-6e-3, 20e-3]];
    const SPEED: [Point2; 3] = [[-0.01, 0.1], [-0.03, 0.18], [-0.05, 0.3]];

    #[test]
    fn every_gradient_is_that_of_central_differences() {
        let (tail, step) = (tail(12), 1e-6);
        let parts = |t: Terms| [t.trailing_edge, t.edge_flux, t.momentum, t.drag];
        let found = parts(tail.terms(&MOVED, &SPEED));
        for (mark, k) in (0..3).flat_map(|m| [(m, 0), (m, 1)]) {
            let moved = |by: f64| {
                let mut other = MOVED;
                other[mark][k] += by;
                parts(tail.terms(&other, &SPEED))
            };
            let quicker = |by: f64| {
                let mut other = SPEED;
                other[mark][k] += by;
                parts(tail.terms(&MOVED, &other))
            };
            let (places, speeds) = ([moved(step), moved(-step)], [quicker(step), quicker(-step)]);
            for (i, part) in found.iter().enumerate() {
                let by = |two: &[[Term; 4]; 2]| (two[0][i].value - two[1][i].value) / (2.0 * step);
                let near = |a: f64, b: f64| (a - b).abs() < 1e-6 * a.abs().max(b.abs()).max(1e-3);
                assert!(
                    near(by(&places), part.by_displacement[mark][k]) && near(by(&speeds), part.by_velocity[mark][k]),
                    "part {i}"
                );
            }
        }
    }

    #[test]
    fn the_integrals_converge_with_the_square_of_the_sections() {
        let of = |count: usize| tail(count).terms(&MOVED, &SPEED).momentum.value;
        let fine = of(640);
        let ratio = (of(10) - fine) / (of(20) - fine);
        assert!((3.6..4.4).contains(&ratio), "{ratio}");
    }

    #[test]
    fn over_a_beat_of_small_amplitude_the_mean_thrust_is_that_of_the_paper() {
        // small bends: [½ m w² x'] is ½ m ẏ², the sliding is of fourth order, the momentum's rate has no mean
        let tail = tail(24);
        let (mut simple, mut shed, n) = (0.0, 0.0, 400);
        for i in 0..n {
            let angle = TAU * f64::from(i) / f64::from(n);
            let motion = |amplitude: f64| [0.0, amplitude * angle.sin()];
            let rate = |amplitude: f64| [0.0, 4.0 * TAU * amplitude * angle.cos()];
            let terms = tail.terms(&[1e-4, 2e-4, 3e-4].map(motion), &[1e-4, 2e-4, 3e-4].map(rate));
            simple += terms.trailing_edge.value / f64::from(n);
            shed += terms.edge_flux.value / f64::from(n);
        }
        assert!((shed / simple - 1.0).abs() < 1e-3, "{shed} {simple}");
    }

    /// Marks of a tail that keeps its length while it bends by `angle` at its end, and their velocities for that angle's `rate`.
    fn bent(angle: f64, rate: f64) -> ([Point2; 3], [Point2; 3]) {
        let place = |a: f64, angle: f64| {
            let (n, l) = (400, a - 0.01);
            (0..n).fold([0.0; 2], |[x, y], i| {
                let s = (f64::from(i) + 0.5) / f64::from(n) * l;
                let turn = angle * (s / 0.1) * (2.0 - s / 0.1);
                [x + (turn.cos() - 1.0) * l / f64::from(n), y + turn.sin() * l / f64::from(n)]
            })
        };
        let moved = [0.05, 0.08, 0.11].map(|a| place(a, angle));
        let speed = [0.05, 0.08, 0.11].map(|a| {
            let (ahead, back) = (place(a, angle + 1e-5), place(a, angle - 1e-5));
            [0, 1].map(|k| rate * (ahead[k] - back[k]) / 2e-5)
        });
        (moved, speed)
    }

    /// Sum over marks of a force times a velocity, W.
    fn power(force: &[Point2], speed: &[Point2]) -> f64 {
        force.iter().zip(speed).map(|(f, v)| f[0] * v[0] + f[1] * v[1]).sum()
    }

    #[test]
    fn the_power_of_the_tail_is_the_rate_of_energy_of_the_water_and_the_flux_at_the_edge() {
        // P = d/dt ∫ ½ m w² da − ½ m w² u at the edge, of a tail that keeps its length [lighthill1971]
        let tail = Tail::new(
            1000.0,
            &Stations { clamp: 0.01, marks: &[0.05, 0.08, 0.11], edge: 0.11, end: 0.11 },
            200,
            &|a| 0.06 - 0.2 * a,
        )
        .unwrap();
        let motion = |t: f64| bent(0.6 * (9.0 * t).sin(), 5.4 * (9.0 * t).cos());
        let water = |t: f64| {
            let (moved, speed) = motion(t);
            tail.water_force(&moved, &speed, FREE)
        };
        let energy = |t: f64| {
            let (moved, speed) = motion(t);
            0.5 * power(&tail.water_force(&moved, &speed, FREE).momentum, &speed)
        };
        let (t, step) = (0.07, 1e-5);
        let (moved, speed) = motion(t);
        let (ahead, back) = (water(t + step).momentum, water(t - step).momentum);
        let rate: Vec<Point2> =
            ahead.iter().zip(&back).map(|(a, b)| [0, 1].map(|k| (a[k] - b[k]) / (2.0 * step))).collect();
        let spent = power(&rate, &speed) - power(&water(t).force, &speed);
        let gained = (energy(t + step) - energy(t - step)) / (2.0 * step);
        let edge = tail.edge.section_at(&moved, &speed);
        let mass = elongated::virtual_mass(1000.0, tail.edge.depth);
        let leaves = 0.5 * mass * edge.normal_velocity().value.powi(2) * edge.tangential_velocity().value;
        // the spline through three marks keeps its length to a few hundredths
        assert!((spent - gained + leaves).abs() < 0.05 * leaves.abs(), "{spent} {gained} {leaves}");
    }

    #[test]
    fn twice_the_added_mass_doubles_the_momentum_of_the_water_and_its_flux() {
        let of = |added: f64| tail(24).water_force(&MOVED, &SPEED, Coefficients { added, drag: 0.0 });
        let doubled = |list: Vec<Point2>| list.into_iter().map(|at| at.map(|x| 2.0 * x)).collect::<Vec<_>>();
        let (one, two) = (of(1.0), of(2.0));
        // a factor of two is exact
        assert_eq!((two.momentum, two.force), (doubled(one.momentum), doubled(one.force)));
    }

    #[test]
    fn drag_dissipates_power_and_changes_nothing_else() {
        let tail = tail(24);
        let (free, dragged) = (
            tail.water_force(&MOVED, &SPEED, FREE),
            tail.water_force(&MOVED, &SPEED, Coefficients { drag: 2.0, ..FREE }),
        );
        assert_eq!(free.momentum, dragged.momentum);
        assert!(power(&dragged.force, &SPEED) < power(&free.force, &SPEED));
    }

    #[test]
    fn a_fin_behind_the_edge_has_added_mass_and_drag_but_no_flux() {
        let of = |end: Metre| {
            Tail::new(1000.0, &Stations { clamp: 0.01, marks: &[0.05, 0.07, 0.09], edge: 0.09, end }, 16, &|a| {
                0.5 * (0.11 - a)
            })
            .unwrap()
        };
        let (short, long) = (of(0.09), of(0.11));
        let water = |tail: &Tail, drag: f64| tail.water_force(&MOVED, &SPEED, Coefficients { drag, ..FREE });
        let kinetic = |tail: &Tail| 0.5 * power(&water(tail, 0.0).momentum, &SPEED);
        assert!(kinetic(&long) > 1.05 * kinetic(&short));
        assert_eq!(water(&long, 0.0).force, water(&short, 0.0).force);
        let spent = |tail: &Tail| power(&water(tail, 1.0).force, &SPEED) - power(&water(tail, 0.0).force, &SPEED);
        assert!(spent(&long) < 1.05 * spent(&short) && spent(&short) < 0.0);
    }

    #[test]
    fn a_mark_beyond_the_end_is_refused() {
        assert!(
            Tail::new(1e3, &Stations { clamp: 0.0, marks: &[0.05, 0.2], edge: 0.1, end: 0.1 }, 10, &|_| 0.05).is_err()
        );
    }
}
