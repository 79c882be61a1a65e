//! The examples do what they say.

#[path = "../examples/lens.rs"]
mod lens;

#[test]
fn the_hidden_lens_comes_back() {
    lens::main().unwrap();
}
