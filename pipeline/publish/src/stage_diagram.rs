//! The stage graph as a diagram: one box a stage, one arrow for each record that is not read through another stage.

use plot::{Colour, Dash, Diagram, Part, palette};
use si::Point2;
use workflow::stage_graph::{Place, StageGraph, lay_out};

/// Sides of a box, and the space beside it, mm.
const BOX: Point2 = [24.4, 30.0];
const APART: Point2 = [2.6, 2.4];
/// Height of a recording's box, mm.
const SOURCE: f64 = 13.0;

/// The graph as a diagram; `said` may say something else than a stage's story.
pub(crate) fn stage_diagram(graph: &StageGraph, text: &dyn Fn(&str) -> Option<String>) -> Diagram {
    let direct = graph.direct_inputs();
    let layout = lay_out(&direct, graph.recordings);
    let pitch = [BOX[0] + APART[0], BOX[1] + APART[1]];
    let size = [layout.columns as f64 * pitch[0] - APART[0] + 1.0, layout.height * pitch[1]];
    let box_centre = |p: &Place| [0.5 + 0.5 * BOX[0] + p.column as f64 * pitch[0], 0.5 * size[1] - p.down * pitch[1]];
    let mut diagram = Diagram::new(size[0], size[1]);
    for (from, to, between) in &layout.lines {
        let (start, end) = (box_centre(&layout.nodes[*from]), box_centre(&layout.nodes[*to]));
        let waypoints =
            between.iter().map(box_centre).flat_map(|[x, y]| [[x - 0.5 * BOX[0], y], [x + 0.5 * BOX[0], y]]);
        let ends = ([start[0] + 0.5 * BOX[0], start[1]], [end[0] - 0.5 * BOX[0], end[1]]);
        let points = std::iter::once(ends.0).chain(waypoints).chain([ends.1]).collect();
        diagram = diagram.with(Part::Arrow { points, text: None, colour: palette::MUTED, dash: Dash::Solid });
    }
    for (i, node) in graph.nodes.iter().enumerate() {
        let text = text(&node.name).unwrap_or_else(|| node.description.clone());
        let title = node.name.replace('_', " ");
        let height = if i < graph.recordings { SOURCE } else { BOX[1] };
        let (at, size, fill) = (box_centre(&layout.nodes[i]), [BOX[0], height], fill_colour(graph, i));
        diagram = diagram.with(Part::Card { at, size, title, text, fill });
    }
    diagram
}

/// Recordings are grey, what ends the graph is green, all between is blue.
fn fill_colour(graph: &StageGraph, node: usize) -> Colour {
    let read = graph.nodes.iter().any(|r| r.reads.contains(&node));
    match (node < graph.recordings, read) {
        (true, _) => palette::FAINT,
        (false, true) => palette::BODY.towards(palette::PAPER, 0.72),
        (false, false) => palette::NETWORK.towards(palette::PAPER, 0.72),
    }
}
