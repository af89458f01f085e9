//! Decompression of Blosc chunks (format 2).
//!
//! ```text
//! version, version of the compressor, flags, bytes per value        a byte each
//! bytes, bytes per block, compressed bytes                          32 bits each
//! the position of each block                                        32 bits each
//! blocks: one stream, or one for each byte of a value; each with its length, and stored plainly if that is its size
//! ```
//!
//! Flag 1: the bytes of values are sorted by significance. 2: the chunk is stored plainly. 4: sorted by bits. 16: one
//! stream for each block. Bits 5 to 7 are the compressor. OpenVDB writes LZ4.

use super::{Cursor, lz4};
use crate::gzip::decompress_zlib;

const SHUFFLED: u8 = 1;
const PLAIN: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const ONE_STREAM: u8 = 16;

/// Most bytes per value, and fewest values of a block, for a stream of each byte.
const MOST_STREAMS: usize = 16;
const FEWEST_VALUES: usize = 128;

/// Bytes before the positions of blocks.
const HEADER: usize = 16;

/// The decompressed bytes, which must be `size`.
///
/// Errors, as text: damaged data, compressors other than LZ4 and Deflate.
pub(super) fn decompress(chunk: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let mut cursor = Cursor::new(chunk, 0);
    let [version, _, flags, value] = [cursor.byte()?, cursor.byte()?, cursor.byte()?, cursor.byte()?];
    let [bytes, block, packed] = [cursor.u32()?, cursor.u32()?, cursor.u32()?].map(|v| v as usize);
    if version != 2 || bytes != size || packed > chunk.len() || (block == 0 && bytes > 0) {
        return Err(format!(
            "a Blosc chunk of version {version} has {bytes} bytes in blocks of {block}: expected {size} bytes"
        ));
    }
    if flags & PLAIN != 0 {
        return cursor.take(size).map(<[u8]>::to_vec);
    }
    if flags & BITS_SHUFFLED != 0 {
        return Err(
            "a Blosc chunk has shuffled bits: expected shuffled bytes; save the file with OpenVDB".into()
        );
    }
    let value = usize::from(value).max(1);
    let mut out = Vec::new();
    for i in 0..bytes.div_ceil(block.max(1)) {
        let wanted = block.min(bytes - out.len());
        let at = Cursor::new(chunk, HEADER + 4 * i).u32()? as usize;
        let several = flags & ONE_STREAM == 0
            && value <= MOST_STREAMS
            && block / value >= FEWEST_VALUES
            && wanted == block;
        let streams = if several { value } else { 1 };
        let mut cursor = Cursor::new(chunk, at);
        let mut plain = Vec::new();
        for _ in 0..streams {
            let part = wanted / streams;
            let length = cursor.u32()? as usize;
            let packed = cursor.take(length)?;
            let found = if length == part { packed.to_vec() } else { unpack(flags >> 5, packed, part)? };
            if found.len() != part {
                return Err(format!("a Blosc stream has {} bytes: expected {part}", found.len()));
            }
            plain.extend(found);
        }
        if flags & SHUFFLED != 0 && value > 1 {
            plain = unshuffled(&plain, value);
        }
        out.extend(plain);
    }
    Ok(out)
}

fn unpack(compressor: u8, packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
    match compressor {
        1 => lz4::decompress(packed, size),
        3 => decompress_zlib(packed, size + 1),
        other => {
            let name = match other {
                0 => "BloscLZ",
                2 => "Snappy",
                4 => "Zstandard",
                _ => "an unknown method",
            };
            Err(format!("is compressed by Blosc with {name}: expected LZ4 or Deflate"))
        }
    }
}

/// Puts the bytes of each value back together: all first bytes come first, then all second bytes, and so on. Bytes
/// after the last whole value stay where they are.
fn unshuffled(bytes: &[u8], value: usize) -> Vec<u8> {
    let count = bytes.len() / value;
    let (whole, rest) = bytes.split_at_checked(count * value).unwrap_or((bytes, &[]));
    let byte = |i: usize| whole.get(i % value * count + i / value).copied().unwrap_or_default();
    (0..whole.len()).map(byte).chain(rest.iter().copied()).collect()
}
