//! The load cell's fixture: what taps say of it, and the inverse shown at work.

use serde::{Deserialize, Serialize};
use si::{Hertz, Newton, Second};
use signal::cell::{Cell, Estimate, Response};
use signal::spectrum::Phasor;

use crate::columns::Columns;
use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Specimen;

/// A fixture, and the traces that show it.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCell {
    /// From the time domain: the one to use.
    pub in_time: Fixture,
    /// From the frequency domain.
    pub in_frequency: Fixture,
    /// How many taps.
    pub taps: usize,
    /// Standard deviation of the log before the first tap, N.
    pub noise: Newton,
    /// The measured response, rising in frequency.
    pub response: Vec<Response>,
    /// A thrust that is never negative, what the cell would feel of it, and what the inverse makes of that.
    pub shown: Shown,
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

/// The inverse at work on a thrust made for it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shown {
    /// s.
    pub time: Vec<Second>,
    /// Never negative, N.
    pub thrust: Vec<Newton>,
    /// By the fixture as found, with the log's noise, N.
    pub felt: Vec<Newton>,
    /// By the inverse, N.
    pub undone: Vec<Newton>,
    /// Standard deviation that noise gives the inverse, N.
    pub sigma: Newton,
    /// Root of the mean squared error over the thrust's standard deviation: as felt, undone, and undone where the
    /// noise is 40 dB under the signal.
    pub nrmse: [f64; 3],
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
    /// As `signal` knows it.
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
}

impl Record for LoadCell {
    type Of = Specimen;
    const STAGE: &'static str = "load_cell";

    fn is_made_for(of: &Specimen) -> bool {
        of.card.fixture.iter().any(|f| matches!(f.of, lab::card::FixtureOf::Taps { .. }))
    }

    fn pack(&self) -> Result<Parcel, RecordError> {
        let of = |part: fn(&Response) -> f64| self.response.iter().map(part).collect::<Vec<f64>>();
        let response = Columns::default()
            .numbers("frequency_hz", of(|r| r.frequency))
            .numbers("real", of(|r| r.transfer.re))
            .numbers("imaginary", of(|r| r.transfer.im))
            .numbers("coherence", of(|r| r.coherence));
        let shown = Columns::default()
            .numbers("time_s", self.shown.time.clone())
            .numbers("thrust_n", self.shown.thrust.clone())
            .numbers("felt_n", self.shown.felt.clone())
            .numbers("undone_n", self.shown.undone.clone());
        let scalars = Scalars {
            in_time: self.in_time,
            in_frequency: self.in_frequency,
            taps: self.taps,
            noise_n: self.noise,
            sigma_n: self.shown.sigma,
            nrmse: self.shown.nrmse,
        };
        Parcel::default()
            .table("response.parquet", &response)?
            .table("shown.parquet", &shown)?
            .scalars("load_cell.json", &scalars)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        let s: Scalars = parcel.read_scalars("load_cell.json")?;
        let (table, shown) = (parcel.read_table("response.parquet")?, parcel.read_table("shown.parquet")?);
        let [f, re, im, coherence] = ["frequency_hz", "real", "imaginary", "coherence"].map(|name| table.f64(name));
        let (f, re, im, coherence) = (f?, re?, im?, coherence?);
        let one = |i: usize| Response { frequency: f[i], transfer: Phasor::new(re[i], im[i]), coherence: coherence[i] };
        let shown = Shown {
            time: shown.f64("time_s")?,
            thrust: shown.f64("thrust_n")?,
            felt: shown.f64("felt_n")?,
            undone: shown.f64("undone_n")?,
            sigma: s.sigma_n,
            nrmse: s.nrmse,
        };
        let response = (0..f.len()).map(one).collect();
        Ok(Self { in_time: s.in_time, in_frequency: s.in_frequency, taps: s.taps, noise: s.noise_n, response, shown })
    }

    fn metrics(&self, of: &Specimen) -> Vec<Metric> {
        let it = &self.in_time;
        let mut all = Vec::new();
        for id in ["load_cell".to_owned(), format!("load_cell.{}", of.card.name)] {
            all.push(Metric::new(format!("{id}.natural_frequency_hz"), it.natural_frequency_hz, "Hz"));
            all.push(Metric::new(format!("{id}.damping_ratio"), it.damping_ratio, ""));
            all.push(Metric::new(format!("{id}.round_trip_nrmse"), self.shown.nrmse[2], ""));
            all.push(Metric::new(format!("{id}.round_trip_own_noise_nrmse"), self.shown.nrmse[1], ""));
        }
        all
    }

    fn telling(&self) -> String {
        let it = &self.in_time;
        format!(
            "{:.3} ± {:.4} Hz, damping {:.5} ± {:.5}",
            it.natural_frequency_hz, it.frequency_sigma_hz, it.damping_ratio, it.damping_sigma
        )
    }
}
