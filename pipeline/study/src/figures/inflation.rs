//! Figure `inflation`: the section of a tail at mid height while one side is inflated and let off again, as frames that follow each other. It stands
//! on the project's front page, where the buckle of the slack wall is to be seen, not in the paper.

use plot::{Axes, Axis, Figure, Legend, Mark, Panel, SINGLE_COLUMN_MM, palette};
use si::{MILLIBAR, MILLIMETRE, Point2};

use super::order::{capitalised, in_order, record_of};
use super::{origin_note, tail};
use diagnostics::Result;
use records::subject::{Specimen, Study};
use records::{Inflation as Inflated, Mesh, Shape};
use sysid::surfaces::{Bounds, Surfaces};
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct Inflation;

/// How long it takes to be inflated and let off, s: the equilibria have no speed of their own.
const SECONDS: f64 = 5.0;
/// Frames for which the highest pressure is held.
const HELD: usize = 6;
/// Frames at most: more exceed what a figure may have.
const FRAMES: usize = 24;
/// Height of a frame, mm.
const HEIGHT: f64 = 62.0;

impl figure::Figure for Inflation {
    type Of = Study;
    type Needs = (Every<Mesh, Specimen>, Every<Inflated, Specimen>);
    const NAME: &'static str = "inflation";
    const CAPTION: &'static str = "the section of a tail while one side is inflated through the buckle of the other";
    const VERSION: u32 = 1;

    fn draw((Every(meshes), Every(inflations)): Self::Needs) -> Result<Figure> {
        let (meshes, inflations) = (in_order(meshes), in_order(inflations));
        let Some((specimen, inflation)) = inflations.first() else { return Err(tail::no_tail()) };
        let Some(mesh) = record_of(&meshes, &specimen.card.name) else { return Err(tail::no_tail()) };
        let shapes = evenly_chosen(&inflation.shapes);
        let sections: Vec<Section> = shapes.iter().map(|shape| Section::of(mesh, inflation, shape)).collect();
        let note = origin_note([specimen.card.as_ref()].into_iter());
        let frames = sections.iter().zip(&shapes).map(|(section, shape)| {
            let pressure = shape.pressure() / MILLIBAR;
            let title = format!(
                "{}, {pressure:.0} mbar in one side: equilibria of the identified model",
                capitalised(&specimen.card.name)
            );
            Figure::new(SINGLE_COLUMN_MM).row(HEIGHT, [section.panel(&sections).titled(&title)]).noted(&note)
        });
        Ok(Figure::animated(frames.collect(), there_and_back(shapes.len()), SECONDS))
    }
}

/// Shapes at like distances among all, the last one among them.
fn evenly_chosen(shapes: &[Shape]) -> Vec<&Shape> {
    let step = shapes.len().div_ceil(FRAMES).max(1);
    let mut chosen: Vec<&Shape> = shapes.iter().rev().step_by(step).collect();
    chosen.reverse();
    chosen
}

/// From the first frame to the last, which is held, and back.
fn there_and_back(count: usize) -> Vec<usize> {
    let last = count.saturating_sub(1);
    (0..last).chain(std::iter::repeat_n(last, HELD)).chain((0..last).rev()).collect()
}

/// The outlines of a section, mm.
struct Section {
    /// Of the body, with the chambers inside of it.
    body: Vec<Vec<Point2>>,
    sheet: Vec<Vec<Point2>>,
}

impl Section {
    fn of(mesh: &Mesh, inflation: &Inflated, shape: &Shape) -> Self {
        let lower = Surfaces::lower_half(&mesh.solid, &inflation.moved(mesh, shape));
        let outlines = |bounds: &[Bounds]| -> Vec<Vec<Point2>> {
            let in_millimetres = |outline: Vec<Point2>| outline.iter().map(|p| p.map(|x| x / MILLIMETRE)).collect();
            lower.outlines(bounds).into_iter().map(in_millimetres).collect()
        };
        Self { body: outlines(&[Bounds::CutBody, Bounds::CutSheet]), sheet: outlines(&[Bounds::CutSheet]) }
    }

    fn points(&self) -> impl Iterator<Item = &Point2> {
        self.body.iter().flatten()
    }

    /// The section in the frame of all of them.
    fn panel(&self, all: &[Self]) -> Panel {
        let ends = |k: usize| {
            let values = || all.iter().flat_map(Section::points).map(|p| p[k]);
            (values().fold(f64::INFINITY, f64::min) - 2.0, values().fold(f64::NEG_INFINITY, f64::max) + 2.0)
        };
        let axis = |name: &str, (low, high): (f64, f64)| Axis::linear(name, "mm").range(low, high);
        let mut axes = Axes::new(axis("x", ends(0)), axis("y", ends(1))).equal().legend(Legend::None);
        // the largest outline is the body's, those inside of it are its chambers
        for (index, outline) in self.body.iter().enumerate() {
            let bounds = if index == 0 { Bounds::CutBody } else { Bounds::Chamber(0) };
            axes = axes.with(Mark::area(outline.clone(), bounds.colour()));
        }
        let sheets = self.sheet.iter().map(|outline| Mark::area(outline.clone(), palette::SPINE));
        Panel::Axes(sheets.fold(axes, Axes::with))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_go_to_the_highest_pressure_and_back() {
        assert_eq!(there_and_back(3), [0, 1, 2, 2, 2, 2, 2, 2, 1, 0]);
        assert_eq!(there_and_back(1), [0; HELD]);
    }
}
