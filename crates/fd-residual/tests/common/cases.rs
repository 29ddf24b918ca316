//! Published problems about ranks, with the questions they are asked and the answers they have.
//!
//! An answer is a line of text, so that one that changes under a change of coordinates is seen whatever
//! the question was. Yuan et al. (1997); Niemann (1998); Frisk et al. (2012); Varga (2017) and the
//! user's guide of FDITOOLS; Chen, Patton and Zhang (1996); Chen and Patton (1999).

use faer::{Mat, Scale, mat};
use fd_core::IoDims;
use fd_model::{Continuous, Discrete, SampleTime, StateSpace};
use fd_residual::{
    DesignError, GeneratorDesign, ResidualForm,
    analysis::{
        Signature, UnknownInputs, achievable_signatures, fault_to_noise_gap, strong_structure,
        weak_structure,
    },
    decouple::{LeftNullSpace, isolability},
    observer::ErrorPoles,
    optimal::{Exposure, OptimalDesign},
    structured::{RowMethod, Structure, StructuredDesign},
    unknown_input::UnknownInputObserver,
};

use super::transfer::{ONE, Ratio, System, ZERO, realise};

/// A plant with what is not known of its inputs.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    pub(crate) plant: System,
    pub(crate) faults: UnknownInputs,
    pub(crate) disturbances: UnknownInputs,
    pub(crate) noise: UnknownInputs,
    /// The published outputs, as combinations of those of this plant.
    pub(crate) published: Mat<f64>,
}

impl Problem {
    pub(crate) fn new(plant: System, faults: UnknownInputs, disturbances: UnknownInputs) -> Self {
        let (noise, published) =
            (UnknownInputs::none(&plant), Mat::identity(plant.ny(), plant.ny()));
        Self { plant, faults, disturbances, noise, published }
    }

    /// Columns of transfer functions: one known input, then disturbances, faults and noise.
    fn realised<const N: usize>(rows: &[[Ratio; N]; 2], kinds: [usize; 3]) -> Self {
        let all = realise(rows);
        let part = |from: usize, count: usize| {
            let (b, d) = (all.b().subcols(from, count), all.d().subcols(from, count));
            (b.to_owned(), d.to_owned())
        };
        let (b, d) = part(0, 1);
        let plant =
            StateSpace::new(all.a().to_owned(), b, all.c().to_owned(), d, Continuous).unwrap();
        let mut from = 1;
        let [disturbances, faults, noise] = kinds.map(|count| {
            let (b, d) = part(from, count);
            from += count;
            UnknownInputs::new("f", b, d).unwrap()
        });
        Self { noise, ..Self::new(plant, faults, disturbances) }
    }

    /// With entries into the states only.
    fn entering(a: Mat<f64>, c: Mat<f64>, bu: Mat<f64>, bf: Mat<f64>, bd: Mat<f64>) -> Self {
        let ny = c.nrows();
        let into = |b: Mat<f64>| {
            let d = Mat::zeros(ny, b.ncols());
            UnknownInputs::new("f", b, d).unwrap()
        };
        let d = Mat::zeros(ny, bu.ncols());
        let plant = StateSpace::new(a, bu, c, d, Continuous).unwrap();
        Self::new(plant, into(bf), into(bd))
    }

    /// The same matrices as those of a plant in discrete time, for which the algebra is the same.
    fn as_sampled(&self) -> StateSpace<Discrete> {
        let p = &self.plant;
        let domain = Discrete { ts: SampleTime::new(0.1).unwrap() };
        let [a, b, c, d] = [p.a(), p.b(), p.c(), p.d()].map(|m| m.to_owned());
        StateSpace::new(a, b, c, d, domain).unwrap()
    }
}

/// A question to a published problem.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) problem: Problem,
    /// Whether units of faults and noise change the answer, as they do for a gap.
    pub(crate) keeps_units_of_faults: bool,
    pub(crate) ask: fn(&Problem) -> Result<String, DesignError>,
    pub(crate) answer: &'static str,
}

const YUAN: &str = "00010011:1 01101110:2 01111101:2 01111111:2 10101110:1 10111101:1 10111111:1 \
     11001100:2 11011111:2 11100110:2 11101010:2 11101110:2 11110101:2 11110111:2 11111001:2 \
     11111011:2 11111101:2 11111111:2";
const YUAN_STRONG: &str = "00010011:1 01101110:2 01111101:2 01111111:2 10101110:1 10111101:1 \
     10111111:1 11001100:2 11011111:2 11101110:2 11111101:2 11111111:2";

