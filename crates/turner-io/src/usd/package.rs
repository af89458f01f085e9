//! Packages (`.usdz`): ZIP archives whose files are stored without compression.
//!
//! The list of files is at the end. Each of its entries leads to a header before the file's bytes.

use std::collections::BTreeMap;
use std::ops::Range;

/// The first bytes of a ZIP archive.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";

/// A package in memory.
#[derive(Debug)]
pub(super) struct Package {
    bytes: Vec<u8>,
    /// The name of the first file, which is the root layer.
    pub(super) first: String,
    files: BTreeMap<String, Range<usize>>,
}

fn u16_at(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..)?.first_chunk().map(|b| usize::from(u16::from_le_bytes(*b)))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..)?.first_chunk().and_then(|b| usize::try_from(u32::from_le_bytes(*b)).ok())
}

/// Whether the name of an entry is a path inside the package.
fn is_inside(name: &str) -> bool {
    !name.is_empty()
        && !name.contains(['\\', ':', '\0', '[', ']'])
        && name.split('/').all(|part| !matches!(part, "" | "." | ".."))
}

impl Package {
    /// Opens a package. The error is the problem in words.
    pub(super) fn open(bytes: Vec<u8>) -> Result<Package, String> {
        const DAMAGED: &str = "the package is damaged: its list of files cannot be read";
        /// Sizes of the record at the end, of entries in the list and of headers, without names.
        const END: usize = 22;
        const ENTRY: usize = 46;
        const HEADER: usize = 30;
        let last = bytes.len().checked_sub(END).ok_or("the package is too short")?;
        // A comment of at most 65,535 bytes may follow the record.
        let mut candidates = (last.saturating_sub(0xFFFF)..=last).rev();
        let end = candidates.find(|at| bytes[*at..].starts_with(b"PK\x05\x06")).ok_or(DAMAGED)?;
        let (count, start) = u16_at(&bytes, end + 10).zip(u32_at(&bytes, end + 16)).ok_or(DAMAGED)?;
        let (mut files, mut first) = (BTreeMap::new(), String::new());
        let mut at = start;
        for _ in 0..count {
            let entry = bytes.get(at..).filter(|b| b.starts_with(b"PK\x01\x02")).ok_or(DAMAGED)?;
            let number = |offset| u16_at(entry, offset).ok_or(DAMAGED);
            let long = |offset| u32_at(entry, offset).ok_or(DAMAGED);
            let (flags, method, size) = (number(8)?, number(10)?, long(24)?);
            let (name, extra, comment) = (number(28)?, number(30)?, number(32)?);
            let text =
                entry.get(ENTRY..ENTRY + name).and_then(|b| std::str::from_utf8(b).ok()).ok_or(DAMAGED)?;
            at += ENTRY + name + extra + comment;
            // A folder.
            if text.ends_with('/') {
                continue;
            }
            if !is_inside(text) {
                return Err(format!("the package contains a file whose path leaves it: {text:?}"));
            }
            if flags & 1 != 0 || method != 0 {
                return Err(format!("{text:?} is compressed or encrypted, which USDZ does not allow"));
            }
            let header = long(42)?;
            let name = u16_at(&bytes, header.saturating_add(26)).ok_or(DAMAGED)?;
            let extra = u16_at(&bytes, header.saturating_add(28)).ok_or(DAMAGED)?;
            let data = header + HEADER + name + extra;
            let end = data.checked_add(size).filter(|end| *end <= bytes.len()).ok_or(DAMAGED)?;
            if first.is_empty() {
                text.clone_into(&mut first);
            }
            files.entry(text.to_owned()).or_insert(data..end);
        }
        if first.is_empty() {
            return Err("the package contains no files".to_owned());
        }
        Ok(Package { bytes, first, files })
    }

    /// The bytes of a file.
    pub(super) fn file(&self, name: &str) -> Option<&[u8]> {
        self.bytes.get(self.files.get(name)?.clone())
    }
}
