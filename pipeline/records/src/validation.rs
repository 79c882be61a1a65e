//! Validation: a motion that identification did not use, measured and simulated.

use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Point2, Second};

use crate::Drag;
use crate::subject::{Specimen, Trial};
use workflow::columns::Columns;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// The paper's own model: elastic, without damping and without the force of water, by implicit Euler.
pub const PAPER_MODEL: &str = "paper_model";

/// A prediction of the motion, and its error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScoredModel {
    /// A model: "viscoelastic", "elastic", "implicit_euler" or [`PAPER_MODEL`]; or a baseline: "rest", "quasi_static", "last_cycle".
    pub name: String,
    /// Root of the mean squared distance from the measured mean, m.
    pub rmse: Metre,
}

/// A positive quantity and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// SI.
    pub value: f64,
    /// Standard deviation of its logarithm.
    pub sigma: f64,
}

/// The tip marker over the repeats of one condition: one simulation for all of them; in water with added mass and drag identified from a
/// release, never from a flapping film.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Validation {
    /// Its name.
    pub marker: String,
    /// Time of each frame, s: frames.
    #[serde(skip)]
    pub time: Vec<Second>,
    /// Measured displacement from rest, the mean of the repeats, m: frames × 2.
    #[serde(skip)]
    pub measured: Vec<Point2>,
    /// Standard deviation over the repeats, m: frames × 2.
    #[serde(skip)]
    pub deviation: Vec<Point2>,
    /// Simulated displacement, m: frames × 2; second order, with the identified relaxation.
    #[serde(skip)]
    pub simulated: Vec<Point2>,
    /// The same by [`PAPER_MODEL`], m: frames × 2.
    #[serde(skip)]
    pub by_paper_model: Vec<Point2>,
    /// Measured pressures in the order of the card's chambers, Pa: chambers × frames.
    #[serde(skip)]
    pub pressures: Vec<Vec<Pascal>>,
    /// Their number.
    pub chambers: usize,
    /// Root of the mean squared distance, m.
    #[serde(rename = "rmse_m")]
    pub rmse: Metre,
    /// Predicted root mean square of the lateral displacement, m.
    #[serde(rename = "amplitude_m")]
    pub amplitude: Interval,
    /// The specimen's length, m.
    #[serde(rename = "length_m")]
    pub length: Metre,
    /// Root mean square of the measured displacement, m: the error of predicting no motion.
    #[serde(rename = "zero_motion_rmse_m")]
    pub zero_motion_rmse: Metre,
    /// How many repeats there are.
    pub repeats: usize,
    /// Lag of the simulation at the flapping frequency, s.
    #[serde(rename = "lag_s")]
    pub lag: Option<Second>,
    /// The models.
    pub scored: Vec<ScoredModel>,
    /// The trivial baselines.
    pub baselines: Vec<ScoredModel>,
    /// Root mean square difference of the reduced from the full model over the largest displacement, no unit; in air.
    pub reduction: Option<f64>,
    /// Largest distance of the reduced model as a twin from the full model over the same time, m; in air.
    #[serde(rename = "twin_error_m")]
    pub twin_error: Option<Metre>,
    /// Duration of the motion over the time in which the twin steps through it on one core, no unit.
    #[serde(skip)]
    pub real_time_factor: Option<f64>,
    /// Coordinates of the reduced model.
    pub coordinates: usize,
}

#[derive(Serialize, Deserialize)]
struct Durations {
    real_time_factor: Option<f64>,
}

/// The columns of each path in the record.
const PATHS: [&str; 4] = ["measured", "deviation", "simulated", PAPER_MODEL];

impl Validation {
    fn named_paths(&self) -> [(&'static str, &[Point2]); 4] {
        let [measured, deviation, simulated, by_paper_model] = PATHS;
        [
            (measured, &self.measured),
            (deviation, &self.deviation),
            (simulated, &self.simulated),
            (by_paper_model, &self.by_paper_model),
        ]
    }

    /// The error in per cent of the specimen's length.
    pub fn rmse_percent(&self) -> f64 {
        100.0 * self.rmse / self.length
    }

    /// The largest distance of a frame's simulated displacement from the measured one, in per cent of the specimen's length.
    pub fn max_percent(&self) -> f64 {
        let distance = |(a, b): (&Point2, &Point2)| (a[0] - b[0]).hypot(a[1] - b[1]);
        100.0 * self.simulated.iter().zip(&self.measured).map(distance).fold(0.0, f64::max) / self.length
    }
}

impl Record for Validation {
    type Of = Trial;
    const STAGE: &'static str = "validate";

