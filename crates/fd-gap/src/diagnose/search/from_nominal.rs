//! Fits that begin at the nominal parameters.
//!
//! Where a large effect is missing, the fit without it bends parameters up to the edges of what is known of them, to make up
//! for it. From there a fit of the effect may not find back: the effect is small there, and the parameters have to
//! move far and together. From the nominal parameters it is the effect that has to move.

use super::trial::Trial;
use crate::fit::{NullFit, Search, Variable, minimise};

/// Part of the way to the edge of its box from which on a parameter makes up for something.
const BENT: f64 = 0.95;
/// Most parameters of an effect: curves and paths follow anything from anywhere.
const FEW: usize = 3;
/// Sizes that are looked at, in typical ones.
const SIZES: [f64; 10] = [-8.0, -4.0, -2.0, -1.0, -0.5, 0.5, 1.0, 2.0, 4.0, 8.0];
/// A fit from the best of them, with all slopes.
const SEARCH: Search =
    Search { iterations: 8, absolute: 0.1, relative: 1e-4, frozen: 0, ..Search::PLAIN };

impl Trial<'_> {
    /// A fit from the nominal parameters and the size that is best there, where the fit without the effect is bent.
    pub(super) fn fit_from_nominal(&mut self, null: &NullFit) {
        let plan = null.problem.plan();
        let variables: Vec<&Variable> =
            plan.nuisances().iter().chain(plan.own_variables()).collect();
        let is_few = self.candidate.parameters.len() <= FEW;
        if !is_few || self.problem.is_dear() || !is_bent(&variables, &null.minimum.z) {
            return;
        }
        // What has no nominal value stays, as an effect does that is there already.
        let known = variables.iter().zip(&null.minimum.z);
        let nominal: Vec<f64> =
            known.map(|(v, z)| if v.prior.is_some() { 0.0 } else { *z }).collect();
        let Some(start) = self.scored.first().map(|start| start.values.clone()) else { return };
        let within = |values: &Vec<f64>| {
            let known = self.candidate.parameters.iter().zip(values);
            known.clone().all(|(p, value)| (p.low..=p.high).contains(value))
        };
        let sizes = SIZES.iter().map(|size| self.scaled(&start, *size)).filter(within);
        let places: Vec<Vec<f64>> =
            sizes.map(|values| self.problem.place(&nominal, &values)).collect();
        let absent = self.problem.place(&nominal, &self.neutral());
        let squares = |r: &Vec<f64>| r.iter().map(|r| r * r).sum::<f64>();
        let found = self.problem.residuals_beside([&absent, &[]], &places);
        let costs =
            found.iter().zip(&places).filter_map(|(r, place)| Some((squares(r.as_ref()?), place)));
        let best = costs.min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, place)) = best else { return };
        let minimum = minimise(&mut self.problem, place, None, SEARCH);
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
