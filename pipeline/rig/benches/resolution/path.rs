//! The path of a tail under rising pressure on one side: what is measured on it, and what it costs.

use std::time::{Duration, Instant};

use fem::{Faces, StaticSettings, System};
use si::{MILLIBAR, Metre, Pascal};

/// Pressures at which angles are compared, mbar.
pub const COMPARED: [f64; 3] = [100.0, 160.0, 225.0];
/// The levels of a staircase, mbar: closer where the wall dents, from 130 mbar on.
// With 20 to 25 mbar between all of them the graded hexahedra took 11 factorisations in the mean, and 85 for the step from 200 to 225 mbar.
const LEVELS: [f64; 14] =
    [25.0, 50.0, 75.0, 100.0, 115.0, 130.0, 145.0, 160.0, 175.0, 190.0, 205.0, 215.0, 225.0, 230.0];
/// Levels beyond, which show that the path goes on and are not counted, mbar.
const BEYOND: [f64; 3] = [250.0, 275.0, 300.0];
/// The last step of Newton's method, relative to the body: as the bench of recordings has it.
const TOLERANCE: f64 = 1e-6;

/// Measurements on a path.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Rotation of the end at each of [`COMPARED`], °; NaN where the path has ended.
    pub angles: [f64; 3],
    /// Growth of a chamber's depth at 160 mbar, m: the largest.
    pub bulge: Metre,
    /// Pressure at which a slack chamber is 1 mm less deep, Pa.
    pub dent: Pascal,
    /// Where the path ends, Pa.
    pub end: Pascal,
    /// Factorisations of each equilibrium, those of abandoned steps included.
    pub factorisations: Vec<usize>,
    /// Of the equilibria of the staircase.
    pub duration: Duration,
}

impl Outcome {
    pub fn factorisations_per_equilibrium(&self) -> f64 {
        self.factorisations.iter().sum::<usize>() as f64 / self.factorisations.len().max(1) as f64
    }

    pub fn seconds_per_equilibrium(&self) -> f64 {
        self.duration.as_secs_f64() / self.factorisations.len().max(1) as f64
    }
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [a, b, c] = self.angles;
        write!(
            f,
            "{:>5.1} ({:>2} at worst)  {a:.2} {b:.2} {c:.2}; bulge {:.2} mm, a dent of 1 mm at {:.1} mbar, to {:.0} mbar, {:.1} s each",
            self.factorisations_per_equilibrium(),
            self.factorisations.iter().max().unwrap_or(&0),
            1e3 * self.bulge,
            self.dent / MILLIBAR,
            self.end / MILLIBAR,
            self.seconds_per_equilibrium()
        )
    }
}

