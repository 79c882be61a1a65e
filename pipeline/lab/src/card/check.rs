//! Checks of a card: each number against the range of its unit, and each name against the others.
//!
//! The ranges include every soft actuator of hand size and exclude a factor of a thousand, so that a wrong unit is found.

use crate::range::{Checked, violation, within};

use super::entry::{name, pixel, point, relative, some, unique};
use super::log::{Log, LogColumn, Place, dimension_of};
use super::solids::{BODY, SPINE};
use super::{
    Camera, Card, Clamp, Experiment, FixtureOf, Led, Marker, Medium, Part, Solid, Solids, Tank, Trial, marker_sources,
    recordings,
};

/// Checks everything on a card, and that its name is that of `folder` where that is known.
pub(super) fn card(card: &Card, folder: Option<&str>) -> Checked {
    name("name", &card.name)?;
    if let Some(folder) = folder.filter(|f| *f != card.name) {
        let what = format!("name is `{}`, but the folder is `{folder}`", card.name);
        return violation("name", what, "a specimen is found by its folder", "make the two equal");
    }
    within("length", card.length, 0.01..=1.0, "m")?;
    solids(&card.solid)?;
    clamp(&card.clamp, card.solid.mesh.is_some())?;
    chambers(card)?;
    markers(card)?;
    card.camera.as_ref().map_or(Ok(()), camera)?;
    water(card)?;
    card.tank.map_or(Ok(()), |t| check_tank(&t))?;
    check_log(&card.log, &card.channels())?;
    card.led.as_ref().map_or(Ok(()), led)?;
    trials(card)?;
    marker_sources::tracks(card)?;
    recordings::recordings(card)?;
    marker_sources::markers(card)?;
    fixtures(card)
}

/// A mesh with regions; or STL files of a body, and of a sheet in it where there is one.
fn solids(all: &Solids) -> Checked {
    some("solid", all.parts.len())?;
    all.mesh.iter().try_for_each(|file| relative("solid.mesh", file))?;
    for part in &all.parts {
        let key = format!("solid.{}", part.name);
        name(&key, &part.name)?;
        source(&key, part, all.mesh.is_some())?;
        solid(&key, &part.solid)?;
    }
    if all.mesh.is_none() && all.position(BODY).is_none() {
        let why = "STL files are meshed as a body, with or without a plane sheet in it";
        return violation(
            "solid",
            "there is no [solid.body]".to_owned(),
            why,
            "call the soft solid body, or give solid.mesh",
        );
    }
    Ok(())
}

/// The file of a solid, or its region of the mesh.
fn source(key: &str, part: &Part, meshed: bool) -> Checked {
    let (name, Solid { file, region, .. }) = (&part.name, &part.solid);
    match (meshed, file, region) {
        (true, Some(_), _) => {
            let why = "solid.mesh gives the elements of every solid";
            violation(&format!("{key}.file"), format!("{key} has a file"), why, "take it out, or take solid.mesh out")
        }
        (true, None, _) => Ok(()),
        (false, _, Some(_)) => {
            let why = "a region belongs to a mesh, and there is no solid.mesh";
            violation(
                &format!("{key}.region"),
                format!("{key} has a region"),
                why,
                "give solid.mesh, or a file instead",
            )
        }
        (false, None, None) => {
            let why = "it is made from an STL file, or is a region of solid.mesh";
            violation(key, format!("{key} has no file"), why, "add file, or solid.mesh")
        }
        (false, Some(file), None) if name == BODY || name == SPINE => relative(&format!("{key}.file"), file),
        (false, Some(_), None) => {
            let why = "STL files are meshed as a body and a plane sheet in it, called body and spine";
            violation(key, format!("{key} has an STL file"), why, "mesh the solids together and give solid.mesh")
        }
    }
}

fn clamp(clamp: &Clamp, meshed: bool) -> Checked {
    clamp.below_x.map_or(Ok(()), |x| within("clamp.below_x", x, -1.0..=1.0, "m"))?;
    if let Some(block) = &clamp.block {
        point("clamp.box.low", &block.low)?;
        point("clamp.box.high", &block.high)?;
    }
    match clamp.is_one() {
        true if clamp.surface.is_some() && !meshed => {
            let what = "clamp.surface is given, but there is no solid.mesh".to_owned();
            let why = "surfaces are named in a mesh file, not in STL files";
            violation("clamp.surface", what, why, "give solid.mesh, or clamp by below_x, plane or box")
        }
        true => Ok(()),
        false => {
            let why = "the specimen is clamped at one place";
            let what = "[clamp] does not have exactly one of below_x, plane (across one axis), box and surface";
            violation("clamp", what.to_owned(), why, "give one, such as below_x = 0.004")
        }
    }
}

