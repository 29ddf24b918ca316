//! A small blind test from end to end, and scores of answers whose result is known.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::{collections::BTreeMap, fs, path::Path};

use fd_lab::blind::{
    Answer, BlindError, CaseKind, Conditions, Effect, Feature, Manner, Misreading, Named, Oracle,
    Order, Origin, Place, Reading, SealKey, Shape, Truth, Variant, make, read_answers, run, score,
    score_open,
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
        let mut order = order(seed);
        order.counts.extend([(CaseKind::Loop, 1), (CaseKind::Cut, 1), (CaseKind::Misread, 1)]);
        let (out, truth) = (room.path().join(name), room.path().join(format!("{name}-truth")));
        make(&order, &out, &truth, &key(), &()).unwrap();
        (files(&out), files(&truth))
    };
    // The loops of these seeds have a controller that can be written as a model.
    let (a, b, c) = (made("a", 13), made("b", 13), made("c", 14));
    assert_eq!(a, b);
    assert_ne!(a.0, c.0);
    // Model, two logs and a commitment, four times; then a model with the controller as well, two
    // more logs from rest, and a log that is read wrongly; nothing of the truth.
    assert_eq!(a.0.len(), 16 + 5 + 6 + 4);
    let says = |bytes: &[u8]| String::from_utf8_lossy(bytes).contains("effects");
    assert!(!a.0.values().chain(a.1.values()).any(|bytes| says(bytes)));
}

#[test]
fn a_test_runs_resumes_and_notices_a_changed_truth() {
    let room = tempfile::tempdir().unwrap();
    let (out, truth) = (room.path().join("cases"), room.path().join("truth"));
    let made = make(&order(11), &out, &truth, &key(), &()).unwrap();
    assert_eq!(made.len(), 4);
    assert!(matches!(make(&order(11), &out, &truth, &key(), &()), Err(BlindError::Exists { .. })));
    // Half a line is what a killed run leaves.
    fs::write(out.join("answers.jsonl"), "{\"case\":\"case-00").unwrap();
    run(&out, &Manner::default(), &()).unwrap();
    let answers = read_answers(&out.join("answers.jsonl")).unwrap();
    assert_eq!(answers.len(), 4);
    assert!(answers.iter().all(|answer| answer.error.is_none()), "{answers:?}");
    assert!(answers.iter().all(|answer| answer.baselines.is_some()));
    let before = fs::read(out.join("answers.jsonl")).unwrap();
    run(&out, &Manner::default(), &()).unwrap();
    assert_eq!(fs::read(out.join("answers.jsonl")).unwrap(), before, "nothing is left to do");

    let result = score(&out, &truth, Variant::AsLogged, None, &()).unwrap();
    assert_eq!((result.cases, result.unanswered, result.failed), (4, 0, 0));
    assert_eq!(result.invisible.of, 2);
    assert!(result.markdown().contains("| two effects: exact pair |"));

    let file = truth.join("case-0001.sealed");
    let mut sealed = fs::read(&file).unwrap();
    let last = sealed.len() - 1;
    sealed[last] ^= 1;
    fs::write(&file, sealed).unwrap();
    let broken = score(&out, &truth, Variant::AsLogged, None, &());
    assert!(matches!(broken, Err(BlindError::Broken { case }) if case == "case-0001"));
}

