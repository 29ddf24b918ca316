//! Published observers: the jet engine of Chen, Patton and Zhang (1996), and the smallest unknown
//! input observer of Chen and Patton's book, in continuous time.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::problems::{Problem, chen_patton, jet_engine};
use faer::{Mat, MatRef, c64, mat, prelude::Solve};
use fd_model::Continuous;
use fd_numeric::dense::Dense;
use fd_residual::{
    ResidualForm,
    analysis::{UnknownInputs, fault_effects},
    directional::{BeardDesign, FaultSpans},
    observer::ErrorPoles,
    unknown_input::UnknownInputObserver,
};

/// Chen, Patton and Zhang (1996): robust and Beard filters of a jet engine.
#[test]
fn jet_engine_fault_isolation() {
    let Problem { plant, disturbances, .. } = jet_engine();
    let (a, c) = (plant.a().to_owned(), plant.c().to_owned());
    let pseudoinverse = c.full_svd().unwrap().pseudoinverse();
    let e1 = mat![[6.2006, 2.8639], [4.1048, -4.3262], [0.0, 0.0]];
    let e_star = disturbances.system(&plant).unwrap().b().to_owned();
    let three = Mat::from_fn(3, 3, |i, j| if i == j { 3.0 } else { 0.0 });
    let k1 = |a1: MatRef<'_, f64>| (&three + a1) * &pseudoinverse;

    // Beard filter K = (3I + A) C⁺: all poles at −3.
    let filter = BeardDesign::full_state(&plant, 3.0).unwrap();
    assert!((filter.observer().gain() - k1(a.as_ref())).norm_max() < 1e-13);
    let beard = filter.form().unwrap();
    assert!(beard.consistency(&plant).unwrap() < 1e-13);
    for pole in beard.system().poles().unwrap() {
        // C⁺ C = I to rounding times cond(C) < 3.
        assert!((pole - c64::new(-3.0, 0.0)).norm() < 1e-13);
    }

    // Robust filter against the printed matrices, with the tolerances of their four digits.
    let robust = UnknownInputObserver::with_gain(&plant, e1.as_ref(), k1).unwrap();
    let robust_form = robust.form().unwrap();
    let printed_h = mat![
        [0.6117, -0.1170, 0.0, 0.3215, 0.3220, -0.1295],
        [-0.1170, 0.9382, 0.0, 0.0605, 0.0623, -0.1916],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    ];
    let printed_t = mat![[0.0, 0.0, -0.1251], [0.0, 0.0, 0.0783], [0.0, 0.0, 1.0]];
    let printed_k = mat![
        [-0.0708, 0.0443, 0.5658, 0.1400, 0.1531, 0.3540],
        [0.0443, -0.0277, -0.3540, -0.0876, -0.0958, -0.2215],
        [0.5658, -0.3540, -4.5229, -1.1193, -1.2239, -2.8297]
    ];
    assert!((robust.h() - printed_h).norm_max() < 1e-4);
    assert!((robust.t() - printed_t).norm_max() < 2e-4);
    assert!((robust.k() - printed_k).norm_max() < 5e-3);
    assert!(robust_form.consistency(&plant).unwrap() < 1e-13);
    // E₁ spans what E* spans, to the four printed digits.
    let disturbance = UnknownInputs::new("d", e1.clone(), Mat::zeros(6, 2)).unwrap();
    let gd = disturbance.system(&plant).unwrap();
    assert!(fault_effects(&robust_form, &gd).unwrap().iter().all(|d| d.peak.norm < 1e-13));
    assert!(fault_effects(&beard, &gd).unwrap().iter().all(|d| d.detectable && d.lasting));

    // Steady state of x' = A x + B u + E* d(x) with u = 0.2.
    let fixed = Mat::from_fn(3, 1, |i, _| if i == 2 { 2.0 } else { 0.0 });
    let mut x = Mat::<f64>::zeros(3, 1);
    for _ in 0..200 {
        let v = |i: usize| x[(i, 0)];
        let d = [v(0) * v(0), v(1) * v(1), v(2) * v(2), v(0) * v(1), v(0) * v(2), v(1) * v(2)];
        let d = Mat::from_fn(6, 1, |i, _| d[i]);
        x = -a.lu().solve(&fixed + &e_star * d);
    }
    for (i, expected) in [0.0483, 0.0269, 0.2].into_iter().enumerate() {
        assert!((x[(i, 0)] - expected).abs() < 1e-4);
    }

    // Isolation index of filter j (row) for a 2 % offset of sensor `fault` (column).
    let indices = |form: &ResidualForm<Continuous>, planes: &[Mat<f64>]| {
        let gain = form.system().dc_gain().unwrap();
        let planes: Vec<_> = planes.iter().map(Mat::as_ref).collect();
        let mut spans = FaultSpans::<f64>::new(&planes).unwrap();
        let columns: Vec<[f64; 3]> = (0..3)
            .map(|fault| {
                let mut y = &c * &x;
                y[(fault, 0)] += 0.02;
                let signals = Mat::from_fn(7, 1, |i, _| if i == 0 { 0.2 } else { y[(i - 1, 0)] });
                let r = &gain * signals;
                let r: Vec<f64> = (0..6).map(|i| r[(i, 0)]).collect();
                let mut index = [0.0; 3];
                spans.index_into(&r, &mut index);
                index
            })
            .collect();
        Mat::from_fn(3, 3, |j, fault| columns[fault][j])
    };
    let planes: Vec<_> = (0..3).map(|j| filter.sensor_plane(j).unwrap()).collect();
    let found = indices(&beard, &planes);
    let expected =
        mat![[0.2869, 0.8448, 0.7559], [0.9993, 0.2698, 0.7785], [0.8673, 0.9940, 0.1746]];
    // The reference was computed from the same rounded matrices and is printed to four digits.
    assert!((&found - &expected).norm_max() < 1e-3, "{found:?}");

    let plane = |j: usize| {
        let through = [&c * robust.k1().subcols(j, 1), &c * robust.h().subcols(j, 1)];
        let unit = |i: usize| if i == j { 1.0 } else { 0.0 };
        Mat::from_fn(6, 3, |i, k| if k == 0 { unit(i) } else { through[k - 1][(i, 0)] })
    };
    let found = indices(&robust_form, &[plane(0), plane(1), plane(2)]);
    let expected = mat![[0.0, 0.4153, 0.2116], [0.4844, 0.0, 0.2029], [0.8568, 0.7043, 0.0]];
    assert!((&found - &expected).norm_max() < 1e-3, "{found:?}");
    // The published ordering: each filter is smallest for its own sensor.
    for fault in 0..3 {
        assert!((0..3).all(|j| j == fault || found[(fault, fault)] < 0.01 * found[(j, fault)]));
    }
}

/// The minimal unknown input observer of Chen and Patton's book.
#[test]
fn minimal_unknown_input_observer() {
    let Problem { plant, disturbances, .. } = chen_patton();
    let poles = [-2.0, -5.0, -10.0].map(|p| c64::new(p, 0.0));
    let given = ErrorPoles::Given(poles.to_vec());
    let gd = disturbances.system(&plant).unwrap();
    let observer = UnknownInputObserver::place(&plant, gd.b(), &given).unwrap();
    assert!((observer.h() - mat![[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]]).norm_max() < 1e-14);
    let by_hand = mat![[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, -1.0]];
    assert!((observer.t() * plant.a() - by_hand).norm_max() < 1e-14);
    let form = observer.form().unwrap();
    let mut found = form.system().poles().unwrap();
    found.sort_by(|p, q| q.re.total_cmp(&p.re));
    for (found, wanted) in found.iter().zip(poles) {
        assert!((found - wanted).norm() < 1e-10, "{found}");
    }
    assert!(form.consistency(&plant).unwrap() < 1e-12);
    assert!(fault_effects(&form, &gd).unwrap()[0].peak.norm < 1e-12);
}
