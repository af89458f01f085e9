//! Surfaces at hits, eight at a time: points, normals and shading frames, equal to those of [`Scene::surface`] and of
//! [`prepare`](crate::material::vertex::prepare) bit by bit.

use turner_bvh::RayBlock;
use turner_bvh::lanes::{Block, Block32, F32x8, F64x8, LANES, Mask8, Simd, Vec3x8};

use crate::bsdf::TerminatorX8;
use crate::interaction::SurfaceInteraction;
use crate::material::bent_normal::HEIGHT;
use crate::math::block::{set_bit, set_vector, vector};
use crate::math::elementary_x8::is_finite;
use crate::math::frame_x8::FrameX8;
use crate::math::{DVec3, Frame, Ray};
use crate::scene::scene::NO_TRANSFORM;
use crate::scene::{Hit, Scene};
use crate::shape::{Shape, SurfacePoint};

/// Eight surfaces. Triangles are computed here from their corners and vertex normals; others are stored as they are.
#[derive(Clone, Debug, Default)]
pub(crate) struct SurfaceBlock {
    /// The lanes of triangles with world-space positions and normals, and those of them with vertex normals.
    triangles: u8,
    smooth: u8,
    /// The lanes of materials that soften shadow terminators.
    softens: u8,
    /// Corners of the triangles, by coordinate.
    corners: [[Block32; 3]; 3],
    /// Their vertex normals, by coordinate.
    normals: [[Block32; 3]; 3],
    /// The lanes whose vertex normals are in the space of their object, and the matrices that bring them to the world, by
    /// column.
    turned: u8,
    turns: [[Block; 3]; 3],
    /// Barycentric weights of the second and third corner.
    weights: [Block; 2],
    /// Offsets of the world mesh, in the lanes of `moved`; -1 where a transform mirrors, else 1.
    offset: [Block; 3],
    moved: u8,
    side: Block,
    error: Block,
    p: [Block; 3],
    ng: [Block; 3],
    /// Shading normals, and those after bump and normal maps.
    ns: [Block; 3],
    mapped: [Block; 3],
    /// Directions of the rays that hit them, and the shading frames on the side where these come from.
    direction: [Block; 3],
    frame: [[Block; 3]; 3],
}

/// Eight surfaces in registers.
#[derive(Clone, Copy)]
pub(crate) struct SurfaceX8<S: Simd> {
    /// The points.
    pub(crate) p: Vec3x8<S>,
    /// Bounds on the distances of the points from the true surfaces.
    pub(crate) error: F64x8<S>,
    /// Geometric and shading normals, out of the shapes.
    pub(crate) ng: Vec3x8<S>,
    /// See `ng`.
    pub(crate) ns: Vec3x8<S>,
    /// Shading frames on the side where the rays come from.
    pub(crate) frame: FrameX8<S>,
    /// Directions towards the rays' origins.
    pub(crate) wo: Vec3x8<S>,
    /// Lanes whose shadow terminators are softened.
    soft: Mask8<S>,
}

impl SurfaceBlock {
    /// Stores the hit of a ray in a lane; false if its surface is not in world space, or has shading normals of its own
    /// where only `flat` ones are asked for.
    #[inline]
    pub(crate) fn take(&mut self, scene: &Scene, lane: usize, hit: &Hit, ray: &Ray, flat: bool) -> bool {
        if !self.take_triangle(scene, lane, hit, flat) {
            match scene.point_in_world(ray, hit).filter(|at| !flat || at.ns == at.ng) {
                Some(at) => {
                    self.set_point(lane, &at);
                    set_vector(&mut self.mapped, lane, at.ns);
                }
                None => return false,
            }
        }
        set_vector(&mut self.direction, lane, ray.direction);
        true
    }

