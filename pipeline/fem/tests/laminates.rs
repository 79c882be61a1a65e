//! Beams of two materials against the theory of laminates, up to a sheet a hundred thousand times as stiff.
//!
//! A narrow beam under a force at its tip: plane sections about the neutral axis of all layers together, and the shear
//! that the flow q = V/(EI) ∫ E z dA stores, w = F L³ / 3EI + F L / κGA.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Clamps, Equilibrium, Forces, Mesh, RegionProperties, SolveError, Solver, StaticSettings, System, box_mesh,
    materials,
};

const LENGTH: f64 = 0.08;
const WIDTH: f64 = 0.003;
const E: f64 = 2e5;
const NU: f64 = 0.3;
const RATIOS: [f64; 6] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5];

/// Layers from below: thickness (m), rows of elements, and whether it is the stiff one.
type Layers = &'static [(f64, usize, bool)];

const IN_THE_MIDDLE: Layers = &[(0.002, 2, false), (0.0005, 1, true), (0.002, 2, false)];
const OFF_THE_MIDDLE: Layers = &[(0.0005, 1, false), (0.0005, 1, true), (0.003, 2, false)];
const CASES: [Layers; 2] = [IN_THE_MIDDLE, OFF_THE_MIDDLE];

/// Heights of the boundaries between rows of elements, m, and which rows are stiff.
fn rows(layers: Layers) -> (Vec<f64>, Vec<bool>) {
    let (mut heights, mut stiff) = (vec![0.0], Vec::new());
    for &(thickness, count, is_stiff) in layers {
        for _ in 0..count {
            heights.push(heights[heights.len() - 1] + thickness / count as f64);
            stiff.push(is_stiff);
        }
    }
    (heights, stiff)
}

/// 1/EI, 1/(N m²), and 1/κGA, 1/N, of a section.
fn compliance(layers: Layers, ratio: f64) -> (f64, f64) {
    let (heights, stiff) = rows(layers);
    let each: Vec<(f64, f64, f64)> =
        (0..stiff.len()).map(|row| (heights[row], heights[row + 1], if stiff[row] { ratio * E } else { E })).collect();
    let whole: f64 = each.iter().map(|(low, high, e)| e * (high - low)).sum();
    let neutral = each.iter().map(|(low, high, e)| e * (high * high - low * low) / 2.0).sum::<f64>() / whole;
    let bending: f64 =
        each.iter().map(|(low, high, e)| e * ((high - neutral).powi(3) - (low - neutral).powi(3)) / 3.0).sum();
    let bending = WIDTH * bending;
    // ½ F²/κGA = ½ ∫ q²/G dA; fine steps through the thickness
    let (mut flow, mut stored) = (0.0, 0.0);
    for (low, high, e) in each {
        let step = (high - low) / 400.0;
        for n in 0..400 {
            let z = low + (f64::from(n) + 0.5) * step - neutral;
            let middle = flow + 0.5 * e * z * step;
            flow += e * z * step;
            stored += middle * middle * WIDTH * step / (e / (2.0 * (1.0 + NU)));
        }
    }
    (1.0 / bending, stored / (bending * bending))
}

/// The beam with its end free to contract and curl, as the theory has it.
fn beam(layers: Layers) -> (Mesh, Clamps) {
    let (heights, stiff) = rows(layers);
    let count = stiff.len();
    let place = |at: [f64; 3]| [LENGTH * at[0], WIDTH * at[1], heights[(count as f64 * at[2]).round() as usize]];
    let mesh = box_mesh::grid([40, 2, count], false, place, |cell| Some(u16::from(stiff[cell[2]])));
    let mesh = box_mesh::to_quadratic(&mesh);
    let middle = middle(layers);
    let end = |at: [f64; 3]| at[0] < 1e-9;
    let in_line = |at: [f64; 3]| end(at) && (at[1] - 0.5 * WIDTH).abs() < 1e-9;
    let clamps = Clamps::where_nodes(&mesh, [true, false, false], end)
        .and(&Clamps::where_nodes(&mesh, [false, true, false], in_line))
        .and(&Clamps::where_nodes(&mesh, [false, false, true], |at| in_line(at) && (at[2] - middle).abs() < 1e-9));
    (mesh, clamps)
}