/// All cases, with their published answers.
pub(crate) fn every_case() -> Vec<Case> {
    let case = |name, problem, ask, answer| Case {
        name,
        problem,
        keeps_units_of_faults: false,
        ask,
        answer,
    };
    let gap = |name, problem, answer| Case {
        keeps_units_of_faults: true,
        ..case(name, problem, optimal_gap, answer)
    };
    vec![
        case("Yuan: weak signatures", yuan(), weak_signatures, YUAN),
        // The orders are those of the weak ones, recomputed; the list itself is published.
        case("Yuan: strong signatures", yuan(), strong_signatures, YUAN_STRONG),
        case("Yuan: a bank of all rows", yuan(), yuan_bank, YUAN),
        case("Niemann: signatures", niemann(), bases, "01:1:3:3 10:1:3:3 11:1:4:4"),
        case("Niemann: null spaces", niemann(), null_spaces, "11:4:4 01:3:3 10:3:3"),
        case("Niemann: a bank", niemann(), dedicated_bank, "10:1 01:1"),
        case(
            "three tanks: isolability",
            tanks(),
            told_apart,
            "111111 110110 101110 111111 111111 100111",
        ),
        case("Varga 5.4: signatures", varga_5_4(), weak_signatures, "11:1"),
        case("Varga 5.4: null space", varga_5_4(), null_space, "11:1:1"),
        case("Varga 5.3: signatures", varga_5_3(), weak_signatures, "11:1"),
        case("Varga 5.2: no solution", varga_5_2(), optimal_gap, NO_SOLUTION),
        gap("Varga 5.6: gap", varga_5_6(), "1 noisy of 2, gap 3.000000"),
        gap("FDITOOLS 8: gap", fditools_8(), "1 noisy of 2, gap 2.000000"),
        case("Varga 7.3: what outputs show", varga_7_3(), shown, "10 11"),
        case("strong structure at 0 and 2 rad/s", varga_strong(), strongly_shown, "00 11, 10 01"),
        case("jet engine: observer", jet_engine(), observer, "blind to all 6 unknown inputs"),
        case("Chen and Patton: observer", chen_patton(), observer, "blind to all 1 unknown inputs"),
    ]
}

const NO_SOLUTION: &str = "no solution: none of the 1 residuals that are free of the unknown inputs \
     reacts to the fault \"f 1\", because it reaches the outputs only as they do";

fn weak_signatures(p: &Problem) -> Result<String, DesignError> {
    signatures(p, &[])
}

fn strong_signatures(p: &Problem) -> Result<String, DesignError> {
    signatures(p, &[0.0, 1.0])
}

fn signatures(p: &Problem, frequencies: &[f64]) -> Result<String, DesignError> {
    let found = achievable_signatures(&p.plant, &p.faults, &p.disturbances, frequencies, 4)?;
    let found: Vec<_> =
        found.iter().map(|a| format!("{}:{}", a.signature, a.least_order)).collect();
    Ok(found.join(" "))
}

/// Signatures with the least order, the dimension, and the order of the full basis.
fn bases(p: &Problem) -> Result<String, DesignError> {
    let found = achievable_signatures(&p.plant, &p.faults, &p.disturbances, &[], 4)?;
    let line = |a: &fd_residual::analysis::Achievable| {
        let full: usize = a.basis_orders.iter().sum();
        format!("{}:{}:{}:{full}", a.signature, a.least_order, a.dimension)
    };
    Ok(found.iter().map(line).collect::<Vec<_>>().join(" "))
}

fn yuan_bank(p: &Problem) -> Result<String, DesignError> {
    let bits = YUAN.split(' ').map(|row| row.bytes().take(8).map(|b| b == b'1').collect());
    bank(&p.as_sampled(), p, &Structure::Rows(bits.map(Signature).collect()))
}

pub(crate) fn dedicated_bank(p: &Problem) -> Result<String, DesignError> {
    bank(&p.as_sampled(), p, &Structure::Dedicated)
}

/// What the residuals of the bank react to, and their orders.
fn bank(
    model: &StateSpace<Discrete>,
    p: &Problem,
    structure: &Structure,
) -> Result<String, DesignError> {
    let method = RowMethod::Parity { longest: 4 };
    let bank = StructuredDesign::new(model, &p.faults, &p.disturbances, structure, method)?;
    let found = weak_structure(&bank.form()?, &p.faults.system(model)?)?;
    let rows = found.iter().zip(bank.orders()).map(|(row, order)| format!("{row}:{order}"));
    Ok(rows.collect::<Vec<_>>().join(" "))
}

/// Detectable faults, residuals and order, decoupled from the disturbance and from each fault in turn.
fn null_spaces(p: &Problem) -> Result<String, DesignError> {
    let spaces = [vec![], vec![0], vec![1]].map(|ignored| {
        let unknown = p.disturbances.and(&p.faults.select(&ignored)?)?;
        line(&LeftNullSpace::of(&p.plant, &unknown)?, p)
    });
    Ok(spaces.into_iter().collect::<Result<Vec<_>, _>>()?.join(" "))
}

