//! Published problems about ranks, with the questions they are asked and the answers they have.
//!
//! An answer is a line of text, so that one that changes under a change of coordinates is seen whatever
//! the question was. The problems and their sources are in `problems.rs`.

use faer::Mat;
use fd_core::IoDims;
use fd_model::{Continuous, Discrete, StateSpace};
use fd_residual::{
    DesignError, GeneratorDesign, ResidualForm,
    analysis::{
        Signature, achievable_signatures, fault_to_noise_gap, strong_structure, weak_structure,
    },
    decouple::{LeftNullSpace, isolability},
    observer::ErrorPoles,
    optimal::{Exposure, OptimalDesign},
    structured::{RowMethod, Structure, StructuredDesign},
    unknown_input::UnknownInputObserver,
};

use super::problems::{
    Problem, chen_patton, fditools_8, jet_engine, niemann, tanks, varga_5_2, varga_5_3, varga_5_4,
    varga_5_6, varga_7_3, varga_strong, yuan,
};

/// A question to a published problem.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) problem: Problem,
    /// Whether units of faults and noise change the answer, as they do for a gap.
    pub(crate) keeps_units_of_faults: bool,
    pub(crate) ask: fn(&Problem) -> Result<String, DesignError>,
    pub(crate) answer: &'static str,
}

pub(crate) const YUAN: &str = "00010011:1 01101110:2 01111101:2 01111111:2 10101110:1 10111101:1 10111111:1 \
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
