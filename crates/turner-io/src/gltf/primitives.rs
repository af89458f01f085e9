//! Converts a primitive to a mesh: attributes, morph targets, skinning, faces, tangents.

use turner::math::{DAffine3, DMat3, DVec3};
use turner::schema::MeshData;

use super::accessors::Elements;
use super::budget::Budget;
use super::buffers::Buffers;
use super::draco::Unpacked;
use super::fault::{Fault, Outcome};
use super::json::{Document, Index, Primitive};
use super::report::Report;
use super::skins::Influences;
use super::topology::Topology;
use super::{tangents, tubes};

/// Most UV sets that are kept.
const MAX_UV_SETS: usize = 8;

/// Coordinates beyond this are reported: single precision can no longer separate neighbouring vertices.
const HUGE: f32 = 1e9;

/// How to convert a primitive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request<'a> {
    /// Weights of the morph targets.
    pub(super) weights: &'a [f64],
    /// The joint matrices of the skin; the mesh is then in world space.
    pub(super) joints: Option<&'a [DAffine3]>,
    /// The UV set of its normal map, if it has one.
    pub(super) normal_map: Option<usize>,
    /// A transform applied to the vertices last: for nodes whose transform has no inverse.
    pub(super) bake: Option<DAffine3>,
}

/// A converted primitive.
#[derive(Debug)]
pub(super) struct Shaped {
    /// The mesh.
    pub(super) mesh: MeshData,
    /// Whether to shade with vertex normals.
    pub(super) smooth: bool,
    /// Whether it is a point cloud, without triangles.
    pub(super) is_cloud: bool,
}

/// Converts a primitive. `pointer` is its JSON pointer. `None` if it cannot be rendered; the report says why.
pub(super) fn shape(
    document: &Document,
    buffers: &Buffers,
    primitive: &Primitive,
    request: Request<'_>,
    (budget, report): (&Budget, &mut Report),
    pointer: &str,
) -> Outcome<Option<Shaped>> {
    let Some(position) = primitive.attributes.get("POSITION") else {
        report.ignored("a primitive without positions");
        return Ok(None);
    };
    let unpacked = Unpacked::read(document, buffers, primitive, (budget, report), pointer)?;
    let source =
        Source { document, buffers, primitive, unpacked: unpacked.as_ref(), request, budget, pointer };
    let positions = source.vertices("POSITION", *position, pointer)?.with_width(&[3], "positions")?;
    let count = positions.count;
    let (mut topology, left_over) = source.topology(count)?;
    if left_over {
        report.doubtful("surplus vertices after the last complete line or triangle");
    }
    let chosen = topology.compact(count, budget, pointer)?;
    let vertices = Vertices { chosen: chosen.as_deref(), count };

    let mut mesh = source.attributes(positions, &vertices, report)?;
    let mut mirrored = source.skin(&mut mesh, &vertices, report)?;
    if let Some(matrix) = request.bake {
        mirrored ^= transform(&mut mesh, |_| Ok::<_, Fault>(matrix))?;
    }
    if mesh.positions.iter().flatten().any(|x| x.abs() > HUGE) {
        report.doubtful("coordinates beyond 1e9, where single precision is inaccurate");
    }
    let mut mesh = match topology {
        Topology::Triangles(mut list) => {
            if mirrored {
                list.iter_mut().for_each(|t| t.swap(1, 2));
            }
            mesh.triangles = list;
            mesh
        }
        Topology::Points(list) => {
            report.approximated("points: rendered as small spheres");
            return Ok(Some(Shaped {
                mesh: cloud(mesh, list, budget, pointer)?,
                smooth: true,
                is_cloud: true,
            }));
        }
        Topology::Lines(list) => {
            report.approximated("lines: rendered as thin tubes");
            tubes::tubes(&mesh, &list, budget, pointer)?
        }
    };
    let flat = mesh.normals.is_empty();
    if !flat && turned_away(&mesh) {
        report.doubtful("a mesh whose normals oppose most of its faces");
    }
    match request.normal_map {
        Some(set) if mesh.tangents.is_empty() => {
            if flat && !mesh.uvs.is_empty() {
                tangents::flatten(&mut mesh, budget, pointer)?;
            }
            tangents::generate(&mut mesh, set, budget, pointer)?;
        }
        _ => {}
    }
    Ok(Some(Shaped { smooth: !flat, is_cloud: false, mesh }))
}

/// A point cloud of the listed vertices, without non-finite ones.
fn cloud(mut mesh: MeshData, mut list: Vec<u32>, budget: &Budget, pointer: &str) -> Outcome<MeshData> {
    list.retain(|v| mesh.positions[*v as usize].iter().all(|x| x.is_finite()));
    budget.take(list.len(), tangents::vertex_size(&mesh), pointer)?;
    tangents::take_vertices(&mut mesh, &list);
    Ok(mesh)
}

