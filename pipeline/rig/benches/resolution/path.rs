//! The path of a tail under rising pressure on one side: what is measured on it, and what it costs.

use fem::{Equilibrium, Faces, StaticSettings, System};
use si::{MILLIBAR, Metre, Pascal};

/// Pressures at which angles are compared, mbar.
pub const LEVELS: [f64; 3] = [100.0, 160.0, 225.0];
/// The end of the path, mbar.
const END: f64 = 230.0;
/// Steps along the path, mbar: the longest, and the shortest before it ends.
const LONGEST: f64 = 20.0;
const SHORTEST: f64 = 0.5;

/// Measurements on a path.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// Rotation of the end at each of [`LEVELS`], °; NaN where the path has ended.
    pub angles: [f64; 3],
    /// Growth of a chamber's depth at 160 mbar, m: the largest.
    pub bulge: Metre,
    /// Pressure at which a slack chamber is 1 mm less deep, Pa.
    pub dent: Pascal,
    /// Where the path ends, Pa.
    pub end: Pascal,
    /// In the mean.
    pub factorisations_per_level: f64,
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [a, b, c] = self.angles;
        let dent = self.dent / MILLIBAR;
        write!(
            f,
            "{:>6.1}  {a:.2} {b:.2} {c:.2}; bulge {:.2} mm, a dent of 1 mm at {dent:.1} mbar, to {:.0} mbar",
            self.factorisations_per_level,
            1e3 * self.bulge,
            self.end / MILLIBAR
        )
    }
}

/// Follows the path with guesses extrapolated from its last two states; a step that fails is halved.
pub fn follow(system: &System) -> Outcome {
    let settings = StaticSettings { tolerance: 1e-6, max_iterations: 16, ..StaticSettings::default() };
    let (walls, mut solver) = (Walls::of(system), system.solver());
    let mut path: Vec<(f64, Equilibrium)> = vec![(0.0, Equilibrium::default())];
    path[0].1.displacement = vec![0.0; 3 * system.mesh().nodes.len()];
    let (mut outcome, mut step, mut spent, mut levels) =
        (Outcome { angles: [f64::NAN; 3], ..Outcome::default() }, 10.0, 0, 0);
    while let Some(&(reached, _)) = path.last().filter(|(at, _)| *at < END) {
        let stop = LEVELS.iter().copied().find(|level| *level > reached + 1e-9).unwrap_or(END);
        let target = if reached + 1.2 * step > stop { stop } else { reached + step };
        let pressures = walls.pressures(target * MILLIBAR);
        let guess = extrapolated(&path, target);
        let nearby = &path[path.len() - 1].1.displacement;
        match solver.equilibrium_near(&pressures, nearby, &guess, &settings) {
            Ok(found) => {
                spent += found.factorisations;
                levels += 1;
                step = if found.factorisations <= 5 { (1.5 * step).min(LONGEST) } else { step };
                walls.measure(&mut outcome, (reached, target), [nearby, &found.displacement]);
                path.push((target, found));
                path.drain(..path.len().saturating_sub(2));
            }
            Err(_) if step > SHORTEST => {
                spent += settings.max_iterations;
                step *= 0.5;
            }
            Err(_) => break,
        }
    }
    outcome.end = path[path.len() - 1].0 * MILLIBAR;
    outcome.factorisations_per_level = f64::from(spent as u32) / f64::from(levels.max(1));
    outcome
}

fn extrapolated(path: &[(f64, Equilibrium)], target: f64) -> Vec<f64> {
    let [(before, from), (at, to)] = path else { return path[0].1.displacement.clone() };
    let part = (target - at) / (at - before);
    from.displacement.iter().zip(&to.displacement).map(|(from, to)| to + part * (to - from)).collect()
}

/// Nodes of a tail that are measured.
struct Walls {
    /// Of each chamber, whether it is filled.
    filled: Vec<bool>,
    /// Two nodes of the end, from y < 0 to y > 0, m apart.
    end: [usize; 2],
    /// Pairs of nodes at mid height, on the sheet's side and on the wall's side of each chamber, and whether it is filled.
    depths: Vec<([usize; 2], bool)>,
    rest: Vec<[Metre; 3]>,
}

