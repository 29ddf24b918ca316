//! How long does a structural analysis of 100 equations take?
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use fd_structure::{
    analysis::Causality,
    design::{Requirement, Sensors},
    model::StructuralModel,
    redundancy::Supports,
};
use fdiag_benches::{MEASUREMENT, SAMPLES, WARM_UP};

/// Tanks in a row, each with a balance, an outflow and a differential constraint, fed at the top. Every level flows back into
/// the outflow above it, so that nothing is solved one after the other. 31 tanks and 7 sensors are 101 equations.
fn tanks(tanks: usize, sensors: usize) -> StructuralModel {
    let mut builder = StructuralModel::builder("tanks").equation("input", ["q0"], ["u"]);
    for i in 1..=tanks {
        let name = |of: &str, i: usize| format!("{of}{i}");
        let (h, dh, q, above) = (name("h", i), name("dh", i), name("q", i), name("q", i - 1));
        let below = name("h", (i + 1).min(tanks));
        builder = builder
            .equation(format!("balance {i}"), [dh.as_str(), &above, &q], [])
            .equation(format!("outflow {i}"), [q.as_str(), &h, &below], [])
            .differential(&h, &dh)
            .fault(format!("leak {i}"), format!("balance {i}"))
            .fault(format!("clogging {i}"), format!("outflow {i}"));
    }
    for s in 0..sensors {
        let level = format!("h{}", 1 + s * tanks / sensors);
        let (name, log) = (format!("sensor {s}"), format!("y{s}"));
        builder = builder
            .equation(name.clone(), [level.as_str()], [log.as_str()])
            .fault(format!("sensor fault {s}"), name);
    }
    builder.build().unwrap()
}

fn hundred_equations(c: &mut Criterion) {
    let model = tanks(31, 7);
    assert_eq!((model.equations().len(), model.faults().len()), (101, 69));
    assert_eq!(model.decompose().redundancy(), 7);
    let mut group = c.benchmark_group("structure of 101 equations, 69 faults");
    group.warm_up_time(WARM_UP).measurement_time(MEASUREMENT).sample_size(SAMPLES);
    group.bench_function("decomposition", |b| b.iter(|| black_box(&model).decompose()));
    for causality in Causality::ALL {
        group.bench_function(format!("isolability, {}", causality.name()), |b| {
            b.iter(|| black_box(&model).isolability(causality));
        });
    }
    group.bench_function("minimal test supports", |b| {
        b.iter(|| black_box(&model).test_supports(Supports::Minimal, 10_000));
    });
    group.bench_function("minimal overdetermined sets, 10000 of them", |b| {
        b.iter(|| black_box(&model).mso_sets(10_000));
    });
    let candidates = (0..model.unknowns().len()).collect();
    let sensors = Sensors { candidates, may_fail: false };
    let wanted = Requirement::detect_all(model.faults().len());
    group.bench_function("sensors to detect all faults", |b| {
        b.iter(|| black_box(&model).place_sensors(&wanted, &sensors).unwrap());
    });
    group.finish();
}

criterion_group!(benches, hundred_equations);
criterion_main!(benches);
