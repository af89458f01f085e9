//! PLY faces: a fast path for binary triangles and quads, and a general path for all polygons.

use turner::schema::{Warning, WarningKind};

use super::header::{self, Element, Encoding, Scalar};
use super::values::{Values, binary};
use super::{Stop, Triangulator, bad_index, skip_list};
use crate::mesh::error::{push, reserve, reserve_some};
use crate::mesh::polygon::PolygonSizes;
use crate::mesh::weld::Welder;
use crate::mesh::{MeshError, warning};

const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];
/// Property with a list of (u, v), one pair per corner.
const WEDGES: &str = "texcoord";
/// Property with the material index of a face.
const MATERIAL: &str = "material";

/// Collects triangles and counts for warnings.
pub(super) struct Faces<'a> {
    vertices: usize,
    name: &'a str,
    cutter: Triangulator,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) polygons: PolygonSizes,
    /// Material index per triangle, or empty.
    pub(super) materials: Vec<u16>,
    /// (u, v) index per corner: as many as triangles, or empty.
    pub(super) wedges: Vec<[u32; 3]>,
    /// Distinct pairs of vertex and (u, v), by their bits.
    pub(super) wedge_uvs: Welder,
    /// The (u, v) indices of the current polygon.
    numbers: Vec<u32>,
    thin: u64,
    without_wedges: u64,
}

