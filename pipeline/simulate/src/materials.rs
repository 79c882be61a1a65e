//! Assignment of the case's materials to the regions of the mesh.

use fem::{Branch, RegionProperties, Relaxation, Springpot};
use mesh::foreign::Region;

use crate::case::{self, Case};
use diagnostics::{Diagnostic, Result};

/// What each region of the mesh is made of, and whether its dilatation is taken as a mean.
///
/// # Errors
/// A [`Diagnostic`] when a region has no material or two, the case names one that is not there, or a law is unknown.
pub(super) fn case_properties(case: &Case, regions: &[Region]) -> Result<(Vec<RegionProperties>, Vec<bool>)> {
    let is = |given: &case::Region, region: &Region| match (&given.name, given.tag) {
        (Some(name), _) => region.name.as_ref() == Some(name),
        (_, Some(tag)) => region.tag == tag,
        (None, None) => regions.len() == 1,
    };
    for (i, given) in case.region.iter().enumerate() {
        if !regions.iter().any(|region| is(given, region)) {
            let message = format!(
                "region {i} of the case ({}) is not in the mesh",
                region_title(given.tag, given.name.as_deref())
            );
            return Err(Diagnostic::new(message, known_regions(regions), "correct its name or tag"));
        }
    }
    let mut assigned = (Vec::new(), Vec::new());
    for region in regions {
        let given: Vec<_> = case.region.iter().filter(|given| is(given, region)).collect();
        let [single] = given[..] else {
            let message = format!(
                "region {} has {} materials",
                region_title(Some(region.tag), region.name.as_deref()),
                given.len()
            );
            let act = "give each region of the mesh one [[region]] with its name or tag";
            return Err(Diagnostic::new(message, known_regions(regions), act));
        };
        assigned.0.push(region_properties(single)?);
        assigned.1.push(single.mean_dilatation);
    }
    Ok(assigned)
}

fn region_properties(of: &case::Region) -> Result<RegionProperties> {
    let relaxation = case_relaxation(of)?;
    let youngs_modulus = of.youngs_modulus / of.modulus_time.map_or(1.0, |time| relaxation.modulus(time));
    let elastic =
        RegionProperties::elastic(material_by_name(&of.material)?, youngs_modulus, of.poissons_ratio, of.density);
    Ok(RegionProperties { stiffening: of.stiffening, relaxation, ..elastic })
}

fn case_relaxation(region: &case::Region) -> Result<Relaxation> {
    let relaxation = match region.springpot {
        Some(case::Springpot { strength, exponent, decades }) => {
            Relaxation::springpot(Springpot { strength, exponent, decades })
        }
        None => {
            let branch = |branch: &case::Branch| Branch { strength: branch.strength, time: branch.time };
            Relaxation::maxwell(&region.branch.iter().map(branch).collect::<Vec<_>>())
        }
    };
    relaxation.map_err(Diagnostic::from)
}

/// One line for each relaxation branch that the steps of a motion cannot follow.
pub(super) fn fast_branches(properties: &[RegionProperties], case: &Case) -> Vec<String> {
    let Some(set) = &case.dynamic else { return Vec::new() };
    let Some(step) = set.step.or(set.adaptive.map(|steps| steps.longest)) else { return Vec::new() };
    let of_region = |(region, is): (usize, &RegionProperties)| {
        let fast = is.relaxation.branches().iter().enumerate().filter(|(_, branch)| branch.time < 0.1 * step);
        let line = |(number, branch): (usize, &Branch)| {
            let time = branch.time;
            format!(
                "branch {number} of region {region} relaxes in {time} s, a step takes {step} s: it acts as a damper; \
                 shorten the step if faster motion matters"
            )
        };
        fast.map(line).collect::<Vec<_>>()
    };
    properties.iter().enumerate().flat_map(of_region).collect()
}

fn material_by_name(name: &str) -> Result<&'static dyn fem::Material> {
    fem::materials::by_name(name).ok_or_else(|| {
        let known_names: Vec<&str> = fem::materials::ALL.iter().map(|law| law.name()).collect();
        let reason = format!("known materials: {}", known_names.join(", "));
        Diagnostic::new(format!("there is no material `{name}`"), reason, "correct the case")
    })
}

fn region_title(tag: Option<i64>, name: Option<&str>) -> String {
    match (tag, name) {
        (Some(tag), Some(name)) => format!("`{name}`, tag {tag}"),
        (Some(tag), None) => format!("tag {tag}"),
        (None, Some(name)) => format!("`{name}`"),
        (None, None) => "without name and tag".to_owned(),
    }
}

fn known_regions(regions: &[Region]) -> String {
    let each = regions.iter().map(|region| region_title(Some(region.tag), region.name.as_deref()));
    format!("the mesh has {} regions: {}", regions.len(), each.collect::<Vec<_>>().join("; "))
}
