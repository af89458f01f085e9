//! The weights of the pixels of windows: non-local means.
//!
//! Two pixels are alike if the patches of 7 x 7 pixels around them differ no more than their noise explains (Buades 2005;
//! Rousselle 2012):
//!
//! ```text
//!   d = mean over the patch of ((p − q)² − (var p + min(var p, var q))) / (ε + k² (var p + var q))
//!   weight = (1 − d / 4)⁴ for 0 <= d < 4, which is nearly exp(−d)
//! ```
//!
//! All pixels of a tile take one offset of the window at a time, so that sums over patches are sliding sums.

use super::light::{Light, luminance};

/// Side of a tile: the pixels whose fits are made together.
pub(super) const TILE: usize = 48;
/// Radius of a window.
pub(super) const RADIUS: usize = 9;
/// Side of a window.
pub(super) const SIDE: usize = 2 * RADIUS + 1;
/// Pixels of a window.
pub(super) const TAPS: usize = SIDE * SIDE;
/// Side of a tile with the windows around it.
pub(super) const REGION: usize = TILE + 2 * RADIUS;

/// Radius of a patch.
const PATCH: usize = 3;
/// Side of a patch.
const PATCH_SIDE: usize = 2 * PATCH + 1;
/// Side of a tile with the patches around it.
const INNER: usize = TILE + 2 * PATCH;
/// The same, filled up to whole vectors.
const WIDE: usize = INNER.next_multiple_of(8);
/// Side of a region with the patches around it.
const OUTER: usize = REGION + 2 * PATCH;
/// Columns of the rows of such a region, filled up likewise.
const COLUMNS: usize = OUTER + WIDE - INNER;

/// k²: how much of a difference that noise may explain is one.
const K2: f32 = 0.3;
/// The largest term of a patch: more than that alone makes the weight 0.
const MOST: f32 = 200.0;

/// A row of a tile.
pub(super) type Line = [f32; TILE];

/// Rows of luminance and variance around a tile, and the weights of its windows.
pub(super) struct Weights {
    luminance: Vec<[f32; COLUMNS]>,
    variance: Vec<[f32; COLUMNS]>,
    /// 1 inside the picture, 0 outside.
    inside: Vec<[f32; REGION]>,
    /// The terms of one row.
    terms: [f32; WIDE],
    /// 1 for pixels with noise.
    noisy: Vec<[f32; REGION]>,
    /// Sums of terms over seven columns.
    along: Vec<Line>,
    /// For each row of the tile and each offset of the window: the weights of the row's pixels.
    pub(super) lines: Vec<Line>,
}

impl Weights {
    pub(super) fn new() -> Weights {
        Weights {
            luminance: vec![[0.0; COLUMNS]; OUTER],
            variance: vec![[0.0; COLUMNS]; OUTER],
            inside: vec![[0.0; REGION]; REGION],
            noisy: vec![[0.0; REGION]; REGION],
            terms: [0.0; WIDE],
            along: vec![[0.0; TILE]; INNER],
            lines: vec![[0.0; TILE]; TILE * TAPS],
        }
    }

    /// The weights of the pixels of row `y` of the tile, for each offset of the window.
    #[inline(always)]
    pub(super) fn of_row(&self, y: usize) -> &[Line] {
        &self.lines[y * TAPS..(y + 1) * TAPS]
    }

    /// 1 for the pixels with noise that the window offset `dx`, `dy` reaches from row `y`; 0 for others.
    #[inline(always)]
    pub(super) fn noisy(&self, y: usize, dx: usize, dy: usize) -> &Line {
        line(&self.noisy[y + dy], dx)
    }

    /// Computes the weights of the tile at (`left`, `top`).
    #[inline(always)]
    pub(super) fn compute(&mut self, light: &Light, left: usize, top: usize) {
        self.load(light, left, top);
        for dy in 0..SIDE {
            for dx in 0..SIDE {
                self.offset(dx, dy);
            }
        }
    }

    #[inline(always)]
    fn load(&mut self, light: &Light, left: usize, top: usize) {
        let (width, height) = (light.width, light.height);
        let place = |at: usize, i: usize, reach: usize, size: usize| {
            (at + i).checked_sub(reach).filter(|v| *v < size)
        };
        for y in 0..OUTER {
            let near_y = (top + y).saturating_sub(RADIUS + PATCH).min(height - 1);
            for x in 0..COLUMNS {
                let near_x = (left + x).saturating_sub(RADIUS + PATCH).min(width - 1);
                let i = near_y * width + near_x;
                self.luminance[y][x] = luminance(&light.values[i]);
                self.variance[y][x] = light.variance[i];
            }
        }
        for y in 0..REGION {
            let row = place(top, y, RADIUS, height);
            for x in 0..REGION {
                let i = row.zip(place(left, x, RADIUS, width)).map(|(y, x)| y * width + x);
                let is_inside = i.is_some_and(|i| light.is_known(i));
                self.inside[y][x] = if is_inside { 1.0 } else { 0.0 };
                let is_noisy = is_inside && i.is_some_and(|i| light.variance[i] > 0.0);
                self.noisy[y][x] = if is_noisy { 1.0 } else { 0.0 };
            }
        }
    }

    /// The weights at one offset of the window.
    #[inline(always)]
    fn offset(&mut self, dx: usize, dy: usize) {
        for y in 0..INNER {
            let own: &[f32; WIDE] = line(&self.luminance[y + RADIUS], RADIUS);
            let own_variance: &[f32; WIDE] = line(&self.variance[y + RADIUS], RADIUS);
            let other: &[f32; WIDE] = line(&self.luminance[y + dy], dx);
            let other_variance: &[f32; WIDE] = line(&self.variance[y + dy], dx);
            for x in 0..WIDE {
                let d = own[x] - other[x];
                let (v, w) = (own_variance[x], other_variance[x]);
                let least = if w < v { w } else { v };
                let term = (d * d - (v + least)) / (1e-10 + K2 * (v + w));
                self.terms[x] = if term < MOST { term } else { MOST };
            }
            let sums = &mut self.along[y];
            for x in 0..TILE {
                let t = &self.terms;
                sums[x] = ((t[x] + t[x + 1]) + (t[x + 2] + t[x + 3])) + ((t[x + 4] + t[x + 5]) + t[x + 6]);
            }
        }
        let mut patch: Line = [0.0; TILE];
        for sums in &self.along[..PATCH_SIDE - 1] {
            for x in 0..TILE {
                patch[x] += sums[x];
            }
        }
        const SCALE: f32 = 0.25 / (PATCH_SIDE * PATCH_SIDE) as f32;
        for y in 0..TILE {
            let (new, old) = (&self.along[y + PATCH_SIDE - 1], &self.along[y]);
            let inside: &Line = line(&self.inside[y + dy], dx);
            let out = &mut self.lines[y * TAPS + dy * SIDE + dx];
            for x in 0..TILE {
                let sum = patch[x] + new[x];
                patch[x] = sum - old[x];
                let far = if sum > 0.0 { sum } else { 0.0 };
                let near = 1.0 - SCALE * far;
                let near = if near > 0.0 { near } else { 0.0 };
                let square = near * near;
                out[x] = square * square * inside[x];
            }
        }
    }
}

/// `N` numbers from `from` on.
#[inline(always)]
fn line<const N: usize>(row: &[f32], from: usize) -> &[f32; N] {
    row[from..].first_chunk().expect("rows are long enough")
}
