//! Meshes: one glTF primitive per material of a mesh.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};
use turner::description::{ObjectContent, ObjectDesc, SceneDesc};
use turner::math::DVec3;
use turner::schema::{ErrorCode, MaterialId, MeshData, MeshId, SceneError};
use turner::shape::ShapeDesc;

use super::Shapes;
use super::buffer::Buffer;
use super::materials::MaterialWriter;
use super::remarks::Remarks;
use super::tessellate::Tessellated;

/// Origin of a mesh: a mesh of the scene, or the tessellation of an object's shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    Mesh(u32),
    Shape(usize),
}

/// A list of a mesh, written once even if several primitives use it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum List {
    Positions,
    Normals,
    Tangents,
    Uvs(usize),
    Colors,
    /// Indices of the triangles with this face material; of all triangles if `None`.
    Triangles(Option<u16>),
}

/// Identity of a glTF mesh: its source, whether it is flat-shaded, whether it is points, and the materials of its
/// parts.
type Key = (Source, bool, bool, Vec<Option<MaterialId>>);

/// The document's meshes.
pub(super) struct MeshWriter<'a> {
    desc: &'a SceneDesc,
    shapes: &'a Shapes,
    pub(super) buffer: Buffer<'a>,
    pub(super) list: Vec<Value>,
    pub(super) materials: MaterialWriter<'a>,
    lists: BTreeMap<(Source, List), Option<usize>>,
    known: BTreeMap<Key, Option<usize>>,
}

/// Normalises in double precision; +y for zero vectors, because glTF requires unit normals.
fn direction(v: [f32; 3]) -> [f32; 3] {
    let unit = DVec3::from(v.map(f64::from)).try_normalize().unwrap_or(DVec3::Y);
    unit.as_vec3().to_array()
}

impl<'a> MeshWriter<'a> {
    pub(super) fn new(desc: &'a SceneDesc, shapes: &'a Shapes, materials: MaterialWriter<'a>) -> Self {
        MeshWriter {
            desc,
            shapes,
            buffer: Buffer::default(),
            list: Vec::new(),
            materials,
            lists: BTreeMap::new(),
            known: BTreeMap::new(),
        }
    }

    /// The index of the mesh of an object; `None` if nothing is visible. `material` applies to parts without
    /// their own. `index` is the position of the object in [`Shapes`].
    pub(super) fn number(
        &mut self,
        object: &ObjectDesc,
        index: usize,
        material: Option<MaterialId>,
        remarks: &mut Remarks,
    ) -> Result<Option<usize>, SceneError> {
        let ObjectContent::Shape(shape) = &object.content else { return Ok(None) };
        let mesh = |id: MeshId| {
            let message = "an object refers to a mesh that does not exist";
            self.desc
                .meshes
                .get(id.index())
                .map(|a| &*a.data)
                .ok_or_else(|| SceneError::new(ErrorCode::Mesh, message))
        };
        let (source, data, flat, parts, points): (Source, &'a MeshData, bool, Vec<_>, bool) = match shape {
            ShapeDesc::Mesh(m) if !m.is_refined() => {
                let data = mesh(m.mesh)?;
                if m.smooth == Some(true) && data.normals.is_empty() {
                    remarks.approximated("smooth meshes without normals: flat-shaded");
                }
                (Source::Mesh(m.mesh.0), data, m.smooth == Some(false), m.materials.clone(), false)
            }
            ShapeDesc::Points(p) => {
                remarks.approximated("point clouds: written as points without a radius");
                (Source::Mesh(p.points.0), mesh(p.points)?, true, Vec::new(), true)
            }
            other => {
                let Some(Some(Tessellated { mesh, materials })) = self.shapes.get(index) else {
                    return Ok(None);
                };
                let mut flat = false;
                match other {
                    ShapeDesc::Mesh(m) => flat = m.smooth == Some(false),
                    ShapeDesc::Plane(_) => remarks.approximated("infinite planes: written as large squares"),
                    ShapeDesc::Box(_)
                    | ShapeDesc::Rectangle(_)
                    | ShapeDesc::HeightField(_)
                    | ShapeDesc::Text(_) => {}
                    ShapeDesc::Curves(_) => remarks.approximated("curves: written as tubes with six sides"),
                    ShapeDesc::Sphere(_)
                    | ShapeDesc::Disk(_)
                    | ShapeDesc::Cylinder(_)
                    | ShapeDesc::Cone(_)
                    | ShapeDesc::Torus(_) => {
                        remarks.approximated("curved shapes: tessellated, within 0.06 % of the radius");
                    }
                    _ => remarks.approximated("solids: tessellated with 96 cells along the longest side"),
                }
                (Source::Shape(index), mesh, flat, materials.clone(), false)
            }
        };
        data.check()?;
        let mut materials: Vec<Option<MaterialId>> = parts.iter().map(|m| m.or(material)).collect();
        materials.push(material);
        let key = (source, flat, points, materials);
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let primitives = self.primitives(source, data, (flat, points), &parts, material, remarks)?;
        let number = if primitives.is_empty() {
            None
        } else {
            let mut mesh = json!({ "primitives": primitives });
            let name = match source {
                Source::Mesh(id) => {
                    self.desc.meshes.get(id as usize).map(|a| super::super::file_names::stem(&a.uri))
                }
                Source::Shape(_) => object.name.as_deref(),
            };
            if let Some(name) = name.filter(|n| !n.is_empty()) {
                mesh["name"] = json!(name);
            }
            self.list.push(mesh);
            Some(self.list.len() - 1)
        };
        self.known.insert(key, number);
        Ok(number)
    }

