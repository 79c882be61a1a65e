//! The examples do what they say.

#[path = "../examples/shallow_arch.rs"]
mod shallow_arch;

#[test]
fn the_arch_has_both_limit_points() {
    shallow_arch::main().unwrap();
}
