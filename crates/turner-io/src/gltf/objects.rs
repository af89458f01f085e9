//! Objects: each node with a mesh places one object per primitive. Objects share a mesh if their vertices are the
//! same: same accessors, morph weights, tangents and skinning.

use std::collections::BTreeMap;
use std::sync::Arc;

use turner::description::{ObjectContent, ObjectDesc};
use turner::math::{DAffine3, DMat3};
use turner::schema::{Asset, MaterialId, MeshData, MeshId, Transform};
use turner::shape::mesh::MeshDesc;
use turner::shape::{PointsDesc, ShapeDesc};

use super::accessors::Elements;
use super::budget::Budget;
use super::buffers::Buffers;
use super::fault::{Fault, Outcome};
use super::instances::Instances;
use super::json::{Document, Index, Node, Primitive};
use super::primitives::{Request, shape};
use super::report::Report;
use super::skins::joint_matrices;
use super::textures::uv_set;
use super::{materials, variants};

/// Most objects of a file; the renderer has the same limit.
const MAX_OBJECTS: usize = 1 << 24;

/// A material as a mesh needs it: its index in the document, and whether the mesh has vertex colours.
pub(super) type Wanted = (Option<Index>, bool);

/// What a primitive's mesh is read from: accessors by attribute, indices, mode and the buffer view of a Draco mesh. A
/// primitive with morph targets is also identified by its mesh and position there.
type Geometry<'a> = (Vec<(&'a str, Index)>, [Option<Index>; 3], Option<(Index, usize)>);

/// Identifies a mesh: its geometry and how it was processed.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    /// Index of a [`Geometry`].
    geometry: usize,
    /// Bit patterns of the morph target weights.
    weights: Vec<u64>,
    normal_map: Option<usize>,
    /// The node and instance, if the vertices include its joints or transform.
    moved: Option<(u32, usize)>,
}

/// A converted mesh.
#[derive(Clone, Copy, Debug)]
struct Made {
    mesh: MeshId,
    smooth: bool,
    is_cloud: bool,
    has_colors: bool,
    uv_sets: u32,
}

/// Collects objects, meshes and materials.
pub(super) struct Objects<'a> {
    document: &'a Document,
    buffers: &'a Buffers,
    budget: &'a Budget,
    /// Morph target weights by node.
    weights: &'a BTreeMap<u32, Vec<f64>>,
    /// The world transform of each node.
    world: &'a [DAffine3],
    variant: Option<Index>,
    geometries: BTreeMap<Geometry<'a>, usize>,
    /// By mesh, the geometry index of each of its primitives.
    of_meshes: BTreeMap<Index, Vec<usize>>,
    made: BTreeMap<Key, Option<Made>>,
    materials: BTreeMap<Wanted, MaterialId>,
    /// The scene's meshes.
    pub(super) meshes: Vec<Asset<MeshData>>,
    /// The scene's objects.
    pub(super) objects: Vec<ObjectDesc>,
    /// The materials of the objects, by [`MaterialId`].
    pub(super) wanted: Vec<Wanted>,
    /// Number of instances from `EXT_mesh_gpu_instancing`.
    pub(super) instances: u64,
}

