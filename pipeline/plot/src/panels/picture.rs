//! Pictures: a grey frame of a video, with marks in pixel coordinates over it.

use si::Point2;

use crate::axis::Scale;
use crate::canvas::{Area, Canvas, Item, TextItem};
use crate::frame::SMALL;
use crate::mark::Mark;
use crate::mark_painter::PlotArea;
use crate::panel::{Draw, LegendPlacement, Margins};
use crate::raster::grey_png;
use crate::ruler::Ruler;
use crate::{PlotError, palette};

/// A grey picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Pixels in a column.
    pub height: usize,
    /// height × width, rows from the top, 0 black to 255 white.
    pub grey: Vec<u8>,
    /// Marks over the picture, in pixels from the left upper corner, y downwards; the centre of a pixel is at half numbers.
    pub marks: Vec<Mark>,
    /// A scale bar: its length in pixels and its text.
    pub scale_bar: Option<(f64, String)>,
}

/// Most pixels in a point of print (216 an inch); finer pictures are averaged down.
const PIXELS_PER_POINT: f64 = 3.0;

impl Picture {
    /// A grey picture: height × width, rows from the top.
    pub fn new(width: usize, height: usize, grey: Vec<u8>) -> Self {
        Self { width, height, grey, marks: Vec::new(), scale_bar: None }
    }

    /// The same picture with one more mark, in pixels.
    pub fn with(mut self, mark: Mark) -> Self {
        self.marks.push(mark);
        self
    }

    /// The same picture with a scale bar: its length in pixels and its text.
    pub fn with_scale_bar(self, pixels: f64, text: &str) -> Self {
        Self { scale_bar: Some((pixels, text.to_owned())), ..self }
    }

    /// The largest rectangle with the picture's aspect ratio in the middle of a cell.
    fn fitted_area(&self, cell: Area) -> Area {
        let size: Point2 = [self.width as f64, self.height as f64];
        let zoom = (cell.width() / size[0]).min(cell.height() / size[1]);
        let half = size.map(|v| 0.5 * zoom * v);
        let [x, y] = cell.centre();
        Area { from: [x - half[0], y - half[1]], to: [x + half[0], y + half[1]] }
    }

    /// The picture with blocks of `block` × `block` pixels averaged (pixels beyond the last whole block are left out).
    fn block_averages(&self, block: usize) -> (usize, usize, Vec<u8>) {
        let (width, height) = (self.width / block, self.height / block);
        let mean = |k: usize| {
            let (row, column) = (k / width * block, k % width * block);
            let pixels = (0..block * block).map(|i| (row + i / block) * self.width + column + i % block);
            let sum: usize = pixels.map(|i| usize::from(self.grey[i])).sum();
            ((sum + block * block / 2) / (block * block)) as u8
        };
        (width, height, (0..width * height).map(mean).collect())
    }

    fn draw_scale_bar(&self, canvas: &mut Canvas, area: Area) {
        let Some((pixels, text)) = &self.scale_bar else { return };
        let length = pixels / self.width as f64 * area.width();
        let (from, y) = (area.from[0] + 5.0, area.to[1] - 6.0);
        let label = Area::new([from - 2.5, y - 11.5], [length.max(22.0) + 5.0, 15.0]);
        canvas.fill_area(label, palette::PAPER, 0.8);
        canvas.draw_segment([from, y], [from + length, y], 1.4, palette::BLACK);
        canvas.draw_text(TextItem::new([from + 0.5 * length.max(22.0), y - 5.5], text, SMALL));
    }
}

impl Draw for Picture {
    fn check_content(&self) -> Result<(), PlotError> {
        let (found, expected) = (self.grey.len(), self.width * self.height);
        match expected {
            0 => Err(PlotError::Empty { what: "a picture" }),
            _ if found != expected => Err(PlotError::Length { what: "a picture".to_owned(), found, expected }),
            _ => self.marks.iter().try_for_each(Mark::check),
        }
    }

    fn frame_margins(&self, _cell: Area, _legend: LegendPlacement) -> Result<Option<Margins>, PlotError> {
        Ok(None)
    }

    fn draw_panel(&self, canvas: &mut Canvas, cell: Area, _legend: LegendPlacement) -> Result<(), PlotError> {
        let area = self.fitted_area(cell);
        let block = (self.width as f64 / (area.width() * PIXELS_PER_POINT)).floor().max(1.0) as usize;
        let (width, height, grey) = self.block_averages(block);
        canvas.items.push(Item::Picture { area, png: grey_png(&grey, width, height)? });
        let ruler = |extent: usize, k: usize| Ruler {
            scale: Scale::Linear,
            ends: (0.0, extent as f64),
            places: (area.from[k], area.to[k]),
        };
        let plot_area = PlotArea { x: ruler(self.width, 0), y: ruler(self.height, 1), frame: area };
        self.marks.iter().for_each(|mark| plot_area.draw_mark(canvas, mark));
        self.draw_scale_bar(canvas, area);
        canvas.draw_outline(area, 0.5, palette::BLACK);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_averaged() {
        let picture = Picture::new(4, 2, vec![0, 100, 10, 10, 100, 200, 10, 10]);
        assert_eq!(picture.block_averages(2), (2, 1, vec![100, 10]));
    }

    #[test]
    fn a_picture_keeps_its_aspect_ratio_in_any_cell() {
        let picture = Picture::new(200, 100, vec![0; 20_000]);
        let area = picture.fitted_area(Area::new([0.0; 2], [50.0, 300.0]));
        assert!((area.width() - 50.0).abs() < 1e-12 && (area.height() - 25.0).abs() < 1e-12);
        let low = picture.fitted_area(Area::new([10.0, 20.0], [400.0, 10.0]));
        let expected = Area { from: [200.0, 20.0], to: [220.0, 30.0] };
        assert!((0..2).all(|k| (low.from[k] - expected.from[k]).abs() + (low.to[k] - expected.to[k]).abs() < 1e-12));
    }
}
