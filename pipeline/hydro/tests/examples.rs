//! The examples do what they say.

#[path = "../examples/heaving_plate.rs"]
mod heaving_plate;

#[test]
fn the_plate_is_pushed_by_its_added_mass() {
    heaving_plate::main().unwrap();
}
