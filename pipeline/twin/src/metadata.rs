//! What a reduced tail's file says in words: counts, names, symmetry and provenance, as the metadata of safetensors.
//!
//! Names are separated by commas; provenance is `key=value`, separated by semicolons.

use std::collections::HashMap;

use crate::data::TwinData;
use crate::layout::Counts;

/// Key of [`Counts`].
pub(crate) const COUNTS: &str = "counts";
const REGIONS: &str = "regions";
const CHAMBERS: &str = "chambers";
const OUTPUTS: &str = "outputs";
const SYMMETRY: &str = "symmetry";
const PROVENANCE: &str = "provenance";
/// Values of the symmetry.
const HALF: &str = "half";
const WHOLE: &str = "whole";

/// The words that go with the arrays.
pub(crate) struct Description {
    pub regions: Vec<String>,
    pub chambers: Vec<String>,
    pub outputs: Vec<String>,
    pub half: bool,
    pub provenance: Vec<(String, String)>,
}

impl Description {
    /// Of the metadata of a tail with these counts.
    pub(crate) fn parse(metadata: &HashMap<String, String>, counts: &Counts) -> Result<Self, String> {
        let text = |key: &str| metadata.get(key).ok_or_else(|| format!("its metadata have no `{key}`"));
        let names = |key: &str, count: usize| {
            let names: Vec<String> = text(key)?.split(',').filter(|_| count > 0).map(str::to_owned).collect();
            let is_complete = names.len() == count;
            is_complete.then_some(()).ok_or_else(|| format!("its metadata name {} {key}, not {count}", names.len()))?;
            Ok::<_, String>(names)
        };
        let half = match text(SYMMETRY)?.as_str() {
            HALF => true,
            WHOLE => false,
            _ => return Err(format!("its metadata state a `{SYMMETRY}` that is neither `{HALF}` nor `{WHOLE}`")),
        };
        let entry = |entry: &str| entry.split_once('=').map(|(key, value)| (key.to_owned(), value.to_owned()));
        let provenance = text(PROVENANCE)?.split(';').filter(|entry| !entry.is_empty()).map(entry);
        let provenance: Option<Vec<_>> = provenance.collect();
        Ok(Self {
            regions: names(REGIONS, counts.points.len())?,
            chambers: names(CHAMBERS, counts.chambers)?,
            outputs: names(OUTPUTS, counts.outputs)?,
            half,
            provenance: provenance
                .ok_or_else(|| format!("its metadata have a `{PROVENANCE}` that is not `key=value`"))?,
        })
    }
}

/// The metadata of a tail as a JSON object.
// By hand, and in this order: safetensors takes metadata as a hash map, whose order changes from run to run, and two files of one tail shall
// have the same bytes.
pub(crate) fn json_object(data: &TwinData) -> String {
    let provenance: Vec<String> = data.provenance.iter().map(|(key, value)| format!("{key}={value}")).collect();
    let entries = [
        (COUNTS, Counts::of_data(data).as_text()),
        (REGIONS, joined(data.regions.iter().map(|region| &*region.name))),
        (CHAMBERS, joined(data.chambers.iter().map(|chamber| &*chamber.name))),
        (OUTPUTS, joined(data.outputs.iter().map(|output| &*output.name))),
        (SYMMETRY, if data.half { HALF } else { WHOLE }.to_owned()),
        (PROVENANCE, provenance.join(";")),
    ];
    let quoted = |text: &str| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""));
    let entries = entries.map(|(key, value)| format!("{}:{}", quoted(key), quoted(&value)));
    format!("{{{}}}", entries.join(","))
}

fn joined<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(",")
}
