//! OpenVDB files: sparse grids of clouds, smoke and fire.
//!
//! A file lists grids by name. A grid has metadata, a transform from indices to space, and a tree of values. The
//! trees read here have the usual shape `Tree_float_5_4_3`: the root has nodes of 32³ children, these have nodes of
//! 16³ children, and those have leaves of 8³ voxels. A child of a node is another node or a tile, one value for the
//! whole region. Everywhere else the value is the background.
//!
//! ```text
//! header    magic, version, identifier, metadata, number of grids
//! for each grid
//!   name, tree type, offsets           the next grid follows at the last offset
//!   compression, metadata, transform
//!   topology: root, nodes with tiles, masks of leaves
//!   buffers: the values of each leaf
//! ```
//!
//! Values are compressed by a mask of active voxels, by Deflate, or by Blosc. The file format is described by
//! OpenVDB's documentation and its file versions 220 to 224; numbers are little-endian.
//!
//! The result is dense: the box of the active voxels and tiles, and one cell around it, so that the interpolation
//! between cell centres is that of the whole sparse grid. Negative values and NaN become 0.

mod blosc;
mod cursor;
mod dense;
mod header;
pub(crate) mod lz4;
#[cfg(test)]
mod tests;
mod topology;
mod transform;
mod values;

use turner::schema::GridData;

use cursor::Cursor;
use dense::Frame;
use header::Entry;
use topology::Topology;

/// Whether the bytes begin with OpenVDB's signature.
pub(crate) fn is_vdb(bytes: &[u8]) -> bool {
    bytes.starts_with(&header::MAGIC)
}

/// Reads the grid `name`; without a name, `density` or the only grid of floats. The values may take `budget` bytes.
///
/// Errors, as text: damaged files, no such grid, grids of other types, grids that are too large.
pub(crate) fn decode(bytes: &[u8], name: Option<&str>, budget: u64) -> Result<GridData, String> {
    let file = header::read(bytes)?;
    let entry = choose(&file.grids, name)?;
    let (mut cursor, grid) = file.open(entry)?;
    if grid.class == "level set" {
        return Err(format!(
            "the grid \"{}\" is a level set, distances to a surface: expected densities, class \"fog volume\"",
            entry.name
        ));
    }
    let topology = Topology::read(&mut cursor, &grid.coding)?;
    let frame = Frame::new(&topology, &grid.transform, budget.min(most_bytes(bytes)))
        .map_err(|problem| format!("the grid \"{}\" {problem}", entry.name))?;
    let values = frame.fill(&topology, &mut cursor, &grid.coding)?;
    GridData::new(frame.size(), values, None)?.with_bounds(frame.bounds(&grid.transform))
}

/// Most bytes of values that a file of this size may become. Plumes fill a hundredth of their box or more, and a
/// voxel takes a tenth of a byte or more; a small file may have one large tile.
fn most_bytes(bytes: &[u8]) -> u64 {
    const ANY: u64 = 64 << 20;
    const RATIO: u64 = 1 << 12;
    ANY.max((bytes.len() as u64).saturating_mul(RATIO))
}

fn choose<'a>(grids: &'a [Entry], name: Option<&str>) -> Result<&'a Entry, String> {
    let chosen = match name {
        Some(name) => grids.iter().find(|g| g.name == name),
        None => grids.iter().find(|g| g.name == "density").or_else(|| {
            let mut floats = grids.iter().filter(|g| g.tree == header::FLOAT);
            floats.next().filter(|_| floats.next().is_none())
        }),
    };
    let Some(entry) = chosen else {
        /// Most grids that an error lists.
        const MOST: usize = 16;
        let mut list: Vec<String> = grids.iter().take(MOST).map(Entry::describe).collect();
        if grids.len() > MOST {
            list.push("…".into());
        }
        let list = if list.is_empty() { "none".to_owned() } else { list.join(", ") };
        return Err(match name {
            Some(name) => format!("has no grid \"{name}\"; its grids: {list}"),
            None => {
                format!("has several grids or none of floats: name one, as in `#density`; its grids: {list}")
            }
        });
    };
    if entry.tree != header::FLOAT {
        return Err(format!("the grid {} cannot be a density: expected {}", entry.describe(), header::FLOAT));
    }
    if !entry.parent.is_empty() {
        return Err(format!("the grid \"{}\" is an instance of \"{}\": name that", entry.name, entry.parent));
    }
    Ok(entry)
}