/// Whether most triangles have vertex normals on their back side.
fn turned_away(mesh: &MeshData) -> bool {
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let away = |t: &&[u32; 3]| {
        let [a, b, c] = t.map(|v| vector(mesh.positions[v as usize]));
        let normal = t.iter().map(|v| vector(mesh.normals[*v as usize])).sum::<DVec3>();
        (b - a).cross(c - a).dot(normal) < 0.0
    };
    2 * mesh.triangles.iter().filter(away).count() > mesh.triangles.len()
}

/// The vertices to keep: those listed, or all.
struct Vertices<'a> {
    chosen: Option<&'a [u32]>,
    count: usize,
}

impl Vertices<'_> {
    fn len(&self) -> usize {
        self.chosen.map_or(self.count, <[u32]>::len)
    }

    /// Their indices in the accessors.
    fn numbers(&self) -> impl Iterator<Item = usize> {
        (0..self.len()).map(|i| self.chosen.map_or(i, |list| list[i] as usize))
    }
}

struct Source<'a> {
    document: &'a Document,
    buffers: &'a Buffers,
    primitive: &'a Primitive,
    /// Its Draco mesh.
    unpacked: Option<&'a Unpacked>,
    request: Request<'a>,
    budget: &'a Budget,
    pointer: &'a str,
}

impl<'a> Source<'a> {
    /// Opens an attribute, from the Draco mesh if it is there.
    fn vertices(&self, name: &str, at: Index, pointer: &str) -> Outcome<Elements<'a>> {
        match self.unpacked.and_then(|unpacked| unpacked.attribute(name)) {
            Some(bytes) => Elements::open_with(self.document, self.buffers, at, bytes, pointer),
            None => Elements::open(self.document, self.buffers, at, pointer),
        }
    }

    /// The elements of the primitive with `count` vertices, and whether vertices are left over.
    fn topology(&self, count: usize) -> Outcome<(Topology, bool)> {
        if let Some(unpacked) = self.unpacked {
            return Topology::of_faces(&unpacked.faces, count, self.budget, self.pointer);
        }
        let open = |at| Elements::open(self.document, self.buffers, at, self.pointer);
        let indices = self.primitive.indices.map(open).transpose()?;
        let mode = self.primitive.mode.map_or(4, |m| m.0);
        Topology::read(mode, indices, count, self.budget, self.pointer)
    }

    /// An attribute of the kept vertices, with morph targets applied; empty if the primitive lacks it.
    fn attribute<const N: usize>(
        &self,
        name: &str,
        widths: &[usize],
        vertices: &Vertices<'_>,
    ) -> Outcome<Vec<[f32; N]>> {
        let Some(at) = self.primitive.attributes.get(name) else { return Ok(Vec::new()) };
        let elements = self.vertices(name, *at, self.pointer)?;
        let elements = elements.with_width(widths, name)?.with_count(vertices.count, name)?;
        self.morphed(elements, name, vertices)
    }

    /// The elements of an attribute plus the weighted displacements of the morph targets (§3.7.2.2).
    fn morphed<const N: usize>(
        &self,
        elements: Elements<'_>,
        name: &str,
        vertices: &Vertices<'_>,
    ) -> Outcome<Vec<[f32; N]>> {
        let mut list = self.budget.list(vertices.len(), self.pointer)?;
        list.extend(vertices.numbers().map(|i| elements.get::<N>(i)));
        for (target, weight) in self.primitive.targets.iter().zip(self.request.weights) {
            let Some(at) = target.get(name).filter(|_| *weight != 0.0) else { continue };
            // Morph targets of tangents have no fourth component; the handedness does not change.
            let width = if name == "TANGENT" { 3 } else { elements.width };
            let deltas = Elements::open(self.document, self.buffers, *at, self.pointer)?;
            let what = "a morph target";
            let deltas = deltas.with_width(&[width], what)?.with_count(vertices.count, what)?;
            for (value, i) in list.iter_mut().zip(vertices.numbers()) {
                let delta = deltas.get::<N>(i);
                for (v, d) in value.iter_mut().zip(delta) {
                    *v += (*weight * f64::from(d)) as f32;
                }
            }
        }
        Ok(list)
    }

    fn attributes(
        &self,
        positions: Elements<'_>,
        vertices: &Vertices<'_>,
        report: &mut Report,
    ) -> Outcome<MeshData> {
        let mut mesh =
            MeshData { positions: self.morphed(positions, "POSITION", vertices)?, ..MeshData::default() };
        mesh.normals = self.attribute("NORMAL", &[3], vertices)?;
        let morphed = self.request.weights.iter().any(|w| *w != 0.0);
        if morphed {
            mesh.normals.iter_mut().for_each(normalize);
        }
        // Tangents without normals must be ignored (§3.7.2.1).
        if !mesh.normals.is_empty() {
            mesh.tangents = self.attribute("TANGENT", &[4], vertices)?;
        }
        let sets =
            (0..MAX_UV_SETS).rev().find(|set| self.attributes_of("TEXCOORD_", *set)).map_or(0, |s| s + 1);
        for set in 0..sets {
            let mut uvs: Vec<[f32; 2]> = self.attribute(&format!("TEXCOORD_{set}"), &[2], vertices)?;
            // In glTF v points down, in Turner up.
            uvs.iter_mut().for_each(|uv| uv[1] = 1.0 - uv[1]);
            if set == 0 { mesh.uvs = uvs } else { mesh.more_uvs.push(uvs) }
        }
        if self.attributes_of("TEXCOORD_", MAX_UV_SETS) {
            report.ignored("texture coordinate sets beyond the eighth");
        }
        mesh.colors = self.attribute("COLOR_0", &[3, 4], vertices)?;
        let opaque =
            self.primitive.attributes.get("COLOR_0").and_then(|at| self.document.accessors.get(at.index()));
        if opaque.is_some_and(|a| a.kind.as_deref() == Some("VEC3")) {
            mesh.colors.iter_mut().for_each(|color| color[3] = 1.0);
        }
        mesh.colors.iter_mut().flatten().for_each(|c| *c = if *c > 0.0 { c.min(f32::MAX) } else { 0.0 });
        if self.attributes_of("COLOR_", 1) {
            report.ignored("vertex colours beyond the first set");
        }
        Ok(mesh)
    }

    fn attributes_of(&self, prefix: &str, set: usize) -> bool {
        self.primitive.attributes.contains_key(&format!("{prefix}{set}"))
    }

    /// Skins the vertices. Returns whether that mirrors the mesh.
    fn skin(&self, mesh: &mut MeshData, vertices: &Vertices<'_>, report: &mut Report) -> Outcome<bool> {
        let Some(joints) = self.request.joints else { return Ok(false) };
        let open = |name: &str, at, pointer: &str| self.vertices(name, at, pointer);
        let influences = Influences::open(self.primitive, vertices.count, self.pointer, open)?;
        if influences.is_empty() {
            report.doubtful("a skinned primitive has no joints");
            return Ok(false);
        }
        let mut numbers = vertices.numbers();
        transform(mesh, |_| {
            let vertex = numbers.next().unwrap_or(0);
            influences.matrix(vertex, joints).map_err(|joint| {
                let message =
                    format!("vertex {vertex} uses joint {joint}, but the skin has {}", joints.len());
                Fault::at(format!("{}/attributes/JOINTS_0", self.pointer), message)
            })
        })
    }
}

