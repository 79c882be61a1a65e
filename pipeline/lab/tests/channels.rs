//! Channels and solids of any number and name on a card.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use lab::Card;
use lab::card::{self, Experiment, Solids};

const GOOD: &str = include_str!("../../study/tests/card.toml");

fn parsed(text: &str) -> Result<Card, String> {
    card::parse(text, Path::new("specimen.toml")).map_err(|e| e.to_string())
}

/// The refusal of the good card with `from` changed to `to`.
fn refusal(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "`{from}` is on the good card");
    parsed(&GOOD.replacen(from, to, 1)).unwrap_err()
}

#[test]
fn channels_have_any_names_and_earlier_keys_are_still_read() {
    let named = GOOD.replace("\"left\"", "\"dorsal\"").replace("\"right\"", "\"ventral\"");
    let card = parsed(&named).unwrap();
    assert_eq!(card.channels(), ["dorsal", "ventral"]);
    assert_eq!(card.trial[0].experiment.channels(), ["dorsal"]);
    let earlier = GOOD.replace("channel = ", "log = ").replace("channels = [\"left\"]", "side = \"left\"");
    assert_ne!(earlier, GOOD);
    assert_eq!(parsed(&earlier).unwrap(), parsed(GOOD).unwrap());
}

#[test]
fn a_trial_that_drives_a_channel_without_a_chamber_or_one_twice_is_refused() {
    let driven = "channels = [\"left\"]";
    let said = refusal(driven, "channels = [\"up\"]");
    assert!(said.contains("drives the channel `up`, which fills no chamber") && said.contains("left, right"), "{said}");
    assert!(refusal(driven, "channels = [\"left\", \"left\"]").contains("drives the channel `left` twice"));
    assert!(refusal(driven, "channels = []").contains("`channels` is empty"));
    assert!(refusal(driven, "").contains("missing field `channels`"));
}

/// The good card with other solids, from the line of its unit on.
fn with_solids(solids: &str) -> Result<Solids, String> {
    let (before, rest) = GOOD.split_once("[solid]").unwrap();
    let (_, after) = rest.split_once("[clamp]").unwrap();
    parsed(&format!("{before}[solid]\nunit = \"mm\"\n{solids}\n[clamp]{after}")).map(|card| card.solid)
}

fn solid(name: &str, source: &str, modulus: f64) -> String {
    let [low, high] = [0.5 * modulus, 2.0 * modulus];
    format!(
        "[solid.{name}]\n{source}\nmaterial = \"neo_hookean\"\nyoungs_modulus = {modulus:?}\npoissons_ratio = 0.4\n\
         density = 1000.0\nplausible = [{low:?}, {high:?}]\n"
    )
}

#[test]
fn solids_are_regions_of_one_mesh_or_come_from_surfaces_and_the_order_is_that_of_their_moduli() {
    let mesh = format!("mesh = \"arm.msh\"\n{}{}", solid("ring", "region = \"7\"", 2e9), solid("skin", "", 1e5));
    let solids = with_solids(&mesh).unwrap();
    let order: Vec<(&str, &str)> = solids.parts.iter().map(|part| (part.name.as_str(), part.region())).collect();
    assert_eq!(order, [("skin", "skin"), ("ring", "7")]);
    let body = with_solids(&solid("body", "file = \"body.stl\"", 1e5)).unwrap();
    assert_eq!((body.parts.len(), body.file("body"), body.file("spine")), (1, Some("body.stl"), None));
}

#[test]
fn a_solid_without_a_source_or_with_two_is_refused() {
    let refused = |text: &str, said: &str| {
        let error = with_solids(text).unwrap_err();
        assert!(error.contains(said), "{error}");
    };
    let body = solid("body", "file = \"body.stl\"", 1e5);
    refused(&format!("mesh = \"arm.msh\"\n{body}"), "solid.body has a file");
    refused(&solid("body", "", 1e5), "solid.body has no file");
    refused(&solid("body", "region = \"3\"", 1e5), "solid.body has a region");
    refused(&format!("{body}{}", solid("ring", "file = \"ring.stl\"", 1e6)), "solid.ring has an STL file");
    refused(&solid("spine", "file = \"spine.stl\"", 1e5), "there is no [solid.body]");
}

