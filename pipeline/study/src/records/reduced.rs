//! Reduced: a specimen's model in a few dozen coordinates.

use fem::Kept;
use serde::{Deserialize, Serialize};
use si::Pascal;

use crate::columns::Columns;
use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Specimen;

/// What is kept of a reduced model, and how far its shapes reach.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduced {
    /// Modes and points, of the specimen's mesh.
    pub kept: Kept,
    /// The highest pressure among the shapes, Pa.
    pub highest: Pascal,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    coordinates: usize,
    regions: usize,
    size: f64,
    highest_pa: Pascal,
}

impl Reduced {
    fn points(&self) -> usize {
        self.kept.points.iter().map(Vec::len).sum()
    }
}

impl Record for Reduced {
    type Of = Specimen;
    const STAGE: &'static str = "reduce";

    fn pack(&self) -> Result<Parcel, RecordError> {
        let Kept { modes, points, size } = &self.kept;
        let scalars =
            Scalars { coordinates: modes.len(), regions: points.len(), size: *size, highest_pa: self.highest };
        let numbered = modes.iter().enumerate();
        let modes = numbered.fold(Columns::default(), |c, (i, mode)| c.numbers(&format!("q{i}_m"), mode.clone()));
        let of = |(region, of): (usize, &Vec<(u32, f64)>)| of.iter().map(|p| (region, *p)).collect::<Vec<_>>();
        let all: Vec<(usize, (u32, f64))> = points.iter().enumerate().flat_map(of).collect();
        let points = Columns::default()
            .counts("region", all.iter().map(|(region, _)| *region as u32).collect())
            .counts("point", all.iter().map(|(_, (point, _))| *point).collect())
            .numbers("weight_m3", all.iter().map(|(_, (_, weight))| *weight).collect());
        Parcel::default()
            .table("modes.parquet", &modes)?
            .table("points.parquet", &points)?
            .scalars("reduced.json", &scalars)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        let scalars: Scalars = parcel.read_scalars("reduced.json")?;
        let modes = parcel.read_table("modes.parquet")?;
        let modes = (0..scalars.coordinates).map(|i| modes.f64(&format!("q{i}_m"))).collect::<Result<_, _>>()?;
        let table = parcel.read_table("points.parquet")?;
        let (numbers, weights) = (table.u32("point")?, table.f64("weight_m3")?);
        let mut points = vec![Vec::new(); scalars.regions];
        for (region, point) in table.u32("region")?.into_iter().zip(numbers.into_iter().zip(weights)) {
            points.get_mut(region as usize).ok_or_else(|| strange(region, scalars.regions))?.push(point);
        }
        Ok(Self { kept: Kept { modes, points, size: scalars.size }, highest: scalars.highest_pa })
    }

    fn metrics(&self, of: &Specimen) -> Vec<Metric> {
        let id = |what: &str| format!("reduce.{}.{what}", of.card.name);
        vec![
            Metric::new(id("coordinates"), self.kept.modes.len() as f64, ""),
            Metric::new(id("points"), self.points() as f64, ""),
        ]
    }

    fn telling(&self) -> String {
        let (coordinates, points) = (self.kept.modes.len(), self.points());
        format!("{coordinates} coordinates, {points} points, up to {:.0} mbar", self.highest / si::MILLIBAR)
    }
}

fn strange(region: u32, regions: usize) -> RecordError {
    let cause = format!("a point of region {region}, of {regions}");
    RecordError::Scalars { file: "points.parquet".into(), cause }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reduced_model_survives_its_record() {
        let points = vec![vec![(3, 1e-9), (7, 2e-9)], Vec::new(), vec![(9, 5e-10)]];
        let kept = Kept { modes: vec![vec![0.1, -0.2, 0.3], vec![0.0, 1e-9, 7.0]], points, size: 2.5 };
        let whole = Reduced { kept, highest: 2e4 };
        assert_eq!(Reduced::unpack(&whole.pack().unwrap()).unwrap(), whole);
    }
}