    fn is_made_for(trial: &Trial) -> bool {
        let wet = || Drag::is_made_for(&Specimen { card: trial.card.clone() });
        trial.is_for_validation() && trial.is_first_repeat() && (!trial.is_in_water() || wet())
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let columns = self.named_paths().iter().fold(
            Columns::default().numbers("time_s", self.time.clone()),
            |c, (who, path)| {
                let axis = |k: usize| path.iter().map(|p| p[k]).collect();
                c.numbers(&format!("{who}_x_m"), axis(0)).numbers(&format!("{who}_y_m"), axis(1))
            },
        );
        let pressures = self.pressures.iter().enumerate();
        let columns = pressures.fold(columns, |c, (i, p)| c.numbers(&format!("chamber{i}_pa"), p.clone()));
        RecordFiles::default()
            .table("validation.parquet", &columns)?
            .scalars("validation.json", self)?
            .durations("durations.json", &Durations { real_time_factor: self.real_time_factor })
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let scalars: Self = files.read_scalars("validation.json")?;
        let columns = files.read_table("validation.parquet")?;
        let path = |who: &str| -> Result<Vec<Point2>, RecordError> {
            let (x, y) = (columns.f64(&format!("{who}_x_m"))?, columns.f64(&format!("{who}_y_m"))?);
            // length: columns of one table are equally long
            Ok(x.into_iter().zip(y).map(|(x, y)| [x, y]).collect())
        };
        let [measured, deviation, simulated, by_paper_model] = PATHS.map(path);
        Ok(Self {
            time: columns.f64("time_s")?,
            measured: measured?,
            deviation: deviation?,
            simulated: simulated?,
            by_paper_model: by_paper_model?,
            pressures: (0..scalars.chambers)
                .map(|i| columns.f64(&format!("chamber{i}_pa")))
                .collect::<Result<_, _>>()?,
            real_time_factor: files.read_scalars::<Durations>("durations.json")?.real_time_factor,
            ..scalars
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |quantity: &str| format!("validate.{}.{quantity}", crate::subject::Condition::of(subject).0);
        let percent = |m: Metre| 100.0 * m / self.length;
        let models = self.scored.iter().chain(&self.baselines);
        let models = models.map(|s| Metric::new(id(&format!("{}.rmse_percent", s.name)), percent(s.rmse), "%"));
        let mut metrics = vec![
            Metric::new(id("rmse_mm"), 1e3 * self.rmse, "mm"),
            Metric::new(id("rmse_percent"), self.rmse_percent(), "%"),
            Metric::new(id("max_percent"), self.max_percent(), "%"),
            Metric::new(id("amplitude_mm"), 1e3 * self.amplitude.value, "mm"),
            Metric::new(id("amplitude_mm.sigma"), 1e3 * self.amplitude.value * self.amplitude.sigma, "mm"),
            Metric::new(id("zero_motion_rmse_percent"), percent(self.zero_motion_rmse), "%"),
            Metric::new(id("repeats"), self.repeats as f64, ""),
            Metric::new(id("reduced_coordinates"), self.coordinates as f64, ""),
        ];
        metrics.extend(self.reduction.map(|error| Metric::new(id("reduction_percent"), 100.0 * error, "%")));
        metrics.extend(self.twin_error.map(|error| Metric::new(id("twin_error_percent"), percent(error), "%")));
        metrics.extend(self.real_time_factor.map(|factor| Metric::new(id("real_time_factor"), factor, "")));
        metrics.extend(self.lag.map(|lag| Metric::new(id("lag_ms"), 1e3 * lag, "ms")));
        metrics.extend(models);
        metrics
    }

    fn summary(&self) -> String {
        let text = |s: &ScoredModel| format!("{} {:.2}", s.name, 1e3 * s.rmse);
        let errors: Vec<String> = self.scored.iter().skip(1).chain(&self.baselines).map(text).collect();
        let (mm, percent) = (1e3 * self.rmse, self.rmse_percent());
        format!(
            "RMSE {mm:.2} mm, {percent:.2} % of the length, {} repeats ({} mm); {} coordinates{}",
            self.repeats,
            errors.join(", "),
            self.coordinates,
            self.reduction.map_or(String::new(), |error| format!(", {:.2} % from the full model", 100.0 * error)),
        )
    }
}
