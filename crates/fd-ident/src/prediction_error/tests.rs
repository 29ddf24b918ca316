//! The sensitivities are the derivatives, for every structure, start and pattern of holes.

use faer::{Mat, prelude::SolveLstsq};
use fd_numeric::dense::Dense;
use proptest::prelude::*;

use super::{
    NoiseStructure,
    bordered::{Bordered, Compressed},
    gauss_newton::SumOfSquares,
    predictor::{Predictor, Stretch},
    problem::Problem,
};
use crate::arx::{ArxOrders, Start, reflect, roots};

fn structure() -> impl Strategy<Value = NoiseStructure> {
    prop_oneof![
        Just(NoiseStructure::OutputError),
        (0..3_usize, 0..3_usize).prop_map(|(nc, nd)| NoiseStructure::BoxJenkins { nc, nd }),
        (0..3_usize).prop_map(|nc| NoiseStructure::Armax { nc }),
    ]
}

fn stretch(nu: usize) -> impl Strategy<Value = Stretch> {
    let mu = prop_oneof![9 => -1.0..1.0_f64, 1 => Just(f64::NAN)];
    (prop::collection::vec(-1.0..1.0_f64, 20 * nu), prop::collection::vec(mu, 20))
        .prop_map(|(u, mu)| Stretch { u, mu })
}

/// All columns, the shared ones first, and the errors.
fn dense(of: &Bordered) -> (Mat<f64>, Mat<f64>) {
    let (own, shared) = (of.own, of.shared);
    let rows: Vec<(usize, usize)> = of
        .blocks
        .iter()
        .enumerate()
        .flat_map(|(b, block)| (0..block.nrows()).map(move |i| (b, i)))
        .collect();
    let jacobian = Mat::from_fn(rows.len(), shared + own * of.blocks.len(), |k, j| {
        let (block, i) = rows[k];
        match j.checked_sub(shared) {
            None => of.blocks[block][(i, own + j)],
            Some(j) if j / own == block => of.blocks[block][(i, j % own)],
            Some(_) => 0.0,
        }
    });
    let errors =
        Mat::from_fn(rows.len(), 1, |k, _| of.blocks[rows[k].0][(rows[k].1, own + shared)]);
    (jacobian, errors)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn sensitivities_are_derivatives(
        noise in structure(),
        (na, nb, delay) in (0..3_usize, 1..3_usize, 0..3_usize),
        offset in any::<bool>(),
        estimated in any::<bool>(),
        stretches in prop::collection::vec(stretch(2), 1..3),
        draw in prop::collection::vec(-0.4..0.4_f64, 40),
    ) {
        let orders = ArxOrders { na, nb, delay, offset };
        let start = if estimated { Start::Estimated } else { Start::Rest };
        let problem = Problem { predictor: Predictor { orders, nu: 2, noise, start }, stretches };
        let p = &draw[..problem.parameters()];
        let (jacobian, errors) = dense(&problem.linearise(p));
        let cost: f64 = (0..errors.nrows()).map(|i| errors[(i, 0)].powi(2)).sum();
        prop_assert!((cost - problem.cost(p)).abs() <= 1e-12 * (1.0 + cost));
        prop_assert_eq!(errors.nrows(), problem.rows());
        // The step of the blocks is that of all columns at once: conditions of damped columns of length 1 are below
        // 1/√λ, and rounding is that often amplified, squared.
        let (damping, n) = (1e-3, p.len());
        let lengths: Vec<f64> = (0..n).map(|j| jacobian.col(j).norm_l2()).collect();
        let length = |j: usize| if lengths[j] > 0.0 { lengths[j] } else { 1.0 };
        let (rows, width) = (errors.nrows(), errors.nrows() + n);
        let x = Mat::from_fn(width, n, |i, j| match i.checked_sub(rows) {
            None => jacobian[(i, j)] / length(j),
            Some(i) => if i == j { f64::sqrt(damping) } else { 0.0 },
        });
        let y = Mat::from_fn(width, 1, |i, _| if i < rows { -errors[(i, 0)] } else { 0.0 });
        let step = x.factor_qr().solve_lstsq(&y);
        for (j, found) in Compressed::new(problem.linearise(p)).step(damping).iter().enumerate() {
            let expected = step[(j, 0)] / length(j);
            prop_assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()) / length(j).min(1.0), "{} {}", found, expected);
        }
        // Central differences err by step² times third derivatives, and by ε/step: 1e-10 each for
        // numbers of size 1; coefficients below 0.4 keep 20 samples below size 1e2.
        let step = 1e-5;
        for j in 0..p.len() {
            let moved = |by: f64| {
                let mut p = p.to_vec();
                p[j] += by;
                dense(&problem.linearise(&p)).1
            };
            let (up, down) = (moved(step), moved(-step));
            for i in 0..errors.nrows() {
                let slope = (up[(i, 0)] - down[(i, 0)]) / (2.0 * step);
                prop_assert!(
                    (slope - jacobian[(i, j)]).abs() < 1e-6 * (1.0 + slope.abs()),
                    "{:?} row {} column {}: {} for {}", noise, i, j, jacobian[(i, j)], slope
                );
            }
        }
    }

    #[test]
    fn reflected_polynomials_are_stable_and_of_the_same_magnitude(
        a in prop::collection::vec(-3.0..3.0_f64, 1..4),
        omega in 0.0..3.0_f64,
    ) {
        let radius = roots(&a).unwrap().iter().map(|p| p.norm()).fold(0.0, f64::max);
        let near = roots(&a).unwrap().iter().any(|p| (p.norm() - 1.0).abs() < 1e-3);
        prop_assume!(!near);
        let mut reflected = a.clone();
        let gain = reflect(&mut reflected).unwrap();
        let largest = roots(&reflected).unwrap().iter().map(|p| p.norm()).fold(0.0, f64::max);
        prop_assert!(largest < 1.0 && (radius >= 1.0 || reflected == a));
        let magnitude = |a: &[f64]| {
            let (mut re, mut im) = (1.0, 0.0);
            for (i, a) in (1..).zip(a) {
                re += a * (f64::from(i) * omega).cos();
                im -= a * (f64::from(i) * omega).sin();
            }
            f64::hypot(re, im)
        };
        // |1/A| before is gain · |1/A| after; roots of multiplicity 3 are known to ε^(1/3).
        let (before, after) = (magnitude(&a) * gain, magnitude(&reflected));
        prop_assert!((before - after).abs() < 1e-4 * (1.0 + after), "{} {}", before, after);
    }
}
