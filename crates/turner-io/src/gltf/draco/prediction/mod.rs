//! Prediction: each entry of an attribute is stored as the difference to what its neighbours, which were stored
//! before it, predict.

mod normals;
mod parallelogram;
mod tex_coords;
mod transforms;

use super::corners::{Corners, next, previous};
use super::order::Order;
use super::reader::Reader;
use super::values::Coding;
use super::{Damage, Read, Room, damaged, rans};
use transforms::{Octahedron, Wrap};

/// What the entries of an attribute are predicted from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Method {
    /// Nothing.
    None,
    /// The entry before.
    Difference,
    /// The parallelogram across an edge.
    Parallelogram,
    /// The mean of up to four parallelograms.
    Parallelograms,
    /// Texture coordinates: the shape of the triangle in space.
    TexCoords,
    /// Normals: the faces around.
    GeometricNormal,
}

/// How an attribute is predicted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scheme {
    method: Method,
    /// Whether entries are octahedral coordinates.
    octahedral: bool,
}

/// The neighbours of the entries of an attribute.
pub(super) struct Neighbours<'a> {
    /// The connectivity of the attribute.
    pub(super) table: &'a Corners,
    /// The order of its entries.
    pub(super) order: &'a Order,
    /// The position of each entry, if the scheme needs them.
    pub(super) positions: Vec<[i32; 3]>,
}

impl Neighbours<'_> {
    /// The entry of a corner.
    #[inline]
    fn entry(&self, corner: u32) -> usize {
        self.order.entry(self.table.vertex(corner)) as usize
    }

    /// The entries of the corners that follow and precede a corner in its face.
    #[inline]
    fn sides(&self, corner: u32) -> [usize; 2] {
        [self.entry(next(corner)), self.entry(previous(corner))]
    }

    /// The position of an entry.
    #[inline]
    fn position(&self, entry: usize) -> [i64; 3] {
        self.positions.get(entry).map_or([0; 3], |p| p.map(i64::from))
    }
}

impl Scheme {
    /// Reads the scheme of an attribute.
    pub(super) fn read(reader: &mut Reader<'_>, coding: Coding) -> Read<Scheme> {
        let octahedral = coding == Coding::Octahedral;
        let method = match reader.byte()? as i8 {
            -2 => return Ok(Scheme { method: Method::None, octahedral }),
            0 => Method::Difference,
            1 => Method::Parallelogram,
            4 => Method::Parallelograms,
            5 => Method::TexCoords,
            6 => Method::GeometricNormal,
            other => return damaged(&format!("has prediction {other}; expected -2, 0, 1, 4, 5 or 6")),
        };
        let (transform, expected) = (reader.byte()?, if octahedral { 3 } else { 1 });
        if transform != expected {
            return damaged(&format!("has differences of type {transform}; expected {expected}"));
        }
        let fits = match method {
            Method::GeometricNormal => octahedral,
            Method::None | Method::Difference => true,
            Method::Parallelogram | Method::Parallelograms | Method::TexCoords => !octahedral,
        };
        if !fits {
            return damaged(&format!("has prediction {method:?} for coding {coding:?}"));
        }
        Ok(Scheme { method, octahedral })
    }

    /// Whether positions predict the attribute.
    pub(super) fn needs_positions(&self) -> bool {
        matches!(self.method, Method::TexCoords | Method::GeometricNormal)
    }

    /// Reads `entries` groups of `width` integers.
    pub(super) fn decode(
        &self,
        entries: usize,
        width: usize,
        neighbours: Option<&Neighbours<'_>>,
        reader: &mut Reader<'_>,
        room: Room<'_>,
    ) -> Read<Vec<i32>> {
        let symbols = read_symbols(entries, width, reader, room)?;
        let mut list = room.list(symbols.len())?;
        // Differences of octahedral coordinates are modulo their range, so they have no sign.
        let is_unsigned = self.octahedral && self.method != Method::None;
        list.extend(symbols.iter().map(|s| match is_unsigned {
            true => *s as i32,
            false => (s >> 1) as i32 ^ -((s & 1) as i32),
        }));
        let mesh = || {
            neighbours.ok_or_else(|| {
                Damage::Stream(format!("has prediction {:?} without edgebreaker", self.method))
            })
        };
        match self.method {
            Method::None => {}
            Method::Difference if self.octahedral => {
                let octahedron = Octahedron::read(reader)?;
                normals::differences(&mut list, octahedron);
            }
            Method::Difference => {
                let wrap = Wrap::read(reader)?;
                each(
                    &mut list,
                    width,
                    |_, done, predicted| before(done, predicted),
                    |p, e| wrap.restore(p, e),
                );
            }
            Method::Parallelogram => {
                let wrap = Wrap::read(reader)?;
                parallelogram::one(&mut list, width, mesh()?, wrap);
            }
            Method::Parallelograms => parallelogram::several(&mut list, width, mesh()?, reader, room)?,
            Method::TexCoords => {
                let mesh = mesh()?;
                if width != 2 {
                    return damaged(&format!("has texture coordinates with {width} components; expected 2"));
                }
                tex_coords::restore(&mut list, mesh, reader, room)?;
            }
            Method::GeometricNormal => normals::from_faces(&mut list, mesh()?, reader)?,
        }
        Ok(list)
    }
}

fn read_symbols(entries: usize, width: usize, reader: &mut Reader<'_>, room: Room<'_>) -> Read<Vec<u32>> {
    if reader.byte()? != 0 {
        return rans::symbols(reader, entries, width, room);
    }
    let size = usize::from(reader.byte()?);
    if !(1..=4).contains(&size) {
        return damaged(&format!("has integers of {size} bytes; expected 1 to 4"));
    }
    let count = entries.saturating_mul(width);
    let bytes = reader.take(count.saturating_mul(size))?;
    let mut list = room.list(count)?;
    let whole = |bytes: &[u8]| bytes.iter().rev().fold(0u32, |v, byte| v << 8 | u32::from(*byte));
    list.extend(bytes.chunks_exact(size).map(whole));
    Ok(list)
}

/// Restores entry after entry: `predict(entry, entries before, predicted)`, then `restore(predicted, difference)`,
/// which turns the difference into the entry.
#[inline]
fn each(
    list: &mut [i32],
    width: usize,
    mut predict: impl FnMut(usize, &[i32], &mut [i32]),
    restore: impl Fn(&[i32], &mut [i32]),
) {
    let mut predicted = [0; 256];
    let Some(predicted) = predicted.get_mut(..width) else { return };
    for i in 0..list.len() / width.max(1) {
        let (done, rest) = list.split_at_mut(i * width);
        let Some(entry) = rest.get_mut(..width) else { return };
        predict(i, done, predicted);
        restore(predicted, entry);
    }
}

/// Predicts the entry before; zero for the first.
#[inline]
fn before(done: &[i32], predicted: &mut [i32]) {
    match done.len().checked_sub(predicted.len()).and_then(|from| done.get(from..)) {
        Some(last) => predicted.copy_from_slice(last),
        None => predicted.fill(0),
    }
}
