//! Solids: the boundaries of body and sheet, as a CAD program would export them.

use super::plan::Plan;
use super::{Resolution, Tail, TailError, layers};
use mesh::{BODY, FACES, SPINE, Surface, TetMesh};
use si::Metre;

/// Body and spine from two different divisions of the same plan.
pub(crate) fn tail_solids(tail: &Tail, fineness: Metre) -> Result<(Surface, Surface), TailError> {
    let part = |edge: Metre, region: u16| {
        let resolution = Resolution::even(tail, edge);
        let plan = mirrored_plan(Plan::new(tail, &resolution));
        // nodes between the sheets are not needed for a surface
        layers::fill_plan(tail, &plan, f64::INFINITY, false).map(|mesh| region_boundary(&mesh, region))
    };
    Ok((part(fineness, BODY)?, part(1.2 * fineness, SPINE)?))
}

/// A plan and its mirror image in z, which share the vertices on z = 0.
fn mirrored_plan(upper: Plan) -> Plan {
    let mut points = upper.points.clone();
    let mut image = Vec::with_capacity(points.len());
    for (v, &[z, x]) in upper.points.iter().enumerate() {
        image.push(if z == 0.0 { v as u32 } else { points.len() as u32 });
        if z != 0.0 {
            points.push([-z, x]);
        }
    }
    let lower = upper.triangles.iter().map(|t| t.map(|v| image[v as usize]));
    let lower: Vec<_> = lower.map(|[a, b, c]| [a, c, b]).collect();
    Plan { points, triangles: upper.triangles.into_iter().chain(lower).collect() }
}

/// The faces that bound one region, normals outwards, points numbered anew.
fn region_boundary(mesh: &TetMesh, region: u16) -> Surface {
    let mut sides = Vec::new();
    for (t, tet) in mesh.tets.iter().enumerate().filter(|(t, _)| mesh.regions[*t] == region) {
        for face in FACES {
            let nodes = face.map(|i| tet[i]);
            let mut key = nodes;
            key.sort_unstable();
            sides.push((key, t, nodes));
        }
    }
    sides.sort_unstable();
    let alone = sides.chunk_by(|a, b| a.0 == b.0).filter(|pair| pair.len() == 1);
    let mut faces: Vec<_> = alone.map(|pair| (pair[0].1, pair[0].2)).collect();
    faces.sort_unstable();
    let mut number = vec![u32::MAX; mesh.nodes.len()];
    let mut surface = Surface::default();
    for (_, nodes) in faces {
        for n in nodes {
            if number[n as usize] == u32::MAX {
                number[n as usize] = surface.points.len() as u32;
                surface.points.push(mesh.nodes[n as usize]);
            }
        }
        surface.faces.push(nodes.map(|n| number[n as usize]));
    }
    surface
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_body_has_two_cavities_and_the_sheet_has_none() {
        let (body, spine) = Tail::nine_chambers().solids(2e-3).unwrap();
        let volumes: Vec<f64> = body.shells().unwrap().0.iter().map(|s| s.volume).collect();
        assert_eq!(volumes.iter().filter(|v| **v < 0.0).count(), 2, "{volumes:?}");
        assert_eq!(volumes.len(), 3);
        assert_eq!(spine.shells().unwrap().0.len(), 1);
    }

    #[test]
    fn the_solids_have_the_volumes_of_the_tails_own_mesh() {
        let tail = Tail::nine_chambers();
        let (body, spine) = tail.solids(1.5e-3).unwrap();
        let mesh = tail.mesh(&Resolution::even(&tail, 2e-3)).unwrap();
        assert!((2.0 * mesh.region_volume(BODY) / body.volume() - 1.0).abs() < 0.01);
        assert!((2.0 * mesh.region_volume(SPINE) / spine.volume() - 1.0).abs() < 0.01);
    }
}
