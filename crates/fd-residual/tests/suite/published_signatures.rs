//! Published answers on which residuals exist, and of which order: what is decoupled from what. Sources: `docs/results/published.md`.
//!
//! The answers are numbers of residuals, orders and bits: nothing is rounded in them. Matrices are as printed, in continuous time.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{
    problems::{Problem, yuan},
    transfer::{Ratio, System, assert_equal, realise},
};
use faer::{Mat, c64, mat};
use fd_model::{Continuous, StateSpace};
use fd_residual::{
    ResidualForm,
    analysis::{Signature, UnknownInputs, achievable_signatures, weak_structure},
    decouple::LeftNullSpace,
    least_order::{LeastOrderBank, LeastOrderDesign},
    observer::ErrorPoles,
    rank::RankTolerance,
    structured::Structure,
};

/// Signature, number of independent residuals, order of all of them together and least order of one: as `fdichkspec` of
/// `FaultDetectionTools` prints them.
type Row = (String, usize, usize, usize);

fn found(p: &Problem, frequencies: &[f64], longest: usize) -> Vec<Row> {
    achievable_signatures(&p.plant, &p.faults, &p.disturbances, frequencies, longest)
        .unwrap()
        .into_iter()
        .map(|a| {
            let full = a.basis_orders.iter().sum();
            (a.signature.to_string(), a.dimension, full, a.least_order)
        })
        .collect()
}

fn rows(published: &[(&str, [usize; 3])]) -> Vec<Row> {
    published.iter().map(|&(bits, [d, full, least])| (bits.to_owned(), d, full, least)).collect()
}

fn given(poles: &[f64]) -> ErrorPoles {
    ErrorPoles::Given(poles.iter().map(|&pole| c64::new(pole, 0.0)).collect())
}

/// A plant that is moved by its faults alone.
fn idle(a: Mat<f64>, c: Mat<f64>, bf: Mat<f64>) -> Problem {
    let (nx, ny, faults) = (a.nrows(), c.nrows(), bf.ncols());
    let plant = StateSpace::new(a, Mat::zeros(nx, 0), c, Mat::zeros(ny, 0), Continuous).unwrap();
    let faults = UnknownInputs::new("f", bf, Mat::zeros(ny, faults)).unwrap();
    let none = UnknownInputs::none(&plant);
    Problem::new(plant, faults, none)
}

