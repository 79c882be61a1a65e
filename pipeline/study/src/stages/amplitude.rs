//! The predicted amplitude of the tip with its interval, to which the uncertainty of the identified parameters is propagated.

use fem::DynamicSettings;
use hydro::Coefficients;
use rayon::prelude::*;
use si::{Metre, Second};
use signal::resample::Samples;

use super::deviations::{PART, UncertainSilicone};
use diagnostics::Result;
use records::{Drag, Interval};
use sysid::actuated::Actuation;
use sysid::{ReducedBody, Viscoelastic};

/// The path of the tip marker of a body in water with these coefficients, or without water.
pub(super) type Simulated<'a> =
    dyn Fn(&ReducedBody, &DynamicSettings, Option<Coefficients>, &Actuation) -> Result<[Samples; 2]> + Sync + 'a;

/// What the prediction rests on.
pub(super) struct Predicted<'a> {
    pub silicone: UncertainSilicone<'a>,
    pub reduced_body: &'a ReducedBody,
    pub drag: Option<&'a Drag>,
    pub settings: &'a DynamicSettings,
}

impl Predicted<'_> {
    /// The relative standard deviation of the amplitude, from a motion under `actuation` to both sides, in which the opposed scales of the
    /// chambers cancel. Silicone, added mass and drag count as independent of each other, which is on the safe side: the drag follows the
    /// silicone. A film differs from the films of identification by a scale of its own.
    pub(super) fn relative_sigma(&self, simulated: &Simulated, actuation: &Actuation) -> Result<f64> {
        let coefficients = self.drag.map(|d| d.by);
        let times: Vec<Second> = actuation.times(self.settings.step).iter().map(|t| actuation.begin + t).collect();
        let log_amplitude = |body: &ReducedBody, coefficients| -> Result<f64> {
            Ok(rms_amplitude(&simulated(body, self.settings, coefficients, actuation)?, &times).ln())
        };
        let nominal = log_amplitude(self.reduced_body, coefficients)?;
        let silicones = self.silicone.perturbed_silicones()?;
        let of_silicone = |silicone: &Viscoelastic| {
            let perturbed = log_amplitude(&self.reduced_body.with(self.silicone.model, silicone), coefficients)?;
            Ok(nominal + (perturbed - nominal) / PART)
        };
        let mut log_amplitudes: Vec<f64> = silicones.par_iter().map(of_silicone).collect::<Result<_>>()?;
        if let Some(drag) = self.drag {
            let Coefficients { added, drag: normal } = drag.by;
            let waters = [
                Coefficients { added: added + drag.sigma.added, drag: normal },
                Coefficients { added, drag: normal + drag.sigma.drag },
            ];
            log_amplitudes.extend(
                waters
                    .into_iter()
                    .map(|coefficients| log_amplitude(self.reduced_body, Some(coefficients)))
                    .collect::<Result<Vec<_>>>()?,
            );
        }
        let variance: f64 = log_amplitudes.iter().map(|perturbed| (perturbed - nominal).powi(2)).sum();
        Ok((variance + self.silicone.identified.noise.scale_sigma.powi(2)).sqrt())
    }
}

/// Root mean square of the lateral displacement of a path at these times, m.
pub(super) fn rms_amplitude([_, lateral]: &[Samples; 2], times: &[Second]) -> Metre {
    let squares: f64 = times.iter().map(|&t| lateral.at(t).powi(2)).sum();
    (squares / times.len().max(1) as f64).sqrt()
}

/// An amplitude with its relative standard deviation.
pub(super) fn rms_interval(path: &[Samples; 2], times: &[Second], sigma: f64) -> Interval {
    Interval { value: rms_amplitude(path, times), sigma }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_amplitude_of_a_sine_is_its_root_mean_square() {
        let times: Vec<f64> = (0..=400).map(|i| 0.01 * f64::from(i)).collect();
        let lateral = times.iter().map(|t| 3e-3 * (std::f64::consts::PI * t).sin()).collect();
        let path =
            [Samples::new(times.clone(), vec![1.0; 401]).unwrap(), Samples::new(times.clone(), lateral).unwrap()];
        assert!((rms_amplitude(&path, &times[..400]) - 3e-3 / 2f64.sqrt()).abs() < 1e-9);
    }
}
