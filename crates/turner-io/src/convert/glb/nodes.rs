//! The node hierarchy.

use serde_json::{Map, Value, json};
use turner::description::{ObjectContent, ObjectDesc, SceneDesc};
use turner::math::{Bounds, DAffine3, DMat3, DVec3};
use turner::schema::{ErrorCode, GroupId, MaterialId, SceneError};
use turner::shape::ShapeDesc;

use super::Shapes;
use super::meshes::MeshWriter;
use super::remarks::Remarks;

/// Most nodes of a file.
const MAX_NODES: usize = 4_000_000;
/// Deepest nesting of groups.
const MAX_DEPTH: u32 = 64;

/// The document's nodes.
#[derive(Debug, Default)]
pub(super) struct Nodes {
    pub(super) list: Vec<Value>,
    pub(super) roots: Vec<usize>,
    /// What nodes place, of those that a keyframe can move.
    pub(super) sources: Vec<(Source, usize)>,
}

/// What a node places.
#[derive(Clone, Copy, Debug)]
pub(super) enum Source {
    /// An object, by its index among those of all groups and then those of the scene.
    Object(usize),
    /// The camera of the scene, then the other cameras.
    Camera(usize),
    /// A light.
    Light(usize),
}

/// A factorisation outer · scale · inner of a matrix, with rotations `outer` and `inner`.
pub(super) struct Parts {
    pub(super) outer: DMat3,
    pub(super) scale: DVec3,
    pub(super) inner: Option<DMat3>,
}

/// Factors a matrix as outer · scale · inner. Without shear, `inner` is `None`. With shear this is the singular value
/// decomposition, from the eigenvectors of MᵀM by Jacobi rotations.
pub(super) fn parts(m: &DMat3) -> Parts {
    let columns = [m.x_axis, m.y_axis, m.z_axis];
    let mut gram = m.transpose() * *m;
    let product = |a: usize, b: usize| {
        columns[a].dot(columns[b]).abs() <= 1e-7 * columns[a].length() * columns[b].length()
    };
    let is_plain = product(0, 1) && product(1, 2) && product(2, 0);
    let mut inner = DMat3::IDENTITY;
    if !is_plain {
        for _ in 0..60 {
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                let off = gram.col(q)[p];
                if off.abs() <= 1e-300 {
                    continue;
                }
                let theta = (gram.col(q)[q] - gram.col(p)[p]) / (2.0 * off);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                let mut j = DMat3::IDENTITY;
                j.col_mut(p)[p] = c;
                j.col_mut(q)[q] = c;
                j.col_mut(q)[p] = s;
                j.col_mut(p)[q] = -s;
                gram = j.transpose() * gram * j;
                inner *= j;
            }
        }
    }
    // The columns are now orthogonal: their lengths are the scale, their directions the outer rotation.
    let turned = *m * inner;
    let mut scale = DVec3::new(turned.x_axis.length(), turned.y_axis.length(), turned.z_axis.length());
    let x = turned.x_axis.normalize_or(DVec3::X);
    let y = (turned.y_axis - x * x.dot(turned.y_axis)).normalize_or(x.any_orthonormal_vector());
    let z = x.cross(y);
    if turned.determinant() < 0.0 {
        scale.z = -scale.z;
    }
    Parts { outer: DMat3::from_cols(x, y, z), scale, inner: (!is_plain).then(|| inner.transpose()) }
}

/// The unit quaternion (x, y, z, w) of a rotation matrix (Shepperd 1978).
pub(super) fn quaternion(m: &DMat3) -> [f64; 4] {
    let at = |row: usize, column: usize| m.col(column)[row];
    let trace = at(0, 0) + at(1, 1) + at(2, 2);
    let q = if trace > 0.0 {
        let s = 2.0 * (trace + 1.0).sqrt();
        [(at(2, 1) - at(1, 2)) / s, (at(0, 2) - at(2, 0)) / s, (at(1, 0) - at(0, 1)) / s, 0.25 * s]
    } else {
        // Start from the largest diagonal element, so that the divisor is not small.
        let i = if at(0, 0) >= at(1, 1) && at(0, 0) >= at(2, 2) {
            0
        } else {
            1 + usize::from(at(2, 2) > at(1, 1))
        };
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let s = 2.0 * (1.0 + at(i, i) - at(j, j) - at(k, k)).max(0.0).sqrt();
        let mut q = [0.0; 4];
        q[i] = 0.25 * s;
        q[j] = (at(j, i) + at(i, j)) / s;
        q[k] = (at(k, i) + at(i, k)) / s;
        q[3] = (at(k, j) - at(j, k)) / s;
        q
    };
    let length = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    q.map(|v| v / length)
}

