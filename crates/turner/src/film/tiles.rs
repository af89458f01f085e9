//! The tiles of a film.

use super::PixelRect;

/// Side of a tile in pixels.
pub const TILE: u32 = 16;

/// Side in pixels of the squares of a [`Half`].
pub const HALF_SQUARE: u32 = 8;

/// Half of the pixels of a picture: a checkerboard of squares of 8 x 8 pixels. Adaptive sampling decides about each half
/// from the samples of the other ([`Renderer::allot`](crate::Renderer::allot)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// The squares with an even sum of column and row.
    Even,
    /// The other squares.
    Odd,
}

impl Half {
    /// Both halves.
    pub const BOTH: [Half; 2] = [Half::Even, Half::Odd];

    /// The half of a pixel of the picture.
    #[inline]
    pub fn of(x: u32, y: u32) -> Half {
        if (x / HALF_SQUARE + y / HALF_SQUARE).is_multiple_of(2) { Half::Even } else { Half::Odd }
    }

    /// The other half.
    pub fn other(self) -> Half {
        match self {
            Half::Even => Half::Odd,
            Half::Odd => Half::Even,
        }
    }
}

/// The tiles of a region, row by row from the top left. Those at the right and bottom may be smaller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileGrid {
    region: PixelRect,
}

impl TileGrid {
    /// The tiles of a non-empty region.
    pub fn new(region: PixelRect) -> TileGrid {
        TileGrid { region }
    }

    /// Number of tiles in a row.
    pub fn columns(&self) -> usize {
        self.region.width.div_ceil(TILE) as usize
    }

    /// Number of rows of tiles.
    pub fn rows(&self) -> usize {
        self.region.height.div_ceil(TILE) as usize
    }

    /// Number of tiles.
    pub fn count(&self) -> usize {
        self.columns() * self.rows()
    }

    /// The pixels of a tile with an index below [`TileGrid::count`].
    pub fn rect(&self, tile: usize) -> PixelRect {
        let (column, row) = (tile % self.columns(), tile / self.columns());
        let (dx, dy) = (column as u32 * TILE, row as u32 * TILE);
        PixelRect {
            x: self.region.x + dx,
            y: self.region.y + dy,
            width: TILE.min(self.region.width - dx),
            height: TILE.min(self.region.height - dy),
        }
    }

    /// Number of pixels of one half of a tile.
    pub fn half_area(&self, tile: usize, half: Half) -> u64 {
        let PixelRect { x, y, width, height } = self.rect(tile);
        let row = |y: u32| (x..x + width).filter(|x| Half::of(*x, y) == half).count() as u64;
        (y..y + height).map(row).sum()
    }

    /// The indices of all tiles that overlap a rectangle.
    pub fn touching(&self, rect: &PixelRect) -> Vec<u32> {
        let apart = |a: u32, size: u32, b: u32, other: u32| a + size <= b || b + other <= a;
        let touches = |tile: &u32| {
            let own = self.rect(*tile as usize);
            !apart(own.x, own.width, rect.x, rect.width) && !apart(own.y, own.height, rect.y, rect.height)
        };
        (0..self.count() as u32).filter(touches).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_a_region_once() {
        let region = PixelRect { x: 5, y: 9, width: 50, height: 33 };
        let grid = TileGrid::new(region);
        assert_eq!((grid.columns(), grid.rows(), grid.count()), (4, 3, 12));
        let mut times = vec![0; 50 * 33];
        for tile in 0..grid.count() {
            let rect = grid.rect(tile);
            for y in rect.y..rect.y + rect.height {
                for x in rect.x..rect.x + rect.width {
                    times[((y - 9) * 50 + x - 5) as usize] += 1;
                }
            }
            assert_eq!(grid.touching(&rect), [tile as u32]);
        }
        assert!(times.iter().all(|n| *n == 1));
        let halves = |tile| Half::BOTH.map(|half| grid.half_area(tile, half));
        assert_eq!((halves(0), halves(3)), ([128, 128], [16, 16]));
        assert!((0..12).all(|tile| halves(tile).iter().sum::<u64>() == grid.rect(tile).area()));
        assert_eq!(grid.touching(&PixelRect { x: 20, y: 0, width: 2, height: 26 }), [0, 1, 4, 5]);
        assert_eq!(grid.touching(&PixelRect { x: 55, y: 0, width: 9, height: 99 }), []);
    }
}
