//! Statistics of a window against what healthy windows were like, and which channels they come from.
//!
//! With `w` the centred and scaled window and `S` the whitened scores,
//!
//! ```text
//! T²  = ‖S w‖²                      how far inside of what moves together
//! T²r = ‖S_r w‖²                    the same of the canonical directions that are left (CVA)
//! Q   = ‖w − B S w‖²                how far outside of it, the squared prediction error
//! ```
//!
//! * **Source.** Jackson and Mudholkar (1979) for principal components, Russell, Chiang and Braatz (2000,
//!   eq. 6 to 9) for canonical variates.
//! * **Contributions.** A statistic `wᵀ M w` is divided among the channels as the squares of `M^½ w`, summed
//!   over the samples of the window: the complete decomposition of Alcala and Qin (2009). They are not
//!   negative and sum to the statistic. A large one says where to look first, not what is wrong: a fault of
//!   one channel is smeared over those that are correlated with it.
//! * **Assumptions.** The plant runs where the healthy logs ran.
//! * **Do not use** it where the operating point changes between logs: every change is an alarm.

mod design;
mod run;

pub(crate) use self::design::Parts;
pub use self::{
    design::MonitorDesign,
    run::{Limits, Monitor, Statistic, Statistics},
};