/// Inserts translation, rotation and scale where they differ from the defaults.
fn place(node: &mut Map<String, Value>, translation: DVec3, parts: &Parts) {
    if translation != DVec3::ZERO {
        node.insert("translation".into(), json!(translation.to_array()));
    }
    let rotation = quaternion(&parts.outer);
    if rotation != [0.0, 0.0, 0.0, 1.0] {
        node.insert("rotation".into(), json!(rotation));
    }
    if parts.scale != DVec3::ONE {
        node.insert("scale".into(), json!(parts.scale.to_array()));
    }
}

impl Nodes {
    fn push(&mut self, node: Map<String, Value>) -> Result<usize, SceneError> {
        if self.list.len() >= MAX_NODES {
            let message = format!("the scene needs more than {MAX_NODES} glTF nodes");
            return Err(SceneError::new(ErrorCode::TooLarge, message)
                .help("convert to a .toml file, which stores each group once"));
        }
        self.list.push(Value::Object(node));
        Ok(self.list.len() - 1)
    }

    /// Adds a node with a transform. A transform with shear needs a second, inner node.
    fn placed(
        &mut self,
        name: Option<&str>,
        transform: &DAffine3,
        mut content: Map<String, Value>,
    ) -> Result<usize, SceneError> {
        let parts = parts(&transform.matrix3);
        let mut node = Map::new();
        if let Some(inner) = &parts.inner {
            content.insert("rotation".into(), json!(quaternion(inner)));
            let child = self.push(content)?;
            node.insert("children".into(), json!([child]));
        } else {
            node = content;
        }
        if let Some(name) = name {
            node.insert("name".into(), json!(name));
        }
        place(&mut node, transform.translation, &parts);
        self.push(node)
    }

    /// Adds a root node with one member, such as a camera. The transform must not have shear.
    pub(super) fn root(
        &mut self,
        (name, source): (Option<&str>, Source),
        transform: &DAffine3,
        key: &str,
        value: Value,
    ) -> bool {
        let mut content = Map::new();
        content.insert(key.into(), value);
        let Ok(node) = self.placed(name, transform, content) else { return false };
        self.roots.push(node);
        self.sources.push((source, node));
        true
    }

    /// Adds all objects of a scene.
    pub(super) fn objects(
        &mut self,
        desc: &SceneDesc,
        meshes: &mut MeshWriter<'_>,
        remarks: &mut Remarks,
    ) -> Result<(), SceneError> {
        // The index of each group's first object in `Shapes`.
        let mut firsts = Vec::with_capacity(desc.groups.len());
        let mut count = 0;
        for group in &desc.groups {
            firsts.push(count);
            count += group.value.objects.len();
        }
        let mut job = Job { desc, firsts, meshes, remarks };
        for (i, object) in desc.objects.iter().enumerate() {
            if let Some(node) = self.object(object, count + i, None, 0, &mut job)? {
                self.roots.push(node);
            }
        }
        Ok(())
    }

    fn object(
        &mut self,
        object: &ObjectDesc,
        index: usize,
        material: Option<MaterialId>,
        depth: u32,
        job: &mut Job<'_, '_>,
    ) -> Result<Option<usize>, SceneError> {
        if object.motion.is_some() {
            job.remarks.ignored("motion blur");
        }
        let material = object.material.or(material);
        let mut content = Map::new();
        match &object.content {
            ObjectContent::Shape(_) => {
                let Some(mesh) = job.meshes.number(object, index, material, job.remarks)? else {
                    return Ok(None);
                };
                content.insert("mesh".into(), json!(mesh));
            }
            ObjectContent::Instance(group) => {
                let children = self.group(*group, material, depth, job)?;
                if children.is_empty() {
                    return Ok(None);
                }
                content.insert("children".into(), json!(children));
            }
        }
        let node = self.placed(object.name.as_deref(), &object.transform.0, content)?;
        self.sources.push((Source::Object(index), node));
        Ok(Some(node))
    }

