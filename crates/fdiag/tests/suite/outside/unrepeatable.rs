//! Simulators that do not repeat themselves: what differs is measured and counts as noise.

use fd_gap::diagnose::Verdict;
use fdiag::gap_study::{GapStudy, LogDefect, Request, SimulatorDefect, Subject, words};
use tempfile::TempDir;

use crate::outside::cart::{Cause, Chance, NOISE, log, simulator};

const SAMPLES: usize = 700;
/// Causes that are tried: those of the test and their neighbours.
const ONLY: [&str; 9] = [
    "input-delay",
    "input-gain",
    "input-lag",
    "coulomb-friction",
    "viscous-friction",
    "constant-load",
    "sensor-scale",
    "sensor-bias",
    "sensor-lag",
];
/// As much noise in the sensors of the simulator as in those of the logs.
const WHITE: Chance = Chance { of_sensors: NOISE, gust: 0.0 };
/// A force by chance, which makes place and speed wander.
const GUSTY: Chance = Chance { of_sensors: [0.0; 2], gust: 0.3 };

fn study(cause: Cause, chance: Chance, is_stated: bool, seed: u64) -> GapStudy {
    let to = TempDir::new().unwrap();
    let mut request = Request::new("cart", [log(&to, cause, SAMPLES, seed)]);
    (request.most, request.as_read) = (1, true);
    request.only = ONLY.map(str::to_owned).to_vec();
    let subject = Subject::lent(&request, simulator(chance, seed, is_stated), None).unwrap();
    let begun = std::time::Instant::now();
    let study = GapStudy::run_on(&request, &subject, &()).unwrap();
    let (counts, _) = study.outside.clone().unwrap();
    let foretold = study.report.sparing.as_ref().map(|sparing| sparing.foretold);
    println!(
        "{cause:?}, {chance:?}, stated {is_stated}, seed {seed}: {}; {} runs, {foretold:?} foretold, {:.1?}",
        study.report.headline,
        counts.made,
        begun.elapsed()
    );
    study
}

/// What is said of the spread of the outputs, by name.
fn said(study: &GapStudy) -> Vec<(String, f64, String)> {
    let each = study.report.findings.iter().filter_map(|finding| match &finding.defect {
        LogDefect::Simulator(SimulatorDefect::NotRepeatable { spread, .. }) => {
            Some((finding.channel.clone(), *spread, words::defect(&finding.defect)))
        }
        _ => None,
    });
    each.collect()
}

#[test]
fn the_spread_of_equal_runs_is_a_finding_in_words() {
    let study = study(Cause::Coulomb(0.4), WHITE, true, 11);
    let said = said(&study);
    assert_eq!(said.iter().map(|(name, ..)| name.as_str()).collect::<Vec<_>>(), ["place", "speed"]);
    for ((_, spread, words), noise) in said.iter().zip(NOISE) {
        // Four runs of 469 samples: the standard deviation is known to 1/√(2·3·469), 1.9 %; three times that.
        assert!((spread / noise - 1.0).abs() < 0.06, "{spread}");
        assert!(words.contains("does not repeat itself"), "{words}");
    }
    // A simulator that repeats itself is not complained of.
    let still = self::study(Cause::Coulomb(0.4), Chance::default(), true, 11);
    assert!(self::said(&still).is_empty());
}

#[test]
fn a_clear_cause_is_still_found() {
    for (cause, label, site) in [
        (Cause::Delay(5), "input-delay", "force"),
        (Cause::SpeedScale(0.15), "sensor-scale", "speed"),
        (Cause::Coulomb(0.8), "coulomb-friction", "rail"),
    ] {
        for seed in 41..43 {
            let study = study(cause, WHITE, true, seed);
            let first = &study.report.diagnosis.causes[0];
            println!(
                "{:?} {label}: {}@{:?}",
                study.report.diagnosis.verdict,
                first.label,
                first.site.name()
            );
            assert_eq!((first.label, first.site.name()), (label, Some(site)), "{seed}");
            assert_ne!(study.report.diagnosis.verdict, Verdict::NoGap);
        }
    }
}

/// Runs draw their chances in the order in which threads make them, so that no two studies are alike: a few of eight nulls
/// may be a crowd of faint causes, tied, that together are just more probable than no gap. None may be sure.
#[test]
fn a_null_is_hardly_blamed_and_never_surely() {
    let mut blamed = 0;
    for (chance, is_stated) in [(WHITE, true), (WHITE, false), (GUSTY, true), (GUSTY, false)] {
        for seed in 31..33 {
            let study = study(Cause::Nothing, chance, is_stated, seed);
            let verdict = study.report.diagnosis.verdict;
            let is_blamed = matches!(verdict, Verdict::Cause | Verdict::Pair | Verdict::Tied);
            let surest = study.report.diagnosis.groups.first().map_or(0.0, |g| g.probability);
            assert!(!is_blamed || surest < 0.5, "{chance:?}: {}", study.report.headline);
            blamed += u8::from(is_blamed);
        }
    }
    assert!(blamed <= 4, "{blamed} of 8");
    println!("{blamed} of 8 blamed");
}
