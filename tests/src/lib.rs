//! Tests of the whole house live beside this file; here is only what several of them share.

/// The card of a small specimen, as a laboratory would write it.
pub const CARD: &str = include_str!("card.toml");
