//! Thrust: how well each rung of the ladder tells it, the traces that show it, and the network.

use serde::{Deserialize, Serialize};
use si::{KilogramPerCubicMetre, Newton, Pascal, Second};

use super::runs::{self, Head};
use crate::columns::Columns;
use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Specimen;
use crate::thrust::Run;
use crate::thrust::score::Score;

/// What was learnt of a specimen's thrust.
#[derive(Debug, Clone, PartialEq)]
pub struct Thrust {
    /// Every parting and rung.
    pub scores: Vec<Scored>,
    /// Mean forces of the runs that the card holds out.
    pub means: Vec<Means>,
    /// Traces: one run that was learnt from and one that was not.
    pub traces: Vec<Trace>,
    /// The static cross-talk that was taken out.
    pub crosstalk: Crosstalk,
    /// The coefficients of tuned theory: shed, gained, drag, inertia, constant.
    pub coefficients: Vec<f64>,
    /// The network as safetensors.
    pub network: Vec<u8>,
    /// Every beating trial as it was learnt from or judged by.
    pub runs: Vec<Run>,
    /// Of the water, as theory was told it, kg/m³.
    pub density: KilogramPerCubicMetre,
    /// Sections of the tail in theory.
    pub sections: usize,
}

/// One rung on one parting of the runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scored {
    /// `card`, `frequency`, `pressure` or `tail`.
    pub parting: String,
    /// The rung's name.
    pub rung: String,
    /// Which of the seeds; 0 for what needs none.
    pub seed: u64,
    /// Its errors on the runs held out.
    pub score: Score,
    /// How many runs it learnt from and was judged by.
    pub runs: [usize; 2],
}

/// The mean force of one run, measured and told.
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
    /// What cross-talk was taken out, on the mean, N.
    pub crosstalk_n: Newton,
}

/// One run as the figure shows it: samples each.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// The run's id.
    pub run: String,
    /// Whether it was learnt from.
    pub learnt: bool,
    /// s.
    pub time: Vec<Second>,
    /// Sideways displacement of the last mark, m.
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
    /// What curve and drift leave, N.
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
    /// The score of a rung on the card's own parting, first seed.
    pub fn of(&self, rung: &str) -> Option<&Scored> {
        self.scores.iter().find(|s| s.parting == "card" && s.rung == rung)
    }
}

impl Record for Thrust {
    type Of = Specimen;
    const STAGE: &'static str = "thrust";

    fn is_made_for(of: &Specimen) -> bool {
        let has = |split| of.trials().iter().any(|t| t.is_weighed_in_water() && t.trial.split == Some(split));
        has(lab::card::Split::Train) && has(lab::card::Split::Test)
    }

    fn pack(&self) -> Result<Parcel, RecordError> {
        let scalars = Scalars {
            scores: self.scores.clone(),
            means: self.means.clone(),
            traces: self.traces.iter().map(|t| (t.run.clone(), t.learnt)).collect(),
            crosstalk: self.crosstalk.clone(),
            coefficients: self.coefficients.clone(),
            runs: self.runs.iter().map(Head::of).collect(),
            density_kg_m3: self.density,
            sections: self.sections,
        };
        let parcel =
            Parcel::default().scalars("thrust.json", &scalars)?.file("network.safetensors", self.network.clone());
        let parcel = parcel.table("runs.parquet", &runs::table(&self.runs))?;
        self.traces.iter().enumerate().try_fold(parcel, |parcel, (i, trace)| {
            let columns = Columns::default()
                .numbers("time_s", trace.time.clone())
                .numbers("moved_m", trace.moved.clone())
                .numbers("measured_n", trace.measured.clone())
                .numbers("theory_n", trace.theory.clone())
                .numbers("network_n", trace.network.clone());
            parcel.table(&format!("trace{i}.parquet"), &columns)
        })
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        let s: Scalars = parcel.read_scalars("thrust.json")?;
        let trace = |(i, (run, learnt)): (usize, (String, bool))| -> Result<Trace, RecordError> {
            let columns = parcel.read_table(&format!("trace{i}.parquet"))?;
            Ok(Trace {
                run,
                learnt,
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
            network: parcel.bytes("network.safetensors")?.to_vec(),
            runs: runs::read(&s.runs, &parcel.read_table("runs.parquet")?)?,
            density: s.density_kg_m3,
            sections: s.sections,
        })
    }

    fn metrics(&self, of: &Specimen) -> Vec<Metric> {
        let name = &of.card.name;
        let mut all = vec![Metric::new(format!("thrust.{name}.crosstalk_lag_s"), self.crosstalk.lag_s, "s")];
        for scored in self.scores.iter().filter(|s| s.seed == 0) {
            let id = match scored.parting.as_str() {
                "card" => format!("thrust.{name}.{}", scored.rung),
                parting => format!("thrust.{name}.{}.by_{parting}", scored.rung),
            };
            let s = &scored.score;
            all.push(Metric::new(format!("{id}.nrmse"), s.nrmse, ""));
            all.push(Metric::new(format!("{id}.mean_error_percent"), s.mean_error_percent, "%"));
            all.push(Metric::new(format!("{id}.phase_deg"), s.phase_deg, "°"));
        }
        all
    }

    fn telling(&self) -> String {
        let said = ["mean", "ebt", "theory", "network"].iter().filter_map(|rung| self.of(rung));
        let said: Vec<String> = said.map(|s| format!("{} {:.2}", s.rung, s.score.nrmse)).collect();
        format!("NRMSE {}", said.join(", "))
    }
}
