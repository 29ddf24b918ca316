//! Where a gap lies: output, side and equation, frequency, operating region, time.

mod result;

pub use self::result::{
    Band, Bin, Change, ChannelGap, FreeSignal, Location, PlaceEvidence, Region, RegionOf, RegionOn,
    SideEvidence, Size, Spectrum, Stretch, TimeCourse,
};
use crate::{
    diagnose::{Case, Diagnosis},
    fit::FitError,
};

/// Says where the gap lies that a diagnosis has found.
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or does not fit the logs of the case.
pub fn locate(_case: &Case<'_>, _diagnosis: &Diagnosis) -> Result<Location, FitError> {
    Ok(Location {
        channels: vec![],
        sides: vec![],
        places: vec![],
        spectra: vec![],
        regions: vec![],
        times: vec![],
    })
}
