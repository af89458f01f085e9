//! PLY vertices: fixed-size columns are decoded directly from the bytes, other layouts value by value.

use turner::color::Transfer;
use turner::schema::MeshData;

use super::header::{self, Element, Encoding, Scalar};
use super::values::{Values, binary};
use super::{Fail, Stop, skip_list};
use crate::mesh::error::reserve;

const POSITION: [&str; 3] = ["x", "y", "z"];
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
/// Property names of (u, v).
const UV_NAMES: [[&str; 2]; 4] =
    [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];
/// Property names of further UV sets, beginning with the second.
pub(super) const MORE_UV_NAMES: [[&str; 2]; 8] = [
    ["u_1", "v_1"],
    ["u_2", "v_2"],
    ["u_3", "v_3"],
    ["u_4", "v_4"],
    ["u_5", "v_5"],
    ["u_6", "v_6"],
    ["u_7", "v_7"],
    ["u_8", "v_8"],
];
/// Property names of tangents; the fourth is the sign of the bitangent.
const TANGENT: [&str; 4] = ["tx", "ty", "tz", "tw"];
/// Property names of colours with opacity.
const COLOR_NAMES: [[&str; 4]; 4] = [
    ["red", "green", "blue", "alpha"],
    ["diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"],
    ["r", "g", "b", "a"],
    ["color_0", "color_1", "color_2", "color_3"],
];

/// Reads the element `vertex`.
pub(super) fn read(
    element: &Element,
    encoding: Encoding,
    data: &mut Values<'_>,
    mesh: &mut MeshData,
    name: &str,
) -> Result<(), Stop> {
    let has = |n: &&str| element.properties.iter().any(|p| p.name == *n && p.count.is_none());
    if let Some(missing) = POSITION.iter().find(|n| !has(n)) {
        return Err(data.fail(format!("vertices have no property \"{missing}\"")).into());
    }
    let has_normals = NORMAL.iter().all(has);
    let uv_names = UV_NAMES.iter().find(|names| names.iter().all(has));
    let color_names = COLOR_NAMES.iter().find(|names| names.iter().take(3).all(has));
    let has_colors = color_names.is_some();
    let has_tangents = TANGENT.iter().all(has);
    let is_there = |names: &[&str; 2]| names.iter().all(has);
    let more_uvs = MORE_UV_NAMES.iter().rposition(is_there).map_or(0, |last| last + 1);
    mesh.more_uvs = vec![Vec::new(); more_uvs];
    let n = element.count;
    reserve(&mut mesh.tangents, if has_tangents { n } else { 0 }, name)?;
    for (set, names) in mesh.more_uvs.iter_mut().zip(&MORE_UV_NAMES) {
        reserve(set, if is_there(names) { n } else { 0 }, name)?;
    }
    reserve(&mut mesh.colors, if has_colors { n } else { 0 }, name)?;
    reserve(&mut mesh.positions, n, name)?;
    reserve(&mut mesh.normals, if has_normals { n } else { 0 }, name)?;
    reserve(&mut mesh.uvs, if uv_names.is_some() { n } else { 0 }, name)?;
    if encoding == Encoding::Ascii || element.has_lists() {
        return Ok(read_slowly(element, uv_names, has_normals, color_names, data, mesh)?);
    }
    let stride: usize = element.properties.iter().map(|p| p.item.size()).sum();
    // `check_count` made sure that they fit.
    let rows = data.rest().get(..stride * n).unwrap_or(&[]);
    let big_endian = encoding == Encoding::BigEndian;
    columns(rows, stride, element, POSITION, big_endian, &mut mesh.positions);
    if has_normals {
        columns(rows, stride, element, NORMAL, big_endian, &mut mesh.normals);
    }
    if let Some(&names) = uv_names {
        columns(rows, stride, element, names, big_endian, &mut mesh.uvs);
    }
    for (set, names) in mesh.more_uvs.iter_mut().zip(MORE_UV_NAMES) {
        if is_there(&names) {
            columns(rows, stride, element, names, big_endian, set);
        }
    }
    if has_tangents {
        columns(rows, stride, element, TANGENT, big_endian, &mut mesh.tangents);
    }
    if let Some(names) = color_names {
        let bands = Band::all(element, names);
        let columns = names.map(|n| element.column(n));
        mesh.colors.extend(rows.chunks_exact(stride).map(|row| {
            [0, 1, 2, 3].map(|i| match columns[i] {
                Some((at, s)) => bands[i].value(binary(row.get(at..).unwrap_or(&[]), s, big_endian)),
                None => 1.0,
            })
        }));
    }
    data.advance(stride * n);
    Ok(())
}

/// Conversion of a colour component: integers are display-encoded, except for opacity; floats are linear.
enum Band {
    Real,
    /// A table for 8-bit values.
    Byte(Box<[f32; 256]>),
    Whole {
        full: f64,
        display: bool,
    },
}

