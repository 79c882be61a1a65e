//! Walls of a simulated tail: dent and bulge of a shape, and the pressure at which a slack wall buckles.

use si::{MILLIBAR, Metre, Pascal, Point3, vec3};

use mesh::wall::{Section, Walls, buckling_pressure};
use records::Mesh;
use sysid::{PressureLevel, SimulatedLevel};

/// Measures the walls of the shapes of one mesh.
pub(super) struct WallGauge<'a> {
    mesh: &'a Mesh,
    section: Option<Section>,
}

/// Pressures nearer to each other than this are one level.
const ALIKE: Pascal = MILLIBAR;

impl<'a> WallGauge<'a> {
    pub fn new(mesh: &'a Mesh) -> Self {
        Self { mesh, section: Section::of(&mesh.solid) }
    }

    /// Walls of the mesh with its nodes at `nodes` (m) under `pressures` (Pa, one a chamber); zero where it has no section at mid height.
    pub(crate) fn walls_of_shape(&self, pressures: &[Pascal], nodes: &[Point3]) -> Walls {
        self.section.as_ref().map_or(Walls::default(), |s| s.walls(nodes, self.lies_left(fullest_chamber(pressures))))
    }

    /// What measures the simulated levels of a search.
    pub(super) fn of_levels(self) -> sysid::WallGauge<'a> {
        Box::new(move |levels, simulated| self.critical_pressure(levels, simulated))
    }

    /// The pressure at which the slack wall buckles, Pa: the mean over the filled chambers. None where one of them leaves it unbuckled.
    fn critical_pressure(&self, levels: &[PressureLevel], simulated: &[SimulatedLevel]) -> Option<Pascal> {
        let mut sides: Vec<(usize, Vec<(Pascal, Metre)>)> = Vec::new();
        for (level, shape) in levels.iter().zip(simulated) {
            let (chamber, point) = (fullest_chamber(&level.pressures), (level.top(), self.wall_dent(level, shape)));
            match sides.iter_mut().find(|(known, _)| *known == chamber) {
                Some((_, points)) => points.push(point),
                None => sides.push((chamber, vec![(0.0, 0.0), point])),
            }
        }
        let buckling_pressures: Option<Vec<Pascal>> = sides.into_iter().map(|(_, points)| buckles_at(points)).collect();
        buckling_pressures
            .filter(|pressures| !pressures.is_empty())
            .map(|pressures| pressures.iter().sum::<Pascal>() / pressures.len() as f64)
    }

    fn wall_dent(&self, level: &PressureLevel, shape: &SimulatedLevel) -> Metre {
        let displacement = shape.displacement.as_chunks::<3>().0;
        let nodes: Vec<Point3> =
            self.mesh.solid.nodes.iter().zip(displacement).map(|(&x, &u)| vec3::add(x, u)).collect();
        self.walls_of_shape(&level.pressures, &nodes).dent_m
    }

    /// Whether a chamber lies at positive y.
    fn lies_left(&self, chamber: usize) -> bool {
        let (solid, cavity) = (&self.mesh.solid, self.mesh.chambers[chamber].skin);
        let faces_of_chamber = solid.skin.iter().filter(|f| f.on == mesh::Skin::Chamber(cavity));
        faces_of_chamber.map(|f| solid.nodes[f.nodes()[0] as usize][1]).sum::<f64>() > 0.0
    }
}

/// The chamber of the highest pressure.
fn fullest_chamber(pressures: &[Pascal]) -> usize {
    (0..pressures.len()).max_by(|a, b| pressures[*a].total_cmp(&pressures[*b])).unwrap_or(0)
}

/// The pressure at which a wall buckles whose dents are known at some pressures, in any order.
fn buckles_at(mut points: Vec<(Pascal, Metre)>) -> Option<Pascal> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.dedup_by(|next, kept| next.0 < kept.0 + ALIKE);
    let (pressures, dents): (Vec<Pascal>, Vec<Metre>) = points.into_iter().unzip();
    buckling_pressure(&pressures, &dents)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_in_any_order_and_twice_give_the_pressure_of_the_steepest_dent() {
        let dent = |p: f64| 3e-3 * (1.0 + ((p - 18e3) / 2e3).tanh());
        let levels = [25e3, 5e3, 20e3, 10e3, 15e3, 20e3 + 1.0, 17.5e3];
        let found = buckles_at(levels.iter().map(|&p| (p, dent(p))).chain([(0.0, 0.0)]).collect());
        assert!(found.is_some_and(|p| (p - 18e3).abs() < 1e3), "{found:?}");
        assert_eq!(buckles_at(levels.iter().map(|&p| (p, 1e-8 * p)).collect()), None);
    }

    #[test]
    fn the_chamber_of_the_highest_pressure_is_the_filled_one() {
        assert_eq!((fullest_chamber(&[0.0, 2e4, 1e4]), fullest_chamber(&[])), (1, 0));
    }
}
