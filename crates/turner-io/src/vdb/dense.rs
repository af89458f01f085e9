//! A sparse tree as a dense grid.

use turner::math::DVec3;
use turner::schema::GridData;
use turner::schema::data::MAX_VALUES;

use super::Cursor;
use super::header::MASKS;
use super::topology::{LEAF, Tile, Topology, bit};
use super::transform::Transform;
use super::values::Coding;

/// What the values are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Neither negative nor NaN, and finite: others are clamped.
    Densities,
    /// Signed, at the centres of voxels.
    Distances,
}

/// The box of cells that is kept, and how it is stored.
pub(super) struct Frame {
    min: [i64; 3],
    max: [i64; 3],
    size: [u32; 3],
    /// Axes along which the transform mirrors: cells are stored in the opposite order.
    mirrored: [bool; 3],
    kind: Kind,
}

impl Frame {
    /// The box of the active voxels and tiles, and one cell around it.
    ///
    /// Errors: no active voxel; more than `budget` bytes of values.
    pub(super) fn new(
        topology: &Topology,
        transform: &Transform,
        kind: Kind,
        budget: u64,
    ) -> Result<Frame, String> {
        let (mut min, mut max) = ([i64::MAX; 3], [i64::MIN; 3]);
        let mut add = |low: [i64; 3], high: [i64; 3]| {
            min = std::array::from_fn(|a| min[a].min(low[a]));
            max = std::array::from_fn(|a| max[a].max(high[a]));
        };
        for tile in topology.tiles.iter().filter(|t| t.is_active) {
            add(tile.origin, tile.origin.map(|v| v + tile.side - 1));
        }
        for leaf in &topology.leaves {
            for i in (0..512).filter(|i| bit(&leaf.mask, *i)) {
                let voxel = voxel(leaf.origin, i);
                add(voxel, voxel);
            }
        }
        if min[0] > max[0] {
            return Err("has no active voxels".into());
        }
        let (min, max) = (min.map(|v| v - 1), max.map(|v| v + 1));
        // Coordinates have 32 bits, so that sides have at most 33.
        let sides: [u64; 3] = std::array::from_fn(|a| (max[a] - min[a] + 1).unsigned_abs());
        let [x, y, z] = sides;
        let cells = x.checked_mul(y).and_then(|n| n.checked_mul(z)).unwrap_or(u64::MAX);
        let size: [Option<u32>; 3] = sides.map(|s| u32::try_from(s).ok());
        let ([Some(sx), Some(sy), Some(sz)], true) = (size, cells <= MAX_VALUES.min(budget / 4)) else {
            let most = MAX_VALUES.min(budget / 4);
            return Err(format!(
                "has {x} × {y} × {z} cells around its active voxels: expected at most {most} in total; crop or resample \
                 the grid"
            ));
        };
        Ok(Frame { min, max, size: [sx, sy, sz], mirrored: transform.scale.map(|s| s < 0.0), kind })
    }

    /// The grid of all values.
    ///
    /// Errors: distances that are not finite, a box that is empty or not finite.
    pub(super) fn grid(&self, values: Vec<f32>, transform: &Transform) -> Result<GridData, String> {
        let data = match self.kind {
            Kind::Densities => GridData::new(self.size, values, None)?,
            Kind::Distances => GridData::of_distances(self.size, values)?,
        };
        data.with_bounds(self.bounds(transform))
    }

    /// The box in space: that of the cells, or that between the first and the last distances. A voxel's coordinates are
    /// its centre.
    fn bounds(&self, transform: &Transform) -> [DVec3; 2] {
        let half = if self.kind == Kind::Distances { 0.0 } else { 0.5 };
        let corner = |cell: [i64; 3], half: f64| {
            let at = |a: usize| (cell[a] as f64 + half) * transform.scale[a] + transform.translation[a];
            DVec3::new(at(0), at(1), at(2))
        };
        let (a, b) = (corner(self.min, -half), corner(self.max, half));
        [a.min(b), a.max(b)]
    }

    /// The values of all cells, x fastest; reads the buffers of the leaves.
    pub(super) fn fill(
        &self,
        topology: &Topology,
        cursor: &mut Cursor<'_>,
        coding: &Coding,
    ) -> Result<Vec<f32>, String> {
        let mut cells = self.cells(topology)?;
        for leaf in &topology.leaves {
            // The mask is stored a second time.
            cursor.take(64)?;
            if coding.version < MASKS {
                // The origin, and the number of buffers.
                cursor.take(12)?;
                let buffers = cursor.byte()?;
                if buffers != 1 {
                    return Err(format!("a leaf has {buffers} buffers: expected 1"));
                }
            }
            let values = coding.values(cursor, 512, &leaf.mask, topology.background)?;
            self.leaf(leaf.origin, values.into_iter(), &mut cells);
        }
        Ok(cells)
    }

    /// All cells, with the background and the tiles.
    ///
    /// Errors: not enough memory.
    pub(super) fn cells(&self, topology: &Topology) -> Result<Vec<f32>, String> {
        let count = self.size.iter().map(|s| *s as usize).product();
        let mut cells = Vec::new();
        let memory = |_| format!("needs {} bytes of memory for its cells", 4 * count);
        cells.try_reserve_exact(count).map_err(memory)?;
        cells.resize(count, self.kind.value(topology.background));
        for tile in &topology.tiles {
            self.paint(tile, &mut cells);
        }
        Ok(cells)
    }

    /// Fills the part of a leaf that lies in the box.
    pub(super) fn leaf(&self, origin: [i64; 3], values: impl Iterator<Item = f32>, cells: &mut [f32]) {
        for (i, value) in values.enumerate() {
            let at = self.index(voxel(origin, i));
            if let Some(cell) = at.and_then(|at| cells.get_mut(at)) {
                *cell = self.kind.value(value);
            }
        }
    }

    /// Fills the part of a tile that lies in the box.
    fn paint(&self, tile: &Tile, cells: &mut [f32]) {
        let low: [i64; 3] = std::array::from_fn(|a| tile.origin[a].max(self.min[a]));
        let high: [i64; 3] = std::array::from_fn(|a| (tile.origin[a] + tile.side - 1).min(self.max[a]));
        if low.iter().zip(&high).any(|(l, h)| l > h) {
            return;
        }
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                let ends = (self.index([low[0], y, z]), self.index([high[0], y, z]));
                let (Some(a), Some(b)) = ends else { continue };
                let row = cells.get_mut(a.min(b)..=a.max(b)).unwrap_or_default();
                row.fill(self.kind.value(tile.value));
            }
        }
    }

    /// The index of a voxel's cell, if it lies in the box.
    fn index(&self, voxel: [i64; 3]) -> Option<usize> {
        let mut at = [0usize; 3];
        for (a, at) in at.iter_mut().enumerate() {
            let (min, max, v) = (self.min[a], self.max[a], voxel[a]);
            if v < min || v > max {
                return None;
            }
            *at = usize::try_from(if self.mirrored[a] { max - v } else { v - min }).ok()?;
        }
        let [x, y, z] = at;
        Some(x + self.size[0] as usize * (y + self.size[1] as usize * z))
    }
}

/// The voxel of a leaf with an index.
fn voxel([x, y, z]: [i64; 3], i: usize) -> [i64; 3] {
    let i = i as i64;
    [x + i / (LEAF * LEAF), y + i / LEAF % LEAF, z + i % LEAF]
}

impl Kind {
    fn value(self, v: f32) -> f32 {
        match self {
            Kind::Densities if v > 0.0 => v.min(1e30),
            Kind::Densities => 0.0,
            Kind::Distances => v,
        }
    }
}
