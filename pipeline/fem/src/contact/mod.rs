//! Frictionless self-contact of the walls of chambers by a repulsive potential [kamensky2018].
//!
//! W(u) = Σ w_i w_j k ψ(|x_i − x_j|) over pairs of points on two walls, each with its area w at rest; ψ rises without limit as two points
//! meet and vanishes beyond the range. A sum over points is smooth where a closest point would jump from one face to the next, so that
//! first and second derivative are exact, and the tangent stays symmetric. Two flat walls with a gap g press on each other with
//! p(g) = 2π k g ψ(g): the walls meet at about half the range.
//!
//! Faces that are closer than twice the range at rest, neighbours above all, do not repel each other. The walls of a half model also meet
//! their mirror images.
//!
//! Points that repel each other share no element. Their nodes are coupled in the tangent, whose sparsity is extended when walls come
//! close ([`crate::system_data::SystemData::with_couplings`]).

mod boxes;
mod face_pair;
mod hull;
mod law;
mod surface;
#[cfg(test)]
mod tests;

use crate::loads::Load;
use crate::mesh::Mesh;
use boxes::{Box3, ClosePair, close_pairs};
use face_pair::{Blocks, FacePair};
use hull::Hulls;
use law::RepulsiveLaw;
use nalgebra::{Matrix3, Vector3};
use si::{Joule, Metre, Pascal};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use surface::{Samples, Surface};

/// How walls in contact repel each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Distance beyond which two points do not repel each other, m; less than the thinnest wall.
    pub range: Metre,
    /// Pressure between two flat walls at half the range, Pa.
    pub pressure: Pascal,
}

/// Samples along an edge are closer than this fraction of the range.
const SPACING: f64 = 0.6;
/// Faces closer than this multiple of the range at rest do not repel each other.
const APART: f64 = 2.0;
/// Fraction of the distance between two walls by which one step may bring them closer.
const APPROACH: f64 = 0.8;
/// Walls farther apart than this multiple of the range are not expected to meet within one step.
const REACH: f64 = 10.0;

/// The walls of the chambers of one mesh, and the law by which they repel each other.
#[derive(Debug, Clone)]
pub(crate) struct SelfContact {
    law: RepulsiveLaw,
    surface: Surface,
    /// Pairs that are too close at rest.
    excluded: BTreeSet<ClosePair>,
    /// Whether walls meet their mirror images.
    half: bool,
}

impl SelfContact {
    /// Between all chamber walls of `mesh`.
    pub(crate) fn new(mesh: &Mesh, contact: Contact) -> Self {
        let surface = Surface::new(mesh, SPACING * contact.range);
        Self::between(surface, RepulsiveLaw::new(contact.range, contact.pressure), mesh.symmetry_plane_z)
    }

    /// Between the faces of `surface` that are apart at rest.
    fn between(surface: Surface, law: RepulsiveLaw, half: bool) -> Self {
        let mut new = Self { law, surface, excluded: BTreeSet::new(), half };
        let at_rest = new.surface.hulls(&new.surface.undisplaced(), false);
        new.excluded = new.close_face_pairs(&at_rest, APART * law.range).into_iter().collect();
        new
    }

    /// The same between some of its faces alone, and their nodes, of which alone it knows displacements.
    pub(crate) fn between_faces(&self, faces: &BTreeSet<u32>) -> (Self, Vec<u32>) {
        let (surface, nodes) = self.surface.with_faces(faces);
        (Self::between(surface, self.law, self.half), nodes)
    }

    /// The faces that are within `reach` of one that they may meet, at `u`.
    pub(crate) fn faces_within(&self, u: &[f64], reach: Metre) -> BTreeSet<u32> {
        let pairs = self.near_face_pairs(u, reach);
        pairs.iter().flat_map(|pair| pair.faces().map(|(face, _)| face)).collect()
    }

    /// Pairs of faces whose boxes are closer than `reach` and that repel each other.
    fn close_face_pairs(&self, hulls: &Hulls, reach: Metre) -> Vec<ClosePair> {
        let boxes: Vec<Box3> = hulls[0].iter().map(|hull| Box3::around(hull)).collect();
        let mut pairs = close_pairs(&boxes, reach, self.half);
        pairs.retain(|pair| !self.excluded.contains(pair));
        pairs
    }

