//! Is the log good enough for the question?

mod autoregression;
mod noise_floor;

pub use self::{
    autoregression::Autoregression,
    noise_floor::{noise_floor, third_difference_floor},
};
