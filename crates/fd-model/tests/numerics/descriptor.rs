//! Descriptor models, transfer functions and minimal parts: laws on random models.

use faer::{Mat, prelude::Solve};
use fd_model::{Continuous, DescriptorSystem, ModelError, StateSpace, TransferFunction};
use fd_numeric::dense::Dense;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

fn matrix(rng: &mut Xoshiro256PlusPlus, rows: usize, columns: usize) -> Mat<f64> {
    Mat::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0))
}

fn system(rng: &mut Xoshiro256PlusPlus, nx: usize) -> StateSpace<Continuous> {
    let (b, c, d) = (matrix(rng, nx, 2), matrix(rng, 2, nx), matrix(rng, 2, 2));
    StateSpace::new(matrix(rng, nx, nx), b, c, d, Continuous).unwrap()
}

/// Largest difference of two transfer functions off the axis, where random poles are not.
fn distance(one: &StateSpace<Continuous>, other: &StateSpace<Continuous>) -> f64 {
    let points = [(4.0, 0.3), (0.1, 5.0), (6.0, -7.0)].map(|(re, im)| faer::c64::new(re, im));
    let at = |p| (one.transfer_at(p).unwrap() - other.transfer_at(p).unwrap()).norm_max();
    points.into_iter().map(at).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Algebraic unknowns that a state-space model is dressed with, and equations and unknowns mixed and in other units, do
    /// not change the transfer function; as many states come back as there were.
    #[test]
    fn algebra_does_not_change_a_model(seed in any::<u64>(), nx in 1..5_usize, extra in 0..4_usize) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let g = system(&mut rng, nx);
        let n = nx + extra;
        // ẋ = A x + B u + F (z − Z x − Y u), 0 = −z + Z x + Y u, and the outputs use z alike.
        let (z, y) = (matrix(&mut rng, extra, nx), matrix(&mut rng, extra, 2));
        let (f, h) = (matrix(&mut rng, nx, extra), matrix(&mut rng, 2, extra));
        let put = |m: &mut Mat<f64>, i: usize, j: usize, part: &Mat<f64>| {
            m.submatrix_mut(i, j, part.nrows(), part.ncols()).copy_from(part);
        };
        let (mut e, mut a) = (Mat::zeros(n, n), Mat::zeros(n, n));
        put(&mut e, 0, 0, &Mat::identity(nx, nx));
        put(&mut a, 0, 0, &(g.a() - &f * &z));
        put(&mut a, 0, nx, &f);
        put(&mut a, nx, 0, &z);
        put(&mut a, nx, nx, &-Mat::<f64>::identity(extra, extra));
        let mut b = Mat::zeros(n, 2);
        put(&mut b, 0, 0, &(g.b() - &f * &y));
        put(&mut b, nx, 0, &y);
        let mut c = Mat::zeros(2, n);
        put(&mut c, 0, 0, &(g.c() - &h * &z));
        put(&mut c, 0, nx, &h);
        let d = g.d() - &h * &y;
        // Other combinations of equations and of unknowns, with units over four decades.
        let unit = |rng: &mut Xoshiro256PlusPlus| 10.0_f64.powf(rng.random_range(-2.0..2.0));
        let mut mixed = || {
            let turn = matrix(&mut rng, n, n) + faer::Scale(2.0) * Mat::<f64>::identity(n, n);
            turn.factor_qr().compute_thin_Q()
        };
        let (left, right) = (mixed(), mixed());
        let units: Vec<f64> = (0..n).map(|_| unit(&mut rng)).collect();
        let left = Mat::from_fn(n, n, |i, j| units[i] * left[(i, j)]);
        let model = DescriptorSystem::new(&left * e * &right, &left * a * &right, &left * b, c * &right, d, Continuous);
        let found = model.unwrap().to_state_space().unwrap();
        prop_assert_eq!(found.nx(), nx);
        prop_assert!(distance(&found, &g) < 1e-8, "{:e}", distance(&found, &g));
    }

    /// Concatenations and selections are what they say, and a minimal part has the same transfer function.
    #[test]
    fn concatenations_are_blocks(seed in any::<u64>(), nx in 1..5_usize) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let (g, h) = (system(&mut rng, nx), system(&mut rng, 3));
        let (side, above) = (g.beside(&h).unwrap(), g.above(&h).unwrap());
        for (part, of) in [
            (side.select(&[0, 1], &[0, 1]), &g),
            (side.select(&[0, 1], &[2, 3]), &h),
            (above.select(&[0, 1], &[0, 1]), &g),
            (above.select(&[2, 3], &[0, 1]), &h),
        ] {
            let part = part.unwrap();
            prop_assert!(distance(&part, of) < 1e-11);
            let minimal = part.minimal(1e-9).unwrap();
            prop_assert!(minimal.nx() == of.nx() && distance(&minimal, of) < 1e-8);
        }
        // Twice the same, side by side, has no more states than once.
        let twice = g.above(&g).unwrap().minimal(1e-9).unwrap();
        prop_assert_eq!(twice.nx(), nx);
    }

    /// To polynomials and back.
    #[test]
    fn transfer_functions_are_realised(seed in any::<u64>(), nx in 0..6_usize) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let den: Vec<f64> = std::iter::once(1.0).chain((0..nx).map(|_| rng.random_range(-3.0..3.0))).collect();
        let num: Vec<f64> = (0..=nx).map(|_| rng.random_range(-3.0..3.0)).collect();
        let ratio = TransferFunction::new(&num, &den).unwrap();
        let system = ratio.realise(Continuous).unwrap();
        prop_assert_eq!(system.nx(), nx);
        let back = system.transfer_function(0, 0).unwrap();
        for p in [(4.0, 0.3), (0.5, 5.0), (-6.0, 7.0)].map(|(re, im)| faer::c64::new(re, im)) {
            let expected = ratio.at(p);
            let size = 1.0 + expected.norm();
            prop_assert!((system.transfer_at(p).unwrap()[(0, 0)] - expected).norm() < 1e-9 * size);
            prop_assert!((back.at(p) - expected).norm() < 1e-8 * size);
        }
    }
}

