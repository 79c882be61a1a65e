//! Validation of a mesh, its properties and its constraints before anything is solved.

use crate::assembly::reference::ReferenceElements;
use crate::assembly::shape_functions::{CUBE_EDGES, EDGES, QUADRILATERAL_SIDES, SIDES};
use crate::contact::Contact;
use crate::mesh::clamps::Clamps;
use crate::mesh::{Chamber, Mesh};
use crate::properties::{Masses, RegionProperties};
use crate::setup_error::{LARGEST, SMALLEST, SetupError, THINNEST};
use materials::Relaxation;
use materials::material::Material;
use nalgebra::{Matrix6, SymmetricEigen, Vector6};
use si::vec3;
use sparse::NodeGraph;
use std::collections::BTreeMap;

/// Checks node numbers, coordinates, size and symmetry plane.
pub(crate) fn check_nodes(mesh: &Mesh, clamps: &Clamps) -> Result<(), SetupError> {
    let (nodes, elements) = (mesh.nodes.len(), mesh.elements.len());
    if elements == 0 {
        return Err(SetupError::Empty);
    }
    if mesh.regions.len() != elements {
        return Err(SetupError::Regions { elements, regions: mesh.regions.len() });
    }
    if let Some(node) = mesh.nodes.iter().position(|at| at.iter().any(|x| !x.is_finite())) {
        return Err(SetupError::NodeNotFinite { node, at: mesh.nodes[node] });
    }
    let exists = |part, index, list: &[u32]| match list.iter().find(|&&node| node as usize >= nodes) {
        Some(&node) => Err(SetupError::NoSuchNode { part, index, node, nodes }),
        None => Ok(()),
    };
    (0..elements).try_for_each(|element| exists("element", element, mesh.elements.nodes(element)))?;
    for chamber in &mesh.chambers {
        (0..chamber.faces.len()).try_for_each(|face| exists("chamber face", face, chamber.faces.nodes(face)))?;
    }
    clamps.iter().enumerate().try_for_each(|(index, (node, _))| exists("clamp", index, &[node]))?;
    let size = mesh.size();
    if !(SMALLEST..=LARGEST).contains(&size) {
        return Err(SetupError::Size { size });
    }
    match mesh.nodes.iter().position(|at| mesh.symmetry_plane_z && at[2] < -1e-7 * size) {
        Some(node) => Err(SetupError::BelowSymmetryPlane { node, z: mesh.nodes[node][2] }),
        None => Ok(()),
    }
}

/// Checks the shapes of the elements, and that every node belongs to one.
pub(crate) fn check_elements(mesh: &Mesh, reference: &ReferenceElements, graph: &NodeGraph) -> Result<(), SetupError> {
    for element in 0..mesh.elements.len() {
        let volume = reference.volumes[element];
        let corner = |n: usize| mesh.nodes[mesh.elements.nodes(element)[n] as usize];
        let edges: &[(usize, usize)] = if matches!(mesh.elements.nodes_each(), 8 | 20) { &CUBE_EDGES } else { &EDGES };
        let longest = edges.iter().map(|&(a, b)| vec3::norm(vec3::sub(corner(b), corner(a)))).fold(0.0, f64::max);
        let ratio = volume / longest.powi(3);
        if ratio.is_nan() || ratio.abs() < THINNEST {
            return Err(SetupError::DegenerateElement { element, volume, ratio });
        }
        let weights = &reference.weights[element * reference.points..(element + 1) * reference.points];
        if weights.iter().any(|&weight| weight <= 0.0) {
            return Err(SetupError::InvertedElement { element, volume });
        }
    }
    match (0..graph.len()).find(|&node| graph.neighbours_of(node as u32).is_empty()) {
        Some(node) => Err(SetupError::UnusedNode { node }),
        None => Ok(()),
    }
}

/// Checks that every element has properties, and their ranges.
pub(crate) fn check_regions(mesh: &Mesh, regions: &[RegionProperties]) -> Result<(), SetupError> {
    let given = regions.len();
    if let Some(element) = mesh.regions.iter().position(|&region| region as usize >= given) {
        return Err(SetupError::RegionWithoutProperties { element, region: mesh.regions[element], given });
    }
    for (region, is) in regions.iter().enumerate() {
        check_elastic(region, is.youngs_modulus, is.poissons_ratio)?;
        check_density(region, is.density)?;
        check_stiffening(region, is.stiffening)?;
        check_relaxation(region, is.material, &is.relaxation)?;
    }
    Ok(())
}

