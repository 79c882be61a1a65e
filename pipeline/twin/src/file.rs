//! A reduced tail as a file of safetensors, and a page of text that describes its arrays.
//!
//! All arrays are of 64-bit floating-point numbers, in SI units and rows first.

use std::collections::HashMap;
use std::path::Path;

use safetensors::{Dtype, SafeTensors, tensor::TensorView};

use crate::data::{Chamber, Region, Section, TwinData};
use crate::error::TwinError;

/// Key of the outputs' names, separated by commas, among the file's metadata.
const OUTPUTS: &str = "outputs";

/// One array.
struct Array {
    name: String,
    shape: Vec<usize>,
    unit: &'static str,
    meaning: &'static str,
    values: Vec<f64>,
}

/// Writes a tail's arrays.
///
/// # Errors
/// [`TwinError::File`] when the file cannot be written.
pub fn write(path: &Path, data: &TwinData) -> Result<(), TwinError> {
    let bytes = bytes(data).map_err(|e| refused(path, e))?;
    std::fs::write(path, bytes).map_err(|e| refused(path, e))
}

/// Reads a tail's arrays.
///
/// # Errors
/// [`TwinError::File`] when the file cannot be read, lacks an array, or holds others than doubles.
pub fn read(path: &Path) -> Result<TwinData, TwinError> {
    let bytes = std::fs::read(path).map_err(|e| refused(path, e))?;
    data(&bytes).map_err(|what| refused(path, what))
}

fn refused(path: &Path, what: impl std::fmt::Display) -> TwinError {
    TwinError::File { file: path.display().to_string(), what: what.to_string() }
}

/// The file's content.
///
/// # Errors
/// Never for arrays that belong together.
pub fn bytes(data: &TwinData) -> Result<Vec<u8>, safetensors::SafeTensorError> {
    let arrays = arrays(data);
    let raw: Vec<Vec<u8>> =
        arrays.iter().map(|array| array.values.iter().flat_map(|value| value.to_le_bytes()).collect()).collect();
    let views = arrays
        .iter()
        .zip(&raw)
        .map(|(array, bytes)| Ok((array.name.clone(), TensorView::new(Dtype::F64, array.shape.clone(), bytes)?)));
    let views = views.collect::<Result<Vec<_>, safetensors::SafeTensorError>>()?;
    let names: Vec<&str> = data.outputs.iter().map(|(name, _)| &**name).collect();
    safetensors::serialize(views, Some(HashMap::from([(OUTPUTS.to_owned(), names.join(","))])))
}

/// The tail in a file's content.
fn data(bytes: &[u8]) -> Result<TwinData, String> {
    let file = SafeTensors::deserialize(bytes).map_err(|e| e.to_string())?;
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|e| e.to_string())?;
    let values = |name: &str| values(&file, name);
    let names = metadata.metadata().as_ref().and_then(|m| m.get(OUTPUTS)).ok_or("it names no outputs")?;
    let mass = values("mass")?;
    let r = mass.len().isqrt().max(1);
    let regions = (0..).take_while(|i| file.tensor(&format!("region{i}.moduli")).is_ok());
    let chambers = (0..).take_while(|i| file.tensor(&format!("chamber{i}.at_rest")).is_ok());
    let rows = values("outputs")?;
    let [slope, value, by] = ["slope", "value", "by"].map(|part| values(&format!("sections.{part}")));
    let sections =
        slope?.chunks_exact(2 * r).zip(value?.chunks_exact(2 * r)).zip(by?.chunks_exact(4)).map(section).collect();
    Ok(TwinData {
        size: first(&values("size")?)?,
        regions: regions.map(|i| region(&|part| values(&format!("region{i}.{part}")))).collect::<Result<_, _>>()?,
        chambers: chambers.map(|i| chamber(&|part| values(&format!("chamber{i}.{part}")))).collect::<Result<_, _>>()?,
        sections,
        outputs: names.split(',').map(str::to_owned).zip(rows.chunks_exact(r).map(<[f64]>::to_vec)).collect(),
        mass,
    })
}

/// Reads one array by its name.
type Reader<'a> = dyn Fn(&str) -> Result<Vec<f64>, String> + 'a;

