//! Models at the edge: no states, one state, poles on the edge of stability, no channels.

use faer::{Mat, mat};
use fd_model::{Continuous, Discrete, ModelError, StateSpace, reduce, riccati, uncertainty};

use crate::models::{distance, ts};

fn scalar(a: f64) -> StateSpace<Continuous> {
    StateSpace::new(mat![[a]], mat![[1.0]], mat![[1.0]], mat![[0.0]], Continuous).unwrap()
}

#[test]
fn static_gains_go_through_every_door() {
    let gain = StateSpace::gain(mat![[2.0, -1.0]], Continuous).unwrap();
    assert!(gain.is_stable().unwrap() && gain.worst_pole().unwrap().is_none());
    assert!(gain.zeros().unwrap().is_empty());
    assert_eq!(gain.observability_gramian().unwrap().nrows(), 0);
    for reduction in [
        reduce::balanced_truncation(&gain, 0).unwrap(),
        reduce::balanced_residualisation(&gain, 0).unwrap(),
    ] {
        assert_eq!(reduction.model.d(), gain.d());
        assert!(reduction.error_bound <= 0.0);
    }
    assert_eq!(reduce::residualise_onto(&gain, &[]).unwrap().d(), gain.d());
    let draw = uncertainty::MatrixPerturbation::default().draw(&gain, 1).unwrap();
    assert!((draw.model.d()[(0, 0)] / 2.0 - 1.0).abs() <= 0.1);
    let what = "states are both controllable and observable";
    let error = reduce::balanced_truncation(&gain, 1).unwrap_err();
    assert_eq!(error, ModelError::Order { requested: 1, available: 0, what });
}

#[test]
fn one_state_has_closed_forms() {
    let lag = scalar(-4.0);
    let (p, q) = (lag.controllability_gramian().unwrap(), lag.observability_gramian().unwrap());
    assert!((p[(0, 0)] - 0.125).abs() < 1e-16 && (q[(0, 0)] - 0.125).abs() < 1e-16);
    assert!((lag.h2_norm().unwrap() - 0.125_f64.sqrt()).abs() < 1e-15);
    let peak = lag.hinf_norm(1e-8).unwrap();
    assert!((peak.norm - 0.25).abs() < 1e-15 && peak.omega <= 0.0);
    let nothing_left = reduce::balanced_residualisation(&lag, 0).unwrap();
    assert!((nothing_left.model.d()[(0, 0)] - 0.25).abs() < 1e-15);
    // Here the bound is tight: the error 1/(s + 4) − 1/4 is largest at infinity.
    assert!((nothing_left.error_bound - 0.25).abs() < 1e-15);
}

#[test]
fn integrators_are_refused_where_they_have_no_answer() {
    let integrator = scalar(0.0);
    let unstable = |what| ModelError::Unstable { what, re: 0.0, im: 0.0 };
    assert_eq!(integrator.h2_norm().unwrap_err(), unstable("the H2 norm"));
    assert_eq!(integrator.hinf_norm(0.1).unwrap_err(), unstable("the H-infinity norm"));
    assert_eq!(
        integrator.hankel_singular_values().unwrap_err(),
        unstable("the Hankel singular values")
    );
    let singular = |role| ModelError::Singular { role };
    let role = "the steady-state matrix (A, or I − A)";
    assert_eq!(integrator.dc_gain().unwrap_err(), singular(role));
    let role = "the resolvent sI − A";
    assert_eq!(integrator.frequency_response(0.0).unwrap_err(), singular(role));
    let role = "the steady-state matrix of the eliminated states";
    assert_eq!(reduce::residualise_onto(&integrator, &[]).unwrap_err(), singular(role));
    // But it can be sampled, connected and asked for its response elsewhere.
    let sampled = integrator.sample_zoh(ts(0.5)).unwrap();
    assert_eq!(sampled.a(), mat![[1.0]]);
    assert!((sampled.b()[(0, 0)] - 0.5).abs() < 1e-15);
    assert!((integrator.frequency_response(2.0).unwrap()[(0, 0)].im + 0.5).abs() < 1e-16);
}

#[test]
fn poles_that_tustin_sends_to_infinity_are_named() {
    let role = "I − A Ts/2";
    assert_eq!(scalar(4.0).sample_tustin(ts(0.5)).unwrap_err(), ModelError::Singular { role });
    let d = Discrete { ts: ts(1.0) };
    let ringing = StateSpace::new(mat![[-1.0]], mat![[1.0]], mat![[1.0]], mat![[0.0]], d).unwrap();
    assert_eq!(ringing.undo_tustin().unwrap_err(), ModelError::Singular { role: "I + A" });
}

