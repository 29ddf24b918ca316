//! Causes, and how probable they are.

use fd_effect::{Side, SiteRef};
use fd_gap::{
    diagnose::{Cause, Diagnosis, Estimate, Group, Pair, SideShare},
    locate::Location,
};
use serde::Serialize;

use crate::gap::words;

/// A place in the model.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SiteReport {
    /// `input`, `force`, `state`, `output`, `parameter` or `model`.
    pub kind: &'static str,
    /// Its name; empty for the whole model.
    pub name: String,
}

/// A mechanism at a place.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct GroupReport {
    /// Mechanism, such as `friction`.
    pub family: &'static str,
    /// In words.
    pub name: String,
    /// Where.
    pub site: SiteReport,
    /// `input`, `dynamics` or `output`.
    pub side: &'static str,
    /// Sum of the probabilities of its causes.
    pub probability: f64,
    /// Places of its causes in `causes`, from 0.
    pub causes: Vec<usize>,
}

/// A side of the plant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SideReport {
    /// `input`, `dynamics` or `output`.
    pub side: &'static str,
    /// Sum of the probabilities of its causes.
    pub probability: f64,
    /// Largest share of the gap that a free signal at one of its places explains.
    pub free_share: Option<f64>,
    /// In words.
    pub statement: String,
}

/// An effect at a site.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CauseReport {
    /// In words, with the place.
    pub name: String,
    /// Label of the effect, as `--exclude` takes it.
    pub label: &'static str,
    /// Where it is.
    pub site: SiteReport,
    /// The other end of a coupling.
    pub partner: Option<SiteReport>,
    /// Mechanism.
    pub family: &'static str,
    /// `input`, `dynamics` or `output`.
    pub side: &'static str,
    /// Probability.
    pub probability: f64,
    /// Logarithm of the evidence over that of no gap.
    pub log_evidence: f64,
    /// Law with the most evidence.
    pub law: &'static str,
    /// Its parameters.
    pub parameters: Vec<ParameterReport>,
    /// Strength in words, such as `0.31 ± 0.02 N m`.
    pub strength: String,
    /// Root mean square of what it leaves of the fitted logs, in sigma.
    pub gap_sigma: f64,
    /// Whether this log cannot tell it from the first cause (true of the first one when there are
    /// others).
    pub is_tied: bool,
    /// Squares of the noise that separate it from the first cause, if it came close to it.
    pub rival_distance: Option<f64>,
}

/// Two causes that act together.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PairReport {
    /// The causes, with the parameters of the joint fit.
    pub causes: Vec<CauseReport>,
    /// Probability.
    pub probability: f64,
    /// Logarithm of the evidence over that of no gap.
    pub log_evidence: f64,
    /// Root mean square of what is left of the fitted logs, in sigma.
    pub gap_sigma: f64,
    /// Whether this log cannot tell it from the first pair (true of the first one when there are
    /// others).
    pub is_tied: bool,
}

/// A parameter of an effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterReport {
    /// Name in the patched model.
    pub name: String,
    /// Value in the patched model.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Its unit.
    pub unit: String,
    /// Whether it is a strength, 0 where the effect is absent.
    pub is_strength: bool,
    /// Value as a person would state it (a limit instead of its inverse, percent).
    pub shown_value: f64,
    /// Standard error of that value.
    pub shown_error: f64,
    /// Unit of that value.
    pub shown_unit: String,
}

impl From<&SiteRef> for SiteReport {
    fn from(site: &SiteRef) -> Self {
        let kind = match site {
            SiteRef::Input(..) => "input",
            SiteRef::Force(..) => "force",
            SiteRef::State(..) => "state",
            SiteRef::Output(..) => "output",
            SiteRef::Parameter(..) => "parameter",
            SiteRef::WholeModel => "model",
        };
        Self { kind, name: site.name().unwrap_or_default().to_owned() }
    }
}

impl ParameterReport {
    fn of(label: &str, estimate: &Estimate) -> Self {
        let (shown_value, shown_error, shown_unit) = words::shown(label, estimate);
        Self {
            name: estimate.name.clone(),
            value: estimate.value,
            standard_error: estimate.standard_error,
            unit: estimate.unit.clone(),
            is_strength: estimate.is_strength,
            shown_value,
            shown_error,
            shown_unit,
        }
    }

    /// Value, standard error and unit in words.
    pub(in crate::gap) fn words(&self) -> String {
        // A limit that is not there.
        if self.shown_value.is_infinite() {
            return "none".to_owned();
        }
        let value = words::with_error(self.shown_value, self.shown_error);
        match self.shown_unit.as_str() {
            "1" | "" => value,
            unit => format!("{value} {unit}"),
        }
    }
}

