//! Published problems of residual generation, one function each.
//!
//! Yuan et al. (1997); Niemann (1998); Frisk et al. (2012); Varga (2017) and the user's guide of FDITOOLS; Chen,
//! Patton and Zhang (1996); Chen and Patton (1999). All in continuous time.

use faer::{Mat, Scale, mat};
use fd_model::{Continuous, Discrete, SampleTime, StateSpace};
use fd_residual::analysis::UnknownInputs;

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
    pub(crate) fn realised<const N: usize, const M: usize>(
        rows: &[[Ratio; N]; M],
        kinds: [usize; 3],
    ) -> Self {
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
    pub(crate) fn entering(
        a: Mat<f64>,
        c: Mat<f64>,
        bu: Mat<f64>,
        bf: Mat<f64>,
        bd: Mat<f64>,
    ) -> Self {
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
    pub(crate) fn as_sampled(&self) -> StateSpace<Discrete> {
        let p = &self.plant;
        let domain = Discrete { ts: SampleTime::new(0.1).unwrap() };
        let [a, b, c, d] = [p.a(), p.b(), p.c(), p.d()].map(|m| m.to_owned());
        StateSpace::new(a, b, c, d, domain).unwrap()
    }
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
pub(crate) fn tanks() -> Problem {
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

pub(crate) fn varga_5_4() -> Problem {
    let first: Ratio = (&[1.0, 1.0], &[1.0, -2.0]);
    let second: Ratio = (&[1.0, 2.0], &[1.0, -3.0]);
    Problem::realised(&[[first, D1, first, ZERO], [second, ZERO, second, ONE]], [1, 2, 0])
}

pub(crate) fn varga_5_3() -> Problem {
    Problem::realised(&[[U1, D1, U1, ZERO], [U2, ZERO, U2, ONE]], [1, 2, 0])
}

pub(crate) fn varga_5_2() -> Problem {
    Problem::realised(&[[U1, LAG, U1, ZERO], [U2, ZERO, ZERO, ONE]], [1, 2, 0])
}

pub(crate) fn varga_5_6() -> Problem {
    Problem::realised(&[[U1, U1, ZERO, LAG], [U2, ZERO, ONE, ZERO]], [0, 2, 1])
}

pub(crate) fn fditools_8() -> Problem {
    Problem::realised(&[[U1, U1, ONE, ZERO, D1], [U2, U2, ZERO, ONE, ZERO]], [0, 3, 1])
}

/// `G_f = [(s+1)/(s−2) 0; (s+2)/(s−3) 1]` in five states.
pub(crate) fn varga_7_3() -> Problem {
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
pub(crate) fn varga_strong() -> Problem {
    let (fades, notch): (Ratio, Ratio) =
        ((&[1.0, 0.0], &[1.0, 1.0]), (&[1.0, 0.0, 4.0], &[1.0, 6.0, 9.0]));
    Problem::realised(&[[ONE, fades, ZERO], [ONE, notch, ONE]], [0, 2, 0])
}

/// The six directions `E*` of nonlinear terms, of rank two.
pub(crate) fn jet_engine() -> Problem {
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

pub(crate) fn chen_patton() -> Problem {
    let a = mat![[-1.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, -1.0]];
    let b = mat![[-1.0], [0.0], [0.0]];
    let c = mat![[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    Problem::entering(a, c, b.clone(), b.clone(), b)
}
