//! Mistakes of reading are told as such, and nothing else is.

use fd_effect::{EverySite, library};
use fd_gap::{
    diagnose::{Case, Diagnosis, Settings, Verdict, diagnose},
    reading::{Mistake, Reading, Suspicion, glance, suspect},
};
use fd_model::{Record, SampleTime};
use fd_sim::{model::Model, patch::Patch, scales::ReplayScales};

use crate::diagnosis::bench_cases::{Reality, example, expr, record};

const FEW: [&str; 7] = [
    "coulomb-friction",
    "viscous-friction",
    "input-delay",
    "input-gain",
    "sensor-scale",
    "sensor-bias",
    "input-dead-zone",
];

fn reality(amplitude: f64) -> Reality {
    Reality { samples: 500, amplitude, parameter_error: 0.02, colour: 0.0, seed: 6 }
}

fn diagnosis(model: &Model, log: &Record) -> Diagnosis {
    let u: Vec<f64> = (0..log.len()).flat_map(|k| log.u(k).to_vec()).collect();
    let scales = ReplayScales::of(model, log.ts(), &u, log.len()).unwrap();
    let effects = library().into_iter().filter(|e| FEW.contains(&e.label())).collect();
    let suspects = EverySite::new(effects, model, scales);
    let logs = std::slice::from_ref(log);
    let case = Case { nominal: model, suspects: &suspects, logs, held_out: &[] };
    diagnose(&case, &Settings::default(), &()).unwrap()
}

/// As a user's study does it.
fn reading(model: &Model, log: &Record) -> Option<Reading> {
    let as_read = diagnosis(model, log);
    let none: Vec<fd_effect::Candidate> = Vec::new();
    let logs = std::slice::from_ref(log);
    let case = Case { nominal: model, suspects: &none, logs, held_out: &[] };
    let found = suspect(&case, Settings::default().horizon, Some(&as_read)).unwrap();
    println!("{:?} as read, suspected: {found:?}", as_read.verdict);
    let reading = judged(&case, found?).map(|(reading, _)| reading);
    println!("{reading:?}");
    reading
}

/// A reading that is confirmed by the diagnosis of the mended log, with the verdict of that.
fn judged(case: &Case<'_>, suspicion: Suspicion) -> Option<(Reading, Verdict)> {
    let logs = suspicion.mended(case.logs).unwrap();
    let model = suspicion.mistake().mended_model(case.nominal.model()).unwrap();
    let mended = diagnosis(&model, &logs[0]);
    let case = Case { nominal: &model, logs: &logs, ..*case };
    Some((suspicion.judged(&case, &mended)?, mended.verdict))
}

/// The mistake that is believed before any cause was tried.
fn at_a_glance(model: &Model, log: &Record) -> Option<Mistake> {
    let none: Vec<fd_effect::Candidate> = Vec::new();
    let logs = std::slice::from_ref(log);
    let case = Case { nominal: model, suspects: &none, logs, held_out: &[] };
    let found = glance(&case, Settings::default().horizon).unwrap();
    let (reading, verdict) = judged(&case, found?)?;
    (verdict == Verdict::NoGap && 0.9 < reading.probability).then_some(reading.mistake)
}

/// A log with its rows changed.
fn changed(log: &Record, change: impl Fn(usize, &mut [f64], &mut [f64])) -> Record {
    let rows = (0..log.len()).map(|k| {
        let (mut u, mut y) = (log.u(k).to_vec(), log.y(k).to_vec());
        change(k, &mut u, &mut y);
        (u, y)
    });
    let (inputs, outputs) = (log.inputs().to_vec(), log.outputs().to_vec());
    Record::from_rows(inputs, outputs, rows, log.ts()).unwrap()
}

/// The reading, which must be nearly certain and be (or not be told from) this mistake.
#[track_caller]
fn assert_told(model: &Model, log: &Record, wanted: &Mistake) -> Reading {
    let found = reading(model, log).unwrap();
    assert!(0.9 < found.probability, "{found:?}");
    assert!(found.mistake == *wanted || found.also.contains(wanted), "{found:?}");
    found
}

#[test]
fn a_wrong_sign() {
    let model = example("dc_drive");
    let log = record(&model, reality(20.0), 1);
    // With one sensor of two there is no doubt whose sign it is.
    let wrong = changed(&log, |_, _, y| y[1] = -y[1]);
    let found = assert_told(&model, &wrong, &Mistake::sign("speed"));
    assert_eq!(found.mistake, Mistake::sign("speed"));
    assert_eq!(at_a_glance(&model, &wrong), Some(found.mistake));
    assert!(found.lines.contains("speed = {"), "{}", found.lines);
}

