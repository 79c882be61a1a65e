//! The law of a solid at eight points at once: stress and its derivative along any change.
//!
//! P = μ̂ (F − G) + λ ln J G + F H with G = F⁻ᵀ, μ̂ = μ + 2 s′(x), s = C₂₀ x² + C₃₀ x³ and H the stress that relaxation holds.

use crate::lanes::{Lanes, per_lane, splat};

/// Nine numbers of a tensor, columns one below the other.
pub type Tensor = [Lanes; 9];
/// xx, yy, zz, yz, xz, xy.
pub type Symmetric = [Lanes; 6];

/// No stress.
pub(crate) const NOTHING: Symmetric = [Lanes::ZERO; 6];

/// The constants that act in a step, Pa.
#[derive(Debug, Clone, Copy)]
pub struct Constants {
    /// μ (1 + A), A the gain of all branches.
    pub mu: f64,
    pub lambda: f64,
    pub stiffening: [f64; 2],
}

/// A deformation with what follows from it.
pub struct Deformed {
    pub gradient: Tensor,
    /// G.
    pub(crate) cofactor: Tensor,
    pub(crate) ln_volume: Lanes,
    /// μ̂.
    secant: Lanes,
    /// 4 s″(x).
    curvature: Lanes,
}

/// Index of row i and column k.
pub(crate) const fn at(i: usize, k: usize) -> usize {
    i + 3 * k
}

/// A tensor by row and column, written out: a loop over entries would be vectorised across them, with gathers, at a third of the speed.
#[inline(always)]
pub(crate) fn nine(of: impl Fn(usize, usize) -> Lanes) -> Tensor {
    [of(0, 0), of(1, 0), of(2, 0), of(0, 1), of(1, 1), of(2, 1), of(0, 2), of(1, 2), of(2, 2)]
}

/// The two other rows, in turn.
const OTHERS: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// Below this |J − 1| / (J + 1) the series of ln J is exact to rounding.
const NEAR: f64 = 0.2;
/// 1/(2k+1) of the area hyperbolic tangent, so that 0.2²³/23 is below rounding.
const SERIES: [f64; 11] = [
    1.0,
    1.0 / 3.0,
    1.0 / 5.0,
    1.0 / 7.0,
    1.0 / 9.0,
    1.0 / 11.0,
    1.0 / 13.0,
    1.0 / 15.0,
    1.0 / 17.0,
    1.0 / 19.0,
    1.0 / 21.0,
];

/// ln, by 2 artanh((J − 1)/(J + 1)) where all lanes are near one: silicone hardly changes its volume.
#[inline(always)]
fn ln(x: Lanes) -> Lanes {
    let s = (x - splat(1.0)) / (x + splat(1.0));
    if !s.to_array().iter().all(|s| s.abs() < NEAR) {
        let lanes = x.to_array();
        return per_lane(|i| lanes[i].ln());
    }
    let square = s * s;
    let sum = SERIES.iter().rev().fold(splat(0.0), |sum, factor| splat(*factor).plus(sum, square));
    (s + s) * sum
}

impl Deformed {
    /// At F = I + `change`.
    #[inline(always)]
    pub fn new(change: &Tensor, by: &Constants) -> Self {
        let mut f = *change;
        for k in [0, 4, 8] {
            f[k] = f[k] + splat(1.0);
        }
        let g = nine(|row, column| {
            let ((a, b), (c, d)) = (OTHERS[row], OTHERS[column]);
            f[at(a, c)] * f[at(b, d)] - f[at(a, d)] * f[at(b, c)]
        });
        let volume = f[0] * g[0] + f[1] * g[1] + f[2] * g[2];
        let inverse = splat(1.0) / volume;
        let g = nine(|row, column| g[at(row, column)] * inverse);
        let ln_volume = ln(volume);
        let x = reduced_invariant(&f, ln_volume);
        let [c20, c30] = by.stiffening.map(splat);
        let (two, six) = (splat(2.0), splat(6.0));
        let secant = splat(by.mu).plus((two * two * c20).plus(six * c30, x), x);
        let curvature = splat(4.0) * (two * c20).plus(six * c30, x);
        Self { gradient: f, cofactor: g, ln_volume, secant, curvature }
    }

