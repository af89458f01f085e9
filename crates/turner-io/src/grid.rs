//! Grids of densities and signed distances: OpenVDB and NanoVDB files, and a text header followed by binary values.
//!
//! ```text
//! turner-grid 1
//! size 64 32 64
//! channels density emission
//! bounds 0 0 0 4 2 4
//! data
//! ```
//!
//! Each header line ends with a line feed. `size` is the number of cells along x, y and z. `channels` begins with
//! `density`, or with `extinction`, a density for each colour; `emission` and one of `albedo` and `scattering`, which
//! are colours, may follow. Or it is `distance` alone: signed distances at vertices. `bounds`, which may be absent, are
//! the least and the largest coordinates of the box that the cells fill, or of the first and the last vertices. The values follow `data` and its line feed, as little-endian IEEE 754 singles, and nothing
//! follows them: all of the first channel, x fastest, then y, then z; then all of the next channel. Colours have three
//! values for each cell.

use std::io::{self, Write};

use turner::math::DVec3;
use turner::schema::data::MAX_VALUES;
use turner::schema::{GridData, GridScattering};

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
pub const MAX_GRID: u64 = 4 * MAX_FLOATS * MAX_VALUES + MAX_HEADING as u64;

/// Most values of a cell: the extinction and the scattering of three colours, and the emission.
const MAX_FLOATS: u64 = 3 + 3 + 1;

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
    let scattering = grid.scattering().map(|s| match s {
        GridScattering::Albedo(_) => "albedo",
        GridScattering::Coefficient(_) => "scattering",
    });
    let density = match grid.extinction() {
        Some(_) => "extinction",
        None if grid.has_distances() => "distance",
        None => "density",
    };
    let emission = grid.emission().map(|_| "emission");
    let channels: Vec<&str> = [Some(density), emission, scattering].into_iter().flatten().collect();
    out.write_all(heading(grid.size(), &channels.join(" "), grid.bounds()).as_bytes())?;
    let density = if grid.extinction().is_some() { None } else { Some(grid.density()) };
    let extinction = grid.extinction().map(<[[f32; 3]]>::as_flattened);
    let scattering = grid.scattering().map(|s| s.values().as_flattened());
    for values in [density, extinction, grid.emission(), scattering].into_iter().flatten() {
        for block in values.chunks(1 << 14) {
            out.write_all(&block.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>())?;
        }
    }
    Ok(())
}

/// A channel of a grid file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Channel {
    Density,
    Distance,
    Extinction,
    Emission,
    Albedo,
    Scattering,
}

/// Their names in files.
const CHANNELS: [(&str, Channel); 6] = [
    ("density", Channel::Density),
    ("distance", Channel::Distance),
    ("extinction", Channel::Extinction),
    ("emission", Channel::Emission),
    ("albedo", Channel::Albedo),
    ("scattering", Channel::Scattering),
];

impl Channel {
    /// Values for each cell: one, or three for a colour.
    fn floats(self) -> u64 {
        match self {
            Channel::Density | Channel::Distance | Channel::Emission => 1,
            Channel::Extinction | Channel::Albedo | Channel::Scattering => 3,
        }
    }
}

/// The channels of the line `channels …`: distance alone; or first density or extinction, each once, albedo or scattering.
fn channels_of(words: &[&str]) -> Option<Vec<Channel>> {
    let (_, names) = words.split_first().filter(|(first, _)| **first == "channels")?;
    let of = |name: &&str| CHANNELS.iter().find(|(n, _)| n == name).map(|(_, c)| *c);
    let channels: Vec<Channel> = names.iter().map(of).collect::<Option<_>>()?;
    let has = |c: Channel| channels.iter().filter(|o| **o == c).count();
    let once = |a: Channel, b: Channel| has(a) + has(b) <= 1;
    if channels == [Channel::Distance] {
        return Some(channels);
    }
    let first = channels.first()?;
    let is_sound = matches!(first, Channel::Density | Channel::Extinction)
        && once(Channel::Density, Channel::Extinction)
        && once(Channel::Albedo, Channel::Scattering)
        && has(Channel::Emission) <= 1
        && has(Channel::Distance) == 0;
    is_sound.then_some(channels)
}

