//! An environment map in tiles: 32 columns by 16 rows of equal angles. A direction can be sampled within one tile, in
//! proportion to luminance.

use super::distribution::{Distribution, Row};
use crate::math::DVec2;

/// Columns and rows of tiles.
pub(super) const COLUMNS: usize = 32;
pub(super) const ROWS: usize = 16;
/// Number of tiles. Tiles are numbered row by row.
pub(super) const TILES: usize = COLUMNS * ROWS;

/// The ends of intervals in 0..=1 in proportion to weights. The last interval with a weight ends at 1.
pub(super) fn ends(weights: &[f64], ends: &mut [f32]) {
    let sum: f64 = weights.iter().sum();
    let last = weights.iter().rposition(|w| *w > 0.0).unwrap_or(0);
    let mut before = 0.0;
    for (i, (weight, end)) in weights.iter().zip(ends).enumerate() {
        before += weight;
        *end = if i >= last { 1.0 } else { (before / sum) as f32 };
    }
}

/// The interval that holds `u`, its length, and `u` rescaled to 0..1.
#[inline]
pub(super) fn choose(ends: &[f32], u: f64) -> (usize, f64, f64) {
    // Counting has no branches that no processor can predict.
    // Rounding must not lead beyond the last interval with a weight.
    let at = (u as f32).min(1.0 - 0.5 * f32::EPSILON);
    let ended: u32 = ends.iter().map(|end| u32::from(*end <= at)).sum();
    let chosen = (ended as usize).min(ends.len() - 1);
    let begin = chosen.checked_sub(1).map_or(0.0, |before| f64::from(ends[before]));
    let length = f64::from(ends[chosen]) - begin;
    (chosen, length, ((u - begin) / length).clamp(0.0, 1.0 - f64::EPSILON))
}

/// Tables for sampling within tiles.
#[derive(Debug)]
pub(super) struct Tiles {
    /// The column of tiles of each pixel column, and the row of tiles of each pixel row.
    of_column: Vec<u8>,
    of_row: Vec<u8>,
    /// First pixel column of each column of tiles, and the end.
    columns: [u32; COLUMNS + 1],
    /// First pixel row of each row of tiles, and the end.
    rows: [u32; ROWS + 1],
    /// The probability of each tile when directions are sampled from the whole map.
    probabilities: Vec<f64>,
    /// Maximum number of pixel rows of a tile. For each tile the end of each of them in 0..=1, by their probability in
    /// the tile.
    rows_per_tile: usize,
    ends: Vec<f32>,
}

impl Tiles {
    pub(super) fn new(distribution: &Distribution) -> Tiles {
        let (width, height) = distribution.size();
        let of = |size: u32, parts: usize| -> Vec<u8> {
            (0..u64::from(size)).map(|i| (i * parts as u64 / u64::from(size)) as u8).collect()
        };
        let (of_column, of_row) = (of(width, COLUMNS), of(height, ROWS));
        let first = |of: &[u8], part: usize| of.partition_point(|i| usize::from(*i) < part) as u32;
        let columns: [u32; COLUMNS + 1] = std::array::from_fn(|i| first(&of_column, i));
        let rows: [u32; ROWS + 1] = std::array::from_fn(|i| first(&of_row, i));
        let rows_per_tile = rows.windows(2).map(|rows| (rows[1] - rows[0]) as usize).max().unwrap_or(1);
        let mut tiles = Tiles {
            of_column,
            of_row,
            columns,
            rows,
            probabilities: Vec::with_capacity(TILES),
            rows_per_tile,
            ends: vec![1.0; TILES * rows_per_tile],
        };
        let mut weights = vec![0.0; rows_per_tile];
        for (tile, to) in tiles.ends.chunks_mut(rows_per_tile).enumerate() {
            let (row, column) = (tile / COLUMNS, tile % COLUMNS);
            weights.fill(0.0);
            for (weight, y) in weights.iter_mut().zip(rows[row]..rows[row + 1]) {
                *weight = distribution.probability(y, [columns[column], columns[column + 1]]);
            }
            tiles.probabilities.push(weights.iter().sum());
            ends(&weights, to);
        }
        tiles
    }

    /// The tile that holds (u, v) of the image, each in 0..=1.
    #[inline]
    pub(super) fn at(&self, uv: DVec2) -> usize {
        let tile = |v: f64, of: &[u8]| usize::from(of[((v * of.len() as f64) as usize).min(of.len() - 1)]);
        tile(uv.y, &self.of_row) * COLUMNS + tile(uv.x, &self.of_column)
    }

    /// The probability of a tile when directions are sampled from the whole map.
    #[inline]
    pub(super) fn probability(&self, tile: usize) -> f64 {
        self.probabilities[tile]
    }

    /// The row and the position along it that two uniform numbers choose within a tile.
    #[inline]
    pub(super) fn row_in(&self, distribution: &Distribution, tile: usize, [u, v]: [f64; 2]) -> Option<Row> {
        let ends = self.ends.get(tile * self.rows_per_tile..(tile + 1) * self.rows_per_tile)?;
        let (row, _, down) = choose(ends, v);
        let (first, column) = (self.rows[tile / COLUMNS], tile % COLUMNS);
        let columns = [self.columns[column], self.columns[column + 1]];
        Some(distribution.row_between(first + row as u32, down, columns, u))
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.probabilities)
            + size_of_val(&*self.ends)
            + self.of_column.len()
            + self.of_row.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Also a number that is 1 in single precision.
    #[test]
    fn intervals_without_a_weight_are_never_chosen() {
        for count in [4, 200] {
            let mut weights = vec![0.0; count];
            (weights[1], weights[2]) = (0.3, 0.7);
            let mut ends_of = vec![0.0; count];
            ends(&weights, &mut ends_of);
            for (u, expected) in [(0.0, 1), (0.29, 1), (0.31, 2), (1.0 - 1e-9, 2), (1.0 - f64::EPSILON, 2)] {
                let (chosen, length, rest) = choose(&ends_of, u);
                assert_eq!(chosen, expected, "{u}");
                assert!(length > 0.0 && (0.0..1.0).contains(&rest), "{u} {length} {rest}");
            }
        }
    }
}
