//! Self-contact by the key of a case.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use simulate::{Body, case, load};
use std::path::Path;

/// The error of the finger's example with `contact` in its case; none where it is accepted.
fn refused(contact: &str) -> Option<String> {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let text = std::fs::read_to_string(examples.join("finger.toml")).unwrap();
    let case = case::parse(&format!("{text}\n[contact]\n{contact}"), Path::new("finger.toml")).unwrap();
    Body::new(&case, &load(&case, &examples).unwrap()).err().map(|error| error.to_string())
}

#[test]
fn the_contact_of_a_case_reaches_its_body() {
    assert_eq!(refused("range = 5e-4\npressure = 1.6e4"), None);
    assert!(refused("range = 0.5\npressure = 1.6e4").unwrap().contains("contact has the range"));
}