    /// Stores the triangle of a hit in a lane, for [`SurfaceBlock::compute_points`]. False if the hit is not on a triangle in
    /// world space.
    #[inline]
    pub(crate) fn take_triangle(&mut self, scene: &Scene, lane: usize, hit: &Hit, flat: bool) -> bool {
        let Some(triangle) = scene.placed_triangle(hit) else { return false };
        let normals = triangle.own.normals_at_corners(hit.shape.part);
        if normals.is_some() && flat {
            return false;
        }
        // Vertex normals are in the space of the object.
        let turn = normals.and_then(|_| scene.normal_matrix(hit));
        if turn.is_some_and(|turn| !turn.is_finite()) {
            return false;
        }
        set_bit(&mut self.turned, lane, turn.is_some());
        if let Some(turn) = turn {
            let columns = [turn.x_axis, turn.y_axis, turn.z_axis];
            self.turns.iter_mut().zip(columns).for_each(|(to, v)| set_vector(to, lane, v));
        }
        set_corners(&mut self.corners, lane, triangle.mesh.corners(triangle.part));
        if let Some(normals) = normals {
            set_corners(&mut self.normals, lane, normals);
        }
        set_bit(&mut self.smooth, lane, normals.is_some());
        (self.weights[0].0[lane], self.weights[1].0[lane]) = (hit.shape.u, hit.shape.v);
        let own = triangle.mesh.error();
        set_bit(&mut self.moved, lane, triangle.moved.is_some());
        if let Some((offset, side)) = triangle.moved {
            set_vector(&mut self.offset, lane, offset);
            self.side.0[lane] = side;
            self.error.0[lane] = own + 4.0 * f64::EPSILON * offset.abs().max_element();
        } else {
            self.side.0[lane] = 1.0;
            self.error.0[lane] = own.max(1e-15 * hit.shape.t);
        }
        set_bit(&mut self.triangles, lane, true);
        true
    }

    /// Stores a surface that a ray of this direction hits. `mapped` is the shading normal after the material's maps.
    #[inline]
    pub(crate) fn set(&mut self, lane: usize, surface: &SurfaceInteraction, mapped: DVec3, direction: DVec3) {
        let SurfaceInteraction { p, error, ng, ns, .. } = *surface;
        self.set_point(lane, &SurfacePoint { p, error, ng, ns });
        set_vector(&mut self.mapped, lane, mapped);
        set_vector(&mut self.direction, lane, direction);
    }

    /// Stores a point and its normals, for [`SurfaceBlock::compute_points`].
    #[inline]
    pub(crate) fn set_point(&mut self, lane: usize, at: &SurfacePoint) {
        set_bit(&mut self.triangles, lane, false);
        set_vector(&mut self.p, lane, at.p);
        self.error.0[lane] = at.error;
        set_vector(&mut self.ng, lane, at.ng);
        set_vector(&mut self.ns, lane, at.ns);
    }

    /// Whether the material in a lane softens shadow terminators.
    #[inline]
    pub(crate) fn set_softens(&mut self, lane: usize, softens: bool) {
        set_bit(&mut self.softens, lane, softens);
    }

    /// The shading normal in a lane, where its shadow terminator is softened.
    #[inline]
    pub(crate) fn soft_normal(&self, lane: usize) -> Option<DVec3> {
        let ns = vector(&self.ns, lane);
        (self.softens >> lane & 1 == 1 && ns != self.normal(lane)).then_some(ns)
    }

    /// Stores the points of eight rays on one flat shape, as [`Scene::point_in_world`].
    #[inline(always)]
    pub(crate) fn set_flat<S: Simd>(&mut self, simd: S, rays: &RayBlock, flat: &FlatBlock) {
        let (point, n) =
            (Vec3x8::splat(simd, flat.point.to_array()), Vec3x8::splat(simd, flat.normal.to_array()));
        let t = F64x8::load(simd, &flat.t);
        let p = Vec3x8::load(simd, &rays.origin) + Vec3x8::load(simd, &rays.direction) * t;
        self.triangles = 0;
        (p - n * (p - point).dot(n)).store(&mut self.p);
        n.store(&mut self.ng);
        n.store(&mut self.ns);
    }

    /// Computes the triangles, and all frames.
    #[inline(always)]
    pub(crate) fn compute<S: Simd>(&mut self, simd: S) {
        let one = F64x8::splat(simd, 1.0);
        self.compute_points(simd);
        let ng = Vec3x8::load(simd, &self.ng);
        let n = Vec3x8::load(simd, &self.mapped);
        let direction = Vec3x8::load(simd, &self.direction);
        let outside = direction.dot(ng).lt(F64x8::splat(simd, 0.0));
        let mut frame = FrameX8::from_z(simd, n);
        let smooth = Mask8::new(simd, u8::MAX).and_not(same(n, ng));
        if smooth.any() {
            let side = outside.select(one, -one);
            let bent = bent_normal(simd, -direction, n * side, ng * side) * side;
            let turned = smooth.and_not(same(bent, n));
            if turned.any() {
                frame = FrameX8::select(turned, with_normal(simd, &frame, bent), frame);
            }
        }
        let frame = frame.turned_unless(outside);
        let [x, y, z] = &mut self.frame;
        frame.x.store(x);
        frame.y.store(y);
        frame.z.store(z);
    }

