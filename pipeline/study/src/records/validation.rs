//! Validation: a motion that identification never saw, measured and simulated.

use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Point2, Second};

use crate::columns::Columns;
use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Trial;

/// The marker farthest out, through one trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// Its name.
    pub marker: String,
    /// Time of each frame, s: frames.
    pub time: Vec<Second>,
    /// Measured displacement from rest, m: frames × 2.
    pub measured: Vec<Point2>,
    /// Simulated displacement, m: frames × 2.
    pub simulated: Vec<Point2>,
    /// Measured pressures in the order of the card's chambers, Pa: chambers × frames.
    pub pressures: Vec<Vec<Pascal>>,
    /// Root of the mean squared distance, m.
    pub rmse: Metre,
    /// The specimen's length, m.
    pub length: Metre,
    /// Root of the mean squared measured displacement, m: the error of a model that says nothing moves.
    pub rest_rmse: Metre,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    marker: String,
    rmse_m: f64,
    length_m: f64,
    rest_rmse_m: f64,
    chambers: usize,
}

impl Validation {
    /// The error in per cent of the specimen's length.
    pub fn rmse_percent(&self) -> f64 {
        100.0 * self.rmse / self.length
    }
}

impl Record for Validation {
    type Of = Trial;
    const STAGE: &'static str = "validate";

    fn is_made_for(of: &Trial) -> bool {
        of.is_for_validation()
    }

    fn pack(&self) -> Result<Parcel, RecordError> {
        let part = |path: &[Point2], k: usize| path.iter().map(|p| p[k]).collect();
        let columns = Columns::default()
            .numbers("time_s", self.time.clone())
            .numbers("measured_x_m", part(&self.measured, 0))
            .numbers("measured_y_m", part(&self.measured, 1))
            .numbers("simulated_x_m", part(&self.simulated, 0))
            .numbers("simulated_y_m", part(&self.simulated, 1));
        let pressures = self.pressures.iter().enumerate();
        let columns = pressures.fold(columns, |c, (i, p)| c.numbers(&format!("chamber{i}_pa"), p.clone()));
        let scalars = Scalars {
            marker: self.marker.clone(),
            rmse_m: self.rmse,
            length_m: self.length,
            rest_rmse_m: self.rest_rmse,
            chambers: self.pressures.len(),
        };
        Parcel::default().table("validation.parquet", &columns)?.scalars("validation.json", &scalars)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        let s: Scalars = parcel.read_scalars("validation.json")?;
        let columns = parcel.read_table("validation.parquet")?;
        let path = |who: &str| -> Result<Vec<Point2>, RecordError> {
            let (x, y) = (columns.f64(&format!("{who}_x_m"))?, columns.f64(&format!("{who}_y_m"))?);
            Ok(x.into_iter().zip(y).map(|(x, y)| [x, y]).collect())
        };
        Ok(Self {
            marker: s.marker,
            time: columns.f64("time_s")?,
            measured: path("measured")?,
            simulated: path("simulated")?,
            pressures: (0..s.chambers).map(|i| columns.f64(&format!("chamber{i}_pa"))).collect::<Result<_, _>>()?,
            rmse: s.rmse_m,
            length: s.length_m,
            rest_rmse: s.rest_rmse_m,
        })
    }

    fn metrics(&self, of: &Trial) -> Vec<Metric> {
        let id = |what: &str| format!("validate.{}_{}.{what}", of.card.name, of.trial.id);
        vec![
            Metric::new(id("rmse_mm"), 1e3 * self.rmse, "mm"),
            Metric::new(id("rmse_percent"), self.rmse_percent(), "%"),
            Metric::new(id("rest_rmse_percent"), 100.0 * self.rest_rmse / self.length, "%"),
        ]
    }

    fn telling(&self) -> String {
        format!("RMSE {:.2} mm, {:.2} % of the length", 1e3 * self.rmse, self.rmse_percent())
    }
}
