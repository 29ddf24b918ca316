//! Fits that begin at the nominal parameters.
//!
//! Where a large effect is missing, the fit without it bends parameters up to the edges of what is known of them, to make up
//! for it. From there a fit of the effect may not find back: the effect is small there, and the parameters have to
//! move far and together. From the nominal parameters it is the effect that has to move.

use fd_numeric::wide::dot;

use super::trial::Trial;
use crate::fit::{NullFit, Search, Variable, minimise};

/// Part of the way to the edge of its box from which on a parameter makes up for something.
const BENT: f64 = 0.95;
/// Most parameters of an effect: curves and paths follow anything from anywhere.
const FEW: usize = 3;
/// A fit from there, with all slopes.
const SEARCH: Search =
    Search { iterations: 8, absolute: 0.1, relative: 1e-4, frozen: 0, ..Search::PLAIN };

/// The unknowns of the fit without any effect at their nominal values, if it is bent. What has no nominal value stays, as an
/// effect does that is there already.
pub(super) fn nominal_where_bent(null: &NullFit) -> Option<Vec<f64>> {
    let plan = null.problem.plan();
    let variables: Vec<&Variable> = plan.nuisances().iter().chain(plan.own_variables()).collect();
    let z = &null.minimum.z;
    if null.problem.is_dear() || !is_bent(&variables, z) {
        return None;
    }
    let known = variables.iter().zip(z);
    Some(known.map(|(v, z)| if v.prior.is_some() { 0.0 } else { *z }).collect())
}

impl Trial<'_> {
    /// A fit from the nominal parameters and the amplitude that leaves least there.
    pub(super) fn fit_from_nominal(&mut self, nominal: &[f64]) {
        let Some(start) = self.scored.first().map(|start| start.values.clone()) else { return };
        if FEW < self.candidate.parameters.len() {
            return;
        }
        let places = [&self.neutral(), &start].map(|values| self.problem.place(nominal, values));
        let found = self.problem.residuals_beside([&[], &[]], &places);
        let [Some(left), Some(changed)] = &found[..] else { return };
        let change: Vec<f64> = changed.iter().zip(left).map(|(r, left)| r - left).collect();
        let size = dot(&change, &change);
        if size <= 0.0 {
            return;
        }
        let [low, high] = self.amplitudes(&start);
        let amplitude = (-dot(&change, left) / size).clamp(low, high);
        let place = self.problem.place(nominal, &self.begun(&start, amplitude));
        let minimum = minimise(&mut self.problem, &place, None, SEARCH);
        self.keep(minimum);
    }
}

/// Whether a parameter that is known is at the edge of that.
fn is_bent(variables: &[&Variable], z: &[f64]) -> bool {
    variables.iter().zip(z).filter(|(variable, _)| variable.prior.is_some()).any(|(variable, z)| {
        let [low, high] = variable.range();
        *z < BENT * low || BENT * high < *z
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_at_either_edge_is_bent() {
        let mass = Variable::known("m", "kg", 2.0, 0.03);
        let [low, high] = mass.range();
        let is_bent = |z: f64| super::is_bent(&[&mass], &[z]);
        assert!(is_bent(low) && is_bent(high) && is_bent(0.96 * high));
        assert!(!is_bent(0.0) && !is_bent(0.9 * low));
        let effect = Variable { prior: None, ..mass.clone() };
        assert!(!super::is_bent(&[&effect], &[high]));
    }
}
