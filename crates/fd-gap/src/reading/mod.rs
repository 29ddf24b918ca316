//! Is the log read as it is meant? Signs, units, swapped columns, clocks, time, and signs and units of
//! parameters, as hypotheses that compete with every physical cause.
//!
//! # How it works
//!
//! 1. The log is diagnosed as it is read. Where there is no gap, that is all.
//! 2. Every mistake is looked at with everything at its nominal value: one simulation, or none where only
//!    outputs are concerned. Up to eight that do not look worse than the log as read get a fit of parameters and
//!    starts, all over the same horizon.
//! 3. The likelihood of the *logged numbers* is compared with that of the best physical explanation, with the
//!    noise of each column at its best value but not below what is stated or the grid of its values, and with as many
//!    samples as there are autocorrelation times. A mistake of each class has 1 % before the data, spread
//!    over its members; a cause pays for being one of many, for its parameters, and for a gain that no honest device has.
//!    An output on a coarse grid that is said to be biased by half a step downwards is suspected to be cut off instead
//!    of rounded, whatever else there is.
//! 4. What survives ([`suspect`]) is diagnosed once more, mended, and believed only if the mended log
//!    explains clearly more ([`Suspicion::judged`]).
//!
//! A factor has to be determined (half and twice of it explain clearly less), and the mended simulation has
//! to follow what was measured: a gain near zero explains nothing. What a delay explains as well stays a delay.
//!
//! *When not to use:* two mistakes at once are found only where one of them explains much alone.
//!
//! ```
//! use fd_effect::Candidate;
//! use fd_gap::{
//!     diagnose::{Case, Settings, diagnose},
//!     reading::{Mistake, suspect},
//! };
//! use fd_model::Record;
//! use fd_sim::model::Model;
//!
//! let model: Model = r#"
//! version = 1
//! kind = "equations"
//! name = "lag"
//! sample_time = 0.1
//! inputs = { u = { unit = "rad" } }
//! outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
//! states = { x = { unit = "V", initial = 0.0, derivative = "sin(u) - x" } }
//! "#.parse()?;
//! let ts = model.sample_time()?;
//! let (mut x, mut rows) = (0.0, Vec::new());
//! for k in 0..300_u32 {
//!     let u = (0.05 * f64::from(k)).sin() + 0.3;
//!     // Millivolts, and noise of ten of them.
//!     rows.push(([u], [1e3 * x + 14.1 * f64::from(k * k).sin()]));
//!     x = u.sin() + (-0.1_f64).exp() * (x - u.sin());
//! }
//! let log = Record::from_rows(model.external_inputs(), model.output_channels(), rows, ts)?;
//! let suspects: Vec<Candidate> = Vec::new();
//! let case = Case { nominal: &model, suspects: &suspects, logs: &[log], held_out: &[] };
//! let settings = Settings::default();
//! // No cause was tried on the log as it is read.
//! let suspicion = suspect(&case, settings.horizon, None)?.ok_or("a mistake")?;
//! assert_eq!(*suspicion.mistake(), Mistake::unit("y", 1e3));
//!
//! let logs = suspicion.mended(case.logs).ok_or("long enough")?;
//! let mended = Case { logs: &logs, ..case };
//! let diagnosis = diagnose(&mended, &settings, &())?;
//! let reading = suspicion.judged(&mended, &diagnosis).ok_or("a reading")?;
//! assert_eq!(reading.statement, "`y` were in mV, not V");
//! assert!(0.9 < reading.probability);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cut_off;
mod hypotheses;
mod misfit;
mod mistake;
mod nominal;
mod price;
mod result;
mod shortlist;
mod suspicion;
mod trial;
mod words;

pub use self::{
    mistake::Mistake,
    nominal::Mended,
    result::Reading,
    suspicion::{Suspicion, suspect},
};
