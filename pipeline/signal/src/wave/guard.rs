//! The guard: a beat or a harmonic of it that lies in a wave's line cannot be told from the wave.
//!
//! Stands on: the wave. Never knows: a trial.

use si::{Hertz, Second};

use super::Wave;

/// A harmonic that lies in a wave's line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near {
    /// Which harmonic of the beat, from 1.
    pub harmonic: usize,
    /// Its frequency, Hz.
    pub at: Hertz,
    /// Which wave, from 0.
    pub wave: usize,
    /// Between the two, Hz.
    pub apart: Hertz,
    /// The wave's line, Hz: its own width, or what so short a recording can tell apart, whichever is wider.
    pub width: Hertz,
}

impl std::fmt::Display for Near {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { harmonic, at, wave, apart, width } = self;
        write!(
            f,
            "harmonic {harmonic} of the beat ({at:.3} Hz) is {apart:.3} Hz from wave {}, whose line is {width:.3} Hz wide",
            wave + 1
        )
    }
}

/// Every harmonic (up to `harmonics`) of a beat (Hz) that lies within half a line's width of a wave, in a recording of
/// `length` (s).
pub fn near(beat: Hertz, harmonics: usize, waves: &[Wave], length: Second) -> Vec<Near> {
    let mut all = Vec::new();
    for (wave, it) in waves.iter().enumerate() {
        let width = it.width().max(1.0 / length);
        for harmonic in 1..=harmonics {
            let at = harmonic as f64 * beat;
            let apart = (at - it.frequency).abs();
            if apart < 0.5 * width {
                all.push(Near { harmonic, at, wave, apart, width });
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(frequency: Hertz) -> Wave {
        let (frequency_sigma, decay_sigma, amplitude, phase) = (1e-3, 1e-2, 1e-3, 0.0);
        Wave { frequency, frequency_sigma, decay: 0.1, decay_sigma, amplitude, phase }
    }

    #[test]
    fn a_beat_on_the_wave_and_a_harmonic_on_it_are_both_named() {
        let waves = [wave(1.16), wave(1.85)];
        assert_eq!(near(1.15, 1, &waves, 10.0).len(), 1);
        let second = near(0.93, 3, &waves, 10.0);
        assert_eq!((second[0].harmonic, second[0].wave), (2, 1));
        assert!(second[0].to_string().contains("1.860 Hz"));
    }

    #[test]
    fn a_beat_two_line_widths_away_is_left_alone() {
        assert!(near(2.0, 1, &[wave(1.8)], 10.0).is_empty());
        // the same beat in a recording that is too short to tell the two apart
        assert_eq!(near(2.0, 1, &[wave(1.8)], 2.0).len(), 1);
    }
}
