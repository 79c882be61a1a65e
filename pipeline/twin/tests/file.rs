//! Damaged files of a tail: each is refused with the file and the array that is wrong.
#![allow(clippy::unwrap_used)] // tests

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use twin::example::beam;
use twin::file;

const FILE: &str = "tail.safetensors";

/// A file's arrays and metadata, to be damaged.
struct Parts {
    arrays: BTreeMap<String, (Vec<usize>, Vec<f64>)>,
    metadata: HashMap<String, String>,
}

impl Parts {
    fn whole() -> Self {
        let bytes = file::bytes(&beam(true)).unwrap();
        let read = SafeTensors::deserialize(&bytes).unwrap();
        let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap());
        let array = |name: &str| {
            let view = read.tensor(name).unwrap();
            (view.shape().to_vec(), view.data().chunks_exact(8).map(number).collect())
        };
        let metadata = SafeTensors::read_metadata(&bytes).unwrap().1.metadata().clone().unwrap();
        Self { arrays: read.names().into_iter().map(|name| (name.to_owned(), array(name))).collect(), metadata }
    }

    fn bytes(&self) -> Vec<u8> {
        let raw = self.arrays.iter().map(|(name, (shape, values))| {
            (name, shape, values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())
        });
        let raw: Vec<_> = raw.collect();
        let views = raw
            .iter()
            .map(|(name, shape, bytes)| (*name, TensorView::new(Dtype::F64, (*shape).clone(), bytes).unwrap()));
        safetensors::serialize(views, Some(self.metadata.clone())).unwrap()
    }

    fn shape(&mut self, name: &str) -> &mut Vec<usize> {
        &mut self.arrays.get_mut(name).unwrap().0
    }

    fn value(&mut self, name: &str, at: usize) -> &mut f64 {
        &mut self.arrays.get_mut(name).unwrap().1[at]
    }

    /// Keeps so many rows.
    fn cut(&mut self, name: &str, rows: usize) {
        let (shape, values) = self.arrays.get_mut(name).unwrap();
        values.truncate(values.len() / shape[0] * rows);
        shape[0] = rows;
    }

    fn without(&mut self, part: &str) {
        self.arrays.retain(|name, _| !name.starts_with(part));
    }
}

/// Holds that a file damaged by `damage` is refused with its name and these words.
#[track_caller]
fn refused(words: &str, damage: impl Fn(&mut Parts)) {
    let mut parts = Parts::whole();
    damage(&mut parts);
    let error = file::parse(&parts.bytes(), Path::new(FILE)).unwrap_err().to_string();
    assert!(error.starts_with(&format!("{FILE}: ")) && error.contains(words), "{error}");
}

#[test]
fn a_file_whose_parts_are_only_taken_apart_is_read() {
    assert_eq!(file::parse(&Parts::whole().bytes(), Path::new(FILE)).unwrap(), beam(true));
}

#[test]
fn an_array_that_is_cut_or_has_other_axes_is_refused_by_name() {
    refused("`region0.gradients` has the shape [80, 9, 7], not [80, 7, 9]", |parts| {
        parts.shape("region0.gradients").swap(1, 2);
    });
    refused("`sections.slope` has the shape [10, 2, 7], not [13, 2, 7]", |parts| {
        ["sections.slope", "sections.value", "sections.by"].iter().for_each(|name| parts.cut(name, 10));
    });
    refused("`outputs` has the shape [1, 7], not [2, 7]", |parts| parts.cut("outputs", 1));
    refused("`region0.branches` has the shape [4], not [2, 2]", |parts| *parts.shape("region0.branches") = vec![4]);
    refused("`size` has the shape [0], not [1]", |parts| parts.cut("size", 0));
    refused("`chamber1.cubic` has the shape [27, 7], not [28, 7]", |parts| parts.cut("chamber1.cubic", 27));
}

#[test]
fn a_region_or_a_chamber_that_is_removed_is_missed_and_another_array_is_refused() {
    refused("no array `region0.moduli`", |parts| parts.without("region0"));
    refused("no array `chamber0.range`", |parts| parts.without("chamber0"));
    refused("no array `chamber1.range`", |parts| parts.without("chamber1"));
    refused("the array \"region1.moduli\"", |parts| {
        let moduli = parts.arrays["region0.moduli"].clone();
        parts.arrays.insert("region1.moduli".into(), moduli);
    });
}

