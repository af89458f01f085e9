//! Mode ATTRIBUTES (appendix A): vertex attributes as byte-wise differences.
//!
//! The elements are split into blocks of up to 256. Within a block, each byte of the element has its own stream; four
//! bytes form a channel. A stream stores the difference of each value to that of the element before:
//!
//! ```text
//! header | block | block | … | tail: padding, first element's predecessor, channel modes (version 1)
//!          └── per channel: 4 streams, one per byte of the channel
//!               └── groups of 16 values: packed with 0, 1, 2, 4 or 8 bits per value
//! ```
//!
//! Differences are bytes in zigzag code (version 0 of EXT_meshopt_compression). Version 1 of KHR_meshopt_compression
//! adds, per channel, 16-bit differences in zigzag code and 32-bit XOR with a rotation.

use super::{Reader, unzigzag};

const HEADER: u8 = 0xa0;
const BLOCK_BYTES: usize = 8192;
const BLOCK_ELEMENTS: usize = 256;
const GROUP: usize = 16;

/// Fills `out` with elements of `stride` bytes, a multiple of 4 up to 256.
pub(super) fn decode(source: &[u8], stride: usize, out: &mut [u8]) -> Option<()> {
    let (&header, body) = source.split_first()?;
    let version = header & 15;
    if header & 0xf0 != HEADER || version > 1 {
        return None;
    }
    let control_size = if version == 0 { 0 } else { stride / 4 };
    let tail = stride + control_size;
    let padded = tail.max(if version == 0 { 32 } else { 24 });
    // The tail: padding, the element before the first one, and the modes of the channels.
    let (streams, end) = body.split_at_checked(body.len().checked_sub(padded)?)?;
    let (last, channels) = end[padded - tail..].split_at(stride);
    let mut last = last.to_vec();
    let mut reader = Reader { bytes: streams };
    let block = (BLOCK_BYTES / stride / GROUP * GROUP).min(BLOCK_ELEMENTS);
    let mut bytes = vec![0u8; 4 * BLOCK_ELEMENTS];
    for elements in out.chunks_mut(block * stride) {
        let count = elements.len() / stride;
        let control = reader.take(control_size)?;
        for channel in 0..stride / 4 {
            for k in 0..4 {
                let stream = &mut bytes[k * BLOCK_ELEMENTS..][..count];
                match (version, control.get(channel).map_or(0, |c| c >> (2 * k) & 3)) {
                    (0, _) => groups(&mut reader, stream, &[0, 2, 4, 8])?,
                    (_, 0) => groups(&mut reader, stream, &[0, 1, 2, 4])?,
                    (_, 1) => groups(&mut reader, stream, &[1, 2, 4, 8])?,
                    (_, 2) => stream.fill(0),
                    _ => stream.copy_from_slice(reader.take(count)?),
                }
            }
            let at = 4 * channel;
            let how = channels.get(channel).copied().unwrap_or(0);
            let before: &mut [u8] = &mut last[at..at + 4];
            match how & 3 {
                0 => {
                    for k in 0..4 {
                        let mut v = before[k];
                        for i in 0..count {
                            let d = bytes[k * BLOCK_ELEMENTS + i];
                            v = v.wrapping_add(unzigzag(u32::from(d)) as u8);
                            elements[i * stride + at + k] = v;
                        }
                        before[k] = v;
                    }
                }
                1 => {
                    for k in [0, 2] {
                        let mut v = u16::from_le_bytes([before[k], before[k + 1]]);
                        for i in 0..count {
                            let d = [bytes[k * BLOCK_ELEMENTS + i], bytes[(k + 1) * BLOCK_ELEMENTS + i]];
                            v = v.wrapping_add(unzigzag(u32::from(u16::from_le_bytes(d))) as u16);
                            elements[i * stride + at + k..][..2].copy_from_slice(&v.to_le_bytes());
                        }
                        before[k..k + 2].copy_from_slice(&v.to_le_bytes());
                    }
                }
                2 => {
                    let rotation = u32::from(32 - (how >> 4)) & 31;
                    let mut v = u32::from_le_bytes([before[0], before[1], before[2], before[3]]);
                    for i in 0..count {
                        let d = [0, 1, 2, 3].map(|k| bytes[k * BLOCK_ELEMENTS + i]);
                        v ^= u32::from_le_bytes(d).rotate_left(rotation);
                        elements[i * stride + at..][..4].copy_from_slice(&v.to_le_bytes());
                    }
                    before.copy_from_slice(&v.to_le_bytes());
                }
                _ => return None,
            }
        }
    }
    reader.bytes.is_empty().then_some(())
}

/// Decodes one stream. For each group of sixteen values, two header bits select one of `widths`, the bits per value.
/// A value with all bits set is an escape: the actual byte follows after the group.
fn groups(reader: &mut Reader<'_>, out: &mut [u8], widths: &[usize; 4]) -> Option<()> {
    let headers = reader.take(out.len().div_ceil(GROUP).div_ceil(4))?;
    for (g, group) in out.chunks_mut(GROUP).enumerate() {
        let width = widths[usize::from(headers[g / 4] >> (2 * (g % 4)) & 3)];
        match width {
            0 => group.fill(0),
            8 => group.copy_from_slice(reader.take(GROUP)?.get(..group.len())?),
            _ => {
                let packed = reader.take(GROUP * width / 8)?;
                let mask = (1u8 << width) - 1;
                // An incomplete last group still stores sixteen values.
                for i in 0..GROUP {
                    let byte = packed[i * width / 8];
                    let within = i * width % 8;
                    // Single bits start at the least significant bit, pairs and nibbles at the
                    // most significant.
                    let shift = if width == 1 { within } else { 8 - width - within };
                    let value = byte >> shift & mask;
                    let value = if value == mask { reader.byte()? } else { value };
                    if let Some(slot) = group.get_mut(i) {
                        *slot = value;
                    }
                }
            }
        }
    }
    Some(())
}
