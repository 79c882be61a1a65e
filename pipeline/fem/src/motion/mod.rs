//! Motion: steps in time, of one length or of their own choice, recorded, and differentiated both ways.
//!
//! Stands on: `solver`, `descent`. Never knows: where pressures come from.

mod adaptive;
pub(crate) mod backward;
mod dynamics;
mod forward;
pub(crate) mod gather;
pub(crate) mod march;
mod products;
pub(crate) mod stencil;
pub(crate) mod trajectory;
mod wear;
