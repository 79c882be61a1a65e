//! The family of specimens that the bench can record.
//!
//! A new one: its file here, its line in [`ALL`], its section in `bench.toml`.
//!
//! Stands on: the contract in `specimen`. Never knows: what is hidden in them.

mod bruce;
mod dory;
mod nemo;

use crate::specimen::Specimen;

/// Every specimen, in the order in which they are recorded.
pub const ALL: &[Specimen] = &[nemo::NEMO, dory::DORY, bruce::BRUCE];

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
            let hidden = Hidden::drawn(&settings, set);
            let inside = |e: f64, [low, high]: [f64; 2]| low < e && e < high;
            assert!(inside(hidden.body.youngs_modulus, settings.material[&set.body].nominal.plausible));
            assert!(inside(hidden.spine.youngs_modulus, settings.material["acetal"].nominal.plausible));
            assert_eq!(hidden, Hidden::drawn(&settings, set));
        }
    }

    #[test]
    fn specimens_of_one_material_share_what_it_hides_but_not_what_their_castings_hide() {
        let settings = Settings::built_in();
        let [nemo, dory, bruce] = ["nemo", "dory", "bruce"].map(|n| Hidden::drawn(&settings, &settings.specimen[n]));
        assert_eq!((&nemo.body, &nemo.spine), (&dory.body, &dory.spine));
        assert!(bruce.body != nemo.body && nemo.asymmetry != dory.asymmetry && nemo.marks != bruce.marks);
    }
}
