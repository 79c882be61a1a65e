//! Figure `calibration`: whether stated intervals are honest, over specimens drawn at random.
//!
//! (a) the share of true values inside central intervals of every stated probability, by kind of quantity, beside the line of honest
//! intervals and the band in which it lies for this number of specimens; (b) ranks of the true values, which are even for honest intervals.

use optimize::coverage::{rank_histogram, share_bounds, share_by_probability};
use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Mark, Panel, palette};

use crate::records::{self, Coverage};
use crate::subject::Study;
use diagnostics::Result;
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

    fn draw(found: Self::Needs) -> Result<Figure> {
        let note = format!("{} specimens of the virtual bench; nothing was measured.", found.specimens);
        let row = [shares(&found).titled("coverage"), ranks(&found.all()).titled("ranks of the true values")];
        Ok(Figure::new(DOUBLE_COLUMN_MM).row(62.0, row).noted(&note))
    }
}

/// Observed over stated probability.
fn shares(found: &records::Calibration) -> Panel {
    let stated: Vec<f64> = (0..POINTS).map(|i| i as f64 / (POINTS - 1) as f64).collect();
    let bounds: Vec<[f64; 2]> = stated.iter().map(|p| share_bounds(*p, found.specimens)).collect();
    let mut axes = Axes::new(Axis::linear("stated probability", ""), Axis::linear("share inside", ""))
        .with(Mark::band(
            stated.clone(),
            bounds.iter().map(|b| b[0]).collect(),
            bounds.iter().map(|b| b[1]).collect(),
            palette::MUTED,
        ))
        .with(Mark::line(vec![[0.0, 0.0], [1.0, 1.0]], palette::MUTED).dashed(Dash::Dashed));
    for (i, kind) in found.kinds.iter().enumerate() {
        axes = axes.with(Mark::line(share_by_probability(&kind.errors), palette::series(i)).labelled(&kind.title));
    }
    Panel::Axes(axes)
}

/// Histogram of the ranks.
fn ranks(all: &Coverage) -> Panel {
    let counts = rank_histogram(&all.errors, BINS);
    let even = all.errors.len() as f64 / BINS as f64;
    let width = 1.0 / BINS as f64;
    let bar = |(i, count): (usize, &usize)| {
        let (left, right, top) = (i as f64 * width, (i + 1) as f64 * width, *count as f64);
        Mark::area(vec![[left, 0.0], [left, top], [right, top], [right, 0.0]], palette::SIMULATED).with_opacity(0.5)
    };
    let axes = Axes::new(Axis::linear("rank of the true value", ""), Axis::linear("estimates", ""));
    let axes = counts.iter().enumerate().map(bar).fold(axes, Axes::with);
    Panel::Axes(axes.with(Mark::horizontal_line(even, palette::MUTED).dashed(Dash::Dashed)))
}
