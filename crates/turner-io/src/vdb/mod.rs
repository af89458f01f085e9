//! OpenVDB files: sparse grids of clouds, smoke and fire, and level sets.
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
//! between cell centres is that of the whole sparse grid. Negative densities and NaN become 0. Level sets keep their
//! signs: they are signed distances. NanoVDB's files (`nano`) give the same dense grids.

mod blosc;
mod cursor;
mod dense;
mod header;
pub(crate) mod lz4;
mod nano;
#[cfg(test)]
mod nano_tests;
#[cfg(test)]
mod tests;
mod topology;
mod transform;
mod values;

use turner::schema::GridData;

use cursor::Cursor;
use dense::{Frame, Kind};
use topology::Topology;

/// Whether the bytes begin with the signature of OpenVDB or NanoVDB.
pub(crate) fn is_vdb(bytes: &[u8]) -> bool {
    bytes.starts_with(&header::MAGIC) || nano::is_nano(bytes)
}

/// Reads the grid `name`; without a name, `density` or the only grid of floats. The values may take `budget` bytes.
///
/// Errors, as text: damaged files, no such grid, grids of other types, grids that are too large.
pub(crate) fn decode(bytes: &[u8], name: Option<&str>, budget: u64) -> Result<GridData, String> {
    let budget = budget.min(most_bytes(bytes));
    if nano::is_nano(bytes) {
        return nano::decode(bytes, name, budget);
    }
    let file = header::read(bytes)?;
    let listed = |e: &header::Entry| Listed {
        name: e.name.clone(),
        kind: e.kind().to_owned(),
        is_float: e.tree == header::FLOAT,
    };
    let list: Vec<Listed> = file.grids.iter().map(listed).collect();
    let chosen = choose(&list, name)?;
    let entry = file.grids.get(chosen).ok_or("has no grids")?;
    if !entry.parent.is_empty() {
        return Err(format!("the grid \"{}\" is an instance of \"{}\": name that", entry.name, entry.parent));
    }
    let (mut cursor, grid) = file.open(entry)?;
    let topology = Topology::read(&mut cursor, &grid.coding)?;
    let kind = if grid.class == "level set" { Kind::Distances } else { Kind::Densities };
    let frame = Frame::new(&topology, &grid.transform, kind, budget)
        .map_err(|problem| format!("the grid \"{}\" {problem}", entry.name))?;
    let values = frame.fill(&topology, &mut cursor, &grid.coding)?;
    frame.grid(values, &grid.transform)
}

/// Whether a NanoVDB file has the grid `name`.
pub(crate) fn has_grid(bytes: &[u8], name: &str) -> bool {
    nano::is_nano(bytes) && nano::names(bytes).is_ok_and(|names| names.iter().any(|n| n == name))
}

/// Most bytes of values that a file of this size may become. Plumes fill a hundredth of their box or more, and a
/// voxel takes a tenth of a byte or more; a small file may have one large tile.
fn most_bytes(bytes: &[u8]) -> u64 {
    const ANY: u64 = 64 << 20;
    const RATIO: u64 = 1 << 12;
    ANY.max((bytes.len() as u64).saturating_mul(RATIO))
}

/// A grid in the list of a file.
struct Listed {
    name: String,
    /// The type of its values, for messages.
    kind: String,
    is_float: bool,
}

impl Listed {
    fn describe(&self) -> String {
        format!("\"{}\" ({})", self.name, self.kind)
    }
}

/// The index of the grid `name`; without a name, of `density` or of the only grid of floats.
fn choose(grids: &[Listed], name: Option<&str>) -> Result<usize, String> {
    let named = |name: &str| grids.iter().position(|g| g.name == name);
    let chosen = match name {
        Some(name) => named(name),
        None => named("density").or_else(|| {
            let mut floats = (0..grids.len()).filter(|i| grids.get(*i).is_some_and(|g| g.is_float));
            floats.next().filter(|_| floats.next().is_none())
        }),
    };
    let Some((chosen, grid)) = chosen.and_then(|i| Some((i, grids.get(i)?))) else {
        /// Most grids that an error lists.
        const MOST: usize = 16;
        let mut list: Vec<String> = grids.iter().take(MOST).map(Listed::describe).collect();
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
    if !grid.is_float {
        return Err(format!("the grid {} has no densities or distances: expected float", grid.describe()));
    }
    Ok(chosen)
}