fn solid(key: &str, solid: &Solid) -> Checked {
    name(&format!("{key}.material"), &solid.material)?;
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
        let what = format!("{key}.plausible is [{low}, {high}] Pa around youngs_modulus = {} Pa", solid.youngs_modulus);
        let why = "an identification starts at youngs_modulus and searches inside plausible";
        return violation(&format!("{key}.plausible"), what, why, "widen plausible, or correct youngs_modulus");
    }
    Ok(())
}

fn chambers(card: &Card) -> Checked {
    some("chamber", card.chamber.len())?;
    unique("chamber", "name", card.chamber.iter().map(|c| c.name.as_str()))?;
    for (i, chamber) in card.chamber.iter().enumerate() {
        point(&format!("chamber.{i}.at"), &chamber.at)?;
        name(&format!("chamber.{i}.channel"), &chamber.channel)?;
    }
    Ok(())
}

fn markers(card: &Card) -> Checked {
    some("marker", card.marker.len())?;
    unique("marker", "name", card.marker.iter().map(|m| m.name.as_str()))?;
    card.marker.iter().enumerate().try_for_each(|(i, marker)| one_marker(&format!("marker.{i}"), marker))
}

fn one_marker(key: &str, marker: &Marker) -> Checked {
    point(&format!("{key}.at"), &marker.at)?;
    marker.clicked.iter().try_for_each(|at| pixel(&format!("{key}.clicked"), at))?;
    marker.diameter.map_or(Ok(()), |diameter| within(&format!("{key}.diameter"), diameter, 2e-4..=0.05, "m"))
}

