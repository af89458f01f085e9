//! From placed objects to what rays are traced through: the order of primitives, the trees over them.

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

/// Scenes of so many shapes or fewer have no tree. Together with a cheaper sphere test 1.5x faster at four spheres; the
/// limit itself is a guess, not measured.
const MAX_LINEAR: usize = 6;

/// What rays are traced through. Copies share all of it.
#[derive(Clone)]
pub(super) struct Geometry {
    pub(super) primitives: Arc<[Primitive]>,
    /// How many are in the tree or the sieve, which come first.
    pub(super) bounded: usize,
    /// Where those begin that are gathered in `merged`, which come last.
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

/// The trees over shapes that are not gathered.
struct SeparateTrees {
    /// Their numbers in the description, in the order of the tree or the sieve.
    order: Vec<u32>,
    bvh: BoxBvh,
    culler: Option<SphereCuller>,
    frame: TraversalFrame,
}

impl Geometry {
    /// Builds the trees; those of meshes that have one are left as they are. `last` is the geometry of the last preparation: what was gathered there in the same
    /// places is shared, and of what differs in some places the tree of the others, unless `whole` asks for a tree over all. Says whether the gathered meshes got a new tree.
    ///
    /// Errors: memory that there is not; a cancelled build is `None`.
    pub(super) fn new(
        placed: Placed,
        materials: &[Material],
        last: Option<&Geometry>,
        whole: bool,
        options: &PrepareOptions,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Option<(Geometry, bool)>, SceneError> {
        let Placed { primitives, bounds, transforms, faces, names, meshes, total, .. } = placed;
        let moves = |p: &Primitive| transforms.get(p.transform as usize).is_some_and(|t| t.motion.is_some());
        let moving: Vec<bool> = primitives.iter().map(moves).collect();
        let still: Vec<Option<Bounds>> =
            bounds.iter().zip(&moving).map(|(b, moves)| b.filter(|_| !moves)).collect();
        let (gathered, offset) = world_mesh::choose(&primitives, &still);
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
        let (mut world_mesh, mut remade) = (None, false);
        if first < ordered.len() {
            let members = Members {
                primitives: &ordered[first..],
                first,
                transforms: &transforms,
                materials,
                faces: &faces,
            };
            let last = last.and_then(|last| last.world_mesh.as_ref());
            let (made, new) = StaticWorldMesh::build(&members, offset, last, whole, options)?;
            (world_mesh, remade) = (Some(made), new);
        }
        let culled = if culler.is_some() { bounded } else { 0 };
        let batch = BatchShapes::new(&ordered[..first], culled, bounded - culled, materials, &faces);
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
        Ok(Some((geometry, remade)))
    }

    /// Whether the tree of the gathered meshes was changed since it was built.
    pub(super) fn is_changed(&self) -> bool {
        self.world_mesh.as_ref().is_some_and(StaticWorldMesh::is_changed)
    }

    /// Triangles of the meshes, each mesh counted once.
    pub(super) fn triangles(&self) -> u64 {
        self.meshes.iter().map(|m| m.triangle_count() as u64).sum()
    }

    /// Bytes: primitives, transforms and the tree over them.
    pub(super) fn tree_bytes(&self) -> u64 {
        let lists = size_of_val(&self.primitives[..]) + size_of_val(&self.transforms[..]);
        (lists + self.bvh.bytes() + self.batch.bytes()) as u64
    }

    /// Bytes: meshes with their trees.
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
        // Few shapes are tested one by one, without a tree.
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
