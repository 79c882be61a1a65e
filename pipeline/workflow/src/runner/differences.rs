//! Differences between the inputs of a record and the present ones, in words.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use super::manifest::MadeFrom;

/// The differences between the inputs of a record and the present ones, one sentence each.
pub fn differences(recorded: &MadeFrom, present: &MadeFrom) -> Vec<String> {
    let mut sentences = Vec::new();
    if recorded.version != present.version {
        sentences
            .push(format!("the stage is of version {}, the record of version {}", present.version, recorded.version));
    }
    sentences.extend(setting_differences("setting", "", &recorded.settings, &present.settings));
    sentences.extend(setting_differences("card entry", "", &recorded.card, &present.card));
    hash_differences("recording", &recorded.raw, &present.raw, &mut sentences);
    hash_differences("record", &recorded.records, &present.records, &mut sentences);
    sentences
}

/// The differences between two values, of which `path` is the key.
fn setting_differences(kind: &str, path: &str, recorded: &Value, present: &Value) -> Vec<String> {
    if recorded == present {
        return Vec::new();
    }
    let (Value::Object(a), Value::Object(b)) = (recorded, present) else {
        return vec![format!("{kind} `{path}` was {} and is {}", display_value(recorded), display_value(present))];
    };
    let keys: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    let of_key = |key: &String| {
        let deeper = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        setting_differences(kind, &deeper, a.get(key).unwrap_or(&Value::Null), b.get(key).unwrap_or(&Value::Null))
    };
    keys.into_iter().flat_map(of_key).collect()
}

fn display_value(value: &Value) -> String {
    match value {
        Value::Null => "absent".into(),
        value => {
            let text = value.to_string();
            if text.chars().count() > 60 { text.chars().take(57).collect::<String>() + "…" } else { text }
        }
    }
}

fn hash_differences(
    kind: &str,
    recorded: &BTreeMap<String, String>,
    present: &BTreeMap<String, String>,
    sentences: &mut Vec<String>,
) {
    let added = present.keys().filter(|name| !recorded.contains_key(*name));
    let changed = present.iter().filter(|(name, hash)| recorded.get(*name).is_some_and(|old| old != *hash));
    let removed = recorded.keys().filter(|name| !present.contains_key(*name));
    sentences.extend(change_sentence(kind, added.collect(), "new to it"));
    sentences.extend(change_sentence(kind, changed.map(|(name, _)| name).collect(), "of other content"));
    sentences.extend(change_sentence(kind, removed.collect(), "no longer read"));
}

/// One sentence about all these names, of which the first is given.
fn change_sentence(kind: &str, names: Vec<&String>, how: &str) -> Option<String> {
    let first = names.first()?;
    Some(match names.len() {
        1 => format!("{kind} `{first}` is {how}"),
        count => format!("{kind} `{first}` and {} more are {how}", count - 1),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn made_from(settings: Value) -> MadeFrom {
        let raw = BTreeMap::from([("fish/video.mp4".to_string(), "ab".to_string())]);
        MadeFrom { version: 1, raw, card: Value::Null, settings, records: BTreeMap::new() }
    }

    #[test]
    fn a_changed_setting_is_named_with_both_values() {
        let sentences = differences(&made_from(json!({"edge": 0.004})), &made_from(json!({"edge": 0.003})));
        assert_eq!(sentences, ["setting `edge` was 0.004 and is 0.003"]);
    }

    #[test]
    fn equal_ingredients_differ_in_nothing_and_share_a_key() {
        let (a, b) = (made_from(json!({"edge": 1})), made_from(json!({"edge": 1})));
        assert!(differences(&a, &b).is_empty());
        assert_eq!(a.key(), b.key());
    }

    #[test]
    fn many_records_of_other_content_are_reported_in_one_sentence() {
        let hashes =
            |hash: &str| -> BTreeMap<String, String> { ["a", "b", "c"].map(|n| (n.into(), hash.into())).into() };
        let (mut recorded, mut present) = (made_from(Value::Null), made_from(Value::Null));
        (recorded.records, present.records) = (hashes("old"), hashes("new"));
        assert_eq!(differences(&recorded, &present), ["record `a` and 2 more are of other content"]);
    }

    #[test]
    fn another_edition_or_recording_is_named() {
        let (recorded, mut present) = (made_from(Value::Null), made_from(Value::Null));
        present.version = 2;
        present.raw.insert("fish/video.mp4".into(), "cd".into());
        let sentences = differences(&recorded, &present);
        assert!(sentences[0].contains("version 2") && sentences[1].contains("fish/video.mp4"));
    }
}
