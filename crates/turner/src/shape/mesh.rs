//! Triangle meshes as a scene describes them.

use std::collections::HashMap;
use std::sync::Arc;

use super::points::{Points, PointsDesc};
use super::triangle_mesh::TriangleMesh;
use crate::math::{DVec2, DVec3};
use crate::scene::error::{escape, unknown_name};
use crate::scene::model::{MaterialsByName, Renumber};
use crate::scene::read::ReadContext;
use crate::scene::schema::{EntryDoc, ParamType, TableReader, params, wrong_type};
use crate::scene::value::{Data, Entry, Span, Table, Value};
use crate::scene::write::{self, WriteContext};
use crate::scene::{Asset, ErrorCode, MaterialId, MeshId, PrepareOptions, SceneError};

/// A mesh as a file gives it: flat lists, indices checked by [`MeshData::check`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Vertex normals: none, or one per vertex.
    pub normals: Vec<[f32; 3]>,
    /// Vertex (u, v), the first set: none, or one per vertex.
    pub uvs: Vec<[f32; 2]>,
    /// The other sets of (u, v), one per vertex each; textures choose by their number, the second set being 1.
    pub more_uvs: Vec<Vec<[f32; 2]>>,
    /// Tangents along u, and 1 or -1 for the side of the bitangent: none, or one per vertex.
    pub tangents: Vec<[f32; 4]>,
    /// Vertex colours, linear red, green, blue and opacity: none, or one per vertex.
    pub colors: Vec<[f32; 4]>,
    /// Triangles, three vertices each.
    pub triangles: Vec<[u32; 3]>,
    /// Which of the mesh's materials each triangle has: none, or one per triangle.
    pub face_materials: Vec<u16>,
    /// The names of these materials.
    pub material_names: Vec<String>,
}

impl MeshData {
    /// Refuses lists that do not fit together.
    pub fn check(&self) -> Result<(), SceneError> {
        let count = self.positions.len();
        let mut lists = vec![
            ("normals", self.normals.len()),
            ("uvs", self.uvs.len()),
            ("tangents", self.tangents.len()),
            ("colors", self.colors.len()),
        ];
        lists.extend(self.more_uvs.iter().map(|set| ("uvs", set.len())));
        for (what, found) in lists {
            if found != 0 && found != count {
                let message = format!("{found} {what} for {count} vertices of a mesh");
                return Err(SceneError::new(ErrorCode::Mesh, message)
                    .help(format!("give one per vertex, or no {what}")));
            }
        }
        for (i, triangle) in self.triangles.iter().enumerate() {
            if let Some(&bad) = triangle.iter().find(|&&v| v as usize >= count) {
                let message =
                    format!("triangle {i} of a mesh names vertex {bad}, but it has {count} vertices");
                return Err(SceneError::new(ErrorCode::Mesh, message).help("vertices are counted from 0"));
            }
        }
        let (found, count) = (self.face_materials.len(), self.triangles.len());
        if found != 0 && found != count {
            let message = format!("{found} materials for {count} triangles of a mesh");
            return Err(SceneError::new(ErrorCode::Mesh, message).help("give one per triangle, or none"));
        }
        Ok(())
    }

    /// Bytes it takes.
    pub fn memory(&self) -> usize {
        size_of_val(self)
            + size_of_val(&self.positions[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.uvs[..])
            + self.more_uvs.iter().map(|set| size_of_val(&set[..])).sum::<usize>()
            + size_of_val(&self.tangents[..])
            + size_of_val(&self.colors[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.face_materials[..])
    }

    /// How many materials its triangles tell apart, at least 1.
    pub fn material_count(&self) -> usize {
        self.face_materials.iter().map(|&m| usize::from(m) + 1).max().unwrap_or(1)
    }
}

/// Which materials take the place of a mesh's own.
#[derive(Clone, Debug, PartialEq)]
pub enum FaceMaterials {
    /// By the name in the file.
    ByName(Vec<(String, Span, MaterialId)>),
    /// By number; `None` for the object's own.
    InOrder(Vec<Option<MaterialId>>),
}

impl ParamType for FaceMaterials {
    fn kind() -> String {
        "{ NAME = material, … } | [material | false, …]".into()
    }
    fn read(value: &Value, cx: &mut ReadContext<'_>) -> Result<FaceMaterials, SceneError> {
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
    fn write(&self, cx: &mut WriteContext<'_>) -> Result<Option<Data>, SceneError> {
        match self {
            FaceMaterials::ByName(list) => MaterialsByName(list.clone()).write(cx),
            FaceMaterials::InOrder(list) => write_materials(list, cx).map(Some),
        }
    }
}

/// A list of materials, `false` for the object's own.
fn write_materials(list: &[Option<MaterialId>], cx: &WriteContext<'_>) -> Result<Data, SceneError> {
    let one = |m: &Option<MaterialId>| m.map_or(Ok(Data::Bool(false)), |m| cx.material(m));
    Ok(write::list(list.iter().map(one).collect::<Result<Vec<_>, _>>()?))
}

/// The lists of a mesh that stands in the scene itself.
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
    /// The materials by number; `None` where none is given.
    fn resolve(
        self,
        data: &MeshData,
        cx: &mut ReadContext<'_>,
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
                let left: Vec<String> = data
                    .material_names
                    .iter()
                    .zip(&list)
                    .filter(|(_, m)| m.is_none())
                    .map(|(n, _)| format!("\"{}\"", escape(n)))
                    .take(8)
                    .collect();
                if !left.is_empty() {
                    let names = left.join(", ");
                    cx.warn(
                        None,
                        format!("faces of the mesh's materials {names} take the object's material"),
                    );
                }
                Ok(list)
            }
        }
    }
}

