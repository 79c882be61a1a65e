//! Costs of the bench: drawing films, and equilibria while a wall buckles.
#![allow(clippy::print_stdout)] // a bench prints

mod buckling;
mod filming;

fn main() {
    filming::print();
    buckling::print();
}
