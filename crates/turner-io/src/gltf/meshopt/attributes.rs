//! Vertex attributes: blocks of up to 256 elements; within a block each byte of an element has its own stream of
//! differences, in groups of sixteen. Version 0 is that of EXT_meshopt_compression, version 1 that of KHR.

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
    // The tail: padding, the element that the first one differs from, and how to put channels together.
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
                    let turn = u32::from(32 - (how >> 4)) & 31;
                    let mut v = u32::from_le_bytes([before[0], before[1], before[2], before[3]]);
                    for i in 0..count {
                        let d = [0, 1, 2, 3].map(|k| bytes[k * BLOCK_ELEMENTS + i]);
                        v ^= u32::from_le_bytes(d).rotate_left(turn);
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

/// A stream of bytes in groups of sixteen: two bits per group choose among `widths` how many bits a byte has.
/// A value of all ones stands for a whole byte that follows the group.
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
                // A last group that is not full has its sixteen values all the same.
                for i in 0..GROUP {
                    let byte = packed[i * width / 8];
                    let within = i * width % 8;
                    // Single bits begin with the lowest, pairs and quadruples with the highest.
                    let shift = if width == 1 { within } else { 8 - width - within };
                    let value = byte >> shift & mask;
                    let value = if value == mask { reader.byte()? } else { value };
                    if let Some(place) = group.get_mut(i) {
                        *place = value;
                    }
                }
            }
        }
    }
    Some(())
}
