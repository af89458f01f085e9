//! The attributes of an EXR header. Each is stored as: name NUL type NUL size value; an empty name ends the list.

use super::FORMAT;
use crate::image::{ImageError, MetaValue, Metadata};
use std::ops::Range;

/// Offset of the first header, after the magic number and the version.
const START: usize = 8;

/// Attributes that describe the structure of the file and are not reported as metadata.
const STRUCTURE: &[&str] = &["name", "type", "view", "version", "chunkCount", "maxSamplesPerPixel"];

/// An attribute and its byte range.
pub(super) struct Attribute<'a> {
    pub(super) name: &'a [u8],
    kind: &'a [u8],
    pub(super) value: &'a [u8],
    pub(super) range: Range<usize>,
}

/// The attributes of the first header; `None` if it extends beyond the end of the bytes.
pub(super) fn attributes(bytes: &[u8]) -> Option<Vec<Attribute<'_>>> {
    attributes_at(bytes, START).map(|(found, _)| found)
}

/// The attributes of the headers of all parts.
pub(super) fn headers(bytes: &[u8]) -> Option<Vec<Vec<Attribute<'_>>>> {
    all_headers(bytes).map(|(headers, _)| headers)
}

/// Where the offset tables begin: after the headers of all parts.
pub(super) fn end_of_headers(bytes: &[u8]) -> Option<usize> {
    all_headers(bytes).map(|(_, end)| end)
}

fn all_headers(bytes: &[u8]) -> Option<(Vec<Vec<Attribute<'_>>>, usize)> {
    /// In the second byte of the flags: the file has several parts.
    const PARTS: u8 = 1 << 4;
    let (first, mut at) = attributes_at(bytes, START)?;
    let mut headers = vec![first];
    if bytes.get(5)? & PARTS == 0 {
        return Some((headers, at));
    }
    // An empty header ends the list.
    while *bytes.get(at)? != 0 {
        let (header, end) = attributes_at(bytes, at)?;
        headers.push(header);
        at = end;
    }
    Some((headers, at + 1))
}

/// The attributes of the header at a byte, and where it ends.
fn attributes_at(bytes: &[u8], mut at: usize) -> Option<(Vec<Attribute<'_>>, usize)> {
    let mut found = Vec::new();
    while *bytes.get(at)? != 0 {
        let start = at;
        let name = until_nul(bytes, &mut at)?;
        let kind = until_nul(bytes, &mut at)?;
        let size = bytes.get(at..at.checked_add(4)?)?;
        let size = usize::try_from(i32::from_le_bytes([size[0], size[1], size[2], size[3]])).ok()?;
        at += 4;
        let end = at.checked_add(size)?;
        let value = bytes.get(at..end)?;
        at = end;
        found.push(Attribute { name, kind, value, range: start..end });
    }
    Some((found, at + 1))
}

fn until_nul<'a>(bytes: &'a [u8], at: &mut usize) -> Option<&'a [u8]> {
    let rest = bytes.get(*at..)?;
    let length = rest.iter().take(256).position(|&b| b == 0)?;
    *at += length + 1;
    Some(&rest[..length])
}

/// The `string` and `int` attributes of the first part, by name.
pub fn read_metadata(bytes: &[u8], name: &str) -> Result<Metadata, ImageError> {
    let list = attributes(bytes)
        .ok_or_else(|| ImageError::damaged(name, FORMAT, "the header extends beyond the end of the file"))?;
    let mut metadata = Metadata::new();
    for attribute in list {
        let value = match (attribute.kind, attribute.value) {
            (b"string", text) => MetaValue::Text(String::from_utf8_lossy(text).into_owned()),
            (b"int", &[a, b, c, d]) => MetaValue::Integer(i32::from_le_bytes([a, b, c, d])),
            _ => continue,
        };
        let key = String::from_utf8_lossy(attribute.name).into_owned();
        if !STRUCTURE.contains(&key.as_str()) {
            metadata.insert(key, value);
        }
    }
    Ok(metadata)
}

/// Sorts the attributes of the header by name, in place. The exr crate keeps custom attributes in a hash map, whose
/// order differs between runs; sorting makes files reproducible. Sizes and offsets do not change.
pub(super) fn sort_attributes(bytes: &mut [u8]) {
    let Some(mut list) = attributes(bytes) else { return };
    list.sort_by_key(|a| a.name);
    let sorted: Vec<u8> = list.iter().flat_map(|a| bytes[a.range.clone()].iter().copied()).collect();
    bytes[START..START + sorted.len()].copy_from_slice(&sorted);
}
