//! Reduced: the hyper-reduced model of a specimen.

use fem::ReducedModelData;
use serde::{Deserialize, Serialize};
use si::Pascal;

use super::inconsistent_file;
use crate::subject::Specimen;
use workflow::columns::Columns;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// Data of a reduced model, and the highest pressure of its snapshots.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduced {
    /// Modes and cubature points on the specimen's mesh.
    pub data: ReducedModelData,
    /// The highest pressure among the snapshots, Pa.
    pub highest: Pascal,
    /// The pressure from which walls of the reduced model pass through each other, Pa; none where they do not.
    pub contact: Option<Pascal>,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    coordinates: usize,
    regions: usize,
    size: f64,
    highest_pa: Pascal,
    contact_pa: Option<Pascal>,
}

impl Reduced {
    fn point_count(&self) -> usize {
        self.data.points.iter().map(Vec::len).sum()
    }
}

impl Record for Reduced {
    type Of = Specimen;
    const STAGE: &'static str = "reduce";

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let ReducedModelData { modes, points, size } = &self.data;
        let scalars = Scalars {
            coordinates: modes.len(),
            regions: points.len(),
            size: *size,
            highest_pa: self.highest,
            contact_pa: self.contact,
        };
        let numbered = modes.iter().enumerate();
        let modes = numbered.fold(Columns::default(), |c, (i, mode)| c.numbers(&format!("q{i}_m"), mode.clone()));
        let with_region =
            |(region, points): (usize, &Vec<(u32, f64)>)| points.iter().map(|p| (region, *p)).collect::<Vec<_>>();
        let rows: Vec<(usize, (u32, f64))> = points.iter().enumerate().flat_map(with_region).collect();
        let points = Columns::default()
            .counts("region", rows.iter().map(|(region, _)| *region as u32).collect())
            .counts("point", rows.iter().map(|(_, (point, _))| *point).collect())
            .numbers("weight_m3", rows.iter().map(|(_, (_, weight))| *weight).collect());
        RecordFiles::default()
            .table("modes.parquet", &modes)?
            .table("points.parquet", &points)?
            .scalars("reduced.json", &scalars)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let scalars: Scalars = files.read_scalars("reduced.json")?;
        let modes = files.read_table("modes.parquet")?;
        if scalars.regions > usize::from(u16::MAX) || modes.f64(&format!("q{}_m", scalars.coordinates)).is_ok() {
            return Err(inconsistent_file(
                "reduced.json",
                "it states fewer coordinates than modes, or more regions than there can be",
            ));
        }
        let modes = (0..scalars.coordinates).map(|i| modes.f64(&format!("q{i}_m"))).collect::<Result<_, _>>();
        let modes = modes.map_err(|e| inconsistent_file("modes.parquet", e.to_string()))?;
        let table = files.read_table("points.parquet")?;
        let (numbers, weights) = (table.u32("point")?, table.f64("weight_m3")?);
        // length: columns of one table are equally long
        let mut points = vec![Vec::new(); scalars.regions];
        for (region, point) in table.u32("region")?.into_iter().zip(numbers.into_iter().zip(weights)) {
            points.get_mut(region as usize).ok_or_else(|| invalid_region(region, scalars.regions))?.push(point);
        }
        let data = ReducedModelData { modes, points, size: scalars.size };
        if let Some(cause) = data.fault() {
            return Err(inconsistent_file("modes.parquet or points.parquet", cause));
        }
        Ok(Self { data, highest: scalars.highest_pa, contact: scalars.contact_pa })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |quantity: &str| format!("reduce.{subject}.{quantity}");
        vec![
            Metric::new(id("coordinates"), self.data.modes.len() as f64, ""),
            Metric::new(id("points"), self.point_count() as f64, ""),
        ]
    }

    fn summary(&self) -> String {
        let (coordinates, points) = (self.data.modes.len(), self.point_count());
        let highest = self.highest / si::MILLIBAR;
        let contact = self.contact.map(|p| format!(", walls touch from {:.0} mbar on", p / si::MILLIBAR));
        format!("{coordinates} coordinates, {points} points, up to {highest:.0} mbar{}", contact.unwrap_or_default())
    }
}

fn invalid_region(region: u32, regions: usize) -> RecordError {
    inconsistent_file("points.parquet", format!("a point of region {region}, of {regions}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reduced_model_survives_its_record() {
        let points = vec![vec![(3, 1e-9), (7, 2e-9)], Vec::new(), vec![(9, 5e-10)]];
        let data = ReducedModelData { modes: vec![vec![0.1, -0.2, 0.3], vec![0.0, 1e-9, 7.0]], points, size: 2.5 };
        for contact in [None, Some(1.5e4)] {
            let reduced = Reduced { data: data.clone(), highest: 2e4, contact };
            assert_eq!(Reduced::from_files(&reduced.to_files().unwrap()).unwrap(), reduced);
        }
    }

    #[test]
    fn a_reduced_model_with_a_number_or_a_count_that_cannot_be_is_refused_with_the_file() {
        let points = vec![vec![(3, 1e-9), (7, 2e-9)]];
        let data = ReducedModelData { modes: vec![vec![0.1, -0.2, 0.3], vec![0.0, 1e-9, 7.0]], points, size: 2.5 };
        let reduced = Reduced { data, highest: 2e4, contact: None };
        let refused = |damage: &dyn Fn(&mut Reduced), words: &str| {
            let mut damaged = reduced.clone();
            damage(&mut damaged);
            let error = Reduced::from_files(&damaged.to_files().unwrap()).unwrap_err().to_string();
            assert!(error.contains("points.parquet") && error.contains(words), "{error}");
        };
        refused(&|r| r.data.modes[1][2] = f64::NAN, "mode 1");
        refused(&|r| r.data.modes.iter_mut().for_each(|mode| mode.truncate(2)), "3 numbers per node");
        refused(&|r| r.data.points[0][1].1 = -1e-9, "weight of a point");
        refused(&|r| r.data.size = 0.0, "must be above 0");
        let text = String::from_utf8(reduced.to_files().unwrap().bytes("reduced.json").unwrap().to_vec()).unwrap();
        for (original, replacement) in
            [("\"coordinates\": 2", "\"coordinates\": 1"), ("\"regions\": 1", "\"regions\": 18446744073709551615")]
        {
            let damaged =
                reduced.to_files().unwrap().file("reduced.json", text.replace(original, replacement).into_bytes());
            assert!(Reduced::from_files(&damaged).unwrap_err().to_string().contains("reduced.json"), "{replacement}");
        }
    }
}
