//! The gallery's figures, from synthetic data.

use std::f64::consts::TAU;

use plot::{
    Axes, Axis, Column, DOUBLE_COLUMN_MM, Dash, Diagram, Figure, Landscape, Legend, Mark, Marker, OverlayKind, Paint,
    Panel, Part, Picture, PlotError, SINGLE_COLUMN_MM, Scene, Side, Table, View, palette,
};

/// Every figure with its name.
pub fn all() -> Result<Vec<(&'static str, String)>, PlotError> {
    Ok(vec![
        ("curves", curves()?),
        ("search", search()?),
        ("thrust", thrust()?),
        ("mesh", mesh()?),
        ("diagram", diagram()?),
        ("picture", picture()?),
        ("table", table()?),
    ])
}

fn wave(frequency: f64, amplitude: f64, lag: f64) -> Vec<[f64; 2]> {
    let ripple = |t: f64| 0.15 * (TAU * 3.0 * frequency * t).sin();
    let at = |i: i32| f64::from(i) * 0.002;
    (0..1000).map(at).map(|t| [t, amplitude * ((TAU * frequency * t - lag).sin() + ripple(t))]).collect()
}

fn flapping(frequency: f64, amplitude: f64, labelled: bool) -> Axes {
    let (measured, simulated) = (wave(frequency, amplitude, 0.0), wave(frequency, 0.96 * amplitude, 0.15));
    let x: Vec<f64> = measured.iter().map(|p| p[0]).collect();
    let band = |by: f64| measured.iter().map(|p| p[1] + by * (1.0 + 0.5 * (9.0 * p[0]).sin())).collect::<Vec<_>>();
    let label = |mark: Mark, text: &str| if labelled { mark.labelled(text) } else { mark };
    Axes::new(Axis::linear("time", "s"), Axis::linear("tip displacement", "mm"))
        .with(label(Mark::band(x, band(-0.9), band(0.9), palette::MEASURED).with_opacity(0.2), "five trials"))
        .with(label(Mark::line(measured, palette::MEASURED), "measured"))
        .with(label(Mark::line(simulated, palette::SIMULATED).dashed(Dash::Dashed), "simulated"))
}

fn curves() -> Result<String, PlotError> {
    let titles =
        ["tail A, 200 mbar, 2 Hz", "tail A, 200 mbar, 4 Hz", "tail B, 500 mbar, 2 Hz", "tail C, 350 mbar, 2 Hz"];
    let panel = |i: usize| {
        let axes = flapping([2.0, 4.0, 2.0, 2.0][i], [8.0, 4.5, 10.0, 7.0][i], i == 0);
        Panel::Axes(axes).titled(titles[i])
    };
    Figure::new(DOUBLE_COLUMN_MM)
        .row(48.0, [panel(0), panel(1)])
        .row(48.0, [panel(2), panel(3)])
        .noted("virtual bench")
        .svg()
}

fn loss(body: f64, spine: f64) -> f64 {
    let (a, b) = ((body / 0.18).ln(), (spine / 3.1).ln());
    0.004 + 0.16 * (0.9 * a + 0.5 * b).abs() + 0.02 * (a - b).abs()
}

fn landscape() -> Landscape {
    let axis = |low: f64, high: f64, n: i32| -> Vec<f64> {
        (0..n).map(|i| low * (high / low).powf(f64::from(i) / f64::from(n - 1))).collect()
    };
    let (body, spine) = (axis(0.1, 0.4, 13), axis(1.5, 6.0, 13));
    let values = spine.iter().flat_map(|s| body.iter().map(|b| loss(*b, *s))).collect();
    let x = Axis::log("body modulus", "MPa");
    let y = Axis::log("spine modulus", "GPa");
    let way = vec![[0.33, 5.0], [0.27, 4.4], [0.22, 3.7], [0.19, 3.3], [0.181, 3.12]];
    Landscape::new((x, body), (y, spine), values, Axis::log("loss", ""))
        .with_path(way, palette::PAPER, "Adam")
        .with(Mark::cross([0.18, 3.1], palette::OPTIMUM).labelled("lowest loss on the grid"))
}

