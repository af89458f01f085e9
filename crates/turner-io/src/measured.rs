//! Measured BRDFs: the tensor files (`.bsdf`) of the RGL material database (Dupuy and Jakob 2018).
//!
//! A file is a list of named arrays. Numbers are little-endian.
//!
//! | bytes | meaning |
//! |---|---|
//! | 12 | `tensor_file` and a zero |
//! | 2 | version: 1, 0 |
//! | 4 | number of fields |
//! | for each field | 2: length of its name; the name; 2: number of dimensions; 1: type; 8: offset of its data in the file; 8 for each dimension |
//!
//! `phi_i` and `theta_i` are directions of view; `ndf`, `sigma`, `vndf` and `luminance` tables of 32-bit floats; the
//! colours are `rgb` (linear sRGB) or `spectra` at `wavelengths` in nm, which are seen under D65.

use std::collections::HashMap;
use std::io::{self, Write};

use turner::schema::{MAX_MEASURED_VALUES, MeasuredBrdf, MeasuredFields, MeasuredTable};

use crate::assets::printable;
use crate::spectral;

/// Largest accepted file, in bytes: 1 GiB.
pub const MAX_BSDF: u64 = 1 << 30;

const MAGIC: &[u8; 12] = b"tensor_file\0";
/// Types of values.
const UINT8: u8 = 1;
const FLOAT32: u8 = 10;
/// Most dimensions of a field.
const MAX_DIMENSIONS: usize = 8;

/// Why a BSDF file could not be read: file, problem and remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}: damaged BSDF file: {problem}\n  download it again")]
pub struct MeasuredError {
    /// The file.
    pub name: String,
    /// What was found and what was expected.
    pub problem: String,
}

/// Memory that reading a file takes besides its bytes, in bytes: at most as much as the file for each of values and two
/// integrals.
pub fn need(bytes: &[u8]) -> u64 {
    bytes.len() as u64 * 3
}

/// An array of a file.
struct Tensor<'a> {
    shape: Vec<u64>,
    kind: u8,
    data: &'a [u8],
}

type Tensors<'a> = HashMap<&'a [u8], Tensor<'a>>;

/// The next `N` bytes.
fn take<'a, const N: usize>(rest: &mut &'a [u8]) -> Result<&'a [u8; N], String> {
    let (head, tail) = rest.split_first_chunk().ok_or("the list of fields is cut off")?;
    *rest = tail;
    Ok(head)
}

/// All arrays. Their data lie within the file.
fn tensors(bytes: &[u8]) -> Result<Tensors<'_>, String> {
    let rest = &mut bytes.strip_prefix(MAGIC).ok_or("it does not begin with \"tensor_file\"")?;
    let version = take::<2>(rest)?;
    if *version != [1, 0] {
        return Err(format!("version {}.{}: expected 1.0", version[0], version[1]));
    }
    let count = u32::from_le_bytes(*take(rest)?);
    let mut tensors = HashMap::new();
    for _ in 0..count {
        let length = usize::from(u16::from_le_bytes(*take(rest)?));
        let name = rest.get(..length).ok_or("the name of a field is cut off")?;
        *rest = &rest[length..];
        let called = || printable(&String::from_utf8_lossy(name));
        let dimensions = usize::from(u16::from_le_bytes(*take(rest)?));
        let [kind] = *take(rest)?;
        let offset = u64::from_le_bytes(*take(rest)?);
        if dimensions > MAX_DIMENSIONS {
            return Err(format!("the field {} has {dimensions} dimensions", called()));
        }
        let shape: Vec<u64> =
            (0..dimensions).map(|_| take(rest).map(|b| u64::from_le_bytes(*b))).collect::<Result<_, _>>()?;
        let width = match kind {
            1 | 2 => 1,
            3 | 4 | 9 => 2,
            5 | 6 | 10 => 4,
            7 | 8 | 11 => 8,
            _ => return Err(format!("the field {} has values of an unknown type, {kind}", called())),
        };
        let size = shape.iter().try_fold(width, |all: u64, n| all.checked_mul(*n));
        let range = size.and_then(|size| Some(offset as usize..offset.checked_add(size)? as usize));
        let data = range.filter(|_| offset <= MAX_BSDF).and_then(|range| bytes.get(range));
        let data = data.ok_or_else(|| format!("the data of the field {} end beyond the file", called()))?;
        tensors.insert(name, Tensor { shape, kind, data });
    }
    Ok(tensors)
}

