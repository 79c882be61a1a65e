//! Sheets: patches of body and spine that touch become one height field.

use super::patches::Patch;
use super::plane::Plane;
use super::sequence::{Sequence, triangle_centroid};
use crate::frame::doubled_area;
use crate::stack::{Column, Fill};
use crate::surface::connected_components;
use si::{Metre, Point2, Point3};

/// The sheets and fills over one region of the plan.
#[derive(Debug, Clone)]
pub(crate) struct Layers {
    /// Sheets from below.
    pub sheets: Vec<u32>,
    /// What is between them, one fewer.
    pub fills: Vec<Fill>,
}

impl Layers {
    /// Whether a chamber is among them.
    pub(crate) fn is_hollow(&self) -> bool {
        self.fills.iter().any(|fill| matches!(fill, Fill::Chamber(_)))
    }
}

/// All sheets of a stack.
pub(crate) struct Sheets<'a> {
    patches: &'a [Patch],
    /// Sheet of each patch.
    of_patch: Vec<u32>,
    /// Patches of each sheet, those of the spine first: the sheet's faces are plane, so its heights are exact.
    members: Vec<Vec<u32>>,
}

impl<'a> Sheets<'a> {
    /// Patches that touch over some region are one sheet.
    pub fn new(patches: &'a [Patch], regions: &[Option<Sequence>]) -> Self {
        let levels = regions.iter().flatten().flat_map(|s| &s.levels);
        let links = levels.filter(|l| l.patches.len() == 2).map(|l| [l.patches[0], l.patches[1]]);
        let (of_patch, count) = connected_components(patches.len(), links);
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); count as usize];
        (0..patches.len()).for_each(|p| members[of_patch[p] as usize].push(p as u32));
        members.iter_mut().for_each(|m| m.sort_by_key(|&p| (1 - patches[p as usize].part, p)));
        Self { patches, of_patch, members }
    }

    pub fn count(&self) -> usize {
        self.members.len()
    }

    /// A point on a sheet, for messages, m.
    pub fn place_of(&self, sheet: u32) -> Point3 {
        self.patches[self.members[sheet as usize][0] as usize].place
    }

    /// Height of a sheet, from its patch nearest in the plan, m.
    pub(crate) fn sheet_height(&self, point: Point2, sheet: u32) -> Metre {
        let heights = self.members[sheet as usize].iter().map(|&p| self.patches[p as usize].height_and_distance(point));
        heights.fold((0.0, f64::INFINITY), |best, h| if h.1 < best.1 { h } else { best }).0
    }

    /// The sheets of a sequence and the fills between them.
    pub(crate) fn layers_of(&self, sequence: &Sequence) -> Layers {
        let sheets = sequence.levels.iter().map(|l| self.of_patch[l.patches[0] as usize]).collect();
        Layers { sheets, fills: sequence.fills.clone() }
    }

    /// The columns over all triangles whose region holds a solid.
    pub(crate) fn solid_columns(&self, plane: &Plane, regions: &[Option<Sequence>]) -> Vec<Column> {
        let column = |(corners, region): (&[u32; 3], &u32)| {
            let Layers { sheets, fills } = self.layers_of(regions[*region as usize].as_ref()?);
            Some(Column { corners: *corners, sheets, fills })
        };
        plane.triangles.iter().zip(&plane.regions).filter_map(column).collect()
    }

    /// Centroids of triangles over which a sheet deviates from its linear interpolation by more than `limit` (m);
    /// triangles smaller than an equilateral one with edges of `least` (m) are not refined.
    pub(crate) fn curved_triangles(
        &self,
        plane: &Plane,
        regions: &[Option<Sequence>],
        limit: Metre,
        least: Metre,
    ) -> Vec<Point2> {
        let bent = |t: &usize| {
            let corners = plane.triangles[*t].map(|v| plane.points[v as usize]);
            let large = doubled_area(corners[0], corners[1], corners[2]) > 0.87 * least * least;
            let sequence = regions[plane.regions[*t] as usize].as_ref().filter(|_| large);
            let sheets = sequence.iter().flat_map(|s| &s.levels).map(|l| self.of_patch[l.patches[0] as usize]);
            sheets.into_iter().any(|sheet| {
                let flat = corners.iter().map(|&c| self.sheet_height(c, sheet)).sum::<f64>() / 3.0;
                (self.sheet_height(triangle_centroid(plane, *t), sheet) - flat).abs() > limit
            })
        };
        (0..plane.triangles.len()).filter(bent).map(|t| triangle_centroid(plane, t)).collect()
    }
}
