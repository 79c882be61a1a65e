//! Landscapes: a heat map over two parameters with contours, and the paths of optimisers over it.
//!
//! The map is one embedded picture as large as the frame. Cells drawn as polygons would show seams between them,
//! because viewers anti-alias each edge.

use si::Point2;

use crate::canvas::{Area, Canvas, Item};
use crate::contour::Field;
use crate::frame::{AxisRange, Frame};
use crate::mark::{Dash, Mark, Side};
use crate::panel::{Draw, LegendPlacement, Margins};
use crate::panels::colour_bar::{Bar, ColourBar};
use crate::raster::Raster;
use crate::{Axis, Colour, Marker, PlotError, legend, palette};

/// How the heat map fills the space between grid points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shading {
    /// Linear between grid points, on the scale of the colour bar.
    #[default]
    Smooth,
    /// One cell of constant colour around each grid point.
    Cells,
}

/// A heat map with contours.
#[derive(Debug, Clone, PartialEq)]
pub struct Landscape {
    /// Horizontal axis; its range is that of the columns.
    pub x: Axis,
    /// Vertical axis; its range is that of the rows.
    pub y: Axis,
    /// x of the grid's columns, increasing, evenly spaced on the axis' scale.
    pub columns: Vec<f64>,
    /// y of the grid's rows, increasing, evenly spaced on the axis' scale.
    pub rows: Vec<f64>,
    /// rows × columns; NaN or infinite where there is no value.
    pub values: Vec<f64>,
    /// What the colours mean.
    pub bar: ColourBar,
    /// How the space between grid points is filled.
    pub shading: Shading,
    /// Whether lines of equal value are drawn at the bar's numbers.
    pub contours: bool,
    /// Marks over the map; labelled marks are listed over the frame.
    pub marks: Vec<Mark>,
}

/// Pixels of the heat map in a point of print: 216 an inch.
const PIXELS_PER_POINT: f64 = 3.0;
/// Least resolution of the grid for contours. The shading is bilinear between grid points; marching squares on the
/// coarse grid would replace its curved level lines by straight segments.
const FINE_COLUMNS: usize = 120;

impl Landscape {
    /// A heat map with smooth shading and contours, from both axes with the grid on each, and values (rows × columns).
    pub fn new((x, columns): (Axis, Vec<f64>), (y, rows): (Axis, Vec<f64>), values: Vec<f64>, bar: ColourBar) -> Self {
        Self { x, y, columns, rows, values, bar, shading: Shading::Smooth, contours: true, marks: Vec::new() }
    }

    /// The same landscape with one more mark.
    pub fn with(mut self, mark: Mark) -> Self {
        self.marks.push(mark);
        self
    }

    /// The path of an optimiser: a line with a dark outline, a small disc at each iterate and a large one at the start.
    pub fn with_path(self, points: Vec<Point2>, colour: Colour, label: &str) -> Self {
        let start = points.first().copied().into_iter().collect();
        let outline = Mark::line(points.clone(), palette::BLACK).sized(2.2);
        let line = Mark::line(points.clone(), colour).sized(1.3).labelled(label);
        let steps = Mark::points(points, Marker::Disc, colour).sized(2.6);
        let begin = Mark::points(start, Marker::Disc, palette::BLACK).sized(6.4);
        let inner = Mark { colour, size: 4.6, ..begin.clone() };
        self.with(outline).with(line).with(steps).with(begin).with(inner)
    }

    /// Lines on which other `values` (rows × columns, NaN where there is none) are equal to `value`, with `text` beside the beginning of the first.
    pub fn with_isoline(self, values: Vec<f64>, value: f64, text: &str, colour: Colour) -> Self {
        let field = Field { columns: self.columns.len(), rows: self.rows.len(), values };
        let lines: Vec<Vec<Point2>> =
            field.contour_lines(value).iter().map(|line| line.iter().map(|p| self.grid_value(*p)).collect()).collect();
        // the middle is where iterates are
        let label_point = lines.first().and_then(|line| line.get(line.len() / 5)).copied();
        let named = |at| Mark::text(at, text, Side::Right, colour).sized(6.0);
        let drawn = lines.into_iter().map(|line| Mark::line(line, colour).sized(1.0).dashed(Dash::Dashed));
        drawn.chain(label_point.map(named)).fold(self, Landscape::with)
    }

