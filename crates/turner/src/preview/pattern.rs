//! Which pixels are sampled in a frame, and with which random numbers.
//!
//! The sixteen pixels of a square of 4 x 4 share one Owen-scrambled Sobol sequence, so that their samples are as evenly
//! distributed as those of one pixel with sixteen samples. A filter over the square then leaves little noise (Keller and
//! Heidrich 2001, "Interleaved sampling"). A frame lights every second pixel, like one colour of a
//! checkerboard; the next frame lights the others.
//!
//! ```text
//!   frame 0, 2, …      numbers of the samples
//!   # . # .            0 . 2 .
//!   . # . #            . 4 . 7
//!   # . # .            3 . 1 .
//!   . # . #            . 6 . 5
//! ```

use crate::sampler::{OwenSobol, SampleId};

/// Side of a square of pixels that share a sequence.
pub(super) const SQUARE: u32 = 4;

/// Numbers of the samples within a square, in rows: those of the pixels with an even sum of coordinates, then the others.
const ORDER: [u8; 16] = [0, 0, 2, 2, 4, 4, 7, 7, 3, 3, 1, 1, 6, 6, 5, 5];

/// The pattern of one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pattern {
    pub(super) frame: u32,
    pub(super) seed: u64,
}

impl Pattern {
    /// Whether a pixel is lit in this frame.
    #[inline]
    pub(super) fn lights(self, x: u32, y: u32) -> bool {
        (x ^ y ^ self.frame) & 1 == 0
    }

    /// Whether the cell of 2 x 2 pixels at these even coordinates gets indirect light in this frame.
    #[inline]
    pub(super) fn gathers(self, x: u32, y: u32) -> bool {
        /// Cells of 4 x 4 pixels in the order of the frames.
        const CELLS: [u32; 4] = [0, 3, 1, 2];
        let cell = (x >> 1 & 1) | (y & 2);
        (x | y) & 1 == 0 && CELLS[(self.frame & 3) as usize] == cell
    }

    /// The id of a pixel's sample: that of its square and the number within it.
    #[inline]
    pub(super) fn id(self, x: u32, y: u32) -> SampleId {
        let odd = (x ^ y) & 1;
        let number = u32::from(ORDER[(x % SQUARE + SQUARE * (y % SQUARE)) as usize]);
        let index = number + 8 * (self.frame >> 1);
        SampleId { x: x / SQUARE * 2 + odd, y: y / SQUARE, index, seed: self.seed }
    }

    /// The sequence of cells that get indirect light: sixteen of them share one.
    #[inline]
    pub(super) fn of_cell(self, x: u32, y: u32) -> OwenSobol {
        let (i, j) = (x / SQUARE, y / SQUARE);
        let number = u32::from(ORDER[(i % SQUARE + SQUARE * (j % SQUARE)) as usize]) * 2 + ((i ^ j) & 1);
        let index = number + 16 * self.frame;
        let (x, y) = (i / SQUARE, j / SQUARE);
        OwenSobol::new(&SampleId { x, y, index, seed: self.seed ^ 0x9e37_79b9 })
    }
}
