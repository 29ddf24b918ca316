//! Properties of expressions: printing, derivatives, bytecode, simplification, hostile texts.

use fd_sim::equation::{
    Binary, Comparison, Cond, Expr, Found, Lookup, Outside, Program, Scope, SyntaxProblem, Table,
    Unary, Values,
};
use proptest::prelude::*;

const NAMES: [&str; 4] = ["a", "b_2", "theta", "_x"];

fn unary_functions() -> impl Strategy<Value = Unary> {
    use Unary::*;
    prop::sample::select(vec![
        Neg, Sin, Cos, Tan, Asin, Acos, Atan, Sinh, Cosh, Tanh, Exp, Ln, Log10, Sqrt, Abs, Sign,
        Floor, Step,
    ])
}

fn binary_functions() -> impl Strategy<Value = Binary> {
    use Binary::*;
    prop::sample::select(vec![Add, Sub, Mul, Div, Pow, Atan2, Min, Max])
}

fn comparisons() -> impl Strategy<Value = Comparison> {
    use Comparison::*;
    prop::sample::select(vec![Less, LessEqual, Greater, GreaterEqual, Equal])
}

fn conditions(expr: impl Strategy<Value = Expr> + Clone + 'static) -> impl Strategy<Value = Cond> {
    let leaf = (comparisons(), expr.clone(), expr).prop_map(|(c, a, b)| Cond::compare(c, a, b));
    leaf.prop_recursive(3, 6, 2, |inner| {
        prop_oneof![
            (inner.clone(), inner.clone()).prop_map(|(a, b)| Cond::And(a.into(), b.into())),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| Cond::Or(a.into(), b.into())),
            inner.prop_map(|a| Cond::Not(a.into())),
        ]
    })
}

fn expressions() -> impl Strategy<Value = Expr> {
    let leaf = prop_oneof![
        prop_oneof![
            -3.0..3.0,
            Just(0.0),
            Just(-0.0),
            Just(1.0),
            Just(2.0),
            Just(-1.0),
            any::<f64>()
        ]
        .prop_filter("a literal is finite", |x: &f64| x.is_finite())
        .prop_map(Expr::Number),
        prop::sample::select(NAMES.to_vec()).prop_map(Expr::name),
        Just(Expr::name("pi")),
    ];
    leaf.prop_recursive(5, 40, 3, |inner| {
        let triple = (inner.clone(), inner.clone(), inner.clone());
        prop_oneof![
            4 => (binary_functions(), inner.clone(), inner.clone()).prop_map(|(f, a, b)| Expr::binary(f, a, b)),
            2 => (unary_functions(), inner.clone()).prop_map(|(f, x)| Expr::unary(f, x)),
            1 => triple.prop_map(|(x, low, high)| Expr::clamp(x, low, high)),
            1 => (conditions(inner.clone()), inner.clone(), inner.clone()).prop_map(|(c, a, b)| Expr::choice(c, a, b)),
            1 => inner.clone().prop_map(|x| Expr::Lookup(Lookup::Value, "map".into(), x.into())),
            1 => inner.prop_map(|x| Expr::Lookup(Lookup::Slope, "map".into(), x.into())),
        ]
    })
}

fn table() -> Table {
    Table::new(vec![-1.0, 0.0, 0.5, 2.0], vec![3.0, 1.0, 1.5, -4.0], Outside::Extend).unwrap()
}

struct Point {
    values: [f64; 4],
    table: Table,
}

impl Values<f64> for Point {
    fn value(&self, name: &str) -> Option<f64> {
        NAMES.iter().position(|known| *known == name).map(|i| self.values[i])
    }

    fn table(&self, name: &str) -> Option<&Table> {
        (name == "map").then_some(&self.table)
    }
}

fn at(values: [f64; 4]) -> Point {
    Point { values, table: table() }
}

fn scope() -> Scope {
    Scope {
        slow: vec!["a".into(), "b_2".into()],
        fast: vec!["theta".into(), "_x".into()],
        definitions: Vec::new(),
        tables: vec![("map".into(), table())],
    }
}

