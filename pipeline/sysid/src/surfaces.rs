//! Solids for figures: surfaces of a mesh by what they bound, whole or cut open at mid height.

use std::collections::{BTreeMap, BTreeSet};

use mesh::{QuadraticFace, QuadraticMesh, SPINE, Skin};
use plot::{Colour, Paint, Scene, palette};
use si::{Point2, Point3};

/// What a surface bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Bounds {
    /// The soft body against the outside.
    Body,
    /// The stiff sheet against the outside.
    Sheet,
    /// A chamber.
    Chamber(u16),
    /// Nothing: the body is cut here.
    CutBody,
    /// Nothing: the sheet is cut here.
    CutSheet,
}

/// Surfaces by what they bound: faces of three points each.
#[derive(Debug, Clone, PartialEq)]
pub struct Surfaces {
    /// m.
    pub points: Vec<Point3>,
    /// By index of their points.
    pub faces: BTreeMap<Bounds, Vec<[u32; 3]>>,
}

impl Surfaces {
    /// The lower half of a solid, cut open at mid height; `points` are its nodes, at rest or moved.
    pub fn lower_half(solid: &QuadraticMesh, points: &[Point3]) -> Self {
        let corners = |nodes: &[u32]| if nodes.len() == 20 { 8 } else { 4 };
        let below =
            |nodes: &[u32]| nodes[..corners(nodes)].iter().map(|&n| solid.nodes[n as usize][2]).sum::<f64>() < 0.0;
        let faces = boundary_faces(solid, |nodes| solid.half || below(nodes));
        // a half model is the upper half: its mirror image is the lower one
        let (points, turn) = if solid.half { (reflect_points(points), true) } else { (points.to_vec(), false) };
        Self { points, faces: split_faces(faces, turn) }
    }

    /// The whole solid.
    pub fn whole(solid: &QuadraticMesh, points: &[Point3]) -> Self {
        let boundary_faces: Vec<_> =
            boundary_faces(solid, |_| true).into_iter().filter(|(bound, _)| !bound.is_cut()).collect();
        if !solid.half {
            return Self { points: points.to_vec(), faces: split_faces(boundary_faces, false) };
        }
        let shift = points.len() as u32;
        let mut faces = split_faces(boundary_faces.clone(), false);
        for (bound, mirrored) in split_faces(boundary_faces, true) {
            faces.entry(bound).or_default().extend(mirrored.into_iter().map(|f| f.map(|i| i + shift)));
        }
        Self { points: [points.to_vec(), reflect_points(points)].concat(), faces }
    }

    /// All of a mesh's skin and cuts as it was meshed, coarse: triangles between the corners of each face.
    pub fn coarse_triangles(solid: &QuadraticMesh) -> BTreeMap<Bounds, Vec<[u32; 3]>> {
        let mut faces: BTreeMap<Bounds, Vec<[u32; 3]>> = BTreeMap::new();
        for (bound, face) in boundary_faces(solid, |_| true) {
            faces.entry(bound).or_default().extend(face.corner_triangles());
        }
        faces
    }

    /// As [`Surfaces::coarse_triangles`], with triangles between all nodes of each face.
    pub fn fine_triangles(solid: &QuadraticMesh) -> BTreeMap<Bounds, Vec<[u32; 3]>> {
        split_faces(boundary_faces(solid, |_| true), false)
    }

    /// Closed lines about the faces that bound these, in the plane (m), the largest first: edges that one triangle alone has, one after the other.
    pub fn outlines(&self, bounds: &[Bounds]) -> Vec<Vec<Point2>> {
        let faces = bounds.iter().filter_map(|bound| self.faces.get(bound)).flatten();
        let edges = faces.flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]);
        let edges: BTreeSet<(u32, u32)> = edges.collect();
        // of two triangles at an edge each has it in the other direction
        let mut next: BTreeMap<u32, u32> = edges.iter().filter(|(a, b)| !edges.contains(&(*b, *a))).copied().collect();
        let mut loops = Vec::new();
        while let Some((&begin, _)) = next.first_key_value() {
            let mut outline = Vec::new();
            let mut node = begin;
            while let Some(following) = next.remove(&node) {
                let [x, y, _] = self.points[node as usize];
                outline.push([x, y]);
                node = following;
            }
            loops.push(outline);
        }
        loops.sort_by(|a, b| enclosed_area(b).total_cmp(&enclosed_area(a)));
        loops
    }

    /// A scene with these surfaces added, each painted as `paint` returns; surfaces for which it returns none are left out.
    pub fn add_to(&self, scene: Scene, paint: impl Fn(Bounds) -> Option<Paint>) -> Scene {
        self.faces.iter().fold(scene, |scene, (bound, faces)| match paint(*bound) {
            Some(paint) => scene.with_surface(&self.points, faces, paint),
            None => scene,
        })
    }
}

impl Bounds {
    /// Whether the solid goes on beyond.
    pub fn is_cut(self) -> bool {
        matches!(self, Self::CutBody | Self::CutSheet)
    }