    /// Computes the points and normals of triangles alone.
    #[inline(always)]
    pub(crate) fn compute_points<S: Simd>(&mut self, simd: S) {
        if self.triangles != 0 {
            self.compute_triangles(simd);
        }
    }

    /// The points and their geometric and shading normals.
    #[inline(always)]
    pub(crate) fn points<S: Simd>(&self, simd: S) -> (Vec3x8<S>, Vec3x8<S>, Vec3x8<S>) {
        (Vec3x8::load(simd, &self.p), Vec3x8::load(simd, &self.ng), Vec3x8::load(simd, &self.ns))
    }

    /// As [`TriangleMesh::surface`](crate::shape::TriangleMesh::surface).
    #[inline(always)]
    fn compute_triangles<S: Simd>(&mut self, simd: S) {
        let (zero, one) = (F64x8::splat(simd, 0.0), F64x8::splat(simd, 1.0));
        let mask = Mask8::new(simd, self.triangles);
        let [a, b, c] = corners(simd, &self.corners);
        let (u, v) = (F64x8::load(simd, &self.weights[0]), F64x8::load(simd, &self.weights[1]));
        let w = one - u - v;
        let n = (b - a).cross(c - a);
        let ng = n * (one / n.dot(n).sqrt()) * F64x8::load(simd, &self.side);
        let p = a * w + b * u + c * v;
        let moved = Mask8::new(simd, self.moved);
        let p = Vec3x8::select(moved, p + Vec3x8::load(simd, &self.offset), p);
        let mut ns = ng;
        if self.smooth != 0 {
            let [a, b, c] = corners(simd, &self.normals);
            let mut n = normalized(simd, a * w + b * u + c * v);
            if self.turned != 0 {
                let [x, y, z] = self.turns.each_ref().map(|column| Vec3x8::load(simd, column));
                let turned = normalized(simd, x * n.x + y * n.y + z * n.z);
                n = Vec3x8::select(Mask8::new(simd, self.turned), turned, n);
            }
            let side = n.dot(ng);
            let n = Vec3x8::select(side.gt(zero), n, Vec3x8::select(side.lt(zero), -n, ng));
            ns = Vec3x8::select(Mask8::new(simd, self.smooth), n, ng);
        }
        Vec3x8::select(mask, p, Vec3x8::load(simd, &self.p)).store(&mut self.p);
        Vec3x8::select(mask, ng, Vec3x8::load(simd, &self.ng)).store(&mut self.ng);
        Vec3x8::select(mask, ns, Vec3x8::load(simd, &self.ns)).store(&mut self.ns);
        Vec3x8::select(mask, ns, Vec3x8::load(simd, &self.mapped)).store(&mut self.mapped);
    }

    /// The point in a lane.
    #[inline]
    pub(crate) fn point(&self, lane: usize) -> DVec3 {
        vector(&self.p, lane)
    }

    /// The points, by coordinate.
    #[inline]
    pub(crate) fn stored_points(&self) -> &[Block; 3] {
        &self.p
    }

    /// The geometric normal in a lane.
    #[inline]
    pub(crate) fn normal(&self, lane: usize) -> DVec3 {
        vector(&self.ng, lane)
    }

    /// The shading normal in a lane.
    #[inline]
    pub(crate) fn shading_normal(&self, lane: usize) -> DVec3 {
        vector(&self.ns, lane)
    }

    /// The shading normal in a lane after the material's maps.
    #[inline]
    pub(crate) fn mapped_normal(&self, lane: usize) -> DVec3 {
        vector(&self.mapped, lane)
    }

    /// The z axis of the shading frame in a lane.
    #[inline]
    pub(crate) fn frame_normal(&self, lane: usize) -> DVec3 {
        vector(&self.frame[2], lane)
    }

    /// The shading frame in a lane.
    #[inline]
    pub(crate) fn frame(&self, lane: usize) -> Frame {
        let [x, y, z] = self.frame.each_ref().map(|axis| vector(axis, lane));
        Frame { x, y, z }
    }

