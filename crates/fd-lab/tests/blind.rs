//! A small blind test from end to end, and scores of answers whose result is known.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::{collections::BTreeMap, fs, path::Path};

use fd_lab::blind::{
    Answer, BlindError, CaseKind, Effect, Named, Oracle, Order, Origin, Place, SealKey, Shape,
    Truth, make, read_answers, run, score, score_open,
};

const SAMPLES: usize = 200;

fn order(seed: u64) -> Order {
    let counts = vec![(CaseKind::Single, 2), (CaseKind::None, 1), (CaseKind::Pair, 1)];
    Order { seed, counts, samples: SAMPLES, full_oracle: false }
}

fn key() -> SealKey {
    SealKey::parse(&"5a".repeat(32)).unwrap()
}

/// All files below a directory with their contents.
fn files(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut open = vec![directory.to_owned()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(directory).unwrap().display().to_string();
                all.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    all
}

#[test]
fn the_same_seed_makes_the_same_cases_and_another_makes_others() {
    let room = tempfile::tempdir().unwrap();
    let made = |name: &str, seed| {
        let (out, truth) = (room.path().join(name), room.path().join(format!("{name}-truth")));
        make(&order(seed), &out, &truth, &key(), || ()).unwrap();
        (files(&out), files(&truth))
    };
    let (a, b, c) = (made("a", 7), made("b", 7), made("c", 8));
    assert_eq!(a, b);
    assert_ne!(a.0, c.0);
    // Model, two logs and a commitment, four times; nothing of the truth.
    assert_eq!(a.0.len(), 16);
    let says = |bytes: &[u8]| String::from_utf8_lossy(bytes).contains("effects");
    assert!(!a.0.values().chain(a.1.values()).any(|bytes| says(bytes)));
}

#[test]
fn a_test_runs_resumes_and_notices_a_changed_truth() {
    let room = tempfile::tempdir().unwrap();
    let (out, truth) = (room.path().join("cases"), room.path().join("truth"));
    let made = make(&order(11), &out, &truth, &key(), || ()).unwrap();
    assert_eq!(made.len(), 4);
    assert!(matches!(
        make(&order(11), &out, &truth, &key(), || ()),
        Err(BlindError::Exists { .. })
    ));
    // Half a line is what a killed run leaves.
    fs::write(out.join("answers.jsonl"), "{\"case\":\"case-00").unwrap();
    run(&out, true, || ()).unwrap();
    let answers = read_answers(&out.join("answers.jsonl")).unwrap();
    assert_eq!(answers.len(), 4);
    assert!(answers.iter().all(|answer| answer.error.is_none()), "{answers:?}");
    assert!(answers.iter().all(|answer| answer.baselines.is_some()));
    let before = fs::read(out.join("answers.jsonl")).unwrap();
    run(&out, true, || ()).unwrap();
    assert_eq!(fs::read(out.join("answers.jsonl")).unwrap(), before, "nothing is left to do");

    let result = score(&out, &truth, || ()).unwrap();
    assert_eq!((result.cases, result.unanswered, result.failed), (4, 0, 0));
    assert_eq!(result.invisible.of, 2);
    assert!(result.markdown().contains("| two effects: exact pair |"));

    let file = truth.join("case-0001.sealed");
    let mut sealed = fs::read(&file).unwrap();
    let last = sealed.len() - 1;
    sealed[last] ^= 1;
    fs::write(&file, sealed).unwrap();
    let broken = score(&out, &truth, || ());
    assert!(matches!(broken, Err(BlindError::Broken { case }) if case == "case-0001"));
}

#[test]
fn the_truth_must_not_lie_among_the_cases() {
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("cases");
    let inside = out.join("cases").join("truth");
    let refused = make(&order(1), &out, &inside, &key(), || ());
    assert!(matches!(refused, Err(BlindError::TruthBeside { .. })));
}

#[test]
fn a_seal_opens_with_its_key_only() {
    let (key, other) = (key(), SealKey::random().unwrap());
    let (sealed, commitment) = key.seal("case-0001", "the truth");
    assert_eq!(key.open("case-0001", &sealed, &commitment).unwrap(), "the truth");
    assert!(other.open("case-0001", &sealed, &commitment).is_err());
    assert!(key.open("case-0002", &sealed, &commitment).is_err());
    assert!(!sealed.windows(5).any(|part| part == b"truth"));
}

fn truth(kind: CaseKind, effects: &[(&str, &str, &str)], nothing: f64) -> Truth {
    let effect = |(label, family, site): &(&str, &str, &str)| Effect {
        label: (*label).to_owned(),
        law: "law".to_owned(),
        family: (*family).to_owned(),
        origin: Origin::Matched,
        place: Place::Force,
        site: (*site).to_owned(),
        index: 0,
        partner: None,
        partner_index: 0,
        strength: 1.0,
        shape: [0.0; 3],
        seed: 0,
        distance: nothing,
    };
    Truth {
        case: "c".to_owned(),
        kind,
        plant: "pendulum".to_owned(),
        excitation: Shape::Prbs,
        samples: 100,
        coloured: false,
        noise_factor: 1.0,
        seed: 0,
        parameters: vec![],
        effects: effects.iter().map(effect).collect(),
        oracle: Some(Oracle { nothing, ..Oracle::default() }),
    }
}

fn answer(no_gap: f64, causes: &[(&str, &str, &str, f64)]) -> Answer {
    let named = |(label, family, site, probability): &(&str, &str, &str, f64)| Named {
        label: (*label).to_owned(),
        law: "law".to_owned(),
        family: (*family).to_owned(),
        side: if label.starts_with("sensor") { "output" } else { "dynamics" }.to_owned(),
        site: (*site).to_owned(),
        partner: None,
        probability: *probability,
    };
    let causes = causes.iter().map(named).collect();
    let (case, verdict) = ("c".to_owned(), "cause".to_owned());
    Answer { case, verdict, no_gap, causes, tied: vec![0], ..Answer::default() }
}

#[test]
fn known_answers_have_known_scores() {
    let dry = ("coulomb-friction", "friction", "joint");
    let pairs = vec![
        // Right; right mechanism only; wrong; blamed on nothing; invisible.
        (
            truth(CaseKind::Single, &[dry], 100.0),
            answer(0.0, &[("coulomb-friction", "friction", "joint", 0.95)]),
        ),
        (
            truth(CaseKind::Single, &[dry], 100.0),
            answer(0.0, &[("drag", "friction", "joint", 0.85), dry_with(0.1)]),
        ),
        (
            truth(CaseKind::Single, &[dry], 100.0),
            answer(0.0, &[("sensor-bias", "sensor-offset", "angle", 0.95)]),
        ),
        (truth(CaseKind::Single, &[dry], 100.0), answer(0.9, &[dry_with(0.05)])),
        (truth(CaseKind::Single, &[dry], 3.0), answer(0.9, &[])),
        // No gap: not blamed, blamed.
        (truth(CaseKind::None, &[], 0.0), answer(0.9, &[dry_with(0.1)])),
        (truth(CaseKind::None, &[], 0.0), answer(0.2, &[dry_with(0.8)])),
        // Two effects: both, one.
        (
            truth(CaseKind::Pair, &[dry, ("constant-load", "load", "joint")], 100.0),
            Answer {
                together: answer(0.0, &[dry_with(0.9), ("constant-load", "load", "joint", 0.9)])
                    .causes,
                ..answer(0.0, &[dry_with(0.9)])
            },
        ),
        (
            truth(CaseKind::Pair, &[dry, ("constant-load", "load", "joint")], 100.0),
            answer(0.0, &[dry_with(0.9)]),
        ),
    ];
    let score = score_open(&pairs).unwrap();
    assert_eq!((score.top.hits, score.top.of), (1, 4));
    assert_eq!((score.place[0].hits, score.place[1].hits), (2, 2));
    assert_eq!((score.invisible.hits, score.invisible.of), (1, 5));
    assert_eq!((score.blamed[0].hits, score.blamed[0].of), (1, 2));
    // Both answers above 0.9 that stand alone, of which one is right.
    assert_eq!((score.sure[0].hits, score.sure[1].hits), (2, 1));
    assert_eq!(score.pairs.map(|rate| rate.hits), [1, 1, 2, 0]);
    // Groups: stated .95, .95 (.85 + .1) and .95; two of three are right.
    let expected = 0.95 - 2.0 / 3.0;
    assert!((score.group[0].error - expected).abs() < 1e-12, "{}", score.group[0].error);
}

fn dry_with(probability: f64) -> (&'static str, &'static str, &'static str, f64) {
    ("coulomb-friction", "friction", "joint", probability)
}