/// The channels that a file has.
#[derive(Default)]
struct Found {
    density: Vec<f32>,
    distance: Option<Vec<f32>>,
    extinction: Option<Vec<[f32; 3]>>,
    emission: Option<Vec<f32>>,
    scattering: Option<GridScattering>,
}

impl Found {
    fn grid(self, size: [u32; 3]) -> Result<GridData, String> {
        if let Some(distances) = self.distance {
            return GridData::of_distances(size, distances);
        }
        let data = match self.extinction {
            Some(extinction) => GridData::of_extinction(size, extinction, self.emission)?,
            None => GridData::new(size, self.density, self.emission)?,
        };
        match self.scattering {
            Some(scattering) => data.with_scattering(scattering),
            None => Ok(data),
        }
    }
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
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let Some(channels) = channels_of(&words) else {
        return wrong(
            "channels density` or, with further channels, `channels extinction emission albedo",
            &line,
        );
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
    let expected = 4 * count * channels.iter().map(|c| c.floats()).sum::<u64>();
    if data.len() as u64 != expected {
        return Err(format!("expected {expected} bytes of values, found {}", data.len()));
    }
    let mut rest = data;
    let mut found = Found::default();
    for channel in channels {
        let (values, after) =
            rest.split_at_checked((4 * count * channel.floats()) as usize).unwrap_or_default();
        rest = after;
        let floats = || values.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b));
        let colors = || floats().collect::<Vec<f32>>().as_chunks::<3>().0.to_vec();
        match channel {
            Channel::Density => found.density = floats().collect(),
            Channel::Distance => found.distance = Some(floats().collect()),
            Channel::Extinction => found.extinction = Some(colors()),
            Channel::Emission => found.emission = Some(floats().collect()),
            Channel::Albedo => found.scattering = Some(GridScattering::Albedo(colors())),
            Channel::Scattering => found.scattering = Some(GridScattering::Coefficient(colors())),
        }
    }
    let data = found.grid(size)?;
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
        let alone = GridData::new([4, 3, 2], density.clone(), None).unwrap();
        assert_eq!(decode(&bytes, "a"), Ok(alone.clone()));
        let colors = |f: f32| (0..24).map(|i| [f * i as f32, f, 0.5 * f]).collect::<Vec<[f32; 3]>>();
        for scattering in
            [GridScattering::Albedo(vec![[0.0, 0.5, 1.0]; 24]), GridScattering::Coefficient(colors(0.5))]
        {
            for base in [alone.clone(), decode(&encode([2, 3, 4], &density, Some(&density)), "a").unwrap()] {
                let colored = base.with_extinction(colors(1.0)).unwrap();
                let colored = colored.with_scattering(scattering.clone()).unwrap();
                let mut bytes = Vec::new();
                write(&colored, &mut bytes).unwrap();
                assert_eq!(decode(&bytes, "a"), Ok(colored));
                assert!(decode(&bytes[..bytes.len() - 4], "a").is_err());
            }
        }
        let distances: Vec<f32> = (0..24).map(|i| 0.5 * i as f32 - 7.25).collect();
        let distances = GridData::of_distances([2, 3, 4], distances).unwrap();
        let mut bytes = Vec::new();
        write(&distances, &mut bytes).unwrap();
        assert_eq!(decode(&bytes, "a"), Ok(distances));
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
        for channels in [
            "heat",
            "emission density",
            "density extinction",
            "density albedo scattering",
            "density distance",
            "distance emission",
            "",
        ] {
            let text = format!("turner-grid 1\nsize 1 1 1\nchannels {channels}\n");
            assert!(with(&text, &[]).contains("channels"), "{channels}");
        }
        let one = "turner-grid 1\nsize 1 1 1\nchannels distance\ndata\n";
        assert!(with(one, &f32::NAN.to_le_bytes()).contains("NaN"));
        assert!(decode(&[one.as_bytes(), &(-1.0f32).to_le_bytes()].concat(), "a").is_ok());
        let ones = [1.0f32.to_le_bytes(); 4].concat();
        let bright = [&[0; 4][..], &ones[..12]].concat();
        let bright = with("turner-grid 1\nsize 1 1 1\nchannels density scattering\ndata\n", &bright);
        assert!(bright.contains("scatters"), "{bright}");
    }
}