#[test]
fn a_card_with_a_mesh_a_box_and_a_plane_is_read_back_the_same() {
    let solids = format!("mesh = \"arm.msh\"\n{}{}", solid("ring", "region = \"7\"", 2e9), solid("skin", "", 1e5));
    let (before, rest) = GOOD.split_once("[solid]").unwrap();
    let (_, after) = rest.split_once("below_x = 0.004").unwrap();
    for clamp in ["plane = { y = 0.01 }", "box = { low = [0.0, 0.0, 0.0], high = [0.1, 0.1, 0.1] }"] {
        let card = parsed(&format!("{before}[solid]\nunit = \"mm\"\n{solids}\n[clamp]\n{clamp}{after}")).unwrap();
        assert_eq!(parsed(&card::write(&card)).unwrap(), card);
    }
}

#[test]
fn the_nominal_stiffening_of_a_solid_is_read_and_one_out_of_range_is_refused() {
    let body = |ratios: &str| solid("body", &format!("file = \"body.stl\"\nstiffening = {ratios}"), 1e5);
    let solids = with_solids(&body("[0.02, 0.1]")).unwrap();
    assert_eq!(solids.parts[0].solid.stiffening, [0.02, 0.1]);
    assert!(with_solids(&body("[0.02, 20.0]")).unwrap_err().contains("stiffening.1"));
}

#[test]
fn the_uncertainty_of_a_stiffening_is_read_written_and_refused_where_it_is_not_positive() {
    let body = |sigma: &str| {
        let given = format!("file = \"body.stl\"\nstiffening = [0.02, 0.1]\nstiffening_sigma = {sigma}");
        with_solids(&solid("body", &given, 1e5))
    };
    let solids = body("[0.01, 0.005]").unwrap();
    assert_eq!(solids.parts[0].solid.stiffening_sigma, Some([0.01, 0.005]));
    assert!(body("[0.01, 0.0]").unwrap_err().contains("stiffening_sigma.1"));
    let mut card = parsed(GOOD).unwrap();
    assert_eq!(card.solid.parts[0].solid.stiffening_sigma, None);
    card.solid.parts[0].solid.stiffening_sigma = Some([0.01, 0.005]);
    assert_eq!(parsed(&card::write(&card)).unwrap().solid, card.solid);
}

#[test]
fn the_first_of_the_staircases_with_the_highest_level_is_found_and_flapping_has_none() {
    let levels = |levels: &[f64]| Experiment::Staircase {
        channels: vec!["left".into()],
        levels: levels.to_vec(),
        hold: 1.5,
        pause: 0.5,
    };
    let flaps = Experiment::Flapping { channels: vec!["left".into()], amplitude: 9e4, frequency: 2.0, cycles: 15 };
    let mut card = parsed(GOOD).unwrap();
    let trial = |(i, experiment)| lab::card::Trial { id: format!("t{i}"), experiment, ..card.trial[0].clone() };
    let all = [flaps, levels(&[1e4]), levels(&[3e4, 2e4]), levels(&[1e4, 3e4])];
    card.trial = all.into_iter().enumerate().map(trial).collect();
    assert_eq!(
        card.highest_staircase().map(|t| (t.id.as_str(), t.experiment.highest_level())),
        Some(("t2", Some(3e4)))
    );
    card.trial[2].medium = lab::card::Medium::Water;
    card.trial[3].medium = lab::card::Medium::Water;
    assert_eq!(card.highest_staircase_in_air().map(|t| t.id.as_str()), Some("t1"));
    card.trial[1].medium = lab::card::Medium::Water;
    assert_eq!(card.highest_staircase_in_air().map(|t| t.id.as_str()), Some("t2"));
    card.trial.truncate(1);
    assert!(card.highest_staircase().is_none() && card.highest_staircase_in_air().is_none());
}
