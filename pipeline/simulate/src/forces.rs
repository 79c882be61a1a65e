//! Dead loads of a case as nodal forces: at points, along edges, over faces, normal to walls at rest, or from a table.

use std::collections::BTreeMap;

use diagnostics::{Diagnostic, Result};
use fem::{Clamps, Forces};
use mesh::{Skin, chamber_containing};
use si::{Point3, vec3};

use crate::case::{self, Case, Place};
use crate::force_table::{ForceTable, NodeOf};
use crate::reach::Reach;
use crate::solid::Loaded;

/// Dead forces of all loads, 3 a node, N.
///
/// # Errors
/// A [`Diagnostic`] when a load meets nothing, or held nodes alone.
pub(super) fn nodal_forces(case: &Case, loaded: &Loaded, mesh: &fem::Mesh, clamps: &Clamps) -> Result<Vec<f64>> {
    let reach = Reach { solid: &loaded.solid, size: mesh.size() };
    let clamped_axes: BTreeMap<u32, [bool; 3]> = clamps.iter().collect();
    let plane = |node: u32| mesh.symmetry_plane_z && mesh.nodes[node as usize][2] == 0.0;
    let still =
        |node: u32, axis: usize| clamped_axes.get(&node).is_some_and(|axes| axes[axis]) || (axis == 2 && plane(node));
    let mut total = vec![0.0; 3 * mesh.nodes.len()];
    for (i, load) in case.load.iter().enumerate() {
        let name = format!("load {i}");
        let list = match loaded.tables.get(&i) {
            Some(table) => of_table(&name, table, &reach, mesh)?,
            None => one_load(&name, load, &reach, mesh)?,
        };
        let moves = |(entry, force): (usize, &f64)| *force != 0.0 && !still((entry / 3) as u32, entry % 3);
        if !list.iter().enumerate().any(moves) {
            return Err(Diagnostic::new(
                format!("load {i} pushes at held nodes alone"),
                "what is held does not move, so that the load does nothing and the clamp contradicts it",
                "move the load or the clamp, or hold fewer axes",
            ));
        }
        total.iter_mut().zip(list).for_each(|(sum, force)| *sum += force);
    }
    Ok(total)
}

/// Forces of one load, 3 a node, N.
fn one_load(name: &str, load: &case::Load, reach: &Reach, mesh: &fem::Mesh) -> Result<Vec<f64>> {
    let none = Forces::none(mesh);
    let place = Place::of(load.plane, load.block);
    let forces = match (load.near, load.force, place, load.line_force, load.traction) {
        (Some(point), Some(force), ..) => none.on_node(reach.nearest_node(name, point)?, force)?,
        (.., Some(place), Some(force_per_length), _) => {
            reach.edges_in(&place).iter().try_fold(none, |sum, edge| sum.on_edge(edge, force_per_length))?
        }
        _ if load.pressure.is_some() => {
            let intensity = load.pressure.unwrap_or_default();
            pressed_faces(name, load, reach)?.iter().try_fold(none, |sum, face| {
                let normal = outward_normal(mesh, face);
                sum.on_face(face, normal.map(|n| -intensity * n))
            })?
        }
        (.., Some(place), _, Some(intensity)) => {
            reach.faces_in(&place).iter().try_fold(none, |sum, face| sum.on_face(face, intensity))?
        }
        _ => none,
    };
    match forces.as_slice().iter().any(|force| *force != 0.0) {
        true => Ok(forces.as_slice().to_vec()),
        false => Err(nothing_there(name, reach)),
    }
}

/// Forces of a table, 3 a node, N.
fn of_table(name: &str, table: &ForceTable, reach: &Reach, mesh: &fem::Mesh) -> Result<Vec<f64>> {
    let mut forces = Forces::none(mesh);
    for &(line, node, force) in table {
        let entry = format!("{name}, line {line} of its table,");
        let node = match node {
            NodeOf::Near(point) => reach.nearest_node(&entry, point)?,
            NodeOf::Number(number) if number < mesh.nodes.len() => number as u32,
            NodeOf::Number(number) => {
                let reason = format!("nodes are numbered from 0 to {}", mesh.nodes.len() - 1);
                return Err(Diagnostic::new(format!("{entry} names node {number}"), reason, "correct the number"));
            }
        };
        forces = forces.on_node(node, force)?;
    }
    Ok(forces.as_slice().to_vec())
}

/// The faces on which a dead pressure acts: of the outer skin in a place, or the walls of a chamber.
fn pressed_faces(name: &str, load: &case::Load, reach: &Reach) -> Result<Vec<Vec<u32>>> {
    if let Some(place) = Place::of(load.plane, load.block) {
        return Ok(reach.faces_in(&place));
    }
    let chamber = load.inside.and_then(|point| chamber_containing(reach.solid, point)).ok_or_else(|| {
        let reason = "the point is in no closed cavity of the mesh";
        Diagnostic::new(format!("{name} has no chamber"), reason, "give a point inside one, m in the frame of the mesh")
    })?;
    let faces = reach.solid.faces().into_iter().filter(|(_, on)| *on == Skin::Chamber(chamber));
    Ok(faces.map(|(nodes, _)| nodes.to_vec()).collect())
}

/// The unit normal of a face at rest, out of the solid.
fn outward_normal(mesh: &fem::Mesh, face: &[u32]) -> Point3 {
    let [a, b, c] = [0, 1, 2].map(|k| mesh.nodes[face[k] as usize]);
    let normal = vec3::cross(vec3::sub(b, a), vec3::sub(c, a));
    vec3::scale(normal, 1.0 / vec3::norm(normal))
}

pub(super) fn nothing_there(entry: &str, reach: &Reach) -> Diagnostic {
    let message =
        format!("{entry} meets nothing: no face or edge of the outer skin lies in its place with all its corners");
    Diagnostic::new(message, reach.extent_text(), "move it onto the body's surface, or widen its box")
}