params! {
    /// A mesh of triangles, from an OBJ, PLY or STL file or written in place. (u, v) are the file's; without any, they are the
    /// weights of a triangle's second and third vertex. The normal points to the side from which the vertices turn
    /// counter-clockwise.
    pub struct MeshKeys as "mesh" {
        /// A .obj, .ply or .stl file.
        file: Option<String> = None;
        /// Vertices, instead of `file`.
        positions: Option<Vec<DVec3>> = None;
        /// Triangles of three vertices each, counted from 0.
        triangles: Option<Vec<[u32; 3]>> = None;
        /// Normals for smooth shading, one per vertex.
        normals: Option<Vec<DVec3>> = None;
        /// Surface coordinates, one pair per vertex.
        uvs: Option<Vec<DVec2>> = None;
        /// A second set of surface coordinates, for textures with `uv_set = 1`.
        uvs_1: Option<Vec<DVec2>> = None;
        /// Tangents along u and the side of the bitangent (1 or −1), one per vertex.
        tangents: Option<Vec<[f64; 4]>> = None;
        /// Colours [r, g, b, opacity], one per vertex; shown by the texture "vertex-color".
        colors: Option<Vec<[f64; 4]>> = None;
        /// Which of `materials` each triangle has, counted from 0.
        face_materials: Option<Vec<u32>> = None;
        /// Materials for parts of the mesh: a list for `face_materials`, `false` in it for the object's own; or a table by the names after `usemtl` in an OBJ
        /// file. What is not named here takes the object's `material`.
        materials: Option<FaceMaterials> = None;
        /// Whether to shade with vertex normals. If not given: where the mesh has normals. `true` for a mesh without normals
        /// computes them from the triangles around each vertex, weighted by area; `false` shows every facet.
        smooth: Option<bool> = None;
    }
    example r#"[[object]]
type = "mesh"
positions = [[-1, 0, 1], [1, 0, 1], [0, 0, -1], [0, 1.5, 0]]
triangles = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]]
material = { color = "salmon" }
"#
}

/// A mesh, its data in the scene's list.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshDesc {
    /// Which mesh.
    pub mesh: MeshId,
    /// Whether to shade with vertex normals; by default if the mesh has any.
    pub smooth: Option<bool>,
    /// Materials by the number that triangles have; the object's where there is none.
    pub materials: Vec<Option<MaterialId>>,
}

impl MeshDesc {
    /// Its documentation.
    pub const DOC: EntryDoc = MeshKeys::DOC;

    /// Moves the numbers of things it refers to.
    pub fn renumber(&mut self, by: &Renumber) {
        self.mesh = by.mesh(self.mesh);
        self.materials.iter_mut().for_each(|m| *m = m.map(|m| by.material(m)));
    }

    /// Its keys: what [`MeshDesc::read`] reads.
    pub fn write(&self, cx: &mut WriteContext<'_>) -> Result<Table, SceneError> {
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

    /// Reads its keys; puts data written in place into the scene's list of meshes.
    pub fn read(table: &mut TableReader<'_>, cx: &mut ReadContext<'_>) -> Result<MeshDesc, SceneError> {
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
                let message = "a mesh has either a `file` or `positions`, `triangles`, `normals`, `uvs` and so on in place";
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
                        .help("show a cloud of points as `type = \"points\"`"));
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
                    let message = format!("a mesh has at most 65536 materials, found number {bad}");
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

/// Bytes that a vertex takes while its normal is computed.
const NORMAL_MADE: u64 = 36;

/// The meshes of a scene, prepared at first use and then shared by all objects that show them the same way.
#[derive(Debug)]
pub struct MeshCache<'a> {
    meshes: &'a [Asset<MeshData>],
    options: PrepareOptions,
    prepared: HashMap<(MeshId, bool), Arc<TriangleMesh>>,
    points_left_out: Vec<String>,
    /// Of triangles with a vertex that is not finite, of those without area, and of meshes without any others.
    left_out: [Without; 3],
}

/// What was left out of meshes: how many triangles, of how many meshes, and the first of these.
#[derive(Debug, Default)]
struct Without {
    triangles: usize,
    meshes: usize,
    first: String,
}

impl Without {
    fn add(&mut self, triangles: usize, name: &str) {
        self.triangles += triangles;
        self.meshes += 1;
        if self.meshes == 1 {
            self.first = match name {
                "" => "a mesh".to_owned(),
                name => format!("the mesh \"{}\"", crate::scene::error::escape(name)),
            };
        }
    }

