//! From placed objects to traversal: the order of primitives, and the BVHs over them.
//!
//! ```text
//! primitives │ 0.. bounded shapes, in the order of │ bounded.. planes and other │ gathered.. members of the │
//!            │ the BVH or the sphere culler        │ unbounded shapes           │ world mesh                │
//! ```
//!
//! Few shapes are tested one by one, some dozens by the sphere culler, more by a BVH. Meshes placed once
//! or a few times share one BVH in world space (`scene::world_mesh`); other meshes have a BVH in object space.

use std::sync::Arc;

use turner_bvh::{Aabb, BoxBvh, BuildOptions};

use super::placed::Placed;
use crate::material::Material;
use crate::math::Bounds;
use crate::scene::alpha_test::Faces;
use crate::scene::batch::BatchShapes;
use crate::scene::names::ObjectNames;
use crate::scene::scene::{NO_TRANSFORM, ObjectTransform, Primitive};
use crate::scene::sphere_culler::{MAX_SHAPES, SphereCuller};
use crate::scene::world_mesh::{self, Members, StaticWorldMesh};
use crate::schema::{ErrorCode, PrepareOptions, SceneError};
use crate::shape::traversal::TraversalFrame;
use crate::shape::{Shape, TriangleMesh};

/// Scenes with at most this many shapes have no BVH. With four spheres this, together with a cheaper sphere test,
/// is 1.5 times faster. The limit itself is a guess, not measured.
const MAX_LINEAR: usize = 6;

/// The geometry that rays traverse. Copies share all of it.
#[derive(Clone)]
pub(super) struct Geometry {
    pub(super) primitives: Arc<[Primitive]>,
    /// The number of primitives in the BVH or the sphere culler, which come first.
    pub(super) bounded: usize,
    /// Index of the first member of `world_mesh`; members come last.
    pub(super) gathered: usize,
    pub(super) world_mesh: Option<StaticWorldMesh>,
    pub(super) transforms: Arc<[ObjectTransform]>,
    pub(super) faces: Arc<[Faces]>,
    pub(super) bvh: Arc<BoxBvh>,
    pub(super) culler: Option<SphereCuller>,
    pub(super) frame: TraversalFrame,
    pub(super) batch: Arc<BatchShapes>,
    pub(super) names: Arc<ObjectNames>,
    pub(super) moves: bool,
    pub(super) total: Bounds,
    meshes: Vec<Arc<TriangleMesh>>,
}

/// BVH or sphere culler over the shapes outside the world mesh.
struct SeparateTrees {
    /// Their indices in the description, in the order of the BVH or the sphere culler.
    order: Vec<u32>,
    bvh: BoxBvh,
    culler: Option<SphereCuller>,
    frame: TraversalFrame,
}