/// The equilibria at [`LEVELS`] and [`BEYOND`], as far as they are found, by the steps of the library with at most `max_iterations` each.
pub fn follow(system: &System, max_iterations: usize) -> Outcome {
    let settings = StaticSettings { load_steps: 1, tolerance: TOLERANCE, max_iterations, ..StaticSettings::default() };
    let (walls, mut solver) = (Walls::of(system), system.solver());
    let mut outcome = Outcome {
        angles: [f64::NAN; 3],
        bulge: 0.0,
        dent: 0.0,
        end: 0.0,
        factorisations: Vec::new(),
        duration: Duration::ZERO,
    };
    let mut shapes: Vec<(Pascal, Vec<Metre>)> = vec![(0.0, vec![0.0; 3 * system.mesh().nodes.len()])];
    let start = Instant::now();
    for level in LEVELS.into_iter().chain(BEYOND) {
        let pressures = walls.pressures(level * MILLIBAR);
        let equilibria: Vec<(Pascal, &[Metre])> = shapes.iter().map(|(sum, shape)| (*sum, shape.as_slice())).collect();
        let Ok(found) = solver.equilibrium_from(&equilibria, &pressures, &settings) else { break };
        let previous_level = outcome.end / MILLIBAR;
        walls.measure(&mut outcome, (previous_level, level), [&shapes[shapes.len() - 1].1, &found.displacement]);
        if level <= LEVELS[LEVELS.len() - 1] {
            outcome.factorisations.push(found.factorisations);
            outcome.duration = start.elapsed();
        }
        outcome.end = level * MILLIBAR;
        shapes.push((pressures.iter().sum(), found.displacement));
    }
    outcome
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
        let (mut filled, mut depths) = (Vec::new(), Vec::new());
        for chamber in &mesh.chambers {
            let wall = wall_nodes(&chamber.faces);
            let is_filled = wall.iter().map(|&n| nodes[n][1]).sum::<f64>() > 0.0;
            filled.push(is_filled);
            let mid: Vec<usize> = wall.into_iter().filter(|&n| nodes[n][2] < 1e-9).collect();
            depths.extend(depth_pairs(nodes, &mid).into_iter().map(|pair| (pair, is_filled)));
        }
        Self { filled, end: end_nodes(nodes), depths, rest: nodes.clone() }
    }

    fn pressures(&self, pressure: Pascal) -> Vec<Pascal> {
        self.filled.iter().map(|filled| if *filled { pressure } else { 0.0 }).collect()
    }

    fn apart(&self, [from, to]: [usize; 2], u: &[f64]) -> [Metre; 3] {
        std::array::from_fn(|axis| self.rest[to][axis] + u[3 * to + axis] - self.rest[from][axis] - u[3 * from + axis])
    }

    /// The largest growth of filled chambers' depths, and the largest loss of slack ones, m.
    fn growths(&self, u: &[f64]) -> [Metre; 2] {
        let (mut bulge, mut dent, rest) = (0.0f64, 0.0f64, vec![0.0; u.len()]);
        for (pair, filled) in &self.depths {
            let growth = si::vec3::norm(self.apart(*pair, u)) - si::vec3::norm(self.apart(*pair, &rest));
            if *filled { bulge = bulge.max(growth) } else { dent = dent.max(-growth) }
        }
        [bulge, dent]
    }

    /// Enters what is measured between two levels (mbar).
    fn measure(&self, outcome: &mut Outcome, (from, to): (f64, f64), [before, now]: [&Vec<f64>; 2]) {
        if let Some(level) = COMPARED.iter().position(|level| (level - to).abs() < 1e-9) {
            let end_vector = self.apart(self.end, now);
            outcome.angles[level] = end_vector[0].atan2(end_vector[1]).to_degrees().abs();
        }
        let [bulge, dent] = self.growths(now);
        if (to - COMPARED[1]).abs() < 1e-9 {
            outcome.bulge = bulge;
        }
        let previous_dent = self.growths(before)[1];
        if outcome.dent == 0.0 && dent >= 1e-3 {
            outcome.dent = (from + (to - from) * (1e-3 - previous_dent) / (dent - previous_dent)) * MILLIBAR;
        }
    }
}

/// Two nodes of the end at mid height, from y < 0 to y > 0.
// The fin's end, where there is one, is thinner than the body and turns with it.
fn end_nodes(nodes: &[[Metre; 3]]) -> [usize; 2] {
    let end_x = nodes.iter().fold(0.0, |most: f64, node| most.max(node[0]));
    let at_end: Vec<usize> = (0..nodes.len()).filter(|&n| nodes[n][0] > end_x - 1e-9 && nodes[n][2] < 1e-9).collect();
    let by_y = |a: &&usize, b: &&usize| nodes[**a][1].total_cmp(&nodes[**b][1]);
    [at_end.iter().min_by(by_y), at_end.iter().max_by(by_y)].map(|node| *node.expect("the end has nodes"))
}

/// Pairs of nodes of a chamber's wall at mid height that face each other across its depth.
fn depth_pairs(nodes: &[[Metre; 3]], mid: &[usize]) -> Vec<[usize; 2]> {
    let distance_from_sheet = |n: &&usize| nodes[**n][1].abs();
    let by_distance = |a: &&usize, b: &&usize| distance_from_sheet(a).total_cmp(&distance_from_sheet(b));
    let mut pairs = Vec::new();
    for &node in mid {
        let opposite = mid.iter().filter(|&&other| (nodes[other][0] - nodes[node][0]).abs() < 1e-9);
        let outer = opposite.clone().max_by(by_distance).copied();
        let inner = opposite.min_by(by_distance).copied();
        pairs.extend(
            inner.zip(outer).filter(|pair| pair.0 == node && pair.1 != node).map(|(inner, outer)| [inner, outer]),
        );
    }
    pairs
}

/// Nodes of a chamber's wall, each once.
fn wall_nodes(faces: &Faces) -> Vec<usize> {
    let mut nodes: Vec<usize> =
        (0..faces.len()).flat_map(|face| faces.nodes(face).iter().map(|&n| n as usize)).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