#[test]
fn the_truth_must_not_lie_among_the_cases() {
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("cases");
    let inside = out.join("cases").join("truth");
    let refused = make(&order(1), &out, &inside, &key(), &());
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
        conditions: Conditions::default(),
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

#[test]
fn a_known_controller_and_runs_from_rest_have_answers_of_their_own() {
    let room = tempfile::tempdir().unwrap();
    let (out, truth) = (room.path().join("cases"), room.path().join("truth"));
    let counts = vec![(CaseKind::Loop, 1), (CaseKind::Cut, 1), (CaseKind::CutNone, 1)];
    // The controller of this seed is one that can be written as a model.
    let order = Order { seed: 13, counts, samples: SAMPLES, full_oracle: false };
    make(&order, &out, &truth, &key(), &()).unwrap();
    for variant in [Variant::AsLogged, Variant::KnownController, Variant::FromRest] {
        let manner = Manner { variant, with_baselines: false, ..Manner::default() };
        run(&out, &manner, &()).unwrap();
    }
    let answers = |file: &str| read_answers(&out.join(file)).unwrap();
    let all = answers("answers.jsonl");
    assert_eq!(all.len(), 3);
    assert!(all.iter().all(|answer| answer.error.is_none()), "{all:?}");
    let (known, rest) =
        (answers("answers_known_controller.jsonl"), answers("answers_from_rest.jsonl"));
    assert_eq!((known.len(), rest.len()), (1, 2));
    assert!(known.iter().chain(&rest).all(|answer| answer.error.is_none()), "{known:?}");
    let result = score(&out, &truth, Variant::AsLogged, None, &()).unwrap();
    let names: Vec<&str> = result.classes.iter().map(|class| class.name.as_str()).collect();
    assert_eq!(names, ["loop", "cut"]);
    assert_eq!(result.classes[1].comparison.as_ref().unwrap().blamed.of, 1);
    assert!(result.markdown().contains("## One run cut in two"));
}

/// A log in other units, told as such by the method, and named as a gain by one that does not ask for them.
#[test]
fn what_is_left_out_of_the_method_is_missed() {
    let room = tempfile::tempdir().unwrap();
    let (out, truth) = (room.path().join("cases"), room.path().join("truth"));
    let order = Order {
        seed: 14,
        counts: vec![(CaseKind::Misread, 1)],
        samples: SAMPLES,
        full_oracle: false,
    };
    make(&order, &out, &truth, &key(), &()).unwrap();
    let told = |without: Option<Feature>, file: &str| {
        let manner = Manner { without, with_baselines: false, ..Manner::default() };
        run(&out, &manner, &()).unwrap();
        let answers = read_answers(&out.join(file)).unwrap();
        assert!(answers.iter().all(|answer| answer.error.is_none()), "{answers:?}");
        let result = score(&out, &truth, Variant::AsLogged, without, &()).unwrap();
        (answers[0].reading.len(), result.classes[0].reading[0].hits)
    };
    let (readings, hits) = told(None, "answers.jsonl");
    assert!(0 < readings && hits == 1, "{readings} {hits}");
    assert_eq!(told(Some(Feature::Readings), "answers_without_readings.jsonl"), (0, 0));
}

#[test]
fn known_answers_to_logs_as_people_have_them_have_known_scores() {
    let dry = ("coulomb-friction", "friction", "joint");
    let load = ("constant-load", "load", "joint");
    let bias = ("sensor-bias", "sensor-offset", "angle");
    let gain = ("input-gain", "actuator-gain", "tau");
    let four = truth(CaseKind::Dominant, &[dry, load, bias, gain], 1e4);
    let listed = |all: &[(&str, &str, &str)]| {
        let with: Vec<_> = all.iter().map(|(a, b, c)| (*a, *b, *c, 0.9)).collect();
        Answer { together: answer(0.0, &with).causes, ..answer(0.0, &with[..1]) }
    };
    let misread = || {
        let mut truth = truth(CaseKind::Misread, &[], 1e6);
        let channel = "angle".to_owned();
        truth.conditions.misreading = Some(Misreading::Unit { channel, factor: 57.3 });
        truth
    };
    let reading = |factor: f64, probability: f64| Reading {
        kind: "unit".to_owned(),
        channels: vec!["angle".to_owned()],
        factor: Some(factor),
        probability,
        ..Reading::default()
    };
    let read =
        |reading: Reading| Answer { reading: vec![reading], ..answer(0.0, &[dry_with(0.9)]) };
    let says_none = Answer { says_none: true, ..answer(0.0, &[dry_with(0.95)]) };
    let pairs = vec![
        // A loop: right and sure; wrong and sure; falsely none of these.
        (truth(CaseKind::Loop, &[dry], 100.0), answer(0.0, &[dry_with(0.95)])),
        (truth(CaseKind::Loop, &[load], 100.0), answer(0.0, &[dry_with(0.95)])),
        (truth(CaseKind::Loop, &[dry], 100.0), says_none.clone()),
        (truth(CaseKind::LoopNone, &[], 0.0), answer(0.1, &[dry_with(0.8)])),
        (truth(CaseKind::LoopNone, &[], 0.0), answer(0.9, &[])),
        // Four effects: all in any order but the largest first; the largest alone; a small one first.
        (four.clone(), listed(&[dry, gain, bias, load])),
        (four.clone(), answer(0.0, &[dry_with(0.9)])),
        (four, listed(&[load, dry])),
        // A wrong unit: told; told too unsurely and by another factor; taken for friction.
        (misread(), read(reading(57.3, 0.99))),
        (misread(), read(reading(9.81, 0.99))),
        (misread(), read(reading(57.3, 0.3))),
        (misread(), answer(0.0, &[dry_with(0.95)])),
        (misread(), says_none),
    ];
    let score = score_open(&pairs).unwrap();
    let class = |name: &str| score.classes.iter().find(|class| class.name == name).unwrap();
    let counts = |rate: fd_lab::blind::Rate| (rate.hits, rate.of);
    let looped = class("loop");
    assert_eq!(counts(looped.right), (2, 3));
    assert_eq!(counts(looped.sure), (1, 2));
    assert_eq!(counts(looped.falsely_none), (1, 3));
    assert_eq!(looped.blamed.map(counts), [(1, 2), (0, 0)]);
    assert_eq!(class("dominant").list.map(counts), [(2, 3), (1, 3), (0, 0)]);
    // What each is worth beside the others needs the case; that what is named is there does not.
    assert_eq!(class("dominant").of_several.map(counts), [(0, 0), (7, 7)]);
    assert_eq!(class("misread").reading.map(counts), [(1, 5), (2, 5)]);
    // Nothing of it is among the first kinds.
    assert_eq!((score.top.of, score.cases), (0, 13));
}
