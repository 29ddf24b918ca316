//! Where a gap lies: output, side and equation, frequency, operating region, time.
//!
//! | question | answer |
//! |---|---|
//! | which output? | gap of each against its noise floor |
//! | which side, which equation? | probabilities of the causes there; and the share of the gap that a *free* signal there would explain, whatever its law |
//! | which frequencies? | power per band against the floor, coherence with the inputs |
//! | which region? | correlation ratio of what is missing with inputs, states, outputs, directions |
//! | when? | the gap over time, and the stretch in which it differs |
//!
//! Claims hold at a stated rate: on a log without a gap, any claim about bands is made in at most
//! 5 % of the cases, any about regions in 5 %, and any about times in 5 %.
//!
//! *When not to use:* a free signal is linearised about the refitted model; where the gap is so
//! large that the refitted model runs through another region than the plant, its share is a hint.

pub(crate) mod bench;
pub(crate) mod channels;
mod columns;
mod empirical_bayes;
mod free_signal;
pub(crate) mod places;
mod regions;
mod result;
mod spectrum;
mod times;

pub use self::result::{
    Band, Bin, Change, ChannelGap, FreeSignal, Location, PlaceEvidence, Region, RegionOf, RegionOn,
    SideEvidence, Size, Spectrum, Stretch, TimeCourse,
};
use self::{
    bench::{Bench, settled},
    free_signal::Probe,
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
pub fn locate(case: &Case<'_>, diagnosis: &Diagnosis) -> Result<Location, FitError> {
    let bench = Bench::new(case, diagnosis)?;
    let before = bench.residuals(&diagnosis.refit.outputs);
    let after = bench.residuals(&diagnosis.best.outputs);
    let probe = Probe::new(case, diagnosis, &bench, &before);
    let model = case.nominal.model();
    let places = places::places(model, diagnosis, &probe);
    let mut refit = case.nominal.patched(&diagnosis.refit.model, bench.simulator.ts())?;
    let theta = settled(&*refit);
    let run = bench.run(&mut *refit, &theta, &diagnosis.refit.starts, &Vec::new());
    let (outputs, states) = run.ok_or(FitError::Diverged)?;
    Ok(Location {
        channels: channels::channels(&bench, diagnosis),
        sides: places::sides(diagnosis, &places),
        spectra: spectrum::spectra(&bench, diagnosis, &before, &after),
        regions: regions::regions(&bench, model, &places, (&outputs, &states), &before),
        times: times::times(&bench, diagnosis, &before, &after),
        places,
    })
}
