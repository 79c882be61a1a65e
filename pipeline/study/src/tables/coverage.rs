//! Table `coverage`: the share of true values inside stated intervals, by kind of quantity.

use optimize::coverage::HALF_WIDTHS;
use plot::Column;

use diagnostics::Result;
use records::subject::Study;
use records::{self, Coverage as Counted};
use workflow::record::Record;
use workflow::table::Table;

/// The table.
pub struct Coverage;

impl Table for Coverage {
    type Of = Study;
    type Needs = records::Calibration;
    const NAME: &'static str = "coverage";
    const CAPTION: &'static str = "share of true values inside their intervals, over specimens drawn at random";
    const VERSION: u32 = 1;

    fn is_made_for(study: &Study) -> bool {
        records::Calibration::is_made_for(study)
    }

    fn fill(calibration: Self::Needs) -> Result<plot::Table> {
        let stated = HALF_WIDTHS.map(|(share, _)| format!("in {:.0} %", 100.0 * share));
        let columns = vec![
            Column::text("quantity"),
            Column::numbers("estimates", ""),
            Column::numbers("σ, median", "%"),
            Column::numbers(&stated[0], "%"),
            Column::numbers("bounds", "%"),
            Column::numbers(&stated[1], "%"),
            Column::numbers("bounds", "%"),
            Column::numbers("mean error / σ", ""),
        ];
        let kinds = calibration.kinds.iter().cloned().chain([calibration.all()]);
        let table = plot::Table::new(columns, kinds.map(|kind| quantity_row(&kind, calibration.specimens)).collect())?;
        let note = format!(
            "{} specimens. Bounds (95 %) count the estimates of one specimen as one; errors are those of logarithms.",
            calibration.specimens
        );
        Ok(table.noted(&note))
    }
}

fn quantity_row(kind: &Counted, specimens: usize) -> Vec<String> {
    let mut cells = vec![kind.title.clone(), kind.errors.len().to_string()];
    cells.push(if kind.sigma.is_nan() { String::new() } else { format!("{:.1}", 100.0 * kind.sigma) });
    for (_, half) in HALF_WIDTHS {
        let (share, [low, high]) = kind.covered_share(half, specimens);
        cells.extend([format!("{:.0}", 100.0 * share), format!("{:.0} to {:.0}", 100.0 * low, 100.0 * high)]);
    }
    cells.push(format!("{:+.2}", kind.errors.iter().sum::<f64>() / kind.errors.len().max(1) as f64));
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_both_shares_with_their_bounds_and_the_mean_error() {
        let errors = vec![0.5, -0.5, 1.5, 0.5];
        let kind = Counted { name: "drag".into(), title: "drag".into(), errors, sigma: 0.1 };
        assert_eq!(quantity_row(&kind, 4), ["drag", "4", "10.0", "75", "30 to 95", "100", "51 to 100", "+0.50"]);
    }
}
