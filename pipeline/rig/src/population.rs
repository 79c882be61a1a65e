//! A population: specimens of one design whose silicone, sheet, casting, water, valve and camera are drawn at random.
//!
//! With it the intervals of a study are held against many truths instead of three. A member is determined by the population's seed and
//! its own number, so that a population can be recorded in parts and on several machines.

use std::borrow::Cow;

use crate::random::RandomStream;
use crate::settings::{Material, Population, Settings, Specimen as Own};
use crate::specimen::{Draw, SHEET, Specimen};
use crate::specimens;

/// A specimen of a population and the settings under which it is recorded.
pub struct Member {
    /// The bench's settings with what was drawn for this member.
    pub settings: Settings,
    /// The specimen.
    pub specimen: Specimen,
}

/// Members of one population have seeds this far from those of the next.
const SEEDS: u64 = 1_000_003;

/// The member of this draw.
///
/// # Panics
/// When `[population] like` names no specimen of the bench, which a test excludes.
pub(crate) fn draw_member(bench: &Settings, draw: Draw) -> Member {
    let ranges = &bench.population;
    let design = specimens::ALL.iter().find(|s| s.name == ranges.like).expect("like names a specimen of the bench");
    let name = format!("tail_{:03}", draw.number);
    let seed = draw.seed.wrapping_mul(SEEDS).wrapping_add(draw.number as u64);
    let mut random = RandomStream::new(seed, "population");
    let mut settings = bench.clone();
    let design_settings = &bench.specimen[&ranges.like];
    let silicone = drawn_silicone(&bench.material[&design_settings.body], ranges, seed, &mut random);
    settings.material.insert(design_settings.body.clone(), silicone);
    let sheet = Material { seed, youngs_modulus: ranges.sheet_youngs_modulus, ..bench.material[SHEET].clone() };
    settings.material.insert(SHEET.to_owned(), sheet);
    (settings.fluid.added, settings.fluid.drag) = (ranges.added, ranges.drag);
    draw_instruments(&mut settings, ranges, &mut random);
    settings.buoyancy.water.insert(name.clone(), bench.buoyancy.water[&ranges.like].clone());
    // the flapping trials that are predicted; the others serve thrust, which a population does not learn
    let flaps = design_settings.flaps.iter().filter(|flap| flap.brief && flap.validate).cloned().collect();
    settings.specimen.insert(name.clone(), Own { seed, flaps, ..design_settings.clone() });
    Member { settings, specimen: Specimen { name: Cow::Owned(name), tail: design.tail, draw: Some(draw) } }
}

fn drawn_silicone(material: &Material, ranges: &Population, seed: u64, random: &mut RandomStream) -> Material {
    let (stiffer, slope) = (random.uniform(ranges.stiffening), random.uniform(ranges.branch_slope));
    Material {
        seed,
        youngs_modulus: ranges.youngs_modulus,
        stiffening: material.stiffening.map(|coefficient| stiffer * coefficient),
        branches: material
            .branches
            .iter()
            .map(|[time, strength]| [*time, strength * libm::pow(*time, slope)])
            .collect(),
        branch_factor: ranges.branch_factor,
        ..material.clone()
    }
}