    /// Those whose hulls are closer than `reach` at `u`.
    fn near_face_pairs(&self, u: &[f64], reach: Metre) -> Vec<ClosePair> {
        let hulls = self.surface.hulls(u, self.half);
        let mut pairs = self.close_face_pairs(&hulls, reach);
        pairs.retain(|pair| hull::hull_gap(hull::of_pair(&hulls, pair)) < reach);
        pairs
    }

    /// The range of the law, m.
    pub(crate) fn range(&self) -> Metre {
        self.law.range
    }

    /// Calls `visit` with the faces that may be within `reach` of each other at `u`.
    fn for_each_face_pair(&self, u: &[f64], reach: Metre, mut visit: impl FnMut(&FacePair)) {
        let _ = self.visit_face_pairs(u, reach, |faces| {
            visit(faces);
            ControlFlow::Continue(())
        });
    }

    /// The same until `visit` breaks off.
    fn visit_face_pairs(
        &self,
        u: &[f64],
        reach: Metre,
        mut visit: impl FnMut(&FacePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut samples: BTreeMap<(u32, bool), Samples> = BTreeMap::new();
        for pair in self.near_face_pairs(u, reach) {
            let faces = pair.faces();
            for (face, mirrored) in faces {
                samples.entry((face, mirrored)).or_insert_with(|| self.surface.samples(face, u, mirrored));
            }
            visit(&FacePair { pair, samples: faces.map(|face| &samples[&face]) })?;
        }
        ControlFlow::Continue(())
    }

    /// `strength` W(u), J; adds its gradient (3 entries per node, N) to `gradient`.
    pub(crate) fn add_energy(&self, u: &[f64], strength: f64, gradient: &mut [f64]) -> Joule {
        let mut total = 0.0;
        self.for_each_face_pair(u, self.law.range, |faces| {
            // most faces whose hulls are near each other have no samples that are: they get no forces
            let mut forces: Option<[Vec<Vector3<f64>>; 2]> = None;
            let area = strength * self.sample_area_product(faces);
            faces.for_each_point_pair(self.law.range, |i, j, apart, distance| {
                total += area * self.law.value(distance);
                let force = apart * (area * self.law.slope(distance) / distance);
                let unloaded = || faces.samples.map(|samples| vec![Vector3::zeros(); samples.positions.len()]);
                let [first, second] = forces.get_or_insert_with(unloaded);
                first[i] += force;
                second[j] -= force;
            });
            for ((face, mirrored), forces) in faces.pair.faces().into_iter().zip(forces.iter().flatten()) {
                self.surface.add_forces(face, mirrored, forces, gradient);
            }
        });
        total
    }

    /// Whether walls are within the range of each other at `u`.
    pub(crate) fn touch(&self, u: &[f64]) -> bool {
        self.visit_face_pairs(u, self.law.range, |faces| faces.first_contact(self.law.range)).is_break()
    }

    /// Product of the areas of two samples, m⁴.
    fn sample_area_product(&self, faces: &FacePair) -> f64 {
        faces.pair.faces().map(|(face, _)| self.surface.sample_area(face)).into_iter().product()
    }

    /// Calls `add` with the blocks of `strength` ∂²W/∂u²: of its convex part alone where that is asked for. Faces whose nodes are not
    /// `coupled` in the tangent get twice their own convex blocks and none between them, which is more than the second derivative in every
    /// direction.
    pub(crate) fn add_stiffness(
        &self,
        u: &[f64],
        (strength, convex): (f64, bool),
        coupled: &dyn Fn(u32, u32) -> bool,
        add: &mut dyn FnMut(u32, u32, &Matrix3<f64>),
    ) {
        self.for_each_face_pair(u, self.law.range, |faces| {
            if faces.first_contact(self.law.range).is_continue() {
                return;
            }
            let nodes = faces.pair.faces().map(|(face, _)| self.surface.nodes(face));
            let is_coupled = nodes[0].iter().all(|a| nodes[1].iter().all(|b| coupled(*a, *b)));
            // (x − y)² ≤ 2x² + 2y²: twice the own blocks bound what those between would take away, and the direction
            // stays one of descent.
            let scale = if is_coupled { strength } else { 2.0 * strength } * self.sample_area_product(faces);
            let blocks = Blocks::of_faces(faces, &self.surface, &self.law, (scale, convex || !is_coupled));
            for (side, nodes) in nodes.iter().enumerate() {
                for (a, &node) in nodes.iter().enumerate() {
                    nodes[..=a].iter().enumerate().for_each(|(b, &other)| add(node, other, &blocks.own[side][a][b]));
                }
            }
            for (a, &node) in nodes[0].iter().enumerate().filter(|_| is_coupled) {
                for (b, &other) in nodes[1].iter().enumerate() {
                    let block = blocks.between[a][b];
                    // a wall that meets its own mirror image
                    let block = if node == other { block + block.transpose() } else { block };
                    add(node, other, &block);
                }
            }
        });
    }

    /// Pairs of nodes that the tangent couples at `u`, with a `margin` (m) for what walls will move.
    pub(crate) fn couplings(&self, u: &[f64], margin: Metre) -> BTreeSet<(u32, u32)> {
        let (mut node_pairs, reach) = (BTreeSet::new(), self.law.range + margin);
        self.for_each_face_pair(u, reach, |faces| {
            let [first, second] = faces.pair.faces().map(|(face, _)| self.surface.nodes(face));
            let each = first.iter().flat_map(|&a| second.iter().map(move |&b| (a.min(b), a.max(b))));
            let is_near = faces.first_contact(reach).is_break();
            node_pairs.extend(each.filter(|(a, b)| is_near && a != b));
        });
        node_pairs
    }

    /// The largest part of `step` (3 entries per node, m) from `u`, at most 1, by which no wall passes through another.
    pub(crate) fn admissible_part(&self, u: &[f64], step: &[f64]) -> f64 {
        let mut part: f64 = 1.0;
        let end: Vec<f64> = u.iter().zip(step).map(|(u, step)| u + step).collect();
        let largest = step.iter().fold(0.0, |greatest: f64, entry| greatest.max(entry.abs()));
        // Two nodes approach each other by at most 2√3 = 3.5 times the largest entry of a step.
        let reach = (4.0 * largest).min(REACH * self.law.range);
        let hulls = [u, &end].map(|u| self.surface.hulls(u, self.half));
        for pair in self.close_face_pairs(&hulls[0], reach) {
            let hulls = [0, 1].map(|time: usize| hull::of_pair(&hulls[time], &pair));
            if !hull::stay_apart(hulls) {
                // points farther apart than this allow the part that others have left
                let reach = part * hull::relative_motion(hulls) / APPROACH;
                if hull::hull_gap(hulls[0]) < reach {
                    part = part.min(self.admissible_part_of_points(&pair, [u, &end], reach));
                }
            }
        }
        part
    }

    /// The same for two faces that no plane keeps apart: by which no sample comes too close to another within `reach`.
    fn admissible_part_of_points(&self, pair: &ClosePair, [u, moved]: [&[f64]; 2], reach: Metre) -> f64 {
        let samples = |at| pair.faces().map(|(face, mirrored)| self.surface.samples(face, at, mirrored));
        let (now, next) = (samples(u), samples(moved));
        let mut part: f64 = 1.0;
        let faces = FacePair { pair: *pair, samples: [&now[0], &now[1]] };
        faces.for_each_point_pair(reach, |i, j, apart, distance| {
            let change = next[0].positions[i] - next[1].positions[j] - apart;
            let approach = -change.dot(&apart) / distance;
            if approach > 0.0 {
                part = part.min(APPROACH * distance / approach);
            }
        });
        part
    }
}

impl Load for SelfContact {
    fn potential(&self, u: &[f64]) -> f64 {
        self.add_energy(u, 1.0, &mut vec![0.0; u.len()])
    }

    fn add_gradient(&self, u: &[f64], strength: f64, gradient: &mut [f64]) {
        self.add_energy(u, strength, gradient);
    }

    fn add_hessian(&self, u: &[f64], strength: f64, add: &mut dyn FnMut(u32, u32, &Matrix3<f64>)) {
        self.add_stiffness(u, (strength, false), &|_, _| true, add);
    }
}
