//! Writing a card: the TOML that [`super::read`] reads, with units as comments and the same bytes every time.

use std::fmt::Write;

use super::{
    Board, BoardKind, Camera, Card, Clamp, Experiment, Fixture, FixtureOf, LensKind, Log, LogColumn, Origin, Part,
    Place, Search, Tracks, Trial,
};

use crate::place::Block;

/// The text of `specimen.toml`.
pub fn write(card: &Card) -> String {
    let mut text = String::new();
    write_head(&mut text, card);
    card.solid.parts.iter().for_each(|part| write_solid(&mut text, part));
    write_clamp(&mut text, &card.clamp);
    for c in &card.chamber {
        let table = format_args!(
            "\n[[chamber]]\nname = {:?}\nat = {:?}  # m, inside it\nchannel = {:?}\n",
            c.name, c.at, c.channel
        );
        put(&mut text, table);
    }
    for m in &card.marker {
        put(&mut text, format_args!("\n[[marker]]\nname = {:?}\nat = {:?}  # m, CAD frame\n", m.name, m.at));
        if let Some(at) = m.clicked {
            put(&mut text, format_args!("clicked = {at:?}  # px in the first frame of every trial\n"));
        }
        m.diameter.iter().for_each(|diameter| put(&mut text, format_args!("diameter = {diameter:?}  # m\n")));
    }
    card.search.iter().for_each(|s| write_search(&mut text, s));
    card.camera.iter().for_each(|c| write_camera(&mut text, c));
    if let Some(w) = &card.water {
        put(&mut text, format_args!("\n[water]\nsurface = {:?}  # m, z\nindex = {:?}\n", w.surface, w.index));
    }
    if let Some(t) = &card.tank {
        put(&mut text, format_args!("\n[tank]\nlength = {:?}  # m\ndepth = {:?}  # m\n", t.length, t.depth));
    }
    if let Some(led) = &card.led {
        put(&mut text, format_args!("\n[led]\ncentre = {:?}  # px\nradius = {:?}  # px\n", led.centre, led.radius));
    }
    for t in &card.trial {
        write_trial(&mut text, t);
    }
    card.tracks.iter().for_each(|t| write_tracks(&mut text, t));
    for f in &card.fixture {
        write_fixture(&mut text, f);
    }
    write_log(&mut text, &card.log);
    text
}

/// Writing to a `String` cannot fail.
fn put(text: &mut String, what: std::fmt::Arguments<'_>) {
    text.write_fmt(what).expect("a string takes any text");
}

fn write_head(text: &mut String, card: &Card) {
    match card.origin {
        Origin::VirtualBench => text.push_str("# Made by the virtual bench: computed, not measured.\n"),
        Origin::Laboratory => text.push_str("# Recorded in a laboratory.\n"),
    }
    put(text, format_args!("name = {:?}\norigin = {:?}\n", card.name, card.origin.word()));
    put(text, format_args!("length = {:?}  # m, errors are divided by it\n", card.length));
    put(text, format_args!("\n[solid]\nunit = {:?}  # of the files\n", card.solid.unit.word()));
    if let Some(mesh) = &card.solid.mesh {
        put(text, format_args!("mesh = {mesh:?}\n"));
    }
}

fn write_clamp(text: &mut String, clamp: &Clamp) {
    text.push_str("\n[clamp]\n");
    if let Some(x) = clamp.below_x {
        put(text, format_args!("below_x = {x:?}  # m: held at and below\n"));
    }
    if let Some(plane) = clamp.plane {
        let axes = [("x", plane.x), ("y", plane.y), ("z", plane.z)];
        let coordinates = axes
            .into_iter()
            .filter_map(|(axis, coordinate)| coordinate.map(|coordinate| format!("{axis} = {coordinate:?}")));
        put(text, format_args!("plane = {{ {} }}  # m\n", coordinates.collect::<Vec<_>>().join(", ")));
    }
    if let Some(Block { low, high }) = clamp.block {
        put(text, format_args!("box = {{ low = {low:?}, high = {high:?} }}  # m\n"));
    }
    clamp.surface.iter().for_each(|surface| put(text, format_args!("surface = {surface:?}  # of the mesh\n")));
}

