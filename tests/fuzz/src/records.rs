//! Files of records, scalars as JSON beside tables that belong to them; and the settings of a study.
//!
//! Tables are not fuzzed: the reader of Parquet is another project's, and a record is only unpacked when its files have the hashes of its
//! manifest.

use std::sync::OnceLock;

use records::{Camera, Drag, Findings, FourParameters, MeshSensitivity, Recovered, Reduced, Relaxation, Transfer};
use workflow::columns::Columns;
use workflow::record::{Record, RecordError, RecordFiles};
use workflow::settings::Profile;

/// The tables of a reduced model of two coordinates, two nodes and three points in two regions.
fn tables() -> &'static RecordFiles {
    static TABLES: OnceLock<RecordFiles> = OnceLock::new();
    TABLES.get_or_init(|| {
        let modes = Columns::default().numbers("q0_m", vec![0.1; 6]).numbers("q1_m", vec![-0.2; 6]);
        let points = Columns::default()
            .counts("region", vec![0, 0, 1])
            .counts("point", vec![3, 7, 9])
            .numbers("weight_m3", vec![1e-9, 2e-9, 3e-9]);
        let files = RecordFiles::default().table("modes.parquet", &modes);
        files.and_then(|files| files.table("points.parquet", &points)).unwrap_or_default()
    })
}

/// Settings are read for each profile, and refused as `study.toml`.
pub fn settings(text: &str) {
    Profile::ALL.iter().for_each(|profile| crate::named(study::settings(text, *profile), "study.toml"));
}

/// A reduced model of these scalars.
pub fn reduced(bytes: &[u8]) {
    names_one_of(Reduced::from_files(&tables().clone().file("reduced.json", bytes.to_vec())), &[".json", ".parquet"]);
}

/// A record of scalars alone: its name in the first line, then the scalars.
pub fn scalars(bytes: &[u8]) {
    let end = bytes.iter().position(|byte| *byte == b'\n').unwrap_or(bytes.len());
    let (name, json) = (&bytes[..end], bytes.get(end + 1..).unwrap_or_default());
    match name {
        b"camera" => unpack::<Camera>("camera.json", json),
        b"drag" => unpack::<Drag>("drag.json", json),
        b"findings" => unpack::<Findings>("findings.json", json),
        b"four_parameters" => unpack::<FourParameters>("four_parameters.json", json),
        b"mesh_sensitivity" => unpack::<MeshSensitivity>("mesh_sensitivity.json", json),
        b"recovered" => unpack::<Recovered>("recovered.json", json),
        b"relaxation" => unpack::<Relaxation>("relaxation.json", json),
        b"transfer" => unpack::<Transfer>("transfer.json", json),
        _ => {}
    }
}

/// What is read has a summary and metrics, as every reader of a record asks for.
fn unpack<R: Record>(file: &str, json: &[u8]) {
    let record = R::from_files(&RecordFiles::default().file(file, json.to_vec()));
    if let Ok(record) = &record {
        drop((record.summary(), record.metrics("subject")));
    }
    names_one_of(record, &[file]);
}

/// Holds that a refusal names a file; the runner adds the record and what to do.
fn names_one_of<T>(read: Result<T, RecordError>, files: &[&str]) {
    if let Err(refusal) = read {
        let message = refusal.to_string();
        assert!(files.iter().any(|file| message.contains(file)), "the refusal names none of {files:?}: {message}");
    }
}