fn values(file: &SafeTensors, name: &str) -> Result<Vec<f64>, String> {
    let tensor = file.tensor(name).map_err(|_| format!("it has no array `{name}`"))?;
    if tensor.dtype() != Dtype::F64 {
        return Err(format!("`{name}` holds {:?}, not F64", tensor.dtype()));
    }
    let number = |bytes: &[u8]| f64::from_le_bytes(std::array::from_fn(|i| bytes[i]));
    Ok(tensor.data().chunks_exact(8).map(number).collect())
}

fn first(values: &[f64]) -> Result<f64, String> {
    values.first().copied().ok_or_else(|| "an array of one number is empty".to_owned())
}

fn region(read: &Reader) -> Result<Region, String> {
    let moduli = read("moduli")?;
    let [mu, lambda, c20, c30] = <[f64; 4]>::try_from(moduli).map_err(|_| "moduli are four numbers".to_owned())?;
    let branches = read("branches")?.chunks_exact(2).map(|branch| [branch[0], branch[1]]).collect();
    Ok(Region {
        mu,
        lambda,
        stiffening: [c20, c30],
        branches,
        weights: read("weights")?,
        gradients: read("gradients")?,
    })
}

fn chamber(read: &Reader) -> Result<Chamber, String> {
    let [linear, quadratic, cubic] = ["linear", "quadratic", "cubic"].map(read);
    Ok(Chamber { at_rest: first(&read("at_rest")?)?, linear: linear?, quadratic: quadratic?, cubic: cubic? })
}

fn section(((slope, value), by): ((&[f64], &[f64]), &[f64])) -> Section {
    Section { slope: slope.to_vec(), value: value.to_vec(), by: std::array::from_fn(|k| by[k]) }
}

/// Every array of a tail.
fn arrays(data: &TwinData) -> Vec<Array> {
    let r = data.coordinates();
    let array = |name: &str, shape: &[usize], unit, meaning, values: Vec<f64>| Array {
        name: name.to_owned(),
        shape: shape.to_vec(),
        unit,
        meaning,
        values,
    };
    let mut all = vec![
        array("mass", &[r, r], "kg m²", "mass matrix of the coordinates q", data.mass.clone()),
        array("size", &[1], "1", "largest |q| that the tail was reduced from", vec![data.size]),
    ];
    for (i, region) in data.regions.iter().enumerate() {
        let Region { mu, lambda, stiffening: [c20, c30], branches, weights, gradients } = region;
        let (n, name) = (weights.len(), |part: &str| format!("region{i}.{part}"));
        let flat = branches.iter().flatten().copied().collect();
        all.extend([
            array(
                &name("moduli"),
                &[4],
                "Pa",
                "mu after all relaxation, lambda, C20, C30",
                vec![*mu, *lambda, *c20, *c30],
            ),
            array(&name("branches"), &[branches.len(), 2], "1, s", "strength over mu, and time, of each branch", flat),
            array(&name("weights"), &[n], "m³", "weight of each cubature point", weights.clone()),
            array(&name("gradients"), &[n, r, 9], "1", "dF/dq at each point, columns of F in turn", gradients.clone()),
        ]);
    }
    for (i, chamber) in data.chambers.iter().enumerate() {
        let (pairs, name) = (r * (r + 1) / 2, |part: &str| format!("chamber{i}.{part}"));
        all.extend([
            array(&name("at_rest"), &[1], "m³", "volume at rest", vec![chamber.at_rest]),
            array(&name("linear"), &[r], "m³", "first derivative by q at rest", chamber.linear.clone()),
            array(&name("quadratic"), &[r, r], "m³", "second derivative", chamber.quadratic.clone()),
            array(
                &name("cubic"),
                &[pairs, r],
                "m³",
                "third derivative by q_i, q_j (i <= j) and q",
                chamber.cubic.clone(),
            ),
        ]);
    }
    let n = data.sections.len();
    let join = |of: fn(&Section) -> &[f64]| data.sections.iter().flat_map(of).copied().collect::<Vec<f64>>();
    all.extend([
        array("sections.slope", &[n, 2, r], "1", "slope of the centre line by q, along x and y", join(|s| &s.slope)),
        array("sections.value", &[n, 2, r], "m", "displacement of the section by q, along x and y", join(|s| &s.value)),
        array(
            "sections.by",
            &[n, 4],
            "kg, kg/m, kg, kg/m",
            "added mass, drag, shed mass, leaving mass",
            join(|s| &s.by),
        ),
    ]);
    let rows = data.outputs.iter().flat_map(|(_, row)| row).copied().collect();
    all.push(array("outputs", &[data.outputs.len(), r], "m", "displacement of each named output by q", rows));
    all
}