fn write_solid(text: &mut String, Part { name, solid }: &Part) {
    put(text, format_args!("\n[solid.{name}]\n"));
    for (key, value) in [("file", &solid.file), ("region", &solid.region)] {
        value.iter().for_each(|value| put(text, format_args!("{key} = {value:?}\n")));
    }
    put(text, format_args!("material = {:?}\n", solid.material));
    put(text, format_args!("youngs_modulus = {:?}  # Pa, nominal: the first guess\n", solid.youngs_modulus));
    put(text, format_args!("poissons_ratio = {:?}\ndensity = {:?}  # kg/m³\n", solid.poissons_ratio, solid.density));
    if solid.stiffening != [0.0; 2] {
        put(text, format_args!("stiffening = {:?}  # C20/C10 and C30/C10, nominal\n", solid.stiffening));
    }
    if let Some(sigma) = solid.stiffening_sigma {
        put(text, format_args!("stiffening_sigma = {sigma:?}  # their standard deviations, of a tensile test\n"));
    }
    put(text, format_args!("plausible = {:?}  # Pa, the box that is searched\n", solid.plausible));
}

fn write_camera(text: &mut String, camera: &Camera) {
    let plane = &camera.plane;
    put(
        text,
        format_args!("\n[camera]\ncalibration = {:?}\nframe_every = {}\n", camera.calibration, camera.frame_every),
    );
    if camera.lens == LensKind::Fisheye {
        text.push_str("lens = \"fisheye\"\n");
    }
    if let Some(file) = &camera.coefficients {
        put(text, format_args!("coefficients = {file:?}  # OpenCV's YAML\n"));
    }
    if camera.readout != 0.0 {
        put(text, format_args!("readout = {:?}  # s, from the first row to the last\n", camera.readout));
    }
    write_board(text, &camera.board);
    put(
        text,
        format_args!("\n[camera.plane]\nseconds = {:?}  # s, the board lies still on the plane\n", plane.seconds),
    );
    put(text, format_args!("origin = {:?}  # m, its inner corner (0, 0)\n", plane.origin));
    put(
        text,
        format_args!(
            "along = {:?}  # its columns; rows run a quarter turn anticlockwise, seen from the camera\n",
            plane.along
        ),
    );
    put(text, format_args!("height = {:?}  # m, z of the plane\n", plane.height));
    if let Some(pitch) = plane.grid {
        put(
            text,
            format_args!(
                "grid = {pitch:?}  # m, pitch of its bright lines along x and y; one of each through the origin\n"
            ),
        );
    }
}

fn write_board(text: &mut String, board: &Board) {
    let (kind, figure) = match board.kind {
        BoardKind::Checkerboard => ("", "squares"),
        BoardKind::Dots => ("kind = \"dots\"\n", "dots"),
        BoardKind::AsymmetricDots => ("kind = \"asymmetric_dots\"\n", "dots of a row"),
        BoardKind::Charuco => ("kind = \"charuco\"\n", "squares"),
    };
    put(text, format_args!("\n[camera.board]\n{kind}columns = {}  # {figure}\nrows = {}\n", board.columns, board.rows));
    put(text, format_args!("square = {:?}  # m\n", board.square));
    board.marker.iter().for_each(|marker| put(text, format_args!("marker = {marker:?}  # m\n")));
    board.dictionary.iter().for_each(|name| put(text, format_args!("dictionary = {name:?}\n")));
}

/// The instruments' logs, where they differ from the usual ones.
fn write_log(text: &mut String, log: &Log) {
    if *log == Log::default() {
        return;
    }
    text.push_str("\n[log]\n");
    if let Some(gap) = log.longest_gap {
        put(text, format_args!("longest_gap = {gap:?}  # s\n"));
    }
    if let Some(lag) = log.force_lag {
        put(text, format_args!("force_lag = {lag:?}  # s\nforce_lag_sigma = {:?}  # s\n", log.force_lag_sigma));
    }
    log.columns.iter().for_each(|column| write_log_column(text, column));
}

