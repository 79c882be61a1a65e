//! A reduced tail laid out for a processor's vectors: its outputs, chambers and limits.

use crate::data::{Chamber, Output, TwinData};
use crate::elastic::{Solid, Stresses};
use crate::error::TwinError;
use crate::history::History;
use crate::state::{Lagged, Past, TwinState, Work};
use crate::water::Water;
use crate::workspace::Workspace;

/// Largest size of the last iteration, relative to the largest shape. 1e-7 takes a tenth longer and moves the tip of a flapping tail by 2e-3 %
/// of its length; 1e-4 excites the stiff sheet and moves it by 4 %.
const TOLERANCE: f64 = 1e-6;
/// Iterations of a step at most, unless a caller sets them; a step that needs more is halved.
const MAX_ITERATIONS: usize = 30;
/// Least tolerance: rounding.
const LEAST: f64 = 1e-11;
/// Part of a chamber's range by which a pressure may lie beyond it: the noise of a gauge and the overshoot of a valve.
const RANGE_MARGIN: f64 = 0.01;

/// A reduced tail, laid out for stepping.
#[derive(Debug, Clone)]
pub struct Twin {
    pub(crate) mass: Vec<f64>,
    pub(crate) size: f64,
    pub(crate) solids: Vec<Solid>,
    pub(crate) chambers: Vec<Chamber>,
    pub(crate) water: Option<Water>,
    outputs: Vec<Output>,
    pub(crate) tolerance: f64,
    pub(crate) max_iterations: usize,
}

impl Twin {
    /// Of a tail's arrays.
    ///
    /// # Errors
    /// [`TwinError::Data`] when they do not belong together.
    pub fn new(data: TwinData) -> Result<Self, TwinError> {
        data.check_data()?;
        let r = data.coordinates();
        let solids = data.regions.iter().map(|region| Solid::new(region, r)).collect();
        let water = (!data.sections.is_empty()).then(|| Water::new(&data.sections, r));
        let TwinData { mass, size, chambers, outputs, .. } = data;
        Ok(Self { mass, size, solids, chambers, water, outputs, tolerance: TOLERANCE, max_iterations: MAX_ITERATIONS })
    }

    /// The same with other iterations of a step at most, 30 unless set: a step that needs more is halved. Fewer bound the time of an attempt.
    #[must_use]
    pub fn with_iterations(self, most: usize) -> Self {
        Self { max_iterations: most.max(1), ..self }
    }

    /// The same with another tolerance of a step: the largest size of its last iteration relative to the largest shape, 1e-6 unless set.
    /// Differences of motions need one near 1e-11, the least.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance: tolerance.max(LEAST), ..self }
    }

    /// r.
    pub fn coordinates(&self) -> usize {
        self.mass.len().isqrt()
    }

    /// At rest for ever.
    pub fn start(&self) -> TwinState {
        let history = |solid: &Solid| History::at_rest(solid.block_count(), solid.branches.len());
        let (r, solids) = (self.coordinates(), &self.solids);
        TwinState {
            time: 0.0,
            past: Past::at_rest(r),
            pressures: vec![0.0; self.chambers.len()],
            histories: solids.iter().map(history).collect(),
            factors: (0.0, solids.iter().map(|solid| Vec::with_capacity(solid.branches.len())).collect()),
            lagged: Lagged::none(r),
            stresses: solids.iter().map(|solid| Stresses::with_capacity(solid.block_count())).collect(),
            work: Work::default(),
            workspace: Workspace::new(solids, r),
        }
    }

    /// Names of the outputs.
    pub fn outputs(&self) -> impl Iterator<Item = &str> {
        self.outputs.iter().map(|output| &*output.name)
    }

    /// The chambers: their channels and ranges.
    pub fn chambers(&self) -> &[Chamber] {
        &self.chambers
    }

    /// The number of the output of this name.
    ///
    /// # Errors
    /// [`TwinError::Output`], with the names that there are.
    pub fn output_number(&self, name: &str) -> Result<usize, TwinError> {
        let number = self.outputs.iter().position(|output| output.name == name);
        number.ok_or_else(|| TwinError::Output {
            name: name.to_owned(),
            names: self.outputs().collect::<Vec<_>>().join(", "),
        })
    }

    /// The displacement that is output `number`, m.
    ///
    /// # Panics
    /// When there is no such output, or the state has other coordinates.
    pub fn output(&self, state: &TwinState, number: usize) -> f64 {
        let (row, q) = (self.output_row(number), state.coordinates());
        assert_eq!(row.len(), q.len(), "a state of other coordinates");
        row.iter().zip(q).map(|(row, q)| row * q).sum()
    }

    /// The row of r numbers that gives output `number`, m per unit of q.
    ///
    /// # Panics
    /// When there is no such output.
    pub fn output_row(&self, number: usize) -> &[f64] {
        &self.outputs[number].row
    }

    /// The largest entry of q over that of the shapes which the tail was reduced from: above 1 it is larger than anything that was seen, and its
    /// shape is extrapolated.
    pub fn excursion(&self, state: &TwinState) -> f64 {
        largest_entry(state.coordinates()) / self.size
    }

    /// The volume of a chamber, m³; of a half model, of the half.
    ///
    /// # Panics
    /// When there is no such chamber, or the state has other coordinates.
    pub fn chamber_volume(&self, state: &TwinState, chamber: usize) -> f64 {
        assert_eq!(self.coordinates(), state.coordinates().len(), "a state of other coordinates");
        self.chambers[chamber].volume(state.coordinates())
    }

    /// # Errors
    /// [`TwinError::Input`] when they are not one finite number for each chamber, [`TwinError::Pressure`] when one is beyond its range.
    pub(crate) fn check_pressures(&self, pressures: &[f64]) -> Result<(), TwinError> {
        if pressures.len() != self.chambers.len() || pressures.iter().any(|p| !p.is_finite()) {
            let what = format!("the pressures {pressures:?} of {} chambers", self.chambers.len());
            return Err(TwinError::Input { what });
        }
        let is_beyond = |(chamber, pressure): &(&Chamber, &f64)| {
            let [low, high] = chamber.range;
            let margin = RANGE_MARGIN * (high - low);
            !(low - margin..=high + margin).contains(pressure)
        };
        match self.chambers.iter().zip(pressures).find(is_beyond) {
            Some((Chamber { name, range, .. }, pressure)) => {
                Err(TwinError::Pressure { chamber: name.clone(), pressure: *pressure, range: *range })
            }
            None => Ok(()),
        }
    }

    /// # Errors
    /// [`TwinError::State`] when the state is of a twin with other coordinates, chambers, regions, points or branches.
    pub(crate) fn check_state(&self, state: &TwinState) -> Result<(), TwinError> {
        let own_sizes = self.solids.iter().map(|solid| History::size(solid.block_count(), solid.branches.len()));
        let fits = state.coordinates().len() == self.coordinates()
            && state.pressures.len() == self.chambers.len()
            && own_sizes.eq(state.histories.iter().map(History::own_size));
        let counts = || [state.coordinates().len(), state.pressures.len(), state.histories.len()];
        let required = || [self.coordinates(), self.chambers.len(), self.solids.len()];
        if fits { Ok(()) } else { Err(TwinError::State { counts: counts(), required: required() }) }
    }
}

/// Largest absolute entry; not a number where one is not.
pub(crate) fn largest_entry(x: &[f64]) -> f64 {
    // `f64::max` drops what is not a number, and a diverged iterate would count as converged.
    if x.iter().any(|entry| entry.is_nan()) {
        return f64::NAN;
    }
    x.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()))
}
