//! The parameters of a case, each with its perturbation.

use fem::{Branch, Parameter, Relaxation};

use crate::Body;
use crate::case::{Case, Dynamic, Scheme};

/// One parameter of a case.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CaseParameter {
    /// Its name.
    pub name: String,
    pub parameter: Parameter,
    /// Its value in the case.
    pub value: f64,
    /// Its perturbation, in the parameter's unit: small enough for a parabola, large enough against rounding.
    pub turn: f64,
}

/// Relative perturbation of a modulus, a density, a pressure or a damping.
const PART: f64 = 0.01;
/// Perturbation of Poisson's ratio, relative to its distance from ½.
const LEFT: f64 = 0.04;

/// All parameters of the case's loss.
pub(super) fn case_parameters(case: &Case, body: &Body) -> Vec<CaseParameter> {
    let mut parameters = Vec::new();
    let inert = case.dynamic.as_ref().is_some_and(|set| set.scheme != Scheme::QuasiStatic);
    let weighs = inert || case.gravity != [0.0; 3];
    for (region, given) in body.system.regions().iter().enumerate() {
        let name = |what: &str| format!("{what} of region {region}");
        parameters.push(relative_parameter(name("E"), Parameter::YoungsModulus(region), given.youngs_modulus));
        let (nu, turn) = (given.poissons_ratio, LEFT * (0.5 - given.poissons_ratio));
        let parameter = Parameter::PoissonsRatio(region);
        parameters.push(CaseParameter { name: name("ν"), parameter, value: nu, turn });
        if given.material.is_stiffening() {
            let term = |term: usize| {
                let parameter = Parameter::Stiffening { region, term };
                CaseParameter {
                    name: name(["C20/C10", "C30/C10"][term]),
                    parameter,
                    value: given.stiffening[term],
                    turn: PART,
                }
            };
            parameters.extend((0..2).map(term));
        }
        if case.dynamic.is_some() {
            parameters.extend(relaxation_parameters(region, &given.relaxation));
        }
        if weighs {
            parameters.push(relative_parameter(name("ρ"), Parameter::Density(region), given.density));
        }
    }
    for (chamber, &number) in case.chamber.iter().zip(&body.numbers) {
        let name = chamber.name.clone().unwrap_or_else(|| number.to_string());
        parameters.push(relative_parameter(format!("pressure gain of {name}"), Parameter::PressureGain(number), 1.0));
    }
    parameters.extend(force_parameter(body));
    parameters.extend(case.dynamic.iter().flat_map(damping_parameters));
    parameters
}

fn relative_parameter(name: String, parameter: Parameter, value: f64) -> CaseParameter {
    CaseParameter { name, parameter, value, turn: PART * value }
}

/// The numbers of a region's relaxation.
fn relaxation_parameters(region: usize, relaxation: &Relaxation) -> Vec<CaseParameter> {
    let name = |what: &str| format!("{what} of region {region}");
    if let Some(springpot) = relaxation.as_springpot() {
        let strength =
            relative_parameter(name("springpot strength"), Parameter::SpringpotStrength(region), springpot.strength);
        let exponent =
            relative_parameter(name("springpot exponent"), Parameter::SpringpotExponent(region), springpot.exponent);
        return vec![strength, exponent];
    }
    let pair = |(branch, is): (usize, &Branch)| {
        let name = |what: &str| name(&format!("{what} of branch {branch}"));
        let strength =
            relative_parameter(name("strength"), Parameter::RelaxationStrength { region, branch }, is.strength);
        [strength, relative_parameter(name("time"), Parameter::RelaxationTime { region, branch }, is.time)]
    };
    relaxation.branches().iter().enumerate().flat_map(pair).collect()
}

/// The largest component of all dead forces.
fn force_parameter(body: &Body) -> Option<CaseParameter> {
    let largest = (0..body.forces.len()).max_by(|&a, &b| body.forces[a].abs().total_cmp(&body.forces[b].abs()))?;
    let value = body.forces[largest];
    let (node, axis) = (largest / 3, largest % 3);
    let name = format!("force on node {node} along {}", ["x", "y", "z"][axis]);
    (value != 0.0).then(|| relative_parameter(name, Parameter::Force { node, axis }, value))
}

fn damping_parameters(set: &Dynamic) -> impl Iterator<Item = CaseParameter> {
    let alpha = relative_parameter("mass damping".into(), Parameter::MassDamping, set.mass_damping);
    let beta = relative_parameter("stiffness damping".into(), Parameter::StiffnessDamping, set.stiffness_damping);
    [alpha, beta].into_iter().filter(|parameter| parameter.value > 0.0)
}