/// A model with one equation too few, written as one with a zero row.
#[test]
fn what_has_no_solution_is_told_from_what_differentiates() {
    let one = Mat::from_fn(2, 2, |i, j| if (i, j) == (0, 0) { 1.0 } else { 0.0 });
    let b = Mat::from_fn(2, 1, |_, _| 1.0);
    let c = Mat::from_fn(1, 2, |_, _| 1.0);
    let model = |e: Mat<f64>, a: Mat<f64>| {
        DescriptorSystem::new(e, a, b.clone(), c.clone(), Mat::zeros(1, 1), Continuous).unwrap()
    };
    let singular = model(one.clone(), one).to_state_space().unwrap_err();
    assert!(matches!(singular, ModelError::Singular { .. }), "{singular}");
    // ẋ₂ = x₁ + u, 0 = x₂ + u: x₁ = −u̇ − u
    let shift = Mat::from_fn(2, 2, |i, j| if (i, j) == (0, 1) { 1.0 } else { 0.0 });
    let high = model(shift, Mat::identity(2, 2)).to_state_space().unwrap_err();
    assert_eq!(high, ModelError::HighIndex { algebraic: 1, solved: 0 });
    assert!(high.to_string().contains("index two or more"));
    // With E invertible it is a state-space model in disguise.
    let e = Mat::from_fn(2, 2, |i, j| if i == j { 2.0 } else { 0.5 });
    let plain = model(e.clone(), -Mat::<f64>::identity(2, 2)).to_state_space().unwrap();
    let a = e.lu().solve(-Mat::<f64>::identity(2, 2));
    let expected = StateSpace::new(a, e.lu().solve(&b), c.clone(), Mat::zeros(1, 1), Continuous);
    assert!(distance(&plain, &expected.unwrap()) < 1e-12);
}

#[test]
fn transfer_functions_are_checked_and_printed() {
    let told = |num: &[f64], den: &[f64]| TransferFunction::new(num, den).map(|g| g.to_string());
    assert_eq!(told(&[0.0, -2.5], &[2.0, 0.0, 1.0]).unwrap(), "-2.5/(2 x^2 + 1)");
    assert_eq!(told(&[0.0], &[1.0, 1.0]).unwrap(), "0/(x + 1)");
    assert!(matches!(
        told(&[1.0, 0.0], &[1.0]),
        Err(ModelError::Order { requested: 1, available: 0, .. })
    ));
    assert!(matches!(told(&[1.0], &[0.0, 0.0]), Err(ModelError::Singular { .. })));
    assert!(matches!(told(&[f64::NAN], &[1.0]), Err(ModelError::NonFinite { .. })));
}