impl<'a> Objects<'a> {
    /// An empty collection.
    pub(super) fn new(
        document: &'a Document,
        (buffers, budget): (&'a Buffers, &'a Budget),
        (weights, world): (&'a BTreeMap<u32, Vec<f64>>, &'a [DAffine3]),
        variant: Option<Index>,
    ) -> Objects<'a> {
        Objects {
            document,
            buffers,
            budget,
            weights,
            world,
            variant,
            geometries: BTreeMap::new(),
            of_meshes: BTreeMap::new(),
            made: BTreeMap::new(),
            materials: BTreeMap::new(),
            meshes: Vec::new(),
            objects: Vec::new(),
            wanted: Vec::new(),
            instances: 0,
        }
    }

    /// Adds the objects of a node.
    pub(super) fn add_node(&mut self, number: u32, report: &mut Report) -> Outcome<()> {
        let node = &self.document.nodes[Index(number)];
        let Some(mesh) = node.mesh else { return Ok(()) };
        let pointer = format!("/nodes/{number}");
        if mesh.index() >= self.document.meshes.len() {
            return Err(Fault::dangling(pointer, "mesh", mesh.0, self.document.meshes.len()));
        }
        let joints = match node.skin {
            Some(skin) => {
                Some(joint_matrices(self.document, self.buffers, skin, self.world, self.budget, &pointer)?)
            }
            None => None,
        };
        let world = self.world[number as usize];
        let instancing = node.extensions.as_deref().and_then(|e| e.instancing.as_ref());
        match (instancing, joints) {
            (Some(instancing), None) => {
                let at = format!("{pointer}/extensions/EXT_mesh_gpu_instancing");
                let instances = Instances::open(self.document, self.buffers, instancing, &at)?;
                self.instances += instances.count as u64;
                for i in 0..instances.count {
                    self.place(number, node, mesh, (world * instances.transform(i), i), None, report)?;
                }
                Ok(())
            }
            (_, joints) => self.place(number, node, mesh, (world, 0), joints.as_deref(), report),
        }
    }

    /// Places a mesh once.
    fn place(
        &mut self,
        number: u32,
        node: &Node,
        mesh: Index,
        (world, instance): (DAffine3, usize),
        joints: Option<&[DAffine3]>,
        report: &mut Report,
    ) -> Outcome<()> {
        // The transform of a skinned mesh's node is ignored; only its joints count (§3.7.3.3).
        let (transform, bake) = match joints {
            Some(_) => (DAffine3::IDENTITY, None),
            None if is_invertible(&world) => (world, None),
            None if !world.is_finite() => {
                report.doubtful("a node whose transform has NaN or infinite values");
                return Ok(());
            }
            None if is_flat(&world.matrix3) => (DAffine3::IDENTITY, Some(world)),
            None => {
                report.doubtful("a node with a scale of 0");
                return Ok(());
            }
        };
        let json = &self.document.meshes[mesh];
        let weights = self.weights.get(&number).unwrap_or(&json.weights);
        for (p, primitive) in json.primitives.iter().enumerate() {
            let pointer = format!("/meshes/{}/primitives/{p}", mesh.0);
            // Charged also if nothing is visible, because it takes time.
            self.budget.take(1, size_of::<ObjectDesc>(), &pointer)?;
            let material = variants::material(self.document, primitive, self.variant, &pointer)?;
            let material_json = material.map(|m| &self.document.materials[m]);
            let normal_map = material_json.and_then(materials::normal_map).map(|info| uv_set(info) as usize);
            let moved = joints.is_some() || bake.is_some();
            let has_tangents = ["NORMAL", "TANGENT"].iter().all(|a| primitive.attributes.contains_key(*a));
            let has_targets = !primitive.targets.is_empty();
            let key = Key {
                geometry: self.geometry(mesh, p),
                weights: weights.iter().filter(|_| has_targets).map(|w| w.to_bits()).collect(),
                normal_map: normal_map.filter(|_| !has_tangents),
                moved: moved.then_some((number, instance)),
            };
            if self.is_placeholder(primitive) {
                report.doubtful("a mesh whose data lies in a buffer without a uri: nothing is shown of it");
                continue;
            }
            let made = match self.made.get(&key) {
                Some(made) => *made,
                None => {
                    let request = Request { weights, joints, normal_map, bake };
                    let name = self.mesh_name(mesh, p);
                    let made = self.make(primitive, request, name, report, &pointer)?;
                    self.made.insert(key, made);
                    made
                }
            };
            let Some(made) = made else { continue };
            self.check_uvs(material, made, report);
            let wanted = (material, made.has_colors);
            let next = MaterialId(self.wanted.len() as u32);
            let id = *self.materials.entry(wanted).or_insert(next);
            if id == next {
                self.wanted.push(wanted);
            }
            if self.objects.len() == MAX_OBJECTS {
                let message = format!("has more than {MAX_OBJECTS} objects, including instances");
                return Err(Fault::too_large(format!("/nodes/{number}"), message));
            }
            let name = node.name.as_ref().or(json.name.as_ref()).filter(|n| !n.is_empty());
            let shape = if made.is_cloud {
                ShapeDesc::Points(PointsDesc { points: made.mesh, radius: None, radii: Vec::new() })
            } else {
                let (mesh, smooth) = (made.mesh, Some(made.smooth));
                ShapeDesc::Mesh(MeshDesc { mesh, smooth, ..MeshDesc::default() })
            };
            self.objects.push(ObjectDesc {
                name: name.cloned(),
                span: None,
                content: ObjectContent::Shape(shape),
                material: Some(id),
                light_group: None,
                shadow_catcher: false,
                hidden_from_camera: false,
                hidden: false,
                transform: Transform(transform),
                motion: None,
            });
        }
        Ok(())
    }

    /// The geometry index of a primitive.
    fn geometry(&mut self, mesh: Index, primitive: usize) -> usize {
        let (document, geometries) = (self.document, &mut self.geometries);
        let known = self.of_meshes.entry(mesh).or_insert_with(|| {
            let primitives = document.meshes[mesh].primitives.iter().enumerate();
            let number = |(p, primitive): (usize, &'a Primitive)| {
                let attributes = primitive.attributes.iter().map(|(name, at)| (name.as_str(), *at)).collect();
                let place = (!primitive.targets.is_empty()).then_some((mesh, p));
                let next = geometries.len();
                let draco = primitive.extensions.as_deref().and_then(|e| e.draco.as_ref());
                let sources = [primitive.indices, primitive.mode, draco.map(|draco| draco.buffer_view)];
                *geometries.entry((attributes, sources, place)).or_insert(next)
            };
            primitives.map(number).collect()
        });
        known.get(primitive).copied().unwrap_or_default()
    }

    fn mesh_name(&self, mesh: Index, primitive: usize) -> String {
        let json = &self.document.meshes[mesh];
        let name = json.name.clone().filter(|n| !n.is_empty()).unwrap_or_else(|| format!("mesh {}", mesh.0));
        if json.primitives.len() > 1 { format!("{name}/{primitive}") } else { name }
    }

    fn make(
        &mut self,
        primitive: &Primitive,
        request: Request<'_>,
        name: String,
        report: &mut Report,
        pointer: &str,
    ) -> Outcome<Option<Made>> {
        let tools = (self.budget, report);
        let Some(shaped) = shape(self.document, self.buffers, primitive, request, tools, pointer)? else {
            return Ok(None);
        };
        let count = if shaped.is_cloud { shaped.mesh.positions.len() } else { shaped.mesh.triangles.len() };
        if count == 0 {
            return Ok(None);
        }
        let has = |set: &Vec<[f32; 2]>| !set.is_empty();
        let sets = [&shaped.mesh.uvs].into_iter().chain(&shaped.mesh.more_uvs);
        let uv_sets = sets.enumerate().map(|(i, set)| u32::from(has(set)) << i).sum();
        let made = Made {
            mesh: MeshId(self.meshes.len() as u32),
            smooth: shaped.smooth,
            is_cloud: shaped.is_cloud,
            has_colors: !shaped.mesh.colors.is_empty(),
            uv_sets,
        };
        self.meshes.push(Asset { uri: name, data: Arc::new(shaped.mesh) });
        Ok(Some(made))
    }

    /// Whether a primitive needs bytes of a placeholder.
    fn is_placeholder(&self, primitive: &Primitive) -> bool {
        let targets = primitive.targets.iter().flat_map(BTreeMap::values);
        let mut accessors = primitive.attributes.values().chain(targets).chain(&primitive.indices);
        accessors.any(|a| {
            let view = self.document.accessors.get(a.index()).and_then(|a| a.buffer_view);
            view.is_some_and(|view| self.buffers.is_placeholder(view))
        })
    }

    /// Reports textures whose UV set the mesh lacks.
    fn check_uvs(&self, material: Option<Index>, made: Made, report: &mut Report) {
        let Some(material) = material.map(|m| &self.document.materials[m]) else { return };
        let missing = |(info, _): &(&_, bool)| made.uv_sets.checked_shr(uv_set(info)).unwrap_or(0) & 1 == 0;
        if materials::textures_of(material).iter().any(missing) {
            report.doubtful("a mesh without the texture coordinates that its textures need");
        }
    }
}