/// The 32-bit floats of a field with the given number of dimensions, and its shape.
fn floats(tensors: &Tensors<'_>, name: &str, dimensions: usize) -> Result<(Vec<u64>, Vec<f32>), String> {
    let tensor = tensors.get(name.as_bytes()).ok_or_else(|| format!("it has no field {name}"))?;
    if tensor.kind != FLOAT32 || tensor.shape.len() != dimensions {
        return Err(format!(
            "the field {name} has {} dimensions and type {}: expected {dimensions} and 32-bit floats ({FLOAT32})",
            tensor.shape.len(),
            tensor.kind
        ));
    }
    if tensor.data.len() as u64 / 4 > MAX_MEASURED_VALUES {
        return Err(format!("the field {name} has more than {MAX_MEASURED_VALUES} values"));
    }
    let values = tensor.data.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    Ok((tensor.shape.clone(), values))
}

/// A table with `dimensions`, of which the last two are rows and columns and the first two directions of view.
fn table(
    tensors: &Tensors<'_>,
    name: &str,
    dimensions: usize,
    views: [usize; 2],
) -> Result<MeasuredTable, String> {
    let (shape, values) = floats(tensors, name, dimensions)?;
    if dimensions > 2 && shape[..2] != views.map(|n| n as u64) {
        return Err(format!(
            "the field {name} has {} × {} directions of view: phi_i and theta_i have {} × {}",
            shape[0], shape[1], views[0], views[1]
        ));
    }
    Ok(MeasuredTable { size: [shape[dimensions - 1] as usize, shape[dimensions - 2] as usize], values })
}

/// Spectra as linear sRGB, three tables for each direction of view.
fn colors_of_spectra(tensors: &Tensors<'_>, views: [usize; 2]) -> Result<MeasuredTable, String> {
    let (_, wavelengths) = floats(tensors, "wavelengths", 1)?;
    if wavelengths.is_empty() || !wavelengths.windows(2).all(|w| w[0] < w[1]) {
        return Err("the wavelengths do not increase".into());
    }
    let spectra = table(tensors, "spectra", 5, views)?;
    let count = wavelengths.len();
    let slice = spectra.size[0].saturating_mul(spectra.size[1]);
    let wanted = slice.saturating_mul(views[0] * views[1]).saturating_mul(count);
    if slice == 0 || spectra.values.len() != wanted {
        return Err(format!("the field spectra has {} values: expected {wanted}", spectra.values.len()));
    }
    let at: Vec<f64> = wavelengths.iter().map(|nm| f64::from(*nm)).collect();
    // Each value counts by the colour of a spectrum that is 1 there and falls linearly to its neighbours.
    let weights: Vec<[f32; 3]> = (0..count)
        .map(|k| {
            let hat = |nm: f64| match at[k] {
                here if nm < here => match k.checked_sub(1) {
                    Some(before) => 1.0 - (here - nm) / (here - at[before]),
                    None => 1.0,
                },
                here => at.get(k + 1).map_or(1.0, |after| 1.0 - (nm - here) / (after - here)),
            };
            spectral::linear_in_daylight(|nm| hat(nm).clamp(0.0, 1.0)).map(|v| v as f32)
        })
        .collect();
    let mut values = vec![0.0; slice * views[0] * views[1] * 3];
    for (spectrum, out) in spectra.values.chunks_exact(slice * count).zip(values.chunks_exact_mut(slice * 3))
    {
        for (one, weight) in spectrum.chunks_exact(slice).zip(&weights) {
            for (channel, weight) in out.chunks_exact_mut(slice).zip(weight) {
                channel.iter_mut().zip(one).for_each(|(sum, v)| *sum += v * weight);
            }
        }
    }
    Ok(MeasuredTable { size: spectra.size, values })
}

