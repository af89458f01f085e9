//! Meshes (UsdGeomMesh): polygons, primvars, subsets with their own materials.
//!
//! A value may belong to the mesh, a face, a point or a corner of a face. Corners of one point with the same values
//! share a vertex.

use std::collections::HashMap;

use turner::description::ObjectContent;
use turner::math::DVec3;
use turner::schema::{ErrorCode, MaterialId, MeshData, WarningKind};
use turner::shape::ShapeDesc;
use turner::shape::mesh::MeshDesc;

use super::materials::Colors;
use super::primvars::{Per, Primvar, integers, read, vectors};
use super::scene::{Scene, State};
use super::stage::Prim;
use super::subdivision;
use super::value::{Read, Value};
use crate::mesh::polygon::{PolygonSizes, Triangulator};
use crate::scene_import::report::Fault;

/// Most corners of all faces of a mesh.
const MAX_CORNERS: usize = 1 << 28;

/// The faces of a mesh.
pub(super) struct Faces {
    pub(super) points: Vec<[f32; 3]>,
    /// The points of all corners.
    pub(super) corners: Vec<u32>,
    /// The first corner and the number of corners of each face; faces that are holes or damaged have none.
    pub(super) faces: Vec<(usize, usize)>,
    damaged: usize,
}

impl Faces {
    fn read(scene: &Scene<'_>, prim: &Prim) -> Read<Option<Faces>> {
        let stage = scene.stage;
        let points = stage.value(prim, "points")?.as_ref().and_then(vectors::<3>).unwrap_or_default();
        let counts = integers(stage.value(prim, "faceVertexCounts")?);
        let indices = integers(stage.value(prim, "faceVertexIndices")?);
        if points.is_empty() || counts.is_empty() || indices.is_empty() || indices.len() > MAX_CORNERS {
            return Ok(None);
        }
        let mut holes = integers(stage.value(prim, "holeIndices")?);
        holes.sort_unstable();
        let corners: Vec<u32> = indices.into_iter().map(|i| u32::try_from(i).unwrap_or(u32::MAX)).collect();
        let (mut faces, mut first, mut damaged) = (Vec::with_capacity(counts.len()), 0_usize, 0);
        for (face, count) in counts.into_iter().enumerate() {
            let count = usize::try_from(count).unwrap_or(0);
            let range = first..first.saturating_add(count);
            let list = corners.get(range.clone()).unwrap_or_default();
            let finite = |i: &u32| points.get(*i as usize).is_some_and(|p| p.iter().all(|v| v.is_finite()));
            let is_sound = list.len() == count && count >= 3 && list.iter().all(finite);
            let is_hole = holes.binary_search(&(face as i64)).is_ok();
            damaged += usize::from(!is_sound && !is_hole);
            faces.push(if is_sound && !is_hole { (first, count) } else { (first, 0) });
            first = range.end;
        }
        Ok(Some(Faces { points, corners, faces, damaged }))
    }
}

/// The primvars that vertices need.
pub(super) struct Attributes {
    pub(super) normals: Option<Primvar<3>>,
    /// Texture coordinates by set; `None` for those that the mesh does not have.
    pub(super) uvs: Vec<Option<Primvar<2>>>,
    pub(super) colors: Option<Primvar<3>>,
    pub(super) opacities: Option<Primvar<1>>,
}

impl Attributes {
    /// The primvars that vertices have values of.
    fn read(scene: &Scene<'_>, prim: &Prim, sets: &[String], is_smooth: bool) -> Read<Attributes> {
        let stage = scene.stage;
        let mut normals = None;
        if !is_smooth {
            normals = read::<3>(stage, prim, "primvars:normals", Per::Point)?;
            if normals.is_none() {
                normals = read::<3>(stage, prim, "normals", Per::Point)?;
            }
        }
        let set = |name: &String| read::<2>(stage, prim, &format!("primvars:{name}"), Per::Mesh);
        Ok(Attributes {
            normals,
            uvs: sets.iter().map(set).collect::<Read<_>>()?,
            colors: read::<3>(stage, prim, "primvars:displayColor", Per::Mesh)?,
            opacities: read::<1>(stage, prim, "primvars:displayOpacity", Per::Mesh)?,
        })
    }

    /// Whether all values belong to points or to the whole mesh.
    fn is_by_point(&self) -> bool {
        fn one<const N: usize>(primvar: &Option<Primvar<N>>) -> bool {
            primvar.as_ref().is_none_or(|p| p.is_by_point() || p.per == Per::Mesh)
        }
        let uvs = self.uvs.iter().all(one);
        one(&self.normals) && uvs && one(&self.colors) && one(&self.opacities)
    }

    /// The indices of the values at a corner, to compare corners with.
    fn indices(&self, face: usize, corner: usize, point: usize, into: &mut Vec<u32>) {
        fn one<const N: usize>(p: &Option<Primvar<N>>, at: [usize; 3]) -> u32 {
            let [face, corner, point] = at;
            p.as_ref().and_then(|p| p.index(face, corner, point)).unwrap_or(u32::MAX)
        }
        let at = [face, corner, point];
        into.push(one(&self.normals, at));
        into.extend(self.uvs.iter().map(|set| one(set, at)));
        into.extend([one(&self.colors, at), one(&self.opacities, at)]);
    }

