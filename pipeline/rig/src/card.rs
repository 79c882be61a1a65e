//! The card that the bench writes: the public data of a specimen, without its hidden properties.

use crate::side::Side;
use lab::card::{self, Card, Experiment, Fixture, FixtureOf, Medium, Origin, Role, Split, Trial};
use si::{Metre, Pascal, Point2, Point3};
use tail_cad::Tail;

use crate::calibration::Calibration;
use crate::settings::{self, Profile, RepeatSplit, Settings};
use crate::specimen::SHEET;

/// The STL files.
pub(crate) const BODY_FILE: &str = "cad/body.stl";
/// The STL files.
pub(crate) const SPINE_FILE: &str = "cad/spine.stl";
/// The calibration film.
pub(crate) const CALIBRATION_FILE: &str = "camera/calibration.mp4";
/// Radius of the disc in which the lamp is read, relative to the lamp: the lamp's blurred edge stays outside.
const LAMP_FRACTION: f64 = 0.8;
/// Clicked pixels are rounded to a tenth, the resolution of a manual click in an enlarged picture.
const CLICK: f64 = 10.0;

/// The pixels of the marks and of the lamp at rest.
pub(crate) struct RestObservation {
    /// Each mark in the first frame, px.
    pub marks: Vec<Point2>,
    /// The lamp's centre and its radius, px.
    pub lamp: (Point2, f64),
}

/// Nominal places of the marks: on the back, above the sheet, m.
pub fn nominal_marks(tail: &Tail, set: &settings::Specimen) -> Vec<(String, Point3)> {
    let mark = |(i, x): (usize, &Metre)| (format!("m{}", i + 1), tail.back_point(*x));
    set.markers.iter().enumerate().map(mark).collect()
}

/// Actual places of the marks, displaced by `offset` along and across, m.
pub(crate) fn painted_marks(tail: &Tail, set: &settings::Specimen, offset: &[Point2]) -> Vec<(String, Point3)> {
    let shifted = |((name, nominal), offset): ((String, Point3), &Point2)| {
        let [x, y, z] = tail.back_point(nominal[0] + offset[0]);
        (name, [x, y + offset[1], z])
    };
    nominal_marks(tail, set).into_iter().zip(offset).map(shifted).collect()
}

/// Use of a trial in the study.
#[derive(Clone, Copy)]
struct Purpose {
    role: Role,
    split: Option<Split>,
}

/// The trials of a specimen: staircases on both sides in air for the identification, one in water for the static force, and flapping
/// trials, each repeated.
pub(crate) fn planned_trials(set: &settings::Specimen, profile: &Profile) -> Vec<Trial> {
    let stairs = |side: Side, levels: &[Pascal]| Experiment::Staircase {
        channels: vec![side.channel_name().to_owned()],
        levels: levels.to_vec(),
        hold: profile.hold,
        pause: profile.pause,
    };
    let identify = Purpose { role: Role::Identify, split: None };
    let mut trials = vec![
        trial_with_files("static_left".to_owned(), identify, Medium::Air, stairs(Side::Left, &set.levels)),
        trial_with_files("static_right".to_owned(), identify, Medium::Air, stairs(Side::Right, &set.levels)),
    ];
    let wet = stairs(Side::Left, &set.levels_in_water);
    let thrust = Purpose { role: Role::Thrust, split: None };
    trials.push(trial_with_files("static_left_water".to_owned(), thrust, Medium::Water, wet));
    for flap in set.flaps.iter().filter(|flap| flap.brief || !profile.brief) {
        trials.extend((1..=profile.repeats).map(|repeat| flapping_trial(flap, profile, repeat)));
    }
    trials
}

fn flapping_trial(flap: &settings::FlappingTrial, profile: &Profile, repeat: usize) -> Trial {
    let (pressure, medium) = (flap.pressure / si::MILLIBAR, flap.medium.word());
    let id = format!("{pressure:.0}mbar_{:.0}hz_{medium}_{repeat:02}", flap.frequency);
    let experiment = Experiment::Flapping {
        channels: crate::side::channel_names().to_vec(),
        amplitude: flap.pressure,
        frequency: flap.frequency,
        cycles: profile.cycles,
    };
    let split = flap.split.map(|splits| match splits {
        RepeatSplit::Test => Split::Test,
        RepeatSplit::Last if repeat == profile.repeats => Split::Test,
        RepeatSplit::Train | RepeatSplit::Last => Split::Train,
    });
    let role = if flap.validate { Role::Validate } else { Role::Thrust };
    trial_with_files(id, Purpose { role, split }, flap.medium, experiment)
}

/// The recordings of the load cell's fixture alone: hammer taps, and the waves after a run.
pub(crate) fn fixture_recordings(set: &Settings) -> Vec<Fixture> {
    let file = |id: &str, log: &str| format!("trials/{id}/{log}.csv");
    let fixture = |id: &str, medium, of| Fixture { id: id.to_owned(), medium, force: file(id, "force"), of };
    let taps = FixtureOf::Taps { hammer: file("taps", "hammer"), count: Some(set.hammer.taps) };
    vec![fixture("taps", Medium::Air, taps), fixture("still_water", Medium::Water, FixtureOf::StillWater)]
}

/// Every trial but a staircase in air has a force log.
fn trial_with_files(id: String, purpose: Purpose, medium: Medium, experiment: Experiment) -> Trial {
    let Purpose { role, split } = purpose;
    let (video, pressure) = (format!("trials/{id}/video.mp4"), format!("trials/{id}/pressure.csv"));
    let has_force = medium == Medium::Water || matches!(experiment, Experiment::Flapping { .. });
    let force = has_force.then(|| format!("trials/{id}/force.csv"));
    Trial { id, role, split, medium, video: Some(video), pressure, force, first_frame: 0, last_frame: None, experiment }
}

