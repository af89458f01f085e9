//! Density grids of heterogeneous media: OpenVDB and NanoVDB files, and a text header followed by binary values.
//!
//! ```text
//! turner-grid 1
//! size 64 32 64
//! channels density emission
//! bounds 0 0 0 4 2 4
//! data
//! ```
//!
//! Each header line ends with a line feed. `size` is the number of cells along x, y and z. `channels` is `density` or
//! `density emission`. `bounds`, which may be absent, are the least and the largest coordinates of the box that the
//! grid fills. The values follow `data` and its line feed, as little-endian IEEE 754 singles, and nothing
//! follows them: all of the first channel, x fastest, then y, then z; then all of the next channel.

use std::io::{self, Write};

use turner::math::DVec3;
use turner::schema::GridData;
use turner::schema::data::MAX_VALUES;

use crate::assets::printable;
use crate::vdb;

/// Why a grid could not be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{name}: damaged or unsupported grid file: {problem}\n  docs/guides/fog-and-smoke.md describes the formats"
)]
pub struct GridError {
    /// The file name, for messages.
    pub name: String,
    /// What was found and what was expected.
    pub problem: String,
}

/// Largest accepted file, in bytes.
pub const MAX_GRID: u64 = 8 * MAX_VALUES + 4096;

/// Longest accepted header, in bytes.
const MAX_HEADING: usize = 4096;

/// Between the name of an OpenVDB or NanoVDB file and that of its grid.
const GRID_MARK: char = '#';

/// The name of a grid file, and that of the grid in it if there is one: `smoke.vdb#flames`.
pub(crate) fn split_name(uri: &str) -> (&str, Option<&str>) {
    match uri.rsplit_once(GRID_MARK) {
        Some((file, grid)) if [".vdb", ".nvdb"].iter().any(|e| file.to_ascii_lowercase().ends_with(e)) => {
            (file, Some(grid))
        }
        _ => (uri, None),
    }
}

/// Reads a grid of any of the formats. `name` appears in messages; after `.vdb#` or `.nvdb#` it names the grid in the file.
pub fn decode(bytes: &[u8], name: &str) -> Result<GridData, GridError> {
    decode_within(bytes, name, u64::MAX)
}

/// Reads a grid whose values may take `budget` bytes of memory.
pub(crate) fn decode_within(bytes: &[u8], name: &str, budget: u64) -> Result<GridData, GridError> {
    let (_, grid) = split_name(name);
    let data = if vdb::is_vdb(bytes) { vdb::decode(bytes, grid, budget) } else { read(bytes) };
    data.map_err(|problem| GridError { name: printable(name), problem: printable(&problem) })
}

/// Encodes a grid as a file that [`decode`] reads. If present, `emission` has as many values as `density`.
pub fn encode(size: [u32; 3], density: &[f32], emission: Option<&[f32]>) -> Vec<u8> {
    let [x, y, z] = size;
    let channels = if emission.is_some() { "density emission" } else { "density" };
    let mut out = heading([x, y, z], channels, None).into_bytes();
    for values in [Some(density), emission].into_iter().flatten() {
        out.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    }
    out
}

fn heading([x, y, z]: [u32; 3], channels: &str, bounds: Option<[DVec3; 2]>) -> String {
    let bounds = bounds.map(|[a, b]| format!("bounds {} {} {} {} {} {}\n", a.x, a.y, a.z, b.x, b.y, b.z));
    format!("turner-grid 1\nsize {x} {y} {z}\nchannels {channels}\n{}data\n", bounds.unwrap_or_default())
}

/// Writes a grid block by block; [`decode`] reads it back unchanged.
pub fn write(grid: &GridData, out: &mut dyn Write) -> io::Result<()> {
    let channels = if grid.emission().is_some() { "density emission" } else { "density" };
    out.write_all(heading(grid.size(), channels, grid.bounds()).as_bytes())?;
    for values in std::iter::once(grid.density()).chain(grid.emission()) {
        for block in values.chunks(1 << 14) {
            out.write_all(&block.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>())?;
        }
    }
    Ok(())
}