fn normalize(v: &mut [f32; 3]) {
    *v = DVec3::from(v.map(f64::from)).normalize_or_zero().as_vec3().to_array();
}

/// The matrix for normals: the cofactor matrix, which equals the inverse transpose up to a positive factor and exists
/// for singular matrices too.
fn normal_matrix(m: &DMat3) -> DMat3 {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let side = if x.dot(y.cross(z)) < 0.0 { -1.0 } else { 1.0 };
    DMat3::from_cols(y.cross(z) * side, z.cross(x) * side, x.cross(y) * side)
}

/// Transforms each vertex by its own matrix. Returns whether most matrices mirror; front faces are then clockwise
/// (§3.7.4) until the triangles are reversed.
fn transform<E>(
    mesh: &mut MeshData,
    mut matrix: impl FnMut(usize) -> Result<DAffine3, E>,
) -> Result<bool, E> {
    let mut mirrored = 0;
    for i in 0..mesh.positions.len() {
        let m = matrix(i)?;
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        mesh.positions[i] = m.transform_point3(wide(mesh.positions[i])).as_vec3().to_array();
        if let Some(normal) = mesh.normals.get_mut(i) {
            *normal = (normal_matrix(&m.matrix3) * wide(*normal)).normalize_or_zero().as_vec3().to_array();
        }
        let mirrors = m.matrix3.determinant() < 0.0;
        mirrored += usize::from(mirrors);
        if let Some([x, y, z, side]) = mesh.tangents.get_mut(i) {
            let tangent = (m.matrix3 * wide([*x, *y, *z])).normalize_or_zero();
            [*x, *y, *z] = tangent.as_vec3().to_array();
            *side = if mirrors { -*side } else { *side };
        }
    }
    Ok(2 * mirrored > mesh.positions.len())
}
