//! A coarse preview of pixels without samples.

use super::{Film, PixelRect};

/// Side of a preview block in pixels.
pub const COARSE: u32 = 4;

/// One value for each block of [`COARSE`] x [`COARSE`] pixels of a film's region, shown where a pixel has no
/// samples. It is never part of a sum.
#[derive(Clone, Debug)]
pub struct Preview {
    region: PixelRect,
    columns: usize,
    /// Colour times coverage, and coverage, row by row; `None` for blocks not traced yet.
    blocks: Vec<Option<[f32; 4]>>,
}

impl Preview {
    /// An empty preview of a region.
    pub(crate) fn new(region: PixelRect) -> Preview {
        let (columns, rows) =
            (region.width.div_ceil(COARSE) as usize, region.height.div_ceil(COARSE) as usize);
        Preview { region, columns, blocks: vec![None; columns * rows] }
    }

    /// Rows of blocks.
    pub(crate) fn rows(&self) -> u32 {
        self.region.height.div_ceil(COARSE)
    }

    /// The pixels that are traced for a row of blocks: the top left one of each block.
    pub(crate) fn positions(&self, row: u32) -> impl Iterator<Item = (u32, u32)> + Clone + use<> {
        let PixelRect { x, y, width, .. } = self.region;
        (0..width).step_by(COARSE as usize).map(move |dx| (x + dx, y + row * COARSE))
    }

    /// Sets a row of blocks, from the left.
    pub(crate) fn set_row(&mut self, row: u32, values: impl Iterator<Item = [f32; 4]>) {
        let first = row as usize * self.columns;
        let blocks = self.blocks.iter_mut().skip(first).take(self.columns);
        blocks.zip(values).for_each(|(block, value)| *block = Some(value));
    }

    /// The value of a pixel, if it is one that is traced.
    pub(crate) fn traced(&self, x: u32, y: u32) -> Option<[f32; 4]> {
        let first = |at: u32, from: u32| at.checked_sub(from).is_some_and(|d| d.is_multiple_of(COARSE));
        let is_traced = first(x, self.region.x) && first(y, self.region.y);
        if is_traced { self.pixel(x, y) } else { None }
    }

    /// The value of the block of a pixel.
    pub(super) fn pixel(&self, x: u32, y: u32) -> Option<[f32; 4]> {
        let (dx, dy) = (x.checked_sub(self.region.x)?, y.checked_sub(self.region.y)?);
        let (column, row) = ((dx / COARSE) as usize, (dy / COARSE) as usize);
        *self.blocks.get(row * self.columns + column).filter(|_| column < self.columns)?
    }
}

impl Film {
    /// Sets or removes the preview shown where there are no samples.
    pub(crate) fn set_preview(&mut self, preview: Option<Preview>) {
        self.preview = preview;
    }

    /// Whether there is a preview.
    pub(crate) fn has_preview(&self) -> bool {
        self.preview.is_some()
    }

    /// Removes and returns the preview.
    pub(crate) fn take_preview(&mut self) -> Option<Preview> {
        self.preview.take()
    }
}
