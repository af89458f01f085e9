//! The header of a file, the list of its grids, and what precedes the tree of each.

use super::Cursor;
use super::transform::{self, Transform};
use super::values::Coding;

/// The first eight bytes of a file.
pub(super) const MAGIC: [u8; 8] = [0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0];

/// The tree type that is read.
pub(super) const FLOAT: &str = "Tree_float_5_4_3";

/// At the end of a tree type: values are stored as halves.
const HALF: &str = "_HalfFloat";

/// In the name of a grid, before the number that tells equal names apart.
const SEPARATOR: char = '\u{1e}';

/// The oldest version that is read (2012).
const OLDEST: u32 = 220;

/// From this version on, each grid has its own compression, and nodes are compressed by masks.
pub(super) const MASKS: u32 = 222;

/// A file whose grids are listed.
pub(super) struct File<'a> {
    bytes: &'a [u8],
    version: u32,
    /// Whether the values of all grids are compressed by Deflate, in versions before [`MASKS`].
    deflated: bool,
    pub(super) grids: Vec<Entry>,
}

/// A grid in the list.
pub(super) struct Entry {
    pub(super) name: String,
    /// The tree type, without the suffix for halves.
    pub(super) tree: String,
    half: bool,
    /// The grid whose tree this one shares, or empty.
    pub(super) parent: String,
    /// Where its data begin.
    at: usize,
}

impl Entry {
    /// The type of its values, for messages.
    pub(super) fn kind(&self) -> &str {
        let kind = self.tree.strip_prefix("Tree_").unwrap_or(&self.tree);
        kind.strip_suffix("_5_4_3").unwrap_or(kind)
    }
}

/// What precedes the tree of a grid.
pub(super) struct Grid {
    /// `fog volume`, `level set`, `staggered`, `unknown` or empty.
    pub(super) class: String,
    pub(super) transform: Transform,
    pub(super) coding: Coding,
}

/// Reads the header and the list of grids.
pub(super) fn read(bytes: &[u8]) -> Result<File<'_>, String> {
    let mut cursor = Cursor::new(bytes, MAGIC.len());
    let version = cursor.u32()?;
    if version < OLDEST {
        return Err(format!("has OpenVDB's file version {version}: expected {OLDEST} or newer"));
    }
    // The version of the library.
    cursor.take(8)?;
    let has_offsets = cursor.byte()? != 0;
    let deflated = version < MASKS && cursor.byte()? != 0;
    // An identifier as text.
    cursor.take(36)?;
    class(&mut cursor)?;
    let count = cursor.u32()?;
    let mut grids = Vec::new();
    for _ in 0..count {
        let full = cursor.string()?;
        let name = full.split(SEPARATOR).next().unwrap_or_default().to_owned();
        let tree = cursor.string()?;
        let half = tree.ends_with(HALF);
        let tree = tree.strip_suffix(HALF).unwrap_or(&tree).to_owned();
        let parent = cursor.string()?.split(SEPARATOR).next().unwrap_or_default().to_owned();
        let [start, _, end] = [cursor.i64()?, cursor.i64()?, cursor.i64()?];
        let (at, end) = if has_offsets {
            (usize::try_from(start), usize::try_from(end))
        } else {
            (Ok(cursor.at()), Ok(0))
        };
        let (Ok(at), Ok(end)) = (at, end) else {
            return Err(format!("the offsets of the grid \"{name}\" are negative"));
        };
        grids.push(Entry { name, tree, half, parent, at });
        if !has_offsets {
            // Only the first grid is found without them.
            break;
        }
        if end < cursor.at() || end > bytes.len() {
            let name = &grids.last().map_or("", |g| g.name.as_str());
            return Err(format!(
                "the grid \"{name}\" ends at byte {end}: expected {} to {}",
                cursor.at(),
                bytes.len()
            ));
        }
        cursor = Cursor::new(bytes, end);
    }
    Ok(File { bytes, version, deflated, grids })
}

impl<'a> File<'a> {
    /// Reads what precedes the tree of a grid. The cursor is then at the tree.
    pub(super) fn open(&self, entry: &Entry) -> Result<(Cursor<'a>, Grid), String> {
        let mut cursor = Cursor::new(self.bytes, entry.at);
        let flags = if self.version >= MASKS { cursor.u32()? } else { u32::from(self.deflated) };
        let class = class(&mut cursor)?;
        let transform = transform::read(&mut cursor)?;
        let coding = Coding::new(self.version, flags, entry.half)?;
        Ok((cursor, Grid { class, transform, coding }))
    }
}

/// Skips metadata and returns the class among them: names, types and values of any size.
fn class(cursor: &mut Cursor<'_>) -> Result<String, String> {
    let count = cursor.u32()?;
    let mut class = String::new();
    for _ in 0..count {
        let (name, kind) = (cursor.string()?, cursor.string()?);
        let length = cursor.u32()? as usize;
        let value = cursor.take(length)?;
        if name == "class" && kind == "string" {
            class = String::from_utf8_lossy(value).into_owned();
        }
    }
    Ok(class)
}
