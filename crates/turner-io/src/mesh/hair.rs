//! Hair: Cem Yuksel's binary HAIR files, and Mitsuba's text files of curves.
//!
//! ```text
//! HAIR: 128 bytes of header, then arrays, little-endian:
//!   0 "HAIR"    4 strands   8 points   12 bits of the arrays   16 default segments   20 default thickness
//!  24 default transparency  28 default colour   40 text
//!  arrays: segments u16 per strand, points 3 f32, thickness f32, transparency f32, colour 3 f32 per point
//! ```
//!
//! A text file has a point and its radius on each line; an empty line ends a curve.

use std::io::{self, Write};

use turner::schema::{MeshData, WarningKind};

use super::error::{push, reserve};
use super::{MeshError, Place, ReadMesh, parse_number, warning};
use crate::assets::printable;

/// First bytes of a HAIR file.
pub(crate) const MAGIC: &[u8] = b"HAIR";
const HEADER: usize = 128;
// Bits of the arrays.
const SEGMENTS: u32 = 1;
const POINTS: u32 = 2;
const THICKNESS: u32 = 4;
const TRANSPARENCY: u32 = 8;
const COLORS: u32 = 16;

pub(super) fn damaged(name: &str, format: &'static str, place: Place, problem: String) -> MeshError {
    MeshError::Damaged { name: printable(name), format, place, problem }
}

/// Reads a HAIR file: points, widths, and colours as vertex colours.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<ReadMesh, MeshError> {
    let fault = |at: usize, problem: String| damaged(name, "HAIR", Place::Byte(at as u64), problem);
    let word =
        |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes);
    let single = |at: usize| f32::from_bits(word(at));
    if bytes.len() < HEADER || !bytes.starts_with(MAGIC) {
        let problem = format!("expected a header of {HEADER} bytes, found {} bytes", bytes.len());
        return Err(fault(0, problem));
    }
    let (strands, points, arrays) = (word(4) as usize, word(8) as usize, word(12));
    if arrays & POINTS == 0 {
        return Err(fault(12, "the file has no points".to_owned()));
    }
    let has = |bit: u32| usize::from(arrays & bit != 0);
    let per_point = 12 * has(POINTS) + 4 * has(THICKNESS) + 4 * has(TRANSPARENCY) + 12 * has(COLORS);
    let need = 2 * (strands as u64) * has(SEGMENTS) as u64 + points as u64 * per_point as u64;
    let room = (bytes.len() - HEADER) as u64;
    if need > room || strands > points {
        let problem =
            format!("{strands} strands with {points} points need {need} bytes, but {room} follow the header");
        return Err(fault(4, problem));
    }
    let mut out = ReadMesh::default();
    let mesh = &mut out.mesh;
    reserve(&mut mesh.strands, strands, name)?;
    let mut at = HEADER;
    let mut sum = 0_u64;
    for _ in 0..strands {
        let segments = if arrays & SEGMENTS == 0 {
            word(16)
        } else {
            let pair = bytes.get(at..at + 2).and_then(|b| b.try_into().ok());
            at += 2;
            u32::from(pair.map_or(0, u16::from_le_bytes))
        };
        sum += u64::from(segments) + 1;
        mesh.strands.push(segments.saturating_add(1));
    }
    if sum != points as u64 {
        return Err(fault(8, format!("{strands} strands have {sum} points, but {points} are announced")));
    }
    reserve(&mut mesh.positions, points, name)?;
    for i in 0..points {
        mesh.positions.push([0, 4, 8].map(|k| single(at + 12 * i + k)));
    }
    at += 12 * points;
    reserve(&mut mesh.widths, points, name)?;
    for i in 0..points {
        mesh.widths.push(single(if arrays & THICKNESS == 0 { 20 } else { at + 4 * i }));
    }
    at += 4 * points * has(THICKNESS);
    if arrays & TRANSPARENCY != 0 {
        out.warnings.push(warning(WarningKind::Ignored, name, 1, "the transparency of hair"));
        at += 4 * points;
    }
    if arrays & COLORS != 0 {
        reserve(&mut mesh.colors, points, name)?;
        for i in 0..points {
            let [r, g, b] = [0, 4, 8].map(|k| single(at + 12 * i + k));
            mesh.colors.push([r, g, b, 1.0].map(|v| if v.is_finite() { v } else { 0.0 }));
        }
    }
    drop_short(&mut out, name);
    Ok(out)
}

