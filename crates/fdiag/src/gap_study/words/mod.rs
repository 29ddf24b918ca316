//! Effects, places, findings and numbers as people say them: what a typed result does not say itself.

mod answer;
mod defects;
mod further;
mod labels;
mod missed;
mod next_steps;
mod numbers;
mod objection;
mod regions;
mod sized_outputs;
mod slow_noise;
mod steps;
mod units;

pub use self::{
    answer::{
        cause, effect, effect_at, estimate, estimate_of, group, pair, side, strength, with_strength,
    },
    defects::{defect, time_policy},
    further::{advice, answers, rivals, truths},
    labels::{at, capital, family, label, list, site, standing},
    numbers::{formula, four, p, percent, probability, share, with_error, with_unit},
    objection::objection,
    regions::{region_of, region_on},
    units::shown,
};
pub(super) use self::{
    missed::missed, next_steps::next_steps, slow_noise::slow_noise, steps::steps,
};
