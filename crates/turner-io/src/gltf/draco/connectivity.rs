//! The faces of a mesh, and sequential connectivity: lists of indices.

use super::corners::Corners;
use super::header::Method;
use super::reader::Reader;
use super::{Read, Room, damaged, edgebreaker, rans};

/// Most faces: corners are numbered with 32 bits.
const MAX_FACES: u32 = u32::MAX / 3;

/// The faces of a mesh.
#[derive(Debug)]
pub(super) struct Connectivity {
    /// Number of points.
    pub(super) points: usize,
    /// Points of each face.
    pub(super) faces: Vec<[u32; 3]>,
    /// Which faces are neighbours, for edgebreaker.
    pub(super) surface: Option<Surface>,
}

/// Neighbourhood of the faces.
#[derive(Debug)]
pub(super) struct Surface {
    /// That of the positions.
    pub(super) corners: Corners,
    /// Those of the attributes with seams, in the order of the stream.
    pub(super) seamed: Vec<Corners>,
}

/// Reads the connectivity.
pub(super) fn read(method: Method, reader: &mut Reader<'_>, room: Room<'_>) -> Read<Connectivity> {
    match method {
        Method::Sequential => sequential(reader, room),
        Method::Edgebreaker => edgebreaker::read(reader, room),
    }
}

/// A number of faces that has room in the numbering of corners.
pub(super) fn face_count(reader: &mut Reader<'_>) -> Read<usize> {
    match reader.varint()? {
        count if count < MAX_FACES => Ok(count as usize),
        count => damaged(&format!("has {count} faces; expected fewer than {MAX_FACES}")),
    }
}

fn sequential(reader: &mut Reader<'_>, room: Room<'_>) -> Read<Connectivity> {
    let count = face_count(reader)?;
    let points = reader.varint()?;
    let mut faces = room.list(count)?;
    match reader.byte()? {
        0 => {
            // Differences to the index before; the lowest bit is the sign.
            let mut last = 0u32;
            let symbols = rans::symbols(reader, count, 3, room)?;
            faces.extend(symbols.as_chunks().0.iter().map(|three: &[u32; 3]| {
                three.map(|symbol| {
                    let size = symbol >> 1;
                    last = if symbol & 1 == 0 { last.wrapping_add(size) } else { last.wrapping_sub(size) };
                    last
                })
            }));
        }
        1 => {
            for _ in 0..count {
                let mut face = [0; 3];
                for index in &mut face {
                    *index = match points {
                        0..0x100 => u32::from(reader.byte()?),
                        0x100..0x1_0000 => u32::from(reader.u16()?),
                        0x1_0000..0x20_0000 => reader.varint()?,
                        _ => reader.u32()?,
                    };
                }
                faces.push(face);
            }
        }
        other => return damaged(&format!("has indices in scheme {other}; expected 0 or 1")),
    }
    Ok(Connectivity { points: points as usize, faces, surface: None })
}