fn search() -> Result<String, PlotError> {
    let falling = |rate: f64, floor: f64, n: i32| -> Vec<[f64; 2]> {
        (0..n).map(|i| [f64::from(i + 1), floor + 0.12 * (-rate * f64::from(i)).exp()]).collect()
    };
    let method = |points: Vec<[f64; 2]>, name: &str, label: &str| {
        let line = Mark::line(points.clone(), palette::method(name)).labelled(label);
        [line, Mark::points(points, Marker::Disc, palette::method(name)).sized(2.6)]
    };
    let mut methods = Axes::new(Axis::linear("forward simulations", ""), Axis::log("lowest loss so far", ""));
    let runs = [
        ("grid", "grid", 0.12, 0.02, 25),
        ("cma_es", "CMA-ES", 0.15, 0.0045, 40),
        ("adam", "Adam", 0.5, 0.004, 30),
        ("gauss_newton", "Gauss-Newton", 2.0, 0.0038, 8),
    ];
    for (name, label, rate, floor, n) in runs {
        methods.marks.extend(method(falling(rate, floor, n), name, label));
    }
    let pressures = [50.0, 100.0, 150.0, 200.0, 250.0];
    let tip = |p: f64| 0.05 * p + 1.2e-4 * p * p;
    let measured: Vec<[f64; 2]> = pressures.iter().map(|p| [*p, tip(*p)]).collect();
    let simulated = (0..60).map(|i| f64::from(i) * 4.4).map(|p| [p, 0.98 * tip(p)]).collect();
    let bend = Axes::new(Axis::linear("pressure", "mbar"), Axis::linear("tip displacement", "mm"))
        .with(Mark::line(simulated, palette::SIMULATED).labelled("simulated"))
        .with(
            Mark::points(measured, Marker::Ring, palette::MEASURED)
                .with_error_bars(vec![0.4, 0.5, 0.7, 0.9, 1.2])
                .labelled("measured"),
        );
    Figure::new(SINGLE_COLUMN_MM)
        .row(68.0, [Panel::Landscape(landscape())])
        .row(45.0, [Panel::Axes(methods)])
        .row(42.0, [Panel::Axes(bend)])
        .noted("virtual bench")
        .svg()
}

fn thrust() -> Result<String, PlotError> {
    let force = |by: f64, lag: f64| -> Vec<[f64; 2]> {
        wave(2.0, 1.0, lag).into_iter().map(|[t, v]| [t, by * (v * v - 0.2) + 0.02 * (60.0 * t).sin()]).collect()
    };
    let tail = Axes::new(Axis::linear("time", "s").without_tick_labels(), Axis::linear("tip", "mm"))
        .with(Mark::span(0.0, 0.4, palette::MUTED))
        .with(Mark::line(wave(2.0, 9.0, 0.4), palette::DISPLACEMENT));
    let thrust = Axes::new(Axis::linear("time", "s"), Axis::linear("thrust", "N"))
        .with(Mark::horizontal_line(0.0, palette::MUTED))
        .with(Mark::span(0.0, 0.4, palette::MUTED))
        .with(Mark::line(force(0.21, 0.0), palette::MEASURED).labelled("measured"))
        .with(Mark::line(force(0.33, 0.1), palette::ELONGATED_BODY).labelled("elongated-body theory"))
        .with(Mark::line(force(0.2, 0.08), palette::NETWORK).labelled("network").dashed(Dash::Dashed));
    let spectrum =
        (1..200).map(|i| f64::from(i) * 0.05).map(|f| [f, 1.0 / ((1.0 - f * f / 16.0).powi(2) + 0.02 * f * f).sqrt()]);
    let resonance = Axes::new(Axis::log("frequency", "Hz"), Axis::log("gain", ""))
        .with(Mark::line(spectrum.collect(), palette::series(0)).labelled("load cell"))
        .with(Mark::vertical_line(4.0, palette::MUTED).dashed(Dash::Dotted).labelled("natural frequency"))
        .with(Mark::text([1.0, 3.0], "1 Hz beat", Side::Above, palette::BLACK));
    Figure::new(DOUBLE_COLUMN_MM)
        .row(26.0, [Panel::Axes(tail.clone()).titled("training"), Panel::Axes(tail).titled("held out")])
        .row(46.0, [Panel::Axes(thrust.clone()), Panel::Axes(thrust.legend(Legend::None))])
        .row(44.0, [Panel::Axes(resonance)])
        .svg()
}

