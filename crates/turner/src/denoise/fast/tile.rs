//! Tiles of blocks: their fits, and what they predict for their pixels.

use turner_bvh::lanes::{Block32, F32x8, LANES, Simd, Work, dispatch};

use super::{BLOCK, Blocks, REACH};
use crate::denoise::fit::{Coefficients, PAIRS, ROW, Row, TERMS, VARIANCE, solve};
use crate::denoise::light::Light;
use crate::denoise::lines::{add, block};
use crate::denoise::{DenoiseOptions, GUIDES, Rgb};
use crate::film::strips;

/// Side of a tile, in blocks.
const TILE: usize = 16;
/// Side of a tile with the windows around it, in blocks.
const REGION: usize = TILE + 2 * REACH;
/// The same with the blocks beside, which are compared.
const OUTER: usize = REGION + 2;
/// Side of a window, in blocks.
const SIDE: usize = 2 * REACH + 1;
/// Pixels beside a block that its fit predicts.
const BESIDE: usize = BLOCK / 2;
/// Side in pixels of what the fits of a tile predict: the tile and a margin.
const PIXELS: usize = TILE * BLOCK + 2 * BESIDE;
/// Pixels that count as one in the terms of position.
const UNIT: f32 = 10.0;
/// Distances count up to this many doublings beyond that of the middle of the tile.
const FAR: f32 = 2.0;
/// Pixels of a block.
const PER_BLOCK: f32 = (BLOCK * BLOCK) as f32;
/// k²: how much of a difference that noise may explain is one.
const K2: f32 = 0.6;
/// The largest term of a comparison: more than that alone makes the weight 0.
const MOST: f32 = 100.0;
/// A window has no fit if its weights sum up to less than this.
const LEAST: f32 = 1e-6;
/// The first index of a term in the upper half of a row of a block's sums.
const UPPER: usize = LANES;
/// Vectors of a block's sums. The matrix of products of terms and light is symmetric: rows 0 to 7 have two vectors, the
/// others only their right one.
const VECTORS: usize = 2 * UPPER + (TERMS - UPPER);

/// The weights of the two blocks that share a pixel, from its distance to their centres.
const TENT: [f32; LANES] = [0.125, 0.375, 0.625, 0.875, 0.875, 0.625, 0.375, 0.125];

const _: () = assert!(BLOCK + 2 * BESIDE == LANES && TERMS > UPPER && TERMS + 3 <= 2 * LANES);

/// The products of terms and light, summed over a block.
type Sums = [Block32; VECTORS];

/// A row of pixels of a tile.
type Line = [f32; PIXELS];

/// The sums of weighted predictions around a tile: planes of red, green, blue and of the weights.
struct Predicted {
    planes: [Vec<Line>; 4],
}

/// What a thread works with.
struct Buffers {
    sums: Vec<Sums>,
    terms: [Vec<Line>; TERMS],
    mean: [[f32; OUTER]; OUTER],
    variance: [[f32; OUTER]; OUTER],
    weights: Vec<[[f32; TILE]; SIDE * SIDE]>,
}

impl Buffers {
    fn new() -> Buffers {
        Buffers {
            sums: vec![[Block32::default(); VECTORS]; REGION * REGION],
            terms: std::array::from_fn(|_| vec![[0.0; PIXELS]; PIXELS]),
            mean: [[0.0; OUTER]; OUTER],
            variance: [[0.0; OUTER]; OUTER],
            weights: vec![[[0.0; TILE]; SIDE * SIDE]; TILE],
        }
    }
}

/// The fits of one tile.
struct Tile<'a> {
    light: &'a Light,
    blocks: &'a Blocks,
    guides: &'a [[f32; GUIDES]],
    /// The first block.
    left: usize,
    top: usize,
    buffers: &'a mut Buffers,
    out: &'a mut Predicted,
}

impl Work for Tile<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        self.load(simd);
        self.compare();
        for y in 0..TILE.min(self.blocks.rows - self.top) {
            for x in 0..TILE.min(self.blocks.columns - self.left) {
                self.fit(simd, x, y);
            }
        }
    }
}

