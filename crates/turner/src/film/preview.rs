//! A coarse preview of pixels without samples.

use super::{Film, Half, PixelRect};

/// Side of a preview block in pixels.
pub const COARSE: u32 = 4;

/// Strides of the blocks that are traced, one after another: the picture is whole, and four times as coarse, after a
/// sixteenth of its blocks, and so on.
const STRIDES: [u32; 4] = [8, 4, 2, 1];

/// One value for each block of [`COARSE`] x [`COARSE`] pixels of a film's region, shown where a pixel has no
/// samples. It is never part of a sum. A block that is not traced yet shows one above or left of it that is.
#[derive(Clone, Debug)]
pub struct Preview {
    region: PixelRect,
    columns: u32,
    /// Colour times coverage, and coverage, row by row; `None` for blocks not traced yet.
    blocks: Vec<Option<[f32; 4]>>,
    /// Whether the integrator had made its choices before.
    pub(crate) is_chosen: bool,
}

/// Blocks of one row that are traced together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PreviewRow {
    row: u32,
    /// Its first column.
    first: u32,
    /// From one column to the next.
    step: u32,
}

impl Preview {
    /// An empty preview of a region.
    pub(crate) fn new(region: PixelRect) -> Preview {
        let (columns, rows) = (region.width.div_ceil(COARSE), region.height.div_ceil(COARSE));
        let blocks = vec![None; columns as usize * rows as usize];
        Preview { region, columns, blocks, is_chosen: false }
    }

    /// All blocks, in the order in which they are traced.
    pub(crate) fn rows(&self) -> Vec<PreviewRow> {
        let rows = self.region.height.div_ceil(COARSE);
        let mut out = Vec::new();
        for stride in STRIDES {
            for row in (0..rows).step_by(stride as usize) {
                // The coarser strides have traced every other block of every other row.
                let is_begun = stride < STRIDES[0] && row.is_multiple_of(2 * stride);
                let (first, step) = if is_begun { (stride, 2 * stride) } else { (0, stride) };
                if first < self.columns {
                    out.push(PreviewRow { row, first, step });
                }
            }
        }
        out
    }

    /// The pixels that are traced for blocks of a row: the top left one of each block.
    pub(crate) fn positions(&self, row: PreviewRow) -> impl Iterator<Item = (u32, u32)> + Clone + use<> {
        let PixelRect { x, y, .. } = self.region;
        let columns = (row.first..self.columns).step_by(row.step as usize);
        columns.map(move |column| (x + column * COARSE, y + row.row * COARSE))
    }

    /// Sets blocks of a row, from the left.
    pub(crate) fn set(&mut self, row: PreviewRow, values: impl Iterator<Item = [f32; 4]>) {
        let first = row.row as usize * self.columns as usize;
        let blocks = self.blocks.iter_mut().skip(first).take(self.columns as usize);
        let blocks = blocks.skip(row.first as usize).step_by(row.step as usize);
        blocks.zip(values).for_each(|(block, value)| *block = Some(value));
    }

    /// The value of a pixel, if it is one that is traced.
    pub(crate) fn traced(&self, x: u32, y: u32) -> Option<[f32; 4]> {
        let first = |at: u32, from: u32| at.checked_sub(from).is_some_and(|d| d.is_multiple_of(COARSE));
        let is_traced = first(x, self.region.x) && first(y, self.region.y);
        let block = [(x.checked_sub(self.region.x)?) / COARSE, (y.checked_sub(self.region.y)?) / COARSE];
        if is_traced { self.block(block) } else { None }
    }

    fn block(&self, [column, row]: [u32; 2]) -> Option<[f32; 4]> {
        let i = row as usize * self.columns as usize + column as usize;
        *self.blocks.get(i).filter(|_| column < self.columns)?
    }

    /// The value of the block of a pixel, or of the nearest one above and left that is traced.
    pub(super) fn pixel(&self, x: u32, y: u32) -> Option<[f32; 4]> {
        let (dx, dy) = (x.checked_sub(self.region.x)?, y.checked_sub(self.region.y)?);
        let [column, row] = [dx / COARSE, dy / COARSE];
        let of = |stride: &u32| self.block([column - column % stride, row - row % stride]);
        STRIDES.iter().rev().find_map(of)
    }

    /// Whether every pixel shows something.
    fn is_whole(&self) -> bool {
        let coarsest = self.rows().into_iter().filter(|row| row.step == STRIDES[0] && row.first == 0);
        coarsest.flat_map(|row| self.positions(row)).all(|(x, y)| self.traced(x, y).is_some())
    }
}

impl Film {
    /// Sets or removes the preview shown where there are no samples.
    pub(crate) fn set_preview(&mut self, preview: Option<Preview>) {
        self.preview = preview;
    }

    /// Whether every pixel has a sample or a block of the preview.
    pub(crate) fn is_covered(&self) -> bool {
        let has_sample = |tile| Half::BOTH.iter().all(|half| !self.held_half(tile, *half).is_empty());
        self.preview.as_ref().is_some_and(Preview::is_whole) || (0..self.tiles().count()).all(has_sample)
    }

    /// Whether there is a preview.
    pub fn has_preview(&self) -> bool {
        self.preview.is_some()
    }

    /// Removes and returns the preview.
    pub(crate) fn take_preview(&mut self) -> Option<Preview> {
        self.preview.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_block_is_traced_once_and_the_coarsest_cover_the_picture() {
        for (width, height) in [(1, 1), (53, 37), (33, 4), (4, 129), (128, 64)] {
            let region = PixelRect { x: 5, y: 3, width, height };
            let mut preview = Preview::new(region);
            let mut seen = std::collections::HashSet::new();
            let blocks = width.div_ceil(COARSE) * height.div_ceil(COARSE);
            for row in preview.rows() {
                let positions: Vec<_> = preview.positions(row).collect();
                for at in &positions {
                    assert!(preview.traced(at.0, at.1).is_none() && seen.insert(*at));
                }
                preview.set(row, positions.iter().map(|(x, y)| [*x as f32, *y as f32, 0.0, 1.0]));
                if !preview.is_whole() {
                    continue;
                }
                // Each pixel shows a block above and left of it.
                for (x, y) in (3..3 + height).flat_map(|y| (5..5 + width).map(move |x| (x, y))) {
                    let [px, py, ..] = preview.pixel(x, y).unwrap();
                    assert!(px <= x as f32 && py <= y as f32 && x as f32 - px < 32.0 && y as f32 - py < 32.0);
                }
            }
            assert!(seen.len() as u32 == blocks && preview.is_whole());
            let [x, y, ..] = preview.pixel(5 + width - 1, 3 + height - 1).unwrap();
            assert_eq!([x as u32, y as u32], [5 + (width - 1) / 4 * 4, 3 + (height - 1) / 4 * 4]);
        }
    }
}
