//! Temperature-dependent properties of air and of lean kerosene products.

use fd_core::Scalar;

/// Specific gas constant of air and products, J/(kg K).
pub const GAS_CONSTANT: f64 = 287.05;

/// Number of polynomial coefficients of `cp`.
const TERMS: usize = 9;

/// Air: `cp / 1000 = Σ A_i z^i`, `z = T / 1000 K`.
const AIR: [f64; TERMS] = [
    0.992_313, 0.236_688, -1.852_148, 6.083_152, -8.893_933, 7.097_112, -3.234_725, 0.794_571,
    -0.081_873,
];

/// Products: addition `f / (1 + f) Σ B_i z^i` for a fuel-air ratio `f`.
const PRODUCTS: [f64; TERMS] = [
    -0.718_874,
    8.747_481,
    -15.863_157,
    17.254_096,
    -10.233_795,
    3.081_778,
    -0.361_112,
    -0.003_919,
    0.0,
];

/// Passes of Chebyshev's method, which cubes the error, in the inverse functions; fixed, so that
/// every result is a smooth function of its arguments and finite differences see no change of
/// the pass count.
const ENTHALPY_PASSES: usize = 3;
const ENTROPY_PASSES: usize = 2;

/// A gas of one composition, with variable heat capacity.
///
/// `cp = 1000 Σ c_i z^i` J/(kg K) with `z = T / 1000 K` and `c_i = A_i + f / (1 + f) B_i`
/// (polynomials of the kind in Walsh & Fletcher, *Gas Turbine Performance*). Enthalpy and
/// entropy function are its exact integrals. Within 0.25 % of real-gas tables of air and lean
/// kerosene products from 288 K to 1800 K.
///
/// ```
/// use fd_jetengine::engine17::Gas;
///
/// let air = Gas::<f64>::air();
/// assert!((air.cp(288.15) - 1003.33).abs() < 0.01);
/// assert!((air.temperature_of_enthalpy(air.enthalpy(700.0), 600.0) - 700.0).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gas<T> {
    /// `c_0`.
    first: T,
    /// `c_i`, `i > 0`.
    heat: [T; TERMS - 1],
    /// `i c_i`: coefficients of the slope of `cp`.
    slope: [T; TERMS - 1],
    /// `c_i / (i + 1)`: coefficients of the enthalpy.
    enthalpy: [T; TERMS - 1],
    /// `c_i / i`: coefficients of the entropy function.
    entropy: [T; TERMS - 1],
}

impl<T: Scalar> Gas<T> {
    /// Dry air.
    #[must_use]
    pub fn air() -> Self {
        Self::from_heat(AIR.map(T::from_design))
    }

    /// Products of kerosene and air at a fuel-air ratio (kg fuel per kg air), lean.
    #[must_use]
    pub fn products(fuel_air_ratio: T) -> Self {
        let share = fuel_air_ratio / (T::one() + fuel_air_ratio);
        let mut heat = AIR.map(T::from_design);
        for (c, &b) in heat.iter_mut().zip(&PRODUCTS) {
            *c += share * T::from_design(b);
        }
        Self::from_heat(heat)
    }

    fn from_heat([first, heat @ ..]: [T; TERMS]) -> Self {
        const ORDERS: [f64; TERMS - 1] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
        let scaled = |factor: fn(f64) -> f64| -> [T; TERMS - 1] {
            std::array::from_fn(|i| heat[i] * T::from_design(factor(ORDERS[i])))
        };
        Self {
            first,
            heat,
            slope: scaled(|order| order),
            enthalpy: scaled(|order| (order + 1.0).recip()),
            entropy: scaled(f64::recip),
        }
    }

    /// Heat capacity at constant pressure in J/(kg K), at a temperature in K.
    #[inline]
    pub fn cp(&self, t: T) -> T {
        let z = t * k(1e-3);
        k::<T>(1e3) * (self.first + z * polynomial(&self.heat, z))
    }

    /// `T / cp dcp/dT`.
    #[inline]
    fn relative_slope(&self, t: T, cp: T) -> T {
        let z = t * k(1e-3);
        k::<T>(1e3) * z * polynomial(&self.slope, z) / cp
    }

    /// Enthalpy above 0 K in J/kg, at a temperature in K.
    #[inline]
    pub fn enthalpy(&self, t: T) -> T {
        let z = t * k(1e-3);
        k::<T>(1e6) * (self.first + z * polynomial(&self.enthalpy, z)) * z
    }

    /// Entropy function `φ(T) = ∫ cp / T dT` in J/(kg K), at a temperature in K.
    #[inline]
    pub fn entropy(&self, t: T) -> T {
        let z = t * k(1e-3);
        k::<T>(1e3) * (self.first * z.ln() + polynomial(&self.entropy, z) * z)
    }

