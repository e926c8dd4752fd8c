//! Numbers in text: decimal to binary and back without loss.

/// Largest integer up to which all integers are exact in a double.
const EXACT_INTEGERS: u64 = 1 << 53;

/// Powers of ten that are exact in a double.
const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// The number that `text` spells, correctly rounded; also `nan` and `inf` in any case, and
/// Fortran's `1.0D0`. `None` for anything else and for numbers beyond the range of a double.
#[inline]
pub(crate) fn parse_float(text: &[u8]) -> Option<f64> {
    short_decimal(text).or_else(|| any_decimal(text))
}

/// Plain decimals of few digits, where one exact operation gives the correctly rounded result
/// (Clinger 1990). Nearly all numbers in mesh files are of this kind.
#[inline]
fn short_decimal(text: &[u8]) -> Option<f64> {
    let (negative, digits) = split_sign(text);
    let mut mantissa = 0_u64;
    let mut fraction_digits = 0;
    let mut in_fraction = false;
    let mut digit_count = 0;
    let mut rest = digits;
    while let [byte, tail @ ..] = rest {
        let digit = byte.wrapping_sub(b'0');
        if digit < 10 {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            digit_count += 1;
            fraction_digits += i32::from(in_fraction);
        } else if *byte == b'.' && !in_fraction {
            in_fraction = true;
        } else {
            break;
        }
        rest = tail;
    }
    // 19 digits cannot overflow 64 bits.
    if digit_count == 0 || digit_count > 19 || mantissa > EXACT_INTEGERS {
        return None;
    }
    let exponent = if rest.is_empty() {
        0
    } else {
        short_exponent(rest)?
    };
    let magnitude = scaled(mantissa, exponent - fraction_digits)?;
    Some(if negative { -magnitude } else { magnitude })
}

/// `mantissa · 10^exponent` where both factors are exact.
#[inline]
fn scaled(mantissa: u64, exponent: i32) -> Option<f64> {
    let power = *POWERS_OF_TEN.get(exponent.unsigned_abs() as usize)?;
    let mantissa = mantissa as f64;
    Some(if exponent < 0 {
        mantissa / power
    } else {
        mantissa * power
    })
}

/// An exponent of up to three digits with its letter.
fn short_exponent(text: &[u8]) -> Option<i32> {
    let [b'e' | b'E' | b'd' | b'D', digits @ ..] = text else {
        return None;
    };
    let (negative, digits) = split_sign(digits);
    if digits.is_empty() || digits.len() > 3 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let magnitude = digits
        .iter()
        .fold(0, |sum, digit| 10 * sum + i32::from(digit - b'0'));
    Some(if negative { -magnitude } else { magnitude })
}

/// Any decimal, by the standard library.
#[cold]
fn any_decimal(text: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(text).ok()?;
    // The library knows no `D`, and a `D` elsewhere than as the exponent fails there too.
    let value: f64 = if text.contains(['d', 'D']) {
        text.replace(['d', 'D'], "e").parse().ok()?
    } else {
        text.parse().ok()?
    };
    let overflowed = value.is_infinite() && text.bytes().any(|byte| byte.is_ascii_digit());
    (!overflowed).then_some(value)
}

/// The integer that `text` spells in decimal, with an optional sign.
#[inline]
pub(crate) fn parse_integer(text: &[u8]) -> Option<i64> {
    let (negative, digits) = split_sign(text);
    // 18 digits cannot overflow 63 bits.
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut magnitude = 0_i64;
    for byte in digits {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        magnitude = 10 * magnitude + i64::from(digit);
    }
    Some(if negative { -magnitude } else { magnitude })
}

#[inline]
fn split_sign(text: &[u8]) -> (bool, &[u8]) {
    match text {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        _ => (false, text),
    }
}

/// Appends the shortest decimal that reads back as `value`, which must be finite.
pub(crate) fn push_float(text: &mut Vec<u8>, value: f64) {
    push_shortened(text, zmij::Buffer::new().format_finite(value));
}

/// Appends the shortest decimal that reads back as this single-precision `value`, which must be
/// finite.
pub(crate) fn push_single(text: &mut Vec<u8>, value: f32) {
    push_shortened(text, zmij::Buffer::new().format_finite(value));
}

/// Integers need no `.0`.
fn push_shortened(text: &mut Vec<u8>, number: &str) {
    text.extend_from_slice(number.strip_suffix(".0").unwrap_or(number).as_bytes());
}

/// Appends an integer.
pub(crate) fn push_integer(text: &mut Vec<u8>, value: impl itoa::Integer) {
    text.extend_from_slice(itoa::Buffer::new().format(value).as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    #[test]
    fn floats_read_as_the_standard_library_reads_them() {
        let words = [
            "0",
            "-0",
            "1",
            "+1.5",
            ".5",
            "5.",
            "1e5",
            "1E-5",
            "1e+22",
            "1e23",
            "0.1",
            "123456789012345678",
            "9007199254740993",
            "2.2250738585072014e-308",
            "4.9e-324",
            "1.7976931348623157e308",
            "-1e-400",
            "0.30000000000000004",
            "00000000000000000000000000001",
            "3.14159265358979323846264338327950288",
        ];
        for word in words {
            let expected: f64 = word.parse().unwrap();
            let value = parse_float(word.as_bytes()).unwrap();
            assert_eq!(value.to_bits(), expected.to_bits(), "{word}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        let words = [
            "", "+", "-", ".", "e5", "1e", "1e+", "0,0", "1.#IND", "-1.#QNAN", "XXX0.5", "1.2.3",
            "1-2", "0x10", "1e400", "-1e999", "one", "--1", "1d", "1_000",
        ];
        for word in words {
            assert_eq!(parse_float(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn special_spellings_are_understood() {
        assert!(parse_float(b"NaN").unwrap().is_nan());
        assert_eq!(parse_float(b"-inf"), Some(f64::NEG_INFINITY));
        assert_eq!(parse_float(b"1.5D2"), Some(150.0));
        assert_eq!(parse_float(b"1.0000000000000000000001d-300"), Some(1e-300));
    }

    #[test]
    fn random_bit_patterns_survive_writing_and_reading() {
        let mut noise = Noise::new(1);
        let mut text = Vec::new();
        for _ in 0..20_000 {
            let value = f64::from_bits(noise.bits());
            if value.is_finite() {
                text.clear();
                push_float(&mut text, value);
                assert_eq!(parse_float(&text).unwrap().to_bits(), value.to_bits());
            }
            let single = f32::from_bits(noise.bits() as u32);
            if single.is_finite() {
                text.clear();
                push_single(&mut text, single);
                assert_eq!(
                    (parse_float(&text).unwrap() as f32).to_bits(),
                    single.to_bits()
                );
            }
        }
    }

    #[test]
    fn integers_have_at_most_one_sign_and_digits_only() {
        assert_eq!(parse_integer(b"-12"), Some(-12));
        assert_eq!(parse_integer(b"+7"), Some(7));
        for word in ["", "-", "1.0", "1e3", "--1", "9999999999999999999"] {
            assert_eq!(parse_integer(word.as_bytes()), None, "{word}");
        }
    }
}
