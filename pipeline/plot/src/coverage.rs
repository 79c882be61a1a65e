//! Coverage: whether a rectangle covers anything that is drawn.

use si::Point2;

use crate::canvas::{Area, Canvas, Item};
use crate::clip;

impl Canvas {
    /// Whether a rectangle touches anything drawn, line widths included.
    pub(crate) fn touches_area(&self, area: &Area) -> bool {
        self.items.iter().any(|item| item_touches(item, area))
    }
}

fn item_touches(item: &Item, area: &Area) -> bool {
    match item {
        Item::Path { points, width, .. } => line_crosses(points, &area.grown(0.5 * width)),
        Item::Polygon { points, .. } => {
            let closed = [&points[..], &points[..points.len().min(1)]].concat();
            line_crosses(&closed, area) || polygon_encloses(points, area.centre())
        }
        Item::Disc { at, radius, .. } => area.grown(*radius).contains(*at),
        Item::Text(text) => text.text_area().intersects(area),
        Item::Picture { area: picture, .. } => picture.intersects(area),
    }
}

fn line_crosses(points: &[Point2], area: &Area) -> bool {
    points.iter().any(|p| area.contains(*p))
        || points.windows(2).any(|s| clip::clip_segment(s[0], s[1], area).is_some())
}

/// Whether a point lies inside of a polygon (even-odd rule).
fn polygon_encloses(points: &[Point2], p: Point2) -> bool {
    let mut inside = false;
    for i in 0..points.len() {
        let (a, b) = (points[i], points[(i + 1) % points.len()]);
        if (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
            inside = !inside;
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Colour, Dash};

    const BLACK: Colour = Colour(0, 0, 0);
    const BOX: Area = Area { from: [4.0, 4.0], to: [6.0, 6.0] };

    #[test]
    fn a_line_that_crosses_between_its_points_is_found() {
        let mut canvas = Canvas::default();
        canvas.draw_path(vec![[0.0, 0.0], [10.0, 10.0]], 1.0, Dash::Solid, BLACK);
        assert!(canvas.touches_area(&BOX));
    }

    #[test]
    fn a_line_beside_is_found_when_it_is_wide_enough() {
        let mut canvas = Canvas::default();
        canvas.draw_path(vec![[0.0, 7.0], [10.0, 7.0]], 1.0, Dash::Solid, BLACK);
        assert!(!canvas.touches_area(&BOX));
        canvas.draw_path(vec![[0.0, 7.0], [10.0, 7.0]], 2.5, Dash::Solid, BLACK);
        assert!(canvas.touches_area(&BOX));
    }

    #[test]
    fn a_polygon_around_the_rectangle_is_found_although_no_edge_is_near() {
        let mut canvas = Canvas::default();
        canvas.fill_area(Area { from: [0.0, 0.0], to: [10.0, 10.0] }, BLACK, 0.2);
        assert!(canvas.touches_area(&BOX));
    }
}
