//! The tournament: fair, repeatable, to be continued, and right about what is known.
#![allow(clippy::unwrap_used, reason = "tests panic to fail")]

use std::{
    fs,
    path::Path,
    sync::atomic::{AtomicU64, Ordering},
};

use fd_lab::compare::{
    CompareConfig, CompareError, Comparison, Engines, ProfileKind, Share, Sizes,
};
use fdiag::Watcher;

/// One linear scenario, one observer, with and without bias model.
fn small() -> CompareConfig {
    let engines = Engines {
        thresholds: 3,
        test: 3,
        calibration_runs: 6,
        threshold_runs: 40,
        test_runs: 6,
        fault_runs: 4,
    };
    let mut config = CompareConfig { engines, ..CompareConfig::default() };
    config.scenarios.retain(|scenario| scenario.name == "linear");
    config.generators.retain(|generator| generator.name == "observer");
    config.biases.retain(|bias| bias.name == "none" || bias.name == "arx-filtered");
    config.detectors.retain(|detector| detector.name == "maximum" || detector.name == "cusum");
    config.faults.profiles = vec![ProfileKind::Incipient];
    config.faults.sensor_sizes = Sizes { smallest: 5e-4, largest: 0.08, count: 6 };
    config
}

fn run(config: &CompareConfig, journal: Option<&Path>, threads: usize) -> Comparison {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let mut comparison = pool.install(|| Comparison::run(config, journal, &())).unwrap();
    // Times are the only thing that may differ.
    comparison.overall.iter_mut().for_each(|overall| overall.cost_ns = None);
    comparison
}

#[test]
fn compensation_finds_smaller_faults_at_the_same_rate() {
    let config = small();
    let comparison = run(&config, None, 2);
    let entries = &comparison.scenarios[0].entries;
    assert_eq!(entries.len(), config.entries());
    let best = |bias: &str| {
        let of = entries.iter().filter(|entry| entry.entry.bias == bias);
        of.map(|entry| entry.score).fold(f64::INFINITY, f64::min)
    };
    // The benchmark of the paper's case makes the smallest fault tens of times smaller; a grid
    // of sizes a factor of 2.8 apart and three engines still show a factor of three.
    assert!(best("arx-filtered") * 3.0 < best("none"), "{comparison:#?}");
    for entry in entries {
        assert_eq!(entry.false_alarms.of, 18);
        for (k, fault) in entry.faults.iter().enumerate() {
            let sizes = comparison.scenarios[0].faults[k].sizes.len();
            assert!((0..sizes).all(|s| (0.0..=1.0).contains(&entry.found(k, s))));
            if let (Some(smallest), [Some(low), _]) = (fault.smallest, fault.interval) {
                assert!(low <= smallest, "{low} {smallest}");
            }
        }
        // A higher rate of false alarms lets no fault through that a lower one found.
        let mut roc = entry.roc.clone();
        roc.sort_by(|a, b| a.rate.total_cmp(&b.rate));
        for pair in roc.windows(2) {
            assert!(pair[0].false_alarms <= pair[1].false_alarms);
        }
    }
    // 400 entries of a scenario with eight kinds of faults have to stay below 1 MB.
    let json = serde_json::to_string(&comparison.scenarios).unwrap();
    assert!(json.len() < 1500 * entries.len(), "{} for {}", json.len(), entries.len());

    let page = comparison.markdown("fdiag-lab compare");
    for part in ["## Ways to be robust", "| observer · arx-filtered · cusum |", "compensation"] {
        assert!(page.contains(part), "{part}: {page}");
    }
    // Every row of a table has as many cells as its header.
    let bars = |line: &&str| line.matches('|').count();
    for table in page.split("\n\n").filter(|part| part.starts_with('|')) {
        let mut counts = table.lines().map(|line| bars(&line));
        let header = counts.next().unwrap();
        assert!(header > 2 && counts.all(|count| count == header), "{table}");
    }
}

