//! The examples do what they say.

#[path = "../examples/spring_chain.rs"]
mod spring_chain;

#[test]
fn the_chain_stretches_evenly() {
    spring_chain::main().unwrap();
}
