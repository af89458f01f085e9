//! Binary layers (`.usdc`), versions 0.4 to 0.13.
//!
//! ```text
//! header ── table of contents ─┬ TOKENS    texts, compressed
//!                              ├ STRINGS   indices of tokens
//!                              ├ FIELDS    a token (the name) and a value: 8 bytes with its type, and its position or itself
//!                              ├ FIELDSETS lists of fields
//!                              ├ PATHS     a tree, compressed
//!                              └ SPECS     a path, a list of fields and a kind each
//! ```
//!
//! Values are decoded when they are asked for. Counts are compared with the bytes that are there before anything is
//! allocated, and each node of the tree of paths is visited once.

mod cursor;
mod ints;
#[cfg(test)]
mod tests;
mod values;

use std::collections::BTreeMap;

use cursor::{Cursor, ended};
use ints::{MAX_ELEMENTS, block, integers};

use super::value::{Broken, Read, Value};

/// The first bytes of a binary layer.
pub(super) const MAGIC: &[u8] = b"PXR-USDC";

/// Deepest nesting of paths.
const MAX_DEPTH: usize = 512;
/// Most bytes of all paths for each byte of the file, and at least.
const PATH_BYTES: usize = 64;
const MIN_PATH_BYTES: usize = 1 << 20;

/// A binary layer.
pub(super) struct Binary {
    bytes: Vec<u8>,
    version: (u8, u8),
    tokens: Vec<String>,
    strings: Vec<u32>,
    fields: Vec<(u32, u64)>,
    /// Indices of fields; lists end with one that is too large.
    sets: Vec<u32>,
    paths: Vec<String>,
    /// By path: the first field in `sets`.
    pub(super) specs: BTreeMap<String, u32>,
}

impl Binary {
    /// Reads the structure of a layer.
    pub(super) fn read(bytes: Vec<u8>) -> Read<Binary> {
        let version = match bytes.get(..24) {
            Some([b'P', b'X', b'R', b'-', b'U', b'S', b'D', b'C', major, minor, ..]) => (*major, *minor),
            _ => return Err(Broken::new("is not a binary USD file")),
        };
        if version.0 != 0 || version.1 < 4 || version.1 > 13 {
            let (major, minor) = version;
            return Err(Broken::new(format!("is of version {major}.{minor}; versions 0.4 to 0.13 are read")));
        }
        let mut binary = Binary {
            bytes,
            version,
            tokens: Vec::new(),
            strings: Vec::new(),
            fields: Vec::new(),
            sets: Vec::new(),
            paths: Vec::new(),
            specs: BTreeMap::new(),
        };
        let bytes = std::mem::take(&mut binary.bytes);
        binary.structure(&bytes)?;
        binary.bytes = bytes;
        Ok(binary)
    }

    fn structure(&mut self, bytes: &[u8]) -> Read<()> {
        let mut toc = Cursor::new(bytes, Cursor::new(bytes, 16)?.u64()?)?;
        let mut sections = BTreeMap::new();
        for _ in 0..toc.count(32)?.min(64) {
            let name = toc.take(16)?;
            let (start, _size) = (toc.u64()?, toc.u64()?);
            let end = name.iter().position(|b| *b == 0).unwrap_or(16);
            sections.insert(name[..end].to_vec(), start);
        }
        let section = |name: &str| match sections.get(name.as_bytes()) {
            Some(start) => Cursor::new(bytes, *start),
            None => Err(Broken::new(format!("has no section {name}"))),
        };
        self.read_tokens(section("TOKENS")?)?;
        if let Ok(mut cursor) = section("STRINGS") {
            for _ in 0..cursor.count(4)? {
                self.strings.push(cursor.u32()?);
            }
        }
        let mut cursor = section("FIELDS")?;
        let count = few(&mut cursor)?;
        let names = integers(&mut cursor, count, false)?;
        let values = block(&mut cursor, 8 * count)?;
        let mut values = Cursor::new(&values, 0)?;
        for name in names {
            self.fields.push((index(name)?, values.u64()?));
        }
        let mut cursor = section("FIELDSETS")?;
        let count = few(&mut cursor)?;
        // The end of a list is -1.
        self.sets = integers(&mut cursor, count, false)?.into_iter().map(|i| i as u32).collect();
        self.read_paths(section("PATHS")?)?;
        self.read_specs(section("SPECS")?)
    }

    fn read_tokens(&mut self, mut cursor: Cursor<'_>) -> Read<()> {
        let count = cursor.u64()?;
        let size = usize::try_from(cursor.u64()?).unwrap_or(usize::MAX);
        if size > 4 * MAX_ELEMENTS {
            return Err(Broken::new("has more than 256 MiB of names"));
        }
        let text = block(&mut cursor, size)?;
        let mut list = text.split(|b| *b == 0);
        for _ in 0..count {
            let token = list.next().ok_or_else(ended)?;
            self.tokens.push(String::from_utf8_lossy(token).into_owned());
        }
        Ok(())
    }

