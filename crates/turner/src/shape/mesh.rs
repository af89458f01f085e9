//! Triangle meshes in the scene description.

use crate::math::{DVec2, DVec3};
use crate::schema::error::{escape, unknown_name};
use crate::schema::value::{Data, Entry, Span, Table, Value};
use crate::schema::{
    EntryDoc, ErrorCode, MaterialId, MaterialsByName, MeshData, MeshId, ParamType, ReadContext, Renumber,
    SceneError, TableReader, WriteContext, params, write, wrong_type,
};

/// Materials that replace a mesh's own.
#[derive(Clone, Debug, PartialEq)]
pub enum FaceMaterials {
    /// By the material name in the file.
    ByName(Vec<(String, Span, MaterialId)>),
    /// By index; `None` keeps the object's material.
    InOrder(Vec<Option<MaterialId>>),
}

impl ParamType for FaceMaterials {
    fn kind() -> String {
        "{ NAME = material, … } | [material | false, …]".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<FaceMaterials, SceneError> {
        match &value.data {
            Data::Table(table) => {
                let entry = |e: &Entry| Ok((e.key.clone(), e.key_span, cx.material(&e.value)?));
                table.entries.iter().map(entry).collect::<Result<_, _>>().map(FaceMaterials::ByName)
            }
            Data::Array(items) => {
                let item = |v: &Value| match v.data {
                    Data::Bool(false) => Ok(None),
                    _ => cx.material(v).map(Some),
                };
                items.iter().map(item).collect::<Result<_, _>>().map(FaceMaterials::InOrder)
            }
            _ => Err(wrong_type(value, &Self::kind())),
        }
    }
    fn show(&self) -> String {
        "materials".into()
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        match self {
            FaceMaterials::ByName(list) => MaterialsByName(list.clone()).write(cx),
            FaceMaterials::InOrder(list) => write_materials(list, cx).map(Some),
        }
    }
}

/// A list of materials; `false` stands for the object's own.
fn write_materials(list: &[Option<MaterialId>], cx: &dyn WriteContext) -> Result<Data, SceneError> {
    let one = |m: &Option<MaterialId>| m.map_or(Ok(Data::Bool(false)), |m| cx.material(m));
    Ok(write::list(list.iter().map(one).collect::<Result<Vec<_>, _>>()?))
}

/// Writes the arrays of an inline mesh.
pub(super) fn write_lists(data: &MeshData, table: &mut Table) {
    fn vectors<const N: usize>(v: &[[f32; N]]) -> Option<Data> {
        (!v.is_empty()).then(|| write::list(v.iter().map(|v| write::list(v.map(write::single)))))
    }
    let whole = |i: u32| Data::Integer(i64::from(i));
    table.push("positions", vectors(&data.positions));
    let triangles = data.triangles.iter().map(|t| write::list(t.map(whole)));
    table.push("triangles", (!data.triangles.is_empty()).then(|| write::list(triangles)));
    table.push("normals", vectors(&data.normals));
    table.push("uvs", vectors(&data.uvs));
    table.push("uvs_1", data.more_uvs.first().and_then(|set| vectors(set)));
    table.push("tangents", vectors(&data.tangents));
    table.push("colors", vectors(&data.colors));
    let faces = data.face_materials.iter().map(|m| whole(u32::from(*m)));
    table.push("face_materials", (!data.face_materials.is_empty()).then(|| write::list(faces)));
}

impl FaceMaterials {
    /// The materials by index; `None` where none is given.
    fn resolve(
        self,
        data: &MeshData,
        cx: &mut dyn ReadContext,
    ) -> Result<Vec<Option<MaterialId>>, SceneError> {
        match self {
            FaceMaterials::InOrder(list) => Ok(list),
            FaceMaterials::ByName(named) => {
                let mut list = vec![None; data.material_names.len()];
                for (name, span, material) in named {
                    let Some(i) = data.material_names.iter().position(|n| *n == name) else {
                        let names: Vec<&str> = data.material_names.iter().map(String::as_str).collect();
                        let what = "material of this mesh";
                        return Err(unknown_name(ErrorCode::UnknownName, span, what, &name, &names));
                    };
                    list[i] = Some(material);
                }
                let unassigned: Vec<String> = data
                    .material_names
                    .iter()
                    .zip(&list)
                    .filter(|(_, m)| m.is_none())
                    .map(|(n, _)| format!("\"{}\"", escape(n)))
                    .take(8)
                    .collect();
                if !unassigned.is_empty() {
                    let names = unassigned.join(", ");
                    cx.warn(
                        None,
                        format!("`materials` has no entry for the mesh's {names}: their faces get the material of the object"),
                    );
                }
                Ok(list)
            }
        }
    }
}

params! {
    /// A triangle mesh from an OBJ, PLY or STL file, or given inline. (u, v) are those of the file or of `uvs`;
    /// without any they are the barycentric weights of a triangle's second and third vertex. The geometric
    /// normal points to the side from which the vertices run counter-clockwise.
    pub struct MeshKeys as "mesh" {
        /// Path of an .obj, .ply or .stl file.
        file: Option<String> = None;
        /// Vertex positions, instead of `file`.
        positions: Option<Vec<DVec3>> = None;
        /// Triangles: three vertex indices each, from 0.
        triangles: Option<Vec<[u32; 3]>> = None;
        /// Vertex normals for smooth shading, one per vertex.
        normals: Option<Vec<DVec3>> = None;
        /// Texture coordinates (u, v), one pair per vertex.
        uvs: Option<Vec<DVec2>> = None;
        /// A second set of texture coordinates, for textures with `uv_set = 1`.
        uvs_1: Option<Vec<DVec2>> = None;
        /// Vertex tangents [x, y, z, side], one per vertex: the direction of u, and the side of the bitangent
        /// (1 or −1).
        tangents: Option<Vec<[f64; 4]>> = None;
        /// Vertex colours [r, g, b, opacity], linear, one per vertex; the texture "vertex-color" shows them.
        colors: Option<Vec<[f64; 4]>> = None;
        /// Index into `materials` for each triangle, from 0.
        face_materials: Option<Vec<u32>> = None;
        /// Materials of parts of the mesh. Either a list that `face_materials` indexes, in which `false` stands
        /// for the object's `material`; or a table from the `usemtl` names of an OBJ file to materials. Faces
        /// without an entry use the object's `material`.
        materials: Option<FaceMaterials> = None;
        /// Whether to interpolate vertex normals. By default only meshes that have normals are smooth. `true`
        /// for a mesh without normals computes them as area-weighted means of the adjacent triangles' normals;
        /// `false` shades flat facets.
        smooth: Option<bool> = None;
    }
    example r#"[[object]]
type = "mesh"
positions = [[-1, 0, 1], [1, 0, 1], [0, 0, -1], [0, 1.5, 0]]
triangles = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]]
material = { color = "salmon" }
"#
}

