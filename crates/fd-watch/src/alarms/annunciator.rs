//! The alarm of one unit: when it is raised, told again and over.

use serde::{Deserialize, Serialize};

use super::settings::AlarmSettings;

/// What a diagnosis says of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Heard {
    /// Time of the sample in s.
    pub time: f64,
    /// Whether it sees a fault.
    pub is_fault: bool,
    /// Which; a fault may have no name.
    pub hypothesis: Option<usize>,
    /// Ratio of statistic to threshold.
    pub ratio: f64,
    /// Whether nobody wants to hear of it now.
    pub is_shelved: bool,
}

/// What is to be told of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Said {
    /// A new alarm.
    Raised,
    /// Another fault explains it better.
    Cause,
    /// It is more severe than was told.
    Severity,
    /// It is the alarm that was over a while ago.
    Returned,
    /// It still stands.
    Reminder,
    /// It is over.
    Cleared,
}

/// An alarm that stands or stood a while ago. Times are in s of the samples.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Annunciator {
    /// The alarm that stands, or that was the last.
    pub id: Option<String>,
    stands: bool,
    /// The cause that was told.
    pub hypothesis: Option<usize>,
    /// Severity that was told.
    pub severity: u8,
    /// Since when there has been a fault without a break, while no alarm stands.
    fault_since: Option<f64>,
    /// Since when the unit has been normal, while an alarm stands.
    normal_since: Option<f64>,
    /// The last sample that spoke for the alarm.
    pub last: f64,
    told: f64,
    /// When the alarm was over.
    cleared: f64,
    off_delay: f64,
    update_after: f64,
}

impl Annunciator {
    /// The id of the alarm that stands.
    pub(crate) fn standing(&self) -> Option<&str> {
        self.id.as_deref().filter(|_| self.stands)
    }

    /// Whether numbers that were read can be.
    pub(crate) fn is_sound(&self) -> bool {
        let times = [self.last, self.told, self.cleared, self.off_delay, self.update_after];
        let since = [self.fault_since, self.normal_since].into_iter().flatten();
        times.into_iter().chain(since).all(f64::is_finite) && (!self.stands || self.id.is_some())
    }

    /// Takes a sample. `name` makes the id of a new alarm.
    pub(crate) fn hear(
        &mut self,
        settings: &AlarmSettings,
        heard: Heard,
        name: impl FnOnce() -> String,
    ) -> Option<Said> {
        if self.stands {
            self.while_standing(settings, heard)
        } else {
            self.while_quiet(settings, heard, name)
        }
    }

    fn while_quiet(
        &mut self,
        settings: &AlarmSettings,
        heard: Heard,
        name: impl FnOnce() -> String,
    ) -> Option<Said> {
        let Heard { time, is_fault, hypothesis, ratio, is_shelved } = heard;
        if !is_fault {
            self.fault_since = None;
            return None;
        }
        let since = *self.fault_since.get_or_insert(time);
        if is_shelved || time - since < settings.on_delay_s {
            return None;
        }
        // Within the hold it is the same alarm, and its unit has to be normal for longer to be believed.
        let returns = self.id.is_some() && since - self.cleared < settings.hold_s;
        if returns {
            self.off_delay = (2.0 * self.off_delay)
                .clamp(settings.off_delay_s, settings.off_delay_s.max(settings.hold_s));
            self.severity = self.severity.max(settings.severity(ratio));
        } else {
            self.id = Some(name());
            self.off_delay = settings.off_delay_s;
            self.severity = settings.severity(ratio);
        }
        self.stands = true;
        (self.hypothesis, self.fault_since, self.normal_since) = (hypothesis, None, None);
        (self.last, self.told, self.update_after) = (time, time, settings.update_s);
        Some(if returns { Said::Returned } else { Said::Raised })
    }

    fn while_standing(&mut self, settings: &AlarmSettings, heard: Heard) -> Option<Said> {
        let Heard { time, is_fault, hypothesis, ratio, is_shelved } = heard;
        if !is_fault && ratio <= 1.0 - settings.deadband {
            let since = *self.normal_since.get_or_insert(time);
            return (self.off_delay <= time - since).then(|| self.clear(time));
        }
        self.normal_since = None;
        self.last = time;
        if is_shelved {
            return None;
        }
        let severity = settings.severity(ratio);
        let is_other = is_fault && hypothesis != self.hypothesis;
        let quiet = time - self.told;
        let said = if severity > self.severity && is_fault {
            self.severity = severity;
            Said::Severity
        } else if is_other && self.update_after <= quiet {
            self.update_after *= 2.0;
            Said::Cause
        } else if 0.0 < settings.renotify_s && settings.renotify_s <= quiet {
            Said::Reminder
        } else {
            return None;
        };
        if is_fault {
            self.hypothesis = hypothesis;
        }
        self.told = time;
        Some(said)
    }