fn read(bytes: &[u8]) -> Result<GridData, String> {
    let mut rest = bytes.get(..MAX_HEADING.min(bytes.len())).unwrap_or_default();
    let mut line = |expected: &str| -> Result<String, String> {
        let end = rest.iter().position(|b| *b == b'\n');
        let text = end.and_then(|end| std::str::from_utf8(rest.get(..end)?).ok());
        let text = text.ok_or_else(|| format!("expected the line `{expected}`, found none"))?.to_owned();
        rest = rest.get(text.len() + 1..).unwrap_or_default();
        Ok(text)
    };
    let mut used = 0;
    let mut next = |expected: &str| -> Result<String, String> {
        let text = line(expected)?;
        used += text.len() + 1;
        Ok(text.trim_end_matches('\r').to_owned())
    };
    let wrong =
        |expected: &str, found: &str| Err(format!("expected `{expected}`, found `{}`", printable(found)));
    let first = next("turner-grid 1")?;
    if first != "turner-grid 1" {
        return wrong("turner-grid 1", &first);
    }
    let line = next("size X Y Z")?;
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let number = |word: &str| word.parse::<u32>().ok();
    let size = match words.as_slice() {
        ["size", x, y, z] => match (number(x), number(y), number(z)) {
            (Some(x), Some(y), Some(z)) => [x, y, z],
            _ => return wrong("size X Y Z", &line),
        },
        _ => return wrong("size X Y Z", &line),
    };
    let line = next("channels density")?;
    let channels = match line.split_ascii_whitespace().collect::<Vec<_>>().as_slice() {
        ["channels", "density"] => 1,
        ["channels", "density", "emission"] => 2,
        _ => return wrong("channels density` or `channels density emission", &line),
    };
    let mut line = next("data")?;
    let mut bounds = None;
    if line.starts_with("bounds ") {
        let numbers: Vec<f64> =
            line.split_ascii_whitespace().skip(1).filter_map(|w| w.parse().ok()).collect();
        let [a, b, c, d, e, f] = numbers[..] else { return wrong("bounds X Y Z X Y Z", &line) };
        bounds = Some([DVec3::new(a, b, c), DVec3::new(d, e, f)]);
        line = next("data")?;
    }
    if line != "data" {
        return wrong("data", &line);
    }
    let count = size.iter().try_fold(1u64, |n, s| n.checked_mul(u64::from(*s)));
    let Some(count) = count.filter(|n| (1..=MAX_VALUES).contains(n)) else {
        let [x, y, z] = size;
        return Err(format!("{x} x {y} x {z} cells: expected 1 to {MAX_VALUES} in total"));
    };
    let data = bytes.get(used..).unwrap_or_default();
    let expected = 4 * channels * count;
    if data.len() as u64 != expected {
        return Err(format!("expected {expected} bytes of values, found {}", data.len()));
    }
    let floats = |bytes: &[u8]| -> Vec<f32> {
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
    };
    let (density, emission) = data.split_at(data.len() / channels as usize);
    let data = GridData::new(size, floats(density), (channels == 2).then(|| floats(emission)))?;
    match bounds {
        Some(bounds) => data.with_bounds(bounds),
        None => Ok(data),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let density: Vec<f32> = (0..24).map(|i| i as f32).collect();
        let emission: Vec<f32> = (0..24).map(|i| 1.0 / (1.0 + i as f32)).collect();
        let bytes = encode([2, 3, 4], &density, Some(&emission));
        let expected = GridData::new([2, 3, 4], density.clone(), Some(emission)).unwrap();
        assert_eq!(decode(&bytes, "a"), Ok(expected));
        let bytes = encode([4, 3, 2], &density, None);
        let alone = GridData::new([4, 3, 2], density, None).unwrap();
        assert_eq!(decode(&bytes, "a"), Ok(alone.clone()));
        let placed = alone.with_bounds([DVec3::new(-0.1, 0.0, 1e-3), DVec3::new(1.0, 2.5, 1e9)]).unwrap();
        let mut bytes = Vec::new();
        write(&placed, &mut bytes).unwrap();
        assert_eq!(decode(&bytes, "a"), Ok(placed));
    }

    #[test]
    fn a_name_after_an_openvdb_file_is_a_grid() {
        assert_eq!(split_name("smoke.nvdb#heat"), ("smoke.nvdb", Some("heat")));
        assert_eq!(split_name("a/smoke.VDB#heat 2"), ("a/smoke.VDB", Some("heat 2")));
        assert_eq!(split_name("take#3.vdb"), ("take#3.vdb", None));
        assert_eq!(split_name("take#3.grid"), ("take#3.grid", None));
    }

    #[test]
    fn damage_is_an_error() {
        let good = encode([2, 2, 2], &[1.0; 8], None);
        for cut in 0..good.len() {
            assert!(decode(&good[..cut], "a").is_err(), "{cut}");
        }
        let with =
            |text: &str, tail: &[u8]| decode(&[text.as_bytes(), tail].concat(), "a").unwrap_err().problem;
        let big = "turner-grid 1\nsize 4000000000 4000000000 4000000000\nchannels density\ndata\n";
        assert!(with(big, &[]).contains("expected 1 to"));
        let lies = "turner-grid 1\nsize 1000 1000 1000\nchannels density\ndata\n";
        assert!(with(lies, &[0; 64]).contains("expected 4000000000 bytes of values, found 64"));
        let one = "turner-grid 1\nsize 1 1 1\nchannels density\ndata\n";
        assert!(with(one, &f32::NAN.to_le_bytes()).contains("NaN"));
        assert!(with(one, &(-1.0f32).to_le_bytes()).contains("-1"));
        assert!(with("turner-grid 2\n", &[]).contains("turner-grid 1"));
        assert!(with("turner-grid 1\nsize 1 -1 1\n", &[]).contains("size"));
        assert!(with("turner-grid 1\nsize 1 1 1\nchannels heat\n", &[]).contains("channels"));
    }
}