/// Xiong and Saif (2000), example 1: an actuator and a sensor, two disturbances.
#[test]
fn xiong_and_saif_four_states() {
    let a = mat![
        [-9.9477, -0.7476, 0.2632, -5.0337],
        [52.1659, 2.7452, 5.5532, -24.4221],
        [26.0922, 2.6361, -4.1975, -19.2774],
        [0.0, 0.0, 1.0, 0.0]
    ];
    let b = mat![[0.4422, 0.1761], [3.5446, -7.5922], [-5.52, 4.49], [0.0, 0.0]];
    let c = mat![
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 1.0, 1.0, 1.0]
    ];
    let bd = mat![[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let actuator = b.subcols(0, 1).to_owned();
    let mut p = Problem::entering(a, c, b, actuator, bd);
    p.faults = p.faults.sensor(&p.plant, 2).unwrap();
    let published = rows(&[("01", [1, 1, 1]), ("10", [1, 2, 2]), ("11", [2, 2, 1])]);
    assert_eq!(found(&p, &[], 6), published);
    // For faults that are constant or oscillate at 1 rad/s, too.
    assert_eq!(found(&p, &[0.0, 1.0], 6), published);
    let orders = [1, 2, 1];
    for ((bits, ..), order) in published.iter().zip(orders) {
        let wanted = Signature(bits.bytes().map(|b| b == b'1').collect());
        let rate = ErrorPoles::Rate(3.0);
        let design = LeastOrderDesign::new(&p.plant, &p.faults, &p.disturbances, &wanted, &rate);
        assert_eq!(design.unwrap().order(), order, "{bits}");
    }
}

/// Xiong and Saif (2000), example 2: two actuators, two disturbances, three outputs.
#[test]
fn xiong_and_saif_five_states() {
    let a = mat![
        [0.0, 0.0, -0.0034, 0.0, 0.0],
        [0.0, -0.041, 0.0013, 0.0, 0.0],
        [0.0, 0.0, -1.1471, 0.0, 0.0],
        [0.0, 0.0, -0.0036, 0.0, 0.0],
        [0.0, 0.094, 0.0057, 0.0, -0.051]
    ];
    let b = mat![
        [-1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 0.948],
        [0.916, -1.0, 0.0],
        [-0.598, 0.0, 0.0]
    ];
    let bd = mat![[0.0, 1.0], [0.062, -0.132], [0.0, -7.189], [0.0, 0.0], [0.0, 0.0]];
    let c = mat![[1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, 0.0]];
    let actuators = b.subcols(0, 2).to_owned();
    let p = Problem::entering(a, c, b, actuators, bd);
    let published = rows(&[("01", [1, 1, 1]), ("10", [1, 1, 1]), ("11", [2, 2, 1])]);
    assert_eq!(found(&p, &[], 6), published);
    assert_eq!(found(&p, &[0.0, 1.0], 6), published);
}

/// Varga (2007): the pitch axis of a Boeing 747 with five surfaces that may fail. Entries from 2e-6 to 93.
#[test]
fn boeing_747_pitch_axis() {
    let a = mat![
        [-0.4861, 3.17e-4, -0.5588, 0.0, -2.04e-6],
        [0.0, -0.0199, 3.0796, -9.8048, 8.98e-5],
        [1.0053, -0.0021, -0.5211, 0.0, 9.30e-6],
        [1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, -92.6, 92.6, 0.0]
    ];
    let moved = [
        [-0.1455, -0.1455, -0.1494, -0.1494, -1.2860, 0.0013, 0.0035, 0.0035, 0.0013],
        [0.0, 0.0, 0.0, 0.0, -0.3122, 0.1999, 0.1999, 0.1999, 0.1999],
        [-0.0071, -0.0071, -0.0074, -0.0074, -0.0676, -0.0004, -0.0004, -0.0004, -0.0004],
    ];
    let b = Mat::from_fn(5, 9, |i, j| if i < 3 { moved[i][j] } else { 0.0 });
    let c = mat![
        [0.0, 0.0, 1.0, 0.0, 0.0],
        [0.0, -0.0199, 3.0796, -9.8048, 8.98e-5],
        [0.0, 0.0, 0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, -92.6, 92.6, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0]
    ];
    // The second output is an acceleration.
    let d = Mat::from_fn(6, 9, |i, j| if i == 1 { moved[1][j] } else { 0.0 });
    let (bf, df) = (b.subcols(0, 5).to_owned(), d.subcols(0, 5).to_owned());
    let plant = StateSpace::new(a, b, c, d, Continuous).unwrap();
    let none = UnknownInputs::none(&plant);
    let p = Problem::new(plant, UnknownInputs::new("f", bf, df).unwrap(), none);
    let weak = rows(&[
        ("00001", [4, 3, 1]),
        ("00110", [4, 4, 2]),
        ("00111", [5, 4, 1]),
        ("11000", [4, 4, 2]),
        ("11001", [5, 4, 1]),
        ("11110", [5, 5, 1]),
        ("11111", [6, 5, 1]),
    ]);
    assert_eq!(found(&p, &[], 8), weak);
    // Three of them are lost for faults that last.
    let strong = rows(&[
        ("00111", [5, 4, 1]),
        ("11001", [5, 4, 1]),
        ("11110", [5, 5, 1]),
        ("11111", [6, 5, 1]),
    ]);
    assert_eq!(found(&p, &[0.0, 1.0], 8), strong);
    assert_eq!(found(&p, &[0.0], 8), strong);
}

/// Tests of Varga with poles of the plant at the frequencies of the faults.
#[test]
fn strong_signatures_with_poles_on_the_axis() {
    let bits = |p: &Problem, frequencies: &[f64]| -> Vec<String> {
        found(p, frequencies, 5).into_iter().map(|(bits, ..)| bits).collect()
    };
    // G_f = [1/(s²+1) 1/s]: at the pole of one fault the other is lost.
    let a = mat![[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]];
    let apart = idle(a, mat![[1.0, 0.0, 1.0]], mat![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    assert_eq!(bits(&apart, &[]), ["11"]);
    assert!(bits(&apart, &[0.0, 1.0]).is_empty() && bits(&apart, &[1.0]).is_empty());
    // G_f = 1/(s (s²+1)) [1 1/(s+2)]: the poles belong to both.
    let a = mat![
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0, 1.0],
        [0.0, 0.0, 0.0, -2.0]
    ];
    let entries = mat![[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let common = idle(a, mat![[1.0, 0.0, 0.0, 0.0]], entries);
    assert_eq!(bits(&common, &[]), ["11"]);
    assert_eq!(bits(&common, &[0.0, 1.0]), ["11"]);
    // G_u = [1/s; 1/s], G_d = [0; s/(s+3)], G_f = [(s+1)/(s+2); 1/(s+2)]: what is free of u and d starts with a derivative.
    let a = Mat::from_fn(3, 3, |i, j| if i == j { [0.0, -2.0, -3.0][i] } else { 0.0 });
    let c = mat![[1.0, -1.0, 0.0], [1.0, 1.0, -3.0]];
    let b = mat![[1.0], [0.0], [0.0]];
    let plant = StateSpace::new(a, b, c, Mat::zeros(2, 1), Continuous).unwrap();
    let fault = UnknownInputs::new("f", mat![[0.0], [1.0], [0.0]], mat![[1.0], [0.0]]).unwrap();
    let load = UnknownInputs::new("d", mat![[0.0], [0.0], [1.0]], mat![[0.0], [1.0]]).unwrap();
    let integrators = Problem::new(plant, fault, load);
    assert_eq!(bits(&integrators, &[]), ["1"]);
    assert!(bits(&integrators, &[0.0, 1.0]).is_empty());
}

/// Yuan et al. (1997) in the user's guide of FDITOOLS, examples 5 and 10: which of the 18 filters react to constant faults, and how
/// few states the whole bank needs once all filters have their poles in {−1, −2}.
#[test]
fn yuan_bank_of_order_six() {
    let p = yuan();
    let strong: Vec<_> = found(&p, &[0.0], 4).into_iter().map(|(.., least)| least).collect();
    assert_eq!(strong, [1, 2, 2, 2, 1, 1, 1, 2, 2, 2, 2, 2]);

    let gf = p.faults.system(&p.plant).unwrap();
    let mut bank: Option<System> = None;
    let weak = found(&p, &[], 4);
    assert_eq!(weak.len(), 18);
    for (bits, _, _, order) in weak {
        let wanted = Signature(bits.bytes().map(|b| b == b'1').collect());
        let poles = given(&[-1.0, -2.0][..order]);
        let none = &p.disturbances;
        let row = LeastOrderDesign::new(&p.plant, &p.faults, none, &wanted, &poles).unwrap();
        assert_eq!(weak_structure(row.form(), &gf).unwrap(), [wanted]);
        let system = row.form().system();
        bank = Some(bank.map_or_else(|| system.clone(), |bank| bank.above(system).unwrap()));
    }
    let bank = bank.unwrap();
    assert_eq!(bank.nx(), 32);
    let hankel = bank.hankel_singular_values().unwrap();
    // Published: only the first six are not zero. Gains are near one, so that rounding leaves less than 1e-12.
    assert!(hankel[5] > 1e-3 && hankel[6] < 1e-12, "{hankel:?}");
    assert_eq!(bank.minimal(1e-7).unwrap().nx(), 6);
}

/// Example 5.10 of Varga (2017): three sensors of one signal, whatever moves it. Every achievable residual compares two or three of
/// them and has no states.
#[test]
fn three_sensors_vote() {
    let (signal, load): (Ratio, Ratio) = ((&[1.0], &[1.0, 0.4, 1.0]), (&[1.0, 3.0], &[1.0, 5.0]));
    // The states of the signal are there once; a model that holds them once per sensor must allow for differences between them.
    let thrice = StateSpace::gain(mat![[1.0], [1.0], [1.0]], Continuous).unwrap();
    let all = realise(&[[signal, load]]).series(&thrice).unwrap();
    let plant = all.select(&[0, 1, 2], &[0]).unwrap();
    let load = all.select(&[0, 1, 2], &[1]).unwrap();
    let load = UnknownInputs::new("load", load.b().to_owned(), load.d().to_owned()).unwrap();
    let sensors = (0..3).fold(UnknownInputs::none(&plant), |all, i| all.sensor(&plant, i).unwrap());
    let p = Problem::new(plant, sensors, load);
    let achievable: Vec<_> = found(&p, &[], 4).into_iter().map(|(bits, ..)| bits).collect();
    assert_eq!(achievable, ["011", "101", "110", "111"]);
    let pairs = [[0.0, 1.0, -1.0], [-1.0, 0.0, 1.0], [1.0, -1.0, 0.0]];
    let bits = pairs.map(|row| Signature(row.iter().map(|&w: &f64| w != 0.0).collect()));
    let (rows, exact) = (Structure::Rows(bits.to_vec()), RankTolerance::default());
    let bank =
        LeastOrderBank::new(&p.plant, &p.faults, &p.disturbances, &rows, 1.0, exact).unwrap();
    for (row, pair) in bank.rows().iter().zip(pairs) {
        assert_eq!(row.order(), 0);
        // The published Q, columns y1, y2, y3 and then u, up to its gain.
        let gains = row.form().system().d();
        let plus = pair.iter().position(|&w| 0.0 < w).unwrap();
        for (sensor, weight) in pair.iter().enumerate() {
            let found = gains[(0, 1 + sensor)] / gains[(0, 1 + plus)];
            assert!((found - weight).abs() < 1e-12, "{gains:?}");
        }
        assert!(gains[(0, 0)].abs() < 1e-12 * gains[(0, 1 + plus)].abs(), "{gains:?}");
    }
}

/// The relation between `u` and the only output of a plant, over the given denominator, with the published gain of `u`.
fn relation(plant: &System, poles: &[f64]) -> ResidualForm<Continuous> {
    let space = LeftNullSpace::of(plant, &UnknownInputs::none(plant)).unwrap();
    assert_eq!((space.residual_len(), space.order()), (1, 2));
    let form = space.placed(&given(poles)).unwrap();
    // Both relations end in −u.
    let rest: f64 = poles.iter().product();
    let gain = -1.0 / (rest * form.system().dc_gain().unwrap()[(0, 0)]);
    form.weighted(mat![[gain]].as_ref()).unwrap()
}

/// Parity relations of the Fault Diagnosis Toolbox: `y″ + (c₃ + c₅) y′ + c₃ c₅ y − u` of its manual with `c₃ = 3` and `c₅ = 5`, and
/// `y″ + 2 y′ + y − u` of its note on orders of differentiation.
#[test]
fn parity_relations_of_two_lags() {
    let lags = |first: f64, second: f64| {
        let (a, b) = (mat![[-first, 1.0], [0.0, -second]], mat![[0.0], [1.0]]);
        StateSpace::new(a, b, mat![[1.0, 0.0]], mat![[0.0]], Continuous).unwrap()
    };
    let to_u: Ratio = (&[-1.0], &[1.0, 3.0, 2.0]);
    let manual = realise(&[[to_u, (&[1.0, 8.0, 15.0], &[1.0, 3.0, 2.0])]]);
    assert_equal(relation(&lags(3.0, 5.0), &[-1.0, -2.0]).system(), &manual);
    let to_u: Ratio = (&[-1.0], &[1.0, 5.0, 6.0]);
    let note = realise(&[[to_u, (&[1.0, 2.0, 1.0], &[1.0, 5.0, 6.0])]]);
    assert_equal(relation(&lags(1.0, 1.0), &[-2.0, -3.0]).system(), &note);
}
