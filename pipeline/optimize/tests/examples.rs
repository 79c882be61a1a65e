//! The examples do what they say.

#[path = "../examples/rosenbrock.rs"]
mod rosenbrock;

#[test]
fn the_valley_is_followed_to_its_end() {
    rosenbrock::main().unwrap();
}
