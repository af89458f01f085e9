//! Endpoints and weights of UASTC blocks (Khronos Data Format Specification, Universal ASTC: decoding process).

use super::Bits;
use super::modes::{Endpoints, Mode, Packed};

/// The values of the numbers of an endpoint, by digit and bits: `digit << bits | value`.
type Levels = [u8; 192];

/// Numbers of a trit and `bits` bits.
const fn trits(bits: u32) -> Levels {
    levels(3, bits)
}

/// Numbers of a quint and `bits` bits.
const fn quints(bits: u32) -> Levels {
    levels(5, bits)
}

/// The numbers of a digit and `bits` bits, spread over 0..=255 so that inverting all bits mirrors the range (ASTC,
/// endpoint unquantization).
const fn levels(base: u32, bits: u32) -> Levels {
    let mut out = [0; 192];
    let mut i = 0;
    while i < base << bits {
        out[i as usize] = level(base, bits, i >> bits, i & ((1 << bits) - 1));
        i += 1;
    }
    out
}

/// The value of a digit and bits. The lowest bit mirrors; the others go to the places of ASTC's table, which depend on
/// base and length.
const fn level(base: u32, bits: u32, digit: u32, value: u32) -> u8 {
    let mirror = if value & 1 == 1 { 0x1ff } else { 0 };
    let upper = value >> 1;
    // b is the second lowest bit, c the third, and so on.
    let (added, factor) = match (base, bits) {
        // b000b0bb0
        (3, 2) => (upper * 0b1_0001_0110, 93),
        // dcb000dcb
        (3, 4) => (upper << 6 | upper, 22),
        // fedcb000f
        (3, 6) => (upper << 4 | upper >> 4, 5),
        // cb0000cbc
        (5, 3) => (upper << 7 | upper << 1 | upper >> 1, 26),
        // edcb0000e
        _ => (upper << 5 | upper >> 3, 6),
    };
    let mixed = (digit * factor + added) ^ mirror;
    (mirror & 0x80 | mixed >> 2) as u8
}

const TRITS_2: Levels = trits(2);
const TRITS_4: Levels = trits(4);
const TRITS_6: Levels = trits(6);
const QUINTS_3: Levels = quints(3);
const QUINTS_5: Levels = quints(5);

/// The pairs of endpoint colours, RGBA, of the subsets.
pub(super) fn endpoints(mode: &Mode, subsets: usize, bits: &mut Bits) -> [[[u8; 4]; 2]; 4] {
    let channels = match mode.endpoints {
        Endpoints::La => 2,
        Endpoints::Rgb => 3,
        Endpoints::Rgba => 4,
    };
    let count = 2 * channels * subsets;
    let mut numbers = [0u8; 18];
    let numbers = &mut numbers[..count.min(18)];
    // All digits come before the bits.
    let (base, most) = match mode.packed {
        Packed::Bits => (1, count),
        Packed::Trits => (3, 5),
        Packed::Quints => (5, 3),
    };
    if base > 1 {
        for group in numbers.chunks_mut(most) {
            let length = match (base, group.len()) {
                (3, 5) | (5, 5) => 8,
                (3, n) => [0, 2, 4, 5, 7][n.min(4)],
                (_, n) => [0, 3, 5, 7][n.min(3)],
            };
            let mut digits = bits.take(length);
            for number in group {
                *number = (digits % base) as u8;
                digits /= base;
            }
        }
    }
    let length = mode.endpoint_bits;
    for number in numbers.iter_mut() {
        let value = bits.take(length);
        let index = ((u32::from(*number) << length | value) as usize).min(191);
        *number = match (mode.packed, length) {
            (Packed::Bits, 8) => value as u8,
            (Packed::Bits, 5) => (value << 3 | value >> 2) as u8,
            (Packed::Bits, _) => (value * 17) as u8,
            (Packed::Trits, 2) => TRITS_2[index],
            (Packed::Trits, 4) => TRITS_4[index],
            (Packed::Trits, _) => TRITS_6[index],
            (Packed::Quints, 3) => QUINTS_3[index],
            (Packed::Quints, _) => QUINTS_5[index],
        };
    }
    let mut out = [[[0, 0, 0, 255]; 2]; 4];
    for (pair, numbers) in out.iter_mut().zip(numbers.chunks_exact(2 * channels)) {
        for (end, color) in pair.iter_mut().enumerate() {
            let at = |channel: usize| numbers[2 * channel + end];
            *color = match mode.endpoints {
                Endpoints::La => [at(0), at(0), at(0), at(1)],
                Endpoints::Rgb => [at(0), at(1), at(2), 255],
                Endpoints::Rgba => [at(0), at(1), at(2), at(3)],
            };
        }
    }
    out
}

/// The weights 0 to 64 of all values of `bits` bits.
pub(super) fn expanded_weights(bits: u32) -> &'static [u8; 32] {
    const WEIGHTS: [[u8; 32]; 6] = [weights(1), weights(1), weights(2), weights(3), weights(4), weights(5)];
    &WEIGHTS[(bits as usize).min(5)]
}

/// Weights of `bits` bits: the bits are repeated to six, and values above 32 are one more.
const fn weights(bits: u32) -> [u8; 32] {
    let mut out = [0; 32];
    let mut i = 0;
    while i < 1 << bits {
        let mut six = 0;
        let mut filled = 0;
        while filled < 6 {
            let shift = 6 - filled - bits as i32;
            six |= if shift >= 0 { i << shift } else { i >> -shift };
            filled += bits as i32;
        }
        out[i] = (six + if six > 32 { 1 } else { 0 }) as u8;
        i += 1;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the tables of the specification (uastc-unquantization-data).
    #[test]
    fn numbers_have_the_values_of_the_tables() {
        assert_eq!(TRITS_2[..12], [0, 255, 69, 186, 23, 232, 92, 163, 46, 209, 116, 139]);
        assert_eq!(QUINTS_3[..8], [0, 255, 32, 223, 65, 190, 97, 158]);
        assert_eq!(QUINTS_3[32..40], [26, 229, 58, 197, 91, 164, 123, 132]);
        assert_eq!(TRITS_4[16..24], [5, 250, 21, 234, 38, 217, 54, 201]);
        assert_eq!(TRITS_4[40..48], [76, 179, 92, 163, 108, 147, 124, 131]);
        assert_eq!(QUINTS_5[96..102], [4, 251, 12, 243, 20, 235]);
        assert_eq!(QUINTS_5[154..160], [110, 145, 118, 137, 126, 129]);
        assert_eq!(TRITS_6[60..68], [120, 135, 124, 131, 1, 254, 5, 250]);
        assert_eq!(TRITS_6[186..192], [118, 137, 122, 133, 126, 129]);
    }

    #[test]
    fn weights_have_the_values_of_the_table() {
        assert_eq!(expanded_weights(1)[..2], [0, 64]);
        assert_eq!(expanded_weights(2)[..4], [0, 21, 43, 64]);
        assert_eq!(expanded_weights(3)[..8], [0, 9, 18, 27, 37, 46, 55, 64]);
        assert_eq!(expanded_weights(4)[5..11], [21, 25, 29, 35, 39, 43]);
        assert_eq!(expanded_weights(5)[14..18], [28, 30, 34, 36]);
    }
}
