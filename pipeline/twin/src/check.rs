//! What the arrays of a reduced tail must be: shapes that agree, finite numbers, a mass matrix of a body, moduli of a stable solid.

use std::collections::BTreeSet;

use crate::data::{Region, TwinData};
use crate::error::TwinError;
use crate::layout::{Counts, array_numbers};

/// Largest difference of a mass from its transposed one, relative to the masses of both coordinates: the rounding of a sum over elements.
const ASYMMETRY: f64 = 1e-9;

type Checked = Result<(), String>;

impl TwinData {
    /// # Errors
    /// [`TwinError::Data`] when the lengths do not agree or a number is out of range.
    pub(crate) fn check_data(&self) -> Result<(), TwinError> {
        self.find_fault().map_err(|what| TwinError::Data { what })
    }

    /// The same, as the text of what is wrong; it names the array as the file does.
    pub(crate) fn find_fault(&self) -> Checked {
        self.check_lengths()?;
        check_names("outputs", self.outputs.iter().map(|output| &*output.name))?;
        check_names("chambers", self.chambers.iter().map(|chamber| &*chamber.name))?;
        check_names("regions", self.regions.iter().map(|region| &*region.name))?;
        check_provenance(&self.provenance)?;
        check_positive("size", &[self.size])?;
        check_mass(&self.mass, self.coordinates())?;
        self.regions
            .iter()
            .enumerate()
            .try_for_each(|(i, properties)| check_region(&format!("region{i}"), properties))?;
        for (i, chamber) in self.chambers.iter().enumerate() {
            check_positive(&format!("chamber{i}.at_rest"), &[chamber.at_rest])?;
            let [low, high] = chamber.range;
            if low > high {
                return Err(format!("`chamber{i}.range` goes from {low} to {high} Pa, and must not fall"));
            }
        }
        self.sections.iter().try_for_each(|section| not_negative("sections.by", &section.by))
    }

    /// Every array has the numbers of its shape, and they are finite.
    fn check_lengths(&self) -> Checked {
        let counts = Counts::of_data(self);
        let r = counts.coordinates;
        if r == 0 {
            return Err("`mass` is empty".to_owned());
        }
        // length: one list has an entry for each array of the other
        for (array, values) in counts.arrays().iter().zip(array_numbers(self)) {
            let (name, required) = (&array.name, array.shape.iter().product::<usize>());
            if values.len() != required {
                return Err(format!("`{name}` has {} numbers, not {required}", values.len()));
            }
            if let Some(value) = values.iter().find(|value| !value.is_finite()) {
                return Err(format!("`{name}` holds {value}, and must be finite"));
            }
        }
        let slopes = self.sections.iter().map(|section| ("sections.slope", section.slope.len(), 2 * r));
        let values = self.sections.iter().map(|section| ("sections.value", section.value.len(), 2 * r));
        let outputs = self.outputs.iter().map(|output| ("outputs", output.row.len(), r));
        match slopes.chain(values).chain(outputs).find(|(_, length, required)| length != required) {
            Some((name, length, required)) => Err(format!("`{name}` has a row of {length} numbers, not {required}")),
            None => Ok(()),
        }
    }
}

/// Names are given by themselves to a program that looks for one, and separated by commas in the file.
fn check_names<'a>(kind: &str, names: impl Iterator<Item = &'a str>) -> Checked {
    let mut known_names = BTreeSet::new();
    for name in names {
        if name.is_empty() || name.contains(|c: char| c == ',' || c.is_control()) {
            return Err(format!("`{kind}` has the name {name:?}, and names have letters and no comma"));
        }
        if !known_names.insert(name) {
            return Err(format!("`{kind}` has the name {name:?} twice"));
        }
    }
    Ok(())
}

/// Keys and values are separated by `=` and `;` in the file.
fn check_provenance(provenance: &[(String, String)]) -> Checked {
    let is_separator = |c: char| c == ';' || c.is_control();
    match provenance
        .iter()
        .find(|(key, value)| key.contains('=') || [key, value].iter().any(|x| x.contains(is_separator)))
    {
        Some((key, value)) => Err(format!("`provenance` has {key:?} = {value:?}, and neither may hold a separator")),
        None => Ok(()),
    }
}

/// Symmetric, and positive definite: the kinetic energy of every motion is positive. Shown by Cholesky's factor.
fn check_mass(mass: &[f64], r: usize) -> Checked {
    let mut factor = mass.to_vec();
    for i in 0..r {
        for j in 0..i {
            // Relative to the diagonal: an entry that is zero by symmetry holds rounding alone, of which any is large
            // beside the entry itself.
            let (entry, mirror_entry, scale) =
                (mass[i * r + j], mass[j * r + i], (mass[i * r + i] * mass[j * r + j]).abs().sqrt());
            if (entry - mirror_entry).abs() > ASYMMETRY * scale {
                return Err(format!(
                    "`mass` is not symmetric: {entry} in row {i}, column {j}, and {mirror_entry} across"
                ));
            }
            let products: f64 = (0..j).map(|k| factor[i * r + k] * factor[j * r + k]).sum();
            factor[i * r + j] = (entry - products) / factor[j * r + j];
        }
        let pivot = mass[i * r + i] - (0..i).map(|k| factor[i * r + k].powi(2)).sum::<f64>();
        if pivot.is_nan() || pivot <= 0.0 {
            return Err(format!("`mass` is not positive definite: the pivot of row {i} is {pivot}"));
        }
        factor[i * r + i] = pivot.sqrt();
    }
    Ok(())
}

fn check_region(name: &str, region: &Region) -> Checked {
    check_positive(&format!("{name}.moduli"), &[region.mu])?;
    // The bulk modulus and not λ: a solid is stable with a negative λ as long as this is positive.
    let bulk = region.lambda + region.mu * 2.0 / 3.0;
    if bulk.is_nan() || bulk <= 0.0 {
        return Err(format!("`{name}.moduli` give a bulk modulus of {bulk}, and must give one above 0"));
    }
    let part = |k: usize| region.branches.iter().map(|branch| branch[k]).collect::<Vec<f64>>();
    not_negative(&format!("{name}.branches"), &part(0))?;
    check_positive(&format!("{name}.branches"), &part(1))?;
    check_positive(&format!("{name}.weights"), &region.weights)
}

fn check_positive(name: &str, values: &[f64]) -> Checked {
    match values.iter().find(|value| !(**value > 0.0 && value.is_finite())) {
        Some(value) => Err(format!("`{name}` has {value} where a number above 0 must stand")),
        None => Ok(()),
    }
}

fn not_negative(name: &str, values: &[f64]) -> Checked {
    match values.iter().find(|value| !(**value >= 0.0 && value.is_finite())) {
        Some(value) => Err(format!("`{name}` has {value} where no negative number may stand")),
        None => Ok(()),
    }
}
