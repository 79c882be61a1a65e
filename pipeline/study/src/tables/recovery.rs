//! Table `recovery`: estimates against the hidden truth of the virtual bench.

use lab::card::Origin;
use plot::Column;

use crate::records::{Drag, Identified, REPORTED, Recovered, RecoveredSpecimen, Relaxation};
use crate::subject::{Specimen, Study};
use diagnostics::Result;
use workflow::needs::Every;
use workflow::subject::Subject;
use workflow::table::Table;

/// The table.
pub struct Recovery;

impl Table for Recovery {
    type Of = Study;
    type Needs = (Recovered, Every<Identified, Specimen>, Every<Relaxation, Specimen>, Every<Drag, Specimen>);
    const NAME: &'static str = "recovery";
    const CAPTION: &'static str = "identified and hidden parameters";
    const VERSION: u32 = 4;

    fn is_made_for(study: &Study) -> bool {
        study.specimens.iter().any(|s| s.card.origin == Origin::VirtualBench)
    }

    fn fill((all, Every(identified), Every(relaxed), Every(dragged)): Self::Needs) -> Result<plot::Table> {
        let columns = vec![
            Column::text("quantity"),
            Column::text("of"),
            Column::numbers("identified", ""),
            Column::numbers("hidden", ""),
            Column::numbers("error", ""),
            Column::numbers("error / σ", ""),
        ];
        let sigma = |name: &str| identified.iter().find(|(s, _)| s.name() == name).map(|(_, found)| found.sigma);
        let water = |name: &str| dragged.iter().find(|(s, _)| s.name() == name).map(|(_, found)| found.sigma);
        let moduli = all.specimens.iter().flat_map(|s| {
            let (sigma, water) = (sigma(&s.name), water(&s.name));
            let rows = moduli(s, sigma.map(|s| s.body_e_pa), sigma.map(|s| s.spine_e_pa));
            let relaxed = relaxed.iter().find(|(of, _)| of.name() == s.name).map(|(_, found)| found);
            let sigma = Sigma {
                silicone: REPORTED.map(|f| relaxed.and_then(|r| r.sigma_at(f).ok())),
                added: water.map(|w| w.added),
                drag: water.map(|w| w.drag),
            };
            rows.into_iter().chain(moving(s, &sigma))
        });
        let rows = moduli.chain(instruments(&all)).collect();
        let table = plot::Table::new(columns, rows)?;
        Ok(table.noted("Error / σ: the error over the standard deviation estimated by the pipeline."))
    }
}

fn moduli(of: &RecoveredSpecimen, body_sigma: Option<f64>, spine_sigma: Option<f64>) -> [Vec<String>; 2] {
    let body = Parameter { name: "E of the body at its time (MPa)", unit: 1e-6, pair: of.body_e_pa, sigma: body_sigma };
    let spine = Parameter { name: "E of the spine (GPa)", unit: 1e-9, pair: of.spine_e_pa, sigma: spine_sigma };
    [body.row(of), spine.row(of)]
}

/// Parameters identified from motion, where there are any.
fn moving(of: &RecoveredSpecimen, sigma: &Sigma) -> Vec<Vec<String>> {
    let silicone = [("storage modulus over E", &of.storage_ratio, 0), ("loss factor", &of.loss_factor, 1)];
    let named = |(name, pairs, which): (&'static str, &Vec<[f64; 2]>, usize)| {
        let at = REPORTED.into_iter().zip(sigma.silicone);
        let row = move |(pair, (f, sigma)): ([f64; 2], (f64, Option<[f64; 2]>))| {
            (format!("{name} at {f} Hz"), Some(pair), sigma.map(|s| s[which]))
        };
        pairs.clone().into_iter().zip(at).map(row)
    };
    let silicone = silicone.into_iter().flat_map(named);
    let water = [("added mass ratio", of.added, sigma.added), ("normal drag coefficient", of.drag, sigma.drag)];
    let water = water.into_iter().map(|(name, pair, sigma)| (name.to_owned(), pair, sigma));
    let known = silicone.chain(water).filter_map(|(name, pair, sigma)| Some((name, pair?, sigma)));
    known.map(|(name, pair, sigma)| Parameter { name: &name, unit: 1.0, pair, sigma }.row(of)).collect()
}

