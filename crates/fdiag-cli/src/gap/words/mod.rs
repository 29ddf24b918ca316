//! Effects, places and numbers as people say them.

mod labels;
mod numbers;
mod units;

pub(super) use self::{
    labels::{at, family, label, list, site},
    numbers::{four, p, percent, probability, share, with_error},
    units::shown,
};
