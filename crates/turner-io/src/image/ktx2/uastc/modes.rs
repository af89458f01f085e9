//! The layouts of UASTC blocks (Khronos Data Format Specification, Universal ASTC: block configuration bits, endpoint
//! and weight bits, partition tables).

/// What a number of an endpoint is packed with, besides its own bits.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Packed {
    /// Nothing.
    Bits,
    /// A digit of base 3; five take 8 bits.
    Trits,
    /// A digit of base 5; three take 7 bits.
    Quints,
}

/// The channels of endpoints.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Endpoints {
    /// Luminance and alpha.
    La,
    /// Red, green and blue; alpha is 255.
    Rgb,
    /// Red, green, blue and alpha.
    Rgba,
}

/// The partitions of a block.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Partitions {
    /// One subset.
    One,
    /// Two subsets, by a table: 2 bits for each pixel, the first pixel lowest.
    Two(&'static [u32]),
    /// Three subsets, likewise.
    Three(&'static [u32]),
}

/// The second plane of weights.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum SecondPlane {
    /// None.
    No,
    /// For the channel that the block names.
    Chosen,
    /// For alpha.
    Alpha,
}

/// The layout of a mode.
#[derive(Clone, Copy)]
pub(super) struct Mode {
    /// Length of the mode's code, in bits.
    pub(super) code: u32,
    /// Bits of hints for encoders of other formats, after the code.
    pub(super) hints: u32,
    pub(super) endpoints: Endpoints,
    pub(super) packed: Packed,
    /// Bits of each number of an endpoint.
    pub(super) endpoint_bits: u32,
    /// Bits of each weight.
    pub(super) weight_bits: u32,
    pub(super) partitions: Partitions,
    pub(super) second_plane: SecondPlane,
}

/// Hints of every mode: one bit for BC1, eight for ETC1.
const HINTS: u32 = 9;
/// The second bit for BC1.
const BC1: u32 = 1;
/// The bias of ETC1.
const BIAS: u32 = 5;
/// Table and multiplier of ETC2's alpha.
const ALPHA: u32 = 8;

use Endpoints::{La, Rgb, Rgba};
use Packed::{Bits, Quints, Trits};
use Partitions::{One, Three, Two};
use SecondPlane::{Alpha, Chosen, No};

/// The index of the mode of one colour, which has a layout of its own.
pub(super) const SOLID: usize = 8;

/// The modes by index. Entry [`SOLID`] is unused.
#[rustfmt::skip]
pub(super) const MODES: [Mode; 19] = [
    mode(4, HINTS + BC1 + BIAS, (Rgb, Trits, 6), 4, One, No),
    mode(6, HINTS + BC1 + BIAS, (Rgb, Bits, 8), 2, One, No),
    mode(5, HINTS + BC1 + BIAS, (Rgb, Bits, 4), 3, Two(&COMMON), No),
    mode(5, HINTS + BC1 + BIAS, (Rgb, Trits, 2), 2, Three(&TRIPLE), No),
    mode(5, HINTS + BC1 + BIAS, (Rgb, Quints, 3), 2, Two(&COMMON), No),
    mode(5, HINTS + BC1 + BIAS, (Rgb, Bits, 8), 3, One, No),
    mode(5, HINTS + BC1 + BIAS, (Rgb, Quints, 5), 2, One, Chosen),
    mode(5, HINTS + BC1 + BIAS, (Rgb, Quints, 3), 2, Two(&MERGED), No),
    mode(5, 0, (Rgba, Bits, 8), 0, One, No),
    mode(5, HINTS + BC1 + BIAS + ALPHA, (Rgba, Bits, 4), 2, Two(&COMMON), No),
    mode(3, HINTS + ALPHA, (Rgba, Trits, 4), 4, One, No),
    mode(2, HINTS + ALPHA, (Rgba, Trits, 4), 2, One, Chosen),
    mode(3, HINTS + ALPHA, (Rgba, Trits, 6), 3, One, No),
    mode(5, HINTS + BC1 + BIAS + ALPHA, (Rgba, Bits, 8), 1, One, Chosen),
    mode(5, HINTS + BC1 + BIAS + ALPHA, (Rgba, Bits, 8), 2, One, No),
    mode(7, HINTS + BC1 + BIAS + ALPHA, (La, Bits, 8), 4, One, No),
    mode(6, HINTS + BC1 + BIAS + ALPHA, (La, Bits, 8), 2, Two(&COMMON), No),
    mode(6, HINTS + BC1 + BIAS + ALPHA, (La, Bits, 8), 2, One, Alpha),
    mode(4, HINTS + BC1 + BIAS, (Rgb, Bits, 5), 5, One, No),
];