/// Checks the ratios C₂₀/C₁₀ and C₃₀/C₁₀.
pub(crate) fn check_stiffening(region: usize, ratios: [f64; 2]) -> Result<(), SetupError> {
    match ratios.into_iter().find(|ratio| !(-10.0..=100.0).contains(ratio)) {
        Some(value) => {
            let (name, range) = ("a ratio of stiffening", "between -10 and 100 (C20/C10 of rubber: -0.1 to 0)");
            Err(SetupError::Property { region, name, value, unit: "", range })
        }
        None => Ok(()),
    }
}

/// Checks that a law can relax: at finite strain that needs an objective one.
pub(crate) fn check_relaxation(
    region: usize,
    material: &dyn Material,
    relaxation: &Relaxation,
) -> Result<(), SetupError> {
    if relaxation.is_none() || material.is_objective() {
        return Ok(());
    }
    Err(SetupError::RelaxationLaw { region, law: material.name() })
}

/// Checks that there is one positive factor per element, or none.
pub(crate) fn element_factors(mesh: &Mesh, factors: &[f64]) -> Result<(), SetupError> {
    let elements = mesh.elements.len();
    if !factors.is_empty() && factors.len() != elements {
        return Err(SetupError::ElementFactors { given: factors.len(), elements });
    }
    match factors.iter().position(|factor| !(*factor > 0.0 && *factor < 1e12)) {
        Some(element) => Err(SetupError::ElementFactor { element, factor: factors[element] }),
        None => Ok(()),
    }
}

/// Checks that no region relaxes where elements have factors: the histories hold one modulus per region.
pub(crate) fn element_factors_relax(factors: &[f64], relaxations: &[&Relaxation]) -> Result<(), SetupError> {
    let relaxes = !factors.is_empty() && relaxations.iter().any(|relaxation| !relaxation.is_none());
    if relaxes { Err(SetupError::ElementFactorsRelax) } else { Ok(()) }
}

/// Checks the range of a density (kg/m³).
pub(crate) fn check_density(region: usize, density: f64) -> Result<(), SetupError> {
    if !(density > 0.0 && density < 1e5) {
        let (name, unit, range) = ("density", "kg/m³", "between 0 and 100000 kg/m³");
        return Err(SetupError::Property { region, name, value: density, unit, range });
    }
    Ok(())
}

/// Checks the ranges of E (Pa) and ν.
pub(crate) fn check_elastic(region: usize, youngs_modulus: f64, poissons_ratio: f64) -> Result<(), SetupError> {
    if !(youngs_modulus > 1.0 && youngs_modulus < 1e13) {
        let (name, unit, range) = ("Young's modulus", "Pa", "between 1 Pa and 10 TPa");
        return Err(SetupError::Property { region, name, value: youngs_modulus, unit, range });
    }
    if !(poissons_ratio > -1.0 && poissons_ratio < 0.5) {
        let (name, unit, range) = ("Poisson's ratio", "", "above -1 and below 0.5 (0.49 to 0.499 for rubber)");
        return Err(SetupError::Property { region, name, value: poissons_ratio, unit, range });
    }
    Ok(())
}

/// Checks nodes and values of attached masses.
pub(crate) fn check_masses(mesh: &Mesh, masses: &Masses) -> Result<(), SetupError> {
    let nodes = mesh.nodes.len();
    for (index, (node, mass)) in masses.iter().enumerate() {
        if node as usize >= nodes {
            return Err(SetupError::NoSuchNode { part: "attached mass", index, node, nodes });
        }
        if !(mass > 0.0 && mass < 1e3) {
            return Err(SetupError::AttachedMass { node, mass });
        }
    }
    Ok(())
}

/// Checks the ranges of a law of contact.
pub(crate) fn check_contact(mesh: &Mesh, Contact { range, pressure }: Contact) -> Result<(), SetupError> {
    let largest = 0.1 * mesh.size();
    if !(range > 0.0 && range <= largest && pressure > 0.0 && pressure.is_finite()) {
        return Err(SetupError::Contact { range, largest, pressure });
    }
    Ok(())
}

/// Checks the range of the share of the μ part that is integrated at finer points.
pub(crate) fn shear_share(share: f64) -> Result<(), SetupError> {
    if (0.0..=1.0).contains(&share) { Ok(()) } else { Err(SetupError::ShearShare { share }) }
}