/// A mesh whose data are in the scene's list of meshes; by default the first one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshDesc {
    /// Index of the mesh.
    pub mesh: MeshId,
    /// Whether to interpolate vertex normals; by default if the mesh has any.
    pub smooth: Option<bool>,
    /// Materials by face material index; `None` is the object's own.
    pub materials: Vec<Option<MaterialId>>,
}

impl MeshDesc {
    /// Its documentation.
    pub const DOC: EntryDoc = MeshKeys::DOC;

    /// Renumbers the ids it refers to.
    pub fn renumber(&mut self, by: &Renumber) {
        self.mesh = by.mesh(self.mesh);
        self.materials.iter_mut().for_each(|m| *m = m.map(|m| by.material(m)));
    }

    /// The keys that [`MeshDesc::read`] reads.
    pub fn write(&self, cx: &mut dyn WriteContext) -> Result<Table, SceneError> {
        let mut table = Table::default();
        match cx.mesh(self.mesh)? {
            (_, Some(file)) => table.push("file", Data::String(file)),
            (data, None) => write_lists(data, &mut table),
        }
        if !self.materials.is_empty() {
            table.push("materials", write_materials(&self.materials, cx)?);
        }
        table.push("smooth", self.smooth.map(Data::Bool));
        Ok(table)
    }

    /// Reads its keys; adds inline data to the scene's list of meshes.
    pub fn read(table: &mut TableReader<'_>, cx: &mut dyn ReadContext) -> Result<MeshDesc, SceneError> {
        let keys = MeshKeys::read(table, cx)?;
        let (smooth, span) = (keys.smooth, table.span());
        let inline = keys.positions.is_some()
            || keys.triangles.is_some()
            || keys.normals.is_some()
            || keys.uvs.is_some()
            || keys.uvs_1.is_some()
            || keys.tangents.is_some()
            || keys.colors.is_some()
            || keys.face_materials.is_some();
        let mesh = match keys.file {
            Some(_) if inline => {
                let message = "a mesh has either a `file` or inline data such as `positions` and `triangles`";
                return Err(SceneError::at(ErrorCode::Conflict, table.span_of("file"), message)
                    .help("remove one of the two"));
            }
            Some(uri) => {
                let mesh = cx.mesh_file(&uri, table.span_of("file"))?;
                let data = cx.mesh_data(mesh);
                if data.triangles.is_empty() {
                    let (name, vertices) = (escape(&uri), data.positions.len());
                    let message =
                        format!("{name}: has {vertices} vertices but no faces; expected a mesh of polygons");
                    return Err(SceneError::at(ErrorCode::Mesh, table.span_of("file"), message)
                        .help("render a point cloud with `type = \"points\"`"));
                }
                mesh
            }
            None => {
                let (Some(positions), Some(triangles)) = (keys.positions, keys.triangles) else {
                    let message = "a mesh needs a `file`, or `positions` and `triangles`";
                    return Err(SceneError::at(ErrorCode::MissingKey, span, message)
                        .help("add `file = \"model.obj\"`"));
                };
                let single = |v: Vec<DVec3>| v.into_iter().map(|p| p.as_vec3().to_array()).collect();
                let pairs = |v: Vec<DVec2>| v.iter().map(|p| p.as_vec2().to_array()).collect();
                let fours = |v: Option<Vec<[f64; 4]>>| {
                    v.unwrap_or_default().iter().map(|p| p.map(|x| x as f32)).collect()
                };
                let faces = keys.face_materials.unwrap_or_default();
                if let Some(bad) = faces.iter().find(|m| **m > u32::from(u16::MAX)) {
                    let message = format!("a mesh has at most 65536 materials, found index {bad}");
                    let span = table.span_of("face_materials");
                    return Err(SceneError::at(ErrorCode::OutOfRange, span, message));
                }
                let data = MeshData {
                    positions: single(positions),
                    normals: single(keys.normals.unwrap_or_default()),
                    uvs: pairs(keys.uvs.unwrap_or_default()),
                    more_uvs: keys.uvs_1.map(pairs).into_iter().collect(),
                    tangents: fours(keys.tangents),
                    colors: fours(keys.colors),
                    triangles,
                    face_materials: faces.into_iter().map(|m| m as u16).collect(),
                    material_names: Vec::new(),
                };
                data.check().map_err(|e| e.or_at(Some(span)))?;
                cx.inline_mesh(data)
            }
        };
        let materials = match keys.materials {
            None => Vec::new(),
            Some(materials) => {
                let data = cx.mesh_data(mesh);
                materials.resolve(&data, cx)?
            }
        };
        Ok(MeshDesc { mesh, smooth, materials })
    }
}
