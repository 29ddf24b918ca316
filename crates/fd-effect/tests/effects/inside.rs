//! Signals inside a model as places for effects.

use fd_effect::{SiteRef, with_inner_places};
use fd_sim::simulate::Outcome;

use crate::cases::{Case, PLANTS};

/// A case whose signals are places.
fn inside(plant: &str) -> Case {
    let Case { model, u, samples, .. } = Case::new(plant, 200);
    let mut case = Case::with_input(with_inner_places(&model), u, samples);
    let ts = case.model.sample_time().unwrap();
    case.scales = case.scales.clone().with_signals(&case.model, ts, &case.u, samples).unwrap();
    case
}

/// Names for terms are names: the plant does the same, but for the rounding of other groupings.
#[test]
fn names_change_nothing() {
    for plant in PLANTS {
        let (plain, named) = (Case::new(plant, 200), inside(plant));
        assert_eq!(named.scales.signals.len(), named.model.definitions.len(), "{plant}");
        let distance = plain.distance(&plain.nominal(), &named.nominal());
        // A thousand steps, each with rounding of 1e-16 that a pendulum makes a thousand times larger.
        assert!(distance < 1e-9, "{plant}: {distance}");
    }
}

/// At zero strength nothing changes, whatever the shapes are; at its starts every effect on a signal that
/// the outputs depend on does something.
#[test]
fn effects_on_signals_are_absent_at_zero_and_there_at_their_starts() {
    let mut moved = 0;
    for plant in PLANTS {
        let case = inside(plant);
        let nominal = case.nominal();
        let all = case.simulated();
        for candidate in all.iter().filter(|c| matches!(c.site, SiteRef::Signal(..))) {
            let start = candidate.starts.first().unwrap();
            let absent = candidate.parameters.iter().zip(start);
            let absent: Vec<f64> =
                absent.map(|(p, x)| if p.is_strength { p.neutral } else { *x }).collect();
            let (outcome, y) = case.apply(candidate, &absent);
            let name =
                format!("{plant}: {} {} {:?}", candidate.label, candidate.law, candidate.site);
            assert_eq!(outcome, Outcome::Complete, "{name}");
            assert!(case.distance(&nominal, &y) < 1e-9, "{name}: {}", case.distance(&nominal, &y));
            let (_, y) = case.apply(candidate, start);
            moved += usize::from(case.distance(&nominal, &y) > 1e-6);
        }
        let signals = case.scales.signals.iter().filter(|signal| signal.moves()).count();
        let on_signals = all.iter().filter(|c| matches!(c.site, SiteRef::Signal(..))).count();
        assert!(signals <= on_signals, "{plant}: every signal is a place");
    }
    assert!(100 < moved, "{moved} of them do something");
}
