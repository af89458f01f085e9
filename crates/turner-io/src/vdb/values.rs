//! The values of nodes and leaves.

use std::borrow::Cow;

use exr::prelude::f16;

use super::header::MASKS;
use super::topology::bit;
use super::{Cursor, blosc};
use crate::gzip::decompress_zlib;

/// Compression flags of a grid.
const DEFLATE: u32 = 1;
const ACTIVE_MASK: u32 = 2;
const BLOSC: u32 = 4;

/// How the values of a grid are stored.
pub(super) struct Coding {
    pub(super) version: u32,
    flags: u32,
    half: bool,
}

impl Coding {
    /// Errors: compressions that do not exist.
    pub(super) fn new(version: u32, flags: u32, half: bool) -> Result<Coding, String> {
        if flags & !(DEFLATE | ACTIVE_MASK | BLOSC) != 0 {
            return Err(format!(
                "has the compression flags {flags:#x}: expected those of Deflate, Blosc and masks"
            ));
        }
        Ok(Coding { version, flags, half })
    }

    /// Reads `count` values of which those in the mask `active` are active. A byte tells which of the others are
    /// stored: all, or one or two values for all of them.
    pub(super) fn values(
        &self,
        cursor: &mut Cursor<'_>,
        count: usize,
        active: &[u8],
        background: f32,
    ) -> Result<Vec<f32>, String> {
        let kind = if self.version >= MASKS { cursor.byte()? } else { 6 };
        // 0: all are the background. 1: minus the background. 2: a value. 3: a mask chooses between minus the
        // background and the background; 4: between a value and the background; 5: between two values. 6: all are
        // stored.
        let mut inactive = [if kind == 0 { background } else { -background }, background];
        if matches!(kind, 2 | 4 | 5) {
            inactive[0] = cursor.f32()?;
        }
        if kind == 5 {
            inactive[1] = cursor.f32()?;
        }
        let second = if matches!(kind, 3..=5) { cursor.take(count / 8)? } else { &[] };
        if kind > 6 {
            return Err(format!("values are stored in the manner {kind}: expected 0 to 6"));
        }
        let sparse = self.flags & ACTIVE_MASK != 0 && kind != 6;
        let stored = if sparse { (0..count).filter(|i| bit(active, *i)).count() } else { count };
        let bytes = self.bytes(cursor, stored)?;
        let mut values: Vec<f32> = if self.half {
            bytes.as_chunks::<2>().0.iter().map(|b| f16::from_le_bytes(*b).to_f32()).collect()
        } else {
            bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
        };
        if sparse {
            let mut next = values.into_iter();
            let value = |i| {
                let is_active = bit(active, i);
                let stored = if is_active { next.next() } else { None };
                stored.unwrap_or(inactive[usize::from(bit(second, i))])
            };
            values = (0..count).map(value).collect();
        }
        Ok(values)
    }

    /// The bytes of `count` values, decompressed.
    fn bytes<'a>(&self, cursor: &mut Cursor<'a>, count: usize) -> Result<Cow<'a, [u8]>, String> {
        let size = count * if self.half { 2 } else { 4 };
        if self.half && count == 0 {
            return Ok(Cow::Borrowed(&[]));
        }
        if self.flags & (BLOSC | DEFLATE) == 0 {
            return cursor.take(size).map(Cow::Borrowed);
        }
        // Bytes that did not become fewer are stored as they are, with a negative length.
        let length = cursor.i64()?;
        let stored = usize::try_from(length.unsigned_abs()).unwrap_or(usize::MAX);
        let bytes = cursor.take(stored)?;
        let bytes = if length <= 0 {
            Cow::Borrowed(bytes)
        } else if self.flags & BLOSC != 0 {
            Cow::Owned(blosc::decompress(bytes, size)?)
        } else {
            Cow::Owned(decompress_zlib(bytes, size + 1)?)
        };
        if bytes.len() != size {
            return Err(format!("{count} values have {} bytes: expected {size}", bytes.len()));
        }
        Ok(bytes)
    }
}
