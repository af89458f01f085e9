//! The topology of a tree: where its leaves and tiles are.

use std::collections::HashSet;

use super::Cursor;
use super::header::MASKS;
use super::values::Coding;

/// Voxels along the side of a leaf, of a node of leaves, and of a node below the root.
pub(super) const LEAF: i64 = 8;
pub(super) const LOWER: i64 = 128;
pub(super) const UPPER: i64 = 4096;

/// A region of one value.
pub(super) struct Tile {
    pub(super) origin: [i64; 3],
    /// Voxels along its side.
    pub(super) side: i64,
    pub(super) value: f32,
    pub(super) is_active: bool,
}

/// A leaf: 8³ voxels, z fastest, then y, then x.
pub(super) struct Leaf {
    pub(super) origin: [i64; 3],
    /// Its active voxels, one bit each.
    pub(super) mask: [u8; 64],
}

/// Where values are.
pub(super) struct Topology {
    pub(super) background: f32,
    /// Tiles that are active or differ from the background.
    pub(super) tiles: Vec<Tile>,
    /// In the order of their buffers.
    pub(super) leaves: Vec<Leaf>,
}

impl Topology {
    /// Reads the topology of a tree. The cursor is then at the buffers.
    pub(super) fn read(cursor: &mut Cursor<'_>, coding: &Coding) -> Result<Topology, String> {
        let trees = cursor.u32()?;
        if trees != 1 {
            return Err(format!("has {trees} buffers a voxel: expected 1"));
        }
        let background = cursor.f32()?;
        let [tiles, children] = [cursor.u32()?, cursor.u32()?];
        let mut topology = Topology { background, tiles: Vec::new(), leaves: Vec::new() };
        // Regions that overlap would be filled once for each.
        let mut seen = HashSet::new();
        let mut origin = |cursor: &mut Cursor<'_>| {
            let origin = cursor.voxel()?;
            if origin.iter().any(|v| v % UPPER != 0) || !seen.insert(origin) {
                return Err(format!("the root's child at {origin:?} is misplaced or not the only one there"));
            }
            Ok(origin)
        };
        for _ in 0..tiles {
            let origin = origin(cursor)?;
            let (value, is_active) = (cursor.f32()?, cursor.byte()? != 0);
            topology.tile(origin, UPPER, value, is_active);
        }
        // Buffers are sorted by the coordinates of the root's children.
        let mut parts: Vec<([i64; 3], Vec<Leaf>)> = Vec::new();
        for _ in 0..children {
            let origin = origin(cursor)?;
            topology.node(cursor, coding, origin, UPPER)?;
            parts.push((origin, std::mem::take(&mut topology.leaves)));
        }
        parts.sort_by_key(|(origin, _)| *origin);
        topology.leaves = parts.into_iter().flat_map(|(_, leaves)| leaves).collect();
        Ok(topology)
    }

    /// Adds a tile, unless it is like everything around it.
    pub(super) fn tile(&mut self, origin: [i64; 3], side: i64, value: f32, is_active: bool) {
        if is_active || value != self.background {
            self.tiles.push(Tile { origin, side, value, is_active });
        }
    }

    /// Reads a node of side [`UPPER`] or [`LOWER`]: masks of children and of active tiles, the values of tiles, then
    /// the children.
    fn node(
        &mut self,
        cursor: &mut Cursor<'_>,
        coding: &Coding,
        at: [i64; 3],
        side: i64,
    ) -> Result<(), String> {
        let (log, child_side) = if side == UPPER { (5u32, LOWER) } else { (4, LEAF) };
        let count = 1usize << (3 * log);
        let (children, active) = (cursor.take(count / 8)?, cursor.take(count / 8)?);
        let origin = |i: usize| {
            let along = |shift: u32| (i as i64 >> shift) & ((1 << log) - 1);
            let [x, y, z] = at;
            [x + child_side * along(2 * log), y + child_side * along(log), z + child_side * along(0)]
        };
        // Older files store the values of tiles only, newer ones one for each child.
        let old = coding.version < MASKS;
        let is_child = |i: &usize| bit(children, *i);
        let stored = if old { count - (0..count).filter(is_child).count() } else { count };
        let values = coding.values(cursor, stored, active, self.background)?;
        let mut next = values.iter();
        for i in 0..count {
            let value = if old && bit(children, i) { None } else { next.next() };
            if let (Some(value), false) = (value, bit(children, i)) {
                self.tile(origin(i), child_side, *value, bit(active, i));
            }
        }
        for i in (0..count).filter(is_child) {
            if child_side == LEAF {
                let mask = cursor.take(64)?.try_into().map_err(|_| "the file ends in a mask".to_owned())?;
                self.leaves.push(Leaf { origin: origin(i), mask });
            } else {
                self.node(cursor, coding, origin(i), child_side)?;
            }
        }
        Ok(())
    }
}

/// Whether a bit of a mask is set.
pub(super) fn bit(mask: &[u8], i: usize) -> bool {
    mask.get(i / 8).is_some_and(|byte| byte >> (i % 8) & 1 == 1)
}