fn run(scope: &Scope, expressions: &[Expr], values: [f64; 4]) -> Vec<f64> {
    let program = Program::compile(scope, expressions).unwrap();
    let mut workspace = program.workspace::<f64>();
    workspace.slow_mut().copy_from_slice(&values[..2]);
    program.prepare(&mut workspace);
    workspace.fast_mut().copy_from_slice(&values[2..]);
    let mut results = vec![0.0; expressions.len()];
    program.run(&mut workspace, &mut results);
    results
}

/// Equal bits, or both NaN: the payload of a NaN depends on the order of operands, which merging
/// of equal sums does not keep.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

fn points() -> impl Strategy<Value = [f64; 4]> {
    prop::array::uniform4(prop_oneof![-3.0..3.0, Just(0.0), Just(1.0), Just(-0.5)])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_printed_tree_parses_to_itself(expr in expressions()) {
        let text = expr.to_string();
        let parsed = Expr::parse(&text);
        prop_assert_eq!(parsed.as_ref(), Ok(&expr), "{}", text);
    }

    #[test]
    fn parentheses_are_needed(expr in expressions()) {
        // Removing any one pair that does not belong to a call changes the meaning or breaks the
        // text.
        let text = expr.to_string();
        for (open, close) in groups(&text) {
            let without = format!("{} {} {}", &text[..open], &text[open + 1..close], &text[close + 1..]);
            prop_assert_ne!(Expr::parse(&without).ok(), Some(expr.clone()), "{}", text);
        }
    }

    #[test]
    fn a_serialised_tree_comes_back(expr in expressions()) {
        let json = serde_json::to_string(&expr).unwrap();
        prop_assert_eq!(serde_json::from_str::<Expr>(&json).unwrap(), expr);
    }

    #[test]
    fn bytecode_gives_the_bits_of_the_tree(all in prop::collection::vec(expressions(), 1..4), values in points()) {
        let compiled = run(&scope(), &all, values);
        for (expr, value) in all.iter().zip(compiled) {
            let expected = expr.evaluate(&at(values)).unwrap();
            prop_assert!(same(value, expected), "{expr}: {value} against {expected}");
        }
    }

    #[test]
    fn definitions_change_no_bit(inner in expressions(), outer in expressions(), values in points()) {
        let mut scope = scope();
        scope.definitions.push(("inner".into(), inner.clone()));
        let named = outer.substitute(&|name| (name == "theta").then(|| Expr::name("inner")));
        let written = outer.substitute(&|name| (name == "theta").then(|| inner.clone()));
        let results = run(&scope, &[named, written], values);
        prop_assert!(same(results[0], results[1]));
    }

    #[test]
    fn simplification_keeps_a_finite_value(expr in expressions(), values in points()) {
        // Only tiny and huge literals make intermediate results that `0*x` could hide.
        let simple = expr.simplify();
        let (before, after) = (expr.evaluate(&at(values)).unwrap(), simple.evaluate(&at(values)).unwrap());
        if before.is_finite() && all_parts_are_finite(&expr, values) {
            // Every rule is exact but for the sign of a zero, which a division turns into another
            // infinity and `atan2` into another branch; those are not finite parts or are ±π.
            let same_angle = (before.abs() - after.abs()).abs() <= 1e-9;
            prop_assert!(before.to_bits() == after.to_bits() || before - after == 0.0
                || (expr.to_string().contains("atan2") && same_angle)
                || expr.to_string().contains('^') && (before - after).abs() <= 1e-12 * before.abs(),
                "{expr} = {before}, {simple} = {after}");
        }
    }

    #[test]
    fn renaming_changes_no_value(expr in expressions(), values in points()) {
        let renamed = expr.rename("a", "alpha").rename("map", "curve");
        let mut scope = scope();
        scope.slow[0] = "alpha".into();
        scope.tables[0].0 = "curve".into();
        prop_assert!(same(run(&scope, &[renamed], values)[0], expr.evaluate(&at(values)).unwrap()));
    }

    #[test]
    fn any_text_is_parsed_or_rejected(text in ".{0,60}") {
        if let Err(error) = Expr::parse(&text) {
            prop_assert!(error.to_string().contains("column"));
        }
    }

    #[test]
    fn nearly_expressions_are_parsed_or_rejected(text in r"[-+*/^<>=(),. a-c0-9e_]{0,40}(if|not|and|or|sin|clamp)?[-+*(), a1]{0,20}") {
        if let Ok(expr) = Expr::parse(&text) {
            prop_assert_eq!(Expr::parse(&expr.to_string()), Ok(expr));
        }
    }
}

