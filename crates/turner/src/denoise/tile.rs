//! Tiles: the fits of a tile's pixels, and what they predict for the pixels around them.

use turner_bvh::lanes::{Block32, F32x8, LANES, Simd, Work, dispatch};

use super::fit::{Coefficients, ROW, Row, TERMS, fill, solve};
use super::light::Light;
use super::lines::{add, block};
use super::weights::{Line, RADIUS, REGION, SIDE, TAPS, TILE, Weights};
use super::{DenoiseOptions, GUIDES, Rgb};
use crate::film::strips;

/// Every third pixel has a fit.
const STEP: usize = 3;
/// A pixel has a fit of its own if those around it count less than this fraction of what they should.
const COVERED: f32 = 0.5;
/// The same if their weights sum up to less than this.
const LEAST: f32 = 1.5;
/// Distances count up to this many doublings beyond that of the middle of the tile.
const FAR: f32 = 2.0;
/// Pixels of a row of a window, filled up to whole vectors.
const WIDE: usize = SIDE.next_multiple_of(LANES);
/// Columns of the rows of terms and predictions.
const COLUMNS: usize = REGION + WIDE - SIDE;

/// Predicted light, and its weight, around a tile.
struct Predicted {
    /// Red, green, blue and weights: rows of a region.
    planes: [Vec<[f32; COLUMNS]>; 4],
}

impl Predicted {
    fn new() -> Predicted {
        Predicted { planes: std::array::from_fn(|_| vec![[0.0; COLUMNS]; REGION]) }
    }
}

/// What a thread works with.
struct Buffers {
    weights: Weights,
    rows: Vec<[Block32; ROW / LANES]>,
    terms: [Vec<[f32; COLUMNS]>; TERMS],
    window: Box<[[f32; WIDE]; SIDE]>,
}

impl Buffers {
    fn new() -> Buffers {
        Buffers {
            weights: Weights::new(),
            rows: vec![[Block32::default(); ROW / LANES]; REGION * REGION],
            terms: std::array::from_fn(|_| vec![[0.0; COLUMNS]; REGION]),
            window: Box::new([[0.0; WIDE]; SIDE]),
        }
    }
}

/// The fits of one tile.
struct Tile<'a> {
    light: &'a Light,
    guides: &'a [[f32; GUIDES]],
    left: usize,
    top: usize,
    buffers: &'a mut Buffers,
    out: &'a mut Predicted,
}

impl Work for Tile<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        self.buffers.weights.compute(self.light, self.left, self.top);
        self.load();
        for y in 0..TILE.min(self.light.height - self.top) {
            let noise = &self.light.variance[(self.top + y) * self.light.width + self.left..];
            if noise[..TILE.min(self.light.width - self.left)].iter().all(|v| *v <= 0.0) {
                continue;
            }
            let alone = self.alone(y);
            for x in 0..TILE.min(self.light.width - self.left) {
                if alone[x] > 0.0 && noise[x] > 0.0 {
                    self.fit(simd, x, y);
                }
            }
        }
    }
}