    /// Extent of a cell beyond its grid point, in grid steps.
    fn half_cell(&self) -> f64 {
        if self.shading == Shading::Cells { 0.5 } else { 0.0 }
    }

    /// Both ends of an axis: those that were set, or those of the grid (with half a cell around it).
    fn axis_ends(&self, axis: &Axis, grid: &[f64]) -> Result<(f64, f64), PlotError> {
        let (low, high) = axis.shown_ends(grid.iter().copied(), 0.0)?;
        let (a, b) = (axis.scale.to_linear(low), axis.scale.to_linear(high));
        let half = self.half_cell() * (b - a) / (grid.len() - 1) as f64;
        Ok(if axis.range.is_some() {
            (low, high)
        } else {
            (axis.scale.value_of(a - half), axis.scale.value_of(b + half))
        })
    }

    fn grid_frame(&self, area: Area) -> Result<Frame<'_>, PlotError> {
        let x = AxisRange { axis: &self.x, ends: self.axis_ends(&self.x, &self.columns)? };
        let y = AxisRange { axis: &self.y, ends: self.axis_ends(&self.y, &self.rows)? };
        Ok(Frame::new(area, x, y))
    }

    fn colour_bar(&self) -> Result<Bar<'_>, PlotError> {
        Bar::new(&self.bar, self.values.iter().copied())
    }

    /// The values on the grid, as fractions of the colour bar's range.
    fn fraction_field(&self, bar: &Bar) -> Field {
        let part = |v: &f64| if v.is_finite() { bar.fraction_of(*v) } else { f64::NAN };
        Field { columns: self.columns.len(), rows: self.rows.len(), values: self.values.iter().map(part).collect() }
    }

    /// The picture: one colour for each pixel of the frame.
    fn render_picture(&self, frame: &Frame, field: &Field) -> Raster {
        let area = frame.plot_area.frame;
        let size = [area.width(), area.height()].map(|v| (v * PIXELS_PER_POINT).round().max(1.0) as usize);
        let mut pixels = Vec::with_capacity(size[0] * size[1] * 4);
        for row in 0..size[1] {
            for column in 0..size[0] {
                let page_coordinate = |k: usize, index: usize| {
                    area.from[k] + (index as f64 + 0.5) / size[k] as f64 * (area.to[k] - area.from[k])
                };
                let part = self
                    .shaded_value(field, self.grid_place(frame, [page_coordinate(0, column), page_coordinate(1, row)]));
                let colour = if part.is_nan() { palette::MISSING } else { palette::heat(part) };
                pixels.extend([colour.0, colour.1, colour.2, 255]);
            }
        }
        Raster { width: size[0], height: size[1], pixels }
    }

    fn shaded_value(&self, field: &Field, p: Point2) -> f64 {
        let p = match self.shading {
            Shading::Smooth => p,
            Shading::Cells => p.map(f64::round),
        };
        let largest_index = [(field.columns - 1) as f64, (field.rows - 1) as f64];
        field.interpolate([p[0].clamp(0.0, largest_index[0]), p[1].clamp(0.0, largest_index[1])])
    }

    /// A point of the page as [column, row] of the grid.
    fn grid_place(&self, frame: &Frame, p: Point2) -> Point2 {
        let grid_coordinate = |axis: &Axis, grid: &[f64], value: f64| {
            let (a, b) = (axis.scale.to_linear(grid[0]), axis.scale.to_linear(grid[grid.len() - 1]));
            (axis.scale.to_linear(value) - a) / (b - a) * (grid.len() - 1) as f64
        };
        let (x, y) = (frame.plot_area.x.value_at(p[0]), frame.plot_area.y.value_at(p[1]));
        [grid_coordinate(&self.x, &self.columns, x), grid_coordinate(&self.y, &self.rows, y)]
    }

    /// [column, row] of the grid in the units of the axes.
    fn grid_value(&self, p: Point2) -> Point2 {
        let axis_value = |axis: &Axis, grid: &[f64], place: f64| {
            let (a, b) = (axis.scale.to_linear(grid[0]), axis.scale.to_linear(grid[grid.len() - 1]));
            axis.scale.value_of(a + place / (grid.len() - 1) as f64 * (b - a))
        };
        [axis_value(&self.x, &self.columns, p[0]), axis_value(&self.y, &self.rows, p[1])]
    }

    fn draw_contours(&self, canvas: &mut Canvas, frame: &Frame, bar: &Bar, field: &Field) {
        let times = FINE_COLUMNS.div_ceil(self.columns.len().max(self.rows.len()));
        let fine = field.refined_field(times);
        for level in bar.contour_levels(frame.plot_area.frame.height()) {
            for line in fine.contour_lines(bar.fraction_of(level)) {
                let points = line.iter().map(|p| self.grid_value(p.map(|v| v / times as f64))).collect();
                let mark = Mark::line(points, palette::PAPER).sized(0.45).with_opacity(0.75);
                frame.plot_area.draw_mark(canvas, &mark);
            }
        }
    }

    fn check_grid(&self, axis: &Axis, grid: &[f64]) -> Result<(), PlotError> {
        let even: Vec<f64> = grid.iter().map(|v| axis.scale.to_linear(*v)).collect();
        let step = (even[even.len() - 1] - even[0]) / (even.len() - 1) as f64;
        let deviation = |i: usize| (even[i] - even[0] - i as f64 * step).abs();
        let uneven = |i: &usize| deviation(*i).is_nan() || deviation(*i) > 1e-6 * step;
        match (0..even.len()).find(uneven) {
            Some(index) => {
                let what = format!("the grid on `{}`, which must rise evenly,", axis.label);
                Err(PlotError::NotFinite { what, index, value: grid[index] })
            }
            None => Ok(()),
        }
    }
}

