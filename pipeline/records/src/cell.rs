//! The load cell's fixture: its transfer function from hammer taps, and an example of its deconvolution.

use serde::{Deserialize, Serialize};
use si::{Hertz, Newton};
use signal::cell::{Cell, DeconvolutionExample, Estimate, FrequencyResponse};
use signal::spectrum::Phasor;

use crate::subject::Specimen;
use workflow::columns::Columns;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// A fixture's identified dynamics, with the traces for the figure.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCell {
    /// Identified in the time domain; used by later stages.
    pub in_time: Fixture,
    /// Identified in the frequency domain.
    pub in_frequency: Fixture,
    /// How many taps.
    pub taps: usize,
    /// Standard deviation of the log before the first tap, N.
    pub noise: Newton,
    /// The measured response, rising in frequency.
    pub response: Vec<FrequencyResponse>,
    /// How the cell's log was sampled, and what was made of it.
    pub sampling: lab::Sampling,
    /// A non-negative thrust, the simulated measurement of it, and its deconvolution.
    pub example: DeconvolutionExample,
}

/// An estimate as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Fixture {
    /// f₀, Hz.
    pub natural_frequency_hz: Hertz,
    /// Its standard deviation, Hz.
    pub frequency_sigma_hz: Hertz,
    /// ζ, no unit.
    pub damping_ratio: f64,
    /// Its standard deviation.
    pub damping_sigma: f64,
    /// Cell's newtons for a newton of the hammer's.
    pub gain: f64,
}

impl From<Estimate> for Fixture {
    fn from(e: Estimate) -> Self {
        Self {
            natural_frequency_hz: e.cell.natural_frequency,
            frequency_sigma_hz: e.frequency_sigma,
            damping_ratio: e.cell.damping_ratio,
            damping_sigma: e.damping_sigma,
            gain: e.gain,
        }
    }
}

impl Fixture {
    /// As the type of `signal`.
    pub fn cell(&self) -> Cell {
        Cell { natural_frequency: self.natural_frequency_hz, damping_ratio: self.damping_ratio }
    }
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    in_time: Fixture,
    in_frequency: Fixture,
    taps: usize,
    noise_n: Newton,
    sigma_n: Newton,
    nrmse: [f64; 3],
    sampling: lab::Sampling,
}

impl Record for LoadCell {
    type Of = Specimen;
    const STAGE: &'static str = "load_cell";

    fn is_made_for(specimen: &Specimen) -> bool {
        specimen.card.fixture.iter().any(|f| matches!(f.of, lab::card::FixtureOf::Taps { .. }))
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let column = |part: fn(&FrequencyResponse) -> f64| self.response.iter().map(part).collect::<Vec<f64>>();
        let response = Columns::default()
            .numbers("frequency_hz", column(|r| r.frequency))
            .numbers("real", column(|r| r.transfer.re))
            .numbers("imaginary", column(|r| r.transfer.im))
            .numbers("coherence", column(|r| r.coherence));
        let example = Columns::default()
            .numbers("time_s", self.example.time.clone())
            .numbers("thrust_n", self.example.thrust.clone())
            .numbers("measured_n", self.example.measured.clone())
            .numbers("deconvolved_n", self.example.deconvolved.clone());
        let scalars = Scalars {
            in_time: self.in_time,
            in_frequency: self.in_frequency,
            taps: self.taps,
            noise_n: self.noise,
            sigma_n: self.example.sigma,
            nrmse: self.example.nrmse,
            sampling: self.sampling.clone(),
        };
        RecordFiles::default()
            .table("response.parquet", &response)?
            .table("example.parquet", &example)?
            .scalars("load_cell.json", &scalars)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let s: Scalars = files.read_scalars("load_cell.json")?;
        let (table, example) = (files.read_table("response.parquet")?, files.read_table("example.parquet")?);
        let [f, re, im, coherence] = ["frequency_hz", "real", "imaginary", "coherence"].map(|name| table.f64(name));
        let (f, re, im, coherence) = (f?, re?, im?, coherence?);
        let frequency_response = |i: usize| FrequencyResponse {
            frequency: f[i],
            transfer: Phasor::new(re[i], im[i]),
            coherence: coherence[i],
        };
        let example = DeconvolutionExample {
            time: example.f64("time_s")?,
            thrust: example.f64("thrust_n")?,
            measured: example.f64("measured_n")?,
            deconvolved: example.f64("deconvolved_n")?,
            sigma: s.sigma_n,
            nrmse: s.nrmse,
        };
        let response = (0..f.len()).map(frequency_response).collect();
        Ok(Self {
            in_time: s.in_time,
            in_frequency: s.in_frequency,
            taps: s.taps,
            noise: s.noise_n,
            response,
            sampling: s.sampling,
            example,
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let it = &self.in_time;
        let mut metrics = Vec::new();
        for id in ["load_cell".to_owned(), format!("load_cell.{subject}")] {
            metrics.push(Metric::new(format!("{id}.natural_frequency_hz"), it.natural_frequency_hz, "Hz"));
            metrics.push(Metric::new(format!("{id}.damping_ratio"), it.damping_ratio, ""));
            metrics.push(Metric::new(format!("{id}.deconvolution_nrmse"), self.example.nrmse[2], ""));
            metrics.push(Metric::new(format!("{id}.deconvolution_own_noise_nrmse"), self.example.nrmse[1], ""));
        }
        metrics
    }

    fn summary(&self) -> String {
        let it = &self.in_time;
        format!(
            "{:.3} ± {:.4} Hz, damping {:.5} ± {:.5}",
            it.natural_frequency_hz, it.frequency_sigma_hz, it.damping_ratio, it.damping_sigma
        )
    }
}