    /// The direction of the ray in a lane.
    #[inline]
    pub(crate) fn direction(&self, lane: usize) -> DVec3 {
        vector(&self.direction, lane)
    }

    /// The origin of rays that leave to a side of the surface: 1 is that of the normal, -1 the other.
    #[inline]
    pub(crate) fn leave(&self, lane: usize, side: f64) -> DVec3 {
        self.point(lane) + self.normal(lane) * (side * 4.0 * self.error.0[lane])
    }

    /// All lanes.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, simd: S) -> SurfaceX8<S> {
        let [x, y, z] = &self.frame;
        let (ng, ns) = (Vec3x8::load(simd, &self.ng), Vec3x8::load(simd, &self.ns));
        SurfaceX8 {
            p: Vec3x8::load(simd, &self.p),
            error: F64x8::load(simd, &self.error),
            ng,
            ns,
            frame: FrameX8 { x: Vec3x8::load(simd, x), y: Vec3x8::load(simd, y), z: Vec3x8::load(simd, z) },
            wo: -Vec3x8::load(simd, &self.direction),
            soft: Mask8::new(simd, self.softens).and_not(same(ns, ng)),
        }
    }
}

/// Hits of eight rays on one plane or rectangle, whose surface is the same everywhere.
pub(crate) struct FlatBlock {
    point: DVec3,
    normal: DVec3,
    t: Block,
}

impl Scene {
    /// The flat shape in world space that all eight rays hit.
    #[inline]
    pub(crate) fn flat_block(&self, hits: &[Option<Hit>]) -> Option<FlatBlock> {
        let primitive = hits.first()?.as_ref()?.primitive;
        let mut t = Block::default();
        if hits.len() < LANES {
            return None;
        }
        for (t, hit) in t.0.iter_mut().zip(hits) {
            *t = hit.as_ref().filter(|hit| hit.primitive == primitive)?.shape.t;
        }
        let (point, normal) = match self.shape_in_world(primitive)? {
            Shape::Plane(plane) => plane.place(),
            Shape::Rectangle(rectangle) => rectangle.place(),
            _ => return None,
        };
        Some(FlatBlock { point, normal, t })
    }

    /// The shape of a primitive in world space, unless it is a mesh or is known in object space alone.
    #[inline]
    fn shape_in_world(&self, primitive: u32) -> Option<&Shape> {
        let primitive = &self.primitives[primitive as usize];
        match (primitive.transform, &primitive.shape) {
            (_, Shape::Mesh(_)) => None,
            (NO_TRANSFORM, shape) => Some(shape),
            (i, _) => self.transforms[i as usize].in_world.as_deref(),
        }
    }

    /// The point and the normals of [`Scene::surface`], where they do not need the surface in object space.
    #[inline]
    pub(crate) fn point_in_world(&self, ray: &Ray, hit: &Hit) -> Option<SurfacePoint> {
        let point = match self.shape_in_world(hit.primitive)? {
            // The most frequent ones: floors and walls.
            Shape::Plane(plane) => plane.surface(ray, &hit.shape),
            Shape::Rectangle(rectangle) => rectangle.surface(ray, &hit.shape),
            shape => shape.surface(ray, &hit.shape),
        };
        Some(SurfacePoint { error: point.error.max(1e-15 * hit.shape.t), ..point })
    }
}

impl<S: Simd> SurfaceX8<S> {
    /// As [`SurfaceInteraction::leave`].
    #[inline(always)]
    pub(crate) fn leave(&self, simd: S, direction: Vec3x8<S>) -> Vec3x8<S> {
        let outwards = direction.dot(self.ng).ge(F64x8::splat(simd, 0.0));
        let side = outwards.select(F64x8::splat(simd, 4.0), F64x8::splat(simd, -4.0));
        self.p + self.ng * (side * self.error)
    }

