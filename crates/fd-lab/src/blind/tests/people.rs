//! Logs as people have them are what they are said to be.

use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Simulator},
};

use crate::blind::{
    conditions::Conditions,
    controller::Action,
    draw::draw,
    kind::CaseKind,
    logger::Logger,
    logs::Part,
    misreading::Misreading,
    simulate::Trial,
    truth::{Scene, Truth},
};

const SAMPLES: usize = 300;

fn drawn(kind: CaseKind, number: usize) -> (Truth, Model) {
    draw(5, kind, number, SAMPLES).unwrap()
}

/// Mean of products over the root of the product of mean squares.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
}

#[test]
fn noise_goes_round_a_loop_and_its_command_is_what_the_plant_saw() {
    for (kind, number) in
        [(CaseKind::LoopNone, 0), (CaseKind::LoopNone, 2), (CaseKind::UnstableNone, 0)]
    {
        let (truth, model) = drawn(kind, number);
        let scene = Scene::new(&truth, &model).unwrap();
        let x0 = scene.initial(0);
        let run = |noisy| scene.trace(&[], &truth.parameters, &x0, 0, noisy).unwrap().unwrap();
        let (noisy, still) = (run(true), run(false));
        let controller = truth.conditions.controller.as_ref().unwrap();
        let (nu, ny) = (model.inputs.len(), model.outputs.len());
        let column = |values: &[f64], i: usize, n: usize| -> Vec<f64> {
            values.iter().skip(i).step_by(n).copied().collect()
        };
        let minus = |a: Vec<f64>, b: Vec<f64>| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| a - b).collect()
        };
        let (i, c) = (controller.input, controller.output);
        let moved = minus(column(&noisy.commands, i, nu), column(&still.commands, i, nu));
        let noise = minus(column(&noisy.y, c, ny), column(&noisy.clean, c, ny));
        assert!(moved.iter().any(|m| 0.0 < m.abs()), "{controller:?}");
        if matches!(controller.action, Action::Proportional | Action::Pid | Action::StateFeedback) {
            // White noise and an open loop would give less than 4/√300 = 0.23.
            let found = correlation(&moved, &noise);
            assert!(0.23 < -found * controller.gain.signum(), "{found} {controller:?}");
        }
        // The same commands in the open loop move the plant along the same way, unless it is one
        // on which rounding grows.
        let (parameters, u) = (&truth.parameters, &noisy.commands);
        let replay = Trial { parameters, x0: &x0, u, noise: None, controller: None };
        let replay = scene.bench.run(&replay, vec![], None).unwrap().unwrap();
        for (a, b) in replay.clean.iter().zip(&noisy.clean).take(60 * ny) {
            assert!((a - b).abs() <= 1e-6 * (1.0 + b.abs()), "{a} {b}");
        }
        let log = scene.log(0, true).unwrap().unwrap();
        assert_eq!(log.input(i).collect::<Vec<_>>(), column(&noisy.commands, i, nu));
    }
}

