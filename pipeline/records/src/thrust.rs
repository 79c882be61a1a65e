//! Thrust: scores of each thrust model, traces for the figure, and the training network.

use serde::{Deserialize, Serialize};
use si::{KilogramPerCubicMetre, Newton, Pascal, Second};

use super::runs::{self, Head};
use crate::subject::Specimen;
use ::thrust::Run;
use ::thrust::score::Score;
use workflow::columns::Columns;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// The training thrust models of a specimen.
#[derive(Debug, Clone, PartialEq)]
pub struct Thrust {
    /// Scores by split rule and model.
    pub scores: Vec<Scored>,
    /// Mean forces of the runs held out by the card.
    pub means: Vec<Means>,
    /// Traces of one training run and one held-out run.
    pub traces: Vec<Trace>,
    /// The static cross-talk that was subtracted.
    pub crosstalk: Crosstalk,
    /// The coefficients of fitted theory: edge flux, momentum rate, drag, inertia, constant.
    pub coefficients: Vec<f64>,
    /// The network as safetensors.
    pub network: Vec<u8>,
    /// Every flapping trial, as used for training or evaluation.
    pub runs: Vec<Run>,
    /// Density of the water in theory, kg/m³.
    pub density: KilogramPerCubicMetre,
    /// Sections of the tail in theory.
    pub sections: usize,
}

/// One model on one split of the runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scored {
    /// `card`, `frequency`, `pressure` or `tail`.
    pub split_rule: String,
    /// The model's name.
    pub model: String,
    /// Index of the seed; 0 for models without one.
    pub seed: u64,
    /// Its errors on the held-out runs.
    pub score: Score,
    /// Numbers of training and of held-out runs.
    pub runs: [usize; 2],
}

/// The mean force of one run, measured and predicted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Means {
    /// The run's id.
    pub run: String,
    /// Pa.
    pub amplitude_pa: Pascal,
    /// Hz.
    pub frequency_hz: f64,
    /// N.
    pub measured_n: Newton,
    /// By the paper's theory, N.
    pub theory_n: Newton,
    /// By the network, N.
    pub network_n: Newton,
    /// Mean of the subtracted cross-talk, N.
    pub crosstalk_n: Newton,
}

/// One run as the figure shows it: samples each.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// The run's id.
    pub run: String,
    /// Whether it is a training run.
    pub training: bool,
    /// s.
    pub time: Vec<Second>,
    /// Lateral displacement of the last marker, m.
    pub moved: Vec<f64>,
    /// N.
    pub measured: Vec<Newton>,
    /// The paper's theory, N.
    pub theory: Vec<Newton>,
    /// N.
    pub network: Vec<Newton>,
}

/// The curve of the cross-talk.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Crosstalk {
    /// Pa.
    pub pressures_pa: Vec<Pascal>,
    /// N.
    pub forces_n: Vec<Newton>,
    /// s.
    pub lag_s: Second,
    /// Its 95 % interval, s.
    pub lag_interval_s: [Second; 2],
    /// Residual of curve and drift, N.
    pub left_n: Newton,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    scores: Vec<Scored>,
    means: Vec<Means>,
    traces: Vec<(String, bool)>,
    crosstalk: Crosstalk,
    coefficients: Vec<f64>,
    runs: Vec<Head>,
    density_kg_m3: f64,
    sections: usize,
}

impl Thrust {
    /// The score of a model on the card's own split, first seed.
    pub fn of(&self, model: &str) -> Option<&Scored> {
        self.scores.iter().find(|s| s.split_rule == "card" && s.model == model)
    }
}

impl Record for Thrust {
    type Of = Specimen;
    const STAGE: &'static str = "thrust";

    fn is_made_for(specimen: &Specimen) -> bool {
        let has = |split| specimen.trials().iter().any(|t| t.has_force_in_water() && t.trial.split == Some(split));
        has(lab::card::Split::Train) && has(lab::card::Split::Test)
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let scalars = Scalars {
            scores: self.scores.clone(),
            means: self.means.clone(),
            traces: self.traces.iter().map(|t| (t.run.clone(), t.training)).collect(),
            crosstalk: self.crosstalk.clone(),
            coefficients: self.coefficients.clone(),
            runs: self.runs.iter().map(Head::of_run).collect(),
            density_kg_m3: self.density,
            sections: self.sections,
        };
        let files =
            RecordFiles::default().scalars("thrust.json", &scalars)?.file("network.safetensors", self.network.clone());
        let files = files.table("runs.parquet", &runs::runs_table(&self.runs))?;
        self.traces.iter().enumerate().try_fold(files, |files, (i, trace)| {
            let columns = Columns::default()
                .numbers("time_s", trace.time.clone())
                .numbers("moved_m", trace.moved.clone())
                .numbers("measured_n", trace.measured.clone())
                .numbers("theory_n", trace.theory.clone())
                .numbers("network_n", trace.network.clone());
            files.table(&format!("trace{i}.parquet"), &columns)
        })
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let s: Scalars = files.read_scalars("thrust.json")?;
        let trace = |(i, (run, training)): (usize, (String, bool))| -> Result<Trace, RecordError> {
            let columns = files.read_table(&format!("trace{i}.parquet"))?;
            Ok(Trace {
                run,
                training,
                time: columns.f64("time_s")?,
                moved: columns.f64("moved_m")?,
                measured: columns.f64("measured_n")?,
                theory: columns.f64("theory_n")?,
                network: columns.f64("network_n")?,
            })
        };
        Ok(Self {
            scores: s.scores,
            means: s.means,
            traces: s.traces.into_iter().enumerate().map(trace).collect::<Result<_, _>>()?,
            crosstalk: s.crosstalk,
            coefficients: s.coefficients,
            network: files.bytes("network.safetensors")?.to_vec(),
            runs: runs::read_runs(&s.runs, &files.read_table("runs.parquet")?)?,
            density: s.density_kg_m3,
            sections: s.sections,
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let name = subject;
        let mut metrics = vec![Metric::new(format!("thrust.{name}.crosstalk_lag_s"), self.crosstalk.lag_s, "s")];
        for scored in self.scores.iter().filter(|s| s.seed == 0) {
            let id = match scored.split_rule.as_str() {
                "card" => format!("thrust.{name}.{}", scored.model),
                split_rule => format!("thrust.{name}.{}.by_{split_rule}", scored.model),
            };
            let s = &scored.score;
            metrics.push(Metric::new(format!("{id}.nrmse"), s.nrmse, ""));
            metrics.push(Metric::new(format!("{id}.mean_error_percent"), s.mean_error_percent, "%"));
            metrics.push(Metric::new(format!("{id}.phase_deg"), s.phase_deg, "°"));
        }
        metrics
    }

    fn summary(&self) -> String {
        let text = ["mean", "ebt", "theory", "network"].iter().filter_map(|model| self.of(model));
        let text: Vec<String> = text.map(|s| format!("{} {:.2}", s.model, s.score.nrmse)).collect();
        format!("NRMSE {}", text.join(", "))
    }
}
