//! Fast parsing of decimal numbers, exact to the last bit.
//!
//! If the digits fit in 53 bits and the power of ten is at most 10^22, the value is the product or quotient of two
//! exact doubles, so one operation rounds it correctly (Clinger 1990, "How to read floating point numbers
//! accurately"). Rounding again to single precision still gives the nearest number, unless the double lies exactly
//! halfway between two singles. In that case, and for any unusual input, `str::parse` decides.

/// Powers of ten that are exact in double precision.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Reads decimal digits from position `at` and appends them to `value`, eight at a time if possible. Returns the
/// position after them. Wraps around on overflow; the caller limits the count.
#[inline]
fn read_digits(text: &[u8], mut at: usize, value: &mut u64) -> usize {
    while let Some(Ok(eight)) = text.get(at..at + 8).map(<[u8; 8]>::try_from) {
        // The digit values, the first in the lowest byte. In `others`, the top bit of each non-digit byte is
        // set.
        let digits = u64::from_le_bytes(eight) ^ 0x3030_3030_3030_3030;
        let others = ((digits.wrapping_add(0x7676_7676_7676_7676)) | digits) & 0x8080_8080_8080_8080;
        let count = others.trailing_zeros() as usize / 8;
        if count == 0 {
            return at;
        }
        // Pad with leading zeros, then combine digits to pairs, groups of four and of eight.
        let digits = digits << (64 - 8 * count);
        let pairs = digits.wrapping_mul(10).wrapping_add(digits >> 8) & 0x00ff_00ff_00ff_00ff;
        let fours = pairs.wrapping_mul(100).wrapping_add(pairs >> 16) & 0x0000_ffff_0000_ffff;
        let all = fours.wrapping_mul(10_000).wrapping_add(fours >> 32) & 0xffff_ffff;
        *value = value.wrapping_mul(TENS[count]).wrapping_add(all);
        at += count;
        if count < 8 {
            return at;
        }
    }
    while let Some(d) = text.get(at).map(|b| b.wrapping_sub(b'0')).filter(|d| *d <= 9) {
        *value = value.wrapping_mul(10).wrapping_add(u64::from(d));
        at += 1;
    }
    at
}

