//! The meaning of a foreign column's values, beyond their storage.

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::schema::types::ColumnDescPtr;

/// The meaning of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Meaning {
    /// The values themselves.
    Plain,
    /// Integers without a sign.
    Unsigned,
    /// Floating point of 16 bits.
    Half,
    /// Integers scaled by so many decimals.
    Decimal(i32),
    /// Times.
    Timed(Timed),
}

/// The kind of times in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timed {
    /// Moments since 1970-01-01, so many to a second: in UTC, or in local time.
    Moments {
        /// How many.
        per_second: i64,
        /// Whether of UTC.
        is_utc: bool,
    },
    /// Times of a day, so many to a second.
    OfDay {
        /// How many.
        per_second: i64,
    },
    /// Days without a time.
    Days,
}

/// The meaning of a column's values by its type.
pub(crate) fn meaning(descriptor: &ColumnDescPtr) -> Meaning {
    if descriptor.physical_type() == Type::INT96 {
        return Meaning::Timed(Timed::Moments { per_second: 1_000_000_000, is_utc: true });
    }
    match descriptor.logical_type_ref() {
        Some(LogicalType::Timestamp(kind)) => Meaning::Timed(Timed::Moments {
            per_second: per_second(&kind.unit),
            is_utc: kind.is_adjusted_to_u_t_c,
        }),
        Some(LogicalType::Time(kind)) => Meaning::Timed(Timed::OfDay { per_second: per_second(&kind.unit) }),
        Some(LogicalType::Date) => Meaning::Timed(Timed::Days),
        Some(LogicalType::Decimal(_)) => Meaning::Decimal(descriptor.type_scale()),
        Some(LogicalType::Integer(kind)) if !kind.is_signed => Meaning::Unsigned,
        Some(LogicalType::Float16) => Meaning::Half,
        _ => converted(descriptor),
    }
}

/// By the converted type, as in the first version of the format.
fn converted(descriptor: &ColumnDescPtr) -> Meaning {
    match descriptor.converted_type() {
        ConvertedType::TIMESTAMP_MILLIS => Meaning::Timed(Timed::Moments { per_second: 1000, is_utc: true }),
        ConvertedType::TIMESTAMP_MICROS => {
            Meaning::Timed(Timed::Moments { per_second: 1_000_000, is_utc: true })
        }
        ConvertedType::TIME_MILLIS => Meaning::Timed(Timed::OfDay { per_second: 1000 }),
        ConvertedType::TIME_MICROS => Meaning::Timed(Timed::OfDay { per_second: 1_000_000 }),
        ConvertedType::DATE => Meaning::Timed(Timed::Days),
        ConvertedType::DECIMAL => Meaning::Decimal(descriptor.type_scale()),
        ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 | ConvertedType::UINT_64 => {
            Meaning::Unsigned
        }
        _ => Meaning::Plain,
    }
}

fn per_second(unit: &TimeUnit) -> i64 {
    match unit {
        TimeUnit::MILLIS => 1000,
        TimeUnit::MICROS => 1_000_000,
        TimeUnit::NANOS => 1_000_000_000,
    }
}

impl Meaning {
    /// The number that an integer of `bits` represents.
    pub(crate) fn integer(self, value: i64, bits: u32) -> f64 {
        match self {
            Self::Unsigned if bits == 32 => f64::from(value as u32),
            Self::Unsigned => value as u64 as f64,
            Self::Decimal(scale) => decimal(i128::from(value), scale),
            _ => value as f64,
        }
    }

    /// The number that bytes of a fixed length represent; `None` if they are not a number.
    pub(crate) fn bytes(self, bytes: &[u8]) -> Option<f64> {
        match (self, bytes) {
            (Self::Half, [low, high]) => Some(half(u16::from_le_bytes([*low, *high]))),
            (Self::Decimal(scale), [first, ..]) if bytes.len() <= 16 => {
                let mut all = [if *first < 0x80 { 0 } else { 0xFF }; 16];
                all[16 - bytes.len()..].copy_from_slice(bytes);
                Some(decimal(i128::from_be_bytes(all), scale))
            }
            _ => None,
        }
    }

    /// Seconds since 1970, or since midnight, of a time that is stored as an integer.
    pub(crate) fn seconds(self, value: i64) -> f64 {
        match self {
            Self::Timed(Timed::Moments { per_second, .. } | Timed::OfDay { per_second }) => {
                let rest = value.rem_euclid(per_second) as f64;
                value.div_euclid(per_second) as f64 + rest / per_second as f64
            }
            _ => f64::NAN,
        }
    }
}

fn decimal(value: i128, scale: i32) -> f64 {
    value as f64 / 10_f64.powi(scale)
}

/// Floating point of 16 bits (IEEE 754).
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1F), f64::from(bits & 0x3FF));
    sign * match exponent {
        0 => fraction * 2_f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + fraction) * 2_f64.powi(exponent - 25),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_16_bits_and_decimals_are_what_they_are_stored_as() {
        for (bits, value) in
            [(0x3C00, 1.0), (0xC000, -2.0), (0x7BFF, 65_504.0), (1, 5.960_464_477_539_063e-8)]
        {
            assert_eq!(half(bits), value);
        }
        assert!(half(0x7E00).is_nan() && half(0xFC00) == f64::NEG_INFINITY);
        let decimal = Meaning::Decimal(2);
        assert_eq!([decimal.integer(-1250, 32), decimal.bytes(&[0xFB, 0x1E]).unwrap()], [-12.5; 2]);
        assert_eq!(Meaning::Unsigned.integer(-1, 32), 4_294_967_295.0);
        let moments = Meaning::Timed(Timed::Moments { per_second: 1000, is_utc: true });
        assert_eq!(moments.seconds(-500), -0.5);
    }
}