impl<'a> Faces<'a> {
    /// An empty collection for a mesh of `vertices` vertices.
    pub(super) fn new(vertices: usize, name: &'a str) -> Faces<'a> {
        Faces {
            vertices,
            name,
            cutter: Triangulator::new(),
            triangles: Vec::new(),
            polygons: PolygonSizes::default(),
            materials: Vec::new(),
            wedges: Vec::new(),
            wedge_uvs: Welder::new(),
            numbers: Vec::new(),
            thin: 0,
            without_wedges: 0,
        }
    }

    pub(super) fn remarks(&self, warnings: &mut Vec<Warning>) {
        let all = [
            (WarningKind::Ignored, self.thin, "faces with fewer than three vertices are ignored"),
            (
                WarningKind::Note,
                self.without_wedges,
                "faces without (u, v) among faces that have them: read as (0, 0)",
            ),
            (
                WarningKind::Approximated,
                self.cutter.fanned as u64,
                "self-intersecting or very large polygons: triangulated as fans",
            ),
        ];
        let all = all.into_iter().filter(|(_, count, _)| *count > 0);
        warnings.extend(all.map(|(kind, count, message)| warning(kind, self.name, count, message)));
    }

    /// Reads the element `face`. Polygons are triangulated by their positions, if these precede the faces in the
    /// file.
    pub(super) fn read(
        &mut self,
        element: &Element,
        encoding: Encoding,
        data: &mut Values<'_>,
        positions: &[[f32; 3]],
    ) -> Result<(), Stop> {
        let is_indices = |p: &header::Property| p.count.is_some() && INDICES.contains(&p.name.as_str());
        let Some(at) = element.properties.iter().position(is_indices) else {
            if element.count == 0 {
                return Ok(());
            }
            return Err(data.fail("faces have no list \"vertex_indices\"".into()).into());
        };
        reserve(&mut self.triangles, element.count, self.name)?;
        let wedge = element.properties.iter().position(|p| p.count.is_some() && p.name == WEDGES);
        // Only integers, clamped to 65535.
        let is_material = |p: &header::Property| {
            p.count.is_none() && p.name == MATERIAL && !matches!(p.item, Scalar::F32 | Scalar::F64)
        };
        let material_at = element.properties.iter().position(is_material);
        reserve(&mut self.materials, if material_at.is_some() { element.count } else { 0 }, self.name)?;
        let mut face = 0;
        if let Some(layout) = FastFaces::of(element, at, encoding) {
            face = match encoding {
                Encoding::BigEndian => layout.read::<true>(element.count, data, self, positions),
                _ => layout.read::<false>(element.count, data, self, positions),
            };
        }
        let (mut polygon, mut uvs, mut material) = (Vec::new(), Vec::new(), 0);
        for face in face..element.count {
            for (i, property) in element.properties.iter().enumerate() {
                let Some(count) = property.count else {
                    let value = data.next(property.item)?;
                    if Some(i) == material_at {
                        material = value.clamp(0.0, f64::from(u16::MAX)) as u16;
                    }
                    continue;
                };
                if i == at {
                    polygon.clear();
                    for _ in 0..data.list_len(count, property.item)? {
                        let index = data.next(property.item)?;
                        if !(index >= 0.0 && index.fract() == 0.0 && index < self.vertices as f64) {
                            let face = face as u64 + 1;
                            let problem = bad_index("vertex", face, index as i64, self.vertices, 0);
                            return Err(data.fail(problem).into());
                        }
                        push(&mut polygon, index as u32, self.name)?;
                    }
                } else if Some(i) == wedge {
                    uvs.clear();
                    for _ in 0..data.list_len(count, property.item)? {
                        push(&mut uvs, data.next(property.item)? as f32, self.name)?;
                    }
                } else {
                    skip_list(count, property.item, data)?;
                }
            }
            let pairs = wedge.map(|_| uvs.as_slice());
            self.add(&polygon, pairs, positions)?;
            if material_at.is_some() {
                self.give_material(material)?;
            }
        }
        Ok(())
    }

    /// Assigns a material to the triangles that have none yet.
    fn give_material(&mut self, material: u16) -> Result<(), MeshError> {
        let count = self.triangles.len().saturating_sub(self.materials.len());
        reserve_some(&mut self.materials, count, self.name)?;
        self.materials.extend(std::iter::repeat_n(material, count));
        Ok(())
    }

    /// Adds the triangles of a polygon, with the (u, v) of its corners if the file has them.
    fn add(
        &mut self,
        polygon: &[u32],
        pairs: Option<&[f32]>,
        positions: &[[f32; 3]],
    ) -> Result<(), MeshError> {
        if polygon.len() < 3 {
            self.thin += 1;
            return Ok(());
        }
        let count = polygon.len() - 2;
        reserve_some(&mut self.triangles, count, self.name)?;
        if count > 1 {
            self.polygons.add(self.triangles.len(), count, self.name)?;
        }
        self.numbers.clear();
        if let Some(pairs) = pairs {
            reserve_some(&mut self.wedges, count, self.name)?;
            self.without_wedges += u64::from(pairs.len() < 2 * polygon.len());
            for (i, &vertex) in polygon.iter().enumerate() {
                let [u, v] = [0, 1].map(|k| pairs.get(2 * i + k).copied().unwrap_or_default().to_bits());
                let number = self.wedge_uvs.number([vertex, u, v], self.name)?;
                push(&mut self.numbers, number, self.name)?;
            }
        }
        let (triangles, wedges, numbers) = (&mut self.triangles, &mut self.wedges, &self.numbers);
        let position = |i: usize| positions.get(polygon[i] as usize).copied().unwrap_or_default();
        self.cutter.cut(polygon.len(), position, &mut |t| {
            triangles.push(t.map(|i| polygon[i]));
            if pairs.is_some() {
                wedges.push(t.map(|i| numbers[i]));
            }
        });
        Ok(())
    }

    /// Reads the element `tristrips`: vertex lists in which each three neighbours form a triangle, and −1 starts
    /// a new strip.
    pub(super) fn read_strips(&mut self, element: &Element, data: &mut Values<'_>) -> Result<(), Stop> {
        for _ in 0..element.count {
            for property in &element.properties {
                let Some(count) = property.count else {
                    data.next(property.item)?;
                    continue;
                };
                if !INDICES.contains(&property.name.as_str()) {
                    skip_list(count, property.item, data)?;
                    continue;
                }
                // The two previous vertices, and the number of vertices of this strip.
                let (mut before, mut read) = ([0_u32; 2], 0_u64);
                for _ in 0..data.list_len(count, property.item)? {
                    let index = data.next(property.item)?;
                    if index == -1.0 {
                        read = 0;
                        continue;
                    }
                    if !(index >= 0.0 && index.fract() == 0.0 && index < self.vertices as f64) {
                        let (face, vertices) = (self.triangles.len() as u64 + 1, self.vertices);
                        return Err(data.fail(bad_index("vertex", face, index as i64, vertices, 0)).into());
                    }
                    let [a, b] = before;
                    let c = index as u32;
                    if read >= 2 && a != b && b != c && a != c {
                        let triangle = if read.is_multiple_of(2) { [a, b, c] } else { [b, a, c] };
                        push(&mut self.triangles, triangle, self.name)?;
                    }
                    (before, read) = ([b, c], read + 1);
                }
            }
        }
        Ok(())
    }
}

/// The layout of nearly all binary files: one list of 32-bit indices with an 8-bit or 32-bit count, among properties
/// of fixed size.
struct FastFaces {
    before: usize,
    after: usize,
    count: Scalar,
    /// The material property: whether it follows the list, its byte offset from the end of the list or the start
    /// of the face, and its type.
    material: Option<(bool, usize, Scalar)>,
}

impl FastFaces {
    fn of(element: &Element, at: usize, encoding: Encoding) -> Option<FastFaces> {
        let list = element.properties.get(at)?;
        let lists = element.properties.iter().filter(|p| p.count.is_some()).count();
        let plain = encoding != Encoding::Ascii && lists == 1;
        let ints = matches!(list.item, Scalar::I32 | Scalar::U32);
        let size = |ps: &[header::Property]| ps.iter().map(|p| p.item.size()).sum();
        let (before, after) = (size(&element.properties[..at]), size(&element.properties[at + 1..]));
        let count =
            list.count.filter(|c| matches!(c, Scalar::U8 | Scalar::I8 | Scalar::I32 | Scalar::U32))?;
        let material = element.properties.iter().position(|p| p.count.is_none() && p.name == MATERIAL);
        let material = material.map(|i| {
            let from = if i > at { at + 1 } else { 0 };
            (i > at, size(&element.properties[from..i]), element.properties[i].item)
        });
        let material = material.filter(|(.., item)| !matches!(item, Scalar::F32 | Scalar::F64));
        (plain && ints).then_some(FastFaces { before, after, count, material })
    }

