//! Checks of a card: each number against the range of its unit, and each name against the others.
//!
//! The ranges include every soft actuator of hand size and exclude a factor of a thousand, so that a wrong unit is found.

use crate::range::{Checked, violation, within};

use super::board::check_board;
use super::entry::{check_name, check_not_empty, check_pixel, check_point, check_relative, check_unique};
use super::log::{Log, LogColumn, Place, dimension_of};
use super::solids::{BODY, SPINE};
use super::{
    Camera, Card, Clamp, Experiment, FixtureOf, Led, Marker, Medium, Part, Solid, Solids, Tank, Trial, marker_sources,
    recordings,
};

/// Checks everything on a card, and that its name is that of `folder` where that is known.
pub(super) fn check_card(card: &Card, folder: Option<&str>) -> Checked {
    check_name("name", &card.name)?;
    if let Some(folder) = folder.filter(|f| *f != card.name) {
        let defect = format!("name is `{}`, but the folder is `{folder}`", card.name);
        return violation("name", defect, "a specimen is found by its folder", "make the two equal");
    }
    within("length", card.length, 0.01..=1.0, "m")?;
    check_solids(&card.solid)?;
    check_clamp(&card.clamp, card.solid.mesh.is_some())?;
    check_chambers(card)?;
    check_markers(card)?;
    card.camera.as_ref().map_or(Ok(()), check_camera)?;
    check_water(card)?;
    card.tank.map_or(Ok(()), |t| check_tank(&t))?;
    check_log(&card.log, &card.channels())?;
    card.led.as_ref().map_or(Ok(()), check_lamp)?;
    check_trials(card)?;
    marker_sources::check_tracks(card)?;
    recordings::check_recordings(card)?;
    marker_sources::check_markers(card)?;
    check_fixtures(card)
}

/// A mesh with regions; or STL files of a body, and of a sheet in it where there is one.
fn check_solids(all: &Solids) -> Checked {
    check_not_empty("solid", all.parts.len())?;
    all.mesh.iter().try_for_each(|file| check_relative("solid.mesh", file))?;
    for part in &all.parts {
        let key = format!("solid.{}", part.name);
        check_name(&key, &part.name)?;
        check_source(&key, part, all.mesh.is_some())?;
        check_solid(&key, &part.solid)?;
    }
    if all.mesh.is_none() && all.position(BODY).is_none() {
        let reason = "STL files are meshed as a body, with or without a plane sheet in it";
        return violation(
            "solid",
            "there is no [solid.body]".to_owned(),
            reason,
            "call the soft solid body, or give solid.mesh",
        );
    }
    Ok(())
}

/// The file of a solid, or its region of the mesh.
fn check_source(key: &str, part: &Part, meshed: bool) -> Checked {
    let (name, Solid { file, region, .. }) = (&part.name, &part.solid);
    match (meshed, file, region) {
        (true, Some(_), _) => {
            let reason = "solid.mesh gives the elements of every solid";
            violation(
                &format!("{key}.file"),
                format!("{key} has a file"),
                reason,
                "take it out, or take solid.mesh out",
            )
        }
        (true, None, _) => Ok(()),
        (false, _, Some(_)) => {
            let reason = "a region belongs to a mesh, and there is no solid.mesh";
            violation(
                &format!("{key}.region"),
                format!("{key} has a region"),
                reason,
                "give solid.mesh, or a file instead",
            )
        }
        (false, None, None) => {
            let reason = "it is made from an STL file, or is a region of solid.mesh";
            violation(key, format!("{key} has no file"), reason, "add file, or solid.mesh")
        }
        (false, Some(file), None) if name == BODY || name == SPINE => check_relative(&format!("{key}.file"), file),
        (false, Some(_), None) => {
            let reason = "STL files are meshed as a body and a plane sheet in it, called body and spine";
            violation(key, format!("{key} has an STL file"), reason, "mesh the solids together and give solid.mesh")
        }
    }
}

