//! GLB, the binary container: a header, a JSON chunk and an optional binary chunk (glTF 2.0 §4).

use super::fault::{Fault, Outcome};
use std::ops::Range;

const MAGIC: &[u8] = b"glTF";
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// The byte ranges of a file's chunks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Parts {
    /// The JSON text.
    pub(super) json: Range<usize>,
    /// The binary chunk: the bytes of buffer 0.
    pub(super) bin: Option<Range<usize>>,
    /// Harmless irregularities, for the report.
    pub(super) faults: Vec<&'static str>,
}

/// Finds the chunks of a GLB file, recognised by its first bytes; any other file is JSON.
pub(super) fn split(bytes: &[u8]) -> Outcome<Parts> {
    if !bytes.starts_with(MAGIC) {
        // Some editors write a byte order mark before the text.
        let start = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let faults = if start > 0 { vec!["the JSON text begins with a byte order mark"] } else { Vec::new() };
        return Ok(Parts { json: start..bytes.len(), bin: None, faults });
    }
    let word = |at: usize| {
        let bytes = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(Fault::of_file(format!(
            "the file has {} bytes; expected a header of 12 bytes and a JSON chunk",
            bytes.len()
        )));
    };
    if version != 2 {
        let message = match version {
            1 => "this is glTF 1.0, in its binary container of version 1; expected glTF 2.0".to_owned(),
            _ => format!("is binary glTF version {version}; expected version 2"),
        };
        return Err(Fault::of_file(message).help("convert it to glTF 2.0"));
    }
    let mut faults = Vec::new();
    let length = length as usize;
    if length > bytes.len() {
        return Err(Fault::of_file(format!(
            "the header states {length} bytes, but the file has {}; it is truncated",
            bytes.len()
        )));
    }
    if length < bytes.len() {
        faults.push("the file is longer than its header states");
    }
    let (mut json, mut bin) = (None, None);
    let (mut at, mut number) = (12usize, 0);
    while at < length {
        let (Some(size), Some(kind)) = (word(at), at.checked_add(4).and_then(word)) else {
            faults.push("there are bytes after the last chunk");
            break;
        };
        let begin = at + 8;
        let end = begin.checked_add(size as usize).filter(|end| *end <= bytes.len()).ok_or_else(|| {
            Fault::of_file(format!(
                "the chunk at byte {at} has {size} bytes, but the file ends after {}",
                bytes.len().saturating_sub(begin)
            ))
        })?;
        match kind {
            JSON if json.is_none() => json = Some(begin..end),
            BIN if bin.is_none() => {
                if number != 1 {
                    faults.push("the binary chunk is not the second one");
                }
                bin = Some(begin..end);
            }
            JSON | BIN => faults.push("several chunks of one type: the first one is used"),
            // Unknown chunks must be ignored (§4.4.3).
            _ => {}
        }
        if size % 4 != 0 {
            faults.push("a chunk whose length is not a multiple of 4");
        }
        number += 1;
        // Chunks are aligned to 4 bytes.
        at = end.checked_next_multiple_of(4).unwrap_or(length);
    }
    let json = json.ok_or_else(|| Fault::of_file("has no JSON chunk; expected one after the header"))?;
    Ok(Parts { json, bin, faults })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(length: u32, chunks: &[(u32, u32, &[u8])]) -> Vec<u8> {
        let mut out = [MAGIC, &2u32.to_le_bytes(), &length.to_le_bytes()].concat();
        for (size, kind, data) in chunks {
            out.extend([&size.to_le_bytes()[..], &kind.to_le_bytes(), data].concat());
        }
        out
    }

    #[test]
    fn chunks_are_found() {
        let bytes = glb(12 + 8 + 4 + 8 + 4, &[(4, JSON, b"{}  "), (4, BIN, b"abcd")]);
        let parts = split(&bytes).unwrap();
        assert_eq!((&bytes[parts.json], &bytes[parts.bin.unwrap()]), (&b"{}  "[..], &b"abcd"[..]));
        assert!(parts.faults.is_empty());
        assert_eq!(split(b"\xef\xbb\xbf{}").unwrap().json, 3..5);
    }

    #[test]
    fn lying_lengths_are_refused_or_named() {
        let said = |bytes: &[u8]| split(bytes).map(|p| p.faults).map_err(|f| f.in_file("a.glb").message);
        assert!(said(&glb(1000, &[(4, JSON, b"{}  ")])).unwrap_err().contains("truncated"));
        assert!(said(&glb(24, &[(5000, JSON, b"{}  ")])).unwrap_err().contains("has 5000 bytes"));
        assert!(said(&glb(0, &[])).unwrap_err().contains("no JSON chunk"));
        assert!(said(b"glTF\x01\0\0\0\0\0\0\0").unwrap_err().contains("version 1"));
        assert!(said(b"glTF").unwrap_err().contains("4 bytes"));
        let longer = [glb(24, &[(4, JSON, b"{}  ")]), vec![0; 9]].concat();
        assert_eq!(said(&longer).unwrap().len(), 1);
    }
}
