//! The layout of a reduced tail's file: name, shape, unit and meaning of each array, from the counts that its metadata state.

use crate::data::{Chamber, Region, Section, TwinData};

/// How many things a tail has. A file states them, so that what was cut off is missed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Counts {
    pub coordinates: usize,
    /// Cubature points of each region.
    pub points: Vec<usize>,
    /// Branches of each region.
    pub branches: Vec<usize>,
    pub chambers: usize,
    pub sections: usize,
    pub outputs: usize,
}

/// One array.
pub(crate) struct Array {
    pub name: String,
    pub shape: Vec<usize>,
    pub unit: &'static str,
    pub meaning: &'static str,
}

/// Keys of the counts, in order.
const KEYS: [&str; 6] = ["coordinates", "points", "branches", "chambers", "sections", "outputs"];

impl Counts {
    pub(crate) fn of_data(data: &TwinData) -> Self {
        Self {
            coordinates: data.coordinates(),
            points: data.regions.iter().map(|region| region.weights.len()).collect(),
            branches: data.regions.iter().map(|region| region.branches.len()).collect(),
            chambers: data.chambers.len(),
            sections: data.sections.len(),
            outputs: data.outputs.len(),
        }
    }

    /// As the metadata have them: `coordinates=2;points=5,3;branches=2,0;chambers=1;sections=1;outputs=2`.
    pub fn as_text(&self) -> String {
        let list = |counts: &[usize]| counts.iter().map(usize::to_string).collect::<Vec<_>>().join(",");
        let [single, chambers, sections, outputs] =
            [self.coordinates, self.chambers, self.sections, self.outputs].map(|count| count.to_string());
        let values = [single, list(&self.points), list(&self.branches), chambers, sections, outputs];
        KEYS.iter().zip(values).map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(";")
    }

    /// The inverse of [`Counts::as_text`]; none where the text is another.
    pub fn parse(text: &str) -> Option<Self> {
        let fields: Vec<(&str, &str)> = text.split(';').map(|field| field.split_once('=')).collect::<Option<_>>()?;
        if fields.iter().map(|(key, _)| *key).ne(KEYS) {
            return None;
        }
        let list = |field: usize| match fields[field].1 {
            "" => Some(Vec::new()),
            counts => counts.split(',').map(|count| count.parse().ok()).collect::<Option<Vec<usize>>>(),
        };
        let count = |field: usize| fields[field].1.parse().ok();
        let (points, branches) = (list(1)?, list(2)?);
        let counts = Self {
            coordinates: count(0)?,
            chambers: count(3)?,
            sections: count(4)?,
            outputs: count(5)?,
            points,
            branches,
        };
        (counts.points.len() == counts.branches.len()).then_some(counts)
    }

    /// Whether a file of so many bytes and arrays can hold them.
    // Asked before memory is taken for them, and before their products are formed.
    pub(crate) fn fit_into(&self, bytes: usize, arrays: usize) -> bool {
        let each = [self.coordinates, self.sections, self.outputs];
        let mut counts = each.iter().chain(&self.points).chain(&self.branches);
        counts.all(|count| *count <= bytes / size_of::<f64>()) && self.chambers.max(self.points.len()) <= arrays
    }

    /// Every array, in the order of [`array_numbers`].
    pub fn arrays(&self) -> Vec<Array> {
        let (r, n) = (self.coordinates, self.sections);
        let mut arrays = vec![
            array("mass", &[r, r], "kg m²", "mass matrix of the coordinates q"),
            array("size", &[1], "1", "largest |q| that the tail was reduced from"),
        ];
        arrays.extend((0..self.points.len()).flat_map(|i| region_arrays(i, [self.points[i], self.branches[i], r])));
        arrays.extend((0..self.chambers).flat_map(|i| chamber_arrays(i, r)));
        arrays.extend([
            array("sections.slope", &[n, 2, r], "1", "slope of the centre line by q, along x and y"),
            array("sections.value", &[n, 2, r], "m", "displacement of the section by q, along x and y"),
            array("sections.by", &[n, 4], "kg, kg/m, kg, kg/m", "added mass, drag, shed mass, leaving mass"),
            array("outputs", &[self.outputs, r], "m", "displacement of each output by q"),
            array("outputs.at_rest", &[self.outputs], "m", "coordinate of each output's point at rest"),
        ]);
        arrays
    }
}

fn array(name: &str, shape: &[usize], unit: &'static str, meaning: &'static str) -> Array {
    Array { name: name.to_owned(), shape: shape.to_vec(), unit, meaning }
}

/// Of a region's points and branches, with r coordinates.
fn region_arrays(number: usize, [points, branches, r]: [usize; 3]) -> [Array; 4] {
    let name = |part: &str| format!("region{number}.{part}");
    [
        array(&name("moduli"), &[4], "Pa", "mu after all relaxation, lambda, C20, C30"),
        array(&name("branches"), &[branches, 2], "1, s", "strength over mu, and time, of each branch"),
        array(&name("weights"), &[points], "m³", "weight of each cubature point"),
        array(&name("gradients"), &[points, r, 9], "1", "dF/dq at each point, columns of F in turn"),
    ]
}

fn chamber_arrays(number: usize, r: usize) -> [Array; 5] {
    let (pairs, name) = (r * (r + 1) / 2, |part: &str| format!("chamber{number}.{part}"));
    [
        array(&name("range"), &[2], "Pa", "lowest and highest pressure that it was reduced under"),
        array(&name("at_rest"), &[1], "m³", "volume at rest"),
        array(&name("linear"), &[r], "m³", "first derivative by q at rest"),
        array(&name("quadratic"), &[r, r], "m³", "second derivative"),
        array(&name("cubic"), &[pairs, r], "m³", "third derivative by q_i, q_j (i <= j) and q"),
    ]
}

/// The numbers of every array, in the order of [`Counts::arrays`].
pub(crate) fn array_numbers(data: &TwinData) -> Vec<Vec<f64>> {
    let mut numbers = vec![data.mass.clone(), vec![data.size]];
    for Region { mu, lambda, stiffening: [c20, c30], branches, weights, gradients, .. } in &data.regions {
        let flat = branches.iter().flatten().copied().collect();
        numbers.extend([vec![*mu, *lambda, *c20, *c30], flat, weights.clone(), gradients.clone()]);
    }
    for Chamber { range, at_rest, linear, quadratic, cubic, .. } in &data.chambers {
        numbers.extend([range.to_vec(), vec![*at_rest], linear.clone(), quadratic.clone(), cubic.clone()]);
    }
    let join = |part: fn(&Section) -> &[f64]| data.sections.iter().flat_map(part).copied().collect::<Vec<f64>>();
    numbers.extend([join(|s| &s.slope), join(|s| &s.value), join(|s| &s.by)]);
    numbers.push(data.outputs.iter().flat_map(|output| &output.row).copied().collect());
    numbers.push(data.outputs.iter().map(|output| output.at_rest).collect());
    numbers
}
