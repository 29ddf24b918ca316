//! Laws of records: there and back, pieces and wholes.

use proptest::prelude::*;

use super::*;
use crate::unit::UnitError;

fn ts(seconds: f64) -> SampleTime {
    SampleTime::new(seconds).unwrap()
}

fn channels() -> (Vec<Channel>, Vec<Channel>) {
    (vec![Channel::new("fuel", "kg/s")], vec![Channel::new("N", "rpm"), Channel::new("T", "K")])
}

fn any_record() -> impl Strategy<Value = Record> {
    (1_usize..40).prop_flat_map(|n| {
        let value = prop_oneof![9 => -1e3..1e3_f64, 1 => Just(f64::NAN)];
        let values = |len| proptest::collection::vec(value.clone(), len);
        (values(n), values(2 * n)).prop_map(|(u, y)| {
            let (inputs, outputs) = channels();
            Record::new(inputs, outputs, u, y, ts(0.5)).unwrap().starting_at(3.0)
        })
    })
}

/// Equality in which missing equals missing.
fn same(a: &Record, b: &Record) -> bool {
    let bits = |r: &Record| -> Vec<Option<u64>> {
        let values = r.u.iter().chain(&r.y);
        values.map(|v| (!v.is_nan()).then_some(v.to_bits())).collect()
    };
    a.inputs == b.inputs
        && a.outputs == b.outputs
        && a.ts == b.ts
        && a.start.to_bits() == b.start.to_bits()
        && bits(a) == bits(b)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn pieces_join_to_the_whole(record in any_record(), cut in 0.0..1.0_f64) {
        // Times are multiples of 0.5 s and exact.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let cut = (cut * record.len() as f64) as usize;
        let (first, second) = (record.slice(0, cut), record.slice(cut, record.len()));
        prop_assert!(same(&first.followed_by(&second).unwrap(), &record));
    }

    #[test]
    fn complete_blocks_hold_all_complete_samples(record in any_record()) {
        let missing = record.missing();
        let blocks = record.complete_blocks(1);
        prop_assert_eq!(blocks.iter().map(Record::len).sum::<usize>(), missing.complete);
        for block in &blocks {
            prop_assert_eq!(block.missing().complete, block.len());
            // Each block is the part of the record at its time.
            let from = (0..record.len()).position(|k| record.time(k).to_bits() == block.time(0).to_bits());
            let from = from.unwrap();
            prop_assert!(same(&record.slice(from, from + block.len()), block));
        }
    }

    #[test]
    fn scaling_there_and_back(record in any_record(), offset in -1e3..1e3_f64, scale in 0.1..10.0_f64) {
        let scaling = Scaling {
            inputs: vec![ChannelScale::deviation(offset)],
            outputs: vec![ChannelScale::per_unit(offset, -scale), ChannelScale::default()],
        };
        let back = record.scaled(&scaling).unwrap();
        let back = back.unscaled(&scaling, record.inputs(), record.outputs()).unwrap();
        prop_assert_eq!(back.outputs(), record.outputs());
        for (a, b) in back.u.iter().chain(&back.y).zip(record.u.iter().chain(&record.y)) {
            // Four roundings of numbers up to |v| + |offset| <= 2000.
            let bound = 4.0 * f64::EPSILON * 2000.0;
            prop_assert!((a - b).abs() <= bound || (a.is_nan() && b.is_nan()));
        }
    }

    #[test]
    fn decimation_composes_and_keeps_the_mean(y in proptest::collection::vec(-1.0..1.0_f64, 12..60)) {
        let record = Record::new(vec![], Channel::numbered("y", 1), vec![], y, ts(0.5)).unwrap();
        let six = record.decimated(6).unwrap();
        let two_three = record.decimated(2).unwrap().decimated(3).unwrap();
        prop_assert_eq!(six.len(), two_three.len());
        for k in 0..six.len() {
            // Means of six numbers below one.
            prop_assert!((six.y(k)[0] - two_three.y(k)[0]).abs() < 8.0 * f64::EPSILON);
            prop_assert_eq!(six.time(k).to_bits(), two_three.time(k).to_bits());
        }
    }
}

#[test]
fn names_are_looked_up_and_rows_checked() {
    let (inputs, outputs) = channels();
    let rows = [(vec![1.0], vec![2.0, 3.0])];
    let record = Record::from_rows(inputs.clone(), outputs.clone(), rows, ts(1.0)).unwrap();
    assert_eq!((record.input_index("fuel"), record.output_index("T")), (Some(0), Some(1)));
    assert_eq!(record.output_index("fuel"), None);
    let short = [(vec![1.0], vec![2.0])];
    let error = Record::from_rows(inputs, outputs, short, ts(1.0)).unwrap_err();
    assert_eq!(error.to_string(), "row of outputs y must be 1x2, got 1x1");
}

#[test]
fn joining_needs_one_time_base_and_the_same_channels() {
    let run = |name: &str, ts_s: f64, start: f64| {
        Record::new(vec![], Channel::numbered(name, 1), vec![], vec![1.0, 2.0], ts(ts_s))
            .unwrap()
            .starting_at(start)
    };
    let first = run("y", 1.0, 0.0);
    let error = |later: &Record| first.followed_by(later).unwrap_err().to_string();
    assert_eq!(
        error(&run("z", 1.0, 2.0)),
        "output 0 is `y1 [1]` in the first record and `z1 [1]` in the second"
    );
    assert_eq!(
        error(&run("y", 2.0, 2.0)),
        "the first record has a sample time of 1 s, the second of 2 s"
    );
    for start in [1.0, 2.5] {
        assert!(matches!(first.followed_by(&run("y", 1.0, start)), Err(RecordError::Order { .. })));
    }
    assert_eq!(first.followed_by(&run("y", 1.0, 5.0)).unwrap().missing().longest_hole, 3);
}

#[test]
fn scales_and_units_are_checked() {
    let record =
        Record::new(vec![], Channel::numbered("y", 1), vec![], vec![1.0], ts(1.0)).unwrap();
    let scaling = |outputs| Scaling { inputs: vec![], outputs };
    assert_eq!(
        record.scaled(&scaling(vec![])).unwrap_err().to_string(),
        "the record has 1 outputs, got 0 scales"
    );
    assert_eq!(
        record.scaled(&scaling(vec![ChannelScale::per_unit(1.0, 0.0)])).unwrap_err().to_string(),
        "the scale of output `y1` must be finite and not 0, got 0"
    );
    assert!(matches!(
        record.in_units(&[], &["kPa"]),
        Err(RecordError::Unit { source: UnitError::Incompatible { .. }, .. })
    ));
    assert!(matches!(record.decimated(0), Err(RecordError::Factor { factor: 0 })));
}