impl Geometry {
    /// Builds the BVHs; a mesh that has one keeps it. `last` is the geometry of the last preparation. Members of
    /// its world mesh that did not change share its BVH, unless `full_rebuild` asks for one over all members.
    /// Returns also whether the world mesh got a new BVH.
    ///
    /// Errors: not enough memory. A cancelled build returns `None`.
    pub(super) fn new(
        placed: Placed,
        materials: &[Material],
        last: Option<&Geometry>,
        full_rebuild: bool,
        options: &PrepareOptions,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Option<(Geometry, bool)>, SceneError> {
        let Placed { primitives, bounds, transforms, faces, names, meshes, total, .. } = placed;
        let moves = |p: &Primitive| transforms.get(p.transform as usize).is_some_and(|t| t.motion.is_some());
        let moving: Vec<bool> = primitives.iter().map(moves).collect();
        let still: Vec<Option<Bounds>> =
            bounds.iter().zip(&moving).map(|(b, moves)| b.filter(|_| !moves)).collect();
        let (gathered, offset) = world_mesh::choose(&primitives, &still, materials);
        for (primitive, gathered) in primitives.iter().zip(&gathered) {
            if let (Shape::Mesh(mesh), false) = (&primitive.shape, gathered) {
                if cancelled() {
                    return Ok(None);
                }
                mesh.build_tree(options)?;
            }
        }
        let SeparateTrees { order, bvh, culler, frame } =
            SeparateTrees::new(&primitives, &bounds, &gathered, &total, options)?;
        let mut slots: Vec<Option<Primitive>> = primitives.into_iter().map(Some).collect();
        let mut ordered: Vec<Primitive> = Vec::with_capacity(slots.len());
        ordered.extend(order.iter().filter_map(|i| slots[*i as usize].take()));
        let bounded = ordered.len();
        let left = slots.into_iter().zip(&gathered);
        let (behind, unbounded): (Vec<_>, Vec<_>) = left.partition(|(_, gathered)| **gathered);
        ordered.extend(unbounded.into_iter().filter_map(|(slot, _)| slot));
        let first = ordered.len();
        ordered.extend(behind.into_iter().filter_map(|(slot, _)| slot));
        if cancelled() {
            return Ok(None);
        }
        let (mut world_mesh, mut rebuilt) = (None, false);
        if first < ordered.len() {
            let members = Members {
                primitives: &ordered[first..],
                first,
                transforms: &transforms,
                materials,
                faces: &faces,
            };
            let last = last.and_then(|last| last.world_mesh.as_ref());
            let (made, new) = StaticWorldMesh::build(&members, offset, last, full_rebuild, options)?;
            (world_mesh, rebuilt) = (Some(made), new);
        }
        let culled = if culler.is_some() { bounded } else { 0 };
        let batch =
            BatchShapes::new(&ordered[..first], culled, bounded - culled, materials, &transforms, &faces);
        let geometry = Geometry {
            primitives: ordered.into(),
            bounded,
            gathered: first,
            world_mesh,
            transforms: transforms.into(),
            faces: faces.into(),
            bvh: Arc::new(bvh),
            culler,
            frame,
            batch: Arc::new(batch),
            names: Arc::new(names.finish()),
            moves: moving.contains(&true),
            total,
            meshes,
        };
        Ok(Some((geometry, rebuilt)))
    }

    /// Whether the BVH of the world mesh was updated after it was built.
    pub(super) fn is_changed(&self) -> bool {
        self.world_mesh.as_ref().is_some_and(StaticWorldMesh::is_changed)
    }

    /// Number of triangles of the meshes; each mesh counts once.
    pub(super) fn triangles(&self) -> u64 {
        self.meshes.iter().map(|m| m.triangle_count() as u64).sum()
    }

    /// Size in bytes of primitives, transforms and the BVH over them.
    pub(super) fn tree_bytes(&self) -> u64 {
        let lists = size_of_val(&self.primitives[..]) + size_of_val(&self.transforms[..]);
        (lists + self.bvh.bytes() + self.batch.bytes()) as u64
    }

    /// Size in bytes of meshes and their BVHs.
    pub(super) fn mesh_bytes(&self) -> u64 {
        self.meshes.iter().map(|m| m.memory() as u64).sum::<u64>()
            + self.world_mesh.as_ref().map_or(0, |m| m.bytes() as u64)
    }
}

impl SeparateTrees {
    fn new(
        primitives: &[Primitive],
        bounds: &[Option<Bounds>],
        gathered: &[bool],
        total: &Bounds,
        options: &PrepareOptions,
    ) -> Result<SeparateTrees, SceneError> {
        // A few shapes are tested one by one, without a BVH.
        let single = gathered.iter().filter(|gathered| !**gathered).count();
        let has_tree = single > MAX_LINEAR;
        let frame = TraversalFrame::new(if has_tree { total } else { &Bounds::EMPTY });
        let ids: Vec<u32> = (0..primitives.len() as u32)
            .filter(|i| has_tree && bounds[*i as usize].is_some() && !gathered[*i as usize])
            .collect();
        let box_of = |i: &u32| bounds[*i as usize].unwrap_or(Bounds::EMPTY);
        if (1..=MAX_SHAPES).contains(&ids.len()) {
            let shapes = ids.iter().map(|i| {
                let primitive = &primitives[*i as usize];
                let sphere = match &primitive.shape {
                    Shape::Sphere(s) if primitive.transform == NO_TRANSFORM => Some((s.center, s.radius)),
                    _ => None,
                };
                (box_of(i), sphere)
            });
            let culler = Some(SphereCuller::new(&frame, shapes));
            return Ok(SeparateTrees { bvh: tree(&[], options)?, culler, frame, order: ids });
        }
        let boxes: Vec<_> = ids.iter().map(|i| frame.aabb(&box_of(i))).collect();
        let bvh = tree(&boxes, options)?;
        let order = bvh.order().iter().map(|i| ids[*i as usize]).collect();
        Ok(SeparateTrees { bvh, culler: None, frame, order })
    }
}

fn tree(boxes: &[Aabb], options: &PrepareOptions) -> Result<BoxBvh, SceneError> {
    let build = BuildOptions {
        threads: options.threads,
        instruction_set: options.instruction_set,
        ..BuildOptions::default()
    };
    BoxBvh::build(boxes, &build).map_err(|e| SceneError::new(ErrorCode::TooLarge, e.to_string()))
}
