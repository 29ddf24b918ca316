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

/// Newton passes of the inverse functions; fixed, so that every result is a smooth function of
/// its arguments and finite differences see no change of the pass count.
const PASSES: usize = 5;

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
    /// `c_i`.
    heat: [T; TERMS],
    /// `c_i / (i + 1)`: coefficients of the enthalpy.
    enthalpy: [T; TERMS],
    /// `c_i / i` for `i > 0`, and `c_0` of the logarithm: coefficients of the entropy function.
    entropy: [T; TERMS],
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

    fn from_heat(heat: [T; TERMS]) -> Self {
        const RECIPROCALS: [f64; TERMS + 1] = [
            1.0,
            1.0,
            1.0 / 2.0,
            1.0 / 3.0,
            1.0 / 4.0,
            1.0 / 5.0,
            1.0 / 6.0,
            1.0 / 7.0,
            1.0 / 8.0,
            1.0 / 9.0,
        ];
        let mut enthalpy = heat;
        let mut entropy = heat;
        for i in 0..TERMS {
            enthalpy[i] *= T::from_design(RECIPROCALS[i + 1]);
            entropy[i] *= T::from_design(RECIPROCALS[i]);
        }
        Self { heat, enthalpy, entropy }
    }

    /// Heat capacity at constant pressure in J/(kg K), at a temperature in K.
    #[inline]
    pub fn cp(&self, t: T) -> T {
        k::<T>(1e3) * horner(&self.heat, t * k(1e-3))
    }

    /// Enthalpy above 0 K in J/kg, at a temperature in K.
    #[inline]
    pub fn enthalpy(&self, t: T) -> T {
        let z = t * k(1e-3);
        k::<T>(1e6) * horner(&self.enthalpy, z) * z
    }

    /// Entropy function `φ(T) = ∫ cp / T dT` in J/(kg K), at a temperature in K.
    #[inline]
    pub fn entropy(&self, t: T) -> T {
        let z = t * k(1e-3);
        k::<T>(1e3) * (self.entropy[0] * z.ln() + horner(&self.entropy[1..], z) * z)
    }

    /// Temperature in K of an enthalpy in J/kg, by Newton's method from `guess`.
    ///
    /// Five passes: from a guess within 40 % the result is exact to rounding.
    #[inline]
    pub fn temperature_of_enthalpy(&self, enthalpy: T, guess: T) -> T {
        let mut t = guess;
        for _ in 0..PASSES {
            t -= (self.enthalpy(t) - enthalpy) / self.cp(t);
        }
        t
    }

    /// Temperature in K after an isentropic change of pressure from `t` (K) by `pressure_ratio`,
    /// by Newton's method from `guess` (K): `φ(T₂) = φ(T₁) + R ln π`.
    #[inline]
    pub fn isentropic(&self, t: T, pressure_ratio: T, guess: T) -> T {
        let target = self.entropy(t) + k::<T>(GAS_CONSTANT) * pressure_ratio.ln();
        let mut t = guess;
        for _ in 0..PASSES {
            t -= (self.entropy(t) - target) * t / self.cp(t);
        }
        t
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

#[inline]
fn horner<T: Scalar>(coefficients: &[T], z: T) -> T {
    coefficients.iter().rev().fold(T::zero(), |sum, &c| sum * z + c)
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

        /// Newton doubles the digits per pass: five passes from 20 % off reach rounding, n · eps.
        #[test]
        fn inverses_invert(t in 250.0..1800.0, far in 0.0..0.04, off in 0.8..1.2) {
            let gas = Gas::<f64>::products(far);
            let back = gas.temperature_of_enthalpy(gas.enthalpy(t), t * off);
            prop_assert!((back / t - 1.0).abs() < 1e-13);
            prop_assert!((gas.isentropic(t, 1.0, t * off) / t - 1.0).abs() < 1e-13);
        }

        #[test]
        fn compression_heats_and_composes(
            t in 250.0..600.0_f64, p in 1.1..4.0_f64, q in 1.1..4.0_f64,
        ) {
            let air = Gas::<f64>::air();
            let once = air.isentropic(t, p * q, t * (p * q).powf(0.28));
            let middle = air.isentropic(t, p, t * p.powf(0.28));
            let twice = air.isentropic(middle, q, middle * q.powf(0.28));
            prop_assert!(t < middle && middle < once);
            prop_assert!((twice / once - 1.0).abs() < 1e-12);
        }
    }
}
