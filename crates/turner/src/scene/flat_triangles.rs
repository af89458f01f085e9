//! Surfaces of flat triangles, eight at a time: equal to [`Scene::surface`] bit by bit.

use turner_bvh::lanes::{Block, Block32, F32x8, F64x8, LANES, Mask8, Simd, Vec3x8};

use crate::math::DVec3;
use crate::scene::{Hit, Scene};

/// Hits of meshes with world-space positions that are shaded with their triangles' normals.
#[derive(Clone, Debug, Default)]
pub struct FlatTriangleBlock {
    /// Corners of the triangles, by coordinate.
    corners: [[Block32; 3]; 3],
    /// Barycentric weights of the second and third corner.
    weights: [Block; 2],
    /// The offset added to points in the lanes of `moved`, and the factor of normals.
    offset: [Block; 3],
    moved: u8,
    side: Block,
    error: Block,
    p: [Block; 3],
    ng: [Block; 3],
}

impl FlatTriangleBlock {
    /// Stores a hit in a lane; false if its surface is not such a triangle.
    #[inline]
    pub fn take(&mut self, scene: &Scene, lane: usize, hit: &Hit) -> bool {
        let Some(triangle) = scene.placed_triangle(hit) else { return false };
        if !triangle.own.is_faceted() {
            return false;
        }
        for (blocks, corner) in self.corners.iter_mut().zip(triangle.mesh.corners(triangle.part)) {
            for (block, v) in blocks.iter_mut().zip(corner) {
                block.0[lane] = v;
            }
        }
        (self.weights[0].0[lane], self.weights[1].0[lane]) = (hit.shape.u, hit.shape.v);
        let own = triangle.mesh.error();
        if let Some((offset, side)) = triangle.moved {
            self.moved |= 1 << lane;
            for (block, v) in self.offset.iter_mut().zip(offset.to_array()) {
                block.0[lane] = v;
            }
            self.side.0[lane] = side;
            self.error.0[lane] = own + 4.0 * f64::EPSILON * offset.abs().max_element();
        } else {
            self.moved &= !(1 << lane);
            self.side.0[lane] = 1.0;
            self.error.0[lane] = own.max(1e-15 * hit.shape.t);
        }
        true
    }

    /// Computes points and normals.
    #[inline(always)]
    pub fn compute<S: Simd>(&mut self, simd: S) {
        let corner = |[x, y, z]: &[Block32; 3]| Vec3x8 {
            x: F32x8::load(simd, x).widen(),
            y: F32x8::load(simd, y).widen(),
            z: F32x8::load(simd, z).widen(),
        };
        let [a, b, c] = &self.corners;
        let (a, b, c) = (corner(a), corner(b), corner(c));
        let (u, v) = (F64x8::load(simd, &self.weights[0]), F64x8::load(simd, &self.weights[1]));
        let one = F64x8::splat(simd, 1.0);
        let n = (b - a).cross(c - a);
        let ng = n * (one / n.dot(n).sqrt());
        (ng * F64x8::load(simd, &self.side)).store(&mut self.ng);
        let p = a * (one - u - v) + b * u + c * v;
        let moved = Mask8::new(simd, self.moved);
        Vec3x8::select(moved, p + Vec3x8::load(simd, &self.offset), p).store(&mut self.p);
    }

    /// The point in a lane.
    #[inline]
    pub fn point(&self, lane: usize) -> DVec3 {
        vector(&self.p, lane)
    }

    /// The geometric normal in a lane, which is also the shading normal.
    #[inline]
    pub fn normal(&self, lane: usize) -> DVec3 {
        vector(&self.ng, lane)
    }

    /// The origin of rays that leave to a side of the surface: 1 is that of the normal, -1 the other.
    #[inline]
    pub fn leave(&self, lane: usize, side: f64) -> DVec3 {
        self.point(lane) + self.normal(lane) * (side * 4.0 * self.error.0[lane])
    }

    /// All points, their error bounds, and normals.
    #[inline(always)]
    pub fn lanes<S: Simd>(&self, simd: S) -> (Vec3x8<S>, F64x8<S>, Vec3x8<S>) {
        (Vec3x8::load(simd, &self.p), F64x8::load(simd, &self.error), Vec3x8::load(simd, &self.ng))
    }
}

#[inline]
fn vector([x, y, z]: &[Block; 3], lane: usize) -> DVec3 {
    debug_assert!(lane < LANES);
    DVec3::new(x.0[lane], y.0[lane], z.0[lane])
}