    /// Lanes in which light from `wi` is reflected: it arrives on the side of wo, by both normals. `above` are the lanes
    /// in which the cosine to the frame's normal is greater than 0.
    #[inline(always)]
    pub(crate) fn reflects(&self, simd: S, wi: Vec3x8<S>, above: Mask8<S>) -> Mask8<S> {
        let zero = F64x8::splat(simd, 0.0);
        let all = Mask8::new(simd, u8::MAX);
        let (o, i) = (self.wo.dot(self.ng), wi.dot(self.ng));
        // As `Vertex::crosses`, whose normal is turned to the side of wo.
        let outside = o.gt(zero);
        let (o_inside, i_inside) = (o.lt(zero), i.lt(zero));
        let within = (o_inside & i_inside) | all.and_not(o_inside | i_inside);
        above & ((outside & i.gt(zero)) | within.and_not(outside))
    }

    /// The shadow terminators in the local frames.
    #[inline(always)]
    pub(crate) fn terminator(&self, simd: S) -> TerminatorX8<S> {
        let (ns, ng) = (self.frame.to_local(self.ns), self.frame.to_local(self.ng));
        TerminatorX8::new(simd, ns, ng, self.soft)
    }
}

/// As [`bent_normal`](crate::material::bent_normal).
#[inline(always)]
fn bent_normal<S: Simd>(simd: S, wo: Vec3x8<S>, ns: Vec3x8<S>, ng: Vec3x8<S>) -> Vec3x8<S> {
    let splat = |v: f64| F64x8::splat(simd, v);
    let (zero, one) = (splat(0.0), splat(1.0));
    let mirrored = -(wo - ns * (splat(2.0) * wo.dot(ns)));
    let (height, bound) = (splat(HEIGHT), splat(0.9) * wo.dot(ng));
    let least = bound.lt(height).select(bound, height);
    let reached = mirrored.dot(ng);
    let stays = reached.ge(least) & wo.dot(ns).gt(zero);
    if stays.bits() == u8::MAX {
        return ns;
    }
    let flat = normalized(simd, mirrored - ng * reached);
    let lifted = flat * (one - least * least).or_larger(zero).sqrt() + ng * least;
    let bent = normalized(simd, wo + lifted);
    let above = bent.dot(wo).gt(zero) & bent.dot(ng).gt(zero);
    Vec3x8::select(stays, ns, Vec3x8::select(above, bent, ng))
}

/// As [`with_normal`](crate::material::bent_normal::with_normal).
#[inline(always)]
fn with_normal<S: Simd>(simd: S, frame: &FrameX8<S>, n: Vec3x8<S>) -> FrameX8<S> {
    let along = frame.x - n * n.dot(frame.x);
    let x = normalized(simd, along);
    let none = x.dot(x).eq(F64x8::splat(simd, 0.0));
    let turned = FrameX8 { x, y: n.cross(x), z: n };
    FrameX8::select(none, FrameX8::from_z(simd, n), turned)
}

/// The unit vectors, or 0 where there is none.
#[inline(always)]
fn normalized<S: Simd>(simd: S, v: Vec3x8<S>) -> Vec3x8<S> {
    let zero = F64x8::splat(simd, 0.0);
    let r = F64x8::splat(simd, 1.0) / v.dot(v).sqrt();
    let valid = is_finite(simd, r) & r.gt(zero);
    Vec3x8::select(valid, v * r, Vec3x8 { x: zero, y: zero, z: zero })
}

#[inline(always)]
fn same<S: Simd>(a: Vec3x8<S>, b: Vec3x8<S>) -> Mask8<S> {
    a.x.eq(b.x) & a.y.eq(b.y) & a.z.eq(b.z)
}

/// Three vectors for each triangle.
#[inline(always)]
fn corners<S: Simd>(simd: S, [a, b, c]: &[[Block32; 3]; 3]) -> [Vec3x8<S>; 3] {
    [corner(simd, a), corner(simd, b), corner(simd, c)]
}

#[inline(always)]
fn corner<S: Simd>(simd: S, [x, y, z]: &[Block32; 3]) -> Vec3x8<S> {
    Vec3x8 {
        x: F32x8::load(simd, x).widen(),
        y: F32x8::load(simd, y).widen(),
        z: F32x8::load(simd, z).widen(),
    }
}

#[inline]
fn set_corners(to: &mut [[Block32; 3]; 3], lane: usize, corners: [[f32; 3]; 3]) {
    for (blocks, corner) in to.iter_mut().zip(corners) {
        for (block, v) in blocks.iter_mut().zip(corner) {
            block.0[lane] = v;
        }
    }
}

#[cfg(test)]
#[path = "surface_block_tests.rs"]
mod tests;