    /// Adds a vertex with the values of these indices.
    fn add(&self, mesh: &mut MeshData, position: [f32; 3], indices: &[u32]) {
        fn value<const N: usize>(p: &Option<Primvar<N>>, i: Option<&u32>) -> Option<[f32; N]> {
            let value = p.as_ref()?.values.get(*i? as usize).copied();
            value.map(|v| v.map(|c| if c.is_finite() { c } else { 0.0 }))
        }
        mesh.positions.push(position);
        if self.normals.is_some() {
            mesh.normals.push(value(&self.normals, indices.first()).unwrap_or_default());
        }
        let has_uvs = self.uvs.iter().any(Option::is_some);
        for (i, set) in self.uvs.iter().enumerate().filter(|_| has_uvs) {
            let uv = value(set, indices.get(1 + i)).unwrap_or_default();
            match i.checked_sub(1) {
                None => mesh.uvs.push(uv),
                Some(i) => {
                    if mesh.more_uvs.len() <= i {
                        mesh.more_uvs.resize(i + 1, Vec::new());
                    }
                    mesh.more_uvs[i].push(uv);
                }
            }
        }
        if self.colors.is_some() || self.opacities.is_some() {
            let at = 1 + self.uvs.len();
            let [r, g, b] = value(&self.colors, indices.get(at)).unwrap_or([1.0; 3]);
            let [a] = value(&self.opacities, indices.get(at + 1)).unwrap_or([1.0]);
            mesh.colors.push([r.max(0.0), g.max(0.0), b.max(0.0), a.clamp(0.0, 1.0)]);
        }
    }
}

/// A mesh and where its points are.
pub(super) struct Made {
    pub(super) mesh: MeshData,
    /// A vertex of each point; `u32::MAX` for those that no face has.
    pub(super) of_points: Vec<u32>,
    /// The face of each triangle.
    pub(super) faces: Vec<u32>,
    fanned: usize,
}

/// Makes vertices and triangles.
fn make(faces: &Faces, attributes: &Attributes, is_left: bool) -> Result<Made, Fault> {
    let mut made = Made {
        mesh: MeshData::default(),
        of_points: vec![u32::MAX; faces.points.len()],
        faces: Vec::new(),
        fanned: 0,
    };
    let is_simple = attributes.is_by_point();
    let mut known: HashMap<Vec<u32>, u32> = HashMap::new();
    let mut key = Vec::new();
    let mut vertex = |made: &mut Made, face: usize, corner: usize| -> u32 {
        let point = faces.corners[corner] as usize;
        if is_simple && made.of_points[point] != u32::MAX {
            return made.of_points[point];
        }
        key.clear();
        attributes.indices(face, corner, point, &mut key);
        let next = made.mesh.positions.len() as u32;
        if !is_simple {
            key.push(point as u32);
            if let Some(&old) = known.get(&key) {
                return old;
            }
            known.insert(key.clone(), next);
        }
        attributes.add(&mut made.mesh, faces.points[point], &key);
        made.of_points[point] = next;
        next
    };
    let mut cutter = Triangulator::new();
    let mut sizes = PolygonSizes::default();
    let short = |_| Fault::new(ErrorCode::TooLarge, "there is not enough memory for a mesh");
    let mut list = Vec::new();
    for (face, &(first, count)) in faces.faces.iter().enumerate() {
        // Left-handed faces run the other way around.
        let corner = |i: usize| first + if is_left { (count - i) % count } else { i };
        list.clear();
        list.extend((0..count).map(|i| vertex(&mut made, face, corner(i))));
        let before = made.mesh.triangles.len();
        let position = |i: usize| faces.points[faces.corners[corner(i)] as usize];
        let triangles = &mut made.mesh.triangles;
        cutter.cut(count, position, &mut |t| triangles.push(t.map(|i| list[i])));
        let cut = made.mesh.triangles.len() - before;
        made.faces.extend(std::iter::repeat_n(face as u32, cut));
        if cut > 1 {
            sizes.add(before, cut, "mesh").map_err(short)?;
        }
    }
    made.mesh.polygons = sizes.finish(made.mesh.triangles.len(), "mesh").map_err(short)?;
    made.fanned = cutter.fanned;
    Ok(made)
}

