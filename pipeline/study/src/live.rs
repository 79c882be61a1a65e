//! Specimens as twins: the identified and reduced tail, in water where added mass and drag were identified, that steps in real time.

use diagnostics::Result;
use hydro::Coefficients;
use publish::page::{LiveTail, LiveTrial};
use si::Point2;
use sysid::{Body, ReducedBody};
use thrust::outline::Outline;
use thrust::real_time::{Surroundings, twin_data};
use twin::TwinData;
use workflow::needs::{Maybe, Needs, read_one};
use workflow::record::Record;
use workflow::runner::Store;

use crate::Runner;
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
pub fn twin(runner: &Runner, specimen: &Specimen, rest: Option<&[Point2]>) -> Result<TwinData> {
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
    let around = |by: Coefficients| Surroundings { tail: &tail, rows: &rows, by, half };
    let water = drag.map(|drag| around(drag.by));
    let names: Vec<String> = (0..stations.len()).map(|i| format!("station{i}")).collect();
    let markers = specimen.card.marker.iter().map(|marker| marker.name.as_str());
    let outputs: Vec<(&str, usize)> = markers.chain(names.iter().map(String::as_str)).zip(0..).collect();
    twin_data(&reduced_body, water.as_ref(), &outputs)
}

/// The tails that can move on the page, each beside a validation trial in its medium.
pub(crate) fn tails(runner: &Runner) -> Result<Vec<LiveTail>> {
    let store = Store::new(&runner.folders);
    let tail = |specimen: &Specimen| -> Option<Result<LiveTail>> {
        let wet = Drag::is_made_for(specimen);
        let fits = |trial: &Trial| Validation::is_made_for(trial) && trial.is_in_water() == wet;
        let trial = specimen.trials().into_iter().find(fits)?;
        let validation = read_one::<Validation>(&trial, &store).ok()?;
        let motion = read_one::<Motion>(&trial, &store).ok()?;
        let data = twin(runner, specimen, Some(&motion.rest)).ok()?;
        Some(live(specimen, &data, validation))
    };
    runner.universe.specimens.iter().filter_map(tail).collect()
}

fn live(specimen: &Specimen, data: &TwinData, validation: Validation) -> Result<LiveTail> {
    let Validation { time, measured, pressures, marker, .. } = validation;
    let highest = pressures.iter().flatten().fold(0.0, |most: f64, p| most.max(*p));
    let trial = LiveTrial { time, measured, pressures };
    let (name, length, arrays) = (specimen.card.name.clone(), specimen.card.length, twin::file::bytes(data)?);
    Ok(LiveTail { name, length, highest, marker, arrays, trial })
}
