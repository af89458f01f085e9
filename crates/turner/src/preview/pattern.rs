//! Which pixels are sampled in a frame, and with which random numbers.
//!
//! The sixteen pixels of a square of 4 x 4 share one Owen-scrambled Sobol sequence, so that their samples are as evenly
//! distributed as those of one pixel with sixteen samples. A filter over the square then leaves little noise (Keller and
//! Heidrich 2001, "Interleaved sampling").
//!
//! The first frame of a view traces every second pixel, like one colour of a checkerboard, and lights the heads of the
//! cells of 2 x 2 or 4 x 4 pixels. Further frames light every second pixel, and the next frame lights the others.
//!
//! ```text
//!   first frame        frames 2, 4, …     numbers of the samples
//!   # . # .            # . # .            0 . 2 .
//!   . o . o            . # . #            . 4 . 7
//!   # . # .            # . # .            3 . 1 .
//!   . o . o            . # . #            . 6 . 5
//! ```

use crate::sampler::{OwenSobol, SampleId, mix};

/// Side of a square of pixels that share a sequence.
pub(super) const SQUARE: u32 = 4;

/// Numbers of the samples within a square, in rows: those of the pixels with an even sum of coordinates, then the others.
const ORDER: [u8; 16] = [0, 0, 2, 2, 4, 4, 7, 7, 3, 3, 1, 1, 6, 6, 5, 5];

/// The pattern of one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pattern {
    pub(super) frame: u32,
    pub(super) seed: u64,
    /// Whether the frame is the first of its view: only the heads of cells are lit.
    pub(super) is_first: bool,
    /// Pixels along a side of a cell: 2 or 4.
    pub(super) cell: u32,
}

impl Pattern {
    /// Whether a pixel is lit in this frame.
    #[inline]
    pub(super) fn lights(self, x: u32, y: u32) -> bool {
        if self.is_first { self.is_head(x, y) } else { (x ^ y ^ self.frame) & 1 == 0 }
    }

    /// Whether a pixel is traced in this frame whatever its neighbours are.
    #[inline]
    pub(super) fn traces(self, x: u32, y: u32) -> bool {
        !self.is_first || (x ^ y) & 1 == 0
    }

    /// Whether a pixel is the head of its cell.
    #[inline]
    pub(super) fn is_head(self, x: u32, y: u32) -> bool {
        (x | y) & (self.cell - 1) == 0
    }

    /// Whether a pixel gets indirect light in this frame: one of each square of 4 x 4.
    #[inline]
    pub(super) fn gathers(self, x: u32, y: u32) -> bool {
        if self.cell == SQUARE {
            return self.is_head(x, y);
        }
        /// The cells of a square in the order of the frames.
        const CELLS: [u32; 4] = [0, 3, 1, 2];
        let cell = (x >> 1 & 1) | (y & 2);
        self.is_head(x, y) && CELLS[(self.frame & 3) as usize] == cell
    }

    /// The id of a pixel's sample: that of its square and the number within it.
    #[inline]
    pub(super) fn id(self, x: u32, y: u32) -> SampleId {
        if self.is_first {
            return self.id_of_cell(x / self.cell, y / self.cell, self.seed ^ 0x7f4a_7c15);
        }
        let odd = (x ^ y) & 1;
        let number = u32::from(ORDER[(x % SQUARE + SQUARE * (y % SQUARE)) as usize]);
        let index = number + 8 * (self.frame >> 1);
        SampleId { x: x / SQUARE * 2 + odd, y: y / SQUARE, index, seed: self.seed }
    }

    /// Two numbers of 0..1 for a cell's head, for anything but its sample.
    #[inline]
    pub(super) fn random(self, x: u32, y: u32) -> [f64; 2] {
        let z = mix(mix(u64::from(x) << 32 | u64::from(y)) ^ u64::from(self.frame) ^ self.seed);
        [z as u32, (z >> 32) as u32].map(|v| f64::from(v) * (1.0 / 4_294_967_296.0))
    }

    /// The sequence of cells that get indirect light: sixteen of them share one.
    #[inline]
    pub(super) fn of_cell(self, x: u32, y: u32) -> OwenSobol {
        OwenSobol::new(&self.id_of_cell(x / SQUARE, y / SQUARE, self.seed ^ 0x9e37_79b9))
    }

    /// The id of a cell's sample: that of its square of 4 x 4 cells and the number within it.
    #[inline]
    fn id_of_cell(self, i: u32, j: u32, seed: u64) -> SampleId {
        let number = u32::from(ORDER[(i % SQUARE + SQUARE * (j % SQUARE)) as usize]) * 2 + ((i ^ j) & 1);
        SampleId { x: i / SQUARE, y: j / SQUARE, index: number + 16 * self.frame, seed }
    }
}
