//! The load of an equilibrium: coordinates in the space of dimensionless constants.

use si::Pascal;

use crate::model::{BODY, Elastic};

/// Scales of the Poisson's ratios of the softest material, which is nearly incompressible, and of others, relative to the logarithm
/// of a modulus.
const BY_RATIO: [f64; 2] = [10.0, 1.0];

/// The derivative of a shape by a coordinate of its load.
#[derive(Debug, Clone, PartialEq)]
pub struct Slope {
    /// The coordinate's number.
    pub coordinate: usize,
    /// The derivative, 3 entries per node, m.
    pub slope: Vec<f64>,
}

/// What derivatives are by, beside the moduli.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extra {
    /// ν of every solid.
    PoissonsRatios,
    /// Both ratios of stiffening.
    Stiffening,
}

impl Extra {
    /// The coordinate of the constant `k` of a body of so many solids, and its change by a unit of the constant.
    fn coordinate(self, k: usize, solids: usize) -> (usize, f64) {
        match self {
            Self::PoissonsRatios => (solids + k, BY_RATIO[k.min(1)]),
            Self::Stiffening => (2 * solids + k, 1.0),
        }
    }
}

fn scale_field(field: &mut [f64], factor: f64) {
    field.iter_mut().for_each(|u| *u *= factor);
}

/// Scale of the pressure in [`Load::expansion_distance`].
const PRESSURE: f64 = 4.0;

/// The load of an equilibrium: the filled chamber, and coordinates in the space of dimensionless constants.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    pub(super) chamber: usize,
    /// The pressure first.
    pub(super) at: Vec<f64>,
}

impl Load {
    /// Of a body with these constants whose `chamber` is filled with `pressure`; `unit` is the pressure over a modulus that counts as one.
    pub fn new(chamber: usize, pressure: Pascal, elastic: &Elastic, unit: f64) -> Self {
        let (e, nu) = (&elastic.youngs_moduli, &elastic.poissons_ratios);
        let moduli = e[1..].iter().map(|modulus| (modulus / e[BODY]).ln());
        let ratios = nu.iter().enumerate().map(|(region, nu)| BY_RATIO[region.min(1)] * nu);
        let constants = moduli.chain(ratios).chain(elastic.stiffening);
        Self { chamber, at: std::iter::once(pressure / e[BODY] / unit).chain(constants).collect() }
    }

    /// The same body at rest.
    pub fn without(mut self) -> Self {
        self.at[0] = 0.0;
        self
    }

    /// The load at `part` (0 to 1) of the way to `other`, whose chamber it has.
    pub fn towards(&self, other: &Self, part: f64) -> Self {
        let coordinates = self.at.iter().zip(&other.at).map(|(start, end)| start + part * (end - start)).collect();
        Self { chamber: other.chamber, at: coordinates }
    }

    /// The pressure and the constants of a body with this load whose softest material has the modulus `body`.
    pub fn constants(&self, body: Pascal, unit: f64) -> (Pascal, Elastic) {
        let solids = self.at.len() / 2 - 1;
        let (moduli, ratios_and_stiffening) = self.at[1..].split_at(solids - 1);
        let (ratios, stiffening) = ratios_and_stiffening.split_at(solids);
        let ratio = |(region, nu): (usize, &f64)| nu / BY_RATIO[region.min(1)];
        let elastic = Elastic {
            youngs_moduli: std::iter::once(body).chain(moduli.iter().map(|log_ratio| body * log_ratio.exp())).collect(),
            poissons_ratios: ratios.iter().enumerate().map(ratio).collect(),
            stiffening: [stiffening[0], stiffening[1]],
        };
        (self.at[0] * body * unit, elastic)
    }

    /// Derivatives of a shape under this load by its coordinates from those by constants: by E of every solid (m/Pa), then by what `extra`
    /// says. None at rest.
    pub fn slopes(&self, moduli: &[Pascal], mut derivatives: Vec<Vec<f64>>, extra: Extra) -> Vec<Slope> {
        let (solids, pressure) = (moduli.len(), self.at[0]);
        if pressure == 0.0 || derivatives.len() < solids {
            return Vec::new();
        }
        let further = derivatives.split_off(solids);
        derivatives.iter_mut().zip(moduli).for_each(|(slope, modulus)| scale_field(slope, *modulus));
        // ∂u/∂ln E of the softest solid is −s ∂u/∂s − Σ ∂u/∂ln r, where s is the pressure and r are the moduli over that one
        let sum = |k: usize| -derivatives.iter().map(|slope| slope[k]).sum::<f64>() / pressure;
        let by_pressure = Slope { coordinate: 0, slope: (0..derivatives[BODY].len()).map(sum).collect() };
        let by_ratio =
            derivatives.into_iter().enumerate().skip(1).map(|(coordinate, slope)| Slope { coordinate, slope });
        let by_others = further.into_iter().enumerate().map(|(k, mut slope)| {
            let (coordinate, unit) = extra.coordinate(k, solids);
            scale_field(&mut slope, 1.0 / unit);
            Slope { coordinate, slope }
        });
        std::iter::once(by_pressure).chain(by_ratio).chain(by_others).collect()
    }

    /// How far a search may move the coordinate `number` from a body that is known: a twentieth of the highest pressure, and of the constants
    /// about what identification leaves open.
    pub fn spread(&self, number: usize) -> f64 {
        let solids = self.at.len() / 2 - 1;
        match number {
            0 => 0.05,
            ratio if ratio < solids => 0.3,
            nu if nu < 2 * solids => 0.01 * BY_RATIO[(nu - solids).min(1)],
            _ => 0.03,
        }
    }

    /// The difference of the coordinate `number` from that of `other`.
    pub(crate) fn coordinate_difference(&self, other: &Self, number: usize) -> f64 {
        self.at[number] - other.at[number]
    }

    /// Its pressure over that of `other`, each relative to the softest material.
    pub fn part_of(&self, other: &Self) -> f64 {
        self.at[0] / other.at[0]
    }

    /// Distance of the constants alone, whatever the pressures.
    pub(crate) fn constants_distance(&self, other: &Self) -> f64 {
        self.at[1..].iter().zip(&other.at[1..]).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }

    /// Distance over which an expansion fails: shapes change most with the pressure.
    pub(crate) fn expansion_distance(&self, other: &Self) -> f64 {
        self.distance_to(other).hypot(PRESSURE * self.coordinate_difference(other, 0))
    }

    /// Distance from another.
    pub fn distance_to(&self, other: &Self) -> f64 {
        self.at.iter().zip(&other.at).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }
}
