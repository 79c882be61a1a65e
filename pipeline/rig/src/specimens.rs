//! The specimens that the bench records.
//!
//! A new specimen needs its shape and its line in [`ALL`] here, and its section in `bench.toml`.

use std::borrow::Cow;

use tail_cad::Tail;

use crate::specimen::Specimen;

/// Every specimen, in the order in which they are recorded.
pub const ALL: &[Specimen] = &[
    designed("nemo", nine_chambers),
    designed("dory", twelve_chambers),
    // Nemo's shape in the stiffer silicone
    designed("bruce", nine_chambers),
];

const fn designed(name: &'static str, tail: fn() -> Tail) -> Specimen {
    Specimen { name: Cow::Borrowed(name), tail, draw: None }
}

/// Nine chambers a side. The outer shape is the laboratory's tail. Walls and sheet are chosen so that 200 mbar on one side move the tip by
/// 18 mm, and 500 mbar move it by 15 mm in the stiffer silicone. The first chamber is longer than the others: near the clamp its slack
/// wall bulges from 250 mbar on, and equilibria exist up to 290 mbar.
fn nine_chambers() -> Tail {
    Tail {
        wall: [1.85e-3; 2],
        rib: 3.0e-3,
        inner_wall: 0.5e-3,
        top_wall: 1.85e-3,
        sheet: 0.69e-3,
        slot_share: 0.3,
        first_longer: 3.0e-3,
        ..Tail::nine_chambers()
    }
}

/// Twelve chambers a side, in the outer shape and with the sheet of [`nine_chambers`]. The walls are chosen so that 350 mbar on one side
/// move the tip by 17 mm and the tail withstands 500 mbar.
fn twelve_chambers() -> Tail {
    Tail {
        wall: [3.8e-3; 2],
        rib: 2.5e-3,
        inner_wall: 0.5e-3,
        top_wall: 2.9e-3,
        sheet: 0.69e-3,
        slot_share: 0.3,
        ..Tail::twelve_chambers()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::specimen::HiddenProperties;

    #[test]
    fn every_specimen_has_its_section_and_true_moduli_inside_the_plausible_range_of_its_card() {
        let settings = Settings::built_in();
        for specimen in ALL {
            let set = &settings.specimen[&*specimen.name];
            let hidden = HiddenProperties::drawn(&settings, set);
            let inside = |e: f64, [low, high]: [f64; 2]| low < e && e < high;
            assert!(inside(hidden.body.youngs_modulus, settings.material[&set.body].nominal.plausible));
            assert!(inside(hidden.spine.youngs_modulus, settings.material["acetal"].nominal.plausible));
            assert_eq!(hidden, HiddenProperties::drawn(&settings, set));
        }
    }

    #[test]
    fn specimens_of_one_material_share_its_properties_but_not_those_of_their_castings() {
        let settings = Settings::built_in();
        let [nemo, dory, bruce] =
            ["nemo", "dory", "bruce"].map(|n| HiddenProperties::drawn(&settings, &settings.specimen[n]));
        assert_eq!((&nemo.body, &nemo.spine), (&dory.body, &dory.spine));
        assert!(bruce.body != nemo.body && nemo.asymmetry != dory.asymmetry && nemo.marks != bruce.marks);
    }
}
