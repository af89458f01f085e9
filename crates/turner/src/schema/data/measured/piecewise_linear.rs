//! Functions on the unit square from grids of values, with linear interpolation between them; as densities they can be
//! sampled and inverted. Several of them, one for each direction of view, are mixed with weights.

/// Slices of a [`PiecewiseLinear2D`] and their weights, whose sum is 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slices {
    at: [(usize, f64); 4],
    count: usize,
}

impl Slices {
    /// From a slice of rows and columns of slices: rows and columns with their weights.
    pub(super) fn new(rows: [(usize, f64); 2], columns: [(usize, f64); 2], per_row: usize) -> Slices {
        let mut slices = Slices { at: [(0, 0.0); 4], count: 0 };
        for (row, a) in rows {
            for (column, b) in columns {
                if a * b > 0.0 {
                    slices.at[slices.count] = (row * per_row + column, a * b);
                    slices.count += 1;
                }
            }
        }
        slices
    }

    /// The first slice alone, of a function that does not depend on the view.
    pub(super) const ONLY: Slices = Slices { at: [(0, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)], count: 1 };

    /// Slice `channel` of each group of `channels`.
    pub(super) fn of_channel(mut self, channel: usize, channels: usize) -> Slices {
        for (at, _) in &mut self.at {
            *at = *at * channels + channel;
        }
        self
    }

    #[inline]
    fn mix(&self, get: impl Fn(usize) -> f32) -> f64 {
        self.at[..self.count].iter().map(|(slice, weight)| f64::from(get(*slice)) * weight).sum()
    }
}

/// Slices of functions on the unit square: x by column, y by row, the first and the last values on its edges.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PiecewiseLinear2D {
    width: usize,
    height: usize,
    /// Slice by slice, row by row.
    values: Vec<f32>,
    /// For each value, the integral along its row from x = 0. Empty unless the functions are densities.
    conditional: Vec<f32>,
    /// For each row, the integral from y = 0.
    marginal: Vec<f32>,
}

/// Where in (0, 1) a density that rises linearly from `a` to `b` has the integral `d`.
fn solve(a: f64, b: f64, d: f64) -> f64 {
    let root = (a * a + 2.0 * (b - a) * d).max(0.0).sqrt();
    if a + root > 0.0 { (2.0 * d / (a + root)).clamp(0.0, 1.0) } else { 0.0 }
}

/// The integral of a density that rises linearly from `a` to `b`, up to `t`.
fn integral(a: f64, b: f64, t: f64) -> f64 {
    t * (a + 0.5 * (b - a) * t)
}

