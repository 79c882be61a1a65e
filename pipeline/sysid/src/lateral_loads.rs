//! Lateral loads on a body like those of its inertia and of the water around it.

use diagnostics::Result;
use fem::{Elements, Mesh, StaticSettings, System};
use si::{CubicMetre, vec3};

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
        Lateral::Water => plate_volumes(system).unwrap_or_else(|| system.node_masses().to_vec()),
    };
    for (i, (node, weight)) in system.mesh().nodes.iter().zip(&weights).enumerate() {
        // As the first mode of a cantilever grows near its clamp; nodes behind it do not move.
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
fn plate_volumes(system: &System) -> Option<Vec<CubicMetre>> {
    let mesh = system.mesh();
    let mut node_volumes = vec![0.0; mesh.nodes.len()];
    for element in (0..mesh.elements.len()).filter(|&e| mesh.regions[e] != BODY as u16) {
        let nodes = mesh.elements.nodes(element);
        // By their corners in tetrahedra: a rounding of these loads takes the ascents of actuation to another optimum,
        // and the numbers of coarse studies with them. The first four nodes of a hexahedron are one face.
        let volume = match mesh.elements {
            Elements::Linear(_) | Elements::Quadratic(_) => corner_volume(mesh, nodes),
            Elements::Hexahedra(_) | Elements::QuadraticHexahedra(_) => system.element_volumes()[element],
        };
        nodes.iter().for_each(|&node| node_volumes[node as usize] += volume / nodes.len() as f64);
    }
    node_volumes.iter().any(|volume| *volume > 0.0).then_some(node_volumes)
}

/// Volume of a tetrahedron with plane faces, m³.
fn corner_volume(mesh: &Mesh, nodes: &[u32]) -> CubicMetre {
    let [a, b, c, d] = [0, 1, 2, 3].map(|k| mesh.nodes[nodes[k] as usize]);
    vec3::dot(vec3::sub(b, a), vec3::cross(vec3::sub(c, a), vec3::sub(d, a))).abs() / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem::{Clamps, RegionProperties, box_mesh, materials};

    const SIDES: [f64; 3] = [0.06, 0.01, 0.02];

    /// A block whose middle third in y is a sheet of another region.
    fn block(mut mesh: Mesh) -> System {
        let is_sheet = |element: usize| {
            let nodes = mesh.elements.nodes(element);
            let middle = nodes.iter().map(|&node| mesh.nodes[node as usize][1]).sum::<f64>() / nodes.len() as f64;
            (middle / SIDES[1] - 0.5).abs() < 1.0 / 6.0
        };
        mesh.regions = (0..mesh.elements.len()).map(|element| u16::from(is_sheet(element))).collect();
        let law = materials::by_name("neo_hookean").expect("a law of the project");
        let clamps = Clamps::below_x(&mesh, 1e-9);
        let solid = |e: f64| RegionProperties::elastic(law, e, 0.4, 1000.0);
        System::new(mesh, vec![solid(2e5), solid(4e9)], clamps).expect("a block with a sheet")
    }

    #[test]
    fn a_sheet_has_its_volume_at_its_own_nodes_in_tetrahedra_and_in_hexahedra() {
        let place = |at: [f64; 3]| [0, 1, 2].map(|axis| SIDES[axis] * at[axis]);
        let hexahedra = box_mesh::quadratic_hexahedra([4, 3, 2], false, place, |_| Some(0));
        for mesh in [hexahedra, box_mesh::quadratic(SIDES, [4, 3, 2])] {
            let system = block(mesh);
            let volumes = plate_volumes(&system).expect("there is a sheet");
            let total: f64 = volumes.iter().sum();
            assert!((total / (SIDES.iter().product::<f64>() / 3.0) - 1.0).abs() < 1e-9, "{total:e}");
            let is_outside = |(at, volume): (&[f64; 3], &f64)| (at[1] / SIDES[1] - 0.5).abs() > 0.2 && *volume > 0.0;
            assert!(!system.mesh().nodes.iter().zip(&volumes).any(is_outside));
        }
    }
}
