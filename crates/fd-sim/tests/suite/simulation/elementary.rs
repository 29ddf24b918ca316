//! Sine, cosine, exponential and hyperbolic tangent: those of the library but for rounding, and the
//! same for one number and for several.

use fd_sim::equation::{Expr, Lanes, Program, Scope};
use proptest::prelude::*;

/// A function as text, that of the library, and how many units in the last place they may be apart.
type Function = (&'static str, fn(f64) -> f64, u64);

/// Sine, cosine and exponential are within 0.8 units of the truth and those of any library within
/// one, so that the difference, a whole number, is at most one. The tangent is within 2.5 units and
/// that of a library within 2.2.
const FUNCTIONS: [Function; 4] = [
    ("sin(x)", f64::sin, 1),
    ("cos(x)", f64::cos, 1),
    ("exp(x)", f64::exp, 1),
    ("tanh(x)", f64::tanh, 4),
];

/// Distance in units in the last place; zeros of both signs are one apart.
fn apart(a: f64, b: f64) -> u64 {
    let order = |x: f64| {
        let bits = x.to_bits().cast_signed();
        if bits < 0 { i64::MIN - bits - 1 } else { bits }
    };
    order(a).abs_diff(order(b))
}

fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

fn ours(text: &str, x: f64) -> f64 {
    Expr::parse(text).unwrap().evaluate(&|_: &str| Some(x)).unwrap()
}

/// Numbers of all sizes, many near multiples of π/2, where most of a sine is taken off.
fn numbers() -> impl Strategy<Value = f64> {
    let multiple = (-70_000..70_000_i32, -30..0_i32, -1.0..1.0_f64)
        .prop_map(|(n, e, d)| f64::from(n) * std::f64::consts::FRAC_PI_2 + d * 2_f64.powi(e));
    let small = (-300..1_i32, -1.0..1.0_f64).prop_map(|(e, d)| d * 2_f64.powi(e));
    let large = prop_oneof![-1e5..1e5_f64, -1e9..1e9_f64];
    let special = prop::sample::select(vec![0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
    prop_oneof![4 => -4.0..4.0_f64, 4 => -30.0..30.0_f64, 2 => -800.0..800.0_f64,
        4 => multiple, 4 => small, 2 => large, 1 => special, 1 => any::<f64>()]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn they_are_those_of_the_library(x in numbers()) {
        for (text, library, most) in FUNCTIONS {
            let (ours, theirs) = (ours(text, x), library(x));
            let is_near = ours.is_nan() && theirs.is_nan() || apart(ours, theirs) <= most;
            prop_assert!(is_near, "{text} of {x:e}: {ours:e} {theirs:e}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn several_side_by_side_have_the_bits_of_one(x in prop::array::uniform16(numbers())) {
        let scope = Scope { fast: vec!["x".into()], ..Scope::default() };
        let all = FUNCTIONS.map(|(text, ..)| Expr::parse(text).unwrap());
        let program = Program::compile(&scope, &all).unwrap();
        // One that is large sends all another way.
        for most in [f64::INFINITY, 1e5, 700.0, 0.75, 0.1] {
            let x = x.map(|x| if x.is_nan() { x } else { x.clamp(-most, most) });
            let mut workspace = program.workspace();
            workspace.fast_mut()[0] = Lanes(x);
            let mut found = [Lanes([0.0; 16]); FUNCTIONS.len()];
            program.run(&mut workspace, &mut found);
            for ((text, ..), found) in FUNCTIONS.iter().zip(found) {
                for (x, found) in x.into_iter().zip(found.0) {
                    prop_assert!(same(found, ours(text, x)), "{text} of {x:e}: {found:e}");
                }
            }
        }
    }
}

/// Next to a multiple of π/2 all digits come from the last parts of π/2.
#[test]
fn nothing_is_lost_next_to_a_multiple() {
    for n in 1..63_661 {
        let x = f64::from(n) * std::f64::consts::FRAC_PI_2;
        let (text, library, most) = FUNCTIONS[usize::from(n % 2 == 1)];
        assert!(apart(ours(text, x), library(x)) <= most, "{text} of {x:e}");
    }
}

#[test]
fn an_odd_function_keeps_the_sign_of_zero() {
    for (text, ..) in [FUNCTIONS[0], FUNCTIONS[3]] {
        assert!(same(ours(text, 0.0), 0.0) && same(ours(text, -0.0), -0.0), "{text}");
    }
}
