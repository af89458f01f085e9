//! Decompression of buffer views (`EXT_meshopt_compression`, `KHR_meshopt_compression`).
//!
//! meshoptimizer's codecs exploit that neighbouring elements are similar. A compressed buffer view has a mode:
//!
//! - ATTRIBUTES: vertex attributes, as differences of each byte to the element before, packed with few bits.
//! - TRIANGLES: triangle indices, coded against recently used edges and vertices.
//! - INDICES: other index buffers, as differences to recent indices.
//!
//! Attributes may then pass a filter (OCTAHEDRAL, QUATERNION, EXPONENTIAL, COLOR) that restores quantised vectors,
//! rotations, floats or colours. The bitstreams are those of the extensions' appendices A (modes) and B (filters).
//!
//! All reads are bounds-checked: a damaged stream is rejected or decodes to wrong values of the right length.

mod attributes;
mod filters;
mod indices;

use super::budget::Budget;
use super::fault::{Fault, Outcome};
use super::json::Meshopt;

/// Reads bytes in order.
struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn byte(&mut self) -> Option<u8> {
        let (&first, rest) = self.bytes.split_first()?;
        self.bytes = rest;
        Some(first)
    }

    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(taken)
    }

    /// A variable-length unsigned integer: seven bits per byte, lowest first.
    fn varint(&mut self) -> Option<u32> {
        let mut value = 0u32;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            value |= u32::from(byte & 127) << shift;
            if byte < 128 {
                break;
            }
        }
        Some(value)
    }
}

/// Decodes zigzag: 0, 1, 2, 3, … become 0, −1, 1, −2, …
fn unzigzag(v: u32) -> u32 {
    (v >> 1) ^ (v & 1).wrapping_neg()
}

/// Decodes a buffer view from its compressed bytes. `pointer` is its JSON pointer, for errors.
pub(super) fn decode(how: &Meshopt, source: &[u8], budget: &Budget, pointer: &str) -> Outcome<Vec<u8>> {
    let stride = how.byte_stride.0;
    let fault = |message: String| Err(Fault::at(pointer, message));
    let allowed = match how.mode.as_str() {
        "ATTRIBUTES" => stride.is_multiple_of(4) && (4..=256).contains(&stride),
        "TRIANGLES" | "INDICES" => stride == 2 || stride == 4,
        other => return fault(format!("has mode {other}; expected ATTRIBUTES, TRIANGLES or INDICES")),
    };
    if !allowed {
        return fault(format!("has a byteStride of {stride} for mode {}", how.mode));
    }
    let stride = stride as usize;
    let Ok(count) = usize::try_from(how.count.0) else { return fault("has too many elements".to_owned()) };
    let Some(size) = count.checked_mul(stride) else { return fault("has too many elements".to_owned()) };
    let mut out = budget.list::<u8>(size, pointer)?;
    out.resize(size, 0);
    let done = match how.mode.as_str() {
        "ATTRIBUTES" => attributes::decode(source, stride, &mut out),
        "TRIANGLES" if count % 3 != 0 => {
            return fault(format!("has {count} indices; expected a multiple of 3"));
        }
        "TRIANGLES" => indices::decode_triangles(source, stride, &mut out),
        _ => indices::decode_sequence(source, stride, &mut out),
    };
    if done.is_none() {
        return fault(format!("its {} compressed bytes are damaged", source.len()));
    }
    let filtered = match (how.filter.as_deref().unwrap_or("NONE"), stride) {
        ("NONE", _) => true,
        (_, _) if how.mode != "ATTRIBUTES" => false,
        ("OCTAHEDRAL", 4) => filters::octahedral_8(&mut out),
        ("OCTAHEDRAL", 8) => filters::octahedral_16(&mut out),
        ("QUATERNION", 8) => filters::quaternion(&mut out),
        ("EXPONENTIAL", _) => filters::exponential(&mut out),
        ("COLOR", 4) => filters::color_8(&mut out),
        ("COLOR", 8) => filters::color_16(&mut out),
        _ => false,
    };
    if !filtered {
        let filter = how.filter.as_deref().unwrap_or_default();
        return fault(format!("has filter {filter} with byteStride {stride} and mode {}", how.mode));
    }
    Ok(out)
}

#[cfg(test)]
mod tests;
