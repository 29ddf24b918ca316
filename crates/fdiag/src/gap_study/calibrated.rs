//! All uncertain parameters of a simulator, calibrated on logs: values, errors, what is open, and what is left.

use fd_effect::Candidate;
use fd_gap::{
    diagnose::Case,
    estimate::{Calibration, Standing, estimate},
};
use fd_sim::{model::Draft, simulate::Simulator};
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    automatic::{longest, settings},
    error::GapError,
    memory::Memory,
    read::read_logs,
    request::{HeldOutChoice, Request},
    study::on_threads,
    subject::{Subject, settled},
};

/// Residuals up to this many times the noise are as good as the noise: what a stated noise is believed to.
const AT_THE_NOISE: f64 = 1.2;

/// A simulator, calibrated.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CalibratedModel {
    /// The answer in one or two sentences.
    pub headline: String,
    /// Values, errors and what is left.
    #[serde(flatten)]
    pub calibration: Calibration,
    /// The file of the simulator with the values in it; not serialised.
    #[serde(skip)]
    pub text: String,
}

/// Fits the uncertain parameters of a simulator to all logs of a request; of the request, what concerns effects and
/// held-out logs does not matter.
///
/// ```no_run
/// use fdiag::gap_study::{Request, calibrate};
///
/// let found = calibrate(&Request::new("cart.toml", ["monday.csv"]))?;
/// println!("{}", found.headline);
/// # Ok::<(), fdiag::gap_study::GapError>(())
/// ```
///
/// # Errors
///
/// Returns the first file or step that is wrong; and an error where the model has no uncertain parameter.
pub fn calibrate(request: &Request) -> Result<CalibratedModel, GapError> {
    calibrate_on(request, &Subject::of(request)?)
}

/// The same with a subject that is there: the model file of the request is but its name.
///
/// # Errors
///
/// As [`calibrate`].
pub fn calibrate_on(request: &Request, subject: &Subject) -> Result<CalibratedModel, GapError> {
    let workers = subject.outside().map_or(1, Simulator::workers);
    on_threads(workers, || of(request, subject)).map_err(|error| subject.explained(error))
}

fn of(request: &Request, subject: &Subject) -> Result<CalibratedModel, GapError> {
    let request = Request { held_out: HeldOutChoice::Logs(Vec::new()), ..request.clone() };
    if subject.model().parameters.iter().all(|p| p.tolerance == 0.0) {
        return Err(GapError::NothingUncertain);
    }
    let data = read_logs(&request, subject, None)?;
    subject.check_cost(&data.fit, &request.limits)?;
    subject.unrepeated(&data)?;
    let ts = data.ts().ok_or(GapError::NothingUncertain)?;
    let simulator = subject.nominal().simulator(ts)?;
    let logs = data.logs(&*simulator)?;
    let (u, samples) = longest(&logs[0]);
    let memory = Memory::of(&*simulator, &u, samples);
    let horizon = settings(&request, memory, &logs, ts).horizon;
    let nominal = subject.nominal();
    let suspects: Vec<Candidate> = Vec::new();
    let case = Case { nominal, suspects: &suspects, logs: &data.fit, held_out: &[] };
    let calibration = estimate(&case, horizon)?;
    let mut draft = Draft::clone(subject.model());
    for found in &calibration.parameters {
        if let Some(parameter) = draft.parameters.iter_mut().find(|p| p.name == found.name) {
            parameter.value = found.value;
        }
    }
    let model = settled(draft, &request.model)?;
    let (headline, text) = (headline(&calibration), subject.text(&model));
    Ok(CalibratedModel { headline, calibration, text })
}

/// How many parameters are found, which are not, and what is left.
fn headline(found: &Calibration) -> String {
    let of = |standing: Standing| -> Vec<&str> {
        let those = found.parameters.iter().filter(|p| p.standing == standing);
        those.map(|p| p.name.as_str()).collect()
    };
    let all = found.parameters.len();
    let mut text = format!("{} of {all} parameters found", of(Standing::Found).len());
    for (standing, what) in [
        (Standing::AtEdge, "at the edge of what is allowed"),
        (Standing::InCombination, "only in combination"),
        (Standing::Unmoved, "not moved by these logs"),
    ] {
        let names = of(standing);
        if !names.is_empty() {
            text += "; ";
            text += what;
            text += ": ";
            text += &names.join(", ");
        }
    }
    let left = found.left();
    let worst =
        found.outputs.iter().max_by(|a, b| (a.after / a.noise).total_cmp(&(b.after / b.noise)));
    let worst = worst.map_or("", |output| output.name.as_str());
    text + &if left <= AT_THE_NOISE {
        ". The model then explains the logs down to the noise.".to_owned()
    } else {
        format!(
            ". {} times the noise of `{worst}` is left: the model lacks something, which `fdiag gap` looks for; the \
             values may stand in for it.",
            fd_model::figure(left)
        )
    }
}