/// Positions of parentheses that do not follow a name.
fn groups(text: &str) -> Vec<(usize, usize)> {
    let mut open = Vec::new();
    let mut groups = Vec::new();
    for (i, c) in text.char_indices() {
        match c {
            '(' => open.push(i),
            ')' => {
                let start: usize = open.pop().unwrap();
                let before = text[..start].chars().next_back();
                if !before.is_some_and(|c| c.is_ascii_alphanumeric() || c == '_') {
                    groups.push((start, i));
                }
            }
            _ => {}
        }
    }
    groups
}

fn all_parts_are_finite(expr: &Expr, values: [f64; 4]) -> bool {
    let here = expr.evaluate(&at(values)).unwrap().is_finite();
    here && match expr {
        Expr::Number(_) | Expr::Name(_) => true,
        Expr::Unary(_, x) | Expr::Lookup(_, _, x) => all_parts_are_finite(x, values),
        Expr::Binary(_, a, b) => all_parts_are_finite(a, values) && all_parts_are_finite(b, values),
        Expr::Clamp(all) => all.iter().all(|x| all_parts_are_finite(x, values)),
        // Conditions are not looked into: leave such trees out.
        Expr::If(..) => false,
    }
}

/// Smooth at every point of the test below, or with kinks that the test keeps away from.
#[test]
fn derivatives_are_central_differences() {
    let texts = [
        "a*theta^3 - b_2*theta*_x + 1/(2 + theta^2)",
        "sin(theta)*cos(a*theta) + tan(theta/3)",
        "asin(theta/4) + acos(theta/5) + atan(a*theta)",
        "sinh(theta)/cosh(theta) + tanh(a*theta) + exp(-theta^2)",
        "ln(3 + theta) + log10(4 + theta*a) + sqrt(5 + theta)",
        "(2 + theta)^a + a^theta + (3 + theta)^(theta/2)",
        "atan2(theta + 2, _x - theta)",
        "abs(theta)*sign(theta) + floor(theta)*theta + step(theta)*theta^2",
        "min(theta, _x) + max(a*theta, b_2)*theta",
        "clamp(theta*a, -1, b_2) + if(theta < _x and not a == 0, theta^2, -theta)",
        "map(theta*a) + map(_x)*theta",
    ];
    let mut checked = 0;
    for text in texts {
        let expr = Expr::parse(text).unwrap();
        let derivative = expr.differentiate("theta");
        for step in 0..60 {
            let theta = -1.473 + 0.05 * f64::from(step);
            let f = |theta: f64| expr.evaluate(&at([0.7, 1.3, theta, 0.211])).unwrap();
            // Error of the difference: h^2 f'''/6 of the order 1e-9, rounding eps/h of 1e-11.
            let h = 1e-5;
            let (left, right) = ((f(theta) - f(theta - h)) / h, (f(theta + h) - f(theta)) / h);
            if 1e-2 <= (left - right).abs() {
                continue; // a kink or jump in between
            }
            let exact = derivative.evaluate(&at([0.7, 1.3, theta, 0.211])).unwrap();
            let difference = (f(theta + h) - f(theta - h)) / (2.0 * h);
            assert!(
                (exact - difference).abs() < 1e-7 * (1.0 + exact.abs()),
                "{text} at {theta}: {exact}, {difference}"
            );
            checked += 1;
        }
    }
    assert!(checked > 600, "{checked}");
}

#[test]
fn rules_at_kinks_are_those_documented() {
    let d = |text: &str, theta: f64| {
        Expr::parse(text)
            .unwrap()
            .differentiate("theta")
            .evaluate(&at([0.0, 0.0, theta, 0.0]))
            .unwrap()
    };
    assert_eq!(d("abs(theta)", 0.0), 0.0);
    assert_eq!(d("sign(theta) + step(theta) + floor(theta)", 0.0), 0.0);
    assert_eq!(d("min(theta, 0)", 0.0), 1.0);
    assert_eq!(d("max(0, theta)", 0.0), 0.0);
    assert_eq!(d("map(theta)", 0.5), -5.5 / 1.5);
    assert_eq!(d("clamp(theta, -1, 1)", 2.0), 0.0);
}