#[test]
fn growth_past_the_largest_number_is_an_error() {
    let error = scalar(1e6).sample_zoh(ts(1.0)).unwrap_err();
    assert!(matches!(error, ModelError::NonFinite { role: "state matrix A", .. }), "{error}");
    let error = scalar(1e308).sample_zoh(ts(1e3)).unwrap_err();
    assert!(matches!(error, ModelError::NonFinite { .. }), "{error}");
}

#[test]
fn stiff_models_keep_their_slow_mode() {
    // Time constants from a day to a nanosecond.
    let a = mat![[-1e-5, 1.0], [0.0, -1e9]];
    let model =
        StateSpace::new(a, mat![[0.0], [1e9]], mat![[1e-5, 0.0]], mat![[0.0]], Continuous).unwrap();
    let sampled = model.sample_zoh(ts(1.0)).unwrap();
    // ε ‖A‖ Ts = 2e-7, the limit of scaling and squaring.
    assert!((sampled.a()[(0, 0)] - (-1e-5_f64).exp()).abs() < 2e-7);
    // One slow lag of gain one: Hankel value one half, known to ε √(1e9/1e-5) = 2e-9.
    let hankel = model.hankel_singular_values().unwrap();
    assert!((hankel[0] - 0.5).abs() < 1e-8, "{hankel:?}");
}

#[test]
fn units_do_not_change_the_answers() {
    let a = mat![[-1.0, 2.0, 0.5], [0.3, -2.0, 1.0], [0.1, 0.7, -3.0]];
    let (b, c) = (mat![[1.0], [0.5], [2.0]], mat![[1.0, 0.2, 0.4]]);
    let units = [1e-6, 1.0, 1e7];
    let rescaled = StateSpace::new(
        Mat::from_fn(3, 3, |i, j| a[(i, j)] * units[i] / units[j]),
        Mat::from_fn(3, 1, |i, _| b[(i, 0)] * units[i]),
        Mat::from_fn(1, 3, |_, j| c[(0, j)] / units[j]),
        mat![[0.0]],
        Continuous,
    );
    let (model, rescaled) =
        (StateSpace::new(a, b, c, mat![[0.0]], Continuous).unwrap(), rescaled.unwrap());
    let (x, y) =
        (model.hankel_singular_values().unwrap(), rescaled.hankel_singular_values().unwrap());
    assert!(x.iter().zip(&y).all(|(x, y)| (x - y).abs() < 1e-14 * x), "{x:?} {y:?}");
    let (x, y) = (model.hinf_norm(1e-8).unwrap().norm, rescaled.hinf_norm(1e-8).unwrap().norm);
    assert!((x / y - 1.0).abs() < 1e-8);
    let sampled = rescaled.sample_zoh(ts(0.3)).unwrap();
    let back = Mat::from_fn(3, 3, |i, j| sampled.a()[(i, j)] / units[i] * units[j]);
    let expected = model.sample_zoh(ts(0.3)).unwrap();
    assert!(distance(back.as_ref(), expected.a()) < 1e-14);
}

#[test]
fn wrong_sizes_and_infinities_are_named_before_anything_is_computed() {
    let (one, two) = (mat![[1.0]], mat![[1.0], [1.0]]);
    let error = riccati::discrete_filter(one.as_ref(), two.as_ref(), one.as_ref(), one.as_ref())
        .unwrap_err();
    let expected = "measurement noise covariance R";
    assert!(error.to_string().contains(expected), "{error}");
    let infinite = mat![[f64::INFINITY]];
    let error =
        riccati::discrete_filter(one.as_ref(), one.as_ref(), infinite.as_ref(), one.as_ref())
            .unwrap_err();
    assert!(matches!(error, ModelError::NonFinite { role: "process noise covariance Q", .. }));
    // A filter without noise on an unstable plant that nothing measures.
    let blind = mat![[0.0]];
    let error =
        riccati::discrete_filter(mat![[1.5]].as_ref(), blind.as_ref(), one.as_ref(), one.as_ref())
            .unwrap_err();
    assert!(matches!(error, ModelError::NotStabilisable { .. } | ModelError::NoConvergence { .. }));
    // Undetectable, but stable: the open loop does.
    let open =
        riccati::discrete_filter(mat![[0.5]].as_ref(), blind.as_ref(), one.as_ref(), one.as_ref())
            .unwrap();
    assert!((open.p[(0, 0)] - 4.0 / 3.0).abs() < 1e-15 && open.gain[(0, 0)].abs() <= 0.0);
}
