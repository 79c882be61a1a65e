//! The family of specimens that the bench can record.
//!
//! A new one: its file here, its line in [`ALL`], its section in `bench.toml`.
//!
//! Stands on: the contract in `specimen`. Never knows: what is hidden in them.

mod nemo;

use crate::specimen::Specimen;

/// Every specimen, in the order in which they are recorded.
pub const ALL: &[Specimen] = &[nemo::NEMO];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::specimen::Hidden;

    #[test]
    fn every_specimen_has_its_section_and_hides_values_inside_the_box_on_its_card() {
        let settings = Settings::built_in();
        for specimen in ALL {
            let set = &settings.specimen[specimen.name];
            let hidden = Hidden::drawn(set);
            let inside = |e: f64, [low, high]: [f64; 2]| low < e && e < high;
            assert!(inside(hidden.body.youngs_modulus, set.nominal_body.plausible));
            assert!(inside(hidden.spine.youngs_modulus, set.nominal_spine.plausible));
            assert_eq!(hidden, Hidden::drawn(set));
        }
    }
}