fn null_space(p: &Problem) -> Result<String, DesignError> {
    line(&LeftNullSpace::of(&p.plant, &p.disturbances)?, p)
}

fn line(space: &LeftNullSpace<Continuous>, p: &Problem) -> Result<String, DesignError> {
    Ok(format!("{}:{}:{}", space.detects(&p.faults)?, space.residual_len(), space.order()))
}

fn told_apart(p: &Problem) -> Result<String, DesignError> {
    let rows = isolability(&p.plant, &p.faults, &p.disturbances)?;
    Ok(rows.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "))
}

fn optimal_gap(p: &Problem) -> Result<String, DesignError> {
    let exposure = Exposure { faults: &p.faults, disturbances: &p.disturbances, noise: &p.noise };
    let design = OptimalDesign::new(&p.plant, &exposure, 3.0)?;
    let (gf, gw) = (p.faults.system(&p.plant)?, p.noise.system(&p.plant)?);
    let gap = fault_to_noise_gap(design.form(), &gf, &gw)?;
    let (noisy, all) = (design.noisy(), design.form().residual_len());
    Ok(format!("{noisy} noisy of {all}, gap {:.6}", gap.ratio))
}

/// The published outputs as residuals.
fn outputs(p: &Problem) -> Result<ResidualForm<Continuous>, DesignError> {
    let (nu, ny) = (p.plant.nu(), p.plant.ny());
    let gain =
        Mat::from_fn(ny, nu + ny, |i, j| if j < nu { 0.0 } else { p.published[(i, j - nu)] });
    ResidualForm::new(IoDims { nu, ny }, StateSpace::gain(gain, Continuous)?)
}

fn joined(rows: &[Signature]) -> String {
    rows.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

fn shown(p: &Problem) -> Result<String, DesignError> {
    Ok(joined(&weak_structure(&outputs(p)?, &p.faults.system(&p.plant)?)?))
}

fn strongly_shown(p: &Problem) -> Result<String, DesignError> {
    let (form, gf) = (outputs(p)?, p.faults.system(&p.plant)?);
    let [rest, two] = [0.0, 2.0]
        .map(|omega| Ok::<_, DesignError>(joined(&strong_structure(&form, &gf, &[omega])?)));
    Ok(format!("{}, {}", rest?, two?))
}

fn observer(p: &Problem) -> Result<String, DesignError> {
    let gd = p.disturbances.system(&p.plant)?;
    let design = UnknownInputObserver::place(&p.plant, gd.b(), &ErrorPoles::Rate(3.0))?;
    let seen = weak_structure(&design.form()?, &gd)?;
    let blind = (0..gd.nu()).filter(|&j| seen.iter().all(|row| !row.0[j])).count();
    let all = if blind == gd.nu() { "all " } else { "" };
    Ok(format!("blind to {all}{blind} unknown inputs"))
}

/// Eight faults of a chain of four compartments.
pub(crate) fn yuan() -> Problem {
    let a = mat![
        [-1.0, 1.0, 0.0, 0.0],
        [1.0, -2.0, 1.0, 0.0],
        [0.0, 1.0, -2.0, 1.0],
        [0.0, 0.0, 1.0, -2.0]
    ];
    let c = mat![[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let b = mat![[1.0], [0.0], [0.0], [0.0]];
    let bf = mat![
        [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 1.0]
    ];
    Problem::entering(a, c, b, bf, Mat::zeros(4, 0))
}

/// All five states measured, faults of both inputs, one disturbance.
pub(crate) fn niemann() -> Problem {
    let scaled = |m: Mat<f64>| Scale(1000.0) * m;
    let a = scaled(mat![
        [-0.0782, 0.2939, 0.0220, 0.0208, -0.0291],
        [0.0077, -0.0278, 0.0015, -0.0015, 0.0026],
        [-1.3251, 5.32608, -0.5263, 0.2214, -0.4777],
        [1.0809, -4.4452, 0.3770, -0.4631, 0.4032],
        [2.1532, -8.6386, 0.7811, -0.5745, 0.7816]
    ]);
    let bd = scaled(mat![[0.0443], [-0.0042], [0.7910], [-0.6598], [-1.2881]]);
    let bu = mat![
        [-0.007_197, 0.003_005],
        [0.003_473, 0.000_284],
        [1.218_502, -0.032_866],
        [1.322_502, 0.020_147],
        [-0.082_265, 0.024_388]
    ];
    Problem::entering(a, Mat::identity(5, 5), bu.clone(), bu, bd)
}

/// `p' = A p + e₁ q₀ + B f` for `R = C = 1`; measured are `p₁` and `q₂ = p₂ − p₃ + f_V2`. Faults of
/// three valves, then of three capacities; the second and third valve and the third capacity look alike.
fn tanks() -> Problem {
    let a = mat![[-1.0, 1.0, 0.0], [1.0, -2.0, 1.0], [0.0, 1.0, -2.0]];
    let (b, c) = (mat![[1.0], [0.0], [0.0]], mat![[1.0, 0.0, 0.0], [0.0, 1.0, -1.0]]);
    let plant = StateSpace::new(a, b, c, Mat::zeros(2, 1), Continuous).unwrap();
    let bf = mat![
        [-1.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        [1.0, -1.0, 0.0, 0.0, 1.0, 0.0],
        [0.0, 1.0, -1.0, 0.0, 0.0, 1.0]
    ];
    let df = Mat::from_fn(2, 6, |i, j| if (i, j) == (1, 1) { 1.0 } else { 0.0 });
    let faults = UnknownInputs::new("f", bf, df).unwrap();
    let none = UnknownInputs::none(&plant);
    Problem::new(plant, faults, none)
}

const U1: Ratio = (&[1.0, 1.0], &[1.0, 2.0]);
const U2: Ratio = (&[1.0, 2.0], &[1.0, 3.0]);
const D1: Ratio = (&[1.0, -1.0], &[1.0, 2.0]);
const LAG: Ratio = (&[1.0], &[1.0, 2.0]);

fn varga_5_4() -> Problem {
    let first: Ratio = (&[1.0, 1.0], &[1.0, -2.0]);
    let second: Ratio = (&[1.0, 2.0], &[1.0, -3.0]);
    Problem::realised(&[[first, D1, first, ZERO], [second, ZERO, second, ONE]], [1, 2, 0])
}

fn varga_5_3() -> Problem {
    Problem::realised(&[[U1, D1, U1, ZERO], [U2, ZERO, U2, ONE]], [1, 2, 0])
}

fn varga_5_2() -> Problem {
    Problem::realised(&[[U1, LAG, U1, ZERO], [U2, ZERO, ZERO, ONE]], [1, 2, 0])
}

fn varga_5_6() -> Problem {
    Problem::realised(&[[U1, U1, ZERO, LAG], [U2, ZERO, ONE, ZERO]], [0, 2, 1])
}

fn fditools_8() -> Problem {
    Problem::realised(&[[U1, U1, ONE, ZERO, D1], [U2, U2, ZERO, ONE, ZERO]], [0, 3, 1])
}

/// `G_f = [(s+1)/(s−2) 0; (s+2)/(s−3) 1]` in five states.
fn varga_7_3() -> Problem {
    let a = Mat::from_fn(5, 5, |i, j| if i == j { [-2.0, -3.0, -1.0, 2.0, 3.0][i] } else { 0.0 });
    let c = mat![[-1.0, 0.0, -1.0, 1.5, 0.0], [0.0, -1.0, 0.0, 0.0, 2.5]];
    let bu = mat![[1.0], [1.0], [0.0], [0.0], [0.0]];
    let plant = StateSpace::new(a, bu, c, mat![[1.0], [1.0]], Continuous).unwrap();
    let bd = mat![[0.0], [0.0], [2.0], [0.0], [0.0]];
    let bf = mat![[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [2.0, 0.0], [2.0, 0.0]];
    let faults = UnknownInputs::new("f", bf, mat![[1.0, 0.0], [1.0, 1.0]]).unwrap();
    let disturbance = UnknownInputs::new("d", bd, mat![[1.0], [0.0]]).unwrap();
    Problem::new(plant, faults, disturbance)
}

/// `G_f = [s/(s+1) 0; (s²+4)/(s+3)² 1]`.
fn varga_strong() -> Problem {
    let (fades, notch): (Ratio, Ratio) =
        ((&[1.0, 0.0], &[1.0, 1.0]), (&[1.0, 0.0, 4.0], &[1.0, 6.0, 9.0]));
    Problem::realised(&[[ONE, fades, ZERO], [ONE, notch, ONE]], [0, 2, 0])
}

/// The six directions `E*` of nonlinear terms, of rank two.
fn jet_engine() -> Problem {
    let a = mat![[-1.5581, 0.6925, 0.3974], [0.2619, -2.2228, 0.2238], [0.0, 0.0, -10.0]];
    let c = mat![
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.55107, 0.13320, 0.30603],
        [0.55217, 0.13526, 0.32912],
        [-0.25693, -0.23625, 0.61299]
    ];
    let e = mat![
        [1.3293, 3.4440, 0.1375, -5.1304, -1.7826, -1.8719],
        [5.6812, -0.5281, -0.3385, -1.6193, 0.5229, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    ];
    let b = mat![[0.0], [0.0], [10.0]];
    Problem::entering(a, c, b.clone(), b, e)
}

fn chen_patton() -> Problem {
    let a = mat![[-1.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, -1.0]];
    let b = mat![[-1.0], [0.0], [0.0]];
    let c = mat![[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    Problem::entering(a, c, b.clone(), b.clone(), b)
}
