//! The examples do what they say.

#[path = "../examples/cantilever.rs"]
mod cantilever;

#[test]
fn the_cantilever_drops_as_a_beam() {
    cantilever::main().unwrap();
}