    /// Temperature in K of an enthalpy in J/kg, from `guess`: from one within 40 % the result is
    /// exact to rounding.
    ///
    /// Chebyshev's method: with `ε = (h - h(T)) / (cp T)` and `κ = T cp' / cp`, a step to
    /// `T (1 + ε (1 - κ ε / 2))`.
    #[inline]
    pub fn temperature_of_enthalpy(&self, enthalpy: T, guess: T) -> T {
        let mut t = guess;
        for _ in 0..ENTHALPY_PASSES {
            let cp = self.cp(t);
            let step = (enthalpy - self.enthalpy(t)) / cp;
            t += step * (T::one() - k::<T>(0.5) * self.relative_slope(t, cp) * step / t);
        }
        t
    }

    /// Temperature in K after an isentropic change of pressure from `t` (K) by `pressure_ratio`:
    /// `φ(T₂) = φ(T₁) + R ln π`.
    ///
    /// Chebyshev's method for `u = ln(T₂ / T₁)`, from that of constant `cp`, which is off by 4 % at
    /// a ratio of 10 and by 13 % at one of 100. Two passes are exact to rounding.
    #[inline]
    pub fn isentropic(&self, t: T, pressure_ratio: T) -> T {
        let polynomials = |t: T| {
            let z = t * k(1e-3);
            k::<T>(1e3) * z * polynomial(&self.entropy, z)
        };
        let added = k::<T>(GAS_CONSTANT) * pressure_ratio.ln();
        let target = added + polynomials(t);
        let mut u = added / self.cp(t);
        for _ in 0..ENTROPY_PASSES {
            let after = t * u.exp();
            let cp = self.cp(after);
            let step = (target - polynomials(after) - k::<T>(1e3) * self.first * u) / cp;
            u += step * (T::one() - k::<T>(0.5) * self.relative_slope(after, cp) * step);
        }
        t * u.exp()
    }

    /// Ratio of heat capacities `γ = cp / (cp - R)` at a temperature in K.
    #[inline]
    pub fn gamma(&self, t: T) -> T {
        let cp = self.cp(t);
        cp / (cp - k(GAS_CONSTANT))
    }
}

/// A constant of the model in the scalar at hand.
#[inline]
pub(crate) fn k<T: Scalar>(value: f64) -> T {
    T::from_design(value)
}

/// `Σ c_i z^i` in the order of Estrin: Horner's takes three times as long, each operation waiting
/// for the one before.
#[inline]
fn polynomial<T: Scalar>(c: &[T; TERMS - 1], z: T) -> T {
    let z_2 = z * z;
    let cubic = |i: usize| (c[i] + c[i + 1] * z) + (c[i + 2] + c[i + 3] * z) * z_2;
    cubic(0) + cubic(4) * (z_2 * z_2)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// `h` and `φ` are the integrals of `cp` and `cp / T`: central differences with a
        /// step of 0.01 K carry a rounding error of about eps · h / step = 2e-8 J/(kg K).
        #[test]
        fn enthalpy_and_entropy_integrate_heat(t in 250.0..1800.0, far in 0.0..0.04) {
            let gas = Gas::<f64>::products(far);
            let step = 0.01;
            let slope = (gas.enthalpy(t + step) - gas.enthalpy(t - step)) / (2.0 * step);
            prop_assert!((slope / gas.cp(t) - 1.0).abs() < 1e-8);
            let slope = (gas.entropy(t + step) - gas.entropy(t - step)) / (2.0 * step);
            prop_assert!((slope * t / gas.cp(t) - 1.0).abs() < 1e-8);
        }

        /// The error of 40 % goes to about 3e-3, 2e-9 and rounding, n · eps, as far as the polynomials
        /// hold: up to some 1800 K.
        #[test]
        fn inverses_invert(t in 250.0..1800.0, far in 0.0..0.04, off in 0.6..1.4) {
            let gas = Gas::<f64>::products(far);
            let back = gas.temperature_of_enthalpy(gas.enthalpy(t), f64::min(t * off, 1800.0));
            prop_assert!((back / t - 1.0).abs() < 1e-13);
        }

        /// Rounding of the entropy function, n · eps, over cp.
        #[test]
        fn isentropic_changes_keep_their_entropy(
            t in 250.0..900.0, far in 0.0..0.04, log_ratio in -3.0..3.0_f64,
        ) {
            let gas = Gas::<f64>::products(far);
            let after = gas.isentropic(t, log_ratio.exp());
            let change = gas.entropy(after) - gas.entropy(t);
            prop_assert!((change - GAS_CONSTANT * log_ratio).abs() < 1e-14 * gas.entropy(t).abs().max(1e4));
        }

        #[test]
        fn compression_heats_and_composes(
            t in 250.0..600.0_f64, p in 1.1..4.0_f64, q in 1.1..4.0_f64,
        ) {
            let air = Gas::<f64>::air();
            let once = air.isentropic(t, p * q);
            let middle = air.isentropic(t, p);
            let twice = air.isentropic(middle, q);
            prop_assert!(t < middle && middle < once);
            prop_assert!((twice / once - 1.0).abs() < 1e-12);
        }
    }
}
