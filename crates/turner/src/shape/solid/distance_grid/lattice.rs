//! Values at the vertices of a grid, and their trilinear interpolation.

use std::sync::Arc;

use crate::math::{Bounds, DVec3};
use crate::schema::GridData;

/// Values at the corners of a cell. Bit 0 of the index is x, bit 1 is y and bit 2 is z.
pub(super) type Corners = [f64; 8];

/// A grid of values whose first and last ones lie on the faces of a box.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    data: Arc<GridData>,
    /// The value at the surface; all values below are less it.
    level: f64,
    /// Cells along x, y and z: one less than values.
    pub(super) cells: [usize; 3],
    min: DVec3,
    /// Cells per unit of length along each axis.
    pub(super) scale: DVec3,
}

impl Lattice {
    /// The values of a grid, at least two along each axis, in a box.
    pub(super) fn new(data: Arc<GridData>, level: f64, bounds: &Bounds) -> Lattice {
        let cells = data.size().map(|n| (n as usize).saturating_sub(1).max(1));
        let scale = DVec3::from(cells.map(|n| n as f64)) / bounds.size();
        Lattice { data, level, cells, min: bounds.min, scale }
    }

    /// A point in units of cells from the first value.
    pub(super) fn in_cells(&self, p: DVec3) -> DVec3 {
        (p - self.min) * self.scale
    }

    /// The point at a vertex.
    pub(super) fn vertex(&self, at: [usize; 3]) -> DVec3 {
        self.min + DVec3::from(at.map(|i| i as f64)) / self.scale
    }

    /// The cell that contains a point in units of cells; the nearest one of a point outside.
    pub(super) fn cell(&self, q: DVec3) -> [usize; 3] {
        // Negative numbers become 0.
        std::array::from_fn(|axis| (q[axis] as usize).min(self.cells[axis] - 1))
    }

    /// Bytes of the values.
    pub(super) fn memory(&self) -> usize {
        self.data.memory()
    }

    /// Whether the values along x at y and z are below the level.
    pub(super) fn row(&self, y: usize, z: usize) -> impl DoubleEndedIterator<Item = bool> {
        let [nx, ny, _] = self.data.size().map(|n| n as usize);
        let first = nx * (y + ny * z);
        let values = self.data.density().get(first..first + nx).unwrap_or_default();
        values.iter().map(|v| f64::from(*v) < self.level)
    }

    /// Whether no value on the faces of the box is below the level.
    pub(super) fn border_is_outside(&self) -> bool {
        let [_, ny, nz] = self.cells;
        let mut rows = (0..=nz).flat_map(|z| (0..=ny).map(move |y| (y, z)));
        rows.all(|(y, z)| {
            let mut row = self.row(y, z);
            if y == 0 || y == ny || z == 0 || z == nz {
                return !row.any(|below| below);
            }
            ![row.next(), row.next_back()].contains(&Some(true))
        })
    }

    /// The value at a vertex; beyond the border that of the nearest one.
    fn value_at(&self, at: [i64; 3]) -> f64 {
        let [nx, ny, nz] = self.data.size();
        let clamp = |i: i64, n: u32| i.clamp(0, i64::from(n) - 1) as usize;
        let row = clamp(at[1], ny) + ny as usize * clamp(at[2], nz);
        let i = clamp(at[0], nx) + nx as usize * row;
        self.data.density().get(i).map_or(0.0, |v| f64::from(*v)) - self.level
    }

    /// The values at the corners of a cell.
    pub(super) fn corners(&self, [x, y, z]: [usize; 3]) -> Corners {
        let [nx, ny, _] = self.data.size().map(|n| n as usize);
        let values = self.data.density();
        std::array::from_fn(|i| {
            let row = y + (i >> 1 & 1) + ny * (z + (i >> 2));
            values.get(x + (i & 1) + nx * row).map_or(0.0, |v| f64::from(*v)) - self.level
        })
    }

    /// The corners of the cell that contains a point, and the fractions of the way between them.
    fn around(&self, p: DVec3) -> (Corners, DVec3) {
        let q = self.in_cells(p);
        let cell = self.cell(q);
        (self.corners(cell), (q - DVec3::from(cell.map(|i| i as f64))).clamp(DVec3::ZERO, DVec3::ONE))
    }

    /// The value at a point; outside the box that of the nearest point of the box.
    pub(super) fn value(&self, p: DVec3) -> f64 {
        let (corners, f) = self.around(p);
        interpolate(&corners, f)
    }

    /// The value and its gradient.
    pub(super) fn gradient(&self, p: DVec3) -> (f64, DVec3) {
        let (corners, f) = self.around(p);
        (interpolate(&corners, f), slopes(&corners, f) * self.scale)
    }