    fn group(
        &mut self,
        id: GroupId,
        material: Option<MaterialId>,
        depth: u32,
        job: &mut Job<'_, '_>,
    ) -> Result<Vec<usize>, SceneError> {
        if depth >= MAX_DEPTH {
            let message = format!("groups contain themselves or are nested deeper than {MAX_DEPTH}");
            return Err(SceneError::new(ErrorCode::Cycle, message));
        }
        let desc = job.desc;
        let (Some(group), Some(first)) = (desc.groups.get(id.index()), job.firsts.get(id.index()).copied())
        else {
            let message = format!("an object places group {}, which does not exist", id.0);
            return Err(SceneError::new(ErrorCode::UnknownName, message));
        };
        let mut children = Vec::new();
        for (i, object) in group.value.objects.iter().enumerate() {
            children.extend(self.object(object, first + i, material, depth + 1, job)?);
        }
        Ok(children)
    }
}

/// Context shared by all objects.
struct Job<'j, 'a> {
    desc: &'j SceneDesc,
    firsts: Vec<usize>,
    meshes: &'j mut MeshWriter<'a>,
    remarks: &'j mut Remarks,
}

/// Half the side of infinite planes: twenty times the extent of all other objects and the cameras.
pub(super) fn reach(desc: &SceneDesc, shapes: &Shapes) -> f64 {
    let mut bounds = Bounds::EMPTY;
    let mut add = |p: DVec3| bounds = bounds.union(&Bounds { min: p, max: p });
    let first = shapes.len() - desc.objects.len().min(shapes.len());
    for (object, shape) in desc.objects.iter().zip(shapes.iter().skip(first)) {
        let data = match (&object.content, shape) {
            (ObjectContent::Shape(ShapeDesc::Mesh(m)), None) => {
                desc.meshes.get(m.mesh.index()).map(|a| &*a.data)
            }
            (_, shape) => shape.as_ref().map(|shape| &shape.mesh),
        };
        let points = data.into_iter().flat_map(|d| &d.positions).map(|p| DVec3::from(p.map(f64::from)));
        let own = Bounds::of(points);
        let corners = if own.is_empty() { [DVec3::ZERO; 8] } else { own.corners() };
        let placed = corners.map(|p| object.transform.0.transform_point3(p));
        placed.into_iter().filter(|p| p.is_finite()).for_each(&mut add);
    }
    for camera in desc.camera.iter().chain(&desc.cameras) {
        let [position, look_at, _] = camera.value.clone().placement_mut().map(|v| *v);
        add(position);
        add(look_at);
    }
    let size = if bounds.is_empty() { 1.0 } else { bounds.size().max_element() };
    20.0 * if size.is_finite() && size > 0.0 { size } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_taken_apart_and_put_together() {
        let mut state = 5_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX) * 4.0 - 2.0
        };
        for i in 0..200 {
            let mut m = DMat3::from_cols_array(&std::array::from_fn(|_| next()));
            if i == 0 {
                m = DMat3::from_diagonal(DVec3::new(2.0, -3.0, 4.0));
            }
            let parts = parts(&m);
            for rotation in [Some(parts.outer), parts.inner].into_iter().flatten() {
                let q = glam_quaternion(quaternion(&rotation));
                assert!((q - rotation).to_cols_array().iter().all(|v| v.abs() < 1e-9), "{rotation} {q}");
            }
            let together =
                parts.outer * DMat3::from_diagonal(parts.scale) * parts.inner.unwrap_or(DMat3::IDENTITY);
            assert!((together - m).to_cols_array().iter().all(|v| v.abs() < 1e-6), "{m} {together}");
        }
    }

    fn glam_quaternion([x, y, z, w]: [f64; 4]) -> DMat3 {
        DMat3::from_cols(
            DVec3::new(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
            DVec3::new(2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
            DVec3::new(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
        )
    }
}
