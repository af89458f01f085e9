//! NanoVDB files: OpenVDB's tree as one block of bytes, in which nodes point to their children.
//!
//! ```text
//! for each segment
//!   header     magic, version, number of grids, codec                             16 bytes
//!   list       type, class, sizes and name of each grid                           176 bytes each, then the name
//!   grids      as they are, or a length and compressed bytes
//!
//! grid         magic, name, transform, class, type                                672 bytes
//! tree         the distance to the root                                           64 bytes
//! root         number of children, background                                     64 bytes, then 32 for each child
//! upper node   masks of active values and of children, then 32³ of 8 bytes: a value, or the distance to a child
//! lower node   the same with 16³
//! leaf         a mask of active voxels, 8³ values
//! ```
//!
//! A file may also be the grids alone, without segments. Version 32 is read, which NanoVDB writes since 2020; numbers are
//! little-endian. Distances are in bytes from the node that has them. The layout is that of NanoVDB's documentation
//! (Museth 2021, "NanoVDB: A GPU-friendly and portable VDB data structure").

use std::borrow::Cow;
use std::collections::HashSet;

use turner::schema::GridData;

use super::dense::{Frame, Kind};
use super::topology::{LEAF, LOWER, Leaf, Topology, UPPER, bit};
use super::transform::Transform;
use super::{Cursor, Listed, blosc, choose};
use crate::gzip::decompress_zlib;

/// The signature without its last byte: `0` of old files and grids, `1` of grids, `2` of files.
const MAGIC: &[u8; 7] = b"NanoVDB";
const GRID: u8 = b'1';

/// The version that is read, in the upper 11 bits of a number.
const VERSION: u32 = 32;

/// Bytes of parts of a file.
const HEADER: usize = 16;
const LISTED: usize = 176;
const GRID_DATA: usize = 672;
const ROOT: usize = 64;
const ROOT_CHILD: usize = 32;

/// Most uncompressed bytes of a chunk of Blosc.
const BLOSC_CHUNK: usize = 1 << 30;

/// The type of floats, and the class of level sets.
const FLOAT: u32 = 1;
const LEVEL_SET: u32 = 1;

/// Names of value types, by number.
const TYPES: [&str; 27] = [
    "unknown",
    "float",
    "double",
    "int16",
    "int32",
    "int64",
    "vec3f",
    "vec3d",
    "mask",
    "half",
    "uint32",
    "bool",
    "rgba8",
    "fp4",
    "fp8",
    "fp16",
    "fpn",
    "vec4f",
    "vec4d",
    "index",
    "on-index",
    "index mask",
    "on-index mask",
    "point index",
    "vec3u8",
    "vec3u16",
    "uint8",
];

/// Whether the bytes begin with NanoVDB's signature.
pub(super) fn is_nano(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC) && bytes.get(MAGIC.len()).is_some_and(|b| (b'0'..=b'2').contains(b))
}

/// A grid in a file.
struct Entry<'a> {
    listed: Listed,
    class: u32,
    codec: u16,
    /// As stored.
    bytes: &'a [u8],
    /// Bytes when decompressed.
    size: u64,
}

