//! Conventions of the code, held by reading it: dependencies, file layout, names, what stages may touch.
//!
//! Each convention is a test; each checker is tried on a small bad example, so that it can fail.

mod citations;
mod contents;
mod cycles;
mod dependencies;
mod files;
mod functions;
mod names;
mod pages;
mod readers;
mod source;
mod stages;
mod tree;
mod visibility;
mod vocabulary;

/// Fails with one line a complaint.
#[track_caller]
fn assert_none(complaints: Vec<String>) {
    assert!(complaints.is_empty(), "\n  {}", complaints.join("\n  "));
}
