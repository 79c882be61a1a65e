//! Figure `calibration`: whether stated intervals are honest, over specimens drawn at random.
//!
//! (a) the share of true values inside central intervals of every stated probability, by kind of quantity, beside the line of honest
//! intervals and the band in which it lies for this number of specimens; (b) ranks of the true values, which are even for honest intervals.

use optimize::coverage::{rank_histogram, share_bounds, share_by_probability};
use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Mark, Panel, palette};

use diagnostics::Result;
use records::subject::Study;
use records::{self, Coverage};
use workflow::figure;
use workflow::record::Record;

/// The figure.
pub struct Calibration;

const POINTS: usize = 51;
/// Bins of the ranks.
const BINS: usize = 10;

impl figure::Figure for Calibration {
    type Of = Study;
    type Needs = records::Calibration;
    const NAME: &'static str = "calibration";
    const CAPTION: &'static str = "shares of true values inside stated intervals, and their ranks";
    const VERSION: u32 = 1;

    fn is_made_for(study: &Study) -> bool {
        records::Calibration::is_made_for(study)
    }

    fn draw(calibration: Self::Needs) -> Result<Figure> {
        let note = format!("{} specimens of the virtual bench; nothing was measured.", calibration.specimens);
        let row = [
            coverage_panel(&calibration).titled("coverage"),
            rank_panel(&calibration.all()).titled("ranks of the true values"),
        ];
        Ok(Figure::new(DOUBLE_COLUMN_MM).row(62.0, row).noted(&note))
    }
}

/// Observed over stated probability.
fn coverage_panel(calibration: &records::Calibration) -> Panel {
    let stated: Vec<f64> = (0..POINTS).map(|i| i as f64 / (POINTS - 1) as f64).collect();
    let bounds: Vec<[f64; 2]> = stated.iter().map(|p| share_bounds(*p, calibration.specimens)).collect();
    let mut axes = Axes::new(Axis::linear("stated probability", ""), Axis::linear("share inside", ""))
        .with(Mark::band(
            stated.clone(),
            bounds.iter().map(|b| b[0]).collect(),
            bounds.iter().map(|b| b[1]).collect(),
            palette::MUTED,
        ))
        .with(Mark::line(vec![[0.0, 0.0], [1.0, 1.0]], palette::MUTED).dashed(Dash::Dashed));
    for (i, kind) in calibration.kinds.iter().enumerate() {
        axes = axes.with(Mark::line(share_by_probability(&kind.errors), palette::series(i)).labelled(&kind.title));
    }
    Panel::Axes(axes)
}

/// Histogram of the ranks.
fn rank_panel(coverage: &Coverage) -> Panel {
    let counts = rank_histogram(&coverage.errors, BINS);
    let even = coverage.errors.len() as f64 / BINS as f64;
    let width = 1.0 / BINS as f64;
    let bar = |(i, count): (usize, &usize)| {
        let (left, right, top) = (i as f64 * width, (i + 1) as f64 * width, *count as f64);
        Mark::area(vec![[left, 0.0], [left, top], [right, top], [right, 0.0]], palette::SIMULATED).with_opacity(0.5)
    };
    let axes = Axes::new(Axis::linear("rank of the true value", ""), Axis::linear("estimates", ""));
    let axes = counts.iter().enumerate().map(bar).fold(axes, Axes::with);
    Panel::Axes(axes.with(Mark::horizontal_line(even, palette::MUTED).dashed(Dash::Dashed)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ranks_are_bars_side_by_side_over_the_share_of_even_ones() {
        // errors of one deviation below, at and above the truth: ranks in different bars
        let errors: Vec<f64> = (0..40).map(|i| f64::from(i) / 10.0 - 2.0).collect();
        let all = Coverage { name: "all".into(), title: "all".into(), errors: errors.clone(), sigma: 1.0 };
        let Panel::Axes(axes) = rank_panel(&all) else { panic!("no axes") };
        let text = format!("{axes:?}");
        let counts = rank_histogram(&errors, BINS);
        assert_eq!(counts.iter().sum::<usize>(), 40);
        assert!(text.contains(&format!("{:?}", 40.0 / BINS as f64)), "{text}");
        let width = 1.0 / BINS as f64;
        for (i, count) in counts.iter().enumerate() {
            let (left, right) = (i as f64 * width, (i + 1) as f64 * width);
            let bar = format!("{:?}", vec![[left, 0.0], [left, *count as f64], [right, *count as f64], [right, 0.0]]);
            assert!(text.contains(&bar), "{bar}");
        }
    }
}
