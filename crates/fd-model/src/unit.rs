//! Units of channels as strings, and affine conversion between those that measure the same.
//!
//! A unit that is not in the [table](KNOWN_UNITS) is allowed but matches only itself, letter by
//! letter. Spaces around a unit do not count.

use thiserror::Error;

/// What a unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Quantity {
    /// Pure numbers.
    Ratio,
    /// Absolute temperature.
    Temperature,
    /// Absolute pressure.
    Pressure,
    /// Speed of rotation; `Hz` and `1/s` are turns per second.
    RotationalSpeed,
    /// Mass per time.
    MassFlow,
    /// Volume.
    Volume,
    /// Volume per time.
    VolumeFlow,
    /// Time.
    Time,
    /// Length.
    Length,
    /// Velocity.
    Velocity,
    /// Acceleration.
    Acceleration,
    /// Plane angle.
    Angle,
    /// Force.
    Force,
    /// Torque.
    Torque,
    /// Force per length.
    Stiffness,
    /// Power.
    Power,
    /// Mass.
    Mass,
    /// Electric voltage.
    Voltage,
    /// Electric current.
    Current,
}

/// Known units: the ways of writing it, what it measures, and `factor` and `offset` in
/// `SI value = factor · (value + offset)`.
pub type KnownUnit = (&'static [&'static str], Quantity, f64, f64);

const TURN: f64 = std::f64::consts::TAU;
const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// International pound in kg and foot in m, standard gravity in m/s²; exact by definition.
const POUND: f64 = 0.453_592_37;
const FOOT: f64 = 0.3048;
const GRAVITY: f64 = 9.806_65;
const POUND_FORCE: f64 = POUND * GRAVITY;
const PSI: f64 = POUND_FORCE / (FOOT / 12.0 * (FOOT / 12.0));
const RANKINE: f64 = 5.0 / 9.0;

