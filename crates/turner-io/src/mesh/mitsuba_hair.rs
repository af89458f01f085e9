//! Hair of Mitsuba 0.6: polylines without widths, as text or binary.
//!
//! ```text
//! text     a point on each line; an empty line or one that begins with # starts another hair
//! binary   "BINARY_HAIR"   u32 points   f32 x, y, z of each point, little-endian; before the first point of a hair ∞
//! ```

use super::error::{push, reserve};
use super::hair::{damaged, drop_short, parse_word};
use super::{MeshError, Place, ReadMesh};

/// First bytes of a binary file.
const MAGIC: &[u8] = b"BINARY_HAIR";

/// Reads a file of either kind.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<ReadMesh, MeshError> {
    let mut hairs = Hairs { out: ReadMesh::default(), open: 0, name };
    match bytes.strip_prefix(MAGIC) {
        Some(rest) => binary(rest, &mut hairs)?,
        None => text(bytes, &mut hairs)?,
    }
    hairs.end()?;
    let mut out = hairs.out;
    drop_short(&mut out, name);
    Ok(out)
}

/// The hairs so far.
struct Hairs<'a> {
    out: ReadMesh,
    /// Points of the hair that has not ended.
    open: u32,
    name: &'a str,
}

impl Hairs<'_> {
    fn end(&mut self) -> Result<(), MeshError> {
        match std::mem::take(&mut self.open) {
            0 => Ok(()),
            points => push(&mut self.out.mesh.strands, points, self.name),
        }
    }

    fn point(&mut self, p: [f32; 3]) -> Result<(), MeshError> {
        self.open += 1;
        push(&mut self.out.mesh.positions, p, self.name)
    }
}

fn binary(bytes: &[u8], hairs: &mut Hairs<'_>) -> Result<(), MeshError> {
    let word = |at: usize| bytes.get(at..at + 4).and_then(|b| <[u8; 4]>::try_from(b).ok());
    let count = word(0).map_or(0, u32::from_le_bytes) as usize;
    let room = bytes.len().saturating_sub(4) / 12;
    if word(0).is_none() || count > room {
        let problem = format!("{count} points are announced, but the file has room for {room}");
        return Err(damaged(hairs.name, "hair", Place::Byte(MAGIC.len() as u64), problem));
    }
    reserve(&mut hairs.out.mesh.positions, count, hairs.name)?;
    let mut at = 4;
    for i in 0..count {
        let single = |at: usize| word(at).map(f32::from_le_bytes);
        if single(at).is_some_and(f32::is_infinite) {
            hairs.end()?;
            at += 4;
        }
        let [Some(x), Some(y), Some(z)] = [0, 4, 8].map(|k| single(at + k)) else {
            let problem = format!("the file ends after {i} of {count} points");
            return Err(damaged(hairs.name, "hair", Place::Byte((MAGIC.len() + at) as u64), problem));
        };
        hairs.point([x, y, z])?;
        at += 12;
    }
    Ok(())
}

fn text(bytes: &[u8], hairs: &mut Hairs<'_>) -> Result<(), MeshError> {
    for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
        let line = line.trim_ascii();
        if line.is_empty() || line.starts_with(b"#") {
            hairs.end()?;
            continue;
        }
        let mut words = line.split(|b| b.is_ascii_whitespace()).filter(|w| !w.is_empty());
        let mut next = || words.next().and_then(|w| std::str::from_utf8(w).ok()).and_then(parse_word);
        let [Some(x), Some(y), Some(z)] = [next(), next(), next()] else {
            let problem = "expected three numbers: x, y and z".to_owned();
            return Err(damaged(hairs.name, "hair", Place::Line(number as u64 + 1), problem));
        };
        hairs.point([x, y, z].map(|v| v as f32))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_binary_files_have_the_same_hairs() {
        let points =
            [[0.0, 0.0, 0.5], [1.0, 0.0, 0.0], [2.0, 0.25, 0.0], [5.0, 0.0, 0.0], [5.0, 1.0, 0.0_f32]];
        let words = "# two hairs and half of one\n0 0 .5\n1 0 0\n2 .25 0\n\n5 0 0\n5 1 0\n#\n7 7 7\n";
        let text = read(words.as_bytes(), "a").unwrap();
        let mut bytes = [MAGIC, &5_u32.to_le_bytes()].concat();
        for (i, p) in points.iter().enumerate() {
            if i == 0 || i == 3 {
                bytes.extend(f32::INFINITY.to_le_bytes());
            }
            bytes.extend(p.iter().flat_map(|v| v.to_le_bytes()));
        }
        let binary = read(&bytes, "b").unwrap();
        for (read, warnings) in [(text, 1), (binary, 0)] {
            assert_eq!((read.mesh.strands, read.mesh.positions), (vec![3, 2], points.to_vec()));
            assert_eq!(read.warnings.len(), warnings);
        }
        for cut in 0..bytes.len() {
            assert!(read(&bytes[..cut], "b").is_err() || cut == 0, "{cut}");
        }
        assert!(read(b"0 0\n", "a").is_err() && read(b"0 0 x\n", "a").is_err());
    }
}
