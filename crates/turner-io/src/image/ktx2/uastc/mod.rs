//! UASTC LDR 4x4: blocks of 4 x 4 pixels in 16 bytes, a subset of ASTC with a layout of its own.
//!
//! A block has a mode, one to three pairs of endpoint colours, and for each pixel a weight between the endpoints of
//! its subset. One channel may have weights of its own, the second plane. The format is that of the Khronos Data
//! Format Specification, Universal ASTC.

mod modes;
mod unpack;

use modes::{MODES, Mode, Partitions, SOLID, SecondPlane};

/// Bytes of a block.
pub(super) const BLOCK: usize = 16;
/// The colour of invalid blocks.
const INVALID: [u8; 4] = [255, 0, 255, 255];

/// Decodes blocks to RGBA, row 0 first. `out` has `4 * width * height` bytes; missing blocks leave their pixels.
pub(super) fn decode(blocks: &[u8], width: usize, out: &mut [u8]) {
    let stride = 4 * width;
    let columns = width.div_ceil(4);
    for (row, line) in blocks.chunks(BLOCK * columns.max(1)).zip(out.chunks_mut(4 * stride.max(1))) {
        for (column, block) in row.as_chunks::<BLOCK>().0.iter().enumerate() {
            let pixels = pixels(u128::from_le_bytes(*block));
            for (four, row) in pixels.as_chunks::<4>().0.iter().zip(line.chunks_exact_mut(stride)) {
                let flat = four.as_flattened();
                let at = BLOCK * column;
                let end = (at + BLOCK).min(row.len());
                if let Some(there) = row.get_mut(at..end) {
                    there.copy_from_slice(&flat[..end - at]);
                }
            }
        }
    }
}

/// Takes bits, lowest first.
struct Bits(u128);

impl Bits {
    /// The next `count` bits, at most 31.
    #[inline]
    fn take(&mut self, count: u32) -> u32 {
        let value = self.0 as u32 & ((1 << count) - 1);
        self.0 >>= count;
        value
    }
}

/// The pixels of a block, row by row.
fn pixels(block: u128) -> [[u8; 4]; 16] {
    let Some(index) = modes::index_of(block) else { return [INVALID; 16] };
    if index == SOLID {
        let color = (block >> MODES[SOLID].code) as u32;
        return [color.to_le_bytes(); 16];
    }
    interpolated(&MODES[index], block).unwrap_or([INVALID; 16])
}

/// The pixels of a block with endpoints and weights; `None` for an invalid one.
fn interpolated(mode: &Mode, block: u128) -> Option<[[u8; 4]; 16]> {
    let mut bits = Bits(block >> (mode.code + mode.hints));
    let (partition, subsets) = match mode.partitions {
        Partitions::One => (0, 1),
        Partitions::Two(table) => (*table.get(bits.take(5) as usize)?, 2),
        Partitions::Three(table) => (*table.get(bits.take(4) as usize)?, 3),
    };
    let second = match mode.second_plane {
        SecondPlane::No => None,
        SecondPlane::Chosen => Some(bits.take(2) as usize),
        SecondPlane::Alpha => Some(3),
    };
    let lines = unpack::endpoints(mode, subsets, &mut bits).map(Line::between);
    let weights = unpack::expanded_weights(mode.weight_bits);
    let mut seen = 0;
    let mut out = [[0; 4]; 16];
    for (i, pixel) in out.iter_mut().enumerate() {
        let subset = (partition >> (2 * i) & 3) as usize;
        // The first weight of a subset is less than half of the range, so that its highest bit is not stored.
        let is_first = seen >> subset & 1 == 0;
        seen |= 1 << subset;
        let stored = mode.weight_bits - u32::from(is_first);
        let line = &lines[subset];
        *pixel = line.at(weights[bits.take(stored) as usize & 31]);
        if let Some(channel) = second {
            pixel[channel] = line.at(weights[bits.take(stored) as usize & 31])[channel];
        }
    }
    Some(out)
}

/// The colours between two endpoints, at 16 bits as ASTC interpolates them.
struct Line {
    /// 64 times the first endpoint, and half of the last bit that is dropped.
    start: [i32; 4],
    /// The difference for one 64th.
    step: [i32; 4],
}

impl Line {
    fn between([low, high]: [[u8; 4]; 2]) -> Line {
        let wide = |v: u8| i32::from(v) * 257;
        Line {
            start: low.map(|v| 64 * wide(v) + 32),
            step: std::array::from_fn(|c| wide(high[c]) - wide(low[c])),
        }
    }

    /// The colour of a weight from 0 to 64.
    #[inline]
    fn at(&self, weight: u8) -> [u8; 4] {
        let weight = i32::from(weight);
        std::array::from_fn(|c| ((self.start[c] + self.step[c] * weight) >> 14) as u8)
    }
}