impl Draw for Landscape {
    fn check_content(&self) -> Result<(), PlotError> {
        if self.columns.len() < 2 || self.rows.len() < 2 {
            return Err(PlotError::Empty { what: "the grid of a landscape" });
        }
        let (found, expected) = (self.values.len(), self.columns.len() * self.rows.len());
        if found != expected {
            return Err(PlotError::Length { what: "the values of a landscape".to_owned(), found, expected });
        }
        let frame = self.grid_frame(Area::new([0.0; 2], [100.0; 2]))?;
        self.colour_bar()?;
        self.check_grid(&self.x, &self.columns)?;
        self.check_grid(&self.y, &self.rows)?;
        self.marks.iter().try_for_each(|mark| frame.plot_area.check_mark(mark))
    }

    fn frame_margins(&self, cell: Area, place: LegendPlacement) -> Result<Option<Margins>, PlotError> {
        let mut margins = self.grid_frame(cell)?.label_margins();
        let height = cell.height() - margins.top - margins.bottom;
        margins.beyond = self.colour_bar()?.total_width(height.max(1.0));
        let width = cell.width() - margins.left - margins.right - margins.beyond;
        if place == LegendPlacement::Over {
            margins.top += legend::height_over(&legend::listed_marks(&self.marks), width);
        }
        Ok(Some(margins))
    }

    fn legend_fits(&self, _frame: Area) -> Result<bool, PlotError> {
        Ok(legend::listed_marks(&self.marks).is_empty()) // a heat map has no free corner
    }