/// The valve's times and the camera's pose.
fn draw_instruments(settings: &mut Settings, ranges: &Population, random: &mut RandomStream) {
    let slower = random.uniform(ranges.valve);
    let valve = &mut settings.valve;
    valve.dead_fill.iter_mut().for_each(|[_, time]| *time *= slower);
    valve.dead_exhaust *= slower;
    valve.fill *= slower;
    valve.exhaust = valve.exhaust.map(|time| slower * time);
    let camera = &mut settings.camera;
    camera.above = camera.above.map(|x| x + random.uniform([-ranges.camera_shift, ranges.camera_shift]));
    camera.tilt = camera.tilt.map(|angle| angle + random.uniform([-ranges.camera_turn, ranges.camera_turn]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::specimen::HiddenProperties;

    fn drawn(seed: u64, number: usize) -> (Member, HiddenProperties) {
        let member = draw_member(&Settings::built_in(), Draw { seed, number });
        let hidden = HiddenProperties::drawn(&member.settings, &member.settings.specimen[&*member.specimen.name]);
        (member, hidden)
    }

    #[test]
    fn a_member_is_that_of_its_seed_and_number() {
        let of = |seed, number| drawn(seed, number).1;
        assert_eq!(of(1, 3), of(1, 3));
        assert!(of(1, 3) != of(1, 4) && of(1, 3) != of(2, 3));
        assert_eq!(drawn(1, 3).0.specimen.name, "tail_003");
    }

    #[test]
    fn twenty_members_fill_the_ranges_and_stay_within_them() {
        let bench = Settings::built_in();
        let ranges = &bench.population;
        let all: Vec<_> = (1..=20).map(|number| drawn(1, number)).collect();
        let sheets: Vec<f64> = all.iter().map(|(_, hidden)| hidden.spine.youngs_modulus).collect();
        let [low, high] = ranges.sheet_youngs_modulus;
        assert!(sheets.iter().all(|e| (low..=high).contains(e)), "{sheets:?}");
        let span = sheets.iter().fold(f64::MIN, |a, b| a.max(*b)) - sheets.iter().fold(f64::MAX, |a, b| a.min(*b));
        assert!(span > 0.7 * (high - low), "{sheets:?}");
        for (member, hidden) in &all {
            // the drawn modulus holds at a time after loading, with what has not relaxed by then
            let time = member.settings.material[&bench.specimen[&ranges.like].body].modulus_time;
            let left: f64 = hidden.body.branch.iter().map(|b| b.strength * libm::exp(-time / b.time)).sum();
            let held = hidden.body.youngs_modulus * (1.0 + left);
            let [low, high] = ranges.youngs_modulus;
            assert!((low..=high).contains(&held), "{held}");
        }
    }

    #[test]
    fn a_member_has_its_own_valve_camera_branches_and_water() {
        let bench = Settings::built_in();
        let ranges = &bench.population;
        let body = &bench.specimen[&ranges.like].body;
        let mut shifts = Vec::new();
        for number in 1..=20 {
            let set = drawn(1, number).0.settings;
            let slower = set.valve.fill / bench.valve.fill;
            assert!((ranges.valve[0]..=ranges.valve[1]).contains(&slower), "{slower}");
            assert!((set.valve.dead_exhaust / bench.valve.dead_exhaust - slower).abs() < 1e-12);
            for ([_, time], [_, bench]) in set.valve.dead_fill.iter().zip(&bench.valve.dead_fill) {
                assert!((time / bench - slower).abs() < 1e-12);
            }
            assert_eq!(set.material[body].branch_factor, ranges.branch_factor);
            assert_eq!((set.fluid.added, set.fluid.drag), (ranges.added, ranges.drag));
            shifts.extend([0, 1].map(|k| (set.camera.above[k] - bench.camera.above[k]) / ranges.camera_shift));
            shifts.extend([0, 1].map(|k| (set.camera.tilt[k] - bench.camera.tilt[k]) / ranges.camera_turn));
        }
        let mean = shifts.iter().sum::<f64>() / shifts.len() as f64;
        assert!(shifts.iter().all(|s| s.abs() <= 1.0 + 1e-9) && mean.abs() < 0.25, "{shifts:?}");
        assert!(shifts.iter().any(|s| *s < -0.5) && shifts.iter().any(|s| *s > 0.5), "{shifts:?}");
    }

    #[test]
    fn members_have_the_trials_that_are_predicted_in_air_and_in_water() {
        let (member, _) = drawn(1, 1);
        let flaps = &member.settings.specimen["tail_001"].flaps;
        assert!(flaps.len() == 2 && flaps.iter().all(|flap| flap.validate));
    }
}