/// Drops curves of one point.
pub(super) fn drop_short(out: &mut ReadMesh, name: &str) {
    let short = out.mesh.strands.iter().filter(|n| **n < 2).count();
    if short == 0 {
        return;
    }
    let mesh = &mut out.mesh;
    let keep: Vec<bool> =
        mesh.strands.iter().flat_map(|n| std::iter::repeat_n(*n >= 2, *n as usize)).collect();
    fn kept<T>(list: &mut Vec<T>, keep: &[bool]) {
        let mut each = keep.iter();
        list.retain(|_| each.next().copied().unwrap_or(false));
    }
    kept(&mut mesh.positions, &keep);
    kept(&mut mesh.widths, &keep);
    kept(&mut mesh.colors, &keep);
    mesh.strands.retain(|n| *n >= 2);
    let message = "curves of a single point: omitted";
    out.warnings.push(warning(WarningKind::Doubtful, name, short as u64, message));
}

/// Whether [`write`] keeps all that the curves have.
pub(crate) fn can_write(data: &MeshData) -> bool {
    let short = data.strands.iter().all(|n| (1..=u32::from(u16::MAX) + 1).contains(n));
    !data.strands.is_empty() && short && data.normals.is_empty() && data.colors.iter().all(|c| c[3] == 1.0)
}

/// Writes a HAIR file.
pub(crate) fn write(data: &MeshData, out: &mut dyn Write) -> io::Result<()> {
    let bit = |there: bool, bit: u32| if there { bit } else { 0 };
    let arrays =
        SEGMENTS | POINTS | bit(!data.widths.is_empty(), THICKNESS) | bit(!data.colors.is_empty(), COLORS);
    let mut header = [0; HEADER];
    let words = [data.strands.len() as u32, data.positions.len() as u32, arrays];
    let parts = MAGIC.iter().copied().chain(words.into_iter().flat_map(u32::to_le_bytes));
    header.iter_mut().zip(parts).for_each(|(to, from)| *to = from);
    out.write_all(&header)?;
    for n in &data.strands {
        out.write_all(&(n.saturating_sub(1) as u16).to_le_bytes())?;
    }
    for v in data.positions.as_flattened().iter().chain(&data.widths) {
        out.write_all(&v.to_le_bytes())?;
    }
    for v in data.colors.iter().flat_map(|c| c.iter().take(3)) {
        out.write_all(&v.to_le_bytes())?;
    }
    Ok(())
}

/// Reads a text file of curves, as Mitsuba's `bsplinecurve` and `linearcurve` do: x, y, z and radius on each line.
pub(crate) fn read_text(bytes: &[u8], name: &str) -> Result<ReadMesh, MeshError> {
    let mut out = ReadMesh::default();
    let mut open = 0;
    for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
        let fault = |problem: String| damaged(name, "curves", Place::Line(number as u64 + 1), problem);
        let line = line.trim_ascii();
        if line.is_empty() {
            if open > 0 {
                push(&mut out.mesh.strands, open, name)?;
            }
            open = 0;
            continue;
        }
        let mut values = [0.0; 4];
        let mut words = line.split(|b| b.is_ascii_whitespace()).filter(|w| !w.is_empty());
        for value in &mut values {
            let word = words.next().and_then(|w| std::str::from_utf8(w).ok());
            *value = word
                .and_then(parse_word)
                .ok_or_else(|| fault("expected four numbers: x, y, z and the radius".to_owned()))?;
        }
        if words.next().is_some() {
            return Err(fault("expected four numbers: x, y, z and the radius; found more".to_owned()));
        }
        let [x, y, z, radius] = values;
        push(&mut out.mesh.positions, [x as f32, y as f32, z as f32], name)?;
        push(&mut out.mesh.widths, (2.0 * radius) as f32, name)?;
        open += 1;
    }
    if open > 0 {
        push(&mut out.mesh.strands, open, name)?;
    }
    drop_short(&mut out, name);
    Ok(out)
}