#[test]
fn rates_in_degrees() {
    let model = example("dc_drive");
    let log = record(&model, reality(20.0), 1);
    let degrees = 180.0 / std::f64::consts::PI;
    let wrong = changed(&log, |_, _, y| y[1] *= degrees);
    let found = assert_told(&model, &wrong, &Mistake::unit("speed", degrees));
    assert_eq!(found.statement, "`speed` were in deg/s, not rad/s");
    assert!(found.lines.contains("column_unit = \"deg/s\""), "{}", found.lines);
    // Errors are those of the numbers in the log: mended, they come down to the noise.
    let noise = model.outputs[1].noise.unwrap();
    assert!(found.after[1] < 1.2 * noise && 10.0 * noise < found.before[1]);
    assert_eq!(at_a_glance(&model, &wrong), Some(found.mistake));
}

/// Half a step too small is a bias of just that, unless one knows what drivers do to voltages.
#[test]
fn values_that_are_cut_off() {
    let mut draft = example("mass_spring_damper").into_draft();
    draft.outputs[0].noise = None;
    let model = Model::try_from(draft).unwrap();
    let log = record(&example("mass_spring_damper"), reality(10.0), 2);
    let cut = changed(&log, |_, _, y| y[0] = 0.004 * (y[0] / 0.004).floor());
    let found = reading(&model, &cut).unwrap();
    let Mistake::CutOff { channels, steps } = &found.mistake else { panic!("{found:?}") };
    assert_eq!(channels, &["position"]);
    // The grid is found again but for rounding.
    assert!((steps[0] - 0.004).abs() < 1e-12 && 0.9 < found.probability, "{found:?}");
    let rounded = changed(&log, |_, _, y| y[0] = 0.004 * (y[0] / 0.004).round());
    assert!(reading(&model, &rounded).is_none());
}

#[test]
fn an_input_in_millivolts() {
    let model = example("dc_drive");
    let log = record(&model, reality(20.0), 2);
    let wrong = changed(&log, |_, u, _| u[0] *= 1e3);
    assert_told(&model, &wrong, &Mistake::unit("u", 1e3));
}

#[test]
fn swapped_columns() {
    let model = example("dc_drive");
    let log = record(&model, reality(20.0), 1);
    let wrong = changed(&log, |_, _, y| y.swap(0, 1));
    let channels = [0, 1].map(|c| model.outputs[c].name.clone());
    assert_told(&model, &wrong, &Mistake::Swap { channels });
}

#[test]
fn a_clock_that_is_late_is_told_and_a_delay_is_not() {
    let model = example("dc_drive");
    let log = record(&model, reality(20.0), 3);
    let shifted = |by: isize| {
        let whole = changed(&log, |k, u, _| {
            u[0] = log.u(k.saturating_add_signed(by).min(log.len() - 1))[0];
        });
        whole.slice(20, log.len() - 20)
    };
    // The command is logged six samples late: the drive answers before it is asked.
    let found = reading(&model, &shifted(-6)).unwrap();
    let late = Mistake::Clock { channel: "u".into(), late: 6 };
    assert!(0.9 < found.probability && found.mistake == late, "{found:?}");
    // Logged early, it is a delay like any other.
    assert_eq!(reading(&model, &shifted(6)), None);
}

#[test]
fn a_wrong_unit_of_time() {
    let model = example("mass_spring_damper");
    let log = record(&model, reality(6.0), 1);
    let (u, y): (Vec<_>, Vec<_>) = log.samples().map(|(u, y)| (u[0], y.to_vec())).unzip();
    let ts = SampleTime::new(60.0 * log.ts().seconds()).unwrap();
    let (inputs, outputs) = (log.inputs().to_vec(), log.outputs().to_vec());
    let wrong = Record::new(inputs, outputs, u, y.concat(), ts).unwrap();
    assert_told(&model, &wrong, &Mistake::Time { factor: 60.0 });
    assert_eq!(at_a_glance(&model, &wrong), Some(Mistake::Time { factor: 60.0 }));
}

#[test]
fn a_coupling_in_another_unit() {
    let model = example("mass_spring_damper");
    let log = record(&model, reality(6.0), 1);
    let mut draft = model.into_draft();
    draft.parameters[1].value *= 9.806_65;
    draft.parameters[1].bounds = None;
    let name = draft.parameters[1].name.clone();
    let wrong = Model::try_from(draft).unwrap();
    assert_told(&wrong, &log, &Mistake::Parameter { name, factor: 9.806_65 });
}