#[test]
fn names_that_do_not_agree_with_the_rows_are_refused() {
    let named =
        |names: &'static str| move |parts: &mut Parts| drop(parts.metadata.insert("outputs".into(), names.into()));
    refused("name 1 outputs, not 2", named("tip_x"));
    refused("the name \"\"", named("tip_x,"));
    refused("the name \"tip\" twice", named("tip,tip"));
    refused("no `outputs`", |parts| drop(parts.metadata.remove("outputs")));
}

#[test]
fn counts_that_are_missing_or_larger_than_the_file_are_refused() {
    let counts =
        |text: &'static str| move |parts: &mut Parts| drop(parts.metadata.insert("counts".into(), text.into()));
    refused("no `counts`", |parts| drop(parts.metadata.remove("counts")));
    for text in [
        "",
        "coordinates=7",
        "coordinates=7;points=80;branches=2,2;chambers=2;sections=13;outputs=2",
        "coordinates=-7;points=80;branches=2;chambers=2;sections=13;outputs=2",
        "coordinates=9999999999;points=80;branches=2;chambers=2;sections=13;outputs=2",
        "coordinates=7;points=80;branches=2;chambers=4000;sections=13;outputs=2",
    ] {
        refused("state the counts", counts(text));
    }
}

#[test]
fn a_number_that_no_body_has_is_refused_by_its_array() {
    let set = |name: &'static str, at: usize, value: f64| move |parts: &mut Parts| *parts.value(name, at) = value;
    refused("`region0.moduli` holds NaN", set("region0.moduli", 1, f64::NAN));
    refused("`sections.by` holds inf", set("sections.by", 3, f64::INFINITY));
    refused("`chamber0.at_rest` holds NaN", set("chamber0.at_rest", 0, f64::NAN));
    refused("`chamber0.at_rest` has -1", set("chamber0.at_rest", 0, -1.0));
    refused("`size` has 0", set("size", 0, 0.0));
    refused("`mass` is not symmetric", set("mass", 1, 1.0));
    refused("`mass` is not positive definite", |parts| {
        parts.arrays.get_mut("mass").unwrap().1.iter_mut().for_each(|m| *m = -*m)
    });
    refused("`region0.moduli` has -1", set("region0.moduli", 0, -1.0));
    refused("a bulk modulus of", set("region0.moduli", 1, -1e9));
    refused("`region0.branches` has -0.1", set("region0.branches", 0, -0.1));
    refused("`region0.branches` has -0.1", set("region0.branches", 1, -0.1));
    refused("`region0.weights` has -0.1", set("region0.weights", 3, -0.1));
    refused("`sections.by` has -0.1", set("sections.by", 0, -0.1));
}

#[test]
fn a_file_cut_anywhere_is_refused_by_name() {
    let whole = file::bytes(&beam(true)).unwrap();
    for part in 0..40 {
        let error = file::parse(&whole[..whole.len() * part / 40], Path::new(FILE)).unwrap_err().to_string();
        assert!(error.starts_with(FILE), "{error}");
    }
}

fn temporary(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("twin-{name}-{}", std::process::id()))
}

#[test]
fn a_folder_a_device_and_a_file_above_the_limit_are_refused_before_they_are_read() {
    let large = temporary("large");
    std::fs::File::create(&large).unwrap().set_len(100 << 30).unwrap();
    let error = file::read(&large).unwrap_err().to_string();
    std::fs::remove_file(&large).unwrap();
    assert!(error.contains("it has 102400 MiB; the limit is 512 MiB"), "{error}");
    for path in [std::env::temp_dir(), PathBuf::from("/dev/zero")].iter().filter(|path| path.exists()) {
        let error = file::read(path).unwrap_err().to_string();
        assert!(error.starts_with(&path.display().to_string()) && error.contains("no regular file"), "{error}");
    }
}

#[test]
fn a_file_that_is_written_is_read_again() {
    let path = temporary("written");
    file::write(&path, &beam(true)).unwrap();
    let read = file::read(&path);
    std::fs::remove_file(&path).unwrap();
    assert_eq!(read.unwrap(), beam(true));
}
