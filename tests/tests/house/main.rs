//! House rules: what STYLE and DESIGN ask of the tree, held by reading it.
//!
//! Each rule is a sentence that is a test, and each checker is tried on a small bad example, so that it can fail.
//!
//! Stands on: the files of the project, as text. Never knows: what the code computes.

mod arrows;
mod prose;
mod rooms;
mod shape;
mod source;
mod tree;

/// Fails with one line a complaint.
#[track_caller]
fn nobody_complains(complaints: Vec<String>) {
    assert!(complaints.is_empty(), "\n  {}", complaints.join("\n  "));
}
