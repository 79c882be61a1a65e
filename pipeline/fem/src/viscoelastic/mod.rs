//! Linear relaxation of the shear stress at finite strain: generalised Maxwell branches beside any law.
//!
//! The second Piola–Kirchhoff stress is S = S(F) + Σᵢ Qᵢ, the law's own long-term stress and one overstress per branch
//! with Q̇ᵢ + Qᵢ/τᵢ = gᵢ Ṡ_μ, where S_μ = F⁻¹ P_μ is the part of the law that is linear in μ.
//! [simo1987, holzapfel1996] S is unchanged by a rotation of the body, and so are the branches.
//!
//! C₂₀ and C₃₀ do not relax: where a law softens with strain, its loss factor and the ratio of its dynamic to its static
//! modulus rise, as damping does in a silicone bar under weights (ratios of 0.050, 0.064 and 0.084 while the frequency
//! falls).
//!
//! Over a step of length h in which S_μ changes at a constant rate, the branches are integrated exactly [taylor1970]:
//! Qᵢ ← dᵢ Qᵢ + aᵢ (S_μ − S_μ,before), dᵢ = e^(−h/τᵢ), aᵢ = gᵢ (1 − dᵢ) τᵢ/h.
//! The error is of second order in h; a branch much faster than the step acts as a viscous damper of the same dissipation,
//! one much slower as a spring. At the end of a step, then, P = P(F) + A P_μ + F H with A = Σ aᵢ, and H known
//! from the past: the derivative of an incremental potential, whose tangent is symmetric.
//!
//! Histories are kept per unit of μ, so that the stress of the branches is linear in μ like the law's.

pub(crate) mod adjoint;
pub(crate) mod history;
pub(crate) mod sensitivity;
pub(crate) mod step;
