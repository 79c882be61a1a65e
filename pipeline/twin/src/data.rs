//! The arrays of a reduced tail.

/// A reduced tail of r coordinates q.
#[derive(Debug, Clone, PartialEq)]
pub struct TwinData {
    /// VᵀMV, r × r, kg m² in the units of q.
    pub mass: Vec<f64>,
    /// Largest |q| of the shapes that it was reduced from: the size that tolerances are relative to.
    pub size: f64,
    /// Its solids.
    pub regions: Vec<Region>,
    /// Its chambers.
    pub chambers: Vec<Chamber>,
    /// Sections in still water; none: in air.
    pub sections: Vec<Section>,
    /// Displacements that have a name.
    pub outputs: Vec<Output>,
    /// Whether half of a symmetric body is modelled: chambers have half of their volume, the water half of its force.
    pub half: bool,
    /// Where the tail comes from, such as specimen, profile, version and records: keys and values.
    pub provenance: Vec<(String, String)>,
}

/// A displacement of a point along one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Its name: the point's, `_` and the axis.
    pub name: String,
    /// r numbers, m per unit of q.
    pub row: Vec<f64>,
    /// Coordinate of the point at rest along that axis, m.
    pub at_rest: f64,
}

/// One solid at its cubature points, of ψ = μ/2 x + C₂₀ x² + C₃₀ x³ + λ/2 ln²J with x = I₁ − 3 − 2 ln J: the neo-Hookean law
/// \[bonet2008\] where C₂₀ and C₃₀ are zero, Yeoh's \[yeoh1993\] otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Its name on the card, numbered where its points are in several groups, which integrate different shares of its moduli.
    pub name: String,
    /// μ after all relaxation, Pa.
    pub mu: f64,
    /// λ, Pa.
    pub lambda: f64,
    /// C₂₀ and C₃₀, Pa.
    pub stiffening: [f64; 2],
    /// Maxwell branches of μ: strength relative to μ (no unit) and time (s).
    pub branches: Vec<[f64; 2]>,
    /// Weight of each cubature point, m³.
    pub weights: Vec<f64>,
    /// ∂F/∂q, points × r × 9, per unit of q: columns of F one below the other.
    pub gradients: Vec<f64>,
}

/// The volume of a chamber, V₀ + a·q + ½ B q q + ⅙ C q q q; of a half model, of the half.
#[derive(Debug, Clone, PartialEq)]
pub struct Chamber {
    /// The channel that fills it.
    pub name: String,
    /// Lowest and highest pressure that the tail was reduced under, Pa: beyond them its shapes are unknown.
    pub range: [f64; 2],
    /// V₀, m³.
    pub at_rest: f64,
    /// a, r.
    pub linear: Vec<f64>,
    /// B, r × r.
    pub quadratic: Vec<f64>,
    /// C(·, i, j) for i ≤ j, r(r+1)/2 × r.
    pub cubic: Vec<f64>,
}

/// A section of the tail in still water. With tangent t = (1, 0) + S q, normal n = (−t_y, t_x), velocity V q̇, w = velocity · n and
/// u = velocity · t, it has the generalised force
/// Vᵀ [−d/dt (m w n) − c |w| w n + l (u w n − ½ w² t)] − h Sᵀ (u w n − ½ w² t)          \[lighthill1971\], \[taylor1952\].
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// S, 2 × r, per unit of q.
    pub slope: Vec<f64>,
    /// V, 2 × r, m per unit of q.
    pub value: Vec<f64>,
    /// m, c, h, l: added mass (kg), drag (kg/m), added mass that sheds momentum (kg) and mass per length that leaves (kg/m).
    pub by: [f64; 4],
}

impl Chamber {
    /// The range of a chamber whose pressures nobody has limited, Pa.
    pub const UNLIMITED: [f64; 2] = [f64::MIN, f64::MAX];
}

impl TwinData {
    /// r.
    pub fn coordinates(&self) -> usize {
        self.mass.len().isqrt()
    }

    /// Number of cubature points.
    pub fn points(&self) -> usize {
        self.regions.iter().map(|region| region.weights.len()).sum()
    }
}