/// All known units.
#[rustfmt::skip]
pub const KNOWN_UNITS: &[KnownUnit] = &[
    (&["1", "", "-"], Quantity::Ratio, 1.0, 0.0),
    (&["pu", "p.u."], Quantity::Ratio, 1.0, 0.0),
    (&["%"], Quantity::Ratio, 0.01, 0.0),
    (&["K"], Quantity::Temperature, 1.0, 0.0),
    (&["degC", "°C", "℃"], Quantity::Temperature, 1.0, 273.15),
    (&["degF", "°F", "℉"], Quantity::Temperature, RANKINE, 459.67),
    (&["R", "degR", "°R"], Quantity::Temperature, RANKINE, 0.0),
    (&["Pa"], Quantity::Pressure, 1.0, 0.0),
    (&["hPa", "mbar"], Quantity::Pressure, 1e2, 0.0),
    (&["kPa"], Quantity::Pressure, 1e3, 0.0),
    (&["MPa"], Quantity::Pressure, 1e6, 0.0),
    (&["bar"], Quantity::Pressure, 1e5, 0.0),
    (&["psi", "psia"], Quantity::Pressure, PSI, 0.0),
    (&["atm"], Quantity::Pressure, 101_325.0, 0.0),
    (&["rad/s"], Quantity::RotationalSpeed, 1.0, 0.0),
    (&["deg/s", "°/s"], Quantity::RotationalSpeed, DEGREE, 0.0),
    (&["deg/min", "°/min"], Quantity::RotationalSpeed, DEGREE / 60.0, 0.0),
    (&["rpm", "RPM", "1/min", "r/min"], Quantity::RotationalSpeed, TURN / 60.0, 0.0),
    (&["Hz", "1/s", "rev/s"], Quantity::RotationalSpeed, TURN, 0.0),
    (&["kg/s"], Quantity::MassFlow, 1.0, 0.0),
    (&["g/s"], Quantity::MassFlow, 1e-3, 0.0),
    (&["kg/h"], Quantity::MassFlow, 1.0 / 3600.0, 0.0),
    (&["lb/s", "lbm/s", "pps"], Quantity::MassFlow, POUND, 0.0),
    (&["lb/h", "lbm/h", "pph"], Quantity::MassFlow, POUND / 3600.0, 0.0),
    (&["m^3", "m3", "m³"], Quantity::Volume, 1.0, 0.0),
    (&["l", "L"], Quantity::Volume, 1e-3, 0.0),
    (&["ml", "mL", "cm^3", "cm3", "cm³"], Quantity::Volume, 1e-6, 0.0),
    (&["m^3/s", "m3/s", "m³/s"], Quantity::VolumeFlow, 1.0, 0.0),
    (&["m^3/h", "m3/h", "m³/h"], Quantity::VolumeFlow, 1.0 / 3600.0, 0.0),
    (&["l/s", "L/s"], Quantity::VolumeFlow, 1e-3, 0.0),
    (&["l/min", "L/min", "lpm", "LPM"], Quantity::VolumeFlow, 1e-3 / 60.0, 0.0),
    (&["l/h", "L/h"], Quantity::VolumeFlow, 1e-3 / 3600.0, 0.0),
    (&["ml/s", "mL/s", "cm^3/s", "cm3/s", "cm³/s"], Quantity::VolumeFlow, 1e-6, 0.0),
    (&["ml/min", "mL/min"], Quantity::VolumeFlow, 1e-6 / 60.0, 0.0),
    (&["s", "sec"], Quantity::Time, 1.0, 0.0),
    (&["ms"], Quantity::Time, 1e-3, 0.0),
    (&["us", "µs", "μs"], Quantity::Time, 1e-6, 0.0),
    (&["ns"], Quantity::Time, 1e-9, 0.0),
    (&["min"], Quantity::Time, 60.0, 0.0),
    (&["h"], Quantity::Time, 3600.0, 0.0),
    (&["day", "days", "d"], Quantity::Time, 86_400.0, 0.0),
    (&["m"], Quantity::Length, 1.0, 0.0),
    (&["um", "µm", "μm"], Quantity::Length, 1e-6, 0.0),
    (&["mm"], Quantity::Length, 1e-3, 0.0),
    (&["cm"], Quantity::Length, 1e-2, 0.0),
    (&["km"], Quantity::Length, 1e3, 0.0),
    (&["in"], Quantity::Length, FOOT / 12.0, 0.0),
    (&["ft"], Quantity::Length, FOOT, 0.0),
    (&["m/s"], Quantity::Velocity, 1.0, 0.0),
    (&["mm/s"], Quantity::Velocity, 1e-3, 0.0),
    (&["cm/s"], Quantity::Velocity, 1e-2, 0.0),
    (&["m/min"], Quantity::Velocity, 1.0 / 60.0, 0.0),
    (&["km/h"], Quantity::Velocity, 1.0 / 3.6, 0.0),
    (&["ft/s"], Quantity::Velocity, FOOT, 0.0),
    (&["kn", "kt"], Quantity::Velocity, 1852.0 / 3600.0, 0.0),
    (&["m/s^2", "m/s2", "m/s²"], Quantity::Acceleration, 1.0, 0.0),
    (&["ft/s^2", "ft/s2", "ft/s²"], Quantity::Acceleration, FOOT, 0.0),
    (&["g0"], Quantity::Acceleration, GRAVITY, 0.0),
    (&["rad"], Quantity::Angle, 1.0, 0.0),
    (&["deg", "°"], Quantity::Angle, DEGREE, 0.0),
    (&["rev"], Quantity::Angle, TURN, 0.0),
    (&["N"], Quantity::Force, 1.0, 0.0),
    (&["kN"], Quantity::Force, 1e3, 0.0),
    (&["lbf"], Quantity::Force, POUND_FORCE, 0.0),
    (&["N m", "N*m", "N·m", "Nm"], Quantity::Torque, 1.0, 0.0),
    (&["mN m", "mN*m", "mN·m", "mNm"], Quantity::Torque, 1e-3, 0.0),
    (&["kN m", "kN*m", "kN·m", "kNm"], Quantity::Torque, 1e3, 0.0),
    (&["lbf ft", "lbf*ft", "lbf·ft", "ft lbf"], Quantity::Torque, POUND_FORCE * FOOT, 0.0),
    (&["N/m"], Quantity::Stiffness, 1.0, 0.0),
    (&["kN/m", "N/mm"], Quantity::Stiffness, 1e3, 0.0),
    (&["W"], Quantity::Power, 1.0, 0.0),
    (&["mW"], Quantity::Power, 1e-3, 0.0),
    (&["kW"], Quantity::Power, 1e3, 0.0),
    (&["MW"], Quantity::Power, 1e6, 0.0),
    (&["hp"], Quantity::Power, 550.0 * POUND_FORCE * FOOT, 0.0),
    (&["kg"], Quantity::Mass, 1.0, 0.0),
    (&["g"], Quantity::Mass, 1e-3, 0.0),
    (&["lb", "lbm"], Quantity::Mass, POUND, 0.0),
    (&["V"], Quantity::Voltage, 1.0, 0.0),
    (&["mV"], Quantity::Voltage, 1e-3, 0.0),
    (&["kV"], Quantity::Voltage, 1e3, 0.0),
    (&["A"], Quantity::Current, 1.0, 0.0),
    (&["uA", "µA", "μA"], Quantity::Current, 1e-6, 0.0),
    (&["mA"], Quantity::Current, 1e-3, 0.0),
    (&["kA"], Quantity::Current, 1e3, 0.0),
];

