//! Differences between the inputs of a record and the present ones, in words.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use super::manifest::MadeFrom;

/// The differences between the inputs of a record and the present ones, one sentence each.
pub fn differences(before: &MadeFrom, now: &MadeFrom) -> Vec<String> {
    let mut found = Vec::new();
    if before.version != now.version {
        found.push(format!("the stage is of version {}, the record of version {}", now.version, before.version));
    }
    found.extend(settings("setting", "", &before.settings, &now.settings));
    found.extend(settings("card entry", "", &before.card, &now.card));
    hashes("recording", &before.raw, &now.raw, &mut found);
    hashes("record", &before.records, &now.records, &mut found);
    found
}

/// The differences between two values, of which `path` is the key.
fn settings(what: &str, path: &str, before: &Value, now: &Value) -> Vec<String> {
    if before == now {
        return Vec::new();
    }
    let (Value::Object(a), Value::Object(b)) = (before, now) else {
        return vec![format!("{what} `{path}` was {} and is {}", shown(before), shown(now))];
    };
    let keys: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    let of_key = |key: &String| {
        let deeper = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        settings(what, &deeper, a.get(key).unwrap_or(&Value::Null), b.get(key).unwrap_or(&Value::Null))
    };
    keys.into_iter().flat_map(of_key).collect()
}

fn shown(value: &Value) -> String {
    match value {
        Value::Null => "absent".into(),
        other => {
            let text = other.to_string();
            if text.chars().count() > 60 { text.chars().take(57).collect::<String>() + "…" } else { text }
        }
    }
}

fn hashes(what: &str, before: &BTreeMap<String, String>, now: &BTreeMap<String, String>, found: &mut Vec<String>) {
    let new = now.keys().filter(|name| !before.contains_key(*name));
    let other = now.iter().filter(|(name, hash)| before.get(*name).is_some_and(|old| old != *hash));
    let gone = before.keys().filter(|name| !now.contains_key(*name));
    found.extend(named(what, new.collect(), "new to it"));
    found.extend(named(what, other.map(|(name, _)| name).collect(), "of other content"));
    found.extend(named(what, gone.collect(), "no longer read"));
}

/// One sentence about all these names, of which the first is given.
fn named(what: &str, names: Vec<&String>, how: &str) -> Option<String> {
    let first = names.first()?;
    Some(match names.len() {
        1 => format!("{what} `{first}` is {how}"),
        count => format!("{what} `{first}` and {} more are {how}", count - 1),
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
        let found = differences(&made_from(json!({"edge": 0.004})), &made_from(json!({"edge": 0.003})));
        assert_eq!(found, ["setting `edge` was 0.004 and is 0.003"]);
    }

    #[test]
    fn equal_ingredients_differ_in_nothing_and_share_a_key() {
        let (a, b) = (made_from(json!({"edge": 1})), made_from(json!({"edge": 1})));
        assert!(differences(&a, &b).is_empty());
        assert_eq!(a.key(), b.key());
    }

    #[test]
    fn many_records_of_other_content_are_reported_in_one_sentence() {
        let of = |hash: &str| -> BTreeMap<String, String> { ["a", "b", "c"].map(|n| (n.into(), hash.into())).into() };
        let (mut before, mut now) = (made_from(Value::Null), made_from(Value::Null));
        (before.records, now.records) = (of("old"), of("new"));
        assert_eq!(differences(&before, &now), ["record `a` and 2 more are of other content"]);
    }

    #[test]
    fn another_edition_or_recording_is_named() {
        let (before, mut now) = (made_from(Value::Null), made_from(Value::Null));
        now.version = 2;
        now.raw.insert("fish/video.mp4".into(), "cd".into());
        let found = differences(&before, &now);
        assert!(found[0].contains("version 2") && found[1].contains("fish/video.mp4"));
    }
}