    /// P times `weight`, Pa.
    #[inline(always)]
    pub fn stress(&self, constants: &Constants, held: Option<&Symmetric>, weight: Lanes) -> Tensor {
        let (f, g) = (&self.gradient, &self.cofactor);
        let pressed = splat(constants.lambda) * self.ln_volume - self.secant;
        let stress = |row, column| (pressed * g[at(row, column)]).plus(self.secant, f[at(row, column)]);
        match held {
            None => nine(|row, column| stress(row, column) * weight),
            Some(held) => nine(|row, column| plus_product(stress(row, column), (f, held), row, column) * weight),
        }
    }

    /// ∂P : `change`, Pa:
    /// μ̂ δF + (μ̂ − λ ln J) G δFᵀ G + λ (G : δF) G + 4 s″ ((F − G) : δF) (F − G) + δF H.
    #[inline(always)]
    pub fn stress_change(&self, constants: &Constants, held: &Symmetric, change: &Tensor) -> Tensor {
        let (f, g) = (&self.gradient, &self.cofactor);
        let geometric = self.secant - splat(constants.lambda) * self.ln_volume;
        let (along_g, along_f) = (contract(g, change), contract(f, change));
        let bent = self.curvature * (along_f - along_g);
        let cofactor_factor = splat(constants.lambda) * along_g - bent;
        let turned = nine(|row, column| {
            (g[at(row, 0)] * change[at(column, 0)])
                .plus(g[at(row, 1)], change[at(column, 1)])
                .plus(g[at(row, 2)], change[at(column, 2)])
        });
        nine(|row, column| {
            let k = at(row, column);
            let product = (turned[at(row, 0)] * g[at(0, column)])
                .plus(turned[at(row, 1)], g[at(1, column)])
                .plus(turned[at(row, 2)], g[at(2, column)]);
            let entry = (self.secant * change[k]).plus(geometric, product).plus(cofactor_factor, g[k]).plus(bent, f[k]);
            plus_product(entry, (change, held), row, column)
        })
    }

    /// μ̂, 4 s″ and μ̂ − λ ln J, Pa: the factors of [`Deformed::stress_change`].
    pub(crate) fn tangent_factors(&self, constants: &Constants) -> [Lanes; 3] {
        [self.secant, self.curvature, self.secant - splat(constants.lambda) * self.ln_volume]
    }

    /// S = F⁻¹ P = μ̂ R + λ ln J (I − R) of the law alone, Pa, from R = I − C⁻¹.
    #[inline(always)]
    pub(crate) fn second_stress(&self, by: &Constants, relaxing: &Symmetric) -> Symmetric {
        let pressed = splat(by.lambda) * self.ln_volume;
        let mut stress = relaxing.map(|entry| (self.secant - pressed) * entry);
        stress[..3].iter_mut().for_each(|entry| *entry = *entry + pressed);
        stress
    }

    /// S_μ / μ = I − C⁻¹, the second Piola–Kirchhoff stress of the part that relaxes.
    #[inline(always)]
    pub(crate) fn relaxing_stress(&self) -> Symmetric {
        let g = &self.cofactor;
        let product = |a: usize, b: usize| {
            (g[at(0, a)] * g[at(0, b)]).plus(g[at(1, a)], g[at(1, b)]).plus(g[at(2, a)], g[at(2, b)])
        };
        let [zero, one] = [0.0, 1.0].map(splat);
        let diagonal = [0, 1, 2].map(|a| one - product(a, a));
        let [yz, xz, xy] = [(1, 2), (0, 2), (0, 1)].map(|(a, b)| zero - product(a, b));
        [diagonal[0], diagonal[1], diagonal[2], yz, xz, xy]
    }
}

/// x = I₁ − 3 − 2 ln J.
#[inline(always)]
pub(crate) fn reduced_invariant(f: &Tensor, ln_volume: Lanes) -> Lanes {
    contract(f, f) - splat(3.0) - ln_volume - ln_volume
}