pub(super) fn parse_word(word: &str) -> Option<f64> {
    parse_number(word.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fur() -> MeshData {
        MeshData {
            positions: (0..7).map(|i| [i as f32, 0.5 * i as f32, -1.0]).collect(),
            widths: (0..7).map(|i| 0.1 * i as f32).collect(),
            colors: (0..7).map(|i| [0.1 * i as f32, 0.2, 0.3, 1.0]).collect(),
            strands: vec![4, 3],
            ..MeshData::default()
        }
    }

    fn file(data: &MeshData) -> Vec<u8> {
        assert!(can_write(data));
        let mut out = Vec::new();
        write(data, &mut out).unwrap();
        out
    }

    #[test]
    fn files_are_read_as_they_were_written() {
        for data in [fur(), MeshData { colors: Vec::new(), ..fur() }] {
            let read = read(&file(&data), "a.hair").unwrap();
            assert_eq!((read.mesh, read.warnings.len()), (data, 0));
        }
    }

    /// The defaults of the header apply where an array is absent.
    #[test]
    fn defaults_of_the_header_apply() {
        let mut bytes = vec![0; HEADER];
        bytes[..4].copy_from_slice(MAGIC);
        let words = [2_u32, 6, POINTS, 2, 0.25_f32.to_bits()];
        bytes[4..24].copy_from_slice(&words.map(u32::to_le_bytes).concat());
        bytes.extend((0..18).flat_map(|i| (i as f32).to_le_bytes()));
        let mesh = read(&bytes, "a.hair").unwrap().mesh;
        assert_eq!((mesh.strands, mesh.widths), (vec![3, 3], vec![0.25; 6]));
        assert_eq!(mesh.positions[5], [15.0, 16.0, 17.0]);
    }

    #[test]
    fn damaged_files_are_errors() {
        let good = file(&fur());
        for end in 0..good.len() {
            assert!(read(&good[..end], "a.hair").is_err(), "{end}");
        }
        for (at, value) in [(4, u32::MAX), (8, u32::MAX), (8, 8), (4, 3), (12, 1), (12, u32::MAX)] {
            let mut bad = good.clone();
            bad[at..at + 4].copy_from_slice(&value.to_le_bytes());
            let error = read(&bad, "a.hair").unwrap_err().to_string();
            assert!(error.contains("a.hair: damaged HAIR: byte"), "{error}");
        }
        // Every damaged byte: an error or valid curves.
        for at in 0..good.len() {
            let mut bad = good.clone();
            bad[at] ^= 0xff;
            if let Ok(read) = read(&bad, "a.hair") {
                read.mesh.check().unwrap();
            }
        }
    }

    #[test]
    fn text_files_have_a_curve_per_paragraph() {
        let text = b"0 0 0 .1\n1 0 0 .2\r\n\n\n5 5 5 1\n\n 2 0 0 .1\n3 0 0 .1\n4 1 2.5e0 .05";
        let read = read_text(text, "a.txt").unwrap();
        assert_eq!(read.mesh.strands, [2, 3]);
        assert_eq!(read.mesh.positions[4], [4.0, 1.0, 2.5]);
        assert_eq!(read.mesh.widths, [0.2, 0.4, 0.2, 0.2, 0.1]);
        assert_eq!(read.warnings.len(), 1);
        for bad in ["1 2 3", "1 2 3 4 5", "1 2 x 4", "1 2 3 4\n\u{e9}"] {
            let error = read_text(bad.as_bytes(), "a.txt").unwrap_err().to_string();
            assert!(error.contains("a.txt: damaged curves: line"), "{error}");
        }
    }
}