impl Walls {
    fn of(system: &System) -> Self {
        let mesh = system.mesh();
        let nodes = &mesh.nodes;
        let far = mesh.bounds().1[0];
        let end: Vec<usize> = (0..nodes.len()).filter(|&n| nodes[n][0] > far - 1e-9 && nodes[n][2] < 1e-9).collect();
        let by_y = |a: &&usize, b: &&usize| nodes[**a][1].total_cmp(&nodes[**b][1]);
        let ends = [end.iter().min_by(by_y), end.iter().max_by(by_y)].map(|node| *node.expect("the end has nodes"));
        let (mut filled, mut depths) = (Vec::new(), Vec::new());
        for chamber in &mesh.chambers {
            let wall = wall_nodes(&chamber.faces);
            let is_filled = wall.iter().map(|&n| nodes[n][1]).sum::<f64>() > 0.0;
            filled.push(is_filled);
            let mid: Vec<usize> = wall.into_iter().filter(|&n| nodes[n][2] < 1e-9).collect();
            for &node in &mid {
                let beside = mid.iter().filter(|&&other| (nodes[other][0] - nodes[node][0]).abs() < 1e-9);
                let away = |n: &&usize| nodes[**n][1].abs();
                let far = beside.clone().max_by(|a, b| away(a).total_cmp(&away(b))).copied();
                let near = beside.min_by(|a, b| away(a).total_cmp(&away(b))).copied();
                depths.extend(
                    near.zip(far).filter(|pair| pair.0 == node && pair.1 != node).map(|(a, b)| ([a, b], is_filled)),
                );
            }
        }
        Self { filled, end: ends, depths, rest: nodes.clone() }
    }

    fn pressures(&self, pressure: Pascal) -> Vec<Pascal> {
        self.filled.iter().map(|filled| if *filled { pressure } else { 0.0 }).collect()
    }

    fn apart(&self, [from, to]: [usize; 2], u: &[f64]) -> [Metre; 3] {
        std::array::from_fn(|axis| self.rest[to][axis] + u[3 * to + axis] - self.rest[from][axis] - u[3 * from + axis])
    }

    /// The largest growth of filled chambers' depths, and the largest loss of slack ones, m.
    fn growths(&self, u: &[f64]) -> [Metre; 2] {
        let (mut bulge, mut dent) = (0.0f64, 0.0f64);
        for (pair, filled) in &self.depths {
            let length = |u: &[f64]| si::vec3::norm(self.apart(*pair, u));
            let growth = length(u) - length(&vec![0.0; u.len()]);
            if *filled { bulge = bulge.max(growth) } else { dent = dent.max(-growth) }
        }
        [bulge, dent]
    }

    /// Enters what is measured between two levels (mbar).
    fn measure(&self, outcome: &mut Outcome, (from, to): (f64, f64), [before, now]: [&Vec<f64>; 2]) {
        if let Some(level) = LEVELS.iter().position(|level| (level - to).abs() < 1e-9) {
            let along = self.apart(self.end, now);
            outcome.angles[level] = along[0].atan2(along[1]).to_degrees().abs();
        }
        let [bulge, dent] = self.growths(now);
        if (to - LEVELS[1]).abs() < 1e-9 {
            outcome.bulge = bulge;
        }
        let previous_dent = self.growths(before)[1];
        if outcome.dent == 0.0 && dent >= 1e-3 {
            outcome.dent = (from + (to - from) * (1e-3 - previous_dent) / (dent - previous_dent)) * MILLIBAR;
        }
    }
}

/// Nodes of a chamber's wall, each once.
fn wall_nodes(faces: &Faces) -> Vec<usize> {
    let mut own: Vec<usize> = (0..faces.len()).flat_map(|face| faces.nodes(face).iter().map(|&n| n as usize)).collect();
    own.sort_unstable();
    own.dedup();
    own
}
