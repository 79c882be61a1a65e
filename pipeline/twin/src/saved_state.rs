//! A state as bytes: all that the next step depends on, so that a motion goes on to the same bits where it is read.
//!
//! A mark, then 64-bit numbers in a fixed order: counts, time, pressures, past values newest first, histories and stresses by region, and the
//! lagged inverse of the tangent where there is one.

use std::collections::VecDeque;

use crate::elastic::Stresses;
use crate::error::TwinError;
use crate::history::History;
use crate::lanes::{LANES, per_lane};
use crate::law::Symmetric;
use crate::state::{Lagged, Past, TwinState, Work};
use crate::step::Twin;

/// Begin of every saved state: its kind and version.
const MARK: &[u8; 8] = b"twin st1";

impl Twin {
    /// The state as bytes, which [`Twin::restored`] reads.
    ///
    /// # Errors
    /// [`TwinError::State`] when the state is of another twin.
    pub fn saved(&self, state: &TwinState) -> Result<Vec<u8>, TwinError> {
        self.check_state(state)?;
        let numbers = state.numbers();
        Ok(MARK.iter().copied().chain(numbers.iter().flat_map(|number| number.to_le_bytes())).collect())
    }

    /// A state that was saved.
    ///
    /// # Errors
    /// [`TwinError::Saved`] when the bytes are not of a state of this twin.
    pub fn restored(&self, bytes: &[u8]) -> Result<TwinState, TwinError> {
        let refused = |what: &str| TwinError::Saved { what: what.to_owned() };
        let content = bytes.strip_prefix(MARK).ok_or_else(|| refused("it does not begin as a saved state does"))?;
        let (eights, rest) = content.as_chunks();
        if !rest.is_empty() {
            return Err(refused("its last number is cut"));
        }
        let numbers: Vec<f64> = eights.iter().map(|eight| f64::from_le_bytes(*eight)).collect();
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(refused("a number in it is not finite"));
        }
        let mut reader = Reader { numbers: &numbers };
        let state = reader.state(self).filter(|_| reader.numbers.is_empty());
        state.ok_or_else(|| refused("it has the numbers of another twin"))
    }
}

impl TwinState {
    /// All numbers, in the order in which [`Reader::state`] takes them.
    fn numbers(&self) -> Vec<f64> {
        let Self { time, past, pressures, histories, factors, lagged, stresses, work } = self;
        let is_stressed = stresses.iter().any(|stresses| !stresses.law.is_empty());
        let counts = [past.times.len(), past.order, usize::from(is_stressed), usize::from(lagged.is_some())];
        let spent = [work.steps, work.residuals, work.tangents];
        let mut numbers: Vec<f64> = counts.iter().chain(&spent).map(|count| *count as f64).collect();
        numbers.extend([*time, factors.0]);
        numbers.extend(pressures);
        numbers.extend(&past.times);
        for rows in [&past.coordinates, &past.velocities, &past.momenta] {
            numbers.extend(rows.iter().flatten());
        }
        histories.iter().for_each(|history| extend(&mut numbers, history.tensors()));
        for stresses in stresses {
            extend(&mut numbers, &stresses.law);
            extend(&mut numbers, &stresses.relaxing);
        }
        if let Some(lagged) = lagged {
            numbers.push(lagged.gamma);
            numbers.extend(&lagged.inverse);
        }
        numbers
    }
}

fn extend(numbers: &mut Vec<f64>, tensors: &[Symmetric]) {
    numbers.extend(tensors.iter().flatten().flat_map(|lanes| lanes.to_array()));
}

/// The numbers that are left to read.
struct Reader<'a> {
    numbers: &'a [f64],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [f64]> {
        let (taken, left) = self.numbers.split_at_checked(count)?;
        self.numbers = left;
        Some(taken)
    }

    fn count(&mut self) -> Option<usize> {
        let number = self.take(1)?[0];
        (number >= 0.0 && number.fract() == 0.0 && number < 2f64.powi(53)).then_some(number as usize)
    }

    fn rows(&mut self, count: usize, length: usize) -> Option<VecDeque<Vec<f64>>> {
        (0..count).map(|_| self.take(length).map(<[f64]>::to_vec)).collect()
    }

    fn tensors(&mut self, count: usize) -> Option<Vec<Symmetric>> {
        // length: so many numbers were taken
        let entry = |numbers: &[f64], k: usize| per_lane(|lane| numbers[LANES * k + lane]);
        (0..count).map(|_| self.take(6 * LANES).map(|numbers| std::array::from_fn(|k| entry(numbers, k)))).collect()
    }

    /// A state of `twin`; none where the counts are none of a state, or numbers are missing.
    fn state(&mut self, twin: &Twin) -> Option<TwinState> {
        let (kept, order, stressed, is_lagged) = (self.count()?, self.count()?, self.count()?, self.count()?);
        let work = Work { steps: self.count()?, residuals: self.count()?, tangents: self.count()? };
        let (time, duration) = (self.take(1)?[0], self.take(1)?[0]);
        let r = twin.coordinates();
        let pressures = self.take(twin.chambers.len())?.to_vec();
        let times = self.take(kept)?.iter().copied().collect();
        let past = [self.rows(kept, r)?, self.rows(kept, r)?, self.rows(kept, r)?];
        let past = Past::restored(times, past, order)?;
        let histories = twin.solids.iter().map(|solid| {
            let [branches, tensors] = History::size(solid.block_count(), solid.branches.len());
            Some(History::restored(branches, self.tensors(tensors)?))
        });
        let histories = histories.collect::<Option<_>>()?;
        let stresses = twin.solids.iter().map(|solid| {
            let blocks = if stressed == 1 { solid.block_count() } else { 0 };
            Some(Stresses { law: self.tensors(blocks)?, relaxing: self.tensors(blocks)? })
        });
        let stresses = stresses.collect::<Option<_>>()?;
        let lagged = match is_lagged {
            0 => None,
            _ => Some(Lagged { gamma: self.take(1)?[0], inverse: self.take(r * r)?.to_vec() }),
        };
        let mut state =
            TwinState { time, past, pressures, histories, lagged, stresses, work, factors: (0.0, Vec::new()) };
        if duration > 0.0 {
            twin.prepare_factors(&mut state, duration);
        }
        Some(state)
    }
}