#[test]
fn the_model_with_the_controller_is_the_loop() {
    let mut seen = Vec::new();
    for number in 0..12 {
        let (truth, model) = drawn(CaseKind::LoopNone, number);
        let controller = truth.conditions.controller.clone().unwrap();
        if seen.contains(&controller.action) {
            continue;
        }
        seen.push(controller.action);
        let Some(closed) = controller.in_model(&model).unwrap() else {
            assert_eq!(controller.action, Action::Human);
            continue;
        };
        let scene = Scene::new(&truth, &model).unwrap();
        let x0 = scene.initial(0);
        let own = scene.trace(&[], &truth.parameters, &x0, 0, false).unwrap().unwrap();
        let mut simulator = EquationSimulator::<f64>::new(&closed).unwrap();
        let mut all_x0 = closed.initial();
        all_x0[..x0.len()].copy_from_slice(&x0);
        // References come after the inputs that nothing drives.
        let (u, nu, i) = (scene.excitation(0), model.inputs.len(), controller.input);
        let row = |row: &[f64]| {
            let free = row.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, v)| *v);
            free.chain([row[i]]).collect::<Vec<f64>>()
        };
        let u: Vec<f64> = u.chunks_exact(nu).flat_map(row).collect();
        let ny = closed.outputs.len();
        let mut theirs = vec![0.0; SAMPLES * ny];
        let _ = Simulator::simulate(&mut simulator, &truth.parameters, &all_x0, &u, &mut theirs);
        if controller.action == Action::BangBang {
            // A switch a hair later is another run; until then it is the same.
            continue;
        }
        for k in 0..SAMPLES {
            let (row, commands) = (&theirs[k * ny..], &own.commands[k * nu..]);
            for (c, output) in model.outputs.iter().enumerate() {
                let d = (row[c] - own.clean[k * (ny - 1) + c]).abs();
                // As for the plants themselves: both integrate with order 4.
                assert!(d < 0.05 * output.noise.unwrap(), "{controller:?} at {k}: {d}");
            }
            let d = (row[ny - 1] - commands[i]).abs();
            assert!(d < 0.02 * controller.limit, "{controller:?} at {k}: {d}");
        }
    }
    assert!(2 < seen.len(), "{seen:?}");
}

#[test]
fn a_cut_goes_on_exactly_and_a_log_in_motion_is_a_part_of_a_run() {
    let (truth, model) = drawn(CaseKind::Cut, 0);
    let scene = Scene::new(&truth, &model).unwrap();
    let part = |part| scene.log_of(0, part, true).unwrap().unwrap().record;
    let (first, second) = (part(Part::First), part(Part::Second));
    assert!(second.continues(&first));
    let whole = Truth { samples: 2 * SAMPLES, conditions: Conditions::default(), ..truth.clone() };
    let whole = Scene::new(&whole, &model).unwrap().log(0, true).unwrap().unwrap();
    assert_eq!(first, whole.slice(0, SAMPLES));
    assert_eq!(second, whole.slice(SAMPLES, 2 * SAMPLES).as_its_own_run());

    let conditions = Conditions { before: 100, ..Conditions::default() };
    let later = Truth { samples: SAMPLES - 100, conditions, ..truth.clone() };
    let later = Scene::new(&later, &model).unwrap().log_of(0, Part::First, true).unwrap().unwrap();
    let plain = Truth { conditions: Conditions::default(), ..truth.clone() };
    let plain = Scene::new(&plain, &model).unwrap().log(0, true).unwrap().unwrap();
    assert_eq!(later.record, plain.slice(100, SAMPLES).starting_at(0.0).as_its_own_run());
    assert_eq!(later.is_kept.len(), SAMPLES - 100);
}

#[test]
fn a_logger_rounds_clips_and_loses() {
    let logger = Logger {
        steps: vec![0.25, 0.0],
        ranges: vec![None, Some([-0.5, 0.5])],
        missing: 0.1,
        lost: 0.2,
        seed: 4,
        ..Logger::default()
    };
    let n = 4000;
    let signal = |k: usize| (0.01 * k as f64).sin();
    let y: Vec<f64> = (0..n).flat_map(|k| [signal(k), signal(k)]).collect();
    let u: Vec<f64> = (0..n).map(|k| if k % 40 < 20 { 0.0 } else { 1.0 }).collect();
    let blurred = logger.log(&y, &u, 2, 0, true);
    let sharp = logger.log(&y, &u, 2, 0, false);
    for k in 0..n {
        let [a, b] = [blurred.y[2 * k], blurred.y[2 * k + 1]];
        assert!(a.is_nan() || (4.0 * a - (4.0 * a).round()).abs() < 1e-12);
        assert!(b.is_nan() || b.abs() <= 0.5);
        let s = sharp.y[2 * k + 1];
        assert!(s.is_nan() || (s - signal(k)).abs() < 1e-15 && s.abs() <= 0.5);
        // A lost row is one in which no input moved.
        assert!(blurred.is_kept[k] || u[k].to_bits() == u[k - 1].to_bits());
    }
    let missing = blurred.y.iter().filter(|y| y.is_nan()).count() as f64 / (2 * n) as f64;
    // Some 120 bursts of about six: two standard deviations are a quarter.
    assert!((0.05..0.16).contains(&missing), "{missing}");
    let lost = blurred.is_kept.iter().filter(|kept| !**kept).count() as f64 / n as f64;
    assert!((0.1..0.2).contains(&lost), "{lost}");
    assert!(logger.labels(0).is_empty());
    assert_eq!(logger.labels(1), ["sensor-saturation"]);
    // A step of one has a variance of 1/12.
    assert!(
        (Logger { steps: vec![1.0], ..logger }.noise(0, 0.0).powi(2) - 1.0 / 12.0).abs() < 1e-15
    );
}

