//! Every filter, for tests that must see them all.
//!
//! Only with the feature `testing`. A test of a law walks this list and keeps none of its own, so what is
//! added to it is put to every law.

use fd_core::{stage::ResidualGenerator, testing::Named};

use crate::{
    NoisyModel, NonlinearError, extended::ExtendedDesign, particle::ParticleDesign,
    unscented::UnscentedDesign,
};

/// Every filter of this crate for `model`, at its start.
///
/// # Errors
///
/// Returns why one of them cannot be made for this model.
pub fn every_filter(
    model: &NoisyModel,
) -> Result<Vec<Named<dyn ResidualGenerator>>, NonlinearError> {
    Ok(vec![
        ("extended", Box::new(ExtendedDesign::new(model.clone()).freeze())),
        (
            "extended, slopes in turns",
            Box::new(ExtendedDesign::new(model.clone()).linearised_over(4).freeze()),
        ),
        ("unscented", Box::new(UnscentedDesign::new(model.clone(), None)?.freeze())),
        ("particle", Box::new(ParticleDesign::new(model.clone(), 60, 5)?.freeze())),
    ])
}