fn check_clamp(clamp: &Clamp, meshed: bool) -> Checked {
    clamp.below_x.map_or(Ok(()), |x| within("clamp.below_x", x, -1.0..=1.0, "m"))?;
    if let Some(block) = &clamp.block {
        check_point("clamp.box.low", &block.low)?;
        check_point("clamp.box.high", &block.high)?;
    }
    match clamp.is_one() {
        true if clamp.surface.is_some() && !meshed => {
            let defect = "clamp.surface is given, but there is no solid.mesh".to_owned();
            let reason = "surfaces are named in a mesh file, not in STL files";
            violation("clamp.surface", defect, reason, "give solid.mesh, or clamp by below_x, plane or box")
        }
        true => Ok(()),
        false => {
            let reason = "the specimen is clamped at one place";
            let defect = "[clamp] does not have exactly one of below_x, plane (across one axis), box and surface";
            violation("clamp", defect.to_owned(), reason, "give one, such as below_x = 0.004")
        }
    }
}

fn check_solid(key: &str, solid: &Solid) -> Checked {
    check_name(&format!("{key}.material"), &solid.material)?;
    within(&format!("{key}.youngs_modulus"), solid.youngs_modulus, 1e3..=1e12, "Pa")?;
    within(&format!("{key}.poissons_ratio"), solid.poissons_ratio, -1.0..=0.499, "")?;
    within(&format!("{key}.density"), solid.density, 100.0..=20_000.0, "kg/m³")?;
    for (term, ratio) in solid.stiffening.into_iter().enumerate() {
        within(&format!("{key}.stiffening.{term}"), ratio, -1.0..=10.0, "")?;
    }
    for (term, sigma) in solid.stiffening_sigma.into_iter().flatten().enumerate() {
        within(&format!("{key}.stiffening_sigma.{term}"), sigma, 1e-6..=10.0, "")?;
    }
    let [low, high] = solid.plausible;
    within(&format!("{key}.plausible.0"), low, 1e3..=1e12, "Pa")?;
    within(&format!("{key}.plausible.1"), high, 1e3..=1e12, "Pa")?;
    if !(low < solid.youngs_modulus && solid.youngs_modulus < high) {
        let defect =
            format!("{key}.plausible is [{low}, {high}] Pa around youngs_modulus = {} Pa", solid.youngs_modulus);
        let reason = "an identification starts at youngs_modulus and searches inside plausible";
        return violation(&format!("{key}.plausible"), defect, reason, "widen plausible, or correct youngs_modulus");
    }
    Ok(())
}

fn check_chambers(card: &Card) -> Checked {
    check_not_empty("chamber", card.chamber.len())?;
    check_unique("chamber", "name", card.chamber.iter().map(|c| c.name.as_str()))?;
    for (i, chamber) in card.chamber.iter().enumerate() {
        check_point(&format!("chamber.{i}.at"), &chamber.at)?;
        check_name(&format!("chamber.{i}.channel"), &chamber.channel)?;
    }
    Ok(())
}

fn check_markers(card: &Card) -> Checked {
    check_not_empty("marker", card.marker.len())?;
    check_unique("marker", "name", card.marker.iter().map(|m| m.name.as_str()))?;
    card.marker.iter().enumerate().try_for_each(|(i, marker)| check_marker(&format!("marker.{i}"), marker))
}

fn check_marker(key: &str, marker: &Marker) -> Checked {
    check_point(&format!("{key}.at"), &marker.at)?;
    marker.clicked.iter().try_for_each(|position| check_pixel(&format!("{key}.clicked"), position))?;
    marker.diameter.map_or(Ok(()), |diameter| within(&format!("{key}.diameter"), diameter, 2e-4..=0.05, "m"))
}

fn check_camera(camera: &Camera) -> Checked {
    check_relative("camera.calibration", &camera.calibration)?;
    if let Some(file) = &camera.coefficients {
        check_relative("camera.coefficients", file)?;
    }
    within("camera.frame_every", camera.frame_every as f64, 1.0..=1000.0, "frames")?;
    within("camera.readout", camera.readout, 0.0..=0.1, "s")?;
    check_board(&camera.board)?;
    let [from, to] = camera.plane.seconds;
    within("camera.plane.seconds.0", from, 0.0..=3600.0, "s")?;
    within("camera.plane.seconds.1", to, from..=3600.0, "s")?;
    within("camera.plane.origin.0", camera.plane.origin[0], -1.0..=1.0, "m")?;
    within("camera.plane.origin.1", camera.plane.origin[1], -1.0..=1.0, "m")?;
    let [x, y] = camera.plane.along;
    within("camera.plane.along", x.hypot(y), 0.999..=1.001, "(its length)")?;
    within("camera.plane.height", camera.plane.height, -1.0..=1.0, "m")?;
    camera.plane.grid.map_or(Ok(()), |pitch| within("camera.plane.grid", pitch, 1e-3..=0.2, "m"))
}

