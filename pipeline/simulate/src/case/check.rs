//! Checks of a case: ranges of its numbers, and missing or contradictory entries.

use std::collections::BTreeSet;

use lab::range::{Checked, within};

use crate::budget::Budget;

use super::check_clamp::check_clamp;
use super::check_place::{FAR, check_place, check_vector};
use super::check_source::check_source;
use super::rule::require;
use super::{ArcLength, Case, Chamber, Dynamic, History, Load, Mass, Output, Place, Region, Static, Wave};

/// Largest pressure, Pa.
const PRESSURE: f64 = 1e8;

/// Checks all entries of a case.
pub(super) fn check_case(case: &Case) -> Checked {
    check_vector("gravity", &case.gravity, 1e3, "m/s²")?;
    check_source(&case.mesh)?;
    let upright = !case.mesh.half || case.gravity[2] == 0.0;
    require("gravity", upright, "gravity on a half model has no part along z: that would break the symmetry")?;
    check_each("region", &case.region, check_region)?;
    check_each("clamp", &case.clamp, |key, clamp| check_clamp(key, clamp, case))?;
    check_each("chamber", &case.chamber, check_chamber)?;
    check_each("load", &case.load, check_load)?;
    check_each("mass", &case.mass, check_mass)?;
    require("static", case.statics.is_some() != case.dynamic.is_some(), "a case has either [static] or [dynamic]")?;
    case.statics.as_ref().map_or(Ok(()), check_statics)?;
    case.statics.as_ref().map_or(Ok(()), |set| set.arc_length.map_or(Ok(()), |path| arc_length(case, set, path)))?;
    case.dynamic.as_ref().map_or(Ok(()), check_dynamic)?;
    check_output(&case.output)?;
    check_names(case)
}

fn check_each<T>(table: &str, list: &[T], check: impl Fn(&str, &T) -> Checked) -> Checked {
    list.iter().enumerate().try_for_each(|(i, one)| check(&format!("{table}.{i}"), one))
}

fn check_region(key: &str, region: &Region) -> Checked {
    within(&format!("{key}.youngs_modulus"), region.youngs_modulus, 1e2..=1e12, "Pa")?;
    let rule = "one below 0.5: incompressible solids are simulated with 0.49 to 0.499 and mean_dilatation = true";
    require(&format!("{key}.poissons_ratio"), region.poissons_ratio < 0.5, rule)?;
    within(&format!("{key}.poissons_ratio"), region.poissons_ratio, -0.99..=0.4999, "")?;
    within(&format!("{key}.density"), region.density, 1.0..=3e4, "kg/m³")?;
    region.stiffening.iter().try_for_each(|ratio| within(&format!("{key}.stiffening"), *ratio, -10.0..=100.0, ""))?;
    check_relaxation(key, region)?;
    require(key, region.name.is_none() || region.tag.is_none(), "a region is named by name or by tag, not by both")
}

fn check_relaxation(key: &str, region: &Region) -> Checked {
    let is_single = region.branch.is_empty() || region.springpot.is_none();
    require(key, is_single, "a region relaxes by branches or by a springpot, not by both")?;
    require(&format!("{key}.branch"), region.branch.len() <= fem::MAX_BRANCHES, "a region has at most 16 branches")?;
    for (i, branch) in region.branch.iter().enumerate() {
        within(&format!("{key}.branch.{i}.strength"), branch.strength, 0.0..=1e3, "of the long-term modulus")?;
        within(&format!("{key}.branch.{i}.time"), branch.time, 1e-9..=1e9, "s")?;
    }
    if let Some(springpot) = region.springpot {
        within(&format!("{key}.springpot.strength"), springpot.strength, 0.0..=1e3, "of the long-term modulus")?;
        within(&format!("{key}.springpot.exponent"), springpot.exponent, 1e-3..=0.999, "")?;
        let rising = springpot.decades[0] <= springpot.decades[1]
            && springpot.decades.iter().all(|decade| (-9..=9).contains(decade));
        require(&format!("{key}.springpot.decades"), rising, "two powers of ten that rise, between -9 and 9")?;
    }
    region.modulus_time.map_or(Ok(()), |time| within(&format!("{key}.modulus_time"), time, 0.0..=1e9, "s"))
}

