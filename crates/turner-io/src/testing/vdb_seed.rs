//! Small OpenVDB files.

use std::collections::BTreeMap;

use exr::prelude::f16;

/// How a file is written.
pub(crate) struct Vdb<'a> {
    pub(crate) version: u32,
    /// 1: Deflate, 2: masks. Together or alone.
    pub(crate) flags: u32,
    pub(crate) half: bool,
    pub(crate) background: f32,
    /// Active voxels and their values.
    pub(crate) voxels: &'a [([i32; 3], f32)],
    /// Active tiles of 8³ voxels; in a node that has voxels.
    pub(crate) tiles: &'a [([i32; 3], f32)],
}

/// The name, tree type, class and transform of a grid.
pub(crate) struct Named<'a> {
    pub(crate) name: &'a str,
    pub(crate) tree: &'a str,
    pub(crate) class: &'a str,
    /// The name of the map and its numbers.
    pub(crate) map: (&'a str, &'a [f64]),
}

/// A cloud of ten voxels and their temperatures, by Deflate and masks.
pub(crate) fn seed() -> Vec<u8> {
    let voxels: Vec<([i32; 3], f32)> =
        (0..10).map(|i| ([i - 4, 2 * i % 7, 1], 0.25 * (1 + i) as f32)).collect();
    let grid = |name| {
        let vdb = Vdb { version: 224, flags: 3, half: false, background: 0.0, voxels: &voxels, tiles: &[] };
        (Named { name, tree: "Tree_float_5_4_3", class: "fog volume", map: UNIFORM }, vdb)
    };
    file(&[grid("density"), grid("temperature")])
}

/// A scale of 0.5 in all directions, and what follows from it.
pub(crate) const UNIFORM: (&str, &[f64]) =
    ("UniformScaleMap", &[0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 2.0, 2.0, 2.0, 4.0, 4.0, 4.0, 1.0, 1.0, 1.0]);

/// A file of grids.
pub(crate) fn file(grids: &[(Named<'_>, Vdb<'_>)]) -> Vec<u8> {
    let Some((_, first)) = grids.first() else { return Vec::new() };
    let mut out = vec![0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0];
    [first.version, 9, 0].iter().for_each(|v| out.extend(v.to_le_bytes()));
    out.push(1);
    if first.version < 222 {
        out.push(first.flags as u8 & 1);
    }
    out.extend([b'0'; 36]);
    metadata(&mut out, &[("creator", "a test")]);
    out.extend((grids.len() as u32).to_le_bytes());
    for (named, vdb) in grids {
        string(&mut out, named.name);
        string(&mut out, &format!("{}{}", named.tree, if vdb.half { "_HalfFloat" } else { "" }));
        string(&mut out, "");
        let offsets = out.len();
        let start = offsets + 24;
        out.extend([0; 24]);
        if vdb.version >= 222 {
            out.extend(vdb.flags.to_le_bytes());
        }
        metadata(&mut out, &[("class", named.class), ("name", named.name)]);
        string(&mut out, named.map.0);
        named.map.1.iter().for_each(|v| out.extend(v.to_le_bytes()));
        vdb.tree(&mut out);
        let end = out.len();
        let numbers = [start, end, end].map(|v| (v as i64).to_le_bytes()).concat();
        out.splice(offsets..start, numbers);
    }
    out
}

fn string(out: &mut Vec<u8>, text: &str) {
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text.as_bytes());
}

fn metadata(out: &mut Vec<u8>, list: &[(&str, &str)]) {
    out.extend((list.len() as u32).to_le_bytes());
    for (name, value) in list {
        string(out, name);
        string(out, "string");
        string(out, value);
    }
}

/// The voxels of a node, by the index of its child.
type Children = BTreeMap<usize, Vec<([i32; 3], f32)>>;

/// Voxels by the child that holds them, in a node with `1 << (3 * log)` children of `side` voxels.
fn children(voxels: &[([i32; 3], f32)], log: u32, side: i32) -> Children {
    let mut out = Children::new();
    for (at, value) in voxels {
        let [x, y, z] = at.map(|v| (v.div_euclid(side).rem_euclid(1 << log)) as usize);
        out.entry((x << (2 * log)) | (y << log) | z).or_default().push((*at, *value));
    }
    out
}