/// Standard deviations of what was identified from motion; none where it was not.
#[derive(Default)]
struct Sigma {
    /// Storage modulus ratio and loss factor at each of [`REPORTED`].
    silicone: [Option<[f64; 2]>; 3],
    added: Option<f64>,
    drag: Option<f64>,
}

/// A parameter of a specimen.
struct Parameter<'a> {
    /// Its name with the unit of the cells.
    name: &'a str,
    /// Number of the cells' units in the SI unit.
    unit: f64,
    /// Identified and hidden, SI.
    pair: [f64; 2],
    /// Standard deviation, SI.
    sigma: Option<f64>,
}

impl Parameter<'_> {
    fn row(&self, of: &RecoveredSpecimen) -> Vec<String> {
        let [found, hidden] = self.pair;
        vec![
            self.name.to_owned(),
            of.name.clone(),
            format!("{:.4}", self.unit * found),
            format!("{:.4}", self.unit * hidden),
            format!("{:.1} %", 100.0 * (found / hidden - 1.0)),
            self.sigma.map_or_else(String::new, |s| format!("{:.1}", (found - hidden).abs() / s)),
        ]
    }
}

/// Instruments: the worst trial or specimen each.
fn instruments(all: &Recovered) -> Vec<Vec<String>> {
    let row = |what: &str, value: f64, digits: usize, unit: &str| {
        [what, "worst", "", "", &format!("{value:.digits$} {unit}"), ""].map(str::to_owned).to_vec()
    };
    let named = |mut row: Vec<String>, of: &str| {
        row[1] = if of.is_empty() { row[1].clone() } else { of.to_owned() };
        row
    };
    let covered = |what: &str, [held, of]: [usize; 2]| {
        let share = format!("{:.1} %", 100.0 * held as f64 / of.max(1) as f64);
        [what, "all", &share, "95 %", "", ""].map(str::to_owned).to_vec()
    };
    let mut rows = vec![
        named(row("tracked pixels", all.track_rms_px, 3, "px"), &all.track_worst),
        row("displacements", all.marker_rms_mm, 4, "mm"),
        row("clock", all.clock_error_ms, 2, "ms"),
        row("focal length", all.focal_error_percent, 2, "%"),
        covered("pixels inside their 95 % ellipse", all.track_coverage),
        covered("displacements inside their 95 % ellipse", all.marker_coverage),
    ];
    rows.extend(all.load_cell_frequency_error_percent.map(|e| row("load cell's frequency", e, 2, "%")));
    rows.extend(all.wave_residual_mn.map(|e| row("residual standing wave", e, 2, "mN")));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_modulus_is_set_beside_the_hidden_one_with_sign_and_in_deviations() {
        let of = RecoveredSpecimen {
            name: "a".into(),
            body_e_pa: [0.19e6, 0.2e6],
            spine_e_pa: [3e9, 3e9],
            storage_ratio: Vec::new(),
            loss_factor: Vec::new(),
            added: None,
            drag: Some([16.0, 15.0]),
        };
        let rows = moduli(&of, Some(0.005e6), None);
        assert_eq!(rows[0][2..], ["0.1900", "0.2000", "-5.0 %", "2.0"]);
        assert_eq!(rows[1][5], "");
        let moving = moving(&of, &Sigma { drag: Some(0.5), ..Sigma::default() });
        assert_eq!((moving.len(), &moving[0][4][..], &moving[0][5][..]), (1, "6.7 %", "2.0"));
    }

    #[test]
    fn every_row_has_a_cell_a_column() {
        let all = Recovered { wave_residual_mn: Some(1.0), ..Recovered::default() };
        assert!(instruments(&all).iter().all(|row| row.len() == 6));
        assert_eq!(instruments(&all).len(), 7);
    }
}