fn check_chamber(key: &str, chamber: &Chamber) -> Checked {
    let is_single = chamber.inside.is_some() != chamber.number.is_some();
    require(key, is_single, "a chamber is chosen by inside = [x, y, z] or by number")?;
    chamber.inside.map_or(Ok(()), |at| check_vector(&format!("{key}.inside"), &at, FAR, "m"))?;
    chamber.sealed_in.map_or(Ok(()), |at| within(&format!("{key}.sealed_in"), at, 1.0..=PRESSURE, "Pa"))?;
    check_history(&format!("{key}.pressure"), &chamber.pressure)
}

/// Holds a history to the range of pressures, and its times to an order.
///
/// # Errors
/// The first number that is not: `key` is where it stands.
pub fn check_history(key: &str, history: &History) -> Checked {
    let pressure = |value: f64| within(key, value, -PRESSURE..=PRESSURE, "Pa");
    match history {
        History::Constant(value) => pressure(*value),
        History::Wave(Wave::Table { times, values }) => {
            require(key, !times.is_empty() && times.len() == values.len(), "a table has as many values as times")?;
            let rising = times.windows(2).all(|pair| pair[0] < pair[1]) && times.iter().all(|t| t.is_finite());
            require(key, rising, "the times of a table rise")?;
            values.iter().try_for_each(|value| pressure(*value))
        }
        History::Wave(Wave::Sine { mean, amplitude, frequency, phase }) => {
            pressure(*mean)?;
            pressure(*amplitude)?;
            within(key, *phase, -100.0..=100.0, "rad")?;
            within(key, *frequency, 1e-6..=1e5, "Hz")
        }
        History::Wave(Wave::Square { low, high, frequency, duty }) => {
            pressure(*low)?;
            pressure(*high)?;
            within(key, *duty, 0.0..=1.0, "(its duty)")?;
            within(key, *frequency, 1e-6..=1e5, "Hz")
        }
        History::Wave(Wave::Ramp { from, to, start, seconds }) => {
            pressure(*from)?;
            pressure(*to)?;
            within(key, *start, -1e6..=1e6, "s")?;
            within(key, *seconds, 1e-9..=1e6, "s")
        }
    }
}

fn check_load(key: &str, load: &Load) -> Checked {
    let [near, inside] = [load.near.is_some(), load.inside.is_some()];
    let places = [near, inside, load.plane.is_some(), load.block.is_some()];
    let whats = [load.force.is_some(), load.line_force.is_some(), load.traction.is_some(), load.pressure.is_some()];
    let has_one = |all: &[bool]| all.iter().filter(|given| **given).count() == 1;
    let fits = match (&load.table, whats) {
        (Some(_), whats) => whats == [false; 4] && places == [false; 4],
        (None, [true, false, false, false]) => near && has_one(&places),
        (None, [false, true, false, false]) => load.block.is_some() && has_one(&places),
        (None, [false, false, true, false]) => !near && !inside && has_one(&places),
        (None, [false, false, false, true]) => !near && has_one(&places),
        _ => false,
    };
    let rule = "it has near with force, box with line_force, plane or box with traction, inside, plane or box with pressure, or table";
    require(key, fits, rule)?;
    for (word, at) in [("near", load.near), ("inside", load.inside)] {
        at.map_or(Ok(()), |at| check_vector(&format!("{key}.{word}"), &at, FAR, "m"))?;
    }
    if load.plane.is_some() || load.block.is_some() {
        check_place(key, Place::of(load.plane, load.block))?;
    }
    if let Some(pressure) = load.pressure {
        within(&format!("{key}.pressure"), pressure, -1e10..=1e10, "Pa")?;
        require(&format!("{key}.pressure"), pressure != 0.0, "a load is not zero")?;
    }
    let check = |word: &str, value: Option<[f64; 3]>, limit: f64, unit: &str| match value {
        Some(value) => {
            check_vector(&format!("{key}.{word}"), &value, limit, unit)?;
            require(&format!("{key}.{word}"), value != [0.0; 3], "a load is not zero")
        }
        None => Ok(()),
    };
    check("force", load.force, 1e6, "N")?;
    check("line_force", load.line_force, 1e8, "N/m")?;
    check("traction", load.traction, 1e10, "Pa")
}

