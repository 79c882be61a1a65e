//! A state as bytes: all that the next step depends on, so that a motion goes on to the same bits where it is read.
//!
//! A mark, then 64-bit numbers in a fixed order: counts, time, pressures, past values newest first, histories and stresses by region, and the
//! lagged inverse of the tangent where there is one.

use crate::elastic::Stresses;
use crate::error::TwinError;
use crate::history::History;
use crate::lanes::{LANES, per_lane};
use crate::law::Symmetric;
use crate::state::{KEPT, Past, TwinState, Work};
use crate::twin::Twin;

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
        let Self { time, past, pressures, histories, factors, lagged, stresses, work, .. } = self;
        let (is_stressed, is_lagged) = (stresses.iter().any(|by| !by.law.is_empty()), lagged.gamma.is_finite());
        let counts = [past.count, past.order, usize::from(is_stressed), usize::from(is_lagged)];
        let spent = [work.steps, work.residuals, work.tangents];
        let mut numbers: Vec<f64> = counts.iter().chain(&spent).map(|count| *count as f64).collect();
        numbers.extend([*time, factors.0]);
        numbers.extend(pressures);
        numbers.extend(&past.times[..past.count]);
        for rows in [&past.coordinates, &past.velocities, &past.momenta] {
            numbers.extend(rows[..past.count].iter().flatten());
        }
        histories.iter().for_each(|history| extend(&mut numbers, history.tensors()));
        for stresses in stresses {
            extend(&mut numbers, &stresses.law);
            extend(&mut numbers, &stresses.relaxing);
        }
        if is_lagged {
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
        // A count is saved as a double, which holds whole numbers exactly up to 2⁵³.
        (number >= 0.0 && number.fract() == 0.0 && number < 2f64.powi(53)).then_some(number as usize)
    }

    /// Fills the first of `rows`.
    fn rows(&mut self, count: usize, rows: &mut [Vec<f64>; KEPT]) -> Option<()> {
        rows[..count].iter_mut().try_for_each(|row| {
            let length = row.len();
            row.copy_from_slice(self.take(length)?);
            Some(())
        })
    }

    fn tensors(&mut self, count: usize) -> Option<Vec<Symmetric>> {
        // length: so many numbers were taken
        let entry = |numbers: &[f64], k: usize| per_lane(|lane| numbers[LANES * k + lane]);
        (0..count).map(|_| self.take(6 * LANES).map(|numbers| std::array::from_fn(|k| entry(numbers, k)))).collect()
    }

    /// A state of `twin`; none where the counts are none of a state, or numbers are missing.
    fn state(&mut self, twin: &Twin) -> Option<TwinState> {
        let (count, order, is_stressed, is_lagged) = (self.count()?, self.count()?, self.count()?, self.count()?);
        let mut state = twin.start();
        state.work = Work { steps: self.count()?, residuals: self.count()?, tangents: self.count()? };
        state.time = self.take(1)?[0];
        let duration = self.take(1)?[0];
        state.pressures.copy_from_slice(self.take(twin.chambers.len())?);
        self.past((count, order), &mut state.past)?;
        for (solid, history) in twin.solids.iter().zip(&mut state.histories) {
            let [branches, tensors] = History::size(solid.block_count(), solid.branches.len());
            *history = History::restored(branches, self.tensors(tensors)?);
        }
        for (solid, stresses) in twin.solids.iter().zip(&mut state.stresses).filter(|_| is_stressed == 1) {
            let blocks = solid.block_count();
            *stresses = Stresses { law: self.tensors(blocks)?, relaxing: self.tensors(blocks)? };
        }
        if is_lagged == 1 {
            state.lagged.gamma = self.take(1)?[0];
            state.lagged.inverse.copy_from_slice(self.take(twin.mass.len())?);
        }
        if duration > 0.0 {
            state.prepare_factors(&twin.solids, duration);
        }
        Some(state)
    }

    fn past(&mut self, (count, order): (usize, usize), past: &mut Past) -> Option<()> {
        if !(1..=KEPT).contains(&count) || !(1..=count).contains(&order) {
            return None;
        }
        (past.count, past.order) = (count, order);
        past.times[..count].copy_from_slice(self.take(count)?);
        // the weights of a guess divide by the time between two states
        past.times[..count].is_sorted_by(|newer, older| newer > older).then_some(())?;
        [&mut past.coordinates, &mut past.velocities, &mut past.momenta]
            .into_iter()
            .try_for_each(|rows| self.rows(count, rows))
    }
}
