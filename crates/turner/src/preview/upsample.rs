//! Light of the grid at every pixel of a row: the mean over the nearest cells that lie on the pixel's surface.
//!
//! ```text
//!   heads of cells   o . o          pixels between them take the light of the two or four nearest heads, with the
//!                    . . .          weights of bilinear interpolation
//!                    o . o            · max(0, n·n')² · max(0, 1 − relative difference of 1 / length)
//! ```

use turner_bvh::InstructionSet;
use turner_bvh::lanes::{Simd, Work, dispatch};

use crate::color::Spectrum;
use crate::preview::buffers::{Grid, Guides, Light};

/// Lights that are on the grid: direct light, gloss, indirect light.
pub(super) type Lights<'a> = [Option<&'a Light>; 3];

/// What is upsampled.
pub(super) struct Upsampled<'a> {
    pub(super) size: [usize; 2],
    pub(super) guides: &'a Guides,
    pub(super) grid: Grid,
    /// The guides of the heads.
    pub(super) heads: &'a Guides,
    pub(super) lights: Lights<'a>,
}

/// Sums over the cells of one parity of columns: red, green, blue, weight.
type Sums = [Vec<f32>; 4];

/// Scratch memory of one thread: the columns of cells, one after another.
#[derive(Default)]
pub(super) struct UpsampleRow {
    columns: [[Sums; 3]; 4],
}

/// What a cell on another surface weighs: it counts only where there is no other.
const OTHER: f32 = 1e-4;

/// Relative difference of 1 / length at which a cell does not count.
const TOLERANCE: f32 = 0.1;

/// Cells around a pixel among which its surface is sought where the nearest ones show others.
const REACH: usize = 2;

impl Upsampled<'_> {
    /// Prepares a row: [`Upsampled::at`] then tells the light of its pixels.
    pub(super) fn row(&self, set: InstructionSet, y: usize, row: &mut UpsampleRow) {
        dispatch(set, Row { of: self, y, row });
    }

    /// The light of a pixel of the prepared row `y`; `None` if no cell near it has any.
    #[inline]
    pub(super) fn at(&self, row: &UpsampleRow, light: usize, x: usize, y: usize) -> Option<Spectrum> {
        let [r, g, b, w] = &row.columns[x % self.grid.cell][light];
        let cell = x / self.grid.cell;
        if w[cell] > 2.0 * OTHER {
            let k = 1.0 / w[cell];
            return Some(Spectrum::new(r[cell] * k, g[cell] * k, b[cell] * k));
        }
        self.search(light, x, y)
    }

    #[cold]
    fn search(&self, light: usize, x: usize, y: usize) -> Option<Spectrum> {
        let light = self.lights[light]?;
        let Grid { cell, columns, rows } = self.grid;
        let (cx, cy) = (x / cell, y / cell);
        let i = y * self.size[0] + x;
        let (mut sum, mut weights) = (Spectrum::BLACK, 0.0);
        for v in cy.saturating_sub(REACH)..rows.min(cy + REACH + 1) {
            for u in cx.saturating_sub(REACH)..columns.min(cx + REACH + 1) {
                let cell = v * columns + u;
                let (p, q) = (self.guides, self.heads);
                if light.count[cell] > 0.0 && p.key[i] == q.key[cell] {
                    let normals = std::array::from_fn(|a| (p.normal[a][i], q.normal[a][cell]));
                    let w = weight(normals, p.near[i], q.near[cell]);
                    sum += Spectrum::from(std::array::from_fn(|c| light.rgb[c][cell])) * w;
                    weights += w;
                }
            }
        }
        (weights > 0.0).then(|| sum * (1.0 / weights))
    }
}

#[inline(always)]
fn weight(normals: [(f32, f32); 3], near_p: f32, near_q: f32) -> f32 {
    let [x, y, z] = normals.map(|(p, q)| p * q);
    let dot = x + y + z;
    let dot = if dot > 0.0 { dot } else { 0.0 };
    let off = (near_p - near_q).abs() / (TOLERANCE * near_p).max(1e-30);
    dot * dot * if off < 1.0 { 1.0 - off } else { 0.0 } + OTHER
}

struct Row<'a, 'b> {
    of: &'a Upsampled<'a>,
    y: usize,
    row: &'b mut UpsampleRow,
}

impl Work for Row<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Row { of, y, row } = self;
        let Grid { cell, columns, rows } = of.grid;
        for (column, sums) in row.columns[..cell].iter_mut().enumerate() {
            for (sums, _) in sums.iter_mut().zip(&of.lights).filter(|(_, light)| light.is_some()) {
                for sum in sums {
                    sum.clear();
                    sum.resize(columns, 0.0);
                }
            }
            let share = |at: usize| at as f32 / cell as f32;
            let (right, below) = (share(column), share(y % cell));
            for (cy, vertical) in [(y / cell, 1.0 - below), (y / cell + 1, below)] {
                for (dx, horizontal) in [(0, 1.0 - right), (1, right)] {
                    let share = vertical * horizontal;
                    if share > 0.0 && cy < rows && dx < columns {
                        tap(of, [column, y], [dx, cy], share, sums);
                    }
                }
            }
        }
    }
}

/// Adds the cells `dx` to the right in a row of cells to all pixels of a column of their cells.
#[inline(always)]
fn tap(of: &Upsampled<'_>, [column, y]: [usize; 2], [dx, cy]: [usize; 2], share: f32, sums: &mut [Sums; 3]) {
    let (width, Grid { cell, columns, .. }) = (of.size[0], of.grid);
    // Pixels of this column that have such a cell.
    let count = (columns - dx).min((width + cell - 1 - column) / cell);
    let at = |plane: &'_ Vec<f32>, x: usize| plane[y * width + cell * x + column];
    let cells = cy * columns + dx;
    let (p, q) = (of.guides, of.heads);
    let [qx, qy, qz] = &q.normal;
    let (qx, qy, qz) = (&qx[cells..][..count], &qy[cells..][..count], &qz[cells..][..count]);
    let (near, keys) = (&q.near[cells..][..count], &q.key[cells..][..count]);
    let mut weights = [0.0f32; 64];
    for begin in (0..count).step_by(64) {
        let n = (count - begin).min(64);
        for (k, w) in weights[..n].iter_mut().enumerate() {
            let x = begin + k;
            let [nx, ny, nz] = &p.normal;
            let normals = [(at(nx, x), qx[x]), (at(ny, x), qy[x]), (at(nz, x), qz[x])];
            let same = p.key[y * width + cell * x + column] == keys[x];
            *w = if same { share * weight(normals, at(&p.near, x), near[x]) } else { 0.0 };
        }
        for (light, sums) in of.lights.iter().zip(&mut *sums) {
            let Some(light) = light else { continue };
            let (from, to) = (cells + begin, begin);
            let [r, g, b] = &light.rgb;
            let (r, g, b) = (&r[from..][..n], &g[from..][..n], &b[from..][..n]);
            let samples = &light.count[from..][..n];
            let [sr, sg, sb, sw] = sums;
            let (sr, sg, sb, sw) =
                (&mut sr[to..][..n], &mut sg[to..][..n], &mut sb[to..][..n], &mut sw[to..][..n]);
            for k in 0..n {
                let w = if samples[k] > 0.0 { weights[k] } else { 0.0 };
                sr[k] += w * r[k];
                sg[k] += w * g[k];
                sb[k] += w * b[k];
                sw[k] += w;
            }
        }
    }
}
