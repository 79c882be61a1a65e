//! Specimens as twins: the identified and reduced tail, in water where added mass and drag were identified, that steps in real time.

use diagnostics::Result;
use hydro::Coefficients;
use publish::page::{LiveTail, LiveTrial};
use si::{Pascal, Point2, Point3};
use sysid::{Body, ReducedBody};
use thrust::outline::Outline;
use thrust::real_time::{Surroundings, twin_data};
use twin::TwinData;
use workflow::needs::{Maybe, Needs, RecordId, read_one};
use workflow::record::Record;
use workflow::runner::Store;

use crate::Runner;
use crate::stages::reduce::idle_chambers;
use records::subject::{Specimen, Trial};
use records::{Drag, Identified, Mesh, Motion, Reduced, Relaxation, Validation};

/// What a twin is made from.
type Inputs = ((Mesh, Identified, Reduced), Relaxation, Maybe<Drag>);

/// Density (kg/m³) and number of sections of the outline where no water was identified: its stations alone are used.
const DRY: (f64, usize) = (998.0, 30);

/// The twin of a specimen from its records, its markers at their positions at `rest` (m) or on the card; outputs are the markers, then
/// stations from the clamp to the end of the fin.
///
/// # Errors
/// A [`diagnostics::Diagnostic`] when a record is missing or stale, or a law is none that a twin has.
pub fn specimen_twin(runner: &Runner, specimen: &Specimen, rest: Option<&[Point2]>) -> Result<TwinData> {
    // masses are of the card, moduli of the records: both must be of the same card
    let records = <Inputs as Needs<Specimen>>::ids(specimen);
    runner.require(&records.iter().map(ToString::to_string).collect::<Vec<_>>())?;
    let ((mesh, identified, reduced), relaxation, Maybe(drag)) =
        <Inputs as Needs<Specimen>>::read(specimen, &Store::new(&runner.folders))?;
    let body = Body::of(&specimen.card);
    let (density, sections) = drag.as_ref().map_or(DRY, |drag| (drag.density, drag.sections));
    let (tail, spots) = Outline::new(&body, &mesh.solid).whole(density, sections)?;
    let model = mesh.model(&body)?;
    let model = match rest {
        Some(rest) => model.with_markers_at(&mesh.solid, &body, rest),
        None => model,
    };
    let model = model.with_spots(spots);
    let reduced_body = ReducedBody::of(&model, &relaxation.silicone(&model, &identified)?, &reduced.data)?;
    let stations: Vec<usize> = (body.markers.len()..reduced_body.markers()).collect();
    let (rows, half) = (reduced_body.rows(&stations), model.system.mesh().symmetry_plane_z);
    let surroundings = |by: Coefficients| Surroundings { tail: &tail, rows: &rows, by, half };
    let water = drag.map(|drag| surroundings(drag.by));
    let names: Vec<String> = (0..stations.len()).map(|i| format!("station{i}")).collect();
    let markers = specimen.card.marker.iter().map(|marker| marker.name.as_str());
    let outputs: Vec<(&str, usize)> = markers.chain(names.iter().map(String::as_str)).zip(0..).collect();
    let mut data = twin_data(&reduced_body, water.as_ref(), &outputs)?;
    let points: Vec<Point3> = model.markers.iter().map(|spot| spot.at(&mesh.solid.nodes)).collect();
    name_parts(&mut data, (reduced_body.group_names(&|region| identified.solids[region].clone()), &points));
    limit_pressures(&mut data, specimen, reduced.highest);
    Ok(TwinData { half, provenance: twin_provenance(runner, specimen, &records), ..data })
}

/// Gives regions their solids' names, and outputs the places of their `points` at rest, x and y of each in turn.
fn name_parts(data: &mut TwinData, (solids, points): (Vec<String>, &[Point3])) {
    for (region, solid) in data.regions.iter_mut().zip(solids) {
        region.name = solid;
    }
    for (output, at_rest) in data.outputs.iter_mut().zip(points.iter().flat_map(|[x, y, _]| [x, y])) {
        output.at_rest = *at_rest;
    }
}

/// Gives chambers the names of their channels, numbered where several share one, and the pressures that the tail was reduced under: up to the
/// `highest`, Pa, and none in a chamber that no trial fills.
fn limit_pressures(data: &mut TwinData, specimen: &Specimen, highest: Pascal) {
    let (chambers, idle) = (&specimen.card.chamber, idle_chambers(specimen));
    for (number, chamber) in data.chambers.iter_mut().enumerate() {
        let channel = &chambers[number].channel;
        let is_shared = chambers.iter().filter(|other| other.channel == *channel).count() > 1;
        chamber.name = if is_shared { format!("{channel}_{number}") } else { channel.clone() };
        chamber.range = [0.0, if idle.contains(&number) { 0.0 } else { highest }];
    }
}

/// Where a twin comes from: specimen, profile, version, and the content of each record that it is made from.
fn twin_provenance(runner: &Runner, specimen: &Specimen, records: &[RecordId]) -> Vec<(String, String)> {
    let store = Store::new(&runner.folders);
    let content = |id: &RecordId| {
        let hash = store.find(id).manifest().map(|manifest| manifest.content.clone()).unwrap_or_default();
        (format!("record {id}"), hash)
    };
    let program = env!("CARGO_PKG_VERSION").to_owned();
    let (specimen, profile) = (specimen.card.name.clone(), runner.profile.name().to_owned());
    let named = [("specimen", specimen), ("profile", profile), ("version", program)];
    named.map(|(key, value)| (key.to_owned(), value)).into_iter().chain(records.iter().map(content)).collect()
}

/// The tails that can move on the page, each beside a validation trial in its medium.
pub(crate) fn live_tails(runner: &Runner) -> Result<Vec<LiveTail>> {
    let store = Store::new(&runner.folders);
    let tail = |specimen: &Specimen| -> Option<Result<LiveTail>> {
        let wet = Drag::is_made_for(specimen);
        let fits = |trial: &Trial| Validation::is_made_for(trial) && trial.is_in_water() == wet;
        let trial = specimen.trials().into_iter().find(fits)?;
        let validation = read_one::<Validation>(&trial, &store).ok()?;
        let motion = read_one::<Motion>(&trial, &store).ok()?;
        let data = specimen_twin(runner, specimen, Some(&motion.rest)).ok()?;
        Some(live_tail(specimen, &data, validation))
    };
    runner.universe.specimens.iter().filter_map(tail).collect()
}

fn live_tail(specimen: &Specimen, data: &TwinData, validation: Validation) -> Result<LiveTail> {
    let Validation { time, measured, pressures, marker, .. } = validation;
    let highest = pressures.iter().flatten().fold(0.0, |most: f64, p| most.max(*p));
    let trial = LiveTrial { time, measured, pressures };
    let (name, length, arrays) = (specimen.card.name.clone(), specimen.card.length, twin::file::bytes(data)?);
    Ok(LiveTail { name, length, highest, marker, arrays, trial })
}
