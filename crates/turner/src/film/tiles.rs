//! The tiles of a film.

use super::PixelRect;

/// Side of a tile in pixels.
pub const TILE: u32 = 16;

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
        assert_eq!(grid.touching(&PixelRect { x: 20, y: 0, width: 2, height: 26 }), [0, 1, 4, 5]);
        assert_eq!(grid.touching(&PixelRect { x: 55, y: 0, width: 9, height: 99 }), []);
    }
}
