//! What a study shows of itself: the tree and the drawing of its stages, and its description for archives.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use workflow::runner::Goal;

use crate::small::{Project, SETTINGS};

/// Every file of a folder with its bytes.
pub fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let (folders, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    let own = files.into_iter().map(|file| (file.clone(), fs::read(file).unwrap()));
    own.chain(folders.iter().flat_map(|folder| bytes(folder))).collect()
}

#[test]
fn the_tree_hangs_each_stage_under_what_it_reads_and_says_what_would_be_made() {
    let project = Project::new("tree");
    let tree = |settings: &str| project.runner(settings).tree(&Goal::default()).unwrap();
    assert!(tree(SETTINGS).contains("└─ halved  1 to make"), "{}", tree(SETTINGS));
    project.run(SETTINGS);
    let lines = tree(SETTINGS);
    let (letters, halved) = (lines.find("letters  1 kept").unwrap(), lines.find("halved  1 kept").unwrap());
    assert!(letters < halved && lines.contains("alone  1 kept"), "{lines}");
}

#[test]
fn the_drawing_names_every_stage() {
    let project = Project::new("drawing");
    let svg = study::plan_svg(&project.runner(SETTINGS), &Goal::default()).unwrap();
    assert!(
        svg.starts_with("<svg") && ["letters", "halved", "alone", "1 to make"].iter().all(|word| svg.contains(word))
    );
}

#[test]
fn the_description_for_archives_names_each_record_its_ingredients_and_its_maker() {
    let project = Project::new("crate");
    project.run(SETTINGS);
    let text = fs::read(project.0.join("data/processed/ro-crate-metadata.json")).unwrap();
    let described: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let graph = described["@graph"].as_array().unwrap();
    let named = |id: &str| graph.iter().find(|thing| thing["@id"] == id).unwrap_or_else(|| panic!("{id} is missing"));
    assert_eq!(named("./")["hasPart"].as_array().unwrap().len(), 3);
    let objects = |made: &str| {
        let made = named(made)["object"].as_array().unwrap().iter();
        made.map(|object| object["@id"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(objects("#made/halved/fish"), ["#settings/halved/fish", "letters/fish/record/"]);
    assert_eq!(objects("#made/letters/fish")[0], "#recording/fish/cad/body.stl");
    let made = named("#made/halved/fish");
    assert_eq!(
        (&made["instrument"]["@id"], &made["result"]["@id"]),
        (&"#halved".into(), &"halved/fish/record/".into())
    );
    let time = |key: &str| made[key].as_str().unwrap();
    assert!(time("startTime") <= time("endTime") && time("endTime").ends_with("+00:00"));
    assert!(named("#letters")["softwareVersion"].as_str().unwrap().ends_with("version 1"));
    assert_eq!(named("#settings/halved/fish")["value"], "{\"step\":1}");
}

#[test]
fn every_entity_of_the_description_is_described_once_and_every_folder_exists() {
    let project = Project::new("entities");
    project.run(SETTINGS);
    let text = fs::read_to_string(project.0.join("data/processed/ro-crate-metadata.json")).unwrap();
    let read: serde_json::Value = serde_json::from_str(&text).unwrap();
    let ids = read["@graph"].as_array().unwrap().iter().map(|entity| entity["@id"].as_str().unwrap());
    let ids: Vec<&str> = ids.collect();
    let named = text.split("\"@id\": \"").skip(1).map(|rest| rest.split('"').next().unwrap());
    let outside = "https://w3id.org/ro/crate/1.1";
    assert!(named.filter(|id| *id != outside).all(|id| ids.iter().filter(|known| **known == id).count() == 1));
    let folders = ids.iter().filter(|id| id.ends_with("/record/"));
    assert_eq!(folders.filter(|id| project.0.join("data/processed").join(id).is_dir()).count(), 3);
}
