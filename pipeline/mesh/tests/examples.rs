//! The examples do what they say.

#[path = "../examples/ball.rs"]
mod ball;

#[test]
fn the_ball_has_its_volume() {
    ball::main().unwrap();
}
