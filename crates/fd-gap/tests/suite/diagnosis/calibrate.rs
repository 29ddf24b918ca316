//! Self-calibration is right on an easy case, and a black box closes what it can.

use std::time::Instant;

use fd_gap::{
    calibrate::self_calibrate,
    ceiling::ceiling,
    diagnose::{Case, CauseId, Settings, diagnose},
};
use fd_sim::{model::Model, patch::Patch};

use crate::diagnosis::bench_cases::{Reality, candidates, example, expr, record, sizes};

fn reality(amplitude: f64, seed: u64) -> Reality {
    Reality { samples: 500, amplitude, parameter_error: 0.02, colour: 0.0, seed }
}

fn friction() -> Model {
    let mut patch = Patch::of(&example("mass_spring_damper"));
    patch.add_force("carriage", "friction", expr("-0.4*v/sqrt(v^2 + 0.004^2)")).unwrap();
    patch.finish().unwrap()
}

#[test]
fn an_easy_case_is_diagonal_whatever_the_number_of_threads() {
    let model = example("mass_spring_damper");
    let mut suspects = candidates(&model, sizes("mass_spring_damper"));
    suspects.retain(|c| ["coulomb", "delay", "bias", "dead-zone"].contains(&c.label));
    let log = record(&friction(), reality(10.0, 3), 1).slice(0, 300);
    let case = Case { nominal: &model, suspects: &suspects, logs: &[log], held_out: &[] };
    let settings = Settings { finalists: 4, ..Settings::default() };
    let diagnosis = diagnose(&case, &settings, &()).unwrap();
    let replicas = 6;
    let begin = Instant::now();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| self_calibrate(&case, &diagnosis, &settings, replicas, &()).unwrap())
    };
    let confusion = run(2);
    println!("{:?}: {}", begin.elapsed(), confusion.statement);
    for (truth, row) in confusion.truths.iter().zip(&confusion.counts) {
        println!("{:?} {row:?}", truth.name);
    }
    println!("{confusion:?}");
    assert!(2 <= confusion.truths.len());
    assert_eq!(confusion.truths[0].cause, None);
    assert_eq!(confusion.truths[1].name, "coulomb at force site `carriage`");
    for (i, row) in confusion.counts.iter().enumerate() {
        assert_eq!(row.iter().sum::<usize>(), confusion.replicas[i]);
        assert!(row.iter().enumerate().all(|(j, count)| i == j || count <= &row[i]), "{row:?}");
    }
    // No gap, and friction of 0.4 N in a log that shows it, are beyond doubt.
    assert!(replicas - 1 <= confusion.counts[0][0] && replicas - 1 <= confusion.counts[1][1]);
    assert!(confusion.set.contains(&Some(CauseId(0))) && !confusion.set.contains(&None));
    assert!(1.0 <= confusion.set_size && confusion.set_size < 3.0);
    assert_eq!(confusion, run(1));
}

#[test]
fn a_black_box_removes_a_part_of_friction_and_nothing_of_noise() {
    let model = example("mass_spring_damper");
    let mut suspects = candidates(&model, sizes("mass_spring_damper"));
    suspects.retain(|c| ["delay", "bias"].contains(&c.label));
    for (truth, is_friction) in [(friction(), true), (model.clone(), false)] {
        let reality = Reality { samples: 1500, ..reality(10.0, 3) };
        let [log, held_out] = [1, 2].map(|seed| record(&truth, reality, seed));
        let case =
            Case { nominal: &model, suspects: &suspects, logs: &[log], held_out: &[held_out] };
        let settings = Settings::default();
        let diagnosis = diagnose(&case, &settings, &()).unwrap();
        let begin = Instant::now();
        let found = ceiling(&case, &diagnosis, &settings, &()).unwrap().unwrap();
        println!("{:?}: {} {found:?}", begin.elapsed(), found.statement);
        let share = found.share();
        if is_friction {
            let share = share.unwrap();
            // Not all: it does not know the law. Not nothing: the gap follows the motion.
            assert!(0.2 < share.fraction && share.fraction < 0.99, "{share:?}");
            assert!(share.interval[0] <= share.fraction && share.fraction <= share.interval[1]);
        } else {
            // What there is above the floor by chance is not reduced.
            let after = found.linear.unwrap().after[0];
            assert!(after < 1.2 * 0.0005, "{after}");
        }
    }
    let case = Case {
        nominal: &model,
        suspects: &suspects,
        logs: &[record(&model, reality(10.0, 3), 1)],
        held_out: &[],
    };
    let settings = Settings::default();
    let diagnosis = diagnose(&case, &settings, &()).unwrap();
    assert_eq!(ceiling(&case, &diagnosis, &settings, &()).unwrap(), None);
}

#[test]
fn a_linear_black_box_removes_a_linear_gap() {
    let model = example("mass_spring_damper");
    let mut patch = Patch::of(&model);
    patch.wrap_input("force", "seen", expr("1.4*force")).unwrap();
    let truth = patch.finish().unwrap();
    let reality = Reality { samples: 1500, ..reality(8.0, 3) };
    let [log, held_out] = [1, 2].map(|seed| record(&truth, reality, seed));
    let case = Case { nominal: &model, suspects: &Vec::new(), logs: &[log], held_out: &[held_out] };
    let settings = Settings::default();
    let diagnosis = diagnose(&case, &settings, &()).unwrap();
    let found = ceiling(&case, &diagnosis, &settings, &()).unwrap().unwrap();
    println!("{} {found:?}", found.statement);
    let closed = found.linear.unwrap().closed.unwrap();
    // The gap is linear, of higher order than the equation, and the training is noisy.
    assert!(0.7 < closed.fraction, "{closed:?}");
}