/// Values in one unit cannot be turned into another.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum UnitError {
    /// Both units are known and measure different things.
    #[error("`{from}` ({from_quantity:?}) cannot be converted to `{to}` ({to_quantity:?})")]
    Incompatible {
        /// Unit of the values.
        from: String,
        /// What it measures.
        from_quantity: Quantity,
        /// Unit that is wanted.
        to: String,
        /// What it measures.
        to_quantity: Quantity,
    },
    /// One of the two units is not in the table, and they are not the same.
    #[error("`{from}` cannot be converted to `{to}`: `{unknown}` is not a known unit")]
    Unknown {
        /// Unit of the values.
        from: String,
        /// Unit that is wanted.
        to: String,
        /// The one that is not known.
        unknown: String,
    },
}

/// `to = factor · from + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conversion {
    factor: f64,
    offset: f64,
}

impl Conversion {
    /// The conversion that changes nothing.
    pub const IDENTITY: Self = Self { factor: 1.0, offset: 0.0 };

    /// The conversion between two units; exactly the identity when they are the same.
    ///
    /// ```
    /// # use fd_model::unit::Conversion;
    /// let to_kelvin = Conversion::between("degF", "K")?;
    /// assert!((to_kelvin.apply(32.0) - 273.15).abs() < 1e-12);
    /// let error = Conversion::between("kPa", "K").unwrap_err();
    /// assert_eq!(error.to_string(), "`kPa` (Pressure) cannot be converted to `K` (Temperature)");
    /// # Ok::<(), fd_model::unit::UnitError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error that names both units when they do not measure the same, or one of them
    /// is unknown and they differ.
    pub fn between(from: &str, to: &str) -> Result<Self, UnitError> {
        let (from, to) = (from.trim(), to.trim());
        if from == to {
            return Ok(Self::IDENTITY);
        }
        let unknown = |unknown: &str| UnitError::Unknown {
            from: from.to_owned(),
            to: to.to_owned(),
            unknown: unknown.to_owned(),
        };
        let (_, from_quantity, from_factor, from_offset) =
            lookup(from).ok_or_else(|| unknown(from))?;
        let (_, to_quantity, to_factor, to_offset) = lookup(to).ok_or_else(|| unknown(to))?;
        if from_quantity != to_quantity {
            let (from, to) = (from.to_owned(), to.to_owned());
            return Err(UnitError::Incompatible { from, from_quantity, to, to_quantity });
        }
        let factor = from_factor / to_factor;
        Ok(Self { factor, offset: factor * from_offset - to_offset })
    }

    /// Converts a value.
    #[must_use]
    pub fn apply(&self, value: f64) -> f64 {
        self.factor * value + self.offset
    }

    /// Converts a difference of values, such as a deviation from an operating point or a
    /// standard deviation: 1 degC of difference is 1 K.
    ///
    /// ```
    /// # use fd_model::unit::Conversion;
    /// assert_eq!(Conversion::between("degC", "K")?.apply_to_difference(1.0), 1.0);
    /// # Ok::<(), fd_model::unit::UnitError>(())
    /// ```
    #[must_use]
    pub fn apply_to_difference(&self, difference: f64) -> f64 {
        self.factor * difference
    }
}