/// A page that describes every array of the file with its shape and unit, and the equations.
pub fn page(data: &TwinData) -> String {
    let line = |array: &Array| {
        format!("{:20} {:14} {:20} {}\n", array.name, format!("{:?}", array.shape), array.unit, array.meaning)
    };
    let names: Vec<&str> = data.outputs.iter().map(|(name, _)| &**name).collect();
    let arrays: String = arrays(data).iter().map(line).collect();
    format!(
        "{EQUATIONS}\n{:20} {:14} {:20} meaning\n{arrays}\noutputs: {}\n",
        "array",
        "shape",
        "unit",
        names.join(", ")
    )
}

/// The equations that the arrays belong to.
const EQUATIONS: &str = "\
A reduced tail: arrays of 64-bit floating-point numbers in SI units, rows first.

  M q'' + sum_points w G^T P(F) = sum_chambers p dV/dq + Q          F = I + G q

  P   stress of the energy mu/2 x + C20 x^2 + C30 x^3 + lambda/2 (ln J)^2 with x = tr(F^T F) - 3 - 2 ln J, and of Maxwell
      branches: S = I - C^-1 drives each, Q' + Q/time = strength dS/dt, and F times mu times their sum is added to P
  V   volume of a chamber: at_rest + linear q + quadratic q q / 2 + cubic q q q / 6; of a half model, of the half
  Q   of still water: with tangent t = (1, 0) + slope q, normal n = (-t_y, t_x), velocity v = value q', w = v.n, u = v.t, sum over sections of
      value^T (-d/dt(by_0 w n) - by_1 |w| w n + by_3 (u w n - w^2 t / 2)) - slope^T by_2 (u w n - w^2 t / 2)

The tail starts from rest, q = 0. Pressures are in Pa, one per chamber; displacements are outputs times q, in m.
";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Twin;

    fn tail() -> TwinData {
        let wave = |count: usize, by: f64| (0..count).map(|k| (by + 1.7 * k as f64).sin()).collect::<Vec<f64>>();
        let region = |branches: Vec<[f64; 2]>| Region {
            mu: 1e5,
            lambda: 1e6,
            stiffening: [1e3, -2e2],
            branches,
            weights: vec![1e-6; 5],
            gradients: wave(5 * 2 * 9, 0.3),
        };
        let chamber = Chamber { at_rest: 1e-5, linear: wave(2, 0.1), quadratic: wave(4, 0.2), cubic: wave(6, 0.5) };
        let section = Section { slope: wave(4, 0.4), value: wave(4, 0.9), by: [0.1, 0.2, 0.3, 0.4] };
        TwinData {
            mass: vec![1.0, 0.2, 0.2, 3.0],
            size: 2.0,
            regions: vec![region(vec![[0.1, 0.02], [0.2, 3.0]]), region(vec![])],
            chambers: vec![chamber],
            sections: vec![section],
            outputs: vec![("tip_x".into(), wave(2, 0.7)), ("tip_y".into(), wave(2, 0.8))],
        }
    }

    #[test]
    fn a_tail_survives_its_file() {
        let data = tail();
        assert_eq!(super::data(&bytes(&data).unwrap()).unwrap(), data);
        Twin::new(data).unwrap();
    }

    #[test]
    fn a_damaged_file_is_refused_with_what_is_wrong() {
        let whole = bytes(&tail()).unwrap();
        assert!(super::data(&whole[..whole.len() / 2]).is_err());
        let other = String::from_utf8_lossy(&whole).replace("\"mass\"", "\"mess\"");
        assert!(super::data(other.as_bytes()).is_err());
        let short = TwinData { mass: vec![1.0; 9], ..tail() };
        let error = Twin::new(short).unwrap_err().to_string();
        assert!(error.contains("the gradients of region 0 has 90 numbers, not 135"), "{error}");
        assert!(Twin::new(TwinData { size: 0.0, ..tail() }).unwrap_err().to_string().contains("size"));
    }

    #[test]
    fn the_page_names_every_array_with_its_shape() {
        let page = page(&tail());
        for line in ["region0.gradients    [5, 2, 9]", "sections.by          [1, 4]", "outputs: tip_x, tip_y"] {
            assert!(page.contains(line), "{page}");
        }
    }
}