    fn draw_panel(&self, canvas: &mut Canvas, area: Area, _place: LegendPlacement) -> Result<(), PlotError> {
        let (frame, bar) = (self.grid_frame(area)?, self.colour_bar()?);
        let field = self.fraction_field(&bar);
        canvas.items.push(Item::Picture { area, png: self.render_picture(&frame, &field).to_png()? });
        if self.contours && self.shading == Shading::Smooth {
            self.draw_contours(canvas, &frame, &bar, &field);
        }
        self.marks.iter().for_each(|mark| frame.plot_area.draw_mark(canvas, mark));
        frame.draw_frame(canvas);
        bar.draw_bar(canvas, area)?;
        legend::draw_over(canvas, &legend::listed_marks(&self.marks), area);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELL: Area = Area { from: [30.0, 10.0], to: [150.0, 90.0] };

    /// Loss |x − 2| + |y − 20| over x 1, 2, 3 and y 10, 20.
    fn three_by_two(shading: Shading) -> Landscape {
        let (x, y, bar) = (Axis::linear("x", "m"), Axis::linear("y", "s"), Axis::linear("loss", ""));
        let values = vec![11.0, 10.0, 11.0, 1.0, 0.0, 1.0];
        Landscape { shading, ..Landscape::new((x, vec![1.0, 2.0, 3.0]), (y, vec![10.0, 20.0]), values, bar) }
    }

    fn picture(landscape: &Landscape) -> Raster {
        let frame = landscape.grid_frame(CELL).unwrap();
        landscape.render_picture(&frame, &landscape.fraction_field(&landscape.colour_bar().unwrap()))
    }

    #[test]
    fn a_path_begins_with_a_disc_of_its_colour_in_a_dark_rim() {
        let (landscape, red) = (three_by_two(Shading::Cells), Colour(200, 0, 0));
        let marks = landscape.with_path(vec![[1.0, 10.0], [2.0, 20.0]], red, "path").marks;
        let [.., rim, disc] = &marks[..] else { panic!("{} marks", marks.len()) };
        assert!(rim.colour == palette::BLACK && disc.colour == red && disc.size < rim.size);
        assert_eq!((disc.all_x(), disc.all_y()), (vec![1.0], vec![10.0]));
    }

    #[test]
    fn an_isoline_crosses_the_grid_where_other_values_reach_its_own() {
        let other = vec![1.0, 2.0, 3.0, 2.0, 3.0, f64::NAN];
        let marks = three_by_two(Shading::Smooth).with_isoline(other, 2.5, "2.5", palette::BLACK).marks;
        let [line, name] = &marks[..] else { panic!("{} marks", marks.len()) };
        let ends = |of: &Mark| (of.all_x(), of.all_y());
        let (x, y) = ends(line);
        assert!(x.len() == 2 && x.iter().zip(&y).all(|(x, y)| (x + 0.1 * y - 3.5).abs() < 1e-12), "{x:?} {y:?}");
        assert_eq!(ends(name).0.len(), 1);
        assert!(three_by_two(Shading::Smooth).with_isoline(vec![0.0; 6], 1.0, "", palette::BLACK).marks.is_empty());
    }

    #[test]
    fn cells_of_a_heat_map_leave_no_gap() {
        let picture = picture(&three_by_two(Shading::Cells));
        let colours = [11.0, 10.0, 1.0, 0.0].map(|v| palette::heat(v / 11.0));
        for pixel in picture.pixels.chunks(4) {
            assert!(pixel[3] == 255 && colours.contains(&Colour(pixel[0], pixel[1], pixel[2])), "{pixel:?}");
        }
    }

    #[test]
    fn the_picture_of_a_heat_map_fills_its_frame() {
        let mut canvas = Canvas::default();
        three_by_two(Shading::Smooth).draw_panel(&mut canvas, CELL, LegendPlacement::Over).unwrap();
        assert!(matches!(&canvas.items[0], Item::Picture { area, .. } if *area == CELL));
    }

    #[test]
    fn the_first_row_of_values_lies_at_the_bottom() {
        let picture = picture(&three_by_two(Shading::Cells));
        let last = picture.pixels.len() - 4;
        let (top, bottom) = (palette::heat(1.0 / 11.0), palette::heat(1.0));
        assert_eq!(picture.pixels[..3], [top.0, top.1, top.2]);
        assert_eq!(picture.pixels[last..last + 3], [bottom.0, bottom.1, bottom.2]);
    }

    #[test]
    fn a_grid_that_is_not_even_is_refused() {
        let mut landscape = three_by_two(Shading::Smooth);
        landscape.columns[1] = 2.2;
        assert!(landscape.check_content().unwrap_err().to_string().contains("rise evenly"));
    }

    #[test]
    fn grid_place_is_the_inverse_of_grid_value() {
        let landscape = three_by_two(Shading::Smooth);
        let frame = landscape.grid_frame(CELL).unwrap();
        let value = landscape.grid_value([0.7, 0.4]);
        let back =
            landscape.grid_place(&frame, [frame.plot_area.x.place_of(value[0]), frame.plot_area.y.place_of(value[1])]);
        assert!((back[0] - 0.7).abs() < 1e-12 && (back[1] - 0.4).abs() < 1e-12);
    }
}
