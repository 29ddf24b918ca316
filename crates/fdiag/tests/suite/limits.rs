//! Specs that ask for more than any machine has: each is refused by its key, at once.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use fdiag::{
    core::{Limits, Resource},
    spec::{BiasSpec, PipelineSpec, testing},
};

/// Lines of specs, the key that is too large, and the limit.
const TOO_LARGE: [(&str, &str, Resource); 21] = [
    (
        "detector = { kind = 'chi-square', window = 18446744073709551615, false_alarms = RATE }",
        "detector.window",
        Resource::Window,
    ),
    (
        "detector = { kind = 'chi-square', window = 9223372036854775807, false_alarms = RATE }",
        "detector.window",
        Resource::Window,
    ),
    (
        "generator = { kind = 'zonotope', rate = 1.0, noise = [1.0], columns = 9223372036854775807 }",
        "generator.columns",
        Resource::Window,
    ),
    (
        "detector = { kind = 'glr', window = 10001, false_alarms = RATE }",
        "detector.window",
        Resource::Window,
    ),
    (
        "detector = { kind = 'glr', whitening = 1000, false_alarms = RATE }",
        "detector.whitening",
        Resource::Order,
    ),
    (
        "detector = { kind = 'two-sample', test = 'mean', window = 1000000, false_alarms = RATE }",
        "detector.window",
        Resource::Window,
    ),
    (
        "detector = { kind = 'adaptive-threshold', corners = 1000000, false_alarms = RATE }",
        "detector.corners",
        Resource::Corners,
    ),
    (
        "detector = { kind = 'adaptive-threshold', bound = { kind = 'ensemble', models = 100000000 }, false_alarms = RATE }",
        "detector.bound.models",
        Resource::Models,
    ),
    (
        "bias = { orders = { kind = 'fixed', na = 9223372036854775807, nb = 3, delay = 0, offset = false } }",
        "bias.orders.na",
        Resource::Order,
    ),
    (
        "bias = { orders = { kind = 'fixed', na = 2, nb = 1000, delay = 0, offset = false } }",
        "bias.orders.nb",
        Resource::Order,
    ),
    (
        "bias = { orders = { kind = 'fixed', na = 2, nb = 3, delay = 100000, offset = false } }",
        "bias.orders.delay",
        Resource::Window,
    ),
    (
        "bias = { orders = { kind = 'select', most = 9223372036854775807 } }",
        "bias.orders.most",
        Resource::Order,
    ),
    ("bias = { learning = { kind = 'armax', nc = 1000000 } }", "bias.learning.nc", Resource::Order),
    (
        "bias = { structure = { kind = 'hammerstein', basis = { kind = 'polynomial', degree = 1000 } } }",
        "bias.structure.basis.degree",
        Resource::Order,
    ),
    (
        "bias = { structure = { kind = 'scheduled', time_constant_s = 1.0, regions = 1000000 } }",
        "bias.structure.regions",
        Resource::Order,
    ),
    (
        "bias = { structure = { kind = 'state-space', states = 1000 } }",
        "bias.structure.states",
        Resource::Order,
    ),
    (
        "bias = { structure = { kind = 'state-space', states = 2, horizon = 1000000 } }",
        "bias.structure.horizon",
        Resource::Window,
    ),
    (
        "generator = { kind = 'parity', order = 9223372036854775807 }",
        "generator.order",
        Resource::Order,
    ),
    (
        "generator = { kind = 'decoupled', rate = 2.0, disturbance = { kind = 'perturbed', rank = 1, models = 100000000 } }",
        "generator.disturbance.models",
        Resource::Models,
    ),
    ("rule = { raise = 3, out_of = 100000 }", "rule.out_of", Resource::Window),
    ("hold_missing = 18446744073709551615", "hold_missing", Resource::Count),
];

#[test]
fn what_is_too_large_is_refused_by_its_key() {
    for (text, key, resource) in TOO_LARGE {
        let text = text.replace("RATE", "{ kind = 'per-sample', rate = 1e-2 }");
        let spec: PipelineSpec = text.parse().unwrap();
        let error = spec.check_limits(&Limits::default()).unwrap_err();
        assert_eq!((error.what.as_str(), error.resource), (key, resource), "{text}");
    }
}

#[test]
fn the_specs_that_are_tested_are_within() {
    let mut specs = vec![PipelineSpec::default()];
    let with = |structure| BiasSpec { structure, ..BiasSpec::default() };
    for (_, detector) in testing::every_detector().unwrap() {
        specs.push(PipelineSpec { detector, ..PipelineSpec::default() });
    }
    for (_, structure) in testing::every_structure().unwrap() {
        specs.push(PipelineSpec { bias: with(structure), ..PipelineSpec::default() });
    }
    for spec in specs {
        spec.check_limits(&Limits::default()).unwrap();
        let nothing = Limits { order: 0, ..Limits::default() };
        assert!(spec.check_limits(&nothing).is_err(), "a service may set lower ones");
    }
}