    /// The meshes, in words.
    fn meshes(&self) -> String {
        match self.meshes {
            1 => self.first.clone(),
            n => format!("{n} meshes, the first of them {}", self.first),
        }
    }
}

impl<'a> MeshCache<'a> {
    /// Over the scene's list, by [`MeshId`].
    pub fn new(meshes: &'a [Asset<MeshData>]) -> MeshCache<'a> {
        MeshCache::with_options(meshes, &PrepareOptions::default())
    }

    /// The same, and how to build trees.
    pub fn with_options(meshes: &'a [Asset<MeshData>], options: &PrepareOptions) -> MeshCache<'a> {
        MeshCache {
            meshes,
            options: options.clone(),
            prepared: HashMap::new(),
            points_left_out: Vec::new(),
            left_out: Default::default(),
        }
    }

    /// What was left out of the meshes prepared so far: a sentence for each kind.
    pub fn warnings(&self) -> Vec<String> {
        let mut out = self.points_left_out.clone();
        let [infinite, flat, empty] = &self.left_out;
        for (without, why) in [(infinite, "with a vertex that is not finite"), (flat, "without area")] {
            let triangles = if without.triangles == 1 { "triangle" } else { "triangles" };
            if without.meshes > 0 {
                out.push(format!("{} {triangles} {why} left out of {}", without.triangles, without.meshes()));
            }
        }
        if empty.meshes > 0 {
            let verb = if empty.meshes == 1 { "has" } else { "have" };
            let meshes = if empty.meshes == 1 { empty.meshes() } else { empty.meshes() + "," };
            out.push(format!("{meshes} {verb} no triangles to show"));
        }
        out
    }

    /// The meshes prepared so far.
    pub fn prepared(&self) -> impl Iterator<Item = &Arc<TriangleMesh>> {
        self.prepared.values()
    }

    /// The points an object shows.
    pub fn points(&mut self, desc: &PointsDesc) -> Result<Arc<Points>, SceneError> {
        let points = Arc::new(desc.prepare(self.meshes, &self.options)?);
        let left_out =
            self.meshes.get(desc.points.index()).map_or(0, |a| a.data.positions.len()) - points.count();
        if left_out > 0 {
            self.points_left_out
                .push(format!("{left_out} points that are not finite, or without a radius, left out"));
        }
        Ok(points)
    }

    /// The mesh an object shows.
    pub fn get(&mut self, desc: &MeshDesc) -> Result<Arc<TriangleMesh>, SceneError> {
        let Some(asset) = self.meshes.get(desc.mesh.index()) else {
            let message =
                format!("an object names mesh {}, but the scene has {}", desc.mesh.0, self.meshes.len());
            return Err(SceneError::new(ErrorCode::Mesh, message));
        };
        let smooth = desc.smooth.unwrap_or(!asset.data.normals.is_empty());
        if let Some(mesh) = self.prepared.get(&(desc.mesh, smooth)) {
            return Ok(Arc::clone(mesh));
        }
        if smooth && asset.data.normals.is_empty() {
            let bytes = (asset.data.positions.len() as u64).saturating_mul(NORMAL_MADE);
            self.options.limits.memory.need(bytes, || "computing normals".to_owned())?;
        }
        let (mesh, left_out) = TriangleMesh::without_tree(&asset.data, smooth)?;
        // Once per mesh, not once for each way it is shaded.
        if !self.prepared.contains_key(&(desc.mesh, !smooth)) {
            let [infinite, flat, empty] = &mut self.left_out;
            for (without, count) in [(infinite, left_out.non_finite), (flat, left_out.flat)] {
                if count > 0 {
                    without.add(count, &asset.uri);
                }
            }
            if mesh.triangle_count() == 0 {
                empty.add(0, &asset.uri);
            }
        }
        let mesh = Arc::new(mesh);
        self.prepared.insert((desc.mesh, smooth), Arc::clone(&mesh));
        Ok(mesh)
    }
}
