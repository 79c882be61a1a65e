//! One iteration, part by part, and its factor beside faer's own.

use crate::Outcome;
use crate::clock::{say, timed};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{CholeskySymbolicParams, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Par, Side};
use fem::{LowerTriangle, StaticSettings, System};

/// Assembly, factor and solve of one iteration.
pub fn iteration(system: &System) -> Outcome<()> {
    let mut solver = system.solver();
    let equilibrium = solver.equilibrium(&[0.0, 1e4], None, &StaticSettings::default())?;
    let (assembly, ()) = timed(3, || Ok(solver.assemble(&equilibrium).map(|_| ())?))?;
    let (faer, ()) = faers_own(&solver.assemble(&equilibrium)?)?;
    let (factor, ()) = timed(3, || Ok(solver.factorise(&equilibrium)?))?;
    let b = vec![1.0; equilibrium.displacement.len()];
    let (solve, _) = timed(5, || Ok(solver.solve(&b)?))?;
    let iteration = assembly + factor + solve;
    say("assembly of the tangent", assembly, Some((iteration, "an iteration")));
    say("factor, checked", factor, Some((faer, "faer's own on the same matrix")));
    say("solve", solve, None);
    Ok(())
}

/// faer's supernodal factor of a matrix in the order that it has.
fn faers_own(matrix: &LowerTriangle) -> Outcome<(f64, ())> {
    let n = matrix.columns.len() - 1;
    let lower = SymbolicSparseColMat::new_checked(n, n, matrix.columns.to_vec(), None, matrix.rows.to_vec());
    let params = CholeskySymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..Default::default()
    };
    let (columns, rows) = transposed(matrix);
    let upper = SymbolicSparseColMat::new_checked(n, n, columns, None, rows);
    let symbolic = factorize_symbolic_cholesky(upper.as_ref(), Side::Upper, SymmetricOrdering::Identity, params)
        .map_err(|fault| fault.to_string())?;
    let mut values = vec![0.0; symbolic.len_val()];
    let mut space = MemBuffer::new(symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()));
    timed(3, || {
        let a = SparseColMatRef::new(lower.as_ref(), matrix.values);
        let (set, stack) = (LltRegularization::default(), MemStack::new(&mut space));
        let factorisation =
            symbolic.factorize_numeric_llt(&mut values, a, Side::Lower, set, Par::Seq, stack, Default::default());
        factorisation.map(|_| ()).map_err(|fault| format!("{fault:?}").into())
    })
}

fn transposed(matrix: &LowerTriangle) -> (Vec<u32>, Vec<u32>) {
    let n = matrix.columns.len() - 1;
    let mut by_row = vec![Vec::new(); n];
    for column in 0..n {
        for &row in &matrix.rows[matrix.columns[column] as usize..matrix.columns[column + 1] as usize] {
            by_row[row as usize].push(column as u32);
        }
    }
    let mut starts = vec![0u32];
    by_row.iter().for_each(|row| starts.push(starts[starts.len() - 1] + row.len() as u32));
    (starts, by_row.concat())
}