    /// A normal that is continuous across cells (Hansson-Söderlund, Evans and Akenine-Möller 2022, "Ray Tracing of Signed
    /// Distance Function Grids", section 4): those of the eight cells around the nearest vertex, each of the slopes of
    /// its cell along the three axes, interpolated between the centres of the cells. `None` if it has no direction.
    pub(super) fn smooth_normal(&self, p: DVec3) -> Option<DVec3> {
        let q = self.in_cells(p);
        let cell = self.cell(q);
        let f = (q - DVec3::from(cell.map(|i| i as f64))).clamp(DVec3::ZERO, DVec3::ONE);
        // For each axis the slopes of the lower and the upper cell, and the weight of the upper one.
        let mut pairs = [[0.0; 2]; 3];
        let mut weights = [0.0; 3];
        for axis in 0..3 {
            let first = cell[axis] as i64;
            let plane = |offset: i64| self.plane(axis, first + offset, cell, f);
            let own = plane(1) - plane(0);
            let is_upper = f[axis] < 0.5;
            let has_other = if is_upper { first > 0 } else { cell[axis] + 1 < self.cells[axis] };
            pairs[axis] = match (has_other, is_upper) {
                (false, _) => [own; 2],
                (true, true) => [plane(0) - plane(-1), own],
                (true, false) => [own, plane(2) - plane(1)],
            };
            weights[axis] = if is_upper { f[axis] + 0.5 } else { f[axis] - 0.5 };
        }
        let normal = |i: usize| {
            let upper = [i & 1, i >> 1 & 1, i >> 2];
            let slopes = DVec3::new(pairs[0][upper[0]], pairs[1][upper[1]], pairs[2][upper[2]]);
            let weight = |axis: usize| if upper[axis] == 1 { weights[axis] } else { 1.0 - weights[axis] };
            (slopes * self.scale).normalize_or_zero() * (weight(0) * weight(1) * weight(2))
        };
        (0..8).map(normal).sum::<DVec3>().try_normalize()
    }

    /// The value on the plane `i` of vertices along an axis, at the place that fractions `f` have in a cell along the other
    /// two.
    fn plane(&self, axis: usize, i: i64, cell: [usize; 3], f: DVec3) -> f64 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let value = |j: i64, k: i64| {
            let mut at = cell.map(|i| i as i64);
            at[axis] = i;
            at[b] += j;
            at[c] += k;
            self.value_at(at)
        };
        mix(mix(value(0, 0), value(1, 0), f[b]), mix(value(0, 1), value(1, 1), f[b]), f[c])
    }
}

/// Exact at both ends.
fn mix(a: f64, b: f64, f: f64) -> f64 {
    a * (1.0 - f) + b * f
}

/// Trilinear interpolation between the corners of a cell, at fractions of its sides. On a face it is that of the
/// neighbour to the last bit.
pub(super) fn interpolate(c: &Corners, f: DVec3) -> f64 {
    let row = |i: usize| mix(c[i], c[i + 1], f.x);
    mix(mix(row(0), row(2), f.y), mix(row(4), row(6), f.y), f.z)
}

/// The gradient of the interpolation, per cell.
fn slopes(c: &Corners, f: DVec3) -> DVec3 {
    // The differences of four edges, `step` long, whose other indices are those of two axes.
    let along = |step: usize, [(i, fi), (j, fj)]: [(usize, f64); 2]| {
        let edge = |at: usize| c[at + step] - c[at];
        mix(mix(edge(0), edge(i), fi), mix(edge(j), edge(i + j), fi), fj)
    };
    let (x, y, z) = ((1, f.x), (2, f.y), (4, f.z));
    DVec3::new(along(1, [y, z]), along(2, [x, z]), along(4, [x, y]))
}

/// The interpolation along a line from `f` in direction `d`, both in fractions of the sides: the coefficients of a cubic
/// (Marmitt et al. 2004, "Fast and Accurate Ray-Voxel Intersection Techniques for Iso-Surface Ray Tracing"), ascending.
pub(super) fn cubic(c: &Corners, f: DVec3, d: DVec3) -> [f64; 4] {
    let (x, y, z) = (c[1] - c[0], c[2] - c[0], c[4] - c[0]);
    let (xy, xz, yz) = (c[3] - c[2] - x, c[5] - c[4] - x, c[6] - c[4] - y);
    let xyz = (c[7] - c[6]) - (c[5] - c[4]) - xy;
    // The mixed terms in powers of the distance.
    let product = |a: f64, da: f64, b: f64, db: f64| [a * b, a * db + da * b, da * db];
    let (fxy, fxz, fyz) =
        (product(f.x, d.x, f.y, d.y), product(f.x, d.x, f.z, d.z), product(f.y, d.y, f.z, d.z));
    let mixed = |k: usize| xy * fxy[k] + xz * fxz[k] + yz * fyz[k];
    [
        c[0] + x * f.x + y * f.y + z * f.z + mixed(0) + xyz * fxy[0] * f.z,
        x * d.x + y * d.y + z * d.z + mixed(1) + xyz * (fxy[1] * f.z + fxy[0] * d.z),
        mixed(2) + xyz * (fxy[2] * f.z + fxy[1] * d.z),
        xyz * fxy[2] * d.z,
    ]
}