/// Adds a mesh.
pub(super) fn add(scene: &mut Scene<'_>, prim: &Prim, state: &State) -> Result<(), Fault> {
    scene.counts.meshes += 1;
    let Some(faces) = Faces::read(scene, prim)? else {
        scene.warn(WarningKind::Doubtful, "a mesh without points or faces");
        return Ok(());
    };
    if faces.damaged > 0 {
        let message = "faces with fewer than three corners, or with points that do not exist or are not finite: omitted";
        scene.warn(WarningKind::Doubtful, message);
    }
    let bytes = 64 * faces.corners.len() as u64 + 32 * faces.points.len() as u64;
    scene.stock.options.limits.memory.need(bytes, || prim.path.clone())?;
    if scene.stage.names(prim, "properties")?.iter().any(|name| name == "skel:skeleton") {
        scene.ignored("skeletons: meshes have their rest pose");
    }
    let subsets = subsets(scene, prim, state)?;
    let own = state.material.clone();
    let paths: Vec<Option<String>> =
        std::iter::once(own).chain(subsets.iter().map(|s| s.0.clone())).collect();
    let sets = scene.uv_sets(&paths)?;
    let scheme = subdivision::scheme(scene, prim)?;
    let attributes = Attributes::read(scene, prim, &sets, scheme.is_some())?;
    let orientation = scene.stage.value(prim, "orientation")?;
    let is_left = orientation.as_ref().and_then(Value::text) == Some("leftHanded");
    let mut made = make(&faces, &attributes, is_left)?;
    if made.mesh.triangles.is_empty() {
        return Ok(());
    }
    if made.fanned > 0 {
        scene.warn(WarningKind::Approximated, "polygons that cross themselves");
    }
    let subdivision = match scheme {
        Some(scheme) => subdivision::of(scene, prim, &made, scheme)?,
        None => None,
    };
    if subdivision.is_none() {
        made.mesh.polygons = Vec::new();
    }
    face_sides(&mut made.mesh);
    let materials = materials(scene, prim, &subsets, &paths, &sets, &mut made, &faces)?;
    let Made { mesh, .. } = made;
    let id = scene.stock.mesh(super::paths::name(&prim.path).to_owned(), mesh);
    let (own, faces) = materials;
    let subdivision = subdivision.map(Box::new);
    let desc = MeshDesc { mesh: id, materials: faces, subdivision, ..MeshDesc::default() };
    scene.place(ObjectContent::Shape(ShapeDesc::Mesh(desc)), own, prim, state.transform)
}

/// Turns normals of length 0 to the side of their triangle.
fn face_sides(mesh: &mut MeshData) {
    let is_zero = |n: &[f32; 3]| n.iter().all(|v| *v == 0.0);
    if !mesh.normals.iter().any(is_zero) {
        return;
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| DVec3::from(mesh.positions[i as usize].map(f64::from)));
        let normal = (b - a).cross(c - a).normalize_or(DVec3::Y).as_vec3().to_array();
        for i in triangle {
            if let Some(own) = mesh.normals.get_mut(*i as usize).filter(|n| is_zero(n)) {
                *own = normal;
            }
        }
    }
}

/// The materials of a mesh and of the faces of its subsets.
fn materials(
    scene: &mut Scene<'_>,
    prim: &Prim,
    subsets: &[(Option<String>, Vec<i64>)],
    paths: &[Option<String>],
    sets: &[String],
    made: &mut Made,
    faces: &Faces,
) -> Result<(Option<MaterialId>, Vec<Option<MaterialId>>), Fault> {
    let colors = Colors::of(&made.mesh);
    let ids: Vec<MaterialId> =
        paths.iter().map(|path| scene.material(path.as_deref(), sets, colors)).collect::<Result<_, _>>()?;
    if subsets.is_empty() {
        return Ok((ids.first().copied(), Vec::new()));
    }
    let mut of_faces = vec![0_u16; faces.faces.len()];
    let mut doubtful = false;
    for (i, (_, list)) in subsets.iter().enumerate() {
        for face in list {
            let place = usize::try_from(*face).ok().and_then(|face| of_faces.get_mut(face));
            doubtful |= place.is_none();
            // The first subset that has a face decides.
            if let Some(place) = place.filter(|p| **p == 0) {
                *place = (i + 1) as u16;
            }
        }
    }
    if doubtful {
        let message = format!("{}: a subset names faces that do not exist", prim.path);
        scene.warn(WarningKind::Doubtful, message);
    }
    made.mesh.face_materials = made.faces.iter().map(|face| of_faces[*face as usize]).collect();
    Ok((ids.first().copied(), ids.into_iter().map(Some).collect()))
}

/// The subsets of a mesh that bind materials, with their faces.
fn subsets(scene: &Scene<'_>, prim: &Prim, state: &State) -> Read<Vec<(Option<String>, Vec<i64>)>> {
    /// Most subsets: materials of faces are numbered in 16 bits.
    const MOST: usize = 60_000;
    let mut subsets = Vec::new();
    let stage = scene.stage;
    if stage.names(prim, "primChildren")?.is_empty() {
        return Ok(subsets);
    }
    for child in stage.children(prim)?.into_iter().take(MOST) {
        if stage.text_field(&child, "typeName")? != "GeomSubset" {
            continue;
        }
        let word = |name| Ok(stage.value(&child, name)?.and_then(|v| v.text().map(str::to_owned)));
        let family = word("familyName")?;
        let element = word("elementType")?;
        let binds = scene.bound(&child, state)?;
        // Only the family for materials binds them, but many programs omit its name.
        let is_for_materials = family.is_none_or(|f| f == "materialBind" || f.is_empty());
        if is_for_materials && element.is_none_or(|e| e == "face") && binds != state.material {
            subsets.push((binds, integers(stage.value(&child, "indices")?)));
        }
    }
    Ok(subsets)
}
