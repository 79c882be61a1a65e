//! Cholesky's factor of the stiffness matrix, by faer's supernodal kernels.
//!
//! The structure is worked out once for a [`crate::System`]; each solver owns the numbers and their scratch space.
//! One thread inside: the second core serves an independent solve (FACTS).
//!
//! Stands on: `sparse`, `faer`. Never knows: what the matrix stands for.

use crate::algebra::sparse::Pattern;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side};

/// Structure of the matrix and of its factor.
#[derive(Debug)]
pub(crate) struct Symbolic {
    lower: SymbolicSparseColMat<u32>,
    cholesky: SymbolicCholesky<u32>,
}

/// Why a matrix has no factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum NoFactor {
    /// A pivot is not positive: the state is not a stable one.
    NotPositive,
    /// The factor does not solve its own matrix.
    Inexact {
        /// ‖Kx − b‖ over ‖b‖ or ‖diag(K) x‖, whichever is larger.
        residual: f64,
    },
}

/// Largest part of its own terms that a solve may leave unbalanced: rounding leaves 1e-13 at a stiffness contrast of 10⁴.
pub(crate) const INEXACT: f64 = 1e-9;

impl Symbolic {
    /// Analyses the pattern in the order that it already has.
    ///
    /// # Errors
    /// faer's own, when indices or memory overflow.
    pub fn new(pattern: &Pattern) -> Result<Self, faer::sparse::FaerError> {
        let n = pattern.freedoms();
        let lower = SymbolicSparseColMat::new_checked(n, n, pattern.columns.clone(), None, pattern.rows.clone());
        let (columns, rows) = upper(pattern);
        let upper = SymbolicSparseColMat::new_checked(n, n, columns, None, rows);
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let cholesky = factorize_symbolic_cholesky(upper.as_ref(), Side::Upper, SymmetricOrdering::Identity, params)?;
        Ok(Self { lower, cholesky })
    }

    /// Entries of the factor, with the zeros inside supernodes.
    pub fn entries(&self) -> usize {
        self.cholesky.len_val()
    }
}

/// The transposed pattern: faer analyses an upper triangle, and factorises a lower one.
fn upper(pattern: &Pattern) -> (Vec<u32>, Vec<u32>) {
    let n = pattern.freedoms();
    let mut columns = vec![0u32; n + 1];
    pattern.rows.iter().for_each(|&row| columns[row as usize + 1] += 1);
    for row in 0..n {
        columns[row + 1] += columns[row];
    }
    let mut next = columns.clone();
    let mut rows = vec![0u32; pattern.rows.len()];
    for column in 0..n {
        for &row in &pattern.rows[pattern.columns[column] as usize..pattern.columns[column + 1] as usize] {
            rows[next[row as usize] as usize] = column as u32;
            next[row as usize] += 1;
        }
    }
    (columns, rows)
}

/// Numbers of one factor, and the space to make and use it.
pub(crate) struct Factor {
    values: Vec<f64>,
    making: MemBuffer,
    solving: MemBuffer,
    ready: bool,
}

impl Factor {
    /// Space for a factor of this structure.
    pub fn new(symbolic: &Symbolic) -> Self {
        let cholesky = &symbolic.cholesky;
        Self {
            values: vec![0.0; cholesky.len_val()],
            making: MemBuffer::new(cholesky.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())),
            solving: MemBuffer::new(cholesky.solve_in_place_scratch::<f64>(1, Par::Seq)),
            ready: false,
        }
    }

    /// Whether there is a factor to solve with.
    pub fn is_ready(&self) -> bool {
        self.ready
    }

    /// Factorises the lower triangle `values`, and checks the factor by solving K x = `probe`.
    ///
    /// # Errors
    /// [`NoFactor`]; no factor is then kept.
    pub fn make(
        &mut self,
        symbolic: &Symbolic,
        pattern: &Pattern,
        values: &[f64],
        probe: &[f64],
    ) -> Result<(), NoFactor> {
        self.ready = false;
        let matrix = SparseColMatRef::new(symbolic.lower.as_ref(), values);
        let made = symbolic.cholesky.factorize_numeric_llt(
            &mut self.values,
            matrix,
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.making),
            Default::default(),
        );
        match made {
            Ok(_) => self.ready = true,
            Err(_) => return Err(NoFactor::NotPositive),
        }
        let residual = self.residual(symbolic, pattern, values, probe);
        if residual <= INEXACT {
            return Ok(());
        }
        self.ready = false;
        Err(if residual.is_nan() { NoFactor::NotPositive } else { NoFactor::Inexact { residual } })
    }

    fn residual(&mut self, symbolic: &Symbolic, pattern: &Pattern, values: &[f64], probe: &[f64]) -> f64 {
        let size = norm(probe);
        if size == 0.0 {
            return 0.0;
        }
        let mut x = probe.to_vec();
        self.solve(symbolic, &mut x);
        let mut back = vec![0.0; x.len()];
        pattern.multiply(values, &x, &mut back);
        back.iter_mut().zip(probe).for_each(|(left, right)| *left -= right);
        let diagonal = pattern.columns.iter().map(|&first| first as usize);
        let terms: Vec<f64> = x.iter().zip(diagonal).map(|(x, first)| values[first] * x).collect();
        norm(&back) / size.max(norm(&terms))
    }

    /// x ← K⁻¹ x, in elimination order.
    ///
    /// # Panics
    /// When no factor was made.
    pub fn solve(&mut self, symbolic: &Symbolic, x: &mut [f64]) {
        assert!(self.ready, "a factor is made before it is used");
        let n = x.len();
        LltRef::new(&symbolic.cholesky, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, n, 1),
            Par::Seq,
            MemStack::new(&mut self.solving),
        );
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum::<f64>().sqrt()
}
