//! A plant of one's own in the comparison: a model file that watches, a plant file that stands for reality, signals
//! that drive it, and faults.
//!
//! Both files are [equations](fd_sim::model), so that loops, disturbances and faults are written where they act. What is
//! unknown enters the plant as further inputs: a disturbance with a [signal](fd_model::signal), a fault with its size from
//! its start on and zero before. The channels of the model are found by name among the inputs and outputs of the plant.
//! Each plant has its parameters anywhere within their tolerances.
//!
//! Not for plants whose structure changes at random: parameters are all that differs from one to the next.

mod config;
mod error;
mod linear;
mod plants;

pub(crate) use self::plants::OwnPlants;
pub use self::{
    config::{OwnFault, OwnPlant},
    error::OwnError,
};
