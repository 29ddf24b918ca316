//! What a log says: as it is read, as it may be meant, with what is unlike the rest of it, and inside the model.

use std::cell::OnceCell;

use fd_gap::{
    diagnose::{Monitor, Verdict},
    reading::Reading,
};
use fd_model::Record;
use fd_sim::simulate::{Follower, Nominal};

use super::{
    attempt::{Attempt, Mended, confirmed, glanced, mended},
    data::Data,
    error::GapError,
    log_part::LogPart,
    pause::Pause,
    request::Request,
    subject::Subject,
    whole::{Whole, judge},
};

/// The attempt that is reported.
pub(super) struct Found<'a> {
    pub attempt: Attempt<'a>,
    /// The mistake of reading that is mended in it.
    pub reading: Option<Reading>,
    /// All rows of a long log.
    pub whole: Option<Whole>,
}

/// What is looked into.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    pub request: &'a Request,
    pub subject: &'a Subject,
    /// The simulator of the subject, or the `follower`.
    pub nominal: &'a dyn Nominal,
    pub data: &'a Data,
    pub follower: Option<&'a Follower<'a>>,
}

/// Data and subjects that come up on the way, and are what attempts are of.
#[derive(Default)]
pub(super) struct Shelf {
    glanced: OnceCell<Mended>,
    richer: OnceCell<Data>,
    mended: OnceCell<Mended>,
    inner: OnceCell<Subject>,
}

impl<'a> Search<'a> {
    /// A mistake of reading that explains all is found first; then come causes in the log as it is read, mistakes that
    /// explain more than these, and places inside the model where one law there may be all there is to say.
    pub(super) fn find(
        self,
        shelf: &'a Shelf,
        pause: &Pause<'_>,
        monitor: &dyn Monitor,
    ) -> Result<Found<'a>, GapError> {
        let found = match self.at_once(shelf, monitor)? {
            Some(found) => found,
            None => self.as_read_or_meant(shelf, pause, monitor)?,
        };
        let has_gap = found.attempt.diagnosis.verdict != Verdict::NoGap;
        let has_room = has_gap && found.reading.is_none() && self.follower.is_none();
        if !has_room || !pause.goes_on("places inside the model") {
            return Ok(found);
        }
        let subject = kept(&shelf.inner, found.attempt.subject.with_inner_places());
        let inside = |inner| Attempt::inside(self.request, inner, &found.attempt, monitor);
        match subject.and_then(inside) {
            Some(attempt) => Ok(Found { whole: self.whole(&attempt)?, attempt, reading: None }),
            None => Ok(found),
        }
    }

    /// A mistake that is seen before any cause is tried, and leaves no gap.
    fn at_once(
        self,
        shelf: &'a Shelf,
        monitor: &dyn Monitor,
    ) -> Result<Option<Found<'a>>, GapError> {
        let Self { request, subject, data, .. } = self;
        // What follows a log makes up for many a mistake of reading.
        let glanced = if self.follower.is_none() { glanced(request, subject, data) } else { None };
        let glanced = kept(&shelf.glanced, glanced);
        let found = confirmed(request, subject, glanced, monitor);
        let Some((attempt, reading)) = found else { return Ok(None) };
        if attempt.diagnosis.verdict != Verdict::NoGap {
            return Ok(None);
        }
        let whole = self.whole(&attempt)?;
        Ok(Some(Found { attempt, reading: Some(reading), whole }))
    }

    fn as_read_or_meant(
        self,
        shelf: &'a Shelf,
        pause: &Pause<'_>,
        monitor: &dyn Monitor,
    ) -> Result<Found<'a>, GapError> {
        let Self { request, subject, nominal, data, follower } = self;
        let first = Attempt::new(request, subject, nominal, data, monitor);
        let whole = match &first {
            Ok(first) => self.whole(first)?,
            Err(_) => None,
        };
        // Windows of a long log that are unlike its stretches are fitted, too.
        let unlike = whole.as_ref().and_then(|whole| with_unlike(data, whole, follower));
        let unlike = unlike.filter(|_| pause.goes_on("windows that are unlike the others"));
        let again = kept(&shelf.richer, unlike)
            .map(|richer| Attempt::new(request, subject, nominal, richer, monitor));
        let (is_richer, as_read) = match again {
            // What was cut short is no better than what came to its end.
            Some(Ok(again)) if again.diagnosis.is_stopped && first.is_ok() => {
                pause.goes_on("windows that are unlike the others");
                (false, first)
            }
            Some(again) => (true, again),
            None => (false, first),
        };
        let suspected = if follower.is_none() && pause.goes_on("mistakes of reading") {
            mended(request, subject, data, &as_read)
        } else {
            None
        };
        let suspected = kept(&shelf.mended, suspected);
        if let Some((attempt, reading)) = confirmed(request, subject, suspected, monitor) {
            let whole = self.whole(&attempt)?;
            return Ok(Found { attempt, reading: Some(reading), whole });
        }
        let attempt = as_read?;
        let whole = if is_richer { self.whole(&attempt)? } else { whole };
        Ok(Found { attempt, reading: None, whole })
    }

    /// All rows of long logs, judged by a diagnosis of their stretches.
    fn whole(self, attempt: &Attempt<'_>) -> Result<Option<Whole>, GapError> {
        let Some(long) = &attempt.data.long else { return Ok(None) };
        let followed = |record: &Record| match self.follower {
            // A record of this model can be followed.
            Some(follower) => follower.record(record).unwrap_or_else(|_| record.clone()),
            None => record.clone(),
        };
        let fitted = attempt.data.fit.iter().map(Record::len).sum();
        Ok(judge(long, attempt.nominal(), &attempt.diagnosis, fitted, followed)?)
    }
}

/// Puts something on a shelf, where there is something.
fn kept<T>(place: &OnceCell<T>, thing: Option<T>) -> Option<&T> {
    thing.map(|thing| place.get_or_init(|| thing))
}

/// The data with windows that the answer does not fit as it does the others; `None` without any.
fn with_unlike(data: &Data, whole: &Whole, follower: Option<&Follower<'_>>) -> Option<Data> {
    let long = data.long.as_ref()?;
    let mut richer = data.clone();
    for window in whole.to_fit(long) {
        let (index, rows) = window.place;
        let (part, record) = &long.parts[index];
        let is_known = |known: &LogPart| known.path == part.path && known.samples == window.rows;
        if data.parts.iter().any(is_known) {
            continue;
        }
        let followed = follower.and_then(|follower| follower.record(record).ok());
        richer.add(part, followed.as_ref().unwrap_or(record), rows);
    }
    (data.fit.len() < richer.fit.len()).then_some(richer)
}