    /// The colour that it has in every figure.
    pub fn colour(self) -> Colour {
        match self {
            Self::Body => palette::BODY,
            Self::Sheet | Self::CutSheet => palette::SPINE,
            Self::Chamber(_) => palette::PRESSURE.towards(palette::PAPER, 0.35),
            Self::CutBody => palette::BODY.towards(palette::BLACK, 0.25),
        }
    }

    /// Covered by that colour.
    pub fn painted(self) -> Option<Paint> {
        Some(Paint::Solid(self.colour()))
    }
}

/// Area within a closed line, m².
fn enclosed_area(outline: &[Point2]) -> f64 {
    let sides = outline.iter().zip(outline.iter().cycle().skip(1));
    0.5 * sides.map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>().abs()
}

/// The boundary faces of the selected elements with what they bound.
fn boundary_faces(solid: &QuadraticMesh, wanted: impl Fn(&[u32]) -> bool) -> Vec<(Bounds, QuadraticFace)> {
    let key = |face: &QuadraticFace| {
        let mut corners = face.corners().to_vec();
        corners.sort_unstable();
        corners
    };
    let skin: BTreeMap<Vec<u32>, Skin> = solid.skin.iter().map(|f| (key(f), f.on)).collect();
    // Ordered: faces, and with them figures, come in the same order in every run.
    let mut sides: BTreeMap<Vec<u32>, (usize, u16, QuadraticFace)> = BTreeMap::new();
    for (element, region) in (0..solid.elements.len()).zip(&solid.regions) {
        if !wanted(solid.elements.nodes(element)) {
            continue;
        }
        for face in solid.elements.sides(element) {
            sides.entry(key(&face)).and_modify(|(count, ..)| *count += 1).or_insert((1, *region, face));
        }
    }
    let once = sides.into_iter().filter(|(_, (count, ..))| *count == 1);
    once.map(|(corners, (_, region, face))| (face_bounds(skin.get(&corners), region), face)).collect()
}

fn face_bounds(skin: Option<&Skin>, region: u16) -> Bounds {
    match (skin, region == SPINE) {
        (Some(Skin::Chamber(k)), _) => Bounds::Chamber(*k),
        (Some(Skin::Outer), false) => Bounds::Body,
        (Some(Skin::Outer), true) => Bounds::Sheet,
        (_, false) => Bounds::CutBody,
        (_, true) => Bounds::CutSheet,
    }
}

/// Triangles between all nodes of each face, by what they bound; turned around where the points are mirrored.
fn split_faces(boundary_faces: Vec<(Bounds, QuadraticFace)>, turn: bool) -> BTreeMap<Bounds, Vec<[u32; 3]>> {
    let mut faces: BTreeMap<Bounds, Vec<[u32; 3]>> = BTreeMap::new();
    for (bound, face) in boundary_faces {
        let turned = face.triangles().into_iter().map(|[i, j, k]| if turn { [i, k, j] } else { [i, j, k] });
        faces.entry(bound).or_default().extend(turned);
    }
    faces
}

fn reflect_points(points: &[Point3]) -> Vec<Point3> {
    points.iter().map(|&[x, y, z]| [x, y, -z]).collect()
}

#[cfg(test)]
mod tests {
    use mesh::QuadraticElements;

    use super::*;

    /// One element that stands on z = 0, as the upper half of a body.
    fn half() -> QuadraticMesh {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let edges = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];
        let middle = |[a, b]: [usize; 2]| [0, 1, 2].map(|k| 0.5 * (corners[a][k] + corners[b][k]));
        let elements = QuadraticElements::Tetrahedra(vec![std::array::from_fn(|i| i as u32)]);
        let sides = elements.sides(0);
        let skin = |f: usize, on| {
            let mut face = sides[f];
            face.on = on;
            face
        };
        QuadraticMesh {
            nodes: corners.into_iter().chain(edges.map(middle)).collect(),
            elements: elements.clone(),
            regions: vec![0],
            skin: vec![skin(0, Skin::Symmetry), skin(1, Skin::Outer), skin(2, Skin::Outer), skin(3, Skin::Chamber(1))],
            half: true,
        }
    }

    #[test]
    fn the_outline_of_a_cut_is_its_rim() {
        let solid = half();
        let lower = Surfaces::lower_half(&solid, &solid.nodes);
        let outlines = lower.outlines(&[Bounds::CutBody]);
        assert_eq!((outlines.len(), outlines[0].len()), (1, 6));
        assert!((enclosed_area(&outlines[0]) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn the_lower_half_of_a_half_model_is_its_mirror_image_with_the_cut_open() {
        let solid = half();
        let lower = Surfaces::lower_half(&solid, &solid.nodes);
        assert!(lower.points.iter().all(|p| p[2] <= 0.0));
        let count = |on| lower.faces.get(&on).map_or(0, Vec::len);
        assert_eq!((count(Bounds::CutBody), count(Bounds::Body), count(Bounds::Chamber(1))), (4, 8, 4));
    }

    #[test]
    fn the_whole_of_a_half_model_is_twice_its_skin_and_has_no_cut() {
        let solid = half();
        let whole = Surfaces::whole(&solid, &solid.nodes);
        assert_eq!(whole.points.len(), 20);
        assert!(whole.faces.keys().all(|on| !on.is_cut()));
        assert_eq!(whole.faces[&Bounds::Body].len(), 16);
    }
}
