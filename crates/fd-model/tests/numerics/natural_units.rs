//! Natural units follow the units of the model, and hold what couples its parts.

use faer::{Mat, mat};
use fd_model::{Continuous, NaturalUnits, StateSpace};

/// In other units the model has the same natural entries, but for units that round the other way.
#[test]
fn natural_entries_do_not_depend_on_the_units() {
    let entry = |i: usize, j: usize| ((1 + 3 * i + 7 * j) as f64).sin();
    let part = |rows, columns, from| Mat::from_fn(rows, columns, |i, j| entry(i + from, j));
    let parts = [part(4, 4, 0), part(4, 2, 5), part(3, 4, 9), part(3, 2, 12)];
    let [a, b, c, d] = parts;
    let model = StateSpace::new(a, b, c, d, Continuous).unwrap();
    let other = NaturalUnits {
        states: vec![1e-4, 3.0, 1e4, 0.1],
        inputs: vec![1e3, 1e-3],
        outputs: vec![1e-4, 20.0, 1e4],
        rate: 1.0,
    };
    let other = model.in_units(&other).unwrap();
    let natural = |model: &StateSpace<Continuous>| model.in_units(&model.natural_units()).unwrap();
    let (one, other) = (natural(&model), natural(&other));
    let pairs =
        [(one.a(), other.a()), (one.b(), other.b()), (one.c(), other.c()), (one.d(), other.d())];
    for (m, n) in pairs {
        for (i, j) in (0..m.nrows()).flat_map(|i| (0..m.ncols()).map(move |j| (i, j))) {
            // Two units, each to the nearest power of two.
            let ratio = m[(i, j)] / n[(i, j)];
            assert!((0.24..4.1).contains(&ratio), "{ratio} at {i}, {j}");
        }
    }
}

/// A tank that fills another: three sensors of the first, three further inflows of the second. Nothing
/// comes back, and still the coupling is as large as the rate of both.
#[test]
fn a_coupling_that_goes_one_way_is_held() {
    let a = mat![[-1.0, 0.0], [1e-5, -1.0]];
    let b = mat![[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 1.0, 1.0]];
    let c = mat![[1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let tanks = StateSpace::new(a, b, c, Mat::zeros(4, 4), Continuous).unwrap();
    let units = tanks.natural_units();
    let coupling = tanks.in_units(&units).unwrap().a()[(1, 0)] / units.rate;
    // One, but for powers of two: of two states and of the rate.
    assert!((0.125..=8.0).contains(&coupling), "{coupling}");
}