/// Powers of ten, by the number of digits that [`read_digits`] reads at once.
const TENS: [u64; 9] = [1, 10, 100, 1000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// Parses the number at the start of `text` to the nearest `f64`; returns it with its length in bytes. `None` if
/// there is no plain decimal number, or one operation does not round it correctly; [`parse_f64`] handles these.
#[inline]
pub(crate) fn quick_f64(text: &[u8]) -> Option<(f64, usize)> {
    let byte = |i: usize| text.get(i).copied().unwrap_or(b' ');
    let negative = byte(0) == b'-';
    let mut at = usize::from(negative || byte(0) == b'+');
    let first = at;
    let mut digits = 0_u64;
    at = read_digits(text, at, &mut digits);
    let mut count = at - first;
    let mut power = 0_i64;
    if byte(at) == b'.' {
        at += 1;
        let point = at;
        at = read_digits(text, at, &mut digits);
        count += at - point;
        power = -((at - point) as i64);
    }
    // Nineteen digits always fit in 64 bits.
    if count == 0 || count > 19 || digits > 1 << 53 {
        return None;
    }
    if byte(at) | 0x20 == b'e' {
        let mut end = at + 1;
        let minus = byte(end) == b'-';
        end += usize::from(minus || byte(end) == b'+');
        let start = end;
        let mut exponent = 0_i64;
        while end - start < 4 {
            let d = byte(end).wrapping_sub(b'0');
            if d > 9 {
                break;
            }
            exponent = exponent * 10 + i64::from(d);
            end += 1;
        }
        if end == start {
            return None;
        }
        power += if minus { -exponent } else { exponent };
        at = end;
    }
    let value = digits as f64;
    let value = match usize::try_from(power.unsigned_abs()).ok().and_then(|p| POWERS.get(p)) {
        Some(&ten) if power < 0 => value / ten,
        Some(&ten) => value * ten,
        None => return None,
    };
    Some((if negative { -value } else { value }, at))
}

/// Like [`quick_f64`], in single precision.
#[inline]
pub(crate) fn quick_f32(text: &[u8]) -> Option<(f32, usize)> {
    let (value, len) = quick_f64(text)?;
    let size = value.abs();
    // Exactly halfway between two singles, or outside the normal range of singles.
    let tie = value.to_bits() & 0x1fff_ffff == 0x1000_0000;
    if tie || !(size >= f64::from(f32::MIN_POSITIVE) && size < f64::from(f32::MAX) || size == 0.0) {
        return None;
    }
    Some((value as f32, len))
}

/// Parses an entire word, with the same result as `str::parse`.
pub(crate) fn parse_f64(word: &[u8]) -> Option<f64> {
    match quick_f64(word) {
        Some((value, len)) if len == word.len() => Some(value),
        _ => std::str::from_utf8(word).ok()?.parse().ok(),
    }
}

/// Parses an entire word in single precision, with the same result as `str::parse`.
pub(crate) fn parse_f32(word: &[u8]) -> Option<f32> {
    match quick_f32(word) {
        Some((value, len)) if len == word.len() => Some(value),
        _ => std::str::from_utf8(word).ok()?.parse().ok(),
    }
}

/// Parses an integer of up to nine digits with an optional minus; returns it with its length. The length is 0 if
/// there is no such integer.
#[inline]
pub(crate) fn quick_int(text: &[u8]) -> (i32, usize) {
    let negative = text.first() == Some(&b'-');
    let first = usize::from(negative);
    let mut value = 0;
    let end = read_digits(text, first, &mut value);
    if !(1..=9).contains(&(end - first)) {
        return (0, 0);
    }
    let value = value as i32;
    (if negative { -value } else { value }, end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str) {
        let bits64 = |v: Option<f64>| v.map(f64::to_bits);
        let bits32 = |v: Option<f32>| v.map(f32::to_bits);
        assert_eq!(bits64(parse_f64(text.as_bytes())), bits64(text.parse().ok()), "{text}");
        assert_eq!(bits32(parse_f32(text.as_bytes())), bits32(text.parse().ok()), "{text}");
    }

    #[test]
    fn numbers_are_those_of_the_standard_library_to_the_last_bit() {
        for text in [
            "0",
            "-0",
            "+0.0",
            "1",
            "-1.5",
            "1e5",
            "1E-5",
            "1.e5",
            ".5",
            ".",
            "",
            "-",
            "+",
            "e5",
            "1e",
            "1e+",
            "1e5x",
            "1.2.3",
            "0x10",
            "inf",
            "-inf",
            "nan",
            "NaN",
            "infinity",
            "1_000",
            " 1",
            "1 ",
            "9007199254740993",
            "9007199254740992",
            "9007199254740991e22",
            "1e23",
            "1e22",
            "1e-22",
            "1e-23",
            "16777217",
            "16777219",
            "33554435",
            "16777217.0000000001",
            "1e39",
            "3.4028235e38",
            "3.4028236e38",
            "3.40282356779733661637539395458142568447e38",
            "1e-45",
            "7e-46",
            "1.1754943e-38",
            "1.1754942e-38",
            "1.4e-45",
            "00000000000000000000000001",
            "1e0000000005",
            "0.00000000000000000000000000000000000000000001",
            "99999999999999999999",
            "4.5e-324",
            "1e400",
            "-1e-400",
        ] {
            check(text);
        }
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 16
        };
        for i in 0..60_000 {
            let (a, b) = (next(), next());
            check(&format!("{}.{}", a % 1000, b % 1_000_000_000));
            check(&format!("-{}e{}", a % (1 << (1 + b % 60)), (b >> 20) % 60));
            check(&format!("{}.{:06}e-{}", a % 10, b % 1_000_000, i % 60));
            // At and near the midpoint of two singles.
            let half = f64::from(f32::from_bits((a as u32) & 0x7f7f_ffff)) + f64::from_bits(b << 40);
            check(&format!("{half}"));
            let middle = f32::from_bits(0x4b00_0000 | (a as u32 & 0x007f_ffff));
            check(&format!("{}", f64::from(middle) + 0.5));
            check(&format!("{}.50000000{}", middle, b % 2));
        }
    }

    #[test]
    fn whole_numbers_up_to_nine_digits() {
        for (text, value) in
            [("1", (1, 1)), ("-27/3", (-27, 3)), ("123456789 ", (123_456_789, 9)), ("0", (0, 1))]
        {
            assert_eq!(quick_int(text.as_bytes()), value);
        }
        for text in ["", "-", "+1", "x", "1234567890", "-1234567890"] {
            assert_eq!(quick_int(text.as_bytes()).1, 0, "{text}");
        }
    }
}