    fn read_paths(&mut self, mut cursor: Cursor<'_>) -> Read<()> {
        let total = few(&mut cursor)?;
        let count = few(&mut cursor)?;
        // Nearly all paths of a file are in its tree.
        if count > total || total > 4 * count + 16 {
            return Err(Broken::new("has damaged paths"));
        }
        let indices = integers(&mut cursor, count, false)?;
        let elements = integers(&mut cursor, count, false)?;
        let jumps = integers(&mut cursor, count, false)?;
        self.paths = vec![String::new(); total];
        let mut left = self.bytes_of_paths(cursor.at);
        let mut visited = vec![false; count];
        // The next node and its parent's path, with its depth.
        let mut pending: Vec<(usize, String, usize)> = vec![(0, String::new(), 0)];
        while let Some((node, parent, depth)) = pending.pop() {
            let damaged = || Broken::new("has damaged paths");
            if count == 0 {
                break;
            }
            let slot = visited.get_mut(node).ok_or_else(damaged)?;
            if std::mem::replace(slot, true) || depth > MAX_DEPTH {
                return Err(damaged());
            }
            let path =
                if parent.is_empty() { "/".to_owned() } else { self.element(&parent, elements[node])? };
            left = left.checked_sub(path.len()).ok_or_else(|| Broken::new("its paths are too long"))?;
            let jump = jumps[node];
            if jump >= 0 && !parent.is_empty() {
                let step = if jump == 0 { 1 } else { jump as usize };
                pending.push((node.saturating_add(step), parent, depth));
            }
            if jump > 0 || jump == -1 {
                pending.push((node + 1, path.clone(), depth + 1));
            }
            let place = self.paths.get_mut(index(indices[node])? as usize).ok_or_else(damaged)?;
            *place = path;
        }
        Ok(())
    }

    /// Most bytes that the paths of a file may have.
    fn bytes_of_paths(&self, size: usize) -> usize {
        let names: usize = self.tokens.iter().map(String::len).sum();
        (PATH_BYTES * (size + names)).max(MIN_PATH_BYTES)
    }

    /// The path of a child or, for a negative token, of a property.
    fn element(&self, parent: &str, token: i64) -> Read<String> {
        let name = self.token(token.unsigned_abs())?;
        if token < 0 {
            return Ok(super::paths::property(parent, name));
        }
        if name.starts_with(['{', '[']) {
            return Ok(format!("{parent}{name}"));
        }
        Ok(super::paths::child(parent, name))
    }

    fn read_specs(&mut self, mut cursor: Cursor<'_>) -> Read<()> {
        let count = few(&mut cursor)?;
        let paths = integers(&mut cursor, count, false)?;
        let sets = integers(&mut cursor, count, false)?;
        for (path, set) in paths.into_iter().zip(sets) {
            let path = self.paths.get(index(path)? as usize).ok_or_else(ended)?;
            self.specs.insert(path.clone(), index(set)?);
        }
        Ok(())
    }

    fn token(&self, index: u64) -> Read<&str> {
        let token = usize::try_from(index).ok().and_then(|i| self.tokens.get(i));
        token.map(String::as_str).ok_or_else(|| Broken::new("refers to a name that it does not have"))
    }

    fn string(&self, index: u32) -> Read<&str> {
        let token = self.strings.get(index as usize);
        self.token(u64::from(*token.ok_or_else(|| Broken::new("refers to a text that it does not have"))?))
    }

    fn path(&self, index: u32) -> Read<&str> {
        let path = self.paths.get(index as usize);
        path.map(String::as_str).ok_or_else(|| Broken::new("refers to a path that it does not have"))
    }

    /// The stored value of a field of a spec.
    pub(super) fn stored(&self, path: &str, name: &str) -> Option<u64> {
        let start = *self.specs.get(path)? as usize;
        let set = self.sets.get(start..)?.iter();
        let fields = set.map_while(|i| self.fields.get(*i as usize));
        fields
            .filter(|(token, _)| self.tokens.get(*token as usize).is_some_and(|t| t == name))
            .map(|f| f.1)
            .next()
    }

    /// Decodes a value, except the values of time samples.
    pub(super) fn decode(&self, stored: u64) -> Read<Value> {
        values::decode(self, stored, 0)
    }
}

/// A count of compressed elements: bounded, because few bytes can hold many.
fn few(cursor: &mut Cursor<'_>) -> Read<usize> {
    let count = cursor.u64()?;
    match usize::try_from(count) {
        Ok(count) if count <= MAX_ELEMENTS / 4 => Ok(count),
        _ => {
            Err(Broken::new(format!("has a list of {count} elements; at most {} are read", MAX_ELEMENTS / 4)))
        }
    }
}

fn index(value: i64) -> Read<u32> {
    u32::try_from(value).map_err(|_| Broken::new("has a negative index"))
}