/// A tapered tube bent sideways: points and faces.
fn tube(bend: f64, from: f64, to: f64, size: f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (long, round) = (160, 64);
    let point = |k: usize| {
        let (t, a) = ((k / round) as f64 / long as f64, (k % round) as f64 / round as f64 * TAU);
        let x = from + (to - from) * t;
        let s = x / 0.1;
        let rib = 1.0 + 0.06 * (TAU * 9.0 * s).cos() * (1.0 - s);
        let thick = size * 0.018 * (1.0 - 0.75 * s).max(0.04) * rib;
        let tall = size * 0.022 * (1.0 - 0.55 * s).max(0.05) * rib;
        [x, bend * s * s + thick * a.cos(), tall * a.sin()]
    };
    let index = |i: usize, j: usize| (i * round + j % round) as u32;
    let mut faces = Vec::new();
    for (i, j) in (0..long).flat_map(|i| (0..round).map(move |j| (i, j))) {
        faces.push([index(i, j), index(i + 1, j), index(i + 1, j + 1)]);
        faces.push([index(i, j), index(i + 1, j + 1), index(i, j + 1)]);
    }
    ((0..(long + 1) * round).map(point).collect(), faces)
}

fn mesh() -> Result<String, PlotError> {
    let markers = vec![[0.055, 0.0, 0.016], [0.07, 0.0, 0.014], [0.085, 0.0, 0.012]];
    let (points, faces) = tube(0.0, 0.0, 0.1, 1.0);
    let rest = Scene::new(View::CORNER)
        .with_surface(&points, &faces, Paint::Transparent(palette::BODY, 0.45))
        .with_surface(&tube(0.0, 0.0, 0.1, 0.4).0, &faces, Paint::Solid(palette::SPINE))
        .with_overlay(markers, OverlayKind::Markers(Marker::Cross), palette::BLACK, 5.0)
        .with_scale_bar(0.02);
    let (bent, faces) = tube(0.03, 0.0, 0.1, 1.0);
    let lengths: Vec<f64> = bent.iter().map(|p| 1e3 * 0.03 * (p[0] / 0.1).powi(2)).collect();
    let bent = Scene::new(View::TOP)
        .with_values(&bent, &faces, &lengths, Axis::linear("displacement", "mm"))
        .with_scale_bar(0.02);
    let (side, faces) = tube(0.0, 0.0, 0.1, 1.0);
    let side = Scene::new(View::SIDE).with_surface(&side, &faces, Paint::Solid(palette::BODY)).with_scale_bar(0.02);
    Figure::new(DOUBLE_COLUMN_MM)
        .row(
            50.0,
            [
                Panel::Scene(rest).titled("at rest"),
                Panel::Scene(bent).titled("250 mbar, simulated"),
                Panel::Scene(side).titled("from the side"),
            ],
        )
        .noted("virtual bench")
        .svg()
}

fn diagram() -> Result<String, PlotError> {
    let boxed = |x: f64, y: f64, lines: &[&str], fill| Part::Box {
        at: [x, y],
        size: [27.0, 12.0],
        lines: lines.iter().map(|l| (*l).to_owned()).collect(),
        fill,
    };
    let light = |c: plot::Colour| palette::PAPER.towards(c, 0.22);
    let arrow = |points: Vec<[f64; 2]>, text: Option<(&str, Side)>| Part::Arrow {
        points,
        text: text.map(|(t, s)| (t.to_owned(), s)),
        colour: palette::BLACK,
        dash: Dash::Solid,
    };
    let flow = Diagram::new(86.0, 50.0)
        .with(boxed(15.0, 40.0, &["video", "KLT, plane"], light(palette::MEASURED)))
        .with(boxed(15.0, 10.0, &["pressure", "on one clock"], light(palette::PRESSURE)))
        .with(boxed(70.0, 10.0, &["simulation", "E, ν by region"], light(palette::SIMULATED)))
        .with(boxed(70.0, 40.0, &["loss", "and its gradient"], light(palette::OPTIMUM)))
        .with(arrow(vec![[28.5, 40.0], [56.5, 40.0]], Some(("measured markers", Side::Above))))
        .with(arrow(vec![[28.5, 10.0], [56.5, 10.0]], Some(("p(t)", Side::Above))))
        .with(arrow(vec![[74.0, 16.0], [74.0, 34.0]], Some(("markers", Side::Right))))
        .with(Part::Arrow {
            points: vec![[66.0, 34.0], [66.0, 16.0]],
            text: Some(("adjoint".to_owned(), Side::Left)),
            colour: palette::SPINE,
            dash: Dash::Dashed,
        });
    let cell = Diagram::new(86.0, 50.0)
        .with(Part::Wall { from: [10.0, 10.0], to: [10.0, 40.0] })
        .with(Part::Spring { from: [10.0, 32.0], to: [42.0, 32.0] })
        .with(Part::Damper { from: [42.0, 18.0], to: [10.0, 18.0] })
        .with(boxed(55.5, 25.0, &["m"], light(palette::BODY)))
        .with(Part::Text { at: [26.0, 37.0], text: "k".to_owned(), side: Side::Centre, colour: palette::BLACK })
        .with(Part::Text { at: [26.0, 11.0], text: "b".to_owned(), side: Side::Centre, colour: palette::BLACK })
        .with(arrow(vec![[69.0, 25.0], [82.0, 25.0]], Some(("thrust", Side::Above))))
        .with(Part::Disc { at: [55.5, 12.0], radius: 2.0, fill: palette::PAPER });
    Figure::new(DOUBLE_COLUMN_MM).row(54.0, [Panel::Diagram(flow), Panel::Diagram(cell)]).svg()
}

