//! Clamps of a case: which nodes they hold, along which axes, and where they move them.

use std::collections::BTreeMap;

use fem::{Clamps, Solver};
use si::{Metre, Newton, Pascal, Point3};

use crate::case::{Axis, Case, Clamp, Place};
use crate::reach::Reach;
use crate::solid::Loaded;
use diagnostics::{Diagnostic, Result};

/// The clamps of a case on its mesh.
#[derive(Debug, Clone, Default)]
pub struct HeldNodes {
    /// Held nodes and axes.
    pub(crate) clamps: Clamps,
    /// Their displacements at level 1, 3 a node, m; empty where none moves.
    pub(crate) prescribed: Vec<Metre>,
    /// Clamps whose force on the body is written.
    pub(crate) grips: Vec<Grip>,
}

/// A clamp with a name.
#[derive(Debug, Clone)]
pub struct Grip {
    /// The prefix of its columns.
    pub(crate) name: String,
    nodes: Vec<u32>,
    axes: [bool; 3],
}

impl HeldNodes {
    /// # Errors
    /// A [`Diagnostic`] when a clamp holds no node, or two hold one at different places.
    pub(crate) fn of_case(case: &Case, loaded: &Loaded, reach: &Reach) -> Result<Self> {
        let (mut held, mut displacements) = (Self::default(), BTreeMap::new());
        for (number, clamp) in case.clamp.iter().enumerate() {
            let nodes = clamped_nodes(number, clamp, loaded, reach)?;
            let axes = [Axis::X, Axis::Y, Axis::Z].map(|axis| clamp.hold.contains(&axis));
            for &node in &nodes {
                held.clamps.constrain(node, axes);
                for axis in (0..3).filter(|&axis| axes[axis]) {
                    let displacement = clamp.displacement[axis];
                    let former = displacements.insert(3 * node as usize + axis, displacement);
                    if let Some(former) = former.filter(|former| *former != displacement) {
                        return Err(contradiction(
                            number,
                            (node, loaded.solid.nodes()[node as usize]),
                            [former, displacement],
                        ));
                    }
                }
            }
            held.grips.extend(clamp.name.clone().map(|name| Grip { name, nodes, axes }));
        }
        if displacements.values().any(|displacement| *displacement != 0.0) {
            held.prescribed = vec![0.0; 3 * loaded.solid.nodes().len()];
            displacements.into_iter().for_each(|(dof, displacement)| held.prescribed[dof] = displacement);
        }
        Ok(held)
    }
}

impl Grip {
    /// The force of the clamp on the body at `displacement` (3 a node, m), of the whole body where a `half` is simulated, N; 0 along axes that it
    /// does not hold. A node that two clamps hold counts in both.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a list is not of the solver's system.
    pub(crate) fn force(
        &self,
        solver: &Solver,
        (displacement, pressures): (&[Metre], &[Pascal]),
        half: bool,
    ) -> Result<[Newton; 3]> {
        let residual = solver.residual(displacement, pressures)?;
        let sum = |axis: usize| self.nodes.iter().map(|&node| residual[3 * node as usize + axis]).sum::<Newton>();
        // the other half pulls alike in the plane of symmetry, and the other way across it
        let halves = if half { [2.0, 2.0, 0.0] } else { [1.0; 3] };
        Ok([0, 1, 2].map(|axis| if self.axes[axis] { halves[axis] * sum(axis) } else { 0.0 }))
    }
}

fn clamped_nodes(number: usize, clamp: &Clamp, loaded: &Loaded, reach: &Reach) -> Result<Vec<u32>> {
    let (nodes, place) = match (&clamp.surface, Place::of(clamp.plane, clamp.block)) {
        (Some(surface), _) => (reach.on_surface(&loaded.surfaces, surface)?, format!("the surface `{surface}`")),
        (None, Some(place)) => (reach.nodes_in(&place), place.to_string()),
        (None, None) => return Ok(Vec::new()),
    };
    if nodes.is_empty() {
        let message = format!("clamp {number} holds no node: none lies on {place}");
        return Err(Diagnostic::new(message, reach.extent_text(), "move the clamp onto the body"));
    }
    Ok(nodes)
}

fn contradiction(number: usize, (node, at): (u32, Point3), [before, displacement]: [Metre; 2]) -> Diagnostic {
    Diagnostic::new(
        format!(
            "clamp {number} moves node {node} at {at:.4?} m by {displacement:e} m, and a clamp before it by {before:e} m"
        ),
        "a node has one displacement along each axis",
        "give clamps that share nodes the same displacement, or let one hold other axes",
    )
}
