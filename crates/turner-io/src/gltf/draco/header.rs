//! The header and the metadata of a Draco stream.

use super::reader::Reader;
use super::{Read, damaged};

/// Set in the flags if metadata follow.
const HAS_METADATA: u16 = 0x8000;

/// How the connectivity is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    /// Indices in order.
    Sequential,
    /// Symbols of a spiral over the faces.
    Edgebreaker,
}

/// Reads the header and skips the metadata.
pub(super) fn read(reader: &mut Reader<'_>) -> Read<Method> {
    if reader.take(5)? != b"DRACO" {
        return damaged("does not begin with DRACO");
    }
    let (major, minor) = (reader.byte()?, reader.byte()?);
    if (major, minor) != (2, 2) {
        return damaged(&format!("has version {major}.{minor}; expected 2.2"));
    }
    match reader.byte()? {
        1 => {}
        0 => return damaged("holds a point cloud; expected a mesh"),
        other => return damaged(&format!("holds geometry of type {other}; expected 1, a mesh")),
    }
    let method = match reader.byte()? {
        0 => Method::Sequential,
        1 => Method::Edgebreaker,
        other => return damaged(&format!("has method {other}; expected 0 or 1")),
    };
    if reader.u16()? & HAS_METADATA != 0 {
        skip_metadata(reader)?;
    }
    Ok(method)
}

/// Metadata are a tree of named entries for each attribute, then one for the file.
fn skip_metadata(reader: &mut Reader<'_>) -> Read<()> {
    for _ in 0..reader.varint()? {
        reader.varint()?;
        skip_tree(reader)?;
    }
    skip_tree(reader)
}

fn skip_tree(reader: &mut Reader<'_>) -> Read<()> {
    // Nodes that are announced and not yet read; all but the root have a name.
    let (mut pending, mut named) = (1u64, false);
    while pending > 0 {
        pending -= 1;
        if named {
            skip_name(reader)?;
        }
        named = true;
        for _ in 0..reader.varint()? {
            skip_name(reader)?;
            let size = reader.varint()?;
            reader.take(size as usize)?;
        }
        pending += u64::from(reader.varint()?);
        if pending > reader.left() as u64 {
            return damaged(&format!("has {pending} groups of metadata in {} bytes", reader.left()));
        }
    }
    Ok(())
}

fn skip_name(reader: &mut Reader<'_>) -> Read<()> {
    let size = reader.byte()?;
    reader.take(usize::from(size))?;
    Ok(())
}