/// A trial that is tracked in a film in water needs the height of the water surface, which refracts every ray.
fn check_water(card: &Card) -> Checked {
    if let Some(water) = &card.water {
        within("water.surface", water.surface, -1.0..=1.0, "m")?;
        return within("water.index", water.index, 1.3..=1.4, "(no unit)");
    }
    match card.trial.iter().position(|t| t.medium == Medium::Water && card.in_space(t).is_none()) {
        None => Ok(()),
        Some(i) => {
            let defect = format!("trial `{}` is in water, but the card has no [water]", card.trial[i].id);
            let reason = "the camera looks through its surface, which refracts every ray";
            violation(&format!("trial.{i}.medium"), defect, reason, "add [water] with surface (m, z) and index (1.333)")
        }
    }
}

/// Checks the size of a tank.
///
/// # Errors
/// [`crate::range::Violation`] when a number is out of its range.
pub fn check_tank(tank: &Tank) -> Checked {
    within("tank.length", tank.length, 0.05..=100.0, "m")?;
    within("tank.depth", tank.depth, 0.01..=10.0, "m")
}

/// Checks how the instruments write their logs, of pressures in these `channels`.
///
/// # Errors
/// [`crate::range::Violation`] when a number is out of its range, or a unit is not that of its quantity.
pub fn check_log(log: &Log, channels: &[String]) -> Checked {
    log.longest_gap.map_or(Ok(()), |gap| within("log.longest_gap", gap, 1e-4..=10.0, "s"))?;
    log.force_lag.map_or(Ok(()), |lag| within("log.force_lag", lag, 0.0..=5.0, "s"))?;
    within("log.force_lag_sigma", log.force_lag_sigma, 0.0..=1.0, "s")?;
    let quantities = [crate::pressure::titles(channels), vec![crate::force::COLUMNS[1].to_owned()]].concat();
    for (i, column) in log.columns.iter().enumerate() {
        check_log_column(&format!("log.columns.{i}"), column, &quantities)?;
    }
    Ok(())
}

fn check_log_column(key: &str, column: &LogColumn, quantities: &[String]) -> Checked {
    if !quantities.contains(&column.quantity) {
        let defect = format!("{key}.quantity is `{}`", column.quantity);
        let reason = format!("logs have {}", quantities.join(", "));
        return violation(&format!("{key}.quantity"), defect, &reason, "name one of them; other columns need no entry");
    }
    let dimension = dimension_of(&column.quantity);
    if let Some(unit) = column.unit.filter(|unit| unit.dimension() != dimension) {
        let defect = format!("{key}.unit is `{}`, of `{}`", unit.word(), column.quantity);
        let reason =
            "time is in s, ms, us or iso8601, pressure in Pa, mbar, kPa, bar or psi, force in N, mN or gf, led in 1";
        return violation(&format!("{key}.unit"), defect, reason, "correct the unit or the quantity");
    }
    if let Place::Position(position) = column.column {
        within(&format!("{key}.column"), position as f64, 1.0..=1000.0, "")?;
    }
    within(&format!("{key}.scale"), column.scale.abs(), 1e-12..=1e12, "")
}

fn check_lamp(led: &Led) -> Checked {
    check_pixel("led.centre", &led.centre)?;
    within("led.radius", led.radius, 1.0..=500.0, "px")
}

fn check_trials(card: &Card) -> Checked {
    check_not_empty("trial", card.trial.len())?;
    check_unique("trial", "id", card.trial.iter().map(|t| t.id.as_str()))?;
    let channels = card.channels();
    for (i, trial) in card.trial.iter().enumerate() {
        check_trial(&format!("trial.{i}"), trial)?;
        check_channels(&format!("trial.{i}.channels"), trial, &channels)?;
    }
    Ok(())
}