#[test]
fn a_wrong_unit_beside_a_dead_zone() {
    let model = example("dc_drive");
    let mut patch = Patch::of(&model);
    patch.wrap_input("u", "applied", expr("u - clamp(u, -3, 3)")).unwrap();
    let log = record(&patch.finish().unwrap(), reality(20.0), 4);
    let degrees = 180.0 / std::f64::consts::PI;
    let wrong = changed(&log, |_, _, y| y[1] *= degrees);
    assert_told(&model, &wrong, &Mistake::unit("speed", degrees));
    // The dead zone is still to be found.
    assert_eq!(at_a_glance(&model, &wrong), None);
}

#[test]
fn nothing_wrong_and_honest_physics_are_no_misreadings() {
    let model = example("dc_drive");
    for seed in 0..3 {
        let log = record(&model, Reality { seed, ..reality(20.0) }, seed);
        assert_eq!(reading(&model, &log), None);
    }
    let truth = |change: &dyn Fn(&mut Patch)| {
        let mut patch = Patch::of(&model);
        change(&mut patch);
        record(&patch.finish().unwrap(), reality(20.0), 4)
    };
    let gain = truth(&|patch| patch.wrap_input("u", "applied", expr("1.5*u")).unwrap());
    assert_eq!(reading(&model, &gain), None);
    // Causes that leave errors of many times the noise.
    for law in ["1.5*u", "2.5*u", "0.3*u", "u - clamp(u, -3, 3)", "clamp(u, -4, 4)", "u + 8"] {
        let log = truth(&|patch| patch.wrap_input("u", "applied", expr(law)).unwrap());
        assert_eq!(at_a_glance(&model, &log), None, "{law}");
    }
    let dead =
        truth(&|patch| patch.wrap_input("u", "applied", expr("u - clamp(u, -3, 3)")).unwrap());
    assert_eq!(reading(&model, &dead), None);
    // An amplifier that delivers next to nothing: what is left is where the run begins.
    let weak = truth(&|patch| patch.wrap_input("u", "applied", expr("0.0002*u")).unwrap());
    assert_eq!(reading(&model, &weak), None);
}

/// The sign of a speed that counts by its square changes nothing; that the run began elsewhere does.
#[test]
fn a_sign_that_changes_nothing_is_no_mistake() {
    let model: Model = r#"
        version = 1
        kind = "equations"
        name = "pump"
        sample_time = 0.2
        parameters = { R = { unit = "s/m^3", value = 2.0, tolerance = 0.1 } }
        inputs = { n = { unit = "1/s" } }
        outputs = { flow = { unit = "m^3/s", value = "q" } }
        states = { q = { unit = "m^3/s", initial = 1.0, tolerance = 0.02, derivative = "n^2 - R*q" } }
        "#
    .parse()
    .unwrap();
    let noise = fd_model::signal::WhiteNoise::new(0.01, 5).values(600).unwrap();
    let mut q = 1.25;
    let rows = (0..600).map(|k| {
        let t = 0.2 * k as f64;
        let n = 1.4 + 0.3 * (0.4 * t).sin() + 0.2 * (0.09 * t).cos();
        let row = ([n], [q + noise[k]]);
        // Twenty Euler steps; the largest rate is 2/s.
        for _ in 0..20 {
            q += 0.01 * (n * n - 2.06 * q);
        }
        row
    });
    let rows: Vec<([f64; 1], [f64; 1])> = rows.collect();
    let (inputs, outputs) = (model.external_inputs(), model.output_channels());
    let log = Record::from_rows(inputs, outputs, rows, model.sample_time().unwrap()).unwrap();
    assert!(reading(&model, &log).is_none());
    assert_eq!(at_a_glance(&model, &log), None);
}

/// A furnace of which one sensor is in degrees Celsius under a header that says kelvin. A bias of -273 K explains the
/// log as well, but no honest sensor has it.
#[test]
fn degrees_celsius_under_a_header_of_kelvin() {
    let model: Model = r#"
version = 1
kind = "equations"
name = "furnace"
sample_time = 5.0
[parameters]
k = { unit = "W/K", value = 40.0, tolerance = 0.05 }
[inputs]
power = { unit = "W" }
[states]
element = { unit = "K", initial = 294.0, derivative = "(power - k*(element - charge))/8000" }
charge = { unit = "K", initial = 294.0, derivative = "(k*(element - charge) - 12*(charge - 294))/40000" }
[outputs]
T_element = { unit = "K", value = "element", noise = 1.0 }
T_charge = { unit = "K", value = "charge", noise = 0.5 }
"#
    .parse()
    .unwrap();
    let log = record(&model, reality(3000.0), 8);
    for (offset, is_told) in [(-273.15, true), (-40.0, false)] {
        let log = changed(&log, |_, _, y| y[1] += offset);
        let zero = Mistake::Zero { channel: "T_charge".to_owned(), offset: -273.15 };
        if is_told {
            assert_told(&model, &log, &zero);
        } else {
            assert!(reading(&model, &log).is_none());
        }
    }
}
