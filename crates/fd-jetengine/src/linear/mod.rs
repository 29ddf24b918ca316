//! Published linear engines, in the common form [`EngineModel`](crate::EngineModel).
//!
//! They show that nothing is tuned to our own plant: the same pipeline runs on any of them.

mod chen_patton_zhang;
mod f100;
mod f100_matrices;

use faer::Mat;

pub use self::{
    chen_patton_zhang::{ChenPattonZhang, chen_patton_zhang},
    f100::f100,
};

/// A printed matrix at design time.
fn matrix<const R: usize, const C: usize>(rows: &[[f64; C]; R]) -> Mat<f64> {
    Mat::from_fn(R, C, |i, j| rows[i][j])
}
