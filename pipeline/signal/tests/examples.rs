//! The examples do what they say.

#[path = "../examples/two_clocks.rs"]
mod two_clocks;

#[test]
fn both_clocks_are_matched() {
    two_clocks::main().unwrap();
}
