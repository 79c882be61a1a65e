//! The crate by itself, as it is exported beside a tail's arrays: its sources without tests, its manifest and its example.

/// The sources, and the example that closes a loop.
const SOURCES: &[(&str, &str)] = &[
    ("src/adjoint.rs", include_str!("adjoint.rs")),
    ("src/chambers.rs", include_str!("chambers.rs")),
    ("src/check.rs", include_str!("check.rs")),
    ("src/data.rs", include_str!("data.rs")),
    ("src/data_sheet.rs", include_str!("data_sheet.rs")),
    ("src/dense.rs", include_str!("dense.rs")),
    ("src/elastic.rs", include_str!("elastic.rs")),
    ("src/equations.rs", include_str!("equations.rs")),
    ("src/error.rs", include_str!("error.rs")),
    ("src/example.rs", include_str!("example.rs")),
    ("src/file.rs", include_str!("file.rs")),
    ("src/gradient.rs", include_str!("gradient.rs")),
    ("src/gradient_check.rs", include_str!("gradient_check.rs")),
    ("src/history.rs", include_str!("history.rs")),
    ("src/lanes.rs", include_str!("lanes.rs")),
    ("src/law.rs", include_str!("law.rs")),
    ("src/layout.rs", include_str!("layout.rs")),
    ("src/lib.rs", include_str!("lib.rs")),
    ("src/metadata.rs", include_str!("metadata.rs")),
    ("src/recording.rs", include_str!("recording.rs")),
    ("src/saved_state.rs", include_str!("saved_state.rs")),
    ("src/single_precision.rs", include_str!("single_precision.rs")),
    ("src/solid_adjoint.rs", include_str!("solid_adjoint.rs")),
    ("src/state.rs", include_str!("state.rs")),
    ("src/step.rs", include_str!("step.rs")),
    ("src/twin.rs", include_str!("twin.rs")),
    ("src/unpack.rs", include_str!("unpack.rs")),
    ("src/water.rs", include_str!("water.rs")),
    ("src/water_adjoint.rs", include_str!("water_adjoint.rs")),
    ("src/workspace.rs", include_str!("workspace.rs")),
    ("examples/tip_control.rs", include_str!("../examples/tip_control.rs")),
    ("examples/step_times.rs", include_str!("../examples/step_times.rs")),
    ("c/src/lib.rs", include_str!("../c/lib.rs")),
    ("c/twin.h", include_str!("../c/twin.h")),
    ("c/tip_control.c", include_str!("../c/tip_control.c")),
];

/// The same versions and the same instruction set as in the project.
const MANIFESTS: [(&str, &str); 3] = [
    (
        "Cargo.toml",
        "[package]\nname = \"twin\"\nversion = \"0.1.0\"\nedition = \"2024\"\nlicense = \"MIT OR Apache-2.0\"\n\n[dependencies]\n\
         safetensors = { version = \"=0.8.0\", default-features = false, features = [\"std\"] }\nthiserror = \"=2.0.21\"\n\
         wide = { version = \"=1.7.1\", default-features = false }\n\n[features]\nportable = []\n\n[workspace]\n",
    ),
    // a folder of its own: functions for C need unsafe code, which the crate does without
    (
        "c/Cargo.toml",
        "[package]\nname = \"twin_c\"\nversion = \"0.1.0\"\nedition = \"2024\"\nlicense = \"MIT OR Apache-2.0\"\n\n[lib]\n\
         crate-type = [\"cdylib\", \"staticlib\"]\n\n[dependencies]\ntwin = { path = \"..\" }\n\n[workspace]\n",
    ),
    (
        ".cargo/config.toml",
        "[target.'cfg(target_arch = \"x86_64\")']\nrustflags = [\"-C\", \"target-cpu=x86-64-v3\"]\n",
    ),
];

/// Every file of the crate by itself: path and content.
pub fn files() -> Vec<(&'static str, String)> {
    let manifests = MANIFESTS.iter().map(|(path, text)| (*path, (*text).to_owned()));
    SOURCES.iter().map(|(path, text)| (*path, standalone_source(text))).chain(manifests).collect()
}

/// A source without its tests, and without what serves the page and the export.
fn standalone_source(text: &str) -> String {
    let text = text.split("\n#[cfg(test)]").next().unwrap_or_default();
    let serves_the_export =
        |line: &str| line.contains("mod package") || line.contains("[`package`]") || line.contains("SCRIPT");
    let is_kept = |line: &&str| !serves_the_export(line);
    text.lines().filter(is_kept).flat_map(|line| [line, "\n"]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_source_is_exported_and_none_has_tests() {
        let files = files();
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src");
        let own = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        for name in own.filter(|name| name.ends_with(".rs") && name != "package.rs") {
            assert!(files.iter().any(|(path, _)| *path == format!("src/{name}")), "{name} is not exported");
        }
        assert!(files.iter().all(|(_, text)| !text.contains("#[test]") && !text.contains("SCRIPT")));
    }

    #[test]
    fn the_manifest_has_the_versions_of_the_project() {
        let project = include_str!("../../../Cargo.toml");
        assert!(include_str!("../../../.cargo/config.toml").ends_with(MANIFESTS[2].1));
        for line in MANIFESTS[0].1.lines().filter(|line| line.contains("version = \"=") || line.contains("thiserror")) {
            assert!(project.contains(line), "{line}");
        }
    }
}