fn write_log_column(text: &mut String, column: &LogColumn) {
    put(text, format_args!("\n[[log.columns]]\nquantity = {:?}\n", column.quantity));
    match &column.column {
        Place::Position(at) => put(text, format_args!("column = {at}\n")),
        Place::Title(title) => put(text, format_args!("column = {title:?}\n")),
    }
    if let Some(unit) = column.unit {
        put(text, format_args!("unit = {:?}\n", unit.word()));
    }
    if column.scale != 1.0 {
        put(text, format_args!("scale = {:?}\n", column.scale));
    }
    if let Some(of) = column.of {
        put(text, format_args!("of = {:?}\n", of.word()));
    }
}

fn write_trial(text: &mut String, trial: &Trial) {
    let (kind, channels) = (trial.experiment.kind(), trial.experiment.channels());
    put(text, format_args!("\n[[trial]]\nid = {:?}\nkind = {kind:?}\nrole = {:?}\n", trial.id, trial.role.word()));
    if let Some(split) = trial.split {
        put(text, format_args!("split = {:?}\n", split.word()));
    }
    let sequence = match trial.experiment {
        Experiment::Staircase { .. } => "filled together",
        Experiment::Flapping { .. } => "filled in turn",
    };
    put(text, format_args!("medium = {:?}\nchannels = {channels:?}  # {sequence}\n", trial.medium.word()));
    trial.video.iter().for_each(|video| put(text, format_args!("video = {video:?}\n")));
    put(text, format_args!("pressure = {:?}\n", trial.pressure));
    if let Some(force) = &trial.force {
        put(text, format_args!("force = {force:?}\n"));
    }
    if trial.first_frame != 0 {
        put(text, format_args!("first_frame = {}\n", trial.first_frame));
    }
    if let Some(last) = trial.last_frame {
        put(text, format_args!("last_frame = {last}\n"));
    }
    match &trial.experiment {
        Experiment::Staircase { levels, hold, pause, .. } => {
            put(text, format_args!("levels = {levels:?}  # Pa\nhold = {hold:?}  # s\npause = {pause:?}  # s\n"));
        }
        Experiment::Flapping { amplitude, frequency, cycles, .. } => {
            put(
                text,
                format_args!("amplitude = {amplitude:?}  # Pa\nfrequency = {frequency:?}  # Hz\ncycles = {cycles}\n"),
            );
        }
    }
}

fn write_search(text: &mut String, search: &Search) {
    put(text, format_args!("\n[search]\nregion = {:?}  # px: left, top, right, bottom\n", search.region));
    put(text, format_args!("order = {:?}\nby = {:?}\n", search.order.word(), search.by.word()));
}

fn write_tracks(text: &mut String, tracks: &Tracks) {
    put(text, format_args!("\n[[tracks]]\ntrial = {:?}\nfile = {:?}\n", tracks.trial, tracks.file));
    let unit = if tracks.space.is_some() { "m" } else { "px" };
    put(text, format_args!("sigma = {:?}  # {unit}\n", tracks.sigma));
    if let Some(axes) = &tracks.space {
        put(
            text,
            format_args!(
                "\n[tracks.space]\nstart = {:?}  # s on the film's clock, without a film on the log's\n",
                axes.start
            ),
        );
        put(text, format_args!("origin = {:?}  # m, in the file's axes\n", axes.origin));
        put(text, format_args!("x = {:?}\nz = {:?}\n", axes.x, axes.z));
    }
}

fn write_fixture(text: &mut String, fixture: &Fixture) {
    let (kind, medium) = (fixture.of.kind(), fixture.medium.word());
    put(text, format_args!("\n[[fixture]]\nid = {:?}\nkind = {kind:?}\nmedium = {medium:?}\n", fixture.id));
    put(text, format_args!("force = {:?}\n", fixture.force));
    if let FixtureOf::Taps { hammer, count } = &fixture.of {
        put(text, format_args!("hammer = {hammer:?}  # on the clock of force\n"));
        count.iter().for_each(|count| put(text, format_args!("count = {count}  # taps\n")));
    }
}
