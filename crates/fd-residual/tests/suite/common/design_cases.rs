//! Published answers of designs: filters of least order and model matching. Varga (2017), examples 5.4, 5.6c and 5.12; that of 5.6 is
//! `√½`, what rest alone allows.

use faer::{Mat, MatRef, mat};
use fd_model::{Continuous, StateSpace, TransferFunction};
use fd_residual::{
    DesignError,
    analysis::{Signature, UnknownInputs, fault_effects},
    least_order::{LeastOrderBank, LeastOrderDesign},
    matching::{ApproximateMatching, ExactMatching, MatchingNorm},
    observer::ErrorPoles,
    optimal::Exposure,
    rank::RankTolerance,
    structured::Structure,
};

use super::{
    cases::{Case, YUAN},
    problems::{Problem, niemann, varga_5_4, varga_5_6, yuan},
    transfer::{ONE, Ratio, ZERO},
};

/// All of them; units of faults are kept where a reference or a gain has them.
pub(crate) fn design_cases() -> Vec<Case> {
    let case = |name, problem, ask, answer| Case {
        name,
        problem,
        keeps_units_of_faults: false,
        ask,
        answer,
    };
    let gain = |name, problem, ask, answer| Case {
        keeps_units_of_faults: true,
        ..case(name, problem, ask, answer)
    };
    vec![
        case("Niemann: filters of least order", niemann(), niemann_filters, "01:1 10:1 11:1"),
        case("Yuan: filters of least order", yuan(), yuan_filters, YUAN),
        gain(
            "Varga 5.4: filter of least order",
            varga_5_4(),
            one_filter,
            "order 1, gains at rest as 0.666667 to 1",
        ),
        gain(
            "Varga 5.4: exact matching",
            varga_5_4(),
            published_filter,
            "update 1.000000, order 1",
        ),
        gain("Varga 5.12: voting", triplex(), voting, "updates 1.000000 1.000000 1.000000"),
        gain("Varga 5.6: approximate matching", varga_5_6(), nearest, "0.707 away"),
    ]
}

fn filters(p: &Problem, rows: &str) -> Result<String, DesignError> {
    let count = p.faults.len();
    let bits = rows.split(' ').map(|row| row.bytes().take(count).map(|b| b == b'1').collect());
    let structure = Structure::Rows(bits.map(Signature).collect());
    let tolerance = RankTolerance::default();
    let bank =
        LeastOrderBank::new(&p.plant, &p.faults, &p.disturbances, &structure, 3.0, tolerance)?;
    let rows = structure.rows(count)?;
    let lines =
        rows.iter().zip(bank.rows()).map(|(row, filter)| format!("{row}:{}", filter.order()));
    Ok(lines.collect::<Vec<_>>().join(" "))
}

fn niemann_filters(p: &Problem) -> Result<String, DesignError> {
    filters(p, "01 10 11")
}

fn yuan_filters(p: &Problem) -> Result<String, DesignError> {
    filters(p, YUAN)
}

fn one_filter(p: &Problem) -> Result<String, DesignError> {
    let (both, poles) = (Signature(vec![true, true]), ErrorPoles::Rate(3.0));
    let design = LeastOrderDesign::new(&p.plant, &p.faults, &p.disturbances, &both, &poles)?;
    let effects = fault_effects(design.form(), &p.faults.system(&p.plant)?)?;
    let at_rest = |fault: usize| effects[fault].steady.unwrap_or(f64::NAN);
    // The plant has no pole at rest.
    Ok(format!("order {}, gains at rest as {:.6} to 1", design.order(), at_rest(0) / at_rest(1)))
}

fn gain_at_rest(system: &StateSpace<Continuous>) -> Result<f64, DesignError> {
    Ok(system.dc_gain()?[(0, 0)].abs())
}

/// The published internal form `[(s+2)/(s+3), (s−3)/(s+3)]` as reference gives the published filter back, with `M = 1`.
fn published_filter(p: &Problem) -> Result<String, DesignError> {
    let ratio =
        |zero: f64| TransferFunction::new(&[1.0, zero], &[1.0, 3.0]).map_err(DesignError::from);
    let reference =
        TransferFunction::realise_matrix(&[vec![ratio(2.0)?, ratio(-3.0)?]], Continuous)?;
    let design = ExactMatching::new(&p.plant, &p.faults, &p.disturbances, &reference, 3.0)?;
    let order = design.form().system().minimal(1e-7)?.nx();
    Ok(format!("update {:.6}, order {order}", gain_at_rest(&design.updates()[0])?))
}

/// Three sensors of one signal: `M_r` compares them in pairs, and there is no other way.
fn triplex() -> Problem {
    let signal: Ratio = (&[1.0], &[1.0, 0.4, 1.0]);
    let load: Ratio = (&[1.0, 3.0], &[1.0, 2.0, 5.0]);
    Problem::realised(
        &[
            [signal, load, ONE, ZERO, ZERO],
            [signal, load, ZERO, ONE, ZERO],
            [signal, load, ZERO, ZERO, ONE],
        ],
        [1, 3, 0],
    )
}

fn voting(p: &Problem) -> Result<String, DesignError> {
    let pairs = mat![[0.0, 1.0, -1.0], [-1.0, 0.0, 1.0], [1.0, -1.0, 0.0]];
    let reference = StateSpace::gain(pairs, Continuous)?;
    let design = ExactMatching::new(&p.plant, &p.faults, &p.disturbances, &reference, 1.0)?;
    let gains: Result<Vec<_>, DesignError> =
        design.updates().iter().map(|update| Ok(format!("{:.6}", gain_at_rest(update)?))).collect();
    Ok(format!("updates {}", gains?.join(" ")))
}

/// The sum of the published outputs, as near as can be to the sum of the faults.
fn nearest(p: &Problem) -> Result<String, DesignError> {
    let sum = mat![[1.0, 1.0]] * &p.published;
    let onto = |m: MatRef<'_, f64>| &sum * m;
    let plant = StateSpace::new(
        p.plant.a().to_owned(),
        p.plant.b().to_owned(),
        onto(p.plant.c()),
        onto(p.plant.d()),
        Continuous,
    )?;
    let of = |unknown: &UnknownInputs| {
        let entry = unknown.system(&p.plant)?;
        UnknownInputs::new("f", entry.b().to_owned(), onto(entry.d()))
    };
    let (faults, noise, none) = (of(&p.faults)?, of(&p.noise)?, UnknownInputs::none(&plant));
    let exposure = Exposure { faults: &faults, disturbances: &none, noise: &noise };
    let reference = StateSpace::gain(Mat::from_fn(1, 2, |_, _| 1.0), Continuous)?;
    let design = ApproximateMatching::new(&plant, &exposure, &reference, 3.0, MatchingNorm::Peak)?;
    let error = design.error(&plant, &exposure, &reference)?.hinf_norm(1e-8)?.norm;
    Ok(format!("{error:.3} away"))
}
