//! What `study doctor` vouches for, in surfaces, mesh files, places in space and force logs: where it says "0 to fix", `study run` reads all of it.
#![allow(clippy::unwrap_used)]

mod specimen;
mod vouch;

use std::fmt::Write;

use specimen::{Project, card, changed, solids};
use vouch::{Input, Verdict, check, study};

/// A file beside other crates' tests.
fn fixture(path: &str) -> Vec<u8> {
    std::fs::read(format!("{}/../{path}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// The card without the lines that hold one of these words.
fn without(card: &str, words: &[&str]) -> String {
    let is_kept = |line: &&str| !words.iter().any(|word| line.contains(word));
    card.lines().filter(is_kept).map(|line| format!("{line}\n")).collect()
}

/// The card from one heading up to the next in other words.
fn replaced(card: &str, (from, until): (&str, &str), text: &str) -> String {
    let (before, rest) = card.split_once(from).unwrap();
    format!("{before}{text}{until}{}", rest.split_once(until).unwrap().1)
}

const BODY: &str = "cad/body.stl";

/// The body in ASCII, mm, with the lines of each face changed.
fn ascii_body(change: impl Fn(usize, String) -> String) -> String {
    let (body, _) = solids();
    let mut text = "solid body\n".to_owned();
    for (number, face) in body.faces.iter().enumerate() {
        let corner = |k: usize| body.points[face[k] as usize].map(|c| format!("{:.6}", 1e3 * c)).join(" ");
        let corners = [0, 1, 2].map(|k| format!("vertex {}\n", corner(k))).concat();
        text += &change(number, format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n"));
    }
    text + "endsolid body\n"
}

fn surface(name: &'static str, bytes: impl Into<Vec<u8>>, verdict: Verdict) -> Input {
    Input { name, file: BODY, bytes: bytes.into(), card: card(), verdict }
}

#[test]
fn surfaces_of_every_form_that_the_doctor_vouches_for_are_meshed_by_run() {
    let plain = ascii_body(|_, face| face);
    let (body, _) = solids();
    let mut binary = mesh::stl::write(&body, 1e-3, "body");
    binary[..5].copy_from_slice(b"solid");
    let named = [&b"solid b\xf6dy\n"[..], plain.split_once('\n').unwrap().1.as_bytes()].concat();
    let twice = ascii_body(|k, face| if k == 5 { face.repeat(2) } else { face });
    let last = body.faces.len() - 1;
    let inputs = vec![
        surface("ASCII", plain.clone(), Verdict::Read),
        surface("upper case", plain.to_uppercase(), Verdict::Read),
        surface("CR alone", plain.replace('\n', "\r"), Verdict::Read),
        surface("a byte-order mark", format!("\u{feff}{plain}"), Verdict::Read),
        surface("a name in Latin-1", named, Verdict::Read),
        surface("normals that are no numbers", plain.replace("normal 0 0 0", "normal nan nan nan"), Verdict::Read),
        surface("solid alone in the first line", plain.replacen("solid body", "solid", 1), Verdict::Read),
        surface("binary that begins with solid", binary.clone(), Verdict::Read),
        surface("a hole", ascii_body(|k, face| if k == last { String::new() } else { face }), Verdict::Refused),
        surface("a face twice", twice, Verdict::Read),
        surface("cut in binary", binary[..binary.len() - 30].to_vec(), Verdict::Refused),
        surface("cut in ASCII", plain[..plain.len() * 2 / 3].to_owned(), Verdict::Refused),
        surface("a corner that is no number", plain.replacen("vertex 0", "vertex O", 1), Verdict::Refused),
        surface("empty", "", Verdict::Refused),
    ];
    check("vouched-surfaces", "mesh", inputs);
}

/// The card of a hollow ball of two groups in a mesh file, m.
fn ball_card(file: &str, [soft, stiff]: [&str; 2]) -> String {
    let solid = |name: &str, region: &str, modulus: f64| {
        let range = [0.3 * modulus, 3.0 * modulus];
        format!(
            "[solid.{name}]\nregion = {region:?}\nmaterial = \"neo_hookean\"\nyoungs_modulus = {modulus:?}\npoissons_ratio = 0.45\n\
             density = 1070.0\nplausible = {range:?}\n"
        )
    };
    let solids = format!(
        "[solid]\nunit = \"m\"\nmesh = {file:?}\n{}{}",
        solid("silicone", soft, 2e5),
        solid("sheet", stiff, 2e6)
    );
    let chamber =
        "[clamp]\nbelow_x = -0.008\n\n[[chamber]]\nname = \"left\"\nat = [0.0, 0.0, 0.0]\nchannel = \"left\"\n\n";
    let card = replaced(&card(), ("[solid]", "[[marker]]"), &format!("{solids}\n{chamber}"));
    let card = changed(&card, "at = [0.05, 0.0, 0.0174]", "at = [0.0, 0.0, 0.01]");
    changed(&card, "origin = [0.0263, -0.0242]", "origin = [-0.0237, -0.0242]")
}

#[test]
fn mesh_files_of_every_format_that_the_doctor_vouches_for_are_read_by_run() {
    let ball = |name: &str| fixture(&format!("mesh/tests/data/{name}"));
    let input = |name: &'static str, file: &'static str, bytes: Vec<u8>, verdict: Verdict| Input {
        name,
        file,
        bytes,
        card: ball_card(file, ["7", "3"]),
        verdict,
    };
    let formats = [
        ("gmsh 4.1", "cad/ball.msh", "ball.msh"),
        ("gmsh 4.1 in binary", "cad/ball.msh", "ball_binary.msh"),
        ("gmsh 2.2", "cad/ball.msh", "ball_legacy.msh"),
        ("gmsh 2.2 in binary", "cad/ball.msh", "ball_legacy_binary.msh"),
        ("an ending in upper case", "cad/BALL.MSH", "ball.msh"),
        ("MEDIT", "cad/ball.mesh", "ball.mesh"),
        ("VTU", "cad/ball.vtu", "ball_ascii.vtu"),
        ("VTU, compressed", "cad/ball.vtu", "ball_zlib.vtu"),
        ("VTU, appended", "cad/ball.vtu", "ball_appended.vtu"),
        ("VTU, an ending in upper case", "cad/BALL.VTU", "ball_raw.vtu"),
    ];
    let mut inputs: Vec<Input> =
        formats.into_iter().map(|(name, file, data)| input(name, file, ball(data), Verdict::Read)).collect();
    let cut = |bytes: Vec<u8>| bytes[..bytes.len() * 2 / 3].to_vec();
    inputs.extend([
        input("gmsh, cut", "cad/ball.msh", cut(ball("ball.msh")), Verdict::Refused),
        input("VTU, cut", "cad/ball.vtu", cut(ball("ball_zlib.vtu")), Verdict::Refused),
        input("no mesh", "cad/ball.msh", b"$MeshFormat\n".to_vec(), Verdict::Refused),
        Input {
            card: ball_card("cad/ball.msh", ["7", "4"]),
            ..input("a group that is not there", "cad/ball.msh", ball("ball.msh"), Verdict::Refused)
        },
        Input {
            card: changed(&ball_card("cad/ball.msh", ["7", "3"]), "unit = \"m\"", "unit = \"mm\""),
            ..input("another unit", "cad/ball.msh", ball("ball.msh"), Verdict::Refused)
        },
        Input {
            card: changed(&ball_card("cad/ball.msh", ["7", "3"]), "at = [0.0, 0.0, 0.0]", "at = [0.0, 0.0, 0.008]"),
            ..input("a chamber in the wall", "cad/ball.msh", ball("ball.msh"), Verdict::Refused)
        },
    ]);
    check("vouched-meshes", "mesh", inputs);
}

const PLACES: &str = "trials/static_left/places.c3d";

/// The card with places in space: the origin moves the file's first marker onto the skin.
fn space_card(start: f64, is_filmed: bool) -> String {
    let tracks = format!(
        "\n[[tracks]]\ntrial = \"static_left\"\nfile = {PLACES:?}\nsigma = 1e-4\n[tracks.space]\nstart = {start:?}\n\
         origin = [0.0, 0.015, -0.0174]\nx = [1.0, 0.0, 0.0]\nz = [0.0, 0.0, 1.0]\n"
    );
    let filmed = card() + &tracks;
    if is_filmed {
        return filmed;
    }
    without(&replaced(&filmed, ("[camera]", "[[trial]]"), ""), &["clicked", "diameter", "video"])
}

/// The second marker of the files, too.
fn with_second_marker(card: &str) -> String {
    let second = "[[marker]]\nname = \"m2\"\nat = [0.1, -0.015, 0.0174]\n\n[[trial]]";
    card.replacen("[[trial]]", second, 1)
}

fn places(name: &'static str, bytes: Vec<u8>, card: String, verdict: Verdict) -> Input {
    Input { name, file: PLACES, bytes, card, verdict }
}

#[test]
fn places_in_space_that_the_doctor_vouches_for_are_read_by_run() {
    let capture = |name: &str| fixture(&format!("lab/tests/data/{name}.c3d"));
    let [gap, prefixed] = ["zero_gap", "subject_prefix"].map(capture);
    let cut = gap[..gap.len() * 2 / 3].to_vec();
    let mut unit = gap.clone();
    let at = unit.windows(2).position(|pair| pair == b"mm").unwrap();
    unit[at..at + 2].copy_from_slice(b"mV");
    for is_filmed in [false, true] {
        let card = space_card(0.0, is_filmed);
        let mut inputs = vec![
            places("a marker that is lost, and not on the card", gap.clone(), card.clone(), Verdict::Read),
            places("a subject's name before the marker's", prefixed.clone(), card.clone(), Verdict::Read),
            places("cut", cut.clone(), card.clone(), Verdict::Refused),
            places("no unit of length", unit.clone(), card.clone(), Verdict::Refused),
            places("no capture", b"frame".to_vec(), card.clone(), Verdict::Refused),
            places(
                "another marker",
                prefixed.clone(),
                changed(&card, "name = \"m1\"", "name = \"tip\""),
                Verdict::Refused,
            ),
            places("elsewhere", prefixed.clone(), changed(&card, "0.015, -0.0174", "0.315, -0.0174"), Verdict::Refused),
            places("after the trial", prefixed.clone(), space_card(100.0, is_filmed), Verdict::Refused),
        ];
        if !is_filmed {
            inputs.push(places(
                "a marker of the card that is lost",
                gap.clone(),
                with_second_marker(&card),
                Verdict::Refused,
            ));
        }
        check(if is_filmed { "vouched-space-film" } else { "vouched-space" }, "clock", inputs);
    }
}

const FORCE: &str = "trials/static_left/force.csv";

/// A force log of 80 Hz with the lamp from `begin` (s) on; one line may be another.
fn forces(begin: f64, samples: usize, other: Option<(usize, &str)>) -> String {
    let mut text = "time_s,force_n,led\n".to_owned();
    for k in 0..samples {
        let time = begin + k as f64 / 80.0;
        let lamp = u8::from((0.34..0.99).contains(&time));
        let force = match other {
            Some((line, word)) if line == k => word.to_owned(),
            _ => format!("{:.4}", 0.05 + 0.01 * (25.0 * time).sin()),
        };
        writeln!(text, "{time:.4},{force},{lamp}.000").unwrap();
    }
    text
}

/// The card of a trial in water with a force log.
fn force_card(is_filmed: bool) -> String {
    let card = changed(&space_card(0.0, is_filmed), "medium = \"air\"", "medium = \"water\"");
    changed(&card, "levels =", &format!("force = {FORCE:?}\nlevels =")) + "\n[water]\nsurface = 0.05\nindex = 1.333\n"
}

fn force_inputs(is_filmed: bool) -> Vec<Input> {
    let input = |name: &'static str, text: String, verdict: Verdict| Input {
        name,
        file: FORCE,
        bytes: text.into_bytes(),
        card: force_card(is_filmed),
        verdict,
    };
    let whole = || forces(0.0, 104, None);
    let mut inputs = vec![
        input("as the guide has it", whole(), Verdict::Read),
        input("CRLF", whole().replace('\n', "\r\n"), Verdict::Read),
        input("decimal commas", whole().replace(',', ";").replace('.', ","), Verdict::Read),
        input("a spike of full scale", forces(0.0, 104, Some((50, "8388607"))), Verdict::Read),
        input("a word for a number", forces(0.0, 104, Some((50, "OVERLOAD"))), Verdict::Refused),
        input("cut within a number", whole()[..whole().len() - 5].to_owned(), Verdict::Refused),
        input("no column of force", whole().replace("force_n", "kraft"), Verdict::Refused),
        input("shorter than the trial", forces(0.0, 30, None), Verdict::Refused),
        input("ends before the last command", forces(-0.2, 80, None), Verdict::Refused),
        input("titles alone", "time_s,force_n,led\n".to_owned(), Verdict::Refused),
    ];
    if !is_filmed {
        inputs.push(input("begins after the first command", forces(0.5, 104, None), Verdict::Refused));
    }
    inputs
}

#[test]
fn force_logs_that_the_doctor_vouches_for_are_read_by_run() {
    for is_filmed in [false, true] {
        let places = fixture("lab/tests/data/subject_prefix.c3d");
        let first = Input {
            name: "the places of the others",
            file: PLACES,
            bytes: places,
            card: space_card(0.0, is_filmed),
            verdict: Verdict::Read,
        };
        let inputs = std::iter::once(first).chain(force_inputs(is_filmed)).collect();
        check(if is_filmed { "vouched-force-film" } else { "vouched-force" }, "wave", inputs);
    }
}

/// A page reads the log of a load cell as a card does.
#[test]
fn a_force_page_reads_what_a_card_reads() {
    let project = Project::new("vouched-page");
    let page = "name = \"cell\"\nchannels = [\"left\"]\n[log]\nforce_lag = 0.0\n[[recording]]\nid = \"run\"\nkind = \"flapping\"\n\
                force = \"force.csv\"\nseconds = [0.2, 0.9]\nfrequency = 10.0\n";
    let folder = project.path("trials/static_left");
    std::fs::write(folder.join("page.toml"), page).unwrap();
    for input in force_inputs(false) {
        std::fs::write(project.path(FORCE), &input.bytes).unwrap();
        let path = folder.join("page.toml");
        let (output, said) = study(&project, &["force", path.to_str().unwrap()]);
        // a page has no trial whose commands the log must cover, but seconds, which it does
        let is_read = match input.name {
            "ends before the last command" | "shorter than the trial" | "begins after the first command" => false,
            _ => input.verdict == Verdict::Read,
        };
        assert_eq!(output.status.code() == Some(0), is_read, "{}: {said}", input.name);
        assert!(is_read || said.contains("why:") && said.contains("do:"), "{}: {said}", input.name);
    }
}
