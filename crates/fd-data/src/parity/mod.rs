//! Parity relations from data: `K [z(k−s); …; z(k)] = 0` for all windows of the healthy plant.
//!
//! * **Equation.** Windows of inputs and outputs of a linear plant of `n` states obey `Y = Γ x + T U`, so that they fill
//!   a space of `(s + 1) nu + n` dimensions only. With the windows before them as instruments, the triangular
//!   factor of `[Z_p; U; Y]` has the block rows `[L21 L22 0]` and `[L31 L32 L33]`; `L33` is noise that the past does
//!   not foretell, and `K` is the left null space of `[L21 L22; L31 L32]`: a data-driven realisation of the stable
//!   kernel representation. Without noise its rows span the parity space of the model (Chow and Willsky 1984).
//! * **Source.** Ding (2014, sections 4.2 to 4.3), on the instruments of Chou and Verhaegen (1997); Wang and
//!   Qin (2002).
//! * **How many states** may be given. Otherwise the singular values count that are larger than what `L33` would
//!   leave of nothing, by the bound on Gaussian matrices of Davidson and Szarek (2001).
//! * **Assumptions.** A linear plant near one operating point, whose constant part is learned; inputs that excite
//!   windows of `s + 1` samples. Feedback is allowed as long as the noise is white on the outputs of a sample.
//! * **Do not use** it on logs whose inputs hardly move: then what is learned is the feedback law or nothing, which
//!   is refused. With a good model take `fd_residual::parity`, which has nothing to learn from noise.

mod design;

pub use self::design::{DataParity, DataParityDesign};