impl Tile<'_> {
    /// Sums of the blocks of the region, and terms of its pixels.
    #[inline(always)]
    fn load<S: Simd>(&mut self, simd: S) {
        let (width, height) = (self.light.width, self.light.height);
        let middle = |first: usize, size: usize| ((first + TILE / 2) * BLOCK).min(size - 1);
        let middle = self.guides[middle(self.top, height) * width + middle(self.left, width)][GUIDES - 1];
        let inside =
            |first: usize, i: usize, size: usize| (first + i).checked_sub(REACH).filter(|v| *v < size);
        for y in 0..REGION {
            let row = inside(self.top, y, self.blocks.rows);
            for x in 0..REGION {
                let at = row.zip(inside(self.left, x, self.blocks.columns));
                self.buffers.sums[y * REGION + x] = match at {
                    Some((row, column)) => self.block(simd, column, row, middle),
                    None => [Block32::default(); VECTORS],
                };
            }
        }
        for y in 0..OUTER {
            let row = (self.top + y).saturating_sub(REACH + 1).min(self.blocks.rows - 1);
            for x in 0..OUTER {
                let column = (self.left + x).saturating_sub(REACH + 1).min(self.blocks.columns - 1);
                let block = row * self.blocks.columns + column;
                self.buffers.mean[y][x] = self.blocks.mean[block];
                self.buffers.variance[y][x] = self.blocks.variance[block];
            }
        }
    }

    /// The sums of a block.
    #[inline(always)]
    fn block<S: Simd>(&mut self, simd: S, column: usize, row: usize, middle: f32) -> Sums {
        let (width, height) = (self.light.width, self.light.height);
        let (left, top) = (self.left * BLOCK, self.top * BLOCK);
        let along =
            |at: usize, first: usize| (at as f32 - first as f32 - (TILE * BLOCK / 2) as f32) * (1.0 / UNIT);
        let mut pixels = [[Block32::default(); 2]; BLOCK * BLOCK];
        for y in row * BLOCK..(row * BLOCK + BLOCK).min(height) {
            for x in column * BLOCK..(column * BLOCK + BLOCK).min(width) {
                let i = y * width + x;
                let [r, g, b, nx, ny, nz, distance] = self.guides[i];
                let distance = (distance - middle).clamp(-FAR, FAR);
                let lower = [1.0, along(x, left), along(y, top), r, g, b, nx, ny];
                let near = (x + BESIDE).checked_sub(left).filter(|x| *x < PIXELS);
                if let Some((x, y)) = near.zip((y + BESIDE).checked_sub(top).filter(|y| *y < PIXELS)) {
                    for (plane, term) in
                        self.buffers.terms.iter_mut().zip(lower.into_iter().chain([nz, distance]))
                    {
                        plane[y][x] = term;
                    }
                }
                if self.light.is_known(i) {
                    let [red, green, blue] = self.light.values[i];
                    let own = self.blocks.variance[row * self.blocks.columns + column];
                    let upper = [nz, distance, red, green, blue, PER_BLOCK * own, 0.0, 0.0];
                    pixels[y % BLOCK * BLOCK + x % BLOCK] = [Block32(lower), Block32(upper)];
                }
            }
        }
        let mut sums = [F32x8::splat(simd, 0.0); VECTORS];
        for [lower, upper] in &pixels {
            let vectors = [F32x8::load(simd, lower), F32x8::load(simd, upper)];
            for i in 0..UPPER {
                let term = F32x8::splat(simd, lower.0[i]);
                for half in 0..2 {
                    sums[2 * i + half] = sums[2 * i + half] + term * vectors[half];
                }
            }
            for i in UPPER..TERMS {
                let sum = &mut sums[UPPER + i];
                *sum = *sum + F32x8::splat(simd, upper.0[i - UPPER]) * vectors[1];
            }
        }
        let mut out = [Block32::default(); VECTORS];
        for k in 0..VECTORS {
            sums[k].store(&mut out[k]);
        }
        out
    }

    /// The weights of the windows.
    #[inline(always)]
    fn compare(&mut self) {
        const SCALE: f32 = 0.25 / 5.0;
        let (mean, variance) = (&self.buffers.mean, &self.buffers.variance);
        for dy in 0..SIDE {
            for dx in 0..SIDE {
                let mut terms = [[0.0f32; TILE + 2]; TILE + 2];
                for y in 0..TILE + 2 {
                    for x in 0..TILE + 2 {
                        let d = mean[y + REACH][x + REACH] - mean[y + dy][x + dx];
                        let (v, w) = (variance[y + REACH][x + REACH], variance[y + dy][x + dx]);
                        let least = if w < v { w } else { v };
                        let term = (d * d - (v + least)) / (1e-10 + K2 * (v + w));
                        terms[y][x] = if term < MOST { term } else { MOST };
                    }
                }
                for y in 0..TILE {
                    let out = &mut self.buffers.weights[y][dy * SIDE + dx];
                    for x in 0..TILE {
                        let beside =
                            (terms[y + 1][x] + terms[y + 1][x + 2]) + (terms[y][x + 1] + terms[y + 2][x + 1]);
                        let sum = terms[y + 1][x + 1] + beside;
                        let near = 1.0 - SCALE * if sum > 0.0 { sum } else { 0.0 };
                        let near = if near > 0.0 { near } else { 0.0 };
                        let square = near * near;
                        out[x] = square * square;
                    }
                }
            }
        }
    }

    /// Fits the window of a block and predicts the light around it.
    #[inline(always)]
    fn fit<S: Simd>(&mut self, simd: S, x: usize, y: usize) {
        let weights = &self.buffers.weights[y];
        let mut sums = [F32x8::splat(simd, 0.0); VECTORS];
        for dy in 0..SIDE {
            for dx in 0..SIDE {
                let weight = weights[dy * SIDE + dx][x];
                if weight > 0.0 {
                    let weight = F32x8::splat(simd, weight);
                    let more = &self.buffers.sums[(y + dy) * REGION + x + dx];
                    for k in 0..VECTORS {
                        sums[k] = sums[k] + weight * F32x8::load(simd, &more[k]);
                    }
                }
            }
        }
        let mut blocks = [Block32::default(); VECTORS];
        for k in 0..VECTORS {
            sums[k].store(&mut blocks[k]);
        }
        if blocks[0].0[0] > LEAST {
            let coefficients = solve(&packed(&blocks));
            self.predict(simd, x, y, &coefficients);
        }
    }

    #[inline(always)]
    fn predict<S: Simd>(&mut self, simd: S, x: usize, y: usize, coefficients: &Coefficients) {
        let own = coefficients.map(|own| own.map(|v| F32x8::splat(simd, v)));
        let at = x * BLOCK;
        let tent = F32x8::load(simd, &Block32(TENT));
        for row in 0..LANES {
            // The block of a pixel, from the middle of the window on.
            let beside = |k: usize| (k + BLOCK - BESIDE) / BLOCK + REACH - 1;
            let weights = &self.buffers.weights[y][beside(row) * SIDE..];
            let near: [f32; LANES] = std::array::from_fn(|k| weights[beside(k)][x] * TENT[row]);
            let weight = tent * F32x8::load(simd, &Block32(near));
            let mut light = own.map(|own| own[0]);
            let line = y * BLOCK + row;
            for (k, plane) in self.buffers.terms.iter().enumerate().skip(1) {
                let term = F32x8::load(simd, &block(&plane[line], at));
                for c in 0..3 {
                    light[c] = light[c] + own[c][k] * term;
                }
            }
            let [colors @ .., total] = &mut self.out.planes;
            for (plane, light) in colors.iter_mut().zip(light) {
                add(simd, &mut plane[line], at, weight * light);
            }
            add(simd, &mut total[line], at, weight);
        }
    }
}