/// Reads the grid `name`; without a name, `density` or the only grid of floats.
///
/// Errors, as text: damaged files, no such grid, grids of other types, grids of more than `budget` bytes.
pub(super) fn decode(bytes: &[u8], name: Option<&str>, budget: u64) -> Result<GridData, String> {
    let entries = list(bytes)?;
    let (listed, entries): (Vec<Listed>, Vec<_>) =
        entries.into_iter().map(|e| (e.listed, (e.class, e.codec, e.bytes, e.size))).unzip();
    let chosen = choose(&listed, name)?;
    let (Some((class, codec, stored, size)), Some(listed)) = (entries.get(chosen), listed.get(chosen)) else {
        return Err("has no grids".into());
    };
    let kind = if *class == LEVEL_SET { Kind::Distances } else { Kind::Densities };
    let of_grid = |problem: String| format!("the grid \"{}\" {problem}", listed.name);
    let grid = unpack(stored, *codec, *size, budget).map_err(of_grid)?;
    let transform = transform(&grid)?;
    let (topology, values) = tree(&grid)?;
    let used = match &grid {
        Cow::Owned(bytes) => bytes.len() as u64,
        Cow::Borrowed(_) => 0,
    };
    let frame = Frame::new(&topology, &transform, kind, budget.saturating_sub(used)).map_err(of_grid)?;
    let mut cells = frame.cells(&topology)?;
    for (leaf, at) in topology.leaves.iter().zip(values) {
        let mut cursor = Cursor::new(&grid, at);
        let bytes = cursor.take(4 * (LEAF * LEAF * LEAF) as usize)?;
        let values = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b));
        frame.leaf(leaf.origin, values, &mut cells);
    }
    frame.grid(cells, &transform)
}

/// The names of all grids.
pub(super) fn names(bytes: &[u8]) -> Result<Vec<String>, String> {
    Ok(list(bytes)?.into_iter().map(|e| e.listed.name).collect())
}

/// The grids of a file.
fn list(bytes: &[u8]) -> Result<Vec<Entry<'_>>, String> {
    let major = |at: usize| Cursor::new(bytes, at).u32().map(|v| v >> 21);
    let alone = bytes.get(MAGIC.len()) == Some(&GRID) || (major(8)? != VERSION && major(16)? == VERSION);
    if alone { grids(bytes) } else { segments(bytes) }
}

fn name_of(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(bytes.get(..end).unwrap_or_default()).into_owned()
}

fn kind_of(kind: u32) -> String {
    TYPES.get(kind as usize).map_or_else(|| format!("type {kind}"), |t| (*t).to_owned())
}

fn checked_version(version: u32) -> Result<(), String> {
    if version >> 21 != VERSION {
        let (major, minor) = (version >> 21, version >> 10 & 0x7ff);
        return Err(format!("has NanoVDB's version {major}.{minor}: expected {VERSION}"));
    }
    Ok(())
}

fn as_size(v: i64) -> Result<u64, String> {
    u64::try_from(v).map_err(|_| format!("has the size {v}: expected fewer bytes"))
}

/// The grids of a file with segments.
fn segments(bytes: &[u8]) -> Result<Vec<Entry<'_>>, String> {
    let mut out = Vec::new();
    let mut cursor = Cursor::new(bytes, 0);
    while cursor.at() < bytes.len() {
        let mut header = Cursor::new(cursor.take(HEADER)?, 0);
        if !is_nano(header.take(MAGIC.len() + 1)?) {
            return Err("a segment does not begin with NanoVDB's signature".into());
        }
        checked_version(header.u32()?)?;
        let [count, codec] = [header.u16()?, header.u16()?];
        let mut listed = Vec::new();
        for _ in 0..count {
            let entry = cursor.take(LISTED)?;
            let mut numbers = Cursor::new(entry, 0);
            let [size, stored] = [as_size(numbers.i64()?)?, as_size(numbers.i64()?)?];
            let mut kind = Cursor::new(entry, 32);
            let [kind, class] = [kind.u32()?, kind.u32()?];
            let name = Cursor::new(entry, 136).u32()? as usize;
            let name = name_of(cursor.take(name)?);
            listed.push((Listed { name, kind: kind_of(kind), is_float: kind == FLOAT }, class, size, stored));
        }
        for (listed, class, size, stored) in listed {
            let bytes = cursor.take(usize::try_from(stored).unwrap_or(usize::MAX))?;
            out.push(Entry { listed, class, codec, bytes, size });
        }
    }
    Ok(out)
}

