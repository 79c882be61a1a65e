//! `study check gradients` on the cases that come with the project.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::Path;

#[test]
fn every_gradient_of_every_example_holds() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let cases = simulate::gradient_check::examples(&root).unwrap();
    assert!(cases.len() >= 3, "{cases:?}");
    for case in cases {
        let report = simulate::gradient_check::run(&case, 6).unwrap();
        assert!(report.holds(), "{report}");
    }
}