    fn primitives(
        &mut self,
        source: Source,
        data: &'a MeshData,
        (flat, points): (bool, bool),
        parts: &[Option<MaterialId>],
        material: Option<MaterialId>,
        remarks: &mut Remarks,
    ) -> Result<Vec<Value>, SceneError> {
        // The face materials in use.
        let mut numbers: Vec<Option<u16>> = data.face_materials.iter().map(|m| Some(*m)).collect();
        numbers.sort_unstable();
        numbers.dedup();
        if points || numbers.is_empty() {
            numbers = vec![None];
        }
        let uv_sets = if data.uvs.is_empty() || points {
            0
        } else {
            // glTF requires consecutive UV sets.
            1 + data.more_uvs.iter().take_while(|set| !set.is_empty()).count()
        };
        let mut out = Vec::new();
        for number in numbers {
            let own = number.and_then(|n| parts.get(usize::from(n)).copied().flatten());
            let indices = if points {
                None
            } else {
                let Some(indices) = self.list_number(source, List::Triangles(number), data) else { continue };
                Some(indices)
            };
            let Some(positions) = self.list_number(source, List::Positions, data) else { continue };
            let (material, shows_colors) = self.materials.number(own.or(material), uv_sets, remarks)?;
            let mut attributes = Map::new();
            attributes.insert("POSITION".into(), json!(positions));
            if !flat && let Some(normals) = self.list_number(source, List::Normals, data) {
                attributes.insert("NORMAL".into(), json!(normals));
                if self.materials.normal_mapped.contains(&material)
                    && let Some(tangents) = self.list_number(source, List::Tangents, data)
                {
                    attributes.insert("TANGENT".into(), json!(tangents));
                }
            }
            let asked_for = self.materials.uv_sets.get(material).copied().unwrap_or(0);
            for set in 0..uv_sets.min(asked_for) {
                if let Some(uvs) = self.list_number(source, List::Uvs(set), data) {
                    attributes.insert(format!("TEXCOORD_{set}"), json!(uvs));
                }
            }
            if shows_colors && let Some(colors) = self.list_number(source, List::Colors, data) {
                attributes.insert("COLOR_0".into(), json!(colors));
            }
            let mut primitive = json!({ "attributes": attributes, "material": material });
            match indices {
                Some(indices) => primitive["indices"] = json!(indices),
                None => primitive["mode"] = json!(0),
            }
            out.push(primitive);
        }
        Ok(out)
    }

    /// The accessor of a list; `None` if the list is empty.
    fn list_number(&mut self, source: Source, list: List, data: &'a MeshData) -> Option<usize> {
        if let Some(known) = self.lists.get(&(source, list)) {
            return *known;
        }
        let buffer = &mut self.buffer;
        let number = match list {
            List::Positions => (!data.positions.is_empty()).then(|| buffer.rows(&data.positions, |p| p)),
            List::Normals => (!data.normals.is_empty()).then(|| buffer.rows(&data.normals, direction)),
            List::Tangents => (!data.tangents.is_empty()).then(|| {
                buffer.rows(&data.tangents, |[x, y, z, w]| {
                    let [x, y, z] = direction([x, y, z]);
                    [x, y, z, if w < 0.0 { -1.0 } else { 1.0 }]
                })
            }),
            List::Uvs(set) => {
                let uvs = if set == 0 { Some(&data.uvs) } else { data.more_uvs.get(set - 1) };
                // In glTF v points down.
                uvs.filter(|uvs| !uvs.is_empty()).map(|uvs| buffer.rows(uvs, |[u, v]| [u, 1.0 - v]))
            }
            List::Colors => {
                (!data.colors.is_empty()).then(|| buffer.rows(&data.colors, |c| c.map(|v| v.clamp(0.0, 1.0))))
            }
            List::Triangles(None) => buffer.triangles(&data.triangles, |_| true),
            List::Triangles(Some(number)) => {
                let materials = &data.face_materials;
                buffer.triangles(&data.triangles, move |i| materials.get(i) == Some(&number))
            }
        };
        self.lists.insert((source, list), number);
        number
    }
}