fn read(bytes: &[u8]) -> Result<MeasuredBrdf, String> {
    let tensors = tensors(bytes)?;
    let (_, theta_i) = floats(&tensors, "theta_i", 1)?;
    let (_, phi_i) = floats(&tensors, "phi_i", 1)?;
    let views = [phi_i.len(), theta_i.len()];
    let rgb = if tensors.contains_key("rgb".as_bytes()) {
        table(&tensors, "rgb", 5, views)?
    } else if tensors.contains_key("spectra".as_bytes()) {
        colors_of_spectra(&tensors, views)?
    } else {
        return Err("it has neither a field rgb nor a field spectra".into());
    };
    let jacobian = tensors.get("jacobian".as_bytes()).and_then(|t| t.data.first());
    MeasuredBrdf::new(MeasuredFields {
        ndf: table(&tensors, "ndf", 2, views)?,
        sigma: table(&tensors, "sigma", 2, views)?,
        vndf: table(&tensors, "vndf", 4, views)?,
        luminance: table(&tensors, "luminance", 4, views)?,
        rgb,
        theta_i,
        phi_i,
        jacobian: jacobian.is_none_or(|v| *v != 0),
    })
}

/// Reads a file. `name` appears in messages.
///
/// Errors: damage, fields that are missing, of another type, or that contradict each other.
pub fn decode(bytes: &[u8], name: &str) -> Result<MeasuredBrdf, MeasuredError> {
    read(bytes).map_err(|problem| MeasuredError { name: printable(name), problem })
}

/// Writes a file with linear sRGB. Tables of densities are scaled, which changes nothing.
pub fn write(measured: &MeasuredBrdf, out: &mut dyn Write) -> io::Result<()> {
    let fields = measured.fields();
    let views = [fields.phi_i.len(), fields.theta_i.len()];
    let floats = |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    let rows = |table: &MeasuredTable| [table.size[1], table.size[0]];
    let seen = |table: &MeasuredTable| [&views[..], &rows(table)[..]].concat();
    let colors = [&views[..], &[3], &rows(&fields.rgb)[..]].concat();
    let all: [(&str, u8, Vec<usize>, Vec<u8>); 9] = [
        ("description", UINT8, vec![6], b"Turner".to_vec()),
        ("jacobian", UINT8, vec![1], vec![u8::from(fields.jacobian)]),
        ("phi_i", FLOAT32, vec![views[0]], floats(&fields.phi_i)),
        ("theta_i", FLOAT32, vec![views[1]], floats(&fields.theta_i)),
        ("ndf", FLOAT32, rows(&fields.ndf).to_vec(), floats(&fields.ndf.values)),
        ("sigma", FLOAT32, rows(&fields.sigma).to_vec(), floats(&fields.sigma.values)),
        ("vndf", FLOAT32, seen(&fields.vndf), floats(&fields.vndf.values)),
        ("luminance", FLOAT32, seen(&fields.luminance), floats(&fields.luminance.values)),
        ("rgb", FLOAT32, colors, floats(&fields.rgb.values)),
    ];
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&(all.len() as u32).to_le_bytes())?;
    let header: usize =
        all.iter().map(|(name, _, shape, _)| 2 + name.len() + 2 + 1 + 8 + 8 * shape.len()).sum();
    let mut offset = MAGIC.len() + 2 + 4 + header;
    for (name, kind, shape, data) in &all {
        out.write_all(&(name.len() as u16).to_le_bytes())?;
        out.write_all(name.as_bytes())?;
        out.write_all(&(shape.len() as u16).to_le_bytes())?;
        out.write_all(&[*kind])?;
        out.write_all(&(offset as u64).to_le_bytes())?;
        for n in shape {
            out.write_all(&(*n as u64).to_le_bytes())?;
        }
        offset += data.len();
    }
    all.iter().try_for_each(|(.., data)| out.write_all(data))
}

