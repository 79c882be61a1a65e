//! Sequences: the patches that a line along the sheet's normal crosses, and the fills between them, for each region.

use super::error::MeshError;
use super::patches::Patch;
use super::plane::Plane;
use crate::frame::{Frame, doubled_area};
use crate::stack::Fill;
use crate::{BODY, SPINE};
use si::{Metre, Point2};
use std::collections::BTreeMap;

/// Patches at one height.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Level {
    pub patches: Vec<u32>,
}

/// The levels over a region from below, and the fills between them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Sequence {
    pub levels: Vec<Level>,
    pub fills: Vec<Fill>,
}

/// The surfaces, and the tolerances with which lines are intersected with them.
pub(crate) struct Sampler<'a> {
    pub frame: Frame,
    pub patches: &'a [Patch],
    /// Chamber of each shell of each part, or nothing for an outer shell.
    pub chambers: &'a [Vec<Option<u16>>; 2],
    /// Distance below which body and spine touch, m.
    pub tolerance: Metre,
    /// A gap between body and spine above this is intended, m.
    pub least_gap: Metre,
}

const ROLES: [&str; 2] = ["body", "spine"];

impl Sampler<'_> {
    /// The sequence of every region, nothing where no solid is.
    ///
    /// Each triangle is sampled at its centroid; the sequence that covers most of the region's area is taken, because
    /// triangles at a region's rim can lie slightly beside the true outline.
    ///
    /// # Errors
    /// [`MeshError`] where a surface has an odd number of crossings, or the surfaces have a gap or an overlap.
    pub(crate) fn region_sequences(&self, plane: &Plane) -> Result<Vec<Option<Sequence>>, MeshError> {
        let mut votes: Vec<BTreeMap<Vec<Level>, (f64, usize)>> = vec![BTreeMap::new(); plane.region_count as usize];
        for (t, corners) in plane.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|v| plane.points[v as usize]);
            let levels = self.levels_at(triangle_centroid(plane, t)).into_iter().map(|l| l.1).collect();
            let (area, first) = votes[plane.regions[t] as usize].entry(levels).or_insert((0.0, t));
            let (best, own) = (plane.triangles[*first].map(|v| plane.points[v as usize]), doubled_area(a, b, c));
            *area += own;
            if own > doubled_area(best[0], best[1], best[2]) {
                *first = t;
            }
        }
        votes.iter().map(|v| self.winning_sequence(plane, v)).collect()
    }

    fn winning_sequence(
        &self,
        plane: &Plane,
        votes: &BTreeMap<Vec<Level>, (f64, usize)>,
    ) -> Result<Option<Sequence>, MeshError> {
        let best = votes.values().fold((0.0, 0), |best, v| if v.0 > best.0 { *v } else { best });
        let point = triangle_centroid(plane, best.1);
        let levels = self.levels_at(point);
        let fills = self.fills_between(point, &levels)?;
        let solid = fills.iter().any(|f| matches!(f, Fill::Region(_)));
        Ok(solid.then(|| Sequence { levels: levels.into_iter().map(|l| l.1).collect(), fills }))
    }

    /// Levels at a plan point from below, with their heights; body and spine share one where they touch.
    fn levels_at(&self, point: Point2) -> Vec<(Metre, Level)> {
        let crossings =
            self.patches.iter().enumerate().filter_map(|(i, p)| Some((p.crossing_height(point)?, i as u32)));
        let mut crossings: Vec<(Metre, u32)> = crossings.collect();
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut levels: Vec<(Metre, Level)> = Vec::new();
        for (height, patch) in crossings {
            match levels.last_mut() {
                Some((low, level)) if height - *low <= self.tolerance && self.touches_other_part(level, patch) => {
                    level.patches.push(patch);
                    level.patches.sort_unstable();
                }
                _ => levels.push((height, Level { patches: vec![patch] })),
            }
        }
        levels
    }

    /// Whether a patch is the other part's side of a level's single patch.
    fn touches_other_part(&self, level: &Level, patch: u32) -> bool {
        let (other, patch) = (&self.patches[level.patches[0] as usize], &self.patches[patch as usize]);
        level.patches.len() == 1 && other.part != patch.part && other.up != patch.up
    }

    fn fills_between(&self, point: Point2, levels: &[(Metre, Level)]) -> Result<Vec<Fill>, MeshError> {
        // number of times that each shell was entered, minus the number of times that it was left
        let mut inside = [0, 1].map(|part: usize| vec![0i32; self.chambers[part].len()]);
        let mut fills = Vec::new();
        for (i, (height, level)) in levels.iter().enumerate() {
            for &p in &level.patches {
                let patch = &self.patches[p as usize];
                inside[patch.part][patch.shell as usize] += if patch.up { -1 } else { 1 };
            }
            let Some(next) = levels.get(i + 1) else { break };
            let (body, spine) = (inside[0].iter().sum::<i32>() > 0, inside[1].iter().sum::<i32>() > 0);
            let middle = self.frame.join(point, (height + next.0) / 2.0);
            let width = next.0 - height;
            if body && spine && width > self.tolerance {
                return Err(MeshError::Overlap { at: middle, width, limit: self.tolerance });
            }
            let fill = if spine {
                Fill::Region(SPINE)
            } else if body {
                Fill::Region(BODY)
            } else {
                self.cavity_of(&inside)
            };
            if fill == Fill::Air && width < self.least_gap && self.faces_other(level, &next.1) {
                return Err(MeshError::Gap { at: middle, width, limit: self.tolerance });
            }
            fills.push(fill);
        }
        let uneven = |part: &usize| inside[*part].iter().any(|&n| n != 0);
        match (0..2).find(uneven) {
            Some(part) => {
                let height = levels.last().map_or(0.0, |l| l.0);
                Err(MeshError::OddCrossings { role: ROLES[part], at: self.frame.join(point, height) })
            }
            None => Ok(fills),
        }
    }

    fn cavity_of(&self, inside: &[Vec<i32>; 2]) -> Fill {
        let shells = inside.iter().zip(self.chambers).flat_map(|(n, c)| n.iter().zip(c));
        let chamber = shells.filter(|(n, _)| **n < 0).find_map(|(_, c)| *c);
        chamber.map_or(Fill::Air, Fill::Chamber)
    }

    fn faces_other(&self, lower: &Level, upper: &Level) -> bool {
        let part = |level: &Level| self.patches[level.patches[0] as usize].part;
        lower.patches.len() == 1 && upper.patches.len() == 1 && part(lower) != part(upper)
    }
}

pub(crate) fn triangle_centroid(plane: &Plane, triangle: usize) -> Point2 {
    let corners = plane.triangles[triangle].map(|v| plane.points[v as usize]);
    [0, 1].map(|k| corners.iter().map(|c| c[k]).sum::<f64>() / 3.0)
}