/// The last of `count` - 1 intervals whose lower end, by `at`, is not above `v`.
fn interval(count: usize, v: f64, at: impl Fn(usize) -> f64) -> usize {
    let (mut low, mut high) = (0, count - 1);
    while high - low > 1 {
        let middle = low.midpoint(high);
        if at(middle) <= v {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

impl PiecewiseLinear2D {
    /// Functions as they are. `values` are whole slices of `width` × `height`, each at least 2.
    pub(super) fn new(width: usize, height: usize, values: Vec<f32>) -> PiecewiseLinear2D {
        PiecewiseLinear2D { width, height, values, conditional: Vec::new(), marginal: Vec::new() }
    }

    /// Densities, each scaled so that its integral is 1. A slice of zeros becomes uniform.
    pub(super) fn densities(width: usize, height: usize, values: Vec<f32>) -> PiecewiseLinear2D {
        let mut made = PiecewiseLinear2D::new(width, height, values);
        let size = width * height;
        let (dx, dy) = (0.5 / (width - 1) as f64, 0.5 / (height - 1) as f64);
        made.conditional = vec![0.0; made.values.len()];
        made.marginal = vec![0.0; made.values.len() / width];
        for (slice, values) in made.values.chunks_exact_mut(size).enumerate() {
            let row_of = |values: &[f32], y: usize, x: usize| f64::from(values[y * width + x]);
            let across = |values: &[f32], y: usize| -> f64 {
                (1..width).map(|x| (row_of(values, y, x - 1) + row_of(values, y, x)) * dx).sum()
            };
            let total: f64 = (1..height).map(|y| (across(values, y - 1) + across(values, y)) * dy).sum();
            if total > 0.0 {
                values.iter_mut().for_each(|v| *v = (f64::from(*v) / total) as f32);
            } else {
                values.fill(1.0);
            }
            let (mut below, mut before) = (0.0, 0.0);
            for y in 0..height {
                let mut sum = 0.0;
                for x in 1..width {
                    sum += (row_of(values, y, x - 1) + row_of(values, y, x)) * dx;
                    made.conditional[slice * size + y * width + x] = sum as f32;
                }
                if y > 0 {
                    below += (before + sum) * dy;
                }
                made.marginal[slice * height + y] = below as f32;
                before = sum;
            }
        }
        made
    }

    /// Number of columns and rows.
    pub(super) fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The values, slice by slice, row by row; densities are scaled.
    pub(super) fn values(&self) -> &[f32] {
        &self.values
    }

    #[inline]
    fn value(&self, slices: &Slices, x: usize, y: usize) -> f64 {
        slices.mix(|s| self.values[(s * self.height + y) * self.width + x])
    }

    #[inline]
    fn along_row(&self, slices: &Slices, x: usize, y: usize) -> f64 {
        slices.mix(|s| self.conditional[(s * self.height + y) * self.width + x])
    }

    #[inline]
    fn below_row(&self, slices: &Slices, y: usize) -> f64 {
        slices.mix(|s| self.marginal[s * self.height + y])
    }

    /// The cell that holds a point of the unit square, and the point within it.
    #[inline]
    fn cell(&self, at: [f64; 2]) -> ([usize; 2], [f64; 2]) {
        let split = |v: f64, n: usize| {
            let v = v.clamp(0.0, 1.0) * (n - 1) as f64;
            let i = (v as usize).min(n - 2);
            (i, v - i as f64)
        };
        let ((x, fx), (y, fy)) = (split(at[0], self.width), split(at[1], self.height));
        ([x, y], [fx, fy])
    }

    /// The function at a point of the unit square.
    #[inline]
    pub(super) fn eval(&self, at: [f64; 2], slices: &Slices) -> f64 {
        let ([x, y], [fx, fy]) = self.cell(at);
        let row = |y| {
            let (a, b) = (self.value(slices, x, y), self.value(slices, x + 1, y));
            a + (b - a) * fx
        };
        let (a, b) = (row(y), row(y + 1));
        a + (b - a) * fy
    }

    /// The values of the left and right edge of a cell at the height `fy` within it.
    #[inline]
    fn edges(&self, [x, y]: [usize; 2], fy: f64, slices: &Slices) -> [f64; 2] {
        [x, x + 1].map(|x| {
            let (a, b) = (self.value(slices, x, y), self.value(slices, x, y + 1));
            a + (b - a) * fy
        })
    }

    /// Densities: the point of the unit square for two uniform numbers, and the density there.
    pub(super) fn sample(&self, u: [f64; 2], slices: &Slices) -> ([f64; 2], f64) {
        let y = interval(self.height, u[1], |y| self.below_row(slices, y));
        let [r0, r1] = [y, y + 1].map(|y| self.along_row(slices, self.width - 1, y));
        let rest = (u[1] - self.below_row(slices, y)) * (self.height - 1) as f64;
        let fy = solve(r0, r1, rest);
        let along = |x| {
            let (a, b) = (self.along_row(slices, x, y), self.along_row(slices, x, y + 1));
            a + (b - a) * fy
        };
        let wanted = u[0] * along(self.width - 1);
        let x = interval(self.width, wanted, along);
        let [c0, c1] = self.edges([x, y], fy, slices);
        let fx = solve(c0, c1, (wanted - along(x)) * (self.width - 1) as f64);
        let at = [(x as f64 + fx) / (self.width - 1) as f64, (y as f64 + fy) / (self.height - 1) as f64];
        (at, c0 + (c1 - c0) * fx)
    }

    /// Densities: the two uniform numbers that [`PiecewiseLinear2D::sample`] maps to a point, and the density there.
    pub(super) fn invert(&self, at: [f64; 2], slices: &Slices) -> ([f64; 2], f64) {
        let ([x, y], [fx, fy]) = self.cell(at);
        let [c0, c1] = self.edges([x, y], fy, slices);
        let along = |x| {
            let (a, b) = (self.along_row(slices, x, y), self.along_row(slices, x, y + 1));
            a + (b - a) * fy
        };
        let whole = along(self.width - 1);
        let before = along(x) + integral(c0, c1, fx) / (self.width - 1) as f64;
        let [r0, r1] = [y, y + 1].map(|y| self.along_row(slices, self.width - 1, y));
        let below = self.below_row(slices, y) + integral(r0, r1, fy) / (self.height - 1) as f64;
        let across = if whole > 0.0 { before / whole } else { fx };
        ([across, below], c0 + (c1 - c0) * fx)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two slices of four columns and three rows.
    fn table() -> PiecewiseLinear2D {
        let one = [1.0, 0.5, 2.0, 0.0, 0.2, 3.0, 1.0, 0.1, 0.0, 0.0, 4.0, 1.0];
        let other = one.map(|v: f32| 1.0 + 2.0 * (2.5 - v) * (2.5 - v));
        PiecewiseLinear2D::densities(4, 3, [one, other].concat())
    }

    fn mixes() -> [Slices; 3] {
        [0.0, 1.0, 0.3].map(|w| Slices::new([(0, 1.0), (0, 0.0)], [(0, 1.0 - w), (1, w)], 2))
    }

    #[test]
    fn densities_have_the_integral_1() {
        for slices in mixes() {
            const N: usize = 600;
            let at = |i: usize| (i as f64 + 0.5) / N as f64;
            let sum: f64 = (0..N * N).map(|i| table().eval([at(i % N), at(i / N)], &slices)).sum();
            let mean = sum / (N * N) as f64;
            assert!((mean - 1.0).abs() < 1e-5, "{mean}");
        }
    }

    #[test]
    fn inversion_undoes_sampling() {
        let table = table();
        for slices in mixes() {
            for i in 0..400 {
                let u = [(f64::from(i % 20) + 0.5) / 20.0, (f64::from(i / 20) + 0.5) / 20.0];
                let (at, density) = table.sample(u, &slices);
                let (back, same) = table.invert(at, &slices);
                assert!((density - same).abs() < 1e-5 * density, "{density} {same}");
                assert!((density - table.eval(at, &slices)).abs() < 1e-9, "{at:?}");
                assert!((u[0] - back[0]).abs() < 2e-6 && (u[1] - back[1]).abs() < 2e-6, "{u:?} {back:?}");
            }
        }
    }

    /// Points of a regular grid of numbers, each counted in the cell where it lands.
    #[test]
    fn samples_have_their_density() {
        const N: usize = 300;
        let table = table();
        for slices in mixes() {
            let mut counts = [0.0f64; 24];
            for i in 0..N * N {
                let u = [i % N, i / N].map(|i| (i as f64 + 0.5) / N as f64);
                let (at, _) = table.sample(u, &slices);
                let cell = [(at[0] * 6.0) as usize, (at[1] * 4.0) as usize];
                counts[cell[1].min(3) * 6 + cell[0].min(5)] += 1.0 / (N * N) as f64;
            }
            for (cell, count) in counts.into_iter().enumerate() {
                let fine = |i: usize| (i as f64 + 0.5) / 40.0;
                let inside = |i: usize| [(cell % 6) as f64 + fine(i % 40), (cell / 6) as f64 + fine(i / 40)];
                let mean = (0..1600)
                    .map(|i| table.eval([inside(i)[0] / 6.0, inside(i)[1] / 4.0], &slices))
                    .sum::<f64>()
                    / 1600.0
                    / 24.0;
                assert!((count - mean).abs() < 1e-3, "{cell}: {count} {mean}");
            }
        }
    }

    #[test]
    fn nothing_becomes_uniform() {
        let table = PiecewiseLinear2D::densities(2, 2, vec![0.0; 4]);
        let (at, density) = table.sample([0.25, 0.75], &Slices::ONLY);
        assert!((at[0] - 0.25).abs() < 1e-12 && (at[1] - 0.75).abs() < 1e-12 && density == 1.0, "{at:?}");
    }
}