/// What a card is written from.
pub(crate) struct CardContent<'a> {
    /// The specimen's name.
    pub(crate) name: &'a str,
    /// The settings of the bench.
    pub(crate) set: &'a Settings,
    /// The nominal shape.
    pub(crate) tail: &'a Tail,
    /// Its trials.
    pub(crate) trials: &'a [Trial],
}

/// The whole card.
pub(crate) fn write_card(content: &CardContent, observed: &RestObservation, film: &Calibration) -> Card {
    let CardContent { name, set, tail, trials } = *content;
    let specimen = &set.specimen[name];
    Card {
        name: name.to_owned(),
        origin: Origin::VirtualBench,
        length: specimen.length,
        solid: card_solids(set, specimen),
        clamp: card::Clamp::below(specimen.clamp),
        chamber: vec![first_chamber(tail, Side::Left), first_chamber(tail, Side::Right)],
        marker: card_markers(tail, specimen, &observed.marks),
        camera: Some(card_camera(set, film)),
        water: Some(card::Water { surface: set.water.surface, index: set.water.index }),
        led: Some(card::Led {
            centre: observed.lamp.0.map(rounded_pixel),
            radius: rounded_pixel(LAMP_FRACTION * observed.lamp.1),
        }),
        trial: trials.to_vec(),
        search: None,
        tracks: Vec::new(),
        fixture: fixture_recordings(set),
        log: card::Log::default(),
        tank: Some(card::Tank { length: set.tank.length, depth: set.tank.depth }),
    }
}

fn rounded_pixel(pixel: f64) -> f64 {
    (CLICK * pixel).round() / CLICK
}

fn card_solids(settings: &Settings, set: &settings::Specimen) -> card::Solids {
    let solid = |file: &str, material: &settings::Material| card::Solid {
        file: Some(file.to_owned()),
        region: None,
        material: material.nominal.law.clone(),
        youngs_modulus: material.nominal.youngs_modulus,
        poissons_ratio: material.nominal.poissons_ratio,
        stiffening: material.nominal.stiffening,
        stiffening_sigma: material.nominal.stiffening_sigma,
        density: material.density,
        plausible: material.nominal.plausible,
    };
    let part = |name: &str, solid| card::Part { name: name.to_owned(), solid };
    let body = part(card::BODY, solid(BODY_FILE, &settings.material[&set.body]));
    let spine = part(card::SPINE, solid(SPINE_FILE, &settings.material[SHEET]));
    card::Solids::new(card::LengthUnit::Mm, None, vec![body, spine])
}

/// The middle of the first chamber of a side.
fn first_chamber(tail: &Tail, side: Side) -> card::Chamber {
    let [from, to] = tail.chamber(0);
    let x = 0.5 * (from + to);
    let (wall, sign) = match side {
        Side::Left => (tail.wall[1], 1.0),
        Side::Right => (tail.wall[0], -1.0),
    };
    let y = 0.5 * (tail.inner_face() + tail.half_width(x, 0.0) - wall);
    let micrometre = |x: Metre| (x * 1e6).round() / 1e6;
    card::Chamber {
        name: side.channel_name().to_owned(),
        at: [micrometre(x), sign * micrometre(y), 0.0],
        channel: side.channel_name().to_owned(),
    }
}

fn card_markers(tail: &Tail, set: &settings::Specimen, observed: &[Point2]) -> Vec<card::Marker> {
    let micrometre = |x: Metre| (x * 1e6).round() / 1e6;
    let marker = |((name, position), clicked): ((String, Point3), &Point2)| card::Marker {
        name,
        at: position.map(micrometre),
        clicked: Some(clicked.map(rounded_pixel)),
        diameter: Some(set.marker_diameter),
    };
    nominal_marks(tail, set).into_iter().zip(observed).map(marker).collect()
}

fn card_camera(set: &Settings, film: &Calibration) -> card::Camera {
    let plane = &set.plane;
    card::Camera {
        calibration: CALIBRATION_FILE.to_owned(),
        frame_every: film.every,
        lens: card::LensKind::BrownConrady,
        coefficients: None,
        readout: set.camera.readout,
        board: card::Board {
            kind: card::BoardKind::Checkerboard,
            marker: None,
            dictionary: None,
            columns: plane.columns,
            rows: plane.rows,
            square: plane.square,
        },
        plane: card::Plane {
            seconds: film.flat.map(|t| (t * 1e3).round() / 1e3),
            origin: plane.corner,
            along: [1.0, 0.0],
            height: plane.height,
            grid: Some(plane.pitch),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn splits(of: RepeatSplit) -> Vec<Option<Split>> {
        let set = Settings::built_in();
        let profile = Profile { repeats: 3, brief: false, ..set.profile["paper"].clone() };
        let mut own = set.specimen["nemo"].clone();
        own.flaps.truncate(1);
        own.flaps[0].split = Some(of);
        planned_trials(&own, &profile)
            .into_iter()
            .filter(|t| matches!(t.experiment, Experiment::Flapping { .. }))
            .map(|t| t.split)
            .collect()
    }

    #[test]
    fn repeats_are_for_training_for_tests_or_the_last_for_a_test() {
        let [train, test] = [Some(Split::Train), Some(Split::Test)];
        assert_eq!(splits(RepeatSplit::Train), [train; 3]);
        assert_eq!(splits(RepeatSplit::Test), [test; 3]);
        assert_eq!(splits(RepeatSplit::Last), [train, train, test]);
    }
}