/// Checks that every connected part is constrained against all six rigid motions.
pub(crate) fn check_constraints(mesh: &Mesh, graph: &NodeGraph, clamps: &Clamps) -> Result<(), SetupError> {
    let constrained: BTreeMap<u32, [bool; 3]> = clamps.iter().collect();
    let size = mesh.size();
    let mut visited = vec![false; graph.len()];
    for node in 0..graph.len() {
        if visited[node] {
            continue;
        }
        let mut gram = Matrix6::zeros();
        let mut queue = vec![node as u32];
        visited[node] = true;
        while let Some(next) = queue.pop() {
            let offset = vec3::scale(vec3::sub(mesh.nodes[next as usize], mesh.nodes[node]), 1.0 / size);
            let axes = constrained.get(&next).copied().unwrap_or_default();
            for motion in (0..3).filter(|&axis| axes[axis]).map(|axis| rigid_motion(offset, axis)) {
                gram += motion * motion.transpose();
            }
            for &other in graph.neighbours_of(next) {
                if !std::mem::replace(&mut visited[other as usize], true) {
                    queue.push(other);
                }
            }
        }
        // In units of the body's size: a clamp of a hundredth of its size leaves eigenvalues near 1e-4.
        if SymmetricEigen::new(gram).eigenvalues.min() < 1e-9 {
            return Err(SetupError::RigidMotion { node });
        }
    }
    Ok(())
}

/// Displacement along `axis` of a point under three unit translations and three unit rotations.
fn rigid_motion(offset: [f64; 3], axis: usize) -> Vector6<f64> {
    let mut motion = Vector6::zeros();
    motion[axis] = 1.0;
    for about in 0..3 {
        let mut spin = [0.0; 3];
        spin[about] = 1.0;
        motion[3 + about] = vec3::cross(spin, offset)[axis];
    }
    motion
}

/// Checks that a chamber's surface is closed, except for edges on the symmetry plane.
pub(crate) fn check_closed(mesh: &Mesh, index: usize, chamber: &Chamber) -> Result<(), SetupError> {
    let (face, element) = (chamber.faces.nodes_each(), mesh.elements.nodes_each());
    if [(3, 4), (6, 10), (8, 20)].iter().all(|pair| *pair != (face, element)) {
        return Err(SetupError::MixedOrders { chamber: index, face, element });
    }
    let sides: &[(usize, usize)] = if face == 8 { &QUADRILATERAL_SIDES } else { &SIDES };
    let size = mesh.size();
    let mut edges: BTreeMap<[u32; 2], (i32, usize)> = BTreeMap::new();
    for face in 0..chamber.faces.len() {
        let nodes = chamber.faces.nodes(face);
        // a side of a triangle among 8-node faces has shrunk to a point
        for (from, to) in sides.iter().map(|&(a, b)| (nodes[a], nodes[b])).filter(|(from, to)| from != to) {
            let (key, sign) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
            let entry = edges.entry(key).or_insert((0, face));
            *entry = (entry.0 + sign, face);
        }
    }
    let plane = |node: u32| mesh.symmetry_plane_z && mesh.on_symmetry_plane(node as usize, size);
    match edges.iter().find(|(edge, (sum, _))| *sum != 0 && !edge.iter().all(|&node| plane(node))) {
        Some((&edge, &(_, face))) => Err(SetupError::OpenChamber { chamber: index, face, edge }),
        None => Ok(()),
    }
}

/// Checks that the nodes of each face belong to one element, so that the Hessian of its volume is in the sparsity
/// pattern.
pub(crate) fn on_elements(graph: &NodeGraph, chamber: usize, wall: &Chamber) -> Result<(), SetupError> {
    for face in 0..wall.faces.len() {
        let nodes = wall.faces.nodes(face);
        for (a, b) in nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| (a, b))).filter(|(a, b)| a != b) {
            if graph.neighbours_of(a).binary_search(&b).is_err() {
                return Err(SetupError::UnattachedFace { chamber, face, a, b });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::mesh::box_mesh;

    #[test]
    fn element_factors_are_positive_and_one_for_each_element_or_none() {
        let mesh = box_mesh::quadratic([0.1; 3], [1, 1, 1]);
        let count = mesh.elements.len();
        let of = |factor: f64| element_factors(&mesh, &vec![factor; count]);
        assert!(of(0.5).is_ok() && element_factors(&mesh, &[]).is_ok());
        for factor in [0.0, -1.0, 1e12, f64::NAN] {
            assert!(matches!(of(factor), Err(SetupError::ElementFactor { element: 0, .. })), "{factor}");
        }
        let short = element_factors(&mesh, &vec![1.0; count - 1]);
        assert!(matches!(short, Err(SetupError::ElementFactors { given, elements }) if given + 1 == elements));
    }
}