const fn mode(
    code: u32,
    hints: u32,
    (endpoints, packed, endpoint_bits): (Endpoints, Packed, u32),
    weight_bits: u32,
    partitions: Partitions,
    second_plane: SecondPlane,
) -> Mode {
    Mode { code, hints, endpoints, packed, endpoint_bits, weight_bits, partitions, second_plane }
}

/// The mode's index by the seven lowest bits of a block; `None` for codes without a mode.
pub(super) fn index_of(block: u128) -> Option<usize> {
    let bits = (block & 127) as u8;
    let found = match bits & 3 {
        0 => 11,
        2 => {
            if bits & 4 == 0 {
                10
            } else {
                12
            }
        }
        _ => match bits & 15 {
            1 => 0,
            9 => 18,
            _ => match bits & 31 {
                0x03 => 3,
                0x07 => 7,
                0x0b => 5,
                0x0d => 14,
                0x0f => 9,
                0x13 => 4,
                0x17 => SOLID,
                0x1b => 6,
                0x1d => 2,
                0x1f => 13,
                _ => match bits & 63 {
                    0x15 => 16,
                    0x25 => 17,
                    0x35 => 1,
                    _ if bits == 0x05 => 15,
                    _ => return None,
                },
            },
        },
    };
    Some(found)
}

/// Partitions of one bit per pixel with two bits per pixel.
const fn spread<const N: usize>(one: [u16; N]) -> [u32; N] {
    let mut two = [0; N];
    let mut i = 0;
    while i < N {
        let mut pixel = 0;
        while pixel < 16 {
            two[i] |= ((one[i] >> pixel & 1) as u32) << (2 * pixel);
            pixel += 1;
        }
        i += 1;
    }
    two
}

/// Partitions in two subsets that ASTC and BC7 share: modes 2, 4, 9 and 16.
const COMMON: [u32; 30] = spread([
    0xcccc, 0x8888, 0x1111, 0xecc8, 0x377f, 0xfeec, 0x0137, 0x137f, 0xc800, 0x0013, 0xfe80, 0x17ff, 0x0017,
    0x00ff, 0xfff0, 0x0fff, 0xff71, 0x8eff, 0x08ce, 0x008c, 0x7310, 0xceff, 0x7331, 0x088c, 0xceef, 0x6666,
    0xf00f, 0x5555, 0x0f0f, 0x36c9,
]);

/// Partitions in two subsets of ASTC that are three of BC7's with two of them merged: mode 7.
const MERGED: [u32; 19] = spread([
    0x00f0, 0x4444, 0x0133, 0xcc80, 0xf0ff, 0x2222, 0xffc8, 0xccce, 0x3c03, 0x00ee, 0x7700, 0x3003, 0x00ce,
    0xff80, 0x6fff, 0x1333, 0x11ff, 0x136c, 0x00ef,
]);

/// Partitions in three subsets: mode 3.
const TRIPLE: [u32; 11] = [
    0xa5a5_0000,
    0xaa00_5555,
    0xaa00_0055,
    0x0000_aa55,
    0x2525_2525,
    0x9494_9494,
    0x5858_5858,
    0x5656_0202,
    0x9292_9292,
    0x55aa_0055,
    0xa050_50a0,
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Every layout but that of one colour fills its 128 bits, or leaves few of them.
    #[test]
    fn layouts_fit_their_blocks() {
        for (i, mode) in MODES.iter().enumerate().filter(|(i, _)| *i != SOLID) {
            let (pattern, subsets): (u32, u32) = match mode.partitions {
                One => (0, 1),
                Two(_) => (5, 2),
                Three(_) => (4, 3),
            };
            let channels = match mode.endpoints {
                La => 2,
                Rgb => 3,
                Rgba => 4,
            };
            let numbers = 2 * channels * subsets;
            let digits = match mode.packed {
                Bits => 0,
                Trits => (8 * numbers).div_ceil(5),
                Quints => (7 * numbers).div_ceil(3),
            };
            let planes = if mode.second_plane == No { 1 } else { 2 };
            let choice = if mode.second_plane == Chosen { 2 } else { 0 };
            let weights = planes * (16 * mode.weight_bits - subsets);
            let endpoints = digits + numbers * mode.endpoint_bits;
            let all = mode.code + mode.hints + pattern + choice + endpoints + weights;
            assert!((100..=128).contains(&all), "mode {i}: {all} bits");
        }
    }

    #[test]
    fn codes_are_distinct_and_all_modes_have_one() {
        let mut seen = [0; 19];
        for bits in 0..128u128 {
            if let Some(index) = index_of(bits) {
                seen[index] += 1;
            }
        }
        // A code of n bits begins 2^(7 − n) of the 128 values.
        for (index, mode) in MODES.iter().enumerate() {
            assert_eq!(seen[index], 128 >> mode.code, "mode {index}");
        }
        assert_eq!(index_of(0x45), None);
    }
}
