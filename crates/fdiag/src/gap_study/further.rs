//! Further questions, once there is a diagnosis.

use fd_gap::{
    calibrate::{Confusion, self_calibrate},
    ceiling::{Ceiling, ceiling},
    diagnose::{Monitor, Verdict},
    experiment::{Advice, Reach, next},
    locate::{Location, locate},
    road::CauseList,
};

use super::{attempt::Attempt, error::GapError, pause::Pause, request::Request};

/// Answers to further questions; `None` where a question makes no sense or was not asked.
pub(super) struct Further {
    pub road: Option<CauseList>,
    pub location: Location,
    pub ceiling: Option<Ceiling>,
    pub advice: Option<Advice>,
    pub calibration: Option<Confusion>,
}

/// How they are asked.
#[derive(Clone, Copy)]
pub(super) struct Asked<'a> {
    pub request: &'a Request,
    /// Whether the simulator follows the logs: with logged outputs among the inputs, a black box would explain each
    /// output by itself, and other inputs cannot be tried.
    pub is_followed: bool,
    pub pause: &'a Pause<'a>,
}

impl Further {
    pub(super) fn of(
        attempt: &Attempt<'_>,
        Asked { request, is_followed, pause }: Asked<'_>,
        monitor: &dyn Monitor,
    ) -> Result<Self, GapError> {
        let Attempt { diagnosis, settings, .. } = attempt;
        let road = match request.most {
            2.. if pause.goes_on("further causes") => attempt.road(request, monitor)?,
            _ => None,
        };
        let case = &diagnosis.as_diagnosed(&attempt.case());
        let location = locate(case, diagnosis, monitor)?;
        let ceiling = if !is_followed && pause.goes_on("black boxes") {
            ceiling(case, diagnosis, settings, monitor)?
        } else {
            None
        };
        let is_open = match diagnosis.verdict {
            Verdict::Tied | Verdict::Unclear => true,
            Verdict::Pair => 1 < diagnosis.tied_pairs.len(),
            _ => false,
        };
        let reach = Reach { seed: request.seed, ..Reach::default() };
        let is_asked = is_open && !is_followed && pause.goes_on("experiments that would decide");
        let advice = is_asked.then(|| next(case, diagnosis, &reach, monitor)).transpose()?;
        let calibration = request
            .calibrate
            .filter(|_| !is_followed && pause.goes_on("the self-calibration"))
            .map(|replicas| self_calibrate(case, diagnosis, settings, replicas, monitor))
            .transpose()?
            .filter(|_| pause.came_to_its_end("the self-calibration"));
        Ok(Self { road, location, ceiling, advice, calibration })
    }
}
