//! The ground truth of a recording: the hidden properties of the specimen, of its surroundings and of its instruments.

use lab::truth::{self, Lens, Pose, TrueForce, TrueInflation, TrueTrial, Truth};
use mesh::wall::{Section, Walls, end_rotation};

use super::setup::Setup;
use crate::bench::Bench;
use crate::force_log;
use crate::physics::{Body, Fluid, PressureSweep};
use crate::side::Side;

/// The ground truth of a recording whose trials have these.
pub(super) fn recording_truth(setup: &Setup, bench: &Bench, (trial, force): (Vec<TrueTrial>, Vec<TrueForce>)) -> Truth {
    let Fluid { density, added, drag } = bench.fluid;
    let sides = Side::BOTH.iter().zip(bench.sweeps);
    Truth {
        cell: Some(force_log::true_cell(bench.set, bench.seed)),
        fluid: Some(truth::Fluid { density, added, drag }),
        inflation: sides.filter_map(|(side, sweep)| true_inflation(bench.body, *side, sweep)).collect(),
        trial,
        force,
        ..of_specimen(setup, bench)
    }
}

/// How the walls of the body move in a sweep; none where its mesh has no nodes at mid height.
fn true_inflation(body: &Body, side: Side, sweep: &PressureSweep) -> Option<TrueInflation> {
    let (rest, section) = (&body.mesh.nodes, Section::of(&body.mesh)?);
    let displaced_nodes = |shape: &Vec<f64>| -> Vec<si::Point3> {
        rest.iter().zip(shape.as_chunks::<3>().0).map(|(x, u)| si::vec3::add(*x, *u)).collect()
    };
    let nodes: Vec<Vec<si::Point3>> = sweep.shapes.iter().map(displaced_nodes).collect();
    let walls: Vec<Walls> = nodes.iter().map(|nodes| section.walls(nodes, side == Side::Left)).collect();
    Some(TrueInflation {
        channel: side.channel_name().to_owned(),
        pressure: sweep.pressures.clone(),
        rotation: nodes.iter().map(|nodes| end_rotation(rest, nodes)).collect(),
        bulge: walls.iter().map(|walls| walls.bulge_m).collect(),
        dent: walls.iter().map(|walls| walls.dent_m).collect(),
        dent_at: walls.iter().map(|walls| walls.dent_at[0]).collect(),
    })
}

/// The ground truth without the trials, the water and the load cell.
fn of_specimen(setup: &Setup, bench: &Bench) -> Truth {
    let (hidden, renderer) = (&setup.hidden, bench.renderer);
    let camera = &renderer.camera;
    let l = &camera.lens;
    Truth {
        origin: lab::VIRTUAL_BENCH.to_owned(),
        specimen: bench.name.to_owned(),
        seed: bench.seed,
        water_surface: Some(renderer.water.surface),
        body: hidden.body.clone(),
        spine: hidden.spine.clone(),
        casting: Some(truth::Casting {
            asymmetry: hidden.asymmetry,
            sheet_offset: hidden.sheet_offset,
            unbonded: setup.true_unbonded(),
            markers: hidden.marks.clone(),
        }),
        fluid: None,
        inflation: Vec::new(),
        lens: Lens { fx: l.fx, fy: l.fy, cx: l.cx, cy: l.cy, k1: l.k1, k2: l.k2, p1: l.p1, p2: l.p2, k3: l.k3 },
        pose: Pose { rotation: camera.pose.rotation, translation: camera.pose.translation },
        cell: None,
        trial: Vec::new(),
        force: Vec::new(),
    }
}