impl Band {
    /// The conversions of all four properties.
    fn all(element: &Element, names: &[&str; 4]) -> [Band; 4] {
        names.map(|name| {
            let item = element.properties.iter().find(|p| p.name == name).map(|p| p.item);
            // The last name is opacity.
            let display = name != names[3];
            match item {
                None | Some(Scalar::F32 | Scalar::F64) => Band::Real,
                Some(Scalar::U8) => {
                    let whole = Band::Whole { full: 255.0, display };
                    Band::Byte(Box::new(std::array::from_fn(|i| whole.value(i as f64))))
                }
                Some(Scalar::U16 | Scalar::I16) => Band::Whole { full: 65535.0, display },
                Some(_) => Band::Whole { full: 255.0, display },
            }
        })
    }

    #[inline]
    fn value(&self, v: f64) -> f32 {
        match self {
            Band::Real => v as f32,
            // ASCII files may contain any number; the cast clamps, truncates, and maps NaN to 0.
            Band::Byte(table) => table[v as u8 as usize],
            Band::Whole { full, display: false } => (v / full) as f32,
            Band::Whole { full, display: true } => Transfer::Srgb.decode((v / full) as f32),
        }
    }
}

/// Decodes `N` properties of all records.
fn columns<const N: usize>(
    rows: &[u8],
    stride: usize,
    element: &Element,
    names: [&str; N],
    big_endian: bool,
    out: &mut Vec<[f32; N]>,
) {
    let found = names.map(|n| element.column(n).unwrap_or((0, Scalar::U8)));
    let rows = rows.chunks_exact(stride);
    if found.iter().all(|(_, s)| *s == Scalar::F32) {
        let word =
            |row: &[u8], at: usize| row.get(at..at + 4).and_then(|b| b.try_into().ok()).unwrap_or([0; 4]);
        if big_endian {
            out.extend(rows.map(|row| found.map(|(at, _)| f32::from_be_bytes(word(row, at)))));
        } else {
            out.extend(rows.map(|row| found.map(|(at, _)| f32::from_le_bytes(word(row, at)))));
        }
    } else {
        out.extend(
            rows.map(|row| found.map(|(at, s)| binary(row.get(at..).unwrap_or(&[]), s, big_endian) as f32)),
        );
    }
}

fn read_slowly(
    element: &Element,
    uv_names: Option<&[&str; 2]>,
    has_normals: bool,
    color_names: Option<&[&str; 4]>,
    data: &mut Values<'_>,
    mesh: &mut MeshData,
) -> Result<(), Fail> {
    // The slot of each property in `row`: 0..3 position, 3..6 normal, 6..8 (u, v), 8..12 colour, 12..16 tangent,
    // then further UV sets. The last slot receives unused properties.
    let uv_names = uv_names.copied().unwrap_or_default();
    let colors = color_names.copied().unwrap_or_default();
    let more = MORE_UV_NAMES.iter().take(mesh.more_uvs.len()).flatten().copied();
    let names: Vec<&str> =
        POSITION.into_iter().chain(NORMAL).chain(uv_names).chain(colors).chain(TANGENT).chain(more).collect();
    let nowhere = names.len();
    let target = |p: &header::Property| match p.count {
        None => names.iter().position(|n| *n == p.name).unwrap_or(nowhere),
        Some(_) => nowhere,
    };
    let targets: Vec<usize> = element.properties.iter().map(target).collect();
    let has = |n: &&str| element.properties.iter().any(|p| p.name == *n && p.count.is_none());
    let has_tangents = TANGENT.iter().all(has);
    let more_there: Vec<bool> = MORE_UV_NAMES.iter().map(|names| names.iter().all(has)).collect();
    let bands = Band::all(element, &colors);
    let mut row = vec![0.0_f64; nowhere + 1];
    row[11] = 1.0;
    for _ in 0..element.count {
        for (property, &target) in element.properties.iter().zip(&targets) {
            match property.count {
                None => row[target] = data.next(property.item)?,
                Some(count) => skip_list(count, property.item, data)?,
            }
        }
        if color_names.is_some() {
            mesh.colors.push([0, 1, 2, 3].map(|i| bands[i].value(row[8 + i])));
        }
        let at = |i: usize| row[i] as f32;
        mesh.positions.push([at(0), at(1), at(2)]);
        if has_normals {
            mesh.normals.push([at(3), at(4), at(5)]);
        }
        if !uv_names[0].is_empty() {
            mesh.uvs.push([at(6), at(7)]);
        }
        if has_tangents {
            mesh.tangents.push([at(12), at(13), at(14), at(15)]);
        }
        for (i, (set, there)) in mesh.more_uvs.iter_mut().zip(&more_there).enumerate() {
            if *there {
                set.push([at(16 + 2 * i), at(17 + 2 * i)]);
            }
        }
    }
    Ok(())
}