/// The grids of a file without segments.
fn grids(bytes: &[u8]) -> Result<Vec<Entry<'_>>, String> {
    let mut out = Vec::new();
    let mut rest = bytes;
    while !rest.is_empty() {
        if !is_nano(rest) {
            return Err("a grid does not begin with NanoVDB's signature".into());
        }
        checked_version(Cursor::new(rest, 16).u32()?)?;
        let size = as_size(Cursor::new(rest, 32).i64()?)?;
        let name = name_of(Cursor::new(rest, 40).take(256)?);
        let mut kind = Cursor::new(rest, 632);
        let [class, kind] = [kind.u32()?, kind.u32()?];
        let length = usize::try_from(size).ok().filter(|s| (GRID_DATA..=rest.len()).contains(s));
        let split = length.and_then(|length| rest.split_at_checked(length));
        let Some((bytes, after)) = split else {
            let left = rest.len();
            return Err(format!("the grid \"{name}\" has {size} bytes: expected {GRID_DATA} to {left}"));
        };
        let listed = Listed { name, kind: kind_of(kind), is_float: kind == FLOAT };
        out.push(Entry { listed, class, codec: 0, bytes, size });
        rest = after;
    }
    Ok(out)
}

/// The bytes of a grid, decompressed: `size` of them.
fn unpack(stored: &[u8], codec: u16, size: u64, budget: u64) -> Result<Cow<'_, [u8]>, String> {
    if size > budget {
        return Err(format!("has {size} bytes: expected at most {budget}; crop or resample the grid"));
    }
    let size = usize::try_from(size).map_err(|_| format!("has {size} bytes: expected fewer"))?;
    let mut cursor = Cursor::new(stored, 0);
    let mut chunk = || {
        let length = as_size(cursor.i64()?)?;
        cursor.take(usize::try_from(length).unwrap_or(usize::MAX))
    };
    let bytes = match codec {
        0 => Cow::Borrowed(stored),
        1 => Cow::Owned(decompress_zlib(chunk()?, size.saturating_add(1))?),
        2 => {
            let mut out = Vec::new();
            out.try_reserve_exact(size).map_err(|_| format!("needs {size} bytes of memory"))?;
            while out.len() < size {
                let part = (size - out.len()).min(BLOSC_CHUNK);
                out.extend(blosc::decompress(chunk()?, part)?);
            }
            Cow::Owned(out)
        }
        other => return Err(format!("has the codec {other}: expected none, ZIP or Blosc (0 to 2)")),
    };
    if bytes.len() != size {
        return Err(format!("has {} bytes: expected {size}", bytes.len()));
    }
    Ok(bytes)
}

/// The transform from indices to space: a matrix of doubles that is multiplied by column vectors, and a translation.
fn transform(grid: &[u8]) -> Result<Transform, String> {
    let numbers = |at: usize| -> Result<[f64; 3], String> {
        let mut cursor = Cursor::new(grid, at);
        Ok([cursor.f64()?, cursor.f64()?, cursor.f64()?])
    };
    Transform::from_matrix([numbers(384)?, numbers(408)?, numbers(432)?], numbers(528)?)
}

/// Where the parts of a node above the leaves are.
struct Layout {
    /// Voxels along the side of the node and of a child.
    side: i64,
    child_side: i64,
    /// Bytes from the start to the table, and of the whole node.
    table: usize,
    bytes: usize,
}

const LAYOUTS: [Layout; 2] = [
    Layout { side: UPPER, child_side: LOWER, table: 8256, bytes: 270_400 },
    Layout { side: LOWER, child_side: LEAF, table: 1088, bytes: 33_856 },
];

/// Bytes of a leaf, up to its mask, and up to its values.
const LEAF_BYTES: usize = 2144;
const LEAF_MASK: usize = 16;
const LEAF_VALUES: usize = 96;

/// The node at a distance from another one.
fn follow(at: usize, distance: i64) -> Result<usize, String> {
    let found = i64::try_from(at).ok().and_then(|at| at.checked_add(distance));
    let found = found.and_then(|v| usize::try_from(v).ok());
    found.ok_or_else(|| format!("a node at byte {at} points {distance} bytes away, out of the file"))
}

