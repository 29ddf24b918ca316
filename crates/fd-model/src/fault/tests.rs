//! Laws of the faults: identities, onsets, patterns.

use proptest::prelude::*;

use super::*;
use crate::Channel;

fn ts(seconds: f64) -> SampleTime {
    SampleTime::new(seconds).unwrap()
}

fn applied(fault: &FaultSpec, values: &[f64]) -> Vec<f64> {
    let mut values = values.to_vec();
    fault.apply(&mut values, 0.0, ts(0.1)).unwrap();
    values
}

fn on_sensor(start_s: f64, effect: Effect) -> FaultSpec {
    FaultSpec::new(Site::sensor(0), start_s, effect)
}

fn any_profile() -> impl Strategy<Value = fn(f64) -> FaultProfile> {
    prop_oneof![
        Just(FaultProfile::abrupt as fn(f64) -> FaultProfile),
        Just((|size| FaultProfile::incipient(size, 2.0)) as fn(f64) -> FaultProfile),
        Just(FaultProfile::drift as fn(f64) -> FaultProfile),
        Just((|size| FaultProfile::intermittent(size, 0.7, 0.3)) as fn(f64) -> FaultProfile),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn faults_of_size_zero_are_the_identity(
        values in proptest::collection::vec(-1e3..1e3_f64, 0..50),
        start_s in 0.0..3.0_f64,
        profile in any_profile(),
    ) {
        for effect in [Effect::Add(profile(0.0)), Effect::Multiply(profile(0.0)), Effect::Scale(1.0)] {
            prop_assert_eq!(&applied(&on_sensor(start_s, effect), &values), &values);
        }
    }

    #[test]
    fn nothing_happens_outside_the_window(
        values in proptest::collection::vec(1.0..2.0_f64, 30),
        from in 0_u8..30,
        length in 0_u8..30,
        profile in any_profile(),
    ) {
        let mut fault = on_sensor(f64::from(from) * 0.1, Effect::Add(profile(5.0)));
        fault.end_s = Some(f64::from(from + length) * 0.1);
        let faulty = applied(&fault, &values);
        let window = usize::from(from)..usize::from(from + length);
        for k in (0..30).filter(|k| !window.contains(k)) {
            prop_assert_eq!(faulty[k].to_bits(), values[k].to_bits());
        }
    }

    #[test]
    fn an_intermittent_fault_is_on_for_its_duty(
        seed in proptest::option::of(any::<u64>()),
        on in 1_u8..10,
    ) {
        // Ten samples per period: a random place shifts the onset by less than one sample, so
        // the count in a period is right to one.
        let duty = f64::from(on) / 10.0;
        let profile = FaultProfile::Intermittent { size: 1.0, period_s: 1.0, duty, seed };
        let f = applied(&on_sensor(0.0, Effect::Add(profile)), &[0.0; 400]);
        for period in f.chunks(10) {
            let count = period.iter().sum::<f64>();
            prop_assert!((count - f64::from(on)).abs() <= f64::from(u8::from(seed.is_some())));
        }
    }
}

#[test]
fn profiles_take_their_shapes() {
    let zeros = [0.0; 6];
    let shape = |profile| applied(&on_sensor(0.2, Effect::Add(profile)), &zeros);
    assert_eq!(shape(FaultProfile::abrupt(2.0)), [0.0, 0.0, 2.0, 2.0, 2.0, 2.0]);
    let near = |found: Vec<f64>, expected: [f64; 6]| {
        // Times are good to an ulp of 0.5 s, sizes here are below 2.
        found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-15)
    };
    assert!(near(shape(FaultProfile::incipient(2.0, 0.2)), [0.0, 0.0, 0.0, 1.0, 2.0, 2.0]));
    assert!(near(shape(FaultProfile::drift(10.0)), [0.0, 0.0, 0.0, 1.0, 2.0, 3.0]));
    assert_eq!(shape(FaultProfile::intermittent(1.0, 0.2, 0.5)), [0.0, 0.0, 1.0, 0.0, 1.0, 0.0]);
    assert_eq!(shape(FaultProfile::incipient(2.0, 0.0)), shape(FaultProfile::abrupt(2.0)));
}

