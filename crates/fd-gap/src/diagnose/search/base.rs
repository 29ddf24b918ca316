//! Where the slopes are taken that say what a candidate could explain, and from where it is fitted.
//!
//! Where a large effect is missing, the fit without it bends parameters up to the edges of what is known of them, to make up
//! for it. From there a fit of the effect may not find back: the effect is small there, and the parameters have to
//! move far and together. From the nominal parameters it is the effect that has to move.

use crate::fit::{Minimum, NullFit, Search, Surroundings, Variable, minimise};

/// Part of the way to the edge of its box from which on a parameter makes up for something.
const BENT: f64 = 0.95;

/// The fit without any effect, or where that is bent the nominal parameters; what has none stays, as an effect does that is
/// there already. Errors of angles go on beyond half a turn.
pub(super) fn base(null: &NullFit) -> Minimum {
    let plan = null.problem.plan();
    let variables: Vec<&Variable> = plan.nuisances().iter().chain(plan.own_variables()).collect();
    let mut place = null.minimum.z.clone();
    let is_bent = is_bent(&variables, &place);
    if null.problem.is_dear() || !is_bent && !null.problem.has_circles() {
        return null.minimum.clone();
    }
    if is_bent {
        let known = place.iter_mut().zip(variables).filter(|(_, v)| v.prior.is_some());
        known.for_each(|(z, _)| *z = 0.0);
    }
    let mut problem = null.problem.clone();
    problem.go_on(true);
    let there = minimise(&mut problem, &place, None, Search::LOOK);
    there.map_or_else(|| null.minimum.clone(), |there| there.shared(&problem))
}

/// Whether slopes are those of the fit without any effect. At the nominal parameters, which are further up, they say little of what
/// a bent fit lacks.
pub(super) fn is_of_the_fit(around: &Surroundings<'_>, null: &NullFit) -> bool {
    around.at().cost <= null.minimum.cost
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
