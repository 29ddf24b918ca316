//! Stiffness that the model lacks.

use fd_sim::{model::Model, scales::ReplayScales};

use super::sites::each_site;
use crate::{Effect, Offers};

/// A spring `k x`: also a leak that grows with a level.
#[derive(Clone, Copy, Debug)]
pub struct LinearStiffness;

/// A spring that stiffens or, with a negative strength, softens: `k x³`, `k x⁵`, or `k x³ + b x²`,
/// different in the two directions.
#[derive(Clone, Copy, Debug)]
pub struct Stiffening;

impl Effect for LinearStiffness {
    fn label(&self) -> &'static str {
        "linear-stiffness"
    }

    fn family(&self) -> &'static str {
        "stiffness"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_site(self, nominal, scales, |sketch, at| {
            let scale = at.force() / at.position();
            vec![
                sketch("linear")
                    .with_position(at)
                    .strength("k", "stiffness", at.per_position(1), scale, [-1.0, 4.0])
                    .resist("spring", "k*x")
                    .starts([[0.05], [0.4]]),
            ]
        })
    }
}

impl Effect for Stiffening {
    fn label(&self) -> &'static str {
        "stiffening"
    }

    fn family(&self) -> &'static str {
        "stiffness"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_site(self, nominal, scales, |sketch, at| {
            let scale = |power| at.force() / at.position().powi(power);
            let unit = |power| at.per_position(power);
            let spring = |law| sketch(law).with_position(at);
            let cubic = |law| spring(law).strength("k", "cubic", unit(3), scale(3), [-1.0, 4.0]);
            vec![
                cubic("cubic").resist("spring", "k*x^3").starts([[0.05], [0.4]]),
                spring("quintic")
                    .strength("k", "quintic", unit(5), scale(5), [-1.0, 4.0])
                    .resist("spring", "k*x^5")
                    .starts([[0.02], [0.15]]),
                cubic("asymmetric")
                    .strength("b", "quadratic", unit(2), scale(2), [-4.0, 4.0])
                    .resist("spring", "k*x^3 + b*x^2")
                    .starts([[0.05, 0.1], [0.05, -0.1]]),
            ]
        })
    }
}