/// The sums as rows of the fit.
#[inline(always)]
fn packed(sums: &Sums) -> Row {
    let at = |i: usize, j: usize| match i < UPPER {
        true => sums[2 * i + j / LANES].0[j % LANES],
        false => sums[UPPER + i].0[j - LANES],
    };
    let mut row: Row = [0.0; ROW];
    row[VARIANCE] = at(0, TERMS + 3);
    let mut k = 0;
    for i in 0..TERMS {
        for j in i..TERMS {
            row[k] = at(i, j);
            k += 1;
        }
        for c in 0..3 {
            row[PAIRS + 3 * i + c] = at(i, TERMS + c);
        }
    }
    row
}

/// The fitted light of each pixel, with `None` for pixels without noise. Returns `None` if it was cancelled.
pub(super) fn fitted(
    light: &Light,
    blocks: &Blocks,
    guides: &[[f32; GUIDES]],
    options: &DenoiseOptions<'_>,
) -> Option<Vec<Option<Rgb>>> {
    let (columns, rows) = (blocks.columns.div_ceil(TILE), blocks.rows.div_ceil(TILE));
    let is_noisy = |left: usize, top: usize| {
        let rows = top.saturating_sub(1)..(top + TILE + 1).min(blocks.rows);
        let near = left.saturating_sub(1)..(left + TILE + 1).min(blocks.columns);
        rows.into_iter()
            .any(|row| blocks.variance[row * blocks.columns..][near.clone()].iter().any(|v| *v > 0.0))
    };
    let predicted: Vec<Option<Predicted>> =
        strips::with(columns * rows, options.threads, Buffers::new, |buffers, tile| {
            let (left, top) = (tile % columns * TILE, tile / columns * TILE);
            (!options.is_cancelled() && is_noisy(left, top)).then(|| {
                let mut out = Predicted { planes: std::array::from_fn(|_| vec![[0.0; PIXELS]; PIXELS]) };
                dispatch(options.set, Tile { light, blocks, guides, left, top, buffers, out: &mut out });
                out
            })
        });
    options.go_on()?;
    const SIZE: usize = TILE * BLOCK;
    Some(strips::map(light.width * light.height, options.threads, |i| {
        let (x, y) = (i % light.width, i / light.width);
        if blocks.variance[y / BLOCK * blocks.columns + x / BLOCK] <= 0.0 {
            return None;
        }
        let (mut sums, mut weight) = ([0.0f32; 3], 0.0f32);
        let reached = |at: usize, count: usize| {
            at.saturating_sub(BESIDE) / SIZE..=((at + BESIDE) / SIZE).min(count - 1)
        };
        for row in reached(y, rows) {
            for column in reached(x, columns) {
                let Some(Predicted { planes }) = &predicted[row * columns + column] else { continue };
                let (x, y) = (x + BESIDE - column * SIZE, y + BESIDE - row * SIZE);
                for c in 0..3 {
                    sums[c] += planes[c][y][x];
                }
                weight += planes[3][y][x];
            }
        }
        (weight > 1e-6).then(|| sums.map(|v| v / weight))
    }))
}
