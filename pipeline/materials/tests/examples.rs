//! The examples do what they say.

#[path = "../examples/balloon.rs"]
mod balloon;

#[test]
fn the_balloon_follows_its_formula() {
    balloon::main().unwrap();
}