/// Reads the tree: its topology, and where the values of each leaf begin.
fn tree(grid: &[u8]) -> Result<(Topology, Vec<usize>), String> {
    let root = follow(GRID_DATA, Cursor::new(grid, GRID_DATA + 24).i64()?)?;
    let mut cursor = Cursor::new(grid, root);
    cursor.take(24)?;
    let (children, background) = (cursor.u32()?, cursor.f32()?);
    let mut topology = Topology { background, tiles: Vec::new(), leaves: Vec::new() };
    let mut cursor = Cursor::new(grid, follow(root, ROOT as i64)?);
    // Regions that overlap would be filled once for each.
    let mut seen = HashSet::new();
    let mut nodes = Vec::new();
    for _ in 0..children {
        let mut child = Cursor::new(cursor.take(ROOT_CHILD)?, 0);
        let key = child.i64()?;
        // 21 bits for each axis: coordinates divided by 4096, as unsigned numbers.
        let along = |shift: u32| i64::from((((key >> shift) & 0x1f_ffff) * UPPER) as i32);
        let origin = [along(42), along(21), along(0)];
        if !seen.insert(origin) {
            return Err(format!("the root has several children at {origin:?}"));
        }
        match child.i64()? {
            0 => {
                let (active, value) = (child.u32()? != 0, child.f32()?);
                topology.tile(origin, UPPER, value, active);
            }
            distance => nodes.push((follow(root, distance)?, origin)),
        }
    }
    for layout in &LAYOUTS {
        nodes = level(grid, &nodes, layout, &mut topology)?;
    }
    let mut values = Vec::new();
    within(grid, nodes.len(), LEAF_BYTES)?;
    for (at, origin) in nodes {
        let node = Cursor::new(grid, at).take(LEAF_BYTES)?;
        let mask = node.get(LEAF_MASK..LEAF_MASK + 64).and_then(|m| m.try_into().ok());
        let mask = mask.ok_or_else(|| "the file ends in a mask".to_owned())?;
        topology.leaves.push(Leaf { origin, mask });
        values.push(at + LEAF_VALUES);
    }
    Ok((topology, values))
}

/// Checks that so many nodes of a size fit into the file: if nodes share their bytes, a small file is a huge tree.
fn within(grid: &[u8], count: usize, bytes: usize) -> Result<(), String> {
    if count > grid.len() / bytes {
        return Err(format!("has {count} nodes of {bytes} bytes in {} bytes", grid.len()));
    }
    Ok(())
}

/// Reads the tiles of all nodes of one level of the tree. Returns their child nodes: the offset of each in the file, and
/// the coordinates of its first voxel.
fn level(
    grid: &[u8],
    nodes: &[(usize, [i64; 3])],
    layout: &Layout,
    topology: &mut Topology,
) -> Result<Vec<(usize, [i64; 3])>, String> {
    within(grid, nodes.len(), layout.bytes)?;
    let along = layout.side / layout.child_side;
    let count = (along * along * along) as usize;
    let mut out = Vec::new();
    for (at, origin) in nodes {
        let mut cursor = Cursor::new(grid, *at);
        let node = Cursor::new(grid, *at).take(layout.bytes)?;
        cursor.take(32)?;
        let (active, children) = (cursor.take(count / 8)?, cursor.take(count / 8)?);
        let (entries, _) = node.get(layout.table..).unwrap_or_default().as_chunks::<8>();
        for (i, entry) in entries.iter().enumerate().take(count) {
            let n = i as i64;
            let steps = [n / (along * along), n / along % along, n % along];
            let origin: [i64; 3] = std::array::from_fn(|a| origin[a] + layout.child_side * steps[a]);
            if bit(children, i) {
                out.push((follow(*at, i64::from_le_bytes(*entry))?, origin));
            } else {
                let [a, b, c, d, ..] = *entry;
                topology.tile(origin, layout.child_side, f32::from_le_bytes([a, b, c, d]), bit(active, i));
            }
        }
    }
    Ok(out)
}
