//! Table `optics`: the error of the markers without each correction between pixel and metre, for the trial of largest motion
//! in each medium. Paper, section IV.

use lab::card::Medium;
use plot::Column;

use diagnostics::Result;
use records::subject::{Study, Trial};
use records::{Markers, OmittedCorrection};
use workflow::needs::Every;
use workflow::subject::Subject;
use workflow::table::Table;

/// The table.
pub struct Optics;

impl Table for Optics {
    type Of = Study;
    type Needs = Every<Markers, Trial>;
    const NAME: &'static str = "optics";
    const CAPTION: &'static str = "size of each correction between pixels and metres";
    const VERSION: u32 = 1;

    fn fill(Every(markers_of_trials): Self::Needs) -> Result<plot::Table> {
        let columns = vec![
            Column::text("medium"),
            Column::text("trial"),
            Column::text("left out"),
            Column::numbers("error of position", "mm"),
            Column::numbers("error of displacement", "mm"),
        ];
        let rows =
            [Medium::Air, Medium::Water].into_iter().filter_map(|medium| liveliest_trial(&markers_of_trials, medium));
        let rows =
            rows.flat_map(|(trial, markers)| markers.left_out.iter().map(|omitted| correction_row(trial, omitted)));
        let table = plot::Table::new(columns, rows.collect())?;
        Ok(table.noted("Root mean square over markers and frames, against the same tracks with every correction."))
    }
}

/// The trial of a medium with the largest marker displacement from the first frame.
fn liveliest_trial(markers_of_trials: &[(Trial, Markers)], medium: Medium) -> Option<(&Trial, &Markers)> {
    let of_medium = markers_of_trials.iter().filter(|(trial, _)| trial.trial.medium == medium);
    let far = of_medium.max_by(|(_, a), (_, b)| largest_displacement(a).total_cmp(&largest_displacement(b)));
    far.map(|(trial, markers)| (trial, markers))
}

/// Largest displacement from the first frame, m.
fn largest_displacement(markers: &Markers) -> f64 {
    let firsts = markers.markers.iter().filter_map(|m| Some((m, m.at.first()?)));
    let far = firsts.flat_map(|(m, first)| m.at.iter().map(|p| (p[0] - first[0]).hypot(p[1] - first[1])));
    far.fold(0.0, f64::max)
}

fn correction_row(trial: &Trial, omitted: &OmittedCorrection) -> Vec<String> {
    let millimetres = |metres: f64| format!("{:.4}", 1e3 * metres);
    let (medium, name) = (trial.trial.medium.word().to_owned(), trial.name());
    vec![
        medium,
        name,
        omitted.correction.replace('_', " "),
        millimetres(omitted.place_m),
        millimetres(omitted.motion_m),
    ]
}