/// A trial drives channels that fill a chamber, each once.
fn check_channels(key: &str, trial: &Trial, channels: &[String]) -> Checked {
    let driven = trial.experiment.channels();
    for (i, channel) in driven.iter().enumerate() {
        if !channels.contains(channel) {
            let defect = format!("trial `{}` drives the channel `{channel}`, which fills no chamber", trial.id);
            let reason = format!("the chambers' channels are {}", channels.join(", "));
            return violation(key, defect, &reason, "name one of them, or add a [[chamber]] with that channel");
        }
        if driven[..i].contains(channel) {
            let defect = format!("trial `{}` drives the channel `{channel}` twice", trial.id);
            return violation(key, defect, "each is filled once a level or a cycle", "name it once");
        }
    }
    Ok(())
}

fn check_trial(key: &str, trial: &Trial) -> Checked {
    check_name(&format!("{key}.id"), &trial.id)?;
    trial.video.iter().try_for_each(|video| check_relative(&format!("{key}.video"), video))?;
    check_relative(&format!("{key}.pressure"), &trial.pressure)?;
    if trial.split.is_some() && trial.force.is_none() {
        let defect = format!("trial `{}` has a split for learning thrust, but no force log", trial.id);
        let reason = "thrust is learned from measured force";
        return violation(&format!("{key}.split"), defect, reason, "name its force log, or leave split out");
    }
    if let Some(force) = &trial.force {
        check_relative(&format!("{key}.force"), force)?;
    }
    if let Some(last) = trial.last_frame {
        within(&format!("{key}.last_frame"), last as f64, trial.first_frame as f64 + 1.0..=1e7, "")?;
    }
    match &trial.experiment {
        Experiment::Staircase { levels, hold, pause, .. } => {
            check_not_empty(&format!("{key}.levels"), levels.len())?;
            for (j, level) in levels.iter().enumerate() {
                within(&format!("{key}.levels.{j}"), *level, 0.0..=5e5, "Pa")?;
            }
            within(&format!("{key}.hold"), *hold, 0.05..=3600.0, "s")?;
            within(&format!("{key}.pause"), *pause, 0.0..=3600.0, "s")
        }
        Experiment::Flapping { amplitude, frequency, cycles, .. } => {
            within(&format!("{key}.amplitude"), *amplitude, 0.0..=5e5, "Pa")?;
            within(&format!("{key}.frequency"), *frequency, 0.05..=50.0, "Hz")?;
            within(&format!("{key}.cycles"), *cycles as f64, 1.0..=1e5, "")
        }
    }
}

/// Ids of fixtures differ from those of trials, because files and results are named by both.
fn check_fixtures(card: &Card) -> Checked {
    check_unique("fixture", "id", card.fixture.iter().map(|f| f.id.as_str()))?;
    for (i, fixture) in card.fixture.iter().enumerate() {
        let key = format!("fixture.{i}");
        if card.trial.iter().any(|t| t.id == fixture.id) {
            let defect = format!("fixture id `{}` is a trial's as well", fixture.id);
            return violation(&format!("{key}.id"), defect, "results are filed under it", "rename one of them");
        }
        check_relative(&format!("{key}.force"), &fixture.force)?;
        if fixture.of == FixtureOf::StillWater && fixture.medium == Medium::Air {
            let defect = format!("fixture `{}` is still water in air", fixture.id);
            return violation(&format!("{key}.medium"), defect, "waves stand in water", "correct kind or medium");
        }
        if fixture.of == FixtureOf::StillWater && card.tank.is_none() {
            let defect = format!("fixture `{}` is still water, but the card has no [tank]", fixture.id);
            let reason = "its size gives the frequencies of its standing waves";
            return violation(
                &format!("{key}.kind"),
                defect,
                reason,
                "add [tank] with length and depth (m, of the water)",
            );
        }
        if let FixtureOf::Taps { hammer, count } = &fixture.of {
            check_relative(&format!("{key}.hammer"), hammer)?;
            count.map_or(Ok(()), |count| within(&format!("{key}.count"), count as f64, 1.0..=1000.0, "taps"))?;
        }
    }
    Ok(())
}
