//! Histories: pressure as a function of time, or of the level of a static case.

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use si::{Hertz, Pascal, Radian, Second};

/// A constant, or a function of time.
#[derive(Debug, Clone, PartialEq)]
pub enum History {
    /// Constant in time; multiplied by the level of a static case.
    Constant(Pascal),
    /// A function of time.
    Wave(Wave),
}

/// A function of time.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Wave {
    /// Linear between points, constant before the first and after the last.
    Table {
        /// s, rising.
        times: Vec<Second>,
        /// Pa.
        values: Vec<Pascal>,
    },
    /// mean + amplitude · sin(2π · frequency · t + phase)
    Sine {
        /// Pa.
        mean: Pascal,
        /// Pa.
        amplitude: Pascal,
        /// Hz.
        frequency: Hertz,
        /// rad.
        #[serde(default)]
        phase: Radian,
    },
    /// High for the part `duty` of each period, then low.
    Square {
        /// Pa.
        low: Pascal,
        /// Pa.
        high: Pascal,
        /// Hz.
        frequency: Hertz,
        /// No unit, between 0 and 1.
        #[serde(default = "half")]
        duty: f64,
    },
    /// Linear from one value to another, then constant.
    Ramp {
        /// Pa.
        #[serde(default)]
        from: Pascal,
        /// Pa.
        to: Pascal,
        /// s.
        #[serde(default)]
        start: Second,
        /// s.
        seconds: Second,
    },
}

fn half() -> f64 {
    0.5
}

impl Default for History {
    fn default() -> Self {
        Self::Constant(0.0)
    }
}

impl History {
    /// The value at `time`, s.
    pub fn value_at(&self, time: Second) -> Pascal {
        match self {
            Self::Constant(value) => *value,
            Self::Wave(wave) => wave.value_at(time),
        }
    }

    /// The value at a level of a static case.
    pub(crate) fn at_level(&self, level: f64) -> Pascal {
        match self {
            Self::Constant(value) => level * value,
            Self::Wave(wave) => wave.value_at(level),
        }
    }
}

impl Wave {
    fn value_at(&self, time: Second) -> Pascal {
        match self {
            Self::Table { times, values } => interpolate(times, values, time),
            Self::Sine { mean, amplitude, frequency, phase } => {
                mean + amplitude * (std::f64::consts::TAU * frequency * time + phase).sin()
            }
            Self::Square { low, high, frequency, duty } => {
                if (frequency * time).rem_euclid(1.0) < *duty {
                    *high
                } else {
                    *low
                }
            }
            Self::Ramp { from, to, start, seconds } => from + (to - from) * ((time - start) / seconds).clamp(0.0, 1.0),
        }
    }
}

fn interpolate(times: &[Second], values: &[Pascal], time: Second) -> Pascal {
    let next = times.partition_point(|earlier| *earlier <= time);
    if next == 0 || next == times.len() {
        return values[next.saturating_sub(1)];
    }
    let part = (time - times[next - 1]) / (times[next] - times[next - 1]);
    values[next - 1] + part * (values[next] - values[next - 1])
}

impl<'de> Deserialize<'de> for History {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Word;
        impl<'de> Visitor<'de> for Word {
            type Value = History;

            fn expecting(&self, out: &mut std::fmt::Formatter) -> std::fmt::Result {
                write!(out, "a number of Pa, or one of `table`, `sine`, `square`, `ramp`")
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<History, E> {
                Ok(History::Constant(value))
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<History, E> {
                Ok(History::Constant(value as f64))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<History, A::Error> {
                Wave::deserialize(MapAccessDeserializer::new(map)).map(History::Wave)
            }
        }
        from.deserialize_any(Word)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Deserialize)]
    struct Holder {
        pressure: History,
    }

    fn history(text: &str) -> History {
        toml::from_str::<Holder>(&format!("pressure = {text}")).unwrap().pressure
    }

    #[test]
    fn a_number_counts_with_the_level_and_a_course_is_read_at_it() {
        assert_eq!(history("2000").at_level(0.25), 500.0);
        assert_eq!(history("2e3").value_at(7.0), 2000.0);
        let table = history("{ table = { times = [0, 1, 3], values = [0, 10, 20] } }");
        assert_eq!([-1.0, 0.5, 2.0, 9.0].map(|time| table.value_at(time)), [0.0, 5.0, 15.0, 20.0]);
    }

    #[test]
    fn waves_take_their_values() {
        let sine = history("{ sine = { mean = 1, amplitude = 2, frequency = 0.5 } }");
        assert!((sine.value_at(0.5) - 3.0).abs() < 1e-15);
        let square = history("{ square = { low = -1, high = 1, frequency = 2 } }");
        assert_eq!([0.0, 0.2, 0.3, 0.5].map(|time| square.value_at(time)), [1.0, 1.0, -1.0, 1.0]);
        let ramp = history("{ ramp = { to = 8, start = 1, seconds = 2 } }");
        assert_eq!([0.0, 2.0, 5.0].map(|time| ramp.value_at(time)), [0.0, 4.0, 8.0]);
    }

    #[test]
    fn a_misspelt_wave_names_the_known_ones() {
        let said = toml::from_str::<Holder>("pressure = { sin = { mean = 1 } }").err().unwrap().to_string();
        assert!(said.contains("unknown variant `sin`") && said.contains("`sine`"), "{said}");
    }
}
