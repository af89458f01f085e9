//! Triangle meshes in the scene description.

use super::displacement::Displacement;
use super::subdivision::{MAX_LEVELS, Subdivision, SubdivisionScheme};
use crate::math::{DVec2, DVec3};
use crate::schema::error::{escape, unknown_name};
use crate::schema::value::{Data, Entry, Span, Table, Value};
use crate::schema::{
    EntryDoc, ErrorCode, ImageId, MaterialId, MaterialsByName, MeshData, MeshId, ParamType, Range,
    ReadContext, Renumber, SceneError, TableReader, WriteContext, params, write, wrong_type,
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

/// A list of vectors; `None` for an empty one.
pub(super) fn vectors<const N: usize>(v: &[[f32; N]]) -> Option<Data> {
    (!v.is_empty()).then(|| write::list(v.iter().map(|v| write::list(v.map(write::single)))))
}

/// Writes the arrays of an inline mesh.
pub(super) fn write_lists(data: &MeshData, table: &mut Table) {
    let whole = |i: u32| Data::Integer(i64::from(i));
    table.push("positions", vectors(&data.positions));
    // Polygons are read as fans.
    let fans = data.fans().filter(|_| !data.polygons.is_empty());
    if let Some(fans) = &fans {
        let polygons = fans.iter().map(|p| write::list(p.iter().map(|i| whole(*i))));
        table.push("polygons", Some(write::list(polygons)));
    } else {
        let triangles = data.triangles.iter().map(|t| write::list(t.map(whole)));
        table.push("triangles", (!data.triangles.is_empty()).then(|| write::list(triangles)));
    }
    table.push("normals", vectors(&data.normals));
    table.push("uvs", vectors(&data.uvs));
    table.push("uvs_1", data.more_uvs.first().and_then(|set| vectors(set)));
    table.push("tangents", vectors(&data.tangents));
    table.push("colors", vectors(&data.colors));
    let mut faces = data.face_materials.clone();
    if fans.is_some() {
        let mut first = 0;
        let firsts = data.polygon_triangles().map(|triangles| {
            first += triangles.len();
            first - triangles.len()
        });
        faces = firsts.filter_map(|i| data.face_materials.get(i).copied()).collect();
    }
    let faces = (!faces.is_empty()).then(|| write::list(faces.iter().map(|m| whole(u32::from(*m)))));
    table.push("face_materials", faces);
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
        /// Polygons, instead of `triangles`: three or more vertex indices each. They should be convex.
        polygons: Option<Vec<Vec<u32>>> = None;
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
        /// Index into `materials` for each triangle or polygon, from 0.
        face_materials: Option<Vec<u32>> = None;
        /// Materials of parts of the mesh. Either a list that `face_materials` indexes, in which `false` stands
        /// for the object's `material`; or a table from the `usemtl` names of an OBJ file to materials. Faces
        /// without an entry use the object's `material`.
        materials: Option<FaceMaterials> = None;
        /// Whether to interpolate vertex normals. By default only meshes that have normals are smooth. `true`
        /// for a mesh without normals computes them as area-weighted means of the adjacent triangles' normals;
        /// `false` shades flat facets.
        smooth: Option<bool> = None;
        /// Makes it a smooth surface that the mesh is the control cage of: how its faces are divided. Polygons of OBJ
        /// and PLY files and of `polygons` are divided as such. Normals and tangents of the mesh are not used. Without
        /// this key the mesh is rendered as it is.
        subdivision: Option<SubdivisionScheme> = None;
        /// How often faces are divided: each level has four times the triangles. The vertices are moved onto the
        /// surface that endless levels would have. Without this key 3.
        levels: Option<u32> = None, in Range::closed(1.0, MAX_LEVELS as f64);
        /// Edges that stay sharp: [vertex, vertex, sharpness] each, as the lists or a PLY file number the vertices. An
        /// edge of sharpness 2 is sharp for two levels, then smooth; one of 10 and more is sharp for ever. The same
        /// vertex twice is a sharp corner.
        creases: Option<Vec<[f64; 3]>> = None;
        /// Edges where the faces make a larger angle, in degrees, stay sharp for ever.
        crease_angle: Option<f64> = None, in Range::closed(0.0, 180.0);
        /// Whether vertices of only one face stay in place, so that the corners of a sheet are not rounded.
        keep_corners: Option<bool> = None;
        /// Divides edges until none is longer, in units of the object, after `subdivision` and as `displacement` has moved
        /// their ends: large faces and steep places get many triangles, others few. Without this key edges are divided
        /// only for `displacement`, to a two-hundredth of the mesh's diagonal.
        edge_length: Option<f64> = None, in Range::POSITIVE;
        /// An image that moves vertices along their normals, read at their (u, v): a height map. Values are the means of
        /// red, green and blue as stored, 0..1 but for float files; images of 16 bits or floats give smooth slopes.
        displacement: Option<ImageId> = None;
        /// How far a value of 1 moves vertices out, in units of the object. Without this key 0.1.
        displacement_scale: Option<f64> = None;
        /// The value of the image that leaves vertices in place; lower values move them in. Without this key 0.
        displacement_midlevel: Option<f64> = None;
    }
    example r#"[[object]]
type = "mesh"
positions = [[-1, 0, 1], [1, 0, 1], [0, 0, -1], [0, 1.5, 0]]
triangles = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]]
material = { color = "salmon" }
"#
}