/// Height of the middle of the stiff layer, m.
fn middle(layers: Layers) -> f64 {
    let (heights, stiff) = rows(layers);
    let row = stiff.iter().position(|stiff| *stiff).unwrap();
    0.5 * (heights[row] + heights[row + 1])
}

/// A force (N) on the end, on each layer in proportion to its modulus, so that nothing is dented.
fn pushed(mesh: &Mesh, layers: Layers, ratio: f64, force: f64) -> Vec<f64> {
    let modulus = |stiff: bool| if stiff { ratio } else { 1.0 };
    let whole: f64 = layers.iter().map(|&(thickness, _, stiff)| WIDTH * thickness * modulus(stiff)).sum();
    let at_tip = |node: &u32| (mesh.nodes[*node as usize][0] - LENGTH).abs() < 1e-9;
    let mut forces = Forces::none(mesh);
    for element in 0..mesh.elements.len() {
        let nodes = mesh.elements.nodes(element);
        let traction = force * modulus(mesh.regions[element] == 1) / whole;
        for side in [[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [0, 2, 3, 6, 9, 7], [1, 2, 3, 5, 9, 8]] {
            let face = side.map(|n| nodes[n]);
            if face.iter().all(at_tip) {
                forces = forces.on_face(&face, [0.0, 0.0, traction]).unwrap();
            }
        }
    }
    forces.as_slice().to_vec()
}

/// The beam, ready to be pushed by a force at its end (N); the node at the tip of its stiff layer.
fn ready(layers: Layers, ratio: f64) -> (Solver, impl Fn(&mut Solver, f64), usize) {
    let (mesh, clamps) = beam(layers);
    let unit = pushed(&mesh, layers, ratio, 1.0);
    let tip = [LENGTH, 0.5 * WIDTH, middle(layers)];
    let tip = mesh.nodes.iter().position(|at| (0..3).all(|axis| (at[axis] - tip[axis]).abs() < 1e-9)).unwrap();
    let material = materials::by_name("neo_hookean").unwrap();
    let soft = RegionProperties::elastic(material, E, NU, 1070.0);
    let stiff = RegionProperties { youngs_modulus: ratio * E, ..soft.clone() };
    let solver = System::new(mesh, vec![soft, stiff], clamps).unwrap().solver();
    let push = move |solver: &mut Solver, force: f64| {
        let forces: Vec<f64> = unit.iter().map(|f| force * f).collect();
        solver.set_forces(&forces).unwrap();
    };
    (solver, push, tip)
}

/// The force under which the theory's deflection is `part` of the length, N.
fn force(layers: Layers, ratio: f64, part: f64) -> f64 {
    let (bending, shear) = compliance(layers, ratio);
    part * LENGTH / (LENGTH.powi(3) * bending / 3.0 + LENGTH * shear)
}

/// The tip's deflection over the theory's, when the theory's is `part` of the length, and the shape.
fn bend(layers: Layers, ratio: f64, part: f64) -> (f64, Equilibrium) {
    let (mut solver, push, tip) = ready(layers, ratio);
    push(&mut solver, force(layers, ratio, part));
    let settings = StaticSettings { load_steps: 1, ..Default::default() };
    let found = solver.equilibrium(&[], None, &settings).unwrap();
    (found.displacement[3 * tip + 2] / (part * LENGTH), found)
}

#[test]
fn laminate_beams_agree_with_theory_at_any_ratio_of_their_moduli() {
    for (layers, ratio) in CASES.iter().flat_map(|layers| RATIOS.map(|ratio| (layers, ratio))) {
        // a hundredth of the length: the curve's own shortening is a ten-thousandth
        let (tip, found) = bend(layers, ratio, 0.01);
        assert!((tip - 1.0).abs() < 0.005, "ratio {ratio:e}: {tip}");
        assert!(found.iterations <= 10, "ratio {ratio:e}: {} iterations", found.iterations);
    }
}

#[test]
fn a_large_deflection_takes_fifteen_iterations_at_most_at_any_ratio_of_the_moduli() {
    for (layers, ratio) in CASES.iter().flat_map(|layers| RATIOS.map(|ratio| (layers, ratio))) {
        let (tip, found) = bend(layers, ratio, 0.3);
        assert!(tip > 0.9 && tip < 0.95, "ratio {ratio:e}: {tip}");
        assert!(found.iterations <= 15, "ratio {ratio:e}: {} iterations", found.iterations);
    }
}

#[test]
fn a_prediction_from_three_shapes_saves_iterations() {
    let (layers, ratio) = (CASES[0], 1e4);
    let (mut solver, push, _) = ready(layers, ratio);
    let settings = StaticSettings::default();
    let at = |part: f64, solver: &mut Solver| {
        push(solver, force(layers, ratio, part));
        solver.equilibrium(&[], None, &settings).unwrap()
    };
    let [first, second, third, rested] = [0.24, 0.26, 0.28, 0.3].map(|part| at(part, &mut solver).displacement);
    let parabola = |i: usize| 3.0 * (third[i] - second[i]) + first[i];
    let predicted: Vec<f64> = (0..rested.len()).map(parabola).collect();
    let extrapolated = solver.equilibrium_near(&[], &third, &predicted, &settings).unwrap();
    let largest = |of: &mut dyn Iterator<Item = f64>| of.fold(0.0, |most: f64, x| most.max(x.abs()));
    let off = largest(&mut rested.iter().zip(&extrapolated.displacement).map(|(a, b)| a - b));
    assert!(off < 1e-6 * largest(&mut rested.iter().copied()), "off by {off} m");
    assert_eq!(extrapolated.factorisations, 1, "the stress of the nearby shape is that of the equilibrium");
    let near = solver.equilibrium(&[], Some(&third), &settings).unwrap();
    assert!(
        extrapolated.iterations < near.iterations,
        "{} iterations, not {}",
        extrapolated.iterations,
        near.iterations
    );
}

#[test]
fn a_useless_prediction_is_refused_at_once() {
    let (layers, ratio) = (CASES[0], 1e4);
    let (mut solver, push, _) = ready(layers, ratio);
    push(&mut solver, force(layers, ratio, 0.1));
    let settings = StaticSettings::default();
    let rested = solver.equilibrium(&[], None, &settings).unwrap();
    let inside_out: Vec<f64> = rested.displacement.iter().map(|u| -40.0 * u).collect();
    let refused = solver.equilibrium_near(&[], &rested.displacement, &inside_out, &settings).unwrap_err();
    assert!(matches!(refused, SolveError::NoEquilibrium { .. }), "{refused}");
    assert!(solver.equilibrium_near(&[], &rested.displacement, &[0.0; 3], &settings).is_err(), "too short");
}

#[test]
fn a_shape_bent_the_other_way_leads_to_the_equilibrium() {
    let (layers, ratio) = (CASES[0], 1e4);
    let (mut solver, push, _) = ready(layers, ratio);
    let settings = StaticSettings::default();
    let mut at = |part: f64, guess: Option<&[f64]>| {
        push(&mut solver, force(layers, ratio, part));
        solver.equilibrium(&[], guess, &settings).unwrap()
    };
    let (bent, back) = (at(0.3, None), at(-0.3, None));
    let found = at(-0.3, Some(&bent.displacement));
    let off = back.displacement.iter().zip(&found.displacement).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(!found.load_stepped && off < 1e-6, "off by {off} m");
}