#[test]
fn stuck_sensors_and_scaled_sensors() {
    let values = [1.0, 2.0, 3.0, f64::NAN, 5.0];
    let last = applied(&on_sensor(0.2, Effect::StuckLast), &values);
    assert_eq!(last[..3], [1.0, 2.0, 2.0]);
    assert!(last[3].is_nan(), "a missing sample stays missing");
    assert_eq!(last[4].to_bits(), 2.0_f64.to_bits());
    assert_eq!(applied(&on_sensor(0.1, Effect::StuckAt(9.0)), &values)[..3], [1.0, 9.0, 9.0]);
    assert_eq!(applied(&on_sensor(0.1, Effect::Scale(0.5)), &values)[..3], [1.0, 1.0, 1.5]);
    // Nothing came before: the first value is the last.
    assert_eq!(applied(&on_sensor(0.0, Effect::StuckLast), &values)[..3], [1.0, 1.0, 1.0]);
}

#[test]
fn random_patterns_do_not_depend_on_the_sample_time() {
    let profile = FaultProfile::Intermittent { size: 1.0, period_s: 1.0, duty: 0.5, seed: Some(4) };
    let fault = on_sensor(0.0, Effect::Add(profile));
    let (mut coarse, mut fine) = ([0.0; 50], [0.0; 500]);
    fault.apply(&mut coarse, 0.0, ts(0.1)).unwrap();
    fault.apply(&mut fine, 0.0, ts(0.01)).unwrap();
    let thinned: Vec<f64> = fine.iter().copied().step_by(10).collect();
    assert_eq!(thinned, coarse);
}

#[test]
fn only_sensor_faults_act_on_records_and_unknown_sensors_are_named() {
    let outputs = vec![Channel::new("T_7", "K"), Channel::new("P_6", "kPa")];
    let mut record =
        Record::new(vec![], outputs, vec![], vec![1.0; 8], ts(1.0)).unwrap().starting_at(100.0);
    let fault = FaultSpec::add(Site::sensor("P_6"), 102.0, FaultProfile::abrupt(1.0));
    fault.apply_to_record(&mut record).unwrap();
    assert_eq!(record.output(1).collect::<Vec<_>>(), [1.0, 1.0, 2.0, 2.0]);
    assert_eq!(record.output(0).collect::<Vec<_>>(), [1.0; 4]);

    let mut error = |site| {
        let fault = FaultSpec::add(site, 0.0, FaultProfile::abrupt(1.0));
        fault.apply_to_record(&mut record).unwrap_err().to_string()
    };
    assert_eq!(
        error(Site::sensor("T7")),
        "fault: there is no sensor `T7`, only [\"T_7\", \"P_6\"]"
    );
    assert_eq!(error(Site::sensor(2)), "fault: there is no sensor 2, there are 2, counted from 0");
    assert!(error(Site::actuator("fuel")).contains("needs a simulation"));
}

#[test]
fn parameters_out_of_range_are_named() {
    let error = |effect| applied_error(&on_sensor(0.0, effect));
    assert_eq!(
        error(Effect::Add(FaultProfile::incipient(1.0, -1.0))),
        "fault: `rise_s` must be 0 s or longer, got -1"
    );
    assert_eq!(
        error(Effect::Add(FaultProfile::intermittent(1.0, 1.0, 2.0))),
        "fault: `duty` must be from 0 to 1, got 2"
    );
    assert_eq!(error(Effect::Scale(f64::NAN)), "fault: `scale` must be finite, got NaN");
    let mut ends_early = on_sensor(5.0, Effect::StuckLast);
    ends_early.end_s = Some(4.0);
    assert_eq!(applied_error(&ends_early), "fault: `end_s` must be at or after `start_s`, got 4");
}

fn applied_error(fault: &FaultSpec) -> String {
    fault.apply(&mut [0.0], 0.0, ts(1.0)).unwrap_err().to_string()
}

#[test]
fn specs_survive_toml_and_unknown_words_are_rejected() {
    for effect in [
        Effect::Add(FaultProfile::drift(0.1)),
        Effect::Multiply(FaultProfile::intermittent(0.1, 2.0, 0.5)),
        Effect::Scale(0.9),
        Effect::StuckAt(4.0),
        Effect::StuckLast,
    ] {
        let fault = FaultSpec::new(Site::component("eta"), 1.0, effect);
        let text = toml::to_string(&fault).unwrap();
        assert_eq!(toml::from_str::<FaultSpec>(&text).unwrap(), fault, "{text}");
    }
    let text = "site = { sensor = 1 }\neffect = { add = { kind = 'sudden', size = 1.0 } }";
    let message = toml::from_str::<FaultSpec>(text).unwrap_err().to_string();
    assert!(message.contains("`abrupt`, `incipient`"), "{message}");
}
