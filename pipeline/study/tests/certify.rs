//! `study check gradients` on the cases that come with the project.
//!
//! Stands on: `study` as its users see it. Never knows: how a gradient is made.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::Path;

#[test]
fn every_gradient_of_every_example_holds() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let cases = study::certify::examples(&root).unwrap();
    assert!(cases.len() >= 3, "{cases:?}");
    for case in cases {
        let certificate = study::certify::run(&case, 6).unwrap();
        assert!(certificate.holds(), "{certificate}");
    }
}
