//! Residuals of many places and slopes by differences, simulated side by side.

use std::ops::Range;

use super::{
    super::layout::{Layout, LeastSquares, Linearization},
    By, Problem,
};

/// Step of a forward difference in a nuisance, in scales. Rounding errors of a simulation are
/// below 1e-12 of its values, and a nuisance moves outputs by up to 1e3 sigma per scale.
const NUISANCE_STEP: f64 = 1e-5;
/// Step of a forward difference in a parameter of an effect, in scales: such laws have kinks.
const EFFECT_STEP: f64 = 1e-4;
/// Where outputs are rounded to `p`, a step is at least this many times `√p`.
const OF_ROOT: f64 = 10.0;
/// … but not more than a scale: beyond that a difference is no slope, however rough the outputs.
const LARGEST_STEP: f64 = 1.0;
/// Outputs that are no rougher are as smooth as those of equations.
const SMOOTH: f64 = 1e-12;

impl Problem {
    /// The step of a difference: forward, unless that leaves the box.
    fn step(&self, by: By, z: &[f64], column: usize) -> f64 {
        let is_effect = (self.plan.shared.len()..self.layout.shared).contains(&column);
        let size = if is_effect { EFFECT_STEP } else { NUISANCE_STEP };
        let stand_in = self.stand_in.as_ref().filter(|_| by == By::StandIn || self.is_stood_in);
        let precision = stand_in.unwrap_or(&self.simulator).precision();
        let rough = (OF_ROOT * precision.sqrt()).min(LARGEST_STEP);
        let size = if precision < SMOOTH { size } else { size.max(rough) };
        let is_inside = |i: usize| z[i] + size <= self.bounds[i][1];
        if self.unknowns(column).all(is_inside) { size } else { -size }
    }

    /// The unknowns of a column: those of all segments at once, for an own unknown moves nothing
    /// but its own segment.
    fn unknowns(&self, column: usize) -> impl Iterator<Item = usize> + use<> {
        let Layout { shared, own, .. } = self.layout;
        let count = if column < shared { 1 } else { self.layout.segments.len() };
        (0..count).map(move |s| column + s * own)
    }

    /// Whether a column has anywhere to go: what is held in a box without width need not be simulated.
    fn can_move(&self, column: usize) -> bool {
        self.unknowns(column).any(|i| self.bounds[i][0] < self.bounds[i][1])
    }

    /// Residuals and slopes by differences.
    fn differences(
        &mut self,
        by: By,
        places: &[Vec<f64>],
        columns: Range<usize>,
    ) -> Vec<Option<Linearization>> {
        let moving: Vec<usize> = columns.clone().filter(|column| self.can_move(*column)).collect();
        let steps: Vec<Vec<f64>> =
            places.iter().map(|z| moving.iter().map(|c| self.step(by, z, *c)).collect()).collect();
        let mut batch = Vec::with_capacity(places.len() * (1 + moving.len()));
        for (z, steps) in places.iter().zip(&steps) {
            batch.push(z.clone());
            batch.extend(moving.iter().zip(steps).map(|(c, step)| self.moved(z, *c, *step)));
        }
        let mut found = self.compare(by, &batch).into_iter();
        let mut all = Vec::with_capacity(places.len());
        // Where the simulator does not like this direction, the other one is tried.
        let mut again: Vec<(usize, usize)> = Vec::new();
        for (p, steps) in steps.iter().enumerate() {
            let r = found.next().flatten();
            let trials: Vec<Option<Vec<f64>>> = found.by_ref().take(moving.len()).collect();
            all.push(r.map(|r| {
                let mut slopes = vec![vec![0.0; r.len()]; columns.len()];
                for (i, trial) in trials.into_iter().enumerate() {
                    match trial {
                        Some(trial) => {
                            slopes[moving[i] - columns.start] = self.slope(trial, &r, steps[i]);
                        }
                        None => again.push((p, i)),
                    }
                }
                Linearization { r, slopes }
            }));
        }
        let back = |(p, i): &(usize, usize)| self.moved(&places[*p], moving[*i], -steps[*p][*i]);
        let batch: Vec<Vec<f64>> = again.iter().map(back).collect();
        for ((p, i), trial) in again.into_iter().zip(self.compare(by, &batch)) {
            if let (Some(there), Some(trial)) = (&mut all[p], trial) {
                there.slopes[moving[i] - columns.start] = self.slope(trial, &there.r, -steps[p][i]);
            }
        }
        all
    }

    /// The slope from residuals to those that were found a step away.
    fn slope(&self, mut found: Vec<f64>, r: &[f64], step: f64) -> Vec<f64> {
        self.less(&mut found, r);
        for change in &mut found {
            *change /= step;
        }
        found
    }

    fn moved(&self, z: &[f64], column: usize, step: f64) -> Vec<f64> {
        let mut moved = z.to_vec();
        for i in self.unknowns(column) {
            moved[i] = z[i] + step;
        }
        moved
    }
}

impl LeastSquares for Problem {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn bounds(&self) -> &[[f64; 2]] {
        &self.bounds
    }

    fn prior(&self) -> &[[f64; 2]] {
        &self.prior
    }

    fn residuals(&mut self, z: &[f64], r: &mut [f64]) -> bool {
        let found = self.compare(By::Simulator, &[z.to_vec()]).pop().flatten();
        if let Some(found) = &found {
            r.copy_from_slice(found);
        }
        found.is_some()
    }

    fn slopes(&mut self, z: &[f64], _r: &[f64], columns: Range<usize>, slopes: &mut [Vec<f64>]) {
        let mut found = self.linearize(&[z.to_vec()], columns.clone());
        if let Some(there) = found.pop().flatten() {
            slopes[columns].iter_mut().zip(there.slopes).for_each(|(to, slope)| *to = slope);
        }
    }

    fn linearize(
        &mut self,
        places: &[Vec<f64>],
        columns: Range<usize>,
    ) -> Vec<Option<Linearization>> {
        if self.stand_in.is_none() {
            return self.differences(By::Simulator, places, columns);
        }
        let here = self.compare(By::Simulator, places);
        let mut stood_in = self.differences(By::StandIn, places, columns.clone());
        let first = self.plan.shared.len();
        for column in (first..self.layout.shared).filter(|column| columns.contains(column)) {
            if !self.effects.get(column - first).is_some_and(|effect| effect.is_native) {
                continue;
            }
            let seen = self.differences(By::Simulator, places, column..column + 1);
            for (there, seen) in stood_in.iter_mut().zip(seen) {
                if let (Some(there), Some(mut seen)) = (there, seen) {
                    there.slopes[column - columns.start] = seen.slopes.swap_remove(0);
                }
            }
        }
        let both = here.into_iter().zip(stood_in);
        both.map(|(r, there)| Some(Linearization { r: r?, slopes: there?.slopes })).collect()
    }
}
