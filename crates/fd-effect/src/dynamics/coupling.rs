//! Coupling between states.

use fd_sim::{equation::Expr, model::Model, scales::ReplayScales};

use crate::{Effect, Offers, Reason, SiteRef, Sketch, units::per};

/// A force `c (b - mean)` that comes from a state `b` which is neither velocity nor position of the
/// site; the mean is that of the nominal model.
#[derive(Clone, Copy, Debug)]
pub struct StateCoupling;

impl Effect for StateCoupling {
    fn label(&self) -> &'static str {
        "state-coupling"
    }

    fn family(&self) -> &'static str {
        "coupling"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let mut offers = Vec::new();
        for (i, site) in scales.sites.iter().enumerate() {
            let sketch = || Sketch::of_force(self, "linear", nominal, scales, i);
            let own = |name: &str| {
                let signals = [&site.velocity, &site.position].into_iter().flatten();
                signals.into_iter().any(|(expr, _)| expr.mentions(name))
            };
            let others: Vec<usize> =
                (0..scales.states.len()).filter(|j| !own(&scales.states[*j].name)).collect();
            if others.is_empty() {
                offers.push(sketch().require(false, Reason::Alone("state")).finish());
            }
            for j in others {
                let state = &scales.states[j];
                let scale = site.force / state.std;
                let unit = per(&site.unit, &state.unit);
                let sketch = sketch()
                    .require(site.force > 0.0, Reason::Still("what the force would move"))
                    .require(state.moves(), Reason::Still("the other state"))
                    .partner(SiteRef::State(j, state.name.clone()))
                    .bind("b", Expr::name(&state.name))
                    .bind("B", state.mean)
                    .strength("c", &format!("from_{}", state.name), unit, scale, [-3.0, 3.0])
                    .force(&format!("pull_of_{}", state.name), "c*(b - B)")
                    .starts([[0.1]]);
                offers.push(sketch.finish());
            }
        }
        offers
    }
}
