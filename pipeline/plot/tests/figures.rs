//! Invariants of every figure: equal bytes, resolution of coordinates, text as text, bounded size, least frame.

use plot::{
    Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Landscape, Mark, Marker, Paint, Panel, PlotError, SINGLE_COLUMN_MM,
    SVG_BYTES_LIMIT, Scene, View, palette,
};

fn wave(samples: u32) -> Vec<[f64; 2]> {
    let time = |i: u32| f64::from(i) * 2.0 / f64::from(samples);
    (0..samples).map(time).map(|t| [t, 8.0 * (12.0 * t).sin() + 0.4 * (900.0 * t).sin()]).collect()
}

fn curves(samples: u32) -> Axes {
    Axes::new(Axis::linear("time", "s"), Axis::linear("tip", "mm"))
        .with(Mark::line(wave(samples), palette::SIMULATED).labelled("simulated <&>"))
        .with(Mark::horizontal_line(0.0, palette::MUTED).dashed(Dash::Dashed))
}

fn landscape() -> Landscape {
    let axis: Vec<f64> = (0..9).map(|i| 0.1 * 1.2f64.powi(i)).collect();
    let values = (0..81).map(|k| 0.01 + f64::from((k % 9 - 4i32).pow(2) + (k / 9 - 4i32).pow(2))).collect();
    let (x, y) = (Axis::log("body", "MPa"), Axis::log("spine", "GPa"));
    Landscape::new((x, axis.clone()), (y, axis), values, Axis::log("loss", ""))
}

/// A wavy sheet of `cells` × `cells` × 2 triangles.
fn sheet(cells: u32) -> Scene {
    let height = |i: u32, j: u32| 0.002 * (f64::from(i * 7919 % 13) * 0.3 + f64::from(j * 104_729 % 17) * 0.2);
    let points =
        (0..=cells).flat_map(|j| (0..=cells).map(move |i| [f64::from(i) * 1e-3, f64::from(j) * 1e-3, height(i, j)]));
    let at = |i: u32, j: u32| j * (cells + 1) + i;
    let faces = (0..cells).flat_map(|j| (0..cells).map(move |i| (i, j)));
    let faces = faces
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]);
    let (points, faces): (Vec<_>, Vec<_>) = (points.collect(), faces.collect());
    Scene::new(View::CORNER).with_surface(&points, &faces, Paint::Solid(palette::BODY)).with_scale_bar(0.02)
}

fn figure() -> Figure {
    Figure::new(DOUBLE_COLUMN_MM)
        .row(50.0, [Panel::Axes(curves(500)).titled("200 mbar"), Panel::Landscape(landscape()).titled("search")])
        .row(40.0, [Panel::Scene(sheet(20))])
        .noted("virtual bench")
}

#[test]
fn the_same_figure_gives_the_same_bytes() {
    assert!(figure().svg().unwrap() == figure().svg().unwrap());
}

#[test]
fn coordinates_have_a_resolution_below_a_point_of_print() {
    let svg = Figure::new(SINGLE_COLUMN_MM).row(40.0, [Panel::Axes(curves(500))]).svg().unwrap();
    // 88 mm are 249.4 points, the viewBox counts twentieths
    assert!(svg.contains("viewBox=\"0 0 4989 "), "{}", &svg[..300]);
    let curve = svg.lines().filter(|l| l.starts_with("<polyline")).max_by_key(|l| l.len()).unwrap();
    let points = curve.split("points=\"").nth(1).unwrap();
    let across: Vec<i32> = points.split(' ').filter_map(|p| p.split(',').next()?.parse().ok()).collect();
    assert!(across.len() > 100 && across.iter().any(|x| x % 20 != 0));
}

#[test]
fn text_is_stored_as_text() {
    let svg = figure().svg().unwrap();
    for words in ["(a)", "(c)", "200 mbar", "tip (mm)", "body (MPa)", "virtual bench", "simulated &lt;&amp;&gt;"] {
        assert!(svg.contains(&format!("{words}</text>")), "{words} is missing");
    }
}

#[test]
fn the_first_font_family_is_helvetica() {
    assert!(figure().svg().unwrap().contains("font-family=\"Helvetica, Arial, "));
}

#[test]
fn a_figure_of_many_points_stays_below_the_limit() {
    // 20 000 rough triangles and 200 000 samples
    let svg = Figure::new(DOUBLE_COLUMN_MM)
        .row(60.0, [Panel::Scene(sheet(100)), Panel::Axes(curves(200_000))])
        .svg()
        .unwrap();
    assert!(svg.len() < SVG_BYTES_LIMIT, "{}", svg.len());
}

#[test]
fn a_panel_below_the_least_size_is_refused_with_its_number() {
    let narrow = Figure::new(SINGLE_COLUMN_MM).row(12.0, [Panel::Axes(curves(10))]).svg();
    assert!(matches!(narrow, Err(PlotError::TooSmall { panel: 1, .. })), "{narrow:?}");
}

#[test]
fn a_point_that_is_not_a_number_is_refused_by_its_label() {
    let bad = Mark::points(vec![[0.0, 1.0], [1.0, f64::NAN]], Marker::Disc, palette::BLACK).labelled("measured");
    let axes = Axes::new(Axis::linear("x", "").range(0.0, 1.0), Axis::linear("y", "").range(0.0, 1.0)).with(bad);
    let error = Figure::new(SINGLE_COLUMN_MM).row(40.0, [Panel::Axes(axes)]).svg().unwrap_err().to_string();
    assert!(error.starts_with("the mark `measured` has NaN as value 1"), "{error}");
}

#[test]
fn an_empty_figure_is_refused() {
    assert!(matches!(Figure::new(SINGLE_COLUMN_MM).svg(), Err(PlotError::Empty { .. })));
}

#[test]
fn the_width_is_stored_in_millimetres() {
    let svg = figure().svg().unwrap();
    assert!(svg.contains("width=\"181.00mm\""), "{}", &svg[..200.min(svg.len())]);
}