fn bits(count: usize, set: impl Iterator<Item = usize>) -> Vec<u8> {
    let mut mask = vec![0u8; count / 8];
    for i in set {
        if let Some(byte) = mask.get_mut(i / 8) {
            *byte |= 1 << (i % 8);
        }
    }
    mask
}

impl Vdb<'_> {
    fn tree(&self, out: &mut Vec<u8>) {
        out.extend(1u32.to_le_bytes());
        out.extend(self.background.to_le_bytes());
        let mut roots: BTreeMap<[i32; 3], Vec<([i32; 3], f32)>> = BTreeMap::new();
        for (at, value) in self.voxels {
            roots.entry(at.map(|v| v.div_euclid(4096) * 4096)).or_default().push((*at, *value));
        }
        out.extend(0u32.to_le_bytes());
        out.extend((roots.len() as u32).to_le_bytes());
        let mut buffers = Vec::new();
        for (origin, voxels) in &roots {
            origin.iter().for_each(|v| out.extend(v.to_le_bytes()));
            let lower = children(voxels, 5, 128);
            self.node(out, 1 << 15, &lower, &Children::new());
            for voxels in lower.values() {
                let leaves = children(voxels, 4, 8);
                let base = voxels[0].0.map(|v| v.div_euclid(128));
                let tiles: Vec<([i32; 3], f32)> = self
                    .tiles
                    .iter()
                    .filter(|(at, _)| at.map(|v| v.div_euclid(128)) == base)
                    .copied()
                    .collect();
                self.node(out, 1 << 12, &leaves, &children(&tiles, 4, 8));
                for voxels in leaves.values() {
                    let active = children(voxels, 3, 1);
                    let mask = bits(512, active.keys().copied());
                    out.extend(&mask);
                    buffers.extend(&mask);
                    if self.version < 222 {
                        buffers.extend([0; 12]);
                        buffers.push(1);
                    }
                    self.values(&mut buffers, 512, &active);
                }
            }
        }
        out.extend(buffers);
    }

    fn node(&self, out: &mut Vec<u8>, count: usize, nodes: &Children, tiles: &Children) {
        out.extend(bits(count, nodes.keys().copied()));
        out.extend(bits(count, tiles.keys().copied()));
        if self.version >= 222 {
            self.values(out, count, tiles);
        } else {
            // Without those of children.
            let value = |i: usize| tiles.get(&i).map_or(self.background, |v| v[0].1);
            self.packed(out, (0..count).filter(|i| !nodes.contains_key(i)).map(value).collect());
        }
    }

    /// Values of which those of `active` differ from the background.
    fn values(&self, out: &mut Vec<u8>, count: usize, active: &Children) {
        let masked = self.flags & 2 != 0;
        if self.version >= 222 {
            out.push(if masked { 0 } else { 6 });
        }
        let stored = |i: usize| active.get(&i).map(|v| v[0].1);
        let values = if masked {
            (0..count).filter_map(stored).collect()
        } else {
            (0..count).map(|i| stored(i).unwrap_or(self.background)).collect()
        };
        self.packed(out, values);
    }

    fn packed(&self, out: &mut Vec<u8>, values: Vec<f32>) {
        let bytes: Vec<u8> = if self.half {
            values.iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()).collect()
        } else {
            values.iter().flat_map(|v| v.to_le_bytes()).collect()
        };
        if self.flags & 1 == 0 || (self.half && values.is_empty()) {
            out.extend(bytes);
            return;
        }
        let packed = miniz_oxide::deflate::compress_to_vec_zlib(&bytes, 6);
        let (length, bytes) = if packed.len() < bytes.len() {
            (packed.len() as i64, packed)
        } else {
            (-(bytes.len() as i64), bytes)
        };
        out.extend(length.to_le_bytes());
        out.extend(bytes);
    }
}