#[test]
fn misreadings_are_what_they_are_called() {
    let (truth, model) = drawn(CaseKind::CutNone, 1);
    let truth = Truth { conditions: Conditions::default(), ..truth };
    let (input, output) = (model.inputs[0].name.clone(), model.outputs[0].name.clone());
    let read = |misreading: Misreading| {
        let conditions = Conditions { misreading: Some(misreading), ..Conditions::default() };
        let truth = Truth { conditions, ..truth.clone() };
        Scene::new(&truth, &model).unwrap().log(0, true).unwrap().unwrap()
    };
    let right = Scene::new(&truth, &model).unwrap().log(0, true).unwrap().unwrap();
    let signed = read(Misreading::Sign { channel: output.clone() });
    assert!(signed.output(0).zip(right.output(0)).all(|(a, b)| a.to_bits() == (-b).to_bits()));
    assert_eq!(signed.input(0).collect::<Vec<_>>(), right.input(0).collect::<Vec<_>>());
    let scaled = read(Misreading::Unit { channel: input.clone(), factor: 1e3 });
    assert!(scaled.input(0).zip(right.input(0)).all(|(a, b)| (a - 1e3 * b).abs() < 1e-9));
    // A command that is logged late: the plant answers before it.
    let late = read(Misreading::Clock { channel: input, late: 4 });
    let longer = Truth { samples: SAMPLES + 8, ..truth.clone() };
    let longer = Scene::new(&longer, &model).unwrap().log(0, true).unwrap().unwrap();
    assert_eq!(late.len(), SAMPLES);
    for k in 0..SAMPLES {
        assert_eq!(late.u(k)[0].to_bits(), longer.u(k)[0].to_bits());
        assert_eq!(late.y(k)[0].to_bits(), longer.y(k + 4)[0].to_bits());
    }
    // Ten times too slow: one sample of ten, each of which lasts as long as all ten.
    let slow = read(Misreading::Time { factor: 10 });
    assert_eq!((slow.len(), slow.ts()), (SAMPLES, right.ts()));
    assert_eq!(slow.input(0).collect::<Vec<_>>(), right.input(0).collect::<Vec<_>>());
    assert_ne!(slow.output(0).collect::<Vec<_>>(), right.output(0).collect::<Vec<_>>());
}

#[test]
fn every_kind_can_be_drawn_and_its_effects_are_its_own() {
    for kind in CaseKind::ALL.into_iter().filter(|kind| !kind.is_plain()) {
        let (truth, model) = drawn(kind, 0);
        assert_eq!(truth.effects.len(), kind.effects(), "{kind:?}");
        assert!(truth.effects.iter().all(|effect| effect.origin == kind.origin()));
        assert!(truth.effects.iter().all(|effect| 9.0 <= effect.distance));
        assert_eq!(truth.conditions.controller.is_some(), kind.is_looped());
        // What is sealed is what is opened.
        let text = serde_json::to_string(&truth).unwrap();
        assert_eq!(serde_json::from_str::<Truth>(&text).unwrap(), truth);
        if kind == CaseKind::Dominant {
            let [first, others @ ..] = &truth.effects[..] else { panic!("four effects") };
            assert!(others.iter().all(|other| 5.0 * other.distance < first.distance));
        }
        if kind == CaseKind::Inside {
            let site = &truth.effects[0].site;
            assert!(model.definitions.iter().any(|definition| definition.name == *site));
        }
    }
}
