//! Every stage works through `Box<S>`, also when `S` is a `dyn` stage.
//!
//! There is deliberately no impl for `&mut S`: it would shadow the impl for `S` whenever a stage
//! is held as a local `&mut S`, and turn borrowed estimates into borrows of that local.

use crate::{
    dims::IoDims,
    frame::Frame,
    scalar::Scalar,
    stage::{
        BiasModel, Compensation, Compensator, Decision, DecisionRule, Detector, Evidence,
        GuardReport, Identifier, Plant, ResidualGenerator, Stage, Verdict,
    },
    visitor::StateVisitor,
};

macro_rules! forward {
    ($stage:ident $body:tt) => {
        impl<T: Scalar, S: $stage<T> + ?Sized> $stage<T> for Box<S> $body
    };
}

forward! { Plant {
    fn nx(&self) -> usize { (**self).nx() }
    fn io(&self) -> IoDims { (**self).io() }
    fn advance(&self, x: &[T], u: &[T], x_next: &mut [T]) { (**self).advance(x, u, x_next); }
    fn output(&self, x: &[T], u: &[T], y: &mut [T]) { (**self).output(x, u, y); }
}}

forward! { Stage {
    fn reset(&mut self) { (**self).reset(); }
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) { (**self).visit_state(visitor); }
}}

forward! { ResidualGenerator {
    fn io(&self) -> IoDims { (**self).io() }
    fn residual_len(&self) -> usize { (**self).residual_len() }
    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) { (**self).step(frame, r); }
}}

forward! { Identifier {
    fn nu(&self) -> usize { (**self).nu() }
    fn residual_len(&self) -> usize { (**self).residual_len() }
    fn update(&mut self, u: &[T], mu: &[T]) { (**self).update(u, mu); }
    fn theta(&self) -> &[T] { (**self).theta() }
    fn variance_into(&self, variance: &mut [T]) { (**self).variance_into(variance); }
    fn guard(&self) -> GuardReport { (**self).guard() }
    fn retrain(&mut self, theta: &[T]) -> bool { (**self).retrain(theta) }
}}

forward! { BiasModel {
    fn nu(&self) -> usize { (**self).nu() }
    fn residual_len(&self) -> usize { (**self).residual_len() }
    fn theta_len(&self) -> usize { (**self).theta_len() }
    fn load(&mut self, theta: &[T]) { (**self).load(theta); }
    fn observe(&mut self, u: &[T], mu: &[T]) { (**self).observe(u, mu); }
    fn simulate(&mut self, u: &[T], mu_hat: &mut [T]) { (**self).simulate(u, mu_hat); }
    fn predict(&mut self, u: &[T], r: &[T], mu_hat: &mut [T]) { (**self).predict(u, r, mu_hat); }
}}

forward! { Compensator {
    fn nu(&self) -> Option<usize> { (**self).nu() }
    fn residual_len(&self) -> usize { (**self).residual_len() }
    fn step(&mut self, frame: Frame<'_, T>, r: &[T], r_star: &mut [T]) -> Compensation {
        (**self).step(frame, r, r_star)
    }
    fn retrain(&mut self) -> bool { (**self).retrain() }
}}

forward! { Detector {
    fn nu(&self) -> Option<usize> { (**self).nu() }
    fn residual_len(&self) -> usize { (**self).residual_len() }
    fn update(&mut self, u: &[T], r: &[T]) -> Verdict<T> { (**self).update(u, r) }
    fn is_void(&self) -> bool { (**self).is_void() }
}}

forward! { DecisionRule {
    fn residual_len(&self) -> usize { (**self).residual_len() }
    fn decide(&mut self, evidence: Evidence<'_, T>) -> Decision<T> { (**self).decide(evidence) }
}}