/// Checks that every accessor with data lies within its buffer view, even if unused.
pub(super) fn check_accessors(document: &Document, buffers: &Buffers, budget: &Budget) -> Outcome<()> {
    for (i, accessor) in document.accessors.iter().enumerate() {
        let sparse = accessor.sparse.as_deref();
        let views = sparse.map(|s| [s.indices.buffer_view, s.values.buffer_view]);
        let mut views = accessor.buffer_view.into_iter().chain(views.into_iter().flatten());
        if views.clone().next().is_some() && !views.any(|view| buffers.is_absent(view)) {
            let elements = Elements::open(document, buffers, Index(i as u32), "")?;
            // Many accessors can share one long list of sparse indices; the budget bounds the time, too.
            budget.take(elements.sparse_count(), 1, "/accessors")?;
            elements.check_sparse()?;
        }
    }
    Ok(())
}

/// Whether a transform can be inverted: judged by the accuracy of the inverse, not by the determinant's magnitude.
fn is_invertible(m: &DAffine3) -> bool {
    let inverse = m.inverse();
    let round_trip = (m.matrix3 * inverse.matrix3 - DMat3::IDENTITY).to_cols_array();
    m.is_finite() && inverse.is_finite() && round_trip.iter().all(|v| v.abs() < 1e-6)
}

/// Whether a singular matrix maps space to a plane (not to a line or a point).
fn is_flat(m: &DMat3) -> bool {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    [x.cross(y), y.cross(z), z.cross(x)].iter().any(|v| v.length_squared() > 0.0)
}