#[cfg(test)]
pub(crate) mod tests {
    use turner::math::DVec3;

    use super::*;

    /// A small isotropic BRDF.
    pub(crate) fn small() -> MeasuredBrdf {
        let table = |slices: usize, from: f32| MeasuredTable {
            size: [3, 2],
            values: (0..6 * slices).map(|i| from + 0.125 * (i % 5) as f32).collect(),
        };
        MeasuredBrdf::new(MeasuredFields {
            theta_i: vec![0.0, 0.7, 1.4],
            phi_i: vec![0.0],
            ndf: table(1, 0.5),
            sigma: table(1, 0.75),
            vndf: table(3, 0.25),
            luminance: table(3, 1.0),
            rgb: table(9, 0.1),
            jacobian: true,
        })
        .unwrap()
    }

    pub(crate) fn file() -> Vec<u8> {
        let mut bytes = Vec::new();
        write(&small(), &mut bytes).unwrap();
        bytes
    }

    /// A file of fields: name, type, shape, data.
    fn of_fields(fields: &[(&str, u8, &[u64], Vec<u8>)]) -> Vec<u8> {
        let mut head = [&MAGIC[..], &[1, 0], &(fields.len() as u32).to_le_bytes()].concat();
        let length: usize = fields.iter().map(|(n, _, s, _)| 13 + n.len() + 8 * s.len()).sum();
        let mut offset = head.len() + length;
        for (name, kind, shape, data) in fields {
            head.extend((name.len() as u16).to_le_bytes());
            head.extend(name.as_bytes());
            head.extend((shape.len() as u16).to_le_bytes());
            head.push(*kind);
            head.extend((offset as u64).to_le_bytes());
            head.extend(shape.iter().flat_map(|n| n.to_le_bytes()));
            offset += data.len();
        }
        fields.iter().fold(head, |all, (.., data)| [all, data.clone()].concat())
    }

    #[test]
    fn files_are_read_back() {
        let back = decode(&file(), "a.bsdf").unwrap();
        assert_eq!(back.fields().rgb.values, small().fields().rgb.values);
        // Densities are scaled once more: by 1, within rounding.
        for (a, b) in back.fields().vndf.values.iter().zip(small().fields().vndf.values) {
            assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
        }
    }

