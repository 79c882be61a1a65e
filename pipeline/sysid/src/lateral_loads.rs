//! Lateral loads on a body like those of its inertia and of the water around it.

use diagnostics::Result;
use fem::StaticSettings;
use si::vec3;

use crate::model::{BODY, Elastic, Model};

/// A lateral load, growing with the square of the distance from the clamp.
// Without the load of water the fin is rigid: a release in water was 3 ms late at first, and drag came out 9.5 % too high in the mean of twelve tails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lateral {
    /// On every node by its mass, as inertia acts.
    Inertia,
    /// On the plate that the body encloses by its area, as water acts, which bends a fin that is light but deep; on every node where there is
    /// none.
    Water,
}

/// Lateral forces (3 a node, N/m) scaled to a unit displacement of the farthest node by the stiffness at rest.
///
/// # Errors
/// A [`Diagnostic`](diagnostics::Diagnostic) when the body at rest has no equilibrium.
pub(crate) fn unit_lateral_load(model: &Model, elastic: &Elastic, load: Lateral) -> Result<Vec<f64>> {
    let system = &model.system;
    let far = system.mesh().nodes.iter().map(|n| n[0]).fold(f64::MIN, f64::max);
    let mut forces = vec![0.0; 3 * system.mesh().nodes.len()];
    let weights = match load {
        Lateral::Inertia => system.node_masses().to_vec(),
        Lateral::Water => plate_volumes(system.mesh()).unwrap_or_else(|| system.node_masses().to_vec()),
    };
    for (i, (node, weight)) in system.mesh().nodes.iter().zip(&weights).enumerate() {
        forces[3 * i + 1] = weight * (node[0].max(0.0) / far).powi(2);
    }
    let mut solver = model.solver(elastic)?;
    let ambient = vec![0.0; system.mesh().chambers.len()];
    let undeformed = solver.equilibrium(&ambient, None, &StaticSettings::default())?;
    solver.assemble(&undeformed)?;
    solver.factorise(&undeformed)?;
    let displacement = solver.solve(&forces)?;
    let largest = displacement.iter().skip(1).step_by(3).fold(0.0, |largest: f64, y| largest.max(y.abs()));
    forces.iter_mut().for_each(|f| *f /= largest);
    Ok(forces)
}

/// Of the solids beside the body, the volume around each node, m³: of a plate of one thickness the area, but for a factor; none of a body alone.
fn plate_volumes(mesh: &fem::Mesh) -> Option<Vec<f64>> {
    let mut node_volumes = vec![0.0; mesh.nodes.len()];
    for element in (0..mesh.elements.len()).filter(|&e| mesh.regions[e] != BODY as u16) {
        let nodes = mesh.elements.nodes(element);
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| mesh.nodes[nodes[k] as usize]);
        let volume = vec3::dot(vec3::sub(b, a), vec3::cross(vec3::sub(c, a), vec3::sub(d, a))).abs() / 6.0;
        nodes.iter().for_each(|&node| node_volumes[node as usize] += volume / nodes.len() as f64);
    }
    node_volumes.iter().any(|volume| *volume > 0.0).then_some(node_volumes)
}