fn picture() -> Result<String, PlotError> {
    let (w, h) = (640usize, 360usize);
    let grey = (0..w * h).map(|k| {
        let (x, y) = ((k % w) as f64, (k / w) as f64);
        let grid = if k % w % 40 < 2 || k / w % 40 < 2 { 40.0 } else { 0.0 };
        let tail = (y - 180.0 - 0.0008 * (x - 100.0).powi(2)).abs() < 60.0 - 0.09 * x && (100.0..560.0).contains(&x);
        if tail { 205 } else { (90.0 + grid + 20.0 * (0.01 * x).sin()) as u8 }
    });
    let marks = vec![[300.0, 212.0], [380.0, 243.0], [460.0, 284.0]];
    let simulated = marks.iter().map(|p| [p[0] + 2.0, p[1] - 3.0]).collect();
    let shown = Picture::new(w, h, grey.collect())
        .with(Mark::points(simulated, Marker::Ring, palette::SIMULATED).sized(7.0))
        .with(Mark::points(marks, Marker::Cross, palette::MEASURED).sized(5.0))
        .with_scale_bar(80.0, "20 mm");
    let outline = |by: f64| -> Vec<[f64; 2]> {
        (0..=50).map(|i| f64::from(i) * 2.0).map(|x| [x, by * (20.0 - 0.16 * x)]).collect()
    };
    let shape = Axes::new(Axis::linear("x", "mm"), Axis::linear("z", "mm"))
        .with(
            Mark::band(
                outline(1.0).iter().map(|p| p[0]).collect(),
                outline(-1.0).iter().map(|p| p[1]).collect(),
                outline(1.0).iter().map(|p| p[1]).collect(),
                palette::BODY,
            )
            .labelled("silicone"),
        )
        .with(Mark::line(vec![[0.0, 0.0], [104.0, 0.0]], palette::SPINE).sized(2.0).labelled("acetal sheet"))
        .equal();
    Figure::new(DOUBLE_COLUMN_MM)
        .row(52.0, [Panel::Picture(shown).titled("frame 212"), Panel::Axes(shape).titled("section")])
        .svg()
}

fn table() -> Result<String, PlotError> {
    let [ours, published] = Column::beside_published("loss after 4 iterations", "");
    let [time, published_time] = Column::beside_published("total time", "min");
    let columns =
        vec![Column::text("method"), Column::numbers("iterations", ""), time, published_time, ours, published];
    let row = |cells: [&str; 6]| cells.map(str::to_owned).to_vec();
    let rows = vec![
        row(["Grid search", "25", "0.41", "132.9", "0.0231", "0.023"]),
        row(["CMA-ES", "40", "0.66", "214", "0.0195", "0.021"]),
        row(["Adam", "4", "0.12", "22", "0.0027", "0.0027"]),
        row(["Gauss-Newton", "6", "0.14", "", "0.0004", ""]),
    ];
    Table::new(columns, rows)?.noted("virtual bench; published: the paper's table III").svg()
}