#[test]
fn deep_nesting_is_an_error() {
    let texts = [
        "(".repeat(100_000),
        "-".repeat(100_000) + "x",
        "not ".repeat(100_000) + "x",
        "sin(".repeat(100_000) + "x",
        "x^".repeat(100_000) + "x",
        "x + ".repeat(100_000) + "x",
        format!("if({}a < b, a, b)", "a < b and ".repeat(10_000)),
    ];
    for text in texts {
        let error = Expr::parse(&text).unwrap_err();
        assert!(
            matches!(error.problem, SyntaxProblem::TooDeep { limit: 256 }),
            "{}",
            error.problem
        );
    }
}

/// The deepest trees in a quarter of the stack of a thread: without optimisation, frames are some three times as large.
#[test]
fn the_deepest_trees_need_little_stack() {
    let deep = |open: &str, close: &str, levels: usize| {
        format!("{}x{}", open.repeat(levels), close.repeat(levels))
    };
    let texts = [
        deep("-(", ")", 255),
        deep("sin(", ")", 255),
        deep("max(1, ", ")", 255),
        deep("if(x < 1, 2, ", ")", 253),
        deep("2*(", ")", 255),
        deep("2^", "", 255),
    ];
    let all = move || {
        for text in texts {
            let expr = Expr::parse(&text).unwrap();
            assert!(254 <= expr.depth(), "{text}");
            assert_eq!(Expr::parse(&expr.to_string()).unwrap(), expr);
            assert!(expr.clone().evaluate::<f64>(&|_: &str| Some(0.5)).is_ok());
            assert!(expr.simplify().mentions("x"));
            drop(expr.differentiate("x"));
        }
    };
    std::thread::Builder::new().stack_size(512 << 10).spawn(all).unwrap().join().unwrap();
}

#[test]
fn errors_point_at_the_place() {
    let expected = |text: &str| {
        let error = Expr::parse(text).unwrap_err();
        (error.problem.to_string(), error.column())
    };
    let cases = [
        ("a*(b + )", "expected a number or name, found `)`", 8),
        ("a b", "expected an operator or the end, found `b`", 3),
        ("(a", "expected `)` or an operator, found the end", 3),
        ("a # b", "unknown character `#`", 3),
        ("1e999", "the number `1e999` is too large", 1),
        ("atan2(a)", "`atan2` takes 2 argument(s), found 1", 1),
        ("2 + sin", "expected `(` and the arguments of the function, found the end", 8),
        ("2*(a < b)", "expected a number, found a condition (true or false)", 3),
        ("if(a, b, c)", "expected a condition such as `x < 1`, found a number", 4),
        ("pi(2)", "`pi` is a name of the language and cannot stand here", 1),
        ("slope(2, x)", "expected the name of a table, found `2`", 7),
        ("", "expected a number or name, found the end", 1),
        ("a +\n  ü", "unknown character `ü`", 3),
    ];
    for (text, problem, column) in cases {
        assert_eq!(expected(text), (problem.to_owned(), column), "{text}");
    }
    let error = Expr::parse("a < b").unwrap_err();
    assert_eq!(
        error.problem,
        SyntaxProblem::Expected { expected: "a number", found: Found::Condition }
    );
    assert!(error.to_string().ends_with("    a < b\n    ^^^^^"), "{error}");
}

#[test]
fn common_parts_are_computed_once_and_slow_parts_not_at_all() {
    let scope = scope();
    let parse = |text: &str| Expr::parse(text).unwrap();
    let program = Program::compile(
        &scope,
        &[parse("sin(theta)*a/b_2 + sin(theta)"), parse("(a/b_2)*sin(theta)")],
    )
    .unwrap();
    // sin(theta); sin(theta)*a; that /b_2; the sum; (a/b_2)*sin(theta). a/b_2 alone is slow.
    assert_eq!(program.instructions(), 5);
}

#[test]
fn a_circle_of_definitions_is_an_error() {
    let mut scope = Scope::default();
    for (name, text) in [("p", "q + 1"), ("q", "sin(r)"), ("r", "p")] {
        scope.definitions.push((name.into(), Expr::parse(text).unwrap()));
    }
    let error = Program::compile(&scope, &[Expr::name("p")]).unwrap_err();
    assert_eq!(error.to_string(), "definitions go round in a circle: p → q → r → p");
}