    /// Reads triangles and quads up to the first other or invalid face; returns the number read.
    fn read<const BIG: bool>(
        &self,
        count: usize,
        data: &mut Values<'_>,
        faces: &mut Faces<'_>,
        positions: &[[f32; 3]],
    ) -> usize {
        let bytes = data.rest();
        let word = |b: &[u8], i: usize| {
            let four = b.get(4 * i..4 * i + 4).and_then(|w| w.try_into().ok()).unwrap_or([255; 4]);
            if BIG { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) }
        };
        let (count_size, vertices) = (self.count.size(), faces.vertices);
        let (mut at, mut face) = (0, 0);
        while face < count {
            let Some(list) = bytes.get(at + self.before..) else { break };
            let n = if count_size == 1 { list.first().copied().map_or(0, u32::from) } else { word(list, 0) };
            let len = count_size + 4 * (n as usize);
            if !(n == 3 || n == 4) || list.len() < len + self.after {
                break;
            }
            let corners = &list[count_size..len];
            let [a, b, c] = [word(corners, 0), word(corners, 1), word(corners, 2)];
            let d = if n == 4 { word(corners, 3) } else { a };
            if [a, b, c, d].iter().any(|&i| i as usize >= vertices) {
                break;
            }
            if n == 4 {
                // Capacity for one triangle per face is reserved; quads need more.
                if faces.add(&[a, b, c, d], None, positions).is_err() {
                    break;
                }
            } else if faces.triangles.len() < faces.triangles.capacity()
                || faces.triangles.try_reserve(1).is_ok()
            {
                faces.triangles.push([a, b, c]);
            } else {
                break;
            }
            if let Some((behind, offset, item)) = self.material {
                let from = at + offset + if behind { self.before + len } else { 0 };
                let value = binary(bytes.get(from..).unwrap_or_default(), item, BIG);
                if faces.give_material(value.clamp(0.0, f64::from(u16::MAX)) as u16).is_err() {
                    break;
                }
            }
            at += self.before + len + self.after;
            face += 1;
        }
        data.advance(at);
        face
    }
}
