//! The F100 turbofan with 16 states, 3 inputs and 5 outputs.

use fd_model::{Channel, Continuous, StateSpace};

use super::{
    f100_matrices::{A, B, C, D},
    matrix,
};
use crate::{error::EngineError, model::EngineModel};

/// The linear model of the F100 engine of the multivariable control literature.
///
/// Transcribed from problem JE1 of the `COMPleib` collection, of which it is the block of the
/// engine proper: rows and columns 1 to 16, with the actuator positions as inputs. Names and
/// units of the signals follow the literature on the F100 control problem and are *not* in the
/// collection; that the third input is the compressor's variable vanes is inferred.
///
/// US units; the operating point is not published, and entries spread over nine decades: use
/// [`EngineModel::equilibrated`] before any method that depends on units (reduction, observers).
///
/// # Errors
///
/// Never in practice; the signature is that of every model.
///
/// ```
/// let (engine, scaling) = fd_jetengine::f100()?.equilibrated()?;
/// assert_eq!((engine.model.nx(), engine.model.nu(), engine.model.ny()), (16, 3, 5));
/// assert!(engine.model.is_stable()?);
/// assert_eq!(scaling.y.len(), 5);
/// # Ok::<(), fd_jetengine::EngineError>(())
/// ```
pub fn f100() -> Result<EngineModel, EngineError> {
    let channels = |list: &[(&str, &str)]| -> Vec<Channel> {
        list.iter().map(|&(name, unit)| Channel::new(name, unit)).collect()
    };
    Ok(EngineModel {
        name: "F100".into(),
        model: StateSpace::new(matrix(&A), matrix(&B), matrix(&C), matrix(&D), Continuous)?,
        inputs: channels(&[("WFMB", "lb/h"), ("AJ", "ft2"), ("CIVV", "deg")]),
        outputs: channels(&[
            ("FN", "lbf"),
            ("WFAN", "lb/s"),
            ("T4", "degR"),
            ("SMAF", "1"),
            ("SMHC", "1"),
        ]),
        states: channels(&[
            ("N1", "rpm"),
            ("N2", "rpm"),
            ("P3", "psi"),
            ("P45", "psi"),
            ("P7m", "psi"),
            ("T25h", "degR"),
            ("T25c", "degR"),
            ("T3", "degR"),
            ("T4hi", "degR"),
            ("T4lo", "degR"),
            ("T4", "degR"),
            ("T45hi", "degR"),
            ("T45lo", "degR"),
            ("T5", "degR"),
            ("T6c", "degR"),
            ("T7m", "degR"),
        ]),
        operating_point: None,
        note: "COMPleib JE1, engine block; signal names from the F100 literature".into(),
    })
}
