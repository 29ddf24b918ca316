//! Which rows and columns of a fault's way into a residual are inverted.

use faer::{Mat, c64, prelude::Solve};
use fd_model::{ModelError, StateSpace, TimeDomain};
use fd_numeric::dense::Dense;

use super::stable::slower;
use crate::{
    error::DesignError,
    matrix::spread_rows,
    optimal::{Regular, regular},
};

/// Relative singular values below this count as zero.
const RANK: f64 = 1e-9;

/// Most sets of rows that are tried.
const MOST: usize = 200;

/// A square part of a system, made regular at infinity, and its inverse.
pub(super) struct Inverted<D> {
    /// Combinations of the rows (rank × rows).
    pub rows: Mat<f64>,
    /// The columns.
    pub columns: Vec<usize>,
    /// Filters in front of the inverse; a common lag `(a/(s + a))ᵏ`, or `z⁻ᵏ`, is in them.
    pub filters: Vec<StateSpace<D>>,
    pub inverse: StateSpace<D>,
}

/// The part with the fewest zeros slower than `rate`, and then at infinity: what the update has to carry. `None` when the
/// system is zero.
pub(super) fn inverted<D: TimeDomain>(
    system: &StateSpace<D>,
    rate: f64,
    corner: f64,
) -> Result<Option<Inverted<D>>, DesignError> {
    let response = somewhere(system)?;
    let columns = independent_columns(&response);
    if columns.is_empty() {
        return Ok(None);
    }
    let all: Vec<_> = (0..system.ny()).collect();
    let tall = system.select(&all, &columns)?;
    let mut best: Option<((usize, usize), Inverted<D>)> = None;
    for rows in candidates(system.ny(), columns.len()) {
        let combined = tall.series(&StateSpace::gain(rows.clone(), tall.domain())?)?;
        let Ok(Regular { system: square, filters }) = regular(&combined, corner) else { continue };
        let Ok(zeros) = combined.minimal(1e-10)?.zeros() else { continue };
        let at_infinity: usize = filters.iter().map(|filter| filter.ny() - filter.nx()).sum();
        let cost = (slower(&zeros, tall.domain(), rate)?, at_infinity);
        if best.as_ref().is_some_and(|(least, _)| *least <= cost) {
            continue;
        }
        let Ok(inverse) = inverse_of(&square) else { continue };
        let columns = columns.clone();
        best = Some((cost, Inverted { rows, columns, filters, inverse }));
        if cost == (0, 0) {
            break;
        }
    }
    match best {
        Some((_, found)) => Ok(Some(found)),
        None => {
            Err(ModelError::Singular { role: "the way of the faults into the residual" }.into())
        }
    }
}

/// The response at a point that is no pole or zero but by bad luck, with rows of unit size.
fn somewhere<D: TimeDomain>(system: &StateSpace<D>) -> Result<Mat<c64>, DesignError> {
    let domain = system.domain();
    let speed = system.a().norm_l2().max(1e-3);
    let highest = domain.highest_frequency();
    let point = if highest.is_finite() {
        c64::new(1.37, 0.41)
    } else {
        c64::new(0.59 * speed, 0.83 * speed)
    };
    let mut response = system.transfer_at(point)?;
    for i in 0..response.nrows() {
        let size = response.row(i).norm_l2();
        if 0.0 < size {
            (0..response.ncols()).for_each(|j| response[(i, j)] /= size);
        }
    }
    Ok(response)
}

/// Columns that are independent, by orthogonalising them one after another, the largest rest first.
fn independent_columns(response: &Mat<c64>) -> Vec<usize> {
    let mut rest = response.clone();
    let size: Vec<f64> = (0..rest.ncols()).map(|j| rest.col(j).norm_l2()).collect();
    let mut chosen = Vec::new();
    while chosen.len() < rest.nrows().min(rest.ncols()) {
        let left = (0..rest.ncols())
            .filter(|j| !chosen.contains(j) && 0.0 < size[*j])
            .map(|j| (j, rest.col(j).norm_l2() / size[j]));
        let Some((pivot, share)) = left.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        if share <= RANK {
            break;
        }
        let unit = rest.col(pivot).to_owned();
        let norm = unit.norm_l2();
        for j in 0..rest.ncols() {
            let along: c64 = (0..rest.nrows()).map(|i| unit[i].conj() * rest[(i, j)]).sum();
            for i in 0..rest.nrows() {
                rest[(i, j)] -= unit[i] * (along / (norm * norm));
            }
        }
        chosen.push(pivot);
    }
    chosen.sort_unstable();
    chosen
}

/// Sets of rows alone, then a few mixtures of all.
fn candidates(rows: usize, rank: usize) -> Vec<Mat<f64>> {
    let mut sets: Vec<Vec<usize>> = vec![Vec::new()];
    for row in 0..rows {
        let longer: Vec<_> = sets
            .iter()
            .filter(|set| set.len() < rank)
            .map(|set| [set.as_slice(), &[row]].concat())
            .collect();
        sets.extend(longer);
        sets.truncate(MOST * rank.max(1));
    }
    let picked = sets.into_iter().filter(|set| set.len() == rank).take(MOST);
    let picked =
        picked.map(|set| Mat::from_fn(rank, rows, |i, j| if set[i] == j { 1.0 } else { 0.0 }));
    let mixed: Vec<Mat<f64>> =
        if rank < rows { spread_rows(rows).into_iter().skip(rows).collect() } else { Vec::new() };
    let groups = mixed
        .chunks_exact(rank.max(1))
        .map(|group| Mat::from_fn(rank, rows, |i, j| group[i][(0, j)]));
    let groups: Vec<_> = groups.collect();
    picked.chain(groups).collect()
}

/// `(A − B D⁻¹ C, B D⁻¹, −D⁻¹ C, D⁻¹)`
fn inverse_of<D: TimeDomain>(g: &StateSpace<D>) -> Result<StateSpace<D>, DesignError> {
    let (a, b, c, d) = (g.a(), g.b(), g.c(), g.d());
    let lu = d.lu();
    let (through, back) = (lu.solve(c), lu.solve(Mat::<f64>::identity(d.nrows(), d.nrows())));
    Ok(StateSpace::new(a - b * &through, b * &back, -through, back, g.domain())?)
}
