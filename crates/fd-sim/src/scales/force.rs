//! Size of what a force moves.

use super::signal::SignalScale;
use crate::{
    equation::{Expr, Unary},
    model::{Definition, Law, Model, Site},
};

/// Size of what a force moves.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceScale {
    /// Name of the site.
    pub name: String,
    /// Unit of the force.
    pub unit: String,
    /// The force that makes the accelerations of the replay, or the largest of those that they are the sum of, as of a spring
    /// that a cylinder pushes slowly: the standard deviation divided by `|mobility|`. Zero when nothing moves.
    pub force: f64,
    /// Mean acceleration per force, with its sign: negative where a positive force works against
    /// what is called the velocity.
    pub mobility: f64,
    /// Largest change of the velocity by a force of 1 in one integration step.
    pub kick: f64,
    /// Whether the force acts at the end of an integration step (states with update laws) instead
    /// of during it.
    pub is_discrete: bool,
    /// Acceleration of the replay.
    pub motion: SignalScale,
    /// Acceleration of the nominal model, an expression of its names; a rate where the site has no
    /// velocity, and a number where no equation of motion is known.
    pub acceleration: Expr,
    /// Acceleration per force, an expression.
    pub compliance: Expr,
    /// Definitions that the model does not have and that both need: slopes of its own definitions,
    /// where those are too long to be written out. Few models need any.
    pub helpers: Vec<Definition>,
    /// The velocity on which the force works: that of the site, or the state it enters where the
    /// site has neither velocity nor position (a current, which a voltage drives).
    pub velocity: Option<(Expr, SignalScale)>,
    /// The displacement on which the force works.
    pub position: Option<(Expr, SignalScale)>,
}

/// Whether a force at the site acts at the end of an integration step instead of during it.
pub(super) fn is_discrete(model: &Model, site: &Site) -> bool {
    let entered = |name: &str| site.enters.iter().any(|(state, _)| state == name);
    model.states.iter().any(|s| entered(&s.name) && matches!(s.law, Law::Update(_)))
}

impl ForceScale {
    /// Whether the nominal model says what moves the site; a black box does not.
    #[must_use]
    pub fn has_equation(&self) -> bool {
        !matches!(self.acceleration, Expr::Number(_))
    }

    /// The kick by which a law that pushes back like a spring bounds its stiffness: twice as large where a simulator outside
    /// holds the force over its step, since it must not turn the motion round.
    #[must_use]
    pub fn held_kick(&self) -> f64 {
        if self.has_equation() { self.kick } else { 2.0 * self.kick }
    }

    /// What fills or moves at the site: the position, else the velocity, which is the state that is entered where
    /// the site names neither.
    #[must_use]
    pub fn level(&self) -> Option<&(Expr, SignalScale)> {
        self.position.as_ref().or(self.velocity.as_ref())
    }

    /// `force` with the sign that makes it work against a motion or displacement to which it is
    /// positive.
    #[must_use]
    pub fn against(&self, force: Expr) -> Expr {
        if self.mobility < 0.0 { force } else { Expr::unary(Unary::Neg, force) }
    }
}
