//! Answers about ranks do not depend on coordinates and units: published problems, each in 20 changes of
//! coordinates, 20 of units, and 20 of both. The shares before and after are in `docs/results/ranks.md`.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::cases::{Case, dedicated_bank, every_case};
use crate::common::changes::Change;
use crate::common::design_cases::design_cases;
use crate::common::{
    Draw, draws, plant,
    problems::{Problem, yuan},
    random_matrix, rng,
};
use faer::{Mat, mat};
use fd_model::{Continuous, StateSpace};
use fd_residual::{
    DesignError,
    analysis::{SignatureSearch, UnknownInputs, fault_to_noise_gap},
    decouple::LeftNullSpace,
    optimal::{Exposure, OptimalDesign},
    parity::ParityDesign,
    rank::{RankDecision, RankTolerance},
};
use proptest::prelude::*;

/// Every case gives its published answer after each of 20 changes.
fn holds(change: impl Fn(&Case, u64) -> Problem) {
    let mut wrong = Vec::new();
    for case in every_case().into_iter().chain(design_cases()) {
        for seed in 0..20 {
            let found = (case.ask)(&change(&case, seed)).unwrap_or_else(|error| error.to_string());
            if found != case.answer {
                wrong.push(format!("{} {seed}: {found}", case.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong answers:\n{}", wrong.len(), wrong.join("\n"));
}

/// Each signal in units of its own, over `2 decades` orders of magnitude.
fn in_units(case: &Case, problem: &Problem, decades: f64, seed: u64) -> Problem {
    Change::units(problem, decades, !case.keeps_units_of_faults, seed).of(problem)
}

#[test]
fn published_answers_are_given() {
    for case in every_case().into_iter().chain(design_cases()) {
        let found = (case.ask)(&case.problem).unwrap_or_else(|error| error.to_string());
        assert_eq!(found, case.answer, "{}", case.name);
    }
}

#[test]
fn answers_do_not_depend_on_coordinates() {
    holds(|case, seed| Change::coordinates(&case.problem, seed).of(&case.problem));
}

#[test]
fn answers_do_not_depend_on_units() {
    holds(|case, seed| in_units(case, &case.problem, 3.0, seed));
    holds(|case, seed| in_units(case, &case.problem, 4.0, 100 + seed));
}

#[test]
fn answers_do_not_depend_on_both() {
    holds(|case, seed| {
        let mixed = Change::coordinates(&case.problem, seed).of(&case.problem);
        in_units(case, &mixed, 4.0, 200 + seed)
    });
}

/// A random plant with two faults, one of them of a sensor too, and a disturbance.
fn random_problem(draw: Draw) -> Problem {
    let sampled = plant(draw);
    let [a, b, c, d] = [sampled.a(), sampled.b(), sampled.c(), sampled.d()].map(|m| m.to_owned());
    // All modes decay in continuous time too.
    let a = a - Mat::<f64>::identity(draw.nx, draw.nx);
    let model = StateSpace::new(a, b, c, d, Continuous).unwrap();
    let into = random_matrix(&mut rng(draw.seed ^ 3), draw.nx, 3);
    let direct = Mat::from_fn(draw.ny, 3, |i, j| if i + 2 == j { 1.0 } else { 0.0 });
    let all = UnknownInputs::new("f", into, direct).unwrap();
    let (faults, disturbance) = (all.select(&[0, 2]).unwrap(), all.select(&[1]).unwrap());
    Problem::new(model, faults, disturbance)
}

/// Other coordinates, and those in other units.
fn changed(problem: &Problem, faults: bool, seed: u64) -> [Problem; 2] {
    let mixed = Change::coordinates(problem, seed).of(problem);
    let scaled = Change::units(&mixed, 3.0, faults, seed).of(&mixed);
    [mixed, scaled]
}

/// Signatures, least orders and dimensions, and how near the nearest decision was.
fn signatures(p: &Problem) -> (Vec<(String, usize, usize)>, f64) {
    let search = SignatureSearch { longest: p.plant.nx() + 1, ..SignatureSearch::default() };
    let answer = search.run(&p.plant, &p.faults, &p.disturbances).unwrap();
    let found = answer.found.iter().map(|a| (a.signature.to_string(), a.least_order, a.dimension));
    (found.collect(), answer.nearest.margin())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Of a random plant too: as many residuals, of the same order, with the same faults in them.
    #[test]
    fn null_spaces_do_not_depend_on_coordinates_and_units(draw in draws(), seed in any::<u64>()) {
        let problem = random_problem(draw);
        let answer = |p: &Problem| match LeftNullSpace::of(&p.plant, &p.disturbances) {
            Err(DesignError::NothingLeft { .. }) => (0, 0, String::new()),
            space => {
                let space = space.unwrap();
                let seen = space.detects(&p.faults).unwrap().to_string();
                (space.residual_len(), space.order(), seen)
            }
        };
        for other in changed(&problem, true, seed) {
            prop_assert_eq!(answer(&other), answer(&problem));
        }
    }

    /// The same signatures at the same orders, and the same bank or the same kind of refusal.
    #[test]
    fn signatures_and_banks_do_not_depend_on_coordinates_and_units(
        draw in draws(),
        seed in any::<u64>(),
    ) {
        let problem = random_problem(Draw { nx: draw.nx.min(4), ..draw });
        let (found, margin) = signatures(&problem);
        // Two changes of condition 10 on either side of a matrix move its singular values by up to 1e2
        // each way: what is nearer to the tolerance has no answer of its own.
        prop_assume!(1e4 < margin);
        let bank = |p: &Problem| dedicated_bank(p).map_err(|error| std::mem::discriminant(&error));
        for other in changed(&problem, true, seed) {
            prop_assert_eq!(signatures(&other).0, found.clone());
            prop_assert_eq!(bank(&other), bank(&problem));
        }
    }

    /// The same gap between faults and noise.
    #[test]
    fn gaps_do_not_depend_on_coordinates_and_units(draw in draws(), seed in any::<u64>()) {
        let Draw { nx, ny, .. } = draw;
        let mut problem = random_problem(Draw { nx: nx.min(4), ny: ny.min(3), ..draw });
        let (nx, ny) = (problem.plant.nx(), problem.plant.ny());
        let into = random_matrix(&mut rng(draw.seed ^ 0xa), nx, nx + ny);
        let direct = Mat::from_fn(ny, nx + ny, |i, j| if i + nx == j { 0.5 } else { 0.0 });
        problem.noise = UnknownInputs::new("w", into, direct).unwrap();
        problem.disturbances = UnknownInputs::none(&problem.plant);
        let gap = |p: &Problem| {
            let exposure =
                Exposure { faults: &p.faults, disturbances: &p.disturbances, noise: &p.noise };
            let design = OptimalDesign::new(&p.plant, &exposure, 1.0).unwrap();
            let [gf, gw] = [&p.faults, &p.noise].map(|g| g.system(&p.plant).unwrap());
            fault_to_noise_gap(design.form(), &gf, &gw).unwrap().ratio
        };
        let expected = gap(&problem);
        for other in changed(&problem, false, seed) {
            let found = gap(&other);
            // Peaks are searched to 1e-8, at frequencies that are found again only nearly.
            prop_assert!((found / expected - 1.0).abs() < 1e-6, "{} of {}", found, expected);
        }
    }
}

/// The nearest decision behind Yuan's signatures is far from the tolerance, in any coordinates: to move
/// one, the tolerance would have to be wrong by four orders of magnitude.
#[test]
fn published_decisions_are_clear() {
    for seed in 0..5 {
        let p = Change::coordinates(&yuan(), seed).of(&yuan());
        let search = SignatureSearch { longest: 4, ..SignatureSearch::default() };
        let found = search.run(&p.plant, &p.faults, &p.disturbances).unwrap();
        assert!(1e4 < found.nearest.margin(), "{}", found.nearest);
        assert!(found.found.iter().all(|one| found.nearest.margin() <= one.nearest.margin()));
    }
}

/// A fault and a load that enter in directions a millionth apart: told apart by a model that is exact, and
/// not by one that is known to four digits.
#[test]
fn the_tolerance_is_that_of_the_model() {
    let weak = 1e-6;
    let (a, b) = (mat![[-1.0, 0.0], [0.0, -3.0]], mat![[1.0, 1.0], [1.0, 1.0 + weak]]);
    let plant =
        StateSpace::new(a, Mat::zeros(2, 1), Mat::identity(2, 2), Mat::zeros(2, 1), Continuous)
            .unwrap();
    let inputs = UnknownInputs::new("f", b, Mat::zeros(2, 2)).unwrap();
    let (load, fault) = (inputs.select(&[0]).unwrap(), inputs.select(&[1]).unwrap());
    let reaction = |tolerance: RankTolerance| {
        let space = LeftNullSpace::within(&plant, &load, tolerance).unwrap();
        space.reactions(&fault).unwrap()[0]
    };
    let exact = reaction(RankTolerance::default());
    assert_eq!(exact.rank, 1, "{exact}");
    // What is left of the fault is a millionth, over the size of the other data.
    let near = exact.smallest_kept;
    assert!(0.01 * weak < near && near < weak, "{near}");
    let rough = reaction(RankTolerance::new(1e-4).unwrap());
    assert_eq!(rough.rank, 0, "{rough}");
    assert!(rough.to_string().starts_with("rank 0 of 1; the next value is"), "{rough}");
}

#[test]
fn decisions_say_how_near_they_were() {
    let tolerance = RankTolerance::new(1e-6).unwrap();
    let both = RankDecision::of(3, &[1.0, 4e-5, 5e-8], tolerance);
    let said = "rank 2 of 3; the next value is 20 times smaller than the tolerance 1e-6, the last one 40 times larger";
    assert_eq!(both.to_string(), said);
    assert!((both.margin() - 20.0).abs() < 1e-12);
    let none = RankDecision::of(1, &[2.5e-7], tolerance);
    let said = "rank 0 of 1; the next value is 4.0 times smaller than the tolerance 1e-6";
    assert_eq!(none.to_string(), said);
    let full = RankDecision::of(1, &[1.0], tolerance).to_string();
    assert_eq!(full, "rank 1 of 1; there is no further value, the last one 1e6 times larger");
}

/// A fault that two sensors show alike but for a part in 10¹¹: no parity relation rests on that.
#[test]
fn rounding_is_no_relation() {
    let domain = crate::common::sampled();
    let c = mat![[1.0], [1.0]];
    let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], c, Mat::zeros(2, 1), domain).unwrap();
    let direct = mat![[0.0, 1.0], [0.0, 1.0 + 1e-11]];
    let faults = UnknownInputs::new("f", mat![[1.0, 0.0]], direct).unwrap();
    // The second fault is one of both sensors alike: y₁ − y₂, which forgets the actuator, sees 1e-11 of
    // it, and each of them with its past all of it.
    let design = |bits: [bool; 2], longest| {
        let (none, wanted) =
            (UnknownInputs::none(&lag), fd_residual::analysis::Signature(bits.to_vec()));
        ParityDesign::with_signature(&lag, &faults, &none, &wanted, longest)
    };
    assert!(matches!(design([false, true], 3), Err(DesignError::NoSignature { .. })));
    assert_eq!(design([true, true], 1).unwrap().order(), 1);
}