impl MeshKeys {
    /// Whether any list is written in place.
    fn is_inline(&self) -> bool {
        self.positions.is_some()
            || self.triangles.is_some()
            || self.polygons.is_some()
            || self.normals.is_some()
            || self.uvs.is_some()
            || self.uvs_1.is_some()
            || self.tangents.is_some()
            || self.colors.is_some()
            || self.face_materials.is_some()
    }

    /// The lists.
    fn data(&mut self, table: &TableReader<'_>) -> Result<MeshData, SceneError> {
        let faces = match (self.triangles.take(), self.polygons.take()) {
            (Some(_), Some(_)) => {
                let message = "a mesh has either `triangles` or `polygons`";
                return Err(SceneError::at(ErrorCode::Conflict, table.span_of("polygons"), message)
                    .help("remove one of the two"));
            }
            (None, None) => None,
            (Some(triangles), None) => Some((triangles, Vec::new())),
            (None, Some(polygons)) => Some(fans(&polygons, table.span_of("polygons"))?),
        };
        let (Some(positions), Some((triangles, polygons))) = (self.positions.take(), faces) else {
            let message = "a mesh needs a `file`, or `positions` and `triangles` or `polygons`";
            return Err(SceneError::at(ErrorCode::MissingKey, table.span(), message)
                .help("add `file = \"model.obj\"`"));
        };
        let single = |v: Vec<DVec3>| v.into_iter().map(|p| p.as_vec3().to_array()).collect();
        let pairs = |v: Vec<DVec2>| v.iter().map(|p| p.as_vec2().to_array()).collect();
        let fours =
            |v: Option<Vec<[f64; 4]>>| v.unwrap_or_default().iter().map(|p| p.map(|x| x as f32)).collect();
        let faces = self.face_materials.take().unwrap_or_default();
        if let Some(bad) = faces.iter().find(|m| **m > u32::from(u16::MAX)) {
            let message = format!("a mesh has at most 65536 materials, found index {bad}");
            let span = table.span_of("face_materials");
            return Err(SceneError::at(ErrorCode::OutOfRange, span, message));
        }
        let mut face_materials: Vec<u16> = faces.into_iter().map(|m| m as u16).collect();
        if !polygons.is_empty() && face_materials.len() == polygons.len() {
            let all = face_materials.iter().zip(&polygons);
            face_materials = all.flat_map(|(m, n)| std::iter::repeat_n(*m, *n as usize)).collect();
        }
        Ok(MeshData {
            positions: single(positions),
            normals: single(self.normals.take().unwrap_or_default()),
            uvs: pairs(self.uvs.take().unwrap_or_default()),
            more_uvs: self.uvs_1.take().map(pairs).into_iter().collect(),
            tangents: fours(self.tangents.take()),
            colors: fours(self.colors.take()),
            triangles,
            polygons,
            face_materials,
            material_names: Vec::new(),
            ..MeshData::default()
        })
    }

    /// How it is subdivided.
    fn subdivision(&mut self, table: &TableReader<'_>) -> Result<Option<Box<Subdivision>>, SceneError> {
        let Some(scheme) = self.subdivision else {
            let of_it = [
                ("levels", self.levels.is_some()),
                ("creases", self.creases.is_some()),
                ("crease_angle", self.crease_angle.is_some()),
                ("keep_corners", self.keep_corners.is_some()),
            ];
            return match of_it.iter().find(|(_, given)| *given) {
                Some((key, _)) => {
                    let message = format!("`{key}` has no effect without `subdivision`");
                    Err(SceneError::at(ErrorCode::Conflict, table.span_of(key), message)
                        .help("add `subdivision = \"catmull_clark\"`"))
                }
                None => Ok(None),
            };
        };
        Ok(Some(Box::new(Subdivision {
            creases: self.creases.take().unwrap_or_default(),
            crease_angle: self.crease_angle,
            keep_corners: self.keep_corners.unwrap_or(false),
            ..Subdivision::new(scheme, self.levels.unwrap_or(3))
        })))
    }
}

