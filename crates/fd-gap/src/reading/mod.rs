//! Is the log read as it is meant? Signs, units, swapped columns, clocks, time, and signs and units of
//! parameters, as hypotheses that compete with every physical cause.
//!
//! # How it works
//!
//! 1. The log is diagnosed as read. If there is no gap, nothing else happens. Where a mistake that no cause does leaves
//!    nothing but noise, and the log as read is far from it, that can be skipped ([`glance`](glance())).
//! 2. Every mistake is examined with everything else at its nominal value: one simulation, or none where only
//!    outputs are concerned. Up to eight that do not look worse than the log as read get a fit of parameters
//!    and initial states, all over the same horizon.
//! 3. The likelihood of the *logged numbers* is compared with that of the best physical explanation, with the
//!    noise of each column at its best value but not below what is stated or the grid of its values, and with
//!    as many samples as there are autocorrelation times. Each class of mistakes has a prior probability of 1
//!    %, spread over its members; a cause is penalised for being one of many, for its parameters, and for a
//!    gain that no real device has. An output on a coarse grid with an apparent bias of half a step downwards
//!    is always suspected to be truncated instead of rounded.
//! 4. A mistake that survives ([`suspect`]) is corrected, the log is diagnosed once more, and the mistake is
//!    believed only if the corrected log explains clearly more ([`Suspicion::judged`]).
//!
//! A factor has to be well determined (half and twice its value explain clearly less), and the corrected
//! simulation has to follow what was measured: a gain near zero explains nothing. What a delay among the
//! suspects can do stays a delay.
//!
//! *When not to use:* two mistakes at once are found only where one of them alone explains much.
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
mod glance;
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
    glance::glance,
    mistake::Mistake,
    nominal::Mended,
    result::Reading,
    suspicion::{Suspicion, suspect},
};
