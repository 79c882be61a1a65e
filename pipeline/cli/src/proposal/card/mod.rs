//! The proposed card as text: each guess behind its key with its confidence and evidence, each question as a line to be filled in.

mod camera;
mod logs;
mod trial;

use std::fmt::Write;

use super::columns::Role;
use super::film::Footage;
use super::guess::{Confidence, Guess};
use super::lamp::lamp;
use super::trials::{Trial, trials};
use super::{Contents, Proposal, solids};

/// A card that is being written, and its guesses.
#[derive(Default)]
struct Writer {
    text: String,
    guesses: Vec<Guess>,
    files: Vec<String>,
}

const HEAD: &str = "# Proposed from the files of this folder by `study doctor`. Behind each value: how sure it is, and its evidence.\n\
    # FILL IN marks what no file says: put a number in the place of nan. `study doctor NAME` checks the card.\n";

/// The proposal for the contents of a folder.
pub(super) fn proposal(contents: &Contents, name: &str) -> Proposal {
    let mut writer = Writer { guesses: contents.remarks.clone(), ..Writer::default() };
    writer.text.push_str(HEAD);
    writer.put(format_args!("\nname = {name:?}\norigin = \"laboratory\"\n"));
    writer.solids(contents);
    let calibration = calibration(&contents.films);
    let films: Vec<&Footage> = contents
        .films
        .iter()
        .filter(|film| calibration.is_none_or(|calibration| !std::ptr::eq(*film, calibration)))
        .collect();
    let lamp = lamp(&films.iter().map(|film| &film.blocks).collect::<Vec<_>>());
    let trials = trials(&films, lamp.as_ref(), &contents.logs);
    writer.chambers(&trials.trials);
    writer.markers();
    writer.camera(calibration, &contents.films);
    writer.lamp(lamp.as_ref(), &films, trials.true_seconds.is_some());
    trials.trials.iter().for_each(|trial| writer.trial(trial));
    writer.rate(&trials);
    writer.logs(&trials.trials);
    contents.logs.iter().for_each(|log| writer.guesses.extend(log.guesses()));
    writer.guesses.extend(trials.unpaired);
    Proposal { guesses: writer.guesses, card: writer.text, files: writer.files }
}

/// The film that shows a board in most of its pictures.
fn calibration(films: &[Footage]) -> Option<&Footage> {
    let pictures = |film: &&Footage| film.board.as_ref().map_or(0, |board| board.pictures.0);
    films.iter().filter(|film| pictures(film) >= 3).max_by_key(pictures)
}

impl Writer {
    fn put(&mut self, arguments: std::fmt::Arguments) {
        self.text.write_fmt(arguments).expect("a string takes any text");
    }

    /// A line of the card with its remark; a question has `nan`.
    fn line(&mut self, key: &str, guess: Guess) {
        let value = guess.value.clone().unwrap_or_else(|| "nan".to_owned());
        self.put(format_args!("{key} = {value}  # {}\n", guess.remark()));
        self.guesses.push(guess);
    }

    /// A file that the card names.
    fn file(&mut self, key: &str, name: &str, guess: Guess) {
        self.files.push(name.to_owned());
        self.line(key, Guess { value: Some(format!("{name:?}")), ..guess });
    }

    fn question(&mut self, table: &str, key: &str, value: &str, action: &str) {
        self.put(format_args!("{key} = {value}  # FILL IN; {action}\n"));
        self.guesses.push(Guess::question(format!("{table}{key}"), action));
    }

    fn solids(&mut self, contents: &Contents) {
        let mut solids: Vec<&solids::Solid> = contents.solids.iter().collect();
        solids.sort_by(|a, b| b.volume.total_cmp(&a.volume));
        let (unit, metres) = solids.first().map_or(("mm", 1e-3), |body| solids::unit(body.length));
        let longest = solids.first().map_or(0.0, |body| body.length);
        self.question(
            "",
            "length",
            "nan",
            &format!(
                "m, 0.01 to 1; from the clamped end to the tip; the largest surface is {} m long",
                longest * metres
            ),
        );
        self.text.push_str("\n[solid]\n");
        if !solids.is_empty() {
            let evidence = format!("the largest surface is {longest:.4} of it long");
            self.line("unit", Guess::new(Confidence::Likely, "solid.unit", format!("{unit:?}"), evidence));
        }
        for (solid, part) in solids.iter().zip(["body", "spine"]) {
            self.solid(solid, part);
        }
        // length: those beyond a body and a sheet are named as questions
        for solid in solids.iter().skip(2) {
            self.guesses
                .push(Guess::question(&solid.name, "a further surface: bond several solids in one mesh, [solid] mesh"));
        }
        if solids.is_empty() {
            self.text.push_str("\n[solid.body]\n");
            self.question(
                "solid.body.",
                "file",
                "\"cad/body.stl\"",
                "the body's surface as STL: there is none in the folder",
            );
            self.material("body");
        }
        self.clamp();
    }

    fn clamp(&mut self) {
        self.text.push_str("\n[clamp]\n");
        self.question(
            "clamp.",
            "below_x",
            "nan",
            "m, -1 to 1; everything at or before this x of the CAD frame is clamped",
        );
    }

    fn solid(&mut self, solid: &solids::Solid, part: &str) {
        self.put(format_args!("\n[solid.{part}]\n"));
        let evidence =
            if part == "body" { "the surface of largest volume" } else { "the surface of second largest volume" };
        self.file(
            "file",
            &solid.name,
            Guess::new(Confidence::Likely, format!("solid.{part}.file"), &solid.name, evidence),
        );
        self.material(part);
    }

    fn material(&mut self, part: &str) {
        let (ratio, density) = if part == "body" { (0.49, 1070.0) } else { (0.37, 1410.0) };
        self.put(format_args!("material = \"neo_hookean\"\npoissons_ratio = {ratio}\ndensity = {density:?}\n"));
        let table = format!("solid.{part}.");
        self.question(&table, "youngs_modulus", "nan", "Pa, 1e3 to 1e12; the initial guess, from the data sheet");
        self.question(&table, "plausible", "[nan, nan]", "Pa, 1e3 to 1e12; lowest and highest plausible modulus");
    }

    fn chambers(&mut self, trials: &[Trial]) {
        let mut channels: Vec<String> = Vec::new();
        for column in trials.iter().flat_map(|trial| trial.pressure.of_role(Role::Command)) {
            channels.extend(column.channel.clone().filter(|channel| !channels.contains(channel)));
        }
        for channel in channels {
            self.put(format_args!("\n[[chamber]]\nname = {channel:?}\n"));
            self.question("chamber.", "at", "[nan, nan, nan]", "m, -1 to 1; a point inside the cavity");
            let evidence = "a command of the logs is called so";
            self.line("channel", Guess::new(Confidence::Likely, "chamber.channel", format!("{channel:?}"), evidence));
        }
    }

    fn markers(&mut self) {
        self.text.push_str("\n# One for each dark mark, from the clamp to the tip.\n[[marker]]\nname = \"m1\"\n");
        self.question("marker.", "at", "[nan, nan, nan]", "m, -1 to 1; where it was painted on the skin");
        self.question("marker.", "clicked", "[nan, nan]", "px, 0 to 20000; its centre in the first frame");
        self.question("marker.", "diameter", "nan", "m, 0.0002 to 0.05; of the dark disc");
    }
}