#[test]
fn threads_and_interruptions_change_nothing() {
    let mut config = small();
    config.engines.test = 2;
    config.biases.truncate(1);
    let directory = tempfile::tempdir().unwrap();
    let journal = directory.path().join("progress.jsonl");
    let whole = run(&config, Some(&journal), 2);
    assert_eq!(run(&config, None, 1), whole);

    // Killed in the middle of writing its fourth line.
    let text = fs::read_to_string(&journal).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let (kept, torn) = (lines[..3].join("\n"), &lines[3][..20]);
    fs::write(&journal, format!("{kept}\n{torn}")).unwrap();
    let watcher = Count::default();
    let mut again = Comparison::run(&config, Some(&journal), &watcher).unwrap();
    again.overall.iter_mut().for_each(|overall| overall.cost_ns = None);
    assert_eq!(again, whole);
    // Of five engines two were known.
    assert_eq!(watcher.0.load(Ordering::Relaxed), 3);

    config.first_seed += 1;
    let other = Comparison::run(&config, Some(&journal), &()).unwrap_err();
    assert!(matches!(other, CompareError::OtherRun { .. }), "{other}");
}

#[derive(Default)]
struct Count(AtomicU64);

impl Watcher for Count {
    fn begin(&self, engines: u64, done: u64) {
        assert_eq!((engines, done), (5, 2));
    }

    fn advance(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn an_entry_that_cannot_be_built_says_why_and_the_others_run() {
    let mut config = small();
    let unknown: CompareConfig = config.clone();
    // There is no such pole.
    config.generators.push(fd_lab::compare::Generator {
        name: "nowhere".to_owned(),
        spec: fdiag::spec::GeneratorSpec::Observer { rate: f64::NAN },
        weighting: None,
        diagnose_s: None,
    });
    config.biases.truncate(1);
    config.engines.test = 1;
    let comparison = run(&config, None, 2);
    let scenario = &comparison.scenarios[0];
    assert_eq!(scenario.failed.len(), config.detectors.len());
    assert!(
        scenario.failed.iter().all(|(entry, why)| entry.generator == "nowhere" && !why.is_empty())
    );
    assert_eq!(scenario.entries.len(), config.detectors.len());

    // Thresholds for one run in a hundred cannot be set with fifty runs.
    let mut few = unknown.clone();
    few.engines.threshold_runs = 10;
    let error = Comparison::run(&few, None, &()).unwrap_err();
    assert!(error.to_string().contains("false_alarms"), "{error}");
    let mut many = unknown.clone();
    many.engines.fault_runs = many.engines.test_runs + 1;
    let error = Comparison::run(&many, None, &()).unwrap_err();
    assert!(error.to_string().contains("fault_runs"), "{error}");
    let mut nothing = unknown.clone();
    nothing.generators[0].diagnose_s = Some(20.0);
    let error = Comparison::run(&nothing, None, &()).unwrap_err();
    assert!(error.to_string().contains("diagnose_s: expected"), "{error}");
    let mut wrong = unknown;
    wrong.faults.sensors = vec!["T_99".to_owned()];
    let error = Comparison::run(&wrong, None, &()).unwrap_err();
    assert!(error.to_string().contains("T_99"), "{error}");
}

/// Clopper & Pearson's own table: 3 of 10 lies in [0.067, 0.652].
#[test]
fn exact_intervals() {
    let share = Share::new(3, 10);
    assert!((share.low - 0.0667).abs() < 5e-4 && (share.high - 0.6525).abs() < 5e-4, "{share:?}");
    assert!((Share::new(10, 10).low - 0.6915).abs() < 5e-4);
    assert!(Share::new(0, 0).share().is_nan());
}

/// Runs of one engine that go together are worth less than independent ones, and never more.
#[test]
fn intervals_of_runs_that_go_together() {
    let engines = [(9, 10), (1, 10), (8, 10), (2, 10), (10, 10), (0, 10)];
    let (clustered, independent) = (Share::clustered(&engines), Share::new(30, 60));
    assert_eq!((clustered.hits, clustered.of), (30, 60));
    assert!(clustered.low < independent.low - 0.1 && clustered.high > independent.high + 0.1);
    // Korn & Graubard by hand: variance 6/5 · (16+16+9+9+25+25)/60² = 1/30, of independent runs
    // 1/240, t-quantiles 2.0010 of 59 and 2.5706 of 5 degrees of freedom; worth 60/8 · 0.6059 = 4.544.
    let by_hand = [0.0825, 0.9175];
    for (found, expected) in [clustered.low, clustered.high].into_iter().zip(by_hand) {
        assert!((found - expected).abs() < 5e-4, "{clustered:?}");
    }
    // None at all: nothing scatters.
    assert_eq!(Share::clustered(&[(0, 10), (0, 10)]), Share::new(0, 20));
}