/// A whole turn in a unit of angles; `None` in any other.
///
/// ```
/// # use fd_model::unit::turn;
/// assert_eq!((turn("deg"), turn("rev"), turn("m")), (Some(360.0), Some(1.0), None));
/// ```
#[must_use]
pub fn turn(unit: &str) -> Option<f64> {
    let (_, quantity, factor, _) = lookup(unit.trim())?;
    (quantity == Quantity::Angle).then(|| TURN / factor)
}

/// What a unit measures, if it is known.
///
/// ```
/// # use fd_model::unit::{Quantity, quantity};
/// assert_eq!(quantity("kPa"), Some(Quantity::Pressure));
/// assert_eq!(quantity("furlong"), None);
/// ```
#[must_use]
pub fn quantity(unit: &str) -> Option<Quantity> {
    lookup(unit.trim()).map(|(_, quantity, _, _)| quantity)
}

fn lookup(unit: &str) -> Option<KnownUnit> {
    KNOWN_UNITS.iter().find(|(names, ..)| names.contains(&unit)).copied()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn every_spelling_is_unique() {
        let mut spellings: Vec<&str> =
            KNOWN_UNITS.iter().flat_map(|(names, ..)| names.iter().copied()).collect();
        let count = spellings.len();
        spellings.sort_unstable();
        spellings.dedup();
        assert_eq!(spellings.len(), count);
    }

    #[test]
    fn conversions_agree_with_published_values() {
        // NIST SP 811 (2008), appendix B.8, printed with seven digits: half a unit of the last
        // one is at most 5e-7. The others are exact but for rounding.
        const PRINTED: f64 = 5e-7;
        for (from, to, value, expected, digits) in [
            ("psi", "Pa", 1.0, 6.894_757e3, PRINTED),
            ("lb/h", "kg/s", 1.0, 1.259_979e-4, PRINTED),
            ("lbf", "N", 1.0, 4.448_222, PRINTED),
            ("hp", "W", 1.0, 7.456_999e2, PRINTED),
            ("lbf ft", "N m", 1.0, 1.355_818, PRINTED),
            ("rpm", "rad/s", 1.0, 1.047_198e-1, PRINTED),
            ("kn", "m/s", 1.0, 5.144_444e-1, PRINTED),
            ("cm3/s", "L/min", 1.0, 0.06, 1e-12),
            ("N/mm", "N/m", 1.0, 1e3, 1e-12),
            ("deg/min", "deg/s", 3.0, 0.05, 1e-12),
            ("degF", "degC", 212.0, 100.0, 1e-12),
            ("R", "K", 1.8, 1.0, 1e-12),
            ("atm", "bar", 1.0, 1.013_25, 1e-12),
            ("%", "pu", 5.0, 0.05, 1e-12),
        ] {
            let found = Conversion::between(from, to).unwrap().apply(value);
            assert!((found / expected - 1.0).abs() < digits, "{value} {from} is {found} {to}");
        }
    }

    #[test]
    fn unknown_units_match_only_themselves() {
        assert_eq!(Conversion::between("furlong", " furlong "), Ok(Conversion::IDENTITY));
        let error = Conversion::between("furlong", "m").unwrap_err();
        assert_eq!(
            error.to_string(),
            "`furlong` cannot be converted to `m`: `furlong` is not a known unit"
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn there_and_back_is_the_identity(value in -1e6..1e6_f64, i in 0..KNOWN_UNITS.len()) {
            let (names, quantity, ..) = KNOWN_UNITS[i];
            for (others, ..) in KNOWN_UNITS.iter().filter(|(_, other, ..)| *other == quantity) {
                let there = Conversion::between(names[0], others[0]).unwrap();
                let back = Conversion::between(others[0], names[0]).unwrap();
                // A handful of roundings of numbers up to |value| plus the offset, which is at
                // most 460 degrees of either kind.
                let bound = 8.0 * f64::EPSILON * (value.abs() + 1000.0);
                prop_assert!((back.apply(there.apply(value)) - value).abs() <= bound);
            }
        }
    }
}