impl Tile<'_> {
    /// Rows of products and terms of the region.
    #[inline(always)]
    fn load(&mut self) {
        let (width, height) = (self.light.width, self.light.height);
        let near = |at: usize, i: usize, size: usize| (at + i).saturating_sub(RADIUS).min(size - 1);
        let middle = near(self.top, REGION / 2, height) * width + near(self.left, REGION / 2, width);
        let middle = self.guides[middle][GUIDES - 1];
        for y in 0..REGION {
            for x in 0..REGION {
                let i = near(self.top, y, height) * width + near(self.left, x, width);
                let along = |v: usize| (v as f32 - (REGION / 2) as f32) * (1.0 / RADIUS as f32);
                let guide = &self.guides[i];
                let [r, g, b, nx, ny, nz, distance] = *guide;
                let terms =
                    [1.0, along(x), along(y), r, g, b, nx, ny, nz, (distance - middle).clamp(-FAR, FAR)];
                let mut row: Row = [0.0; ROW];
                fill(&mut row, &terms, &self.light.values[i], self.light.variance[i]);
                let blocks = &mut self.buffers.rows[y * REGION + x];
                for (block, values) in blocks.iter_mut().zip(row.chunks_exact(LANES)) {
                    block.0.copy_from_slice(values);
                }
                for (plane, term) in self.buffers.terms.iter_mut().zip(terms) {
                    plane[y][x] = term;
                }
            }
        }
    }

    /// 1 for the pixels of a row that get a fit if they have noise: those of the grid, and those for which the grid is too
    /// coarse.
    #[inline(always)]
    fn alone(&self, y: usize) -> Line {
        let (mut all, mut grid): (Line, Line) = ([0.0; TILE], [0.0; TILE]);
        // Tiles begin on the grid, and so do windows.
        let on_grid: [Line; STEP] = std::array::from_fn(|phase| {
            std::array::from_fn(|x| f32::from(u8::from((x + phase) % STEP == 1)))
        });
        for (k, weights) in self.buffers.weights.of_row(y).iter().enumerate() {
            let (dx, dy) = (k % SIDE, k / SIDE);
            let columns = &on_grid[dx % STEP];
            let noisy = self.buffers.weights.noisy(y, dx, dy);
            let row = if (y + dy) % STEP == 1 { 1.0 } else { 0.0 };
            for x in 0..TILE {
                all[x] += weights[x];
                grid[x] += row * columns[x] * noisy[x] * weights[x];
            }
        }
        const CELL: f32 = (STEP * STEP) as f32;
        std::array::from_fn(|x| {
            let is_grid = y % STEP == 1 && x % STEP == 1;
            let is_covered = CELL * grid[x] >= COVERED * all[x] && grid[x] >= LEAST;
            if is_grid || !is_covered { 1.0 } else { 0.0 }
        })
    }

    /// Fits the window of a pixel and predicts its light.
    #[inline(always)]
    fn fit<S: Simd>(&mut self, simd: S, x: usize, y: usize) {
        let lines = self.buffers.weights.of_row(y);
        let window = &mut *self.buffers.window;
        for k in 0..TAPS {
            window[k / SIDE][k % SIDE] = lines[k][x];
        }
        let mut sums = [F32x8::splat(simd, 0.0); ROW / LANES];
        for (dy, weights) in window.iter().enumerate() {
            let first = (y + dy) * REGION + x;
            for (weight, row) in weights.iter().zip(&self.buffers.rows[first..first + SIDE]) {
                let weight = F32x8::splat(simd, *weight);
                for k in 0..ROW / LANES {
                    sums[k] = sums[k] + weight * F32x8::load(simd, &row[k]);
                }
            }
        }
        let mut blocks = [Block32::default(); ROW / LANES];
        for k in 0..ROW / LANES {
            sums[k].store(&mut blocks[k]);
        }
        let mut sums: Row = [0.0; ROW];
        for (to, block) in sums.chunks_exact_mut(LANES).zip(&blocks) {
            to.copy_from_slice(&block.0);
        }
        if sums[0] > 0.0 {
            let coefficients = solve(&sums);
            self.predict(simd, x, y, &coefficients);
        }
    }

    #[inline(always)]
    fn predict<S: Simd>(&mut self, simd: S, x: usize, y: usize, coefficients: &Coefficients) {
        const VECTORS: usize = WIDE / LANES;
        let own = coefficients.map(|own| own.map(|v| F32x8::splat(simd, v)));
        for dy in 0..SIDE {
            let mut light = own.map(|own| [own[0]; VECTORS]);
            for (k, plane) in self.buffers.terms.iter().enumerate().skip(1) {
                for v in 0..VECTORS {
                    let term = F32x8::load(simd, &block(&plane[y + dy], x + v * LANES));
                    for c in 0..3 {
                        light[c][v] = light[c][v] + own[c][k] * term;
                    }
                }
            }
            let [colors @ .., sum] = &mut self.out.planes;
            for v in 0..VECTORS {
                let weight = F32x8::load(simd, &block(&self.buffers.window[dy], v * LANES));
                let at = x + v * LANES;
                for (plane, light) in colors.iter_mut().zip(&light) {
                    add(simd, &mut plane[y + dy], at, weight * light[v]);
                }
                add(simd, &mut sum[y + dy], at, weight);
            }
        }
    }
}

/// The fitted light of each pixel, with `None` for pixels without noise. Returns `None` if it was cancelled.
pub(super) fn fitted(
    light: &Light,
    guides: &[[f32; GUIDES]],
    options: &DenoiseOptions<'_>,
) -> Option<Vec<Option<Rgb>>> {
    let (width, height) = (light.width, light.height);
    let columns = width.div_ceil(TILE);
    let tiles = columns * height.div_ceil(TILE);
    let is_noisy = |tile: usize| {
        let (left, top) = (tile % columns * TILE, tile / columns * TILE);
        let rows = top.saturating_sub(RADIUS)..(top + TILE + RADIUS).min(height);
        let near = left.saturating_sub(RADIUS)..(left + TILE + RADIUS).min(width);
        rows.into_iter().any(|y| light.variance[y * width..][near.clone()].iter().any(|v| *v > 0.0))
    };
    let predicted: Vec<Option<Box<Predicted>>> =
        strips::with(tiles, options.threads, Buffers::new, |buffers, tile| {
            (!options.is_cancelled() && is_noisy(tile)).then(|| {
                let mut out = Box::new(Predicted::new());
                let (left, top) = (tile % columns * TILE, tile / columns * TILE);
                dispatch(options.set, Tile { light, guides, left, top, buffers, out: &mut out });
                out
            })
        });
    options.go_on()?;
    Some(strips::map(width * height, options.threads, |i| {
        if light.variance[i] <= 0.0 {
            return None;
        }
        let (x, y) = (i % width, i / width);
        let (mut sums, mut weight) = ([0.0f32; 3], 0.0f32);
        let reached =
            |at: usize, size: usize| at.saturating_sub(RADIUS) / TILE..=(at + RADIUS).min(size - 1) / TILE;
        for row in reached(y, height) {
            for column in reached(x, width) {
                let Some(tile) = &predicted[row * columns + column] else { continue };
                let (x, y) = (x + RADIUS - column * TILE, y + RADIUS - row * TILE);
                for c in 0..3 {
                    sums[c] += tile.planes[c][y][x];
                }
                weight += tile.planes[3][y][x];
            }
        }
        (weight > 1e-6).then(|| sums.map(|v| v / weight))
    }))
}