impl MeshKeys {
    /// How it is displaced.
    fn displacement(&self, table: &TableReader<'_>) -> Result<Option<Displacement>, SceneError> {
        let Some(image) = self.displacement else {
            let of_it = [
                ("displacement_scale", self.displacement_scale.is_some()),
                ("displacement_midlevel", self.displacement_midlevel.is_some()),
            ];
            let Some((key, _)) = of_it.iter().find(|(_, given)| *given) else { return Ok(None) };
            let message = format!("`{key}` has no effect without `displacement`");
            return Err(SceneError::at(ErrorCode::Conflict, table.span_of(key), message)
                .help("name an image: `displacement = \"height.png\"`"));
        };
        let scale = self.displacement_scale.unwrap_or(0.1);
        Ok(Some(Displacement { image, scale, midlevel: self.displacement_midlevel.unwrap_or(0.0) }))
    }
}

/// Triangles of polygons, as fans around their first corners, and their number in each; none if all polygons are
/// triangles.
fn fans(polygons: &[Vec<u32>], span: Span) -> Result<(Vec<[u32; 3]>, Vec<u32>), SceneError> {
    let (mut triangles, mut counts) = (Vec::new(), Vec::with_capacity(polygons.len()));
    for (i, polygon) in polygons.iter().enumerate() {
        let [first, rest @ ..] = polygon.as_slice() else { return Err(thin(i, 0, span)) };
        if rest.len() < 2 {
            return Err(thin(i, polygon.len(), span));
        }
        triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        counts.push(rest.len() as u32 - 1);
    }
    if counts.iter().all(|n| *n == 1) {
        counts.clear();
    }
    Ok((triangles, counts))
}

fn thin(polygon: usize, corners: usize, span: Span) -> SceneError {
    let message = format!("polygon {polygon} of a mesh has {corners} vertices; expected at least 3");
    SceneError::at(ErrorCode::Mesh, span, message)
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
    /// Whether and how it is subdivided.
    pub subdivision: Option<Box<Subdivision>>,
    /// Longest edge after edges are divided, in units of the object.
    pub edge_length: Option<f64>,
    /// Whether and how vertices are displaced.
    pub displacement: Option<Displacement>,
}

impl MeshDesc {
    /// Its documentation.
    pub const DOC: EntryDoc = MeshKeys::DOC;

    /// Whether its triangles are made while a scene is prepared: by subdivision, divided edges or displacement.
    pub fn is_refined(&self) -> bool {
        self.subdivision.is_some() || self.edge_length.is_some() || self.displacement.is_some()
    }

    /// Renumbers the ids it refers to.
    pub fn renumber(&mut self, by: &Renumber) {
        self.mesh = by.mesh(self.mesh);
        self.materials.iter_mut().for_each(|m| *m = m.map(|m| by.material(m)));
        if let Some(displacement) = &mut self.displacement {
            displacement.image = by.image(displacement.image);
        }
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
        if let Some(by) = &self.subdivision {
            table.push("subdivision", by.scheme.write(cx)?);
            table.push("levels", by.levels.write(cx)?);
            let creases = (!by.creases.is_empty()).then(|| by.creases.write(cx)).transpose()?;
            table.push("creases", creases.flatten());
            table.push("crease_angle", by.crease_angle.write(cx)?);
            table.push("keep_corners", by.keep_corners.then_some(Data::Bool(true)));
        }
        table.push("edge_length", self.edge_length.write(cx)?);
        if let Some(by) = &self.displacement {
            table.push("displacement", by.image.write(cx)?);
            table.push("displacement_scale", by.scale.write(cx)?);
            table.push("displacement_midlevel", by.midlevel.write(cx)?);
        }
        Ok(table)
    }

    /// Reads its keys; adds inline data to the scene's list of meshes.
    pub fn read(table: &mut TableReader<'_>, cx: &mut dyn ReadContext) -> Result<MeshDesc, SceneError> {
        let mut keys = MeshKeys::read(table, cx)?;
        let subdivision = keys.subdivision(table)?;
        let displacement = keys.displacement(table)?;
        let (smooth, edge_length) = (keys.smooth, keys.edge_length);
        let mesh = match keys.file.take() {
            Some(_) if keys.is_inline() => {
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
                let data = keys.data(table)?;
                data.check().map_err(|e| e.or_at(Some(table.span())))?;
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
        Ok(MeshDesc { mesh, smooth, materials, subdivision, edge_length, displacement })
    }
}
