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
//! *When not to use:* a free signal is linearised about the refitted model; where the gap is so large that the
//! refitted model runs through a different region than the plant, its share is only a hint.

pub(crate) mod bench;
pub(crate) mod channels;
mod columns;
mod empirical_bayes;
mod free_signal;
mod motion;
pub(crate) mod places;
mod regions;
mod result;
mod spectrum;
mod times;

pub use self::result::{
    Band, Bin, Change, ChannelGap, FreeSignal, Location, PlaceEvidence, Region, RegionOf, RegionOn,
    SideEvidence, Size, Spectrum, Stretch, TimeCourse,
};
use self::{bench::Bench, free_signal::Probe, motion::motion};
use crate::{
    diagnose::{Case, Diagnosis, Monitor},
    fit::FitError,
};

/// Says where the gap lies that a diagnosis has found. The monitor sees [`Stage::Locate`](crate::diagnose::Stage), with a piece
/// per place.
///
/// ```
/// use fd_effect::Candidate;
/// use fd_gap::{diagnose::{Case, Settings, diagnose}, locate::locate};
/// use fd_sim::model::Model;
/// # use fd_model::{Channel, Record};
/// # let model: Model = r#"
/// # version = 1
/// # kind = "equations"
/// # name = "lag"
/// # sample_time = 0.1
/// # inputs = { u = { unit = "V" } }
/// # outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
/// # parameters = { T = { unit = "s", value = 1.0 } }
/// # states = { x = { unit = "V", initial = 0.0, derivative = "(u - x)/T" } }
/// # "#.parse()?;
/// # let (u, y) = ([Channel::new("u", "V")], [Channel::new("y", "V")]);
/// # let noise = |k: u32| 0.01 * f64::from(k * 7919 % 13).sin();
/// # let x = |k: u32| 1.0 - (-0.1 * f64::from(k)).exp();
/// # let rows = (0..100).map(|k| ([1.0], [x(k) + noise(k)]));
/// # let log = Record::from_rows(u.to_vec(), y.to_vec(), rows, model.sample_time()?)?;
/// let (logs, held_out) = ([log.clone()], [log]);
/// let suspects: Vec<Candidate> = Vec::new();
/// let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
/// let settings = Settings::default();
/// let diagnosis = diagnose(&case, &settings, &())?;
/// let location = locate(&case, &diagnosis, &())?;
/// assert!(location.channels[0].statement.starts_with("y: no gap"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or does not fit the logs of the case.
pub fn locate(
    case: &Case<'_>,
    diagnosis: &Diagnosis,
    monitor: &dyn Monitor,
) -> Result<Location, FitError> {
    let bench = Bench::new(case, diagnosis)?;
    let before = bench.residuals(&diagnosis.refit.outputs);
    let after = bench.residuals(&diagnosis.best.outputs);
    let probe = Probe::new(case, diagnosis, &bench, &before);
    let model = case.nominal.model();
    let places = places::places(model, diagnosis, &probe, monitor);
    let motion = motion(case, diagnosis, &bench)?;
    Ok(Location {
        channels: channels::channels(&bench, diagnosis),
        sides: places::sides(diagnosis, &places),
        spectra: spectrum::spectra(&bench, diagnosis, &before, &after),
        regions: regions::regions(&bench, &motion, &places, &before),
        times: times::times(&bench, diagnosis, &before, &after),
        places,
    })
}