fn check_mass(key: &str, mass: &Mass) -> Checked {
    let spread = mass.plane.is_some() || mass.block.is_some();
    let at_point = mass.near.is_some() && mass.mass.is_some() && !spread && mass.area_density.is_none();
    let on_faces = mass.near.is_none() && mass.mass.is_none() && spread && mass.area_density.is_some();
    require(key, at_point || mass.hangs.is_none(), "what hangs has near with mass")?;
    require(key, at_point || on_faces, "it has near with mass, or plane or box with area_density")?;
    mass.near.map_or_else(
        || check_place(key, Place::of(mass.plane, mass.block)),
        |at| check_vector(&format!("{key}.near"), &at, FAR, "m"),
    )?;
    mass.mass.map_or(Ok(()), |mass| within(&format!("{key}.mass"), mass, 1e-9..=100.0, "kg"))?;
    mass.area_density.map_or(Ok(()), |layer| within(&format!("{key}.area_density"), layer, 1e-6..=1e4, "kg/m²"))
}

fn check_statics(set: &Static) -> Checked {
    require("static.levels", !set.levels.is_empty(), "at least one level is solved")?;
    set.levels.iter().try_for_each(|level| within("static.levels", *level, -1e3..=1e3, ""))?;
    within("static.load_steps", set.load_steps as f64, 1.0..=1e4, "")?;
    within("static.tolerance", set.tolerance, 1e-13..=1e-2, "of the size")?;
    set.max_cutbacks.map_or(Ok(()), |limit| within("static.max_cutbacks", limit as f64, 0.0..=1e4, ""))?;
    check_budget("static", set.budget())
}

fn check_budget(table: &str, budget: Budget) -> Checked {
    let key = |name: &str| format!("{table}.{name}");
    budget.max_iterations.map_or(Ok(()), |limit| within(&key("max_iterations"), limit as f64, 1.0..=1e9, ""))?;
    budget.timeout.map_or(Ok(()), |limit| within(&key("timeout"), limit, 1e-3..=1e7, "s"))
}

/// A path follows loads that grow in proportion, from none to the last level.
fn arc_length(case: &Case, set: &Static, path: ArcLength) -> Checked {
    within("static.arc_length.max_step", path.max_step, 1e-6..=0.5, "of the size")?;
    within("static.arc_length.max_steps", path.max_steps as f64, 1.0..=1e5, "steps")?;
    let rising = set.levels[0] > 0.0 && set.levels.windows(2).all(|pair| pair[0] < pair[1]);
    require("static.levels", rising, "with arc_length the levels rise from above 0: the path ends at the last one")?;
    check_each("chamber", &case.chamber, |key, chamber| {
        let plain = matches!(chamber.pressure, History::Constant(_));
        require(
            &format!("{key}.pressure"),
            plain,
            "with arc_length a pressure is a plain number, multiplied by the level",
        )?;
        let fed = chamber.sealed_in.is_none();
        require(
            &format!("{key}.sealed_in"),
            fed,
            "with arc_length chambers are fed: the pressure is what the path follows",
        )
    })
}

fn check_dynamic(set: &Dynamic) -> Checked {
    within("dynamic.duration", set.duration, 1e-9..=1e5, "s")?;
    let has_one = set.step.is_some() != set.adaptive.is_some();
    require("dynamic", has_one, "[dynamic] has either step or adaptive")?;
    if let Some(step) = set.step {
        within("dynamic.step", step, 1e-9..=set.duration, "s")?;
        let steps = set.duration / step;
        let is_whole = (steps - steps.round()).abs() <= 1e-6 * steps;
        require("dynamic.step", is_whole, "the duration is a whole number of steps")?;
        within("dynamic.step", steps, 1.0..=1e7, "steps")?;
    }
    if let Some(steps) = set.adaptive {
        within("dynamic.adaptive.tolerance", steps.tolerance, 1e-12..=1.0, "m")?;
        within("dynamic.adaptive.shortest", steps.shortest, 1e-9..=set.duration, "s")?;
        within("dynamic.adaptive.longest", steps.longest, steps.shortest..=set.duration, "s")?;
    }
    check_budget("dynamic", set.budget())?;
    within("dynamic.mass_damping", set.mass_damping, 0.0..=1e6, "1/s")?;
    within("dynamic.stiffness_damping", set.stiffness_damping, 0.0..=1e3, "s")?;
    let is_moved_by_inertia = fem::Scheme::from(set.scheme) != fem::Scheme::QuasiStatic;
    let of_inertia = [
        ("mass_damping", set.mass_damping > 0.0),
        ("stiffness_damping", set.stiffness_damping > 0.0),
        ("lumped_mass", set.lumped_mass),
    ];
    of_inertia.iter().try_for_each(|(word, is_given)| {
        let rule = "it has no effect on a quasi-static motion, whose states are equilibria";
        require(&format!("dynamic.{word}"), is_moved_by_inertia || !is_given, rule)
    })
}