fn camera(camera: &Camera) -> Checked {
    relative("camera.calibration", &camera.calibration)?;
    if let Some(file) = &camera.coefficients {
        relative("camera.coefficients", file)?;
    }
    within("camera.frame_every", camera.frame_every as f64, 1.0..=1000.0, "frames")?;
    within("camera.readout", camera.readout, 0.0..=0.1, "s")?;
    within("camera.board.columns", camera.board.columns as f64, 3.0..=100.0, "squares")?;
    within("camera.board.rows", camera.board.rows as f64, 3.0..=100.0, "squares")?;
    within("camera.board.square", camera.board.square, 1e-3..=0.2, "m")?;
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
fn water(card: &Card) -> Checked {
    if let Some(water) = &card.water {
        within("water.surface", water.surface, -1.0..=1.0, "m")?;
        return within("water.index", water.index, 1.3..=1.4, "(no unit)");
    }
    match card.trial.iter().position(|t| t.medium == Medium::Water && card.in_space(t).is_none()) {
        None => Ok(()),
        Some(i) => {
            let what = format!("trial `{}` is in water, but the card has no [water]", card.trial[i].id);
            let why = "the camera looks through its surface, which refracts every ray";
            violation(&format!("trial.{i}.medium"), what, why, "add [water] with surface (m, z) and index (1.333)")
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
    let known = [crate::pressure::titles(channels), vec![crate::force::COLUMNS[1].to_owned()]].concat();
    for (i, column) in log.columns.iter().enumerate() {
        log_column(&format!("log.columns.{i}"), column, &known)?;
    }
    Ok(())
}

fn log_column(key: &str, column: &LogColumn, known: &[String]) -> Checked {
    if !known.contains(&column.quantity) {
        let what = format!("{key}.quantity is `{}`", column.quantity);
        let why = format!("logs have {}", known.join(", "));
        return violation(&format!("{key}.quantity"), what, &why, "name one of them; other columns need no entry");
    }
    let dimension = dimension_of(&column.quantity);
    if let Some(unit) = column.unit.filter(|unit| unit.dimension() != dimension) {
        let what = format!("{key}.unit is `{}`, of `{}`", unit.word(), column.quantity);
        let why =
            "time is in s, ms, us or iso8601, pressure in Pa, mbar, kPa, bar or psi, force in N, mN or gf, led in 1";
        return violation(&format!("{key}.unit"), what, why, "correct the unit or the quantity");
    }
    if let Place::Position(at) = column.column {
        within(&format!("{key}.column"), at as f64, 1.0..=1000.0, "")?;
    }
    within(&format!("{key}.scale"), column.scale.abs(), 1e-12..=1e12, "")
}

fn led(led: &Led) -> Checked {
    pixel("led.centre", &led.centre)?;
    within("led.radius", led.radius, 1.0..=500.0, "px")
}

fn trials(card: &Card) -> Checked {
    some("trial", card.trial.len())?;
    unique("trial", "id", card.trial.iter().map(|t| t.id.as_str()))?;
    let channels = card.channels();
    for (i, trial) in card.trial.iter().enumerate() {
        one_trial(&format!("trial.{i}"), trial)?;
        driven(&format!("trial.{i}.channels"), trial, &channels)?;
    }
    Ok(())
}

/// A trial drives channels that fill a chamber, each once.
fn driven(key: &str, trial: &Trial, channels: &[String]) -> Checked {
    let driven = trial.experiment.channels();
    for (i, channel) in driven.iter().enumerate() {
        if !channels.contains(channel) {
            let what = format!("trial `{}` drives the channel `{channel}`, which fills no chamber", trial.id);
            let why = format!("the chambers' channels are {}", channels.join(", "));
            return violation(key, what, &why, "name one of them, or add a [[chamber]] with that channel");
        }
        if driven[..i].contains(channel) {
            let what = format!("trial `{}` drives the channel `{channel}` twice", trial.id);
            return violation(key, what, "each is filled once a level or a cycle", "name it once");
        }
    }
    Ok(())
}

fn one_trial(key: &str, trial: &Trial) -> Checked {
    name(&format!("{key}.id"), &trial.id)?;
    trial.video.iter().try_for_each(|video| relative(&format!("{key}.video"), video))?;
    relative(&format!("{key}.pressure"), &trial.pressure)?;
    if trial.split.is_some() && trial.force.is_none() {
        let what = format!("trial `{}` has a split for learning thrust, but no force log", trial.id);
        let why = "thrust is learned from measured force";
        return violation(&format!("{key}.split"), what, why, "name its force log, or leave split out");
    }
    if let Some(force) = &trial.force {
        relative(&format!("{key}.force"), force)?;
    }
    if let Some(last) = trial.last_frame {
        within(&format!("{key}.last_frame"), last as f64, trial.first_frame as f64 + 1.0..=1e7, "")?;
    }
    match &trial.experiment {
        Experiment::Staircase { levels, hold, pause, .. } => {
            some(&format!("{key}.levels"), levels.len())?;
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
fn fixtures(card: &Card) -> Checked {
    unique("fixture", "id", card.fixture.iter().map(|f| f.id.as_str()))?;
    for (i, fixture) in card.fixture.iter().enumerate() {
        let key = format!("fixture.{i}");
        if card.trial.iter().any(|t| t.id == fixture.id) {
            let what = format!("fixture id `{}` is a trial's as well", fixture.id);
            return violation(&format!("{key}.id"), what, "results are filed under it", "rename one of them");
        }
        relative(&format!("{key}.force"), &fixture.force)?;
        if fixture.of == FixtureOf::StillWater && fixture.medium == Medium::Air {
            let what = format!("fixture `{}` is still water in air", fixture.id);
            return violation(&format!("{key}.medium"), what, "waves stand in water", "correct kind or medium");
        }
        if fixture.of == FixtureOf::StillWater && card.tank.is_none() {
            let what = format!("fixture `{}` is still water, but the card has no [tank]", fixture.id);
            let why = "its size gives the frequencies of its standing waves";
            return violation(&format!("{key}.kind"), what, why, "add [tank] with length and depth (m, of the water)");
        }
        if let FixtureOf::Taps { hammer, count } = &fixture.of {
            relative(&format!("{key}.hammer"), hammer)?;
            count.map_or(Ok(()), |count| within(&format!("{key}.count"), count as f64, 1.0..=1000.0, "taps"))?;
        }
    }
    Ok(())
}
