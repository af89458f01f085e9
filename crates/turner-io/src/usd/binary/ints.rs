//! Compressed data: LZ4 blocks, and integers as differences of few bytes.
//!
//! Integers begin with the most frequent difference. Two bits per integer say whether its difference is that one or
//! has 8, 16 or 32 bits (for long integers 16, 32 or 64), and the differences follow.

use super::cursor::{Cursor, ended};
use crate::usd::value::{Broken, Read};
use crate::vdb::lz4;

/// Most elements of one array.
pub(super) const MAX_ELEMENTS: usize = 1 << 26;

/// Reads a length and a compressed block, at most `limit` bytes when decompressed.
pub(super) fn block(cursor: &mut Cursor<'_>, limit: usize) -> Read<Vec<u8>> {
    let size = cursor.count(1)?;
    let mut bytes = Cursor::new(cursor.take(size)?, 0)?;
    let damaged = |_| Broken::new("its LZ4 data are damaged");
    match bytes.u8()? {
        0 => lz4::decompress(bytes.take(size - 1)?, limit).map_err(damaged),
        chunks => {
            let mut out = Vec::new();
            for _ in 0..chunks {
                let size = bytes.u32()? as usize;
                let more = lz4::decompress(bytes.take(size)?, limit - out.len()).map_err(damaged)?;
                out.extend(more);
            }
            Ok(out)
        }
    }
}

/// Reads `count` compressed integers of 32 or 64 bits.
pub(super) fn integers(cursor: &mut Cursor<'_>, count: usize, is_long: bool) -> Read<Vec<i64>> {
    if count == 0 {
        return Ok(Vec::new());
    }
    if count > MAX_ELEMENTS {
        return Err(Broken::new(format!("an array of {count} elements; at most {MAX_ELEMENTS} are read")));
    }
    let size = if is_long { 8 } else { 4 };
    let codes = count.div_ceil(4);
    let bytes = block(cursor, size + codes + size * count)?;
    let mut head = Cursor::new(&bytes, 0)?;
    let usual = if is_long { head.i64()? } else { i64::from(head.u32()? as i32) };
    let codes = head.take(codes)?;
    let mut sum = 0_i64;
    let mut out = Vec::new();
    out.try_reserve_exact(count).map_err(|_| Broken::new("there is not enough memory for an array"))?;
    for i in 0..count {
        let code = codes.get(i / 4).ok_or_else(ended)? >> (2 * (i % 4)) & 3;
        let width = match code {
            0 => 0,
            1 => size / 4,
            2 => size / 2,
            _ => size,
        };
        let step = match head.take(width)? {
            [] => usual,
            [a] => i64::from(*a as i8),
            [a, b] => i64::from(i16::from_le_bytes([*a, *b])),
            [a, b, c, d] => i64::from(i32::from_le_bytes([*a, *b, *c, *d])),
            all => i64::from_le_bytes(all.try_into().map_err(|_| ended())?),
        };
        sum = sum.wrapping_add(step);
        if !is_long {
            sum = i64::from(sum as i32);
        }
        out.push(sum);
    }
    Ok(out)
}