/// A : B
#[inline(always)]
fn contract(a: &Tensor, b: &Tensor) -> Lanes {
    let column = |k: usize| (a[k] * b[k]).plus(a[k + 1], b[k + 1]).plus(a[k + 2], b[k + 2]);
    column(0) + column(3) + column(6)
}

/// `sum` and the entry of A H in `row` and `column`.
#[inline(always)]
fn plus_product(sum: Lanes, (a, [xx, yy, zz, yz, xz, xy]): (&Tensor, &Symmetric), row: usize, column: usize) -> Lanes {
    let [x, y, z] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]][column];
    sum.plus(a[at(row, 0)], *x).plus(a[at(row, 1)], *y).plus(a[at(row, 2)], *z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::LANES;
    use materials::material::Moduli;
    use nalgebra::Matrix3;

    const BY: Constants = Constants { mu: 7e4, lambda: 9e5, stiffening: [-1e3, 400.0] };

    fn change(far: f64) -> Tensor {
        std::array::from_fn(|k| per_lane(|i| far * (1.0 + 2.3 * k as f64 + 0.7 * i as f64).sin()))
    }

    fn matrix(of: &Tensor, i: usize) -> Matrix3<f64> {
        Matrix3::from_fn(|row, column| of[at(row, column)].to_array()[i])
    }

    #[test]
    fn stress_and_tangent_are_those_of_yeohs_law() {
        let law = materials::by_name("yeoh").unwrap();
        let moduli = Moduli { mu: BY.mu, lambda: BY.lambda, stiffening: BY.stiffening };
        // near rest the logarithm is a series, farther away it is not
        for far in [0.05, 0.25] {
            let here = Deformed::new(&change(far), &BY);
            let stress = here.stress(&BY, None, splat(2.0));
            let along = change(0.9);
            let image = here.stress_change(&BY, &[splat(0.0); 6], &along);
            for i in 0..LANES {
                let exact = law.constitutive_response(&matrix(&here.gradient, i), moduli);
                assert!((matrix(&stress, i) * 0.5 - exact.stress).norm() < 1e-11 * exact.stress.norm().max(BY.mu));
                let by = nalgebra::SVector::<f64, 9>::from_fn(|k, _| along[k].to_array()[i]);
                let exact = Matrix3::from_column_slice((exact.tangent * by).as_slice());
                assert!((matrix(&image, i) - exact).norm() < 1e-11 * exact.norm());
            }
        }
    }

    #[test]
    fn the_part_that_relaxes_is_that_of_a_region_in_one_step() {
        let law = materials::by_name("neo_hookean").unwrap();
        let region =
            materials::step::RegionStep::new(law, Moduli::of(2e5, 0.45), &materials::Relaxation::default(), 0.1);
        let here = Deformed::new(&change(0.1), &BY);
        let found = here.relaxing_stress();
        for i in 0..LANES {
            let exact = region.stress(&matrix(&here.gradient, i));
            (0..6).for_each(|n| assert!((found[n].to_array()[i] - exact[n]).abs() < 1e-13));
        }
    }

    #[test]
    fn a_held_stress_adds_f_times_it_and_its_derivative() {
        let held: Symmetric = std::array::from_fn(|n| splat(10.0 * n as f64 - 20.0));
        let here = Deformed::new(&change(0.1), &BY);
        let [with, without] = [Some(&held), None].map(|held| here.stress(&BY, held, splat(1.0)));
        let full = materials::symmetric::full_tensor(&std::array::from_fn(|n| held[n].to_array()[0]));
        let exact = matrix(&here.gradient, 3) * full;
        assert!((matrix(&with, 3) - matrix(&without, 3) - exact).norm() < 1e-10);
        let [with, without] = [held, [splat(0.0); 6]].map(|held| here.stress_change(&BY, &held, &change(1.0)));
        assert!((matrix(&with, 3) - matrix(&without, 3) - matrix(&change(1.0), 3) * full).norm() < 1e-9);
    }
}
