//! A study of logs in a few sentences.

use fd_model::figure;
use fd_numeric::rms;
use fdiag::training::{Applied, WhyNot};

use super::{
    healthy::LogDoubt,
    report::file_name,
    study::{LogResult, LogStudy, SignalUnit},
};

impl LogStudy {
    /// What came out, in one sentence.
    #[must_use]
    pub fn headline(&self) -> String {
        let later: Vec<&LogResult> = self.logs.iter().filter(|log| !log.healthy).collect();
        let shown: Vec<&LogResult> =
            if later.is_empty() { self.logs.iter().collect() } else { later.clone() };
        let total =
            |f: &dyn Fn(&LogResult) -> &[f64]| rms(shown.iter().flat_map(|log| f(log)).copied());
        let (before, after) = (total(&|log| &log.rms_primary), total(&|log| &log.rms_compensated));
        // Several outputs have no unit in common; what is left is how much smaller they became.
        let change = match &self.residuals[..] {
            [only] => format!(
                " from {} to {} {}",
                figure(only.scale * before),
                figure(only.scale * after),
                only.unit
            ),
            _ => String::new(),
        };
        let which = if later.is_empty() { "healthy logs" } else { "later logs" };
        let alarms = self.alarms(&later);
        let off = self.where_off();
        if self.all_are(Applied::Nothing) {
            return format!("{off}{alarms}{}", self.cautions());
        }
        let factor = |after: f64| {
            if after <= before {
                format!("{} times smaller", figure(before / after))
            } else {
                format!("{} times larger", figure(after / before))
            }
        };
        let alone = if self.all_are(Applied::Constant) {
            String::new()
        } else {
            format!(", a constant alone {}", factor(total(&|log| &log.rms_constant)))
        };
        format!(
            "{off}Compensation makes the rms residual on the {which} {}{change}{alone}.{alarms}{}{}",
            factor(after),
            self.warning(),
            self.cautions(),
        )
    }

    /// Which logs raise an alarm, the healthy ones among them, and which could not be judged, as sentences.
    fn alarms(&self, later: &[&LogResult]) -> String {
        let is_alarmed = |log: &&LogResult| log.first_alarm_s.1.is_some();
        let (judged, unjudged): (Vec<&LogResult>, Vec<&LogResult>) =
            later.iter().partition(|log| 0 < log.judged);
        let said = match (judged.len(), judged.iter().copied().filter(|l| is_alarmed(l)).count()) {
            (0, _) => String::new(),
            (1, 0) => " The later log raises no alarm.".to_owned(),
            (1, _) => " The later log raises an alarm.".to_owned(),
            (n, 0) => format!(" None of the {n} later logs raises an alarm."),
            (n, a) => format!(" {a} of the {n} later logs raise an alarm."),
        };
        let names: Vec<String> = unjudged.into_iter().map(file_name).collect();
        let unjudged = if names.is_empty() {
            String::new()
        } else {
            format!(
                " Not judged: {}; no sample is left once the diagnosis has settled (`settle_s` of the spec, by default five \
                 time constants of the residual generator).",
                names.join(", ")
            )
        };
        let healthy = || self.logs.iter().filter(|log| log.healthy);
        let (own, all) = (healthy().filter(is_alarmed).count(), healthy().count());
        let own = if own == 0 {
            String::new()
        } else {
            format!(
                " {own} of the {all} healthy logs {} an alarm as well: the threshold does not cover all that the healthy \
                 plant does.",
                if own == 1 { "raises" } else { "raise" }
            )
        };
        said + &unjudged + &own
    }

    /// Whether the same is subtracted from every residual.
    fn all_are(&self, applied: Applied) -> bool {
        let payments = &self.bias.payments;
        !payments.is_empty() && payments.iter().all(|payment| payment.applied == applied)
    }

    /// The residuals that the bias model is not subtracted from and why, as sentences; empty when there are none.
    fn where_off(&self) -> String {
        let off: Vec<(&SignalUnit, Applied, WhyNot)> = self
            .residuals
            .iter()
            .zip(&self.bias.payments)
            .filter(|(_, payment)| payment.applied != Applied::Bias)
            .filter_map(|(residual, payment)| Some((residual, payment.applied, payment.why_not?)))
            .collect();
        let Some((_, _, first)) = off.first() else { return String::new() };
        let all_for_this = off.iter().all(|(_, _, why)| why == first);
        let why = if all_for_this {
            first.in_words().to_owned()
        } else {
            let each = off.iter().map(|(of, _, why)| format!("{}: {}", of.name, why.in_words()));
            each.collect::<Vec<_>>().join("; ")
        };
        if *first == WhyNot::Never {
            "Compensation is switched off (bias.apply = \"never\"); the primary residual is judged."
                .to_owned()
        } else if self.all_are(Applied::Nothing) {
            format!(
                "Compensation does not pay here and is off, and the primary residual is judged: {why}."
            )
        } else if self.all_are(Applied::Constant) {
            format!("Only a constant is subtracted, as more does not pay here: {why}. ")
        } else {
            let instead = off.iter().map(|(residual, applied, why)| {
                let with = if *applied == Applied::Constant { "a constant" } else { "nothing" };
                format!("{} has {with} subtracted: {}", residual.name, why.in_words())
            });
            let instead: Vec<String> = instead.collect();
            format!(
                "The bias model is not subtracted where it does not pay. {}. ",
                instead.join("; ")
            )
        }
    }

    /// What speaks against the healthy logs and the thresholds from them, as sentences.
    fn cautions(&self) -> String {
        let doubts = self.doubts.iter().map(LogDoubt::sentence);
        let voids = self.logs.iter().filter_map(|log| {
            log.void.as_ref().map(|void| format!("{}: {}.", file_name(log), void.in_words()))
        });
        let not_compared = self.not_compared.as_ref();
        let not_compared =
            not_compared.map(|why| format!("Alarms without compensation are not compared: {why}."));
        let above = self.above_maximum.map(|above| above.in_words());
        let all: Vec<String> = doubts.chain(voids).chain(not_compared).chain(above).collect();
        if all.is_empty() { String::new() } else { format!(" {}", all.join(" ")) }
    }

    /// Logs on which compensation makes things worse, as a sentence; empty when there are none.
    fn warning(&self) -> String {
        let total = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
        let worse: Vec<String> = self
            .logs
            .iter()
            .filter(|log| total(&log.rms_compensated) > total(&log.rms_primary))
            .map(file_name)
            .collect();
        if worse.is_empty() {
            return String::new();
        }
        format!(
            " It makes the residual larger on {}: the bias there is not the one that was learned, \
             for example because it is not linear in the input.",
            worse.join(", ")
        )
    }
}
