//! Fault estimates instead of residuals: size and time course, with an interval.
//!
//! * **Equation.** The stationary Kalman filter of the plant with its faults as additional random-walk states,
//!   `x⁺ = A x + B u + B_f f + w`, `f⁺ = f + w_f`, `y = C x + D u + D_f f + v`; the "residual" is the estimate
//!   `f̂(k)` from all samples up to `k`, in the unit of the fault (Friedland 1969; Chen and Patton 1999,
//!   section 2.9, input observers).
//! * **Interval.** `f̂ ± z σ` with the stationary standard deviation `σ` of the error
//!   ([`FaultEstimatorDesign::deviations`]) holds its level for faults that walk as assumed; it is
//!   too wide for a constant fault, and too narrow while the filter still follows a jump.
//! * **Assumptions.** The model is right: what it does not explain is called a fault. All faults
//!   together must be observable: no more faults than outputs, each visible at steady state.
//! * **Do not use** it to detect: a compensated residual against a calibrated threshold says
//!   whether there is a fault; this says how large it is.

mod design;

pub use self::design::{FaultEstimatorDesign, FaultNoise};