impl CauseReport {
    pub(in crate::gap) fn of(cause: &Cause) -> Self {
        let parameters: Vec<ParameterReport> =
            cause.parameters.iter().map(|e| ParameterReport::of(cause.label, e)).collect();
        Self {
            name: name(cause),
            label: cause.label,
            site: SiteReport::from(&cause.site),
            partner: cause.partner.as_ref().map(SiteReport::from),
            family: cause.family,
            side: side(cause.side),
            probability: cause.probability,
            log_evidence: cause.log_evidence,
            law: cause.law,
            strength: strength(cause, &parameters),
            parameters,
            gap_sigma: cause.gap,
            is_tied: false,
            rival_distance: None,
        }
    }

    /// All causes of a diagnosis.
    pub(in crate::gap) fn all(diagnosis: &Diagnosis) -> Vec<Self> {
        let mut causes: Vec<Self> = diagnosis.causes.iter().map(Self::of).collect();
        if 1 < diagnosis.tied.len() {
            for id in &diagnosis.tied {
                causes[id.0].is_tied = true;
            }
        }
        for rival in &diagnosis.rivals {
            causes[rival.cause.0].rival_distance = Some(rival.distance);
        }
        causes
    }
}

impl PairReport {
    fn of(pair: &Pair) -> Self {
        Self {
            causes: pair.causes.iter().map(CauseReport::of).collect(),
            probability: pair.probability,
            log_evidence: pair.log_evidence,
            gap_sigma: pair.gap,
            is_tied: false,
        }
    }

    /// Both causes, in words.
    pub(in crate::gap) fn name(&self) -> String {
        let names: Vec<&str> = self.causes.iter().map(|cause| cause.name.as_str()).collect();
        names.join(" with ")
    }

    /// All pairs of a diagnosis.
    pub(in crate::gap) fn all(diagnosis: &Diagnosis) -> Vec<Self> {
        let mut pairs: Vec<Self> = diagnosis.pairs.iter().map(Self::of).collect();
        if 1 < diagnosis.tied_pairs.len() {
            for id in &diagnosis.tied_pairs {
                pairs[id.0].is_tied = true;
            }
        }
        pairs
    }
}

impl GroupReport {
    pub(in crate::gap) fn of(group: &Group) -> Self {
        Self {
            family: group.family,
            name: format!("{} {}", words::family(group.family), words::at(&group.site))
                .trim_end()
                .to_owned(),
            site: SiteReport::from(&group.site),
            side: side(group.side),
            probability: group.probability,
            causes: group.causes.iter().map(|id| id.0).collect(),
        }
    }
}

impl SideReport {
    /// Sides with what a free signal at each of them explains.
    pub(in crate::gap) fn all(diagnosis: &Diagnosis, location: &Location) -> Vec<Self> {
        let report = |share: &SideShare| {
            let known = location.sides.iter().find(|evidence| evidence.side == share.side);
            Self {
                side: side(share.side),
                probability: share.probability,
                free_share: known.and_then(|evidence| evidence.free_share),
                statement: known.map_or_else(String::new, |evidence| evidence.statement.clone()),
            }
        };
        diagnosis.sides.iter().map(report).collect()
    }
}

/// The key of a side.
pub(in crate::gap) fn side(side: Side) -> &'static str {
    match side {
        Side::Input => "input",
        Side::Dynamics => "dynamics",
        Side::Output => "output",
    }
}

fn name(cause: &Cause) -> String {
    let mut name = format!("{} {}", words::label(cause.label), words::at(&cause.site));
    if let Some(partner) = &cause.partner {
        name = format!("{name} with {}", words::site(partner));
    }
    name.trim_end().to_owned()
}

/// The strengths; a curve of many strengths by its largest value.
fn strength(cause: &Cause, parameters: &[ParameterReport]) -> String {
    let strengths: Vec<&ParameterReport> = parameters.iter().filter(|p| p.is_strength).collect();
    if cause.label.ends_with("-map") {
        let by_size =
            |a: &&&ParameterReport, b: &&&ParameterReport| a.value.abs().total_cmp(&b.value.abs());
        let largest = strengths.iter().max_by(by_size);
        return largest.map_or_else(String::new, |p| format!("up to {}", p.words()));
    }
    let prefix = format!("{}_", cause.site.name().unwrap_or("plant"));
    let named = |p: &&ParameterReport| {
        let name = p.name.strip_prefix(&prefix).unwrap_or(&p.name).replace('_', " ");
        format!("{name} {}", p.words())
    };
    match &strengths[..] {
        [only] => only.words(),
        several => several.iter().map(named).collect::<Vec<_>>().join(", "),
    }
}