fn check_output(output: &Output) -> Checked {
    within("output.every", output.every as f64, 1.0..=1e7, "")?;
    check_each("output.node", &output.node, |key, node| check_vector(&format!("{key}.near"), &node.near, FAR, "m"))?;
    check_each("output.marker", &output.marker, |key, marker| check_vector(&format!("{key}.at"), &marker.at, FAR, "m"))
}

/// Names head columns: letters, digits and `_`, each once.
fn check_names(case: &Case) -> Checked {
    let chambers =
        case.chamber.iter().enumerate().filter_map(|(i, c)| Some((format!("chamber.{i}.name"), c.name.as_ref()?)));
    let nodes = case.output.node.iter().enumerate().map(|(i, n)| (format!("output.node.{i}.name"), &n.name));
    let markers = case.output.marker.iter().enumerate().map(|(i, m)| (format!("output.marker.{i}.name"), &m.name));
    let mut taken = BTreeSet::new();
    let clamps = case.clamp.iter().enumerate().filter_map(|(i, c)| Some((format!("clamp.{i}.name"), c.name.as_ref()?)));
    for (key, name) in chambers.chain(nodes).chain(markers).chain(clamps) {
        let plain = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        require(&key, plain, "a name heads columns: letters, digits and `_`")?;
        require(&key, taken.insert(name.clone()), "names must be unique: they head columns")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A case with one of everything.
    const WHOLE: &str = r#"
gravity = [0.0, -9.81, 0.0]
mesh = { file = "finger.msh", unit = "mm", half = true }
region = [{ name = "soft", material = "yeoh", youngs_modulus = 1.6e5, poissons_ratio = 0.49, density = 1070.0, branch = [{ strength = 0.2, time = 0.05 }] }]
clamp = [{ plane = { x = 0.0 } }]
chamber = [{ name = "left", inside = [0.02, 0.0, 0.0], pressure = 2e4 }]
load = [{ near = [0.1, 0.0, 0.0], force = [0.0, 1.0, 0.0] }]
mass = [{ near = [0.1, 0.0, 0.0], mass = 0.002, hangs = "z" }]
static = { levels = [0.5, 1.0], arc_length = { max_step = 0.05 } }
output = { node = [{ name = "tip", near = [0.1, 0.0, 0.0] }], marker = [{ name = "back", at = [0.05, 0.01, 0.0] }] }
"#;

    /// The key of the first entry that is refused once `from` has become `to`.
    fn refused(from: &str, to: &str) -> Option<String> {
        assert!(WHOLE.contains(from), "{from}");
        let case: Case = toml::from_str(&WHOLE.replacen(from, to, 1)).unwrap_or_else(|e| panic!("{to}: {e}"));
        super::check_case(&case).err().map(|violation| violation.key)
    }

    #[test]
    fn a_whole_case_passes_and_what_is_left_out_has_its_default() {
        assert_eq!(refused("gravity", "gravity"), None);
        let case: Case = toml::from_str(&WHOLE.replace("levels = [0.5, 1.0], ", "")).unwrap();
        let set = case.statics.unwrap();
        assert_eq!((set.levels, set.load_steps, set.tolerance), (vec![1.0], 3, 1e-8));
        let springpot: crate::case::Springpot = toml::from_str("strength = 0.1\nexponent = 0.3").unwrap();
        assert_eq!(springpot.decades, [-3, 1]);
    }

    #[test]
    fn the_first_entry_that_cannot_be_followed_is_named() {
        let force = "near = [0.1, 0.0, 0.0], force = [0.0, 1.0, 0.0]";
        let weight = "near = [0.1, 0.0, 0.0], mass = 0.002, hangs = \"z\"";
        let set = "static = { levels = [0.5, 1.0], arc_length = { max_step = 0.05 } }";
        let branch = "branch = [{ strength = 0.2, time = 0.05 }]";
        for (from, to, key) in [
            ("-9.81, 0.0", "-9.81, 0.1", "gravity"),
            ("-9.81", "-9810.0", "gravity.1"),
            ("file = \"finger.msh\"", "file = \"finger.msh\", edge = 0.004", "mesh"),
            ("file = \"finger.msh\"", "file = \"finger.msh\", spine = \"s.stl\"", "mesh"),
            ("file = \"finger.msh\"", "body = \"b.stl\"", "mesh"),
            ("file = \"finger.msh\"", "body = \"b.stl\", edge = 2.0", "mesh.edge"),
            ("name = \"soft\"", "name = \"soft\", tag = 7", "region.0"),
            ("1.6e5", "16.0", "region.0.youngs_modulus"),
            ("0.49", "0.5", "region.0.poissons_ratio"),
            ("density = 1070.0", "density = 0.1", "region.0.density"),
            ("density", "stiffening = [200.0, 0.0], density", "region.0.stiffening"),
            ("density", "modulus_time = -1.0, density", "region.0.modulus_time"),
            (branch, "branch = [{ strength = 0.2, time = 0.0 }]", "region.0.branch.0.time"),
            (branch, "branch = [{ strength = -0.2, time = 0.1 }]", "region.0.branch.0.strength"),
            (
                branch,
                "branch = [{ strength = 0.2, time = 1.0 }], springpot = { strength = 0.1, exponent = 0.3 }",
                "region.0",
            ),
            (branch, "springpot = { strength = 0.1, exponent = 1.0 }", "region.0.springpot.exponent"),
            (branch, "springpot = { strength = 0.1, exponent = 0.3, decades = [1, 0] }", "region.0.springpot.decades"),
            (
                branch,
                "springpot = { strength = 0.1, exponent = 0.3, decades = [-10, 0] }",
                "region.0.springpot.decades",
            ),
            ("plane = { x = 0.0 }", "hold = []", "clamp.0"),
            ("plane = { x = 0.0 }", "plane = { x = 0.0 }, hold = []", "clamp.0.hold"),
            ("plane = { x = 0.0 }", "plane = { x = 0.0 }, surface = \"3\"", "clamp.0"),
            ("plane = { x = 0.0 }", "plane = { x = 11.0 }", "clamp.0.plane"),
            ("plane = { x = 0.0 }", "box = { low = [0.0, 0.0, 1.0], high = [1.0, 1.0, 0.5] }", "clamp.0.box"),
            ("inside = [0.02, 0.0, 0.0]", "inside = [0.02, 0.0, 0.0], number = 0", "chamber.0"),
            ("inside = [0.02, 0.0, 0.0]", "inside = [20.0, 0.0, 0.0]", "chamber.0.inside.0"),
            ("pressure = 2e4", "pressure = 2e4, sealed_in = 101325.0", "chamber.0.sealed_in"),
            ("pressure = 2e4", "pressure = 2e9", "chamber.0.pressure"),
            ("\"left\"", "\"to the left\"", "chamber.0.name"),
            ("\"left\"", "\"tip\"", "output.node.0.name"),
            ("\"back\"", "\"\"", "output.marker.0.name"),
            (force, "near = [0.1, 0.0, 0.0], traction = [0.0, 1.0, 0.0]", "load.0"),
            (force, "inside = [0.1, 0.0, 0.0], traction = [0.0, 1.0, 0.0]", "load.0"),
            (force, "inside = [0.1, 0.0, 0.0], plane = { x = 0.0 }, pressure = 1.0", "load.0"),
            (force, "near = [0.1, 0.0, 0.0], pressure = 1.0", "load.0"),
            (force, "near = [0.1, 0.0, 0.0], line_force = [0.0, 1.0, 0.0]", "load.0"),
            (force, "near = [0.1, 0.0, 0.0], force = [0.0, 1.0, 0.0], pressure = 1.0", "load.0"),
            (force, "table = \"f.csv\", force = [0.0, 1.0, 0.0]", "load.0"),
            (force, "near = [0.1, 0.0, 0.0], force = [0.0, 0.0, 0.0]", "load.0.force"),
            (force, "near = [0.1, 99.0, 0.0], force = [0.0, 1.0, 0.0]", "load.0.near.1"),
            (force, "plane = { x = 99.0 }, traction = [0.0, 1.0, 0.0]", "load.0.plane"),
            (force, "plane = { x = 0.0 }, pressure = 0.0", "load.0.pressure"),
            (force, "plane = { x = 0.0 }, pressure = 1e11", "load.0.pressure"),
            (weight, "near = [0.1, 0.0, 0.0], area_density = 1.0", "mass.0"),
            (weight, "plane = { x = 0.0 }, area_density = 1.0, hangs = \"z\"", "mass.0"),
            (weight, "near = [0.1, 0.0, 0.0], mass = 0.002, area_density = 1.0", "mass.0"),
            (weight, "plane = { x = 0.0 }, area_density = 1e5", "mass.0.area_density"),
            (weight, "near = [0.1, 0.0, 0.0], mass = 1e3", "mass.0.mass"),
            ("levels = [0.5, 1.0]", "levels = []", "static.levels"),
            ("levels = [0.5, 1.0]", "levels = [1.0, 1.0]", "static.levels"),
            ("levels = [0.5, 1.0]", "levels = [0.0, 1.0]", "static.levels"),
            ("levels = [0.5, 1.0]", "levels = [0.5, 1.0], load_steps = 0", "static.load_steps"),
            ("max_step = 0.05", "max_step = 0.6", "static.arc_length.max_step"),
            ("levels = [0.5, 1.0]", "levels = [0.5, 1.0], max_iterations = 0", "static.max_iterations"),
            ("levels = [0.5, 1.0]", "levels = [0.5, 1.0], max_cutbacks = 20000", "static.max_cutbacks"),
            ("levels = [0.5, 1.0]", "levels = [0.5, 1.0], timeout = 0.0", "static.timeout"),
            (set, "dynamic = { duration = 1.0, step = 0.5, timeout = -1.0 }", "dynamic.timeout"),
            (set, "", "static"),
            (set, "dynamic = { duration = 1.0, step = 0.3 }", "dynamic.step"),
            (set, "dynamic = { duration = 1.0, step = 2.0 }", "dynamic.step"),
            (set, "dynamic = { duration = 1.0 }", "dynamic"),
            (set, "dynamic = { duration = 1.0, step = 0.5, mass_damping = -1.0 }", "dynamic.mass_damping"),
            (
                set,
                "dynamic = { duration = 1.0, step = 0.5, scheme = \"quasi_static\", mass_damping = 1.0 }",
                "dynamic.mass_damping",
            ),
            (
                set,
                "dynamic = { duration = 1.0, step = 0.5, scheme = \"quasi_static\", lumped_mass = true }",
                "dynamic.lumped_mass",
            ),
            (
                set,
                "dynamic = { duration = 1.0, adaptive = { tolerance = 1e-5, shortest = 0.1, longest = 0.01 } }",
                "dynamic.adaptive.longest",
            ),
            ("output = { ", "output = { every = 0, ", "output.every"),
        ] {
            assert_eq!(refused(from, to).as_deref(), Some(key), "{to}");
        }
    }

    #[test]
    fn what_may_stand_in_its_place_is_followed() {
        let force = "near = [0.1, 0.0, 0.0], force = [0.0, 1.0, 0.0]";
        let set = "static = { levels = [0.5, 1.0], arc_length = { max_step = 0.05 } }";
        for (from, to) in [
            ("file = \"finger.msh\"", "body = \"b.stl\", edge = 0.004, spine = \"s.stl\""),
            ("plane = { x = 0.0 }", "surface = \"3\""),
            (force, "table = \"f.csv\""),
            (force, "inside = [0.1, 0.0, 0.0], pressure = -1.0"),
            (force, "plane = { x = 0.0 }, traction = [0.0, 1.0, 0.0]"),
            (force, "box = { low = [0.0, 0.0, 0.0], high = [0.0, 1.0, 1.0] }, line_force = [0.0, 1.0, 0.0]"),
            (set, "dynamic = { duration = 0.3, step = 0.1 }"),
            (set, "dynamic = { duration = 1.0, adaptive = { tolerance = 1e-5, shortest = 0.01, longest = 0.01 } }"),
        ] {
            assert_eq!(refused(from, to), None, "{to}");
        }
    }
}
