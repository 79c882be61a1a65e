//! Harmonics of the tail beat within a wave's spectral line, which cannot be separated from the wave.

use si::{Hertz, Second};

use super::Wave;

/// A harmonic within a wave's spectral line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CloseHarmonic {
    /// Number of the harmonic, from 1.
    pub harmonic: usize,
    /// Its frequency, Hz.
    pub at: Hertz,
    /// Number of the wave, from 0.
    pub wave: usize,
    /// Distance between the two, Hz.
    pub distance: Hertz,
    /// Width of the wave's line, Hz: its own, or the resolution of the recording where that is coarser.
    pub width: Hertz,
}

impl std::fmt::Display for CloseHarmonic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { harmonic, at, wave, distance, width } = self;
        write!(
            f,
            "harmonic {harmonic} of the beat ({at:.3} Hz) is {distance:.3} Hz from wave {}, whose line is {width:.3} Hz wide",
            wave + 1
        )
    }
}

/// Every harmonic (up to `harmonics`) of a beat (Hz) that lies within half a line's width of a wave, in a recording of
/// `length` (s).
pub fn close_harmonics(beat: Hertz, harmonics: usize, waves: &[Wave], length: Second) -> Vec<CloseHarmonic> {
    let mut close = Vec::new();
    for (wave, line) in waves.iter().enumerate() {
        let width = line.width().max(1.0 / length);
        for harmonic in 1..=harmonics {
            let harmonic_frequency = harmonic as f64 * beat;
            let distance = (harmonic_frequency - line.frequency).abs();
            if distance < 0.5 * width {
                close.push(CloseHarmonic { harmonic, at: harmonic_frequency, wave, distance, width });
            }
        }
    }
    close
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(frequency: Hertz) -> Wave {
        let (frequency_sigma, decay_sigma, amplitude, phase) = (1e-3, 1e-2, 1e-3, 0.0);
        Wave { frequency, frequency_sigma, decay: 0.1, decay_sigma, amplitude, phase }
    }

    #[test]
    fn a_beat_and_a_harmonic_in_a_line_are_both_listed() {
        let waves = [wave(1.16), wave(1.85)];
        assert_eq!(close_harmonics(1.15, 1, &waves, 10.0).len(), 1);
        let second = close_harmonics(0.93, 3, &waves, 10.0);
        assert_eq!((second[0].harmonic, second[0].wave), (2, 1));
        assert!(second[0].to_string().contains("1.860 Hz"));
    }

    #[test]
    fn a_beat_two_line_widths_away_is_not_listed() {
        assert!(close_harmonics(2.0, 1, &[wave(1.8)], 10.0).is_empty());
        // the same beat in a recording that is too short to resolve the two
        assert_eq!(close_harmonics(2.0, 1, &[wave(1.8)], 2.0).len(), 1);
    }
}