    /// Spectra that are the same at all wavelengths are grey; those of long wavelengths are red.
    #[test]
    fn spectra_become_colors() {
        let floats = |v: &[f32]| -> Vec<u8> { v.iter().flat_map(|v| v.to_le_bytes()).collect() };
        let ones = |n: usize| floats(&vec![1.0; n]);
        let with = |spectra: &[f32], wavelengths: &[f32]| {
            of_fields(&[
                ("phi_i", 10, &[1], floats(&[0.0])),
                ("theta_i", 10, &[1], floats(&[0.0])),
                ("ndf", 10, &[2, 2], ones(4)),
                ("sigma", 10, &[2, 2], ones(4)),
                ("vndf", 10, &[1, 1, 2, 2], ones(4)),
                ("luminance", 10, &[1, 1, 2, 2], ones(4)),
                ("wavelengths", 10, &[3], floats(wavelengths)),
                ("spectra", 10, &[1, 1, 3, 2, 2], floats(spectra)),
            ])
        };
        let colors = |spectra: &[f32]| {
            let read = decode(&with(spectra, &[400.0, 560.0, 700.0]), "a.bsdf").unwrap();
            let rgb = read.fields().rgb;
            assert_eq!((rgb.size, rgb.values.len()), ([2, 2], 12));
            DVec3::new(rgb.values[1].into(), rgb.values[5].into(), rgb.values[9].into())
        };
        let grey = colors(&[0.5; 12]);
        assert!((grey - 0.5).abs().max_element() < 1e-4, "{grey}");
        let red = colors(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
        assert!(red.x > 0.4 && red.x > 4.0 * red.z.abs(), "{red}");
        let error = decode(&with(&[0.5; 12], &[400.0, 390.0, 700.0]), "a.bsdf").unwrap_err();
        assert!(error.problem.contains("do not increase"), "{error}");
    }

    #[test]
    fn damage_is_reported() {
        let whole = file();
        for (bytes, problem) in [
            (b"OBJ".to_vec(), "does not begin"),
            ([&whole[..12], &[2, 0], &whole[14..]].concat(), "version 2.0"),
            (whole[..16].to_vec(), "cut off"),
            (whole[..60].to_vec(), "end beyond the file"),
            (whole[..whole.len() - 1].to_vec(), "end beyond the file"),
            ([&whole[..14], &[8, 0, 0, 0], &whole[18..]].concat(), "neither a field rgb"),
            (of_fields(&[("theta_i", 11, &[1], vec![0; 8])]), "expected 1 and 32-bit floats"),
            (of_fields(&[("theta_i", 99, &[1], vec![0; 8])]), "unknown type"),
            (of_fields(&[("theta_i", 10, &[1; 9], vec![0; 8])]), "9 dimensions"),
            (of_fields(&[("theta_i", 10, &[u64::MAX, 2], vec![])]), "end beyond the file"),
            (of_fields(&[("a", 10, &[0], vec![])]), "no field theta_i"),
        ] {
            let error = decode(&bytes, "a.bsdf").unwrap_err();
            assert!(error.problem.contains(problem), "{error}, not {problem}");
        }
        // No byte changed leads to a panic.
        for i in 0..whole.len().min(400) {
            for value in [0, 1, 0x7f, 0xff] {
                let mut bytes = whole.clone();
                bytes[i] = value;
                let _ = decode(&bytes, "a.bsdf");
            }
        }
    }

    /// pbrt's and Mitsuba's materials share the tables of one file; damaged ones are grey.
    #[test]
    fn importers_read_measured_materials() {
        use turner::material::MaterialDesc;

        use crate::assets::MemoryAssets;
        use crate::import::ImportOptions;

        let pbrt = "WorldBegin Material \"measured\" \"string filename\" \"a.bsdf\" Shape \"sphere\"\n\
                    AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" AttributeEnd";
        let bsdf = "<bsdf type='measured'><string name='filename' value='a.bsdf'/></bsdf>";
        let mitsuba = format!(
            "<scene version='3.0.0'><shape type='sphere'>{bsdf}</shape>\
             <shape type='sphere'><bsdf type='twosided'>{bsdf}</bsdf></shape></scene>"
        );
        for (name, text) in [("a.pbrt", pbrt), ("a.xml", &mitsuba)] {
            let mut assets = MemoryAssets::default();
            assets.files.insert("a.bsdf".into(), file());
            let load = |assets: &MemoryAssets| {
                let options = ImportOptions::default();
                crate::import::import(text.as_bytes().to_vec(), name, assets, &options).unwrap()
            };
            let scene = load(&assets);
            assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
            let [MaterialDesc::Measured(a), MaterialDesc::Measured(b)] =
                [&scene.materials[0].value, &scene.materials[1].value]
            else {
                panic!("{name}: {:?}", scene.materials)
            };
            assert!(std::sync::Arc::ptr_eq(&a.file.data, &b.file.data));
            assert_eq!([a.front_only, b.front_only], [name == "a.xml", false]);
            assert_eq!(b.emission_luminance > 0.0, name == "a.pbrt");
            assets.files.insert("a.bsdf".into(), file()[..99].to_vec());
            let scene = load(&assets);
            assert!(scene.warnings[0].message.contains("rendered as diffuse grey"), "{:?}", scene.warnings);
        }
    }
}