    /// The alarm ends here, whatever its delays.
    pub(crate) fn clear(&mut self, time: f64) -> Said {
        self.stands = false;
        (self.cleared, self.fault_since, self.normal_since) = (time, None, None);
        Said::Cleared
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is told of samples a second apart.
    fn told(
        settings: &AlarmSettings,
        samples: impl Iterator<Item = (bool, f64)>,
    ) -> Vec<(u32, Said)> {
        let mut alarm = Annunciator::default();
        (0..)
            .zip(samples)
            .filter_map(|(k, (is_fault, ratio))| {
                let (time, is_shelved) = (f64::from(k), false);
                let heard = Heard { time, is_fault, hypothesis: None, ratio, is_shelved };
                Some((k, alarm.hear(settings, heard, || k.to_string())?))
            })
            .collect()
    }

    #[test]
    fn delays_are_what_they_say() {
        let settings = AlarmSettings { on_delay_s: 5.0, ..AlarmSettings::default() };
        let fault = |from: usize, to: usize| {
            (0..300).map(move |k| if (from..to).contains(&k) { (true, 2.0) } else { (false, 0.5) })
        };
        assert_eq!(told(&settings, fault(10, 15)), []);
        assert_eq!(told(&settings, fault(10, 30)), [(15, Said::Raised), (90, Said::Cleared)]);
    }

    /// Just below the threshold is not yet normal.
    #[test]
    fn the_deadband_holds() {
        let settings = AlarmSettings { deadband: 0.1, ..AlarmSettings::default() };
        let hovering = (0..500).map(|k| (k < 5, if k < 5 { 1.2 } else { 0.95 }));
        assert_eq!(told(&settings, hovering), [(0, Said::Raised)]);
    }

    /// A fault whose statistic goes over and under the threshold every 100 s, for a day: with an off-delay of 60 s that
    /// would be 864 alarms.
    #[test]
    fn a_fault_that_comes_and_goes_is_one_alarm() {
        let settings = AlarmSettings::default();
        let chatter = (0..86_400).map(|k| if k % 100 < 20 { (true, 1.5) } else { (false, 0.5) });
        let told = told(&settings, chatter);
        let count = |what| told.iter().filter(|(_, said)| *said == what).count();
        // The off-delay is 120 s after one return.
        assert_eq!([Said::Raised, Said::Returned, Said::Cleared].map(count), [1, 1, 1]);
        assert_eq!(count(Said::Reminder), 2);
        assert_eq!(told.len(), 5);
    }

    #[test]
    fn severity_rises_and_does_not_fall() {
        let ratios = [1.5, 4.0, 2.0, 4.0, 20.0, 5.0];
        let said = told(&AlarmSettings::default(), ratios.map(|ratio| (true, ratio)).into_iter());
        assert_eq!(said, [(0, Said::Raised), (1, Said::Severity), (4, Said::Severity)]);
    }

    /// Two causes that take turns at every sample for a day are told about ten times.
    #[test]
    fn causes_that_take_turns_are_told_ever_more_rarely() {
        let settings = AlarmSettings { renotify_s: 0.0, ..AlarmSettings::default() };
        let mut alarm = Annunciator::default();
        let told = (0..86_400_u32).filter(|k| {
            let (time, is_fault, is_shelved) = (f64::from(*k), true, false);
            let hypothesis = Some((k % 2) as usize);
            let heard = Heard { time, is_fault, hypothesis, ratio: 1.5, is_shelved };
            alarm.hear(&settings, heard, String::new).is_some()
        });
        assert!((5..=12).contains(&told.count()));
    }

    #[test]
    fn what_is_shelved_is_raised_afterwards() {
        let mut alarm = Annunciator::default();
        let settings = AlarmSettings::default();
        let said = |alarm: &mut Annunciator, k: u32| {
            let (time, is_shelved) = (f64::from(k), k < 50);
            let (is_fault, hypothesis) = (true, None);
            let heard = Heard { time, is_fault, hypothesis, ratio: 1.5, is_shelved };
            alarm.hear(&settings, heard, String::new)
        };
        assert!((0..50).all(|k| said(&mut alarm, k).is_none()));
        assert_eq!(said(&mut alarm, 50), Some(Said::Raised));
    }
}
