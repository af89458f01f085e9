//! Eight rays against one triangle each: the same operations as [`RayShear`](super::triangle::RayShear), in the same
//! order.

use turner_bvh::lanes::{Block32, F32x8, F64x8, Mask8, Simd, Vec3x8};

/// Where eight rays hit the planes of their triangles.
pub(super) struct TriangleHits<S: Simd> {
    /// Lanes that hit the triangle itself, at a finite t.
    pub(super) hit: Mask8<S>,
    /// Parameters along the rays.
    pub(super) t: F64x8<S>,
    /// Barycentric weights of the second and the third vertex.
    pub(super) u: F64x8<S>,
    pub(super) v: F64x8<S>,
}

/// The vertices of eight triangles: vertex, coordinate, lane.
pub(super) type Corners = [[Block32; 3]; 3];

#[inline(always)]
pub(super) fn intersect_triangles<S: Simd>(
    simd: S,
    origin: Vec3x8<S>,
    direction: Vec3x8<S>,
    corners: &Corners,
) -> TriangleHits<S> {
    let splat = |v: f64| F64x8::splat(simd, v);
    let [dx, dy, dz] = [direction.x.abs(), direction.y.abs(), direction.z.abs()];
    let second = dx.gt(dy);
    let along_x = second & dx.gt(dz);
    let along_y = dy.gt(dz).and_not(second);
    let order = Order { along_x, along_y };
    let (o, d) = (order.apply(origin), order.apply(direction));
    let shear_z = splat(1.0) / d.z;
    let (shear_x, shear_y) = (d.x * shear_z, d.y * shear_z);
    let shear = Vec3x8 { x: shear_x, y: shear_y, z: shear_z };
    let [a, b, c] = corners;
    let a = sheared(simd, a, &order, o, shear);
    let b = sheared(simd, b, &order, o, shear);
    let c = sheared(simd, c, &order, o, shear);
    let u = c.x * b.y - c.y * b.x;
    let v = a.x * c.y - a.y * c.x;
    let w = b.x * a.y - b.y * a.x;
    let zero = splat(0.0);
    let below = u.lt(zero) | v.lt(zero) | w.lt(zero);
    let above = u.gt(zero) | v.gt(zero) | w.gt(zero);
    let det = u + v + w;
    let inv = splat(1.0) / det;
    let (u, v, w) = (u * inv, v * inv, w * inv);
    let t = (u * a.z + v * b.z + w * c.z) * shear_z;
    let finite = t.abs().lt(splat(f64::INFINITY));
    let hit = finite.and_not(below & above).and_not(det.eq(zero));
    TriangleHits { hit, t, u: v, v: w }
}

/// Axis permutations: masks of the lanes whose last axis is x or y.
struct Order<S: Simd> {
    along_x: Mask8<S>,
    along_y: Mask8<S>,
}

// Methods, because closures are not compiled for the caller's instruction set.
impl<S: Simd> Order<S> {
    #[inline(always)]
    fn apply(&self, v: Vec3x8<S>) -> Vec3x8<S> {
        let Order { along_x, along_y } = self;
        Vec3x8 {
            x: along_x.select(v.y, along_y.select(v.z, v.x)),
            y: along_x.select(v.z, along_y.select(v.x, v.y)),
            z: along_x.select(v.x, along_y.select(v.y, v.z)),
        }
    }
}

/// Vertices permuted as the rays, relative to their origins, sheared.
#[inline(always)]
fn sheared<S: Simd>(
    simd: S,
    [x, y, z]: &[Block32; 3],
    order: &Order<S>,
    origin: Vec3x8<S>,
    shear: Vec3x8<S>,
) -> Vec3x8<S> {
    let p = Vec3x8 {
        x: F32x8::load(simd, x).widen(),
        y: F32x8::load(simd, y).widen(),
        z: F32x8::load(simd, z).widen(),
    };
    let p = order.apply(p) - origin;
    Vec3x8 { x: p.x - shear.x * p.z, y: p.y - shear.y * p.z, z: p.z }
}

#[cfg(test)]
mod tests {
    use turner_bvh::InstructionSet;
    use turner_bvh::lanes::{Block, LANES, Work, dispatch};

    use super::*;
    use crate::math::{DVec3, Ray};
    use crate::shape::triangle::RayShear;
    use crate::testing::Random;

    struct Intersect<'a> {
        origin: &'a [Block; 3],
        direction: &'a [Block; 3],
        corners: &'a Corners,
        out: &'a mut [Block; 3],
    }

    impl Work for Intersect<'_> {
        type Output = u8;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> u8 {
            let (origin, direction) = (Vec3x8::load(simd, self.origin), Vec3x8::load(simd, self.direction));
            let hits = intersect_triangles(simd, origin, direction, self.corners);
            Vec3x8 { x: hits.t, y: hits.u, z: hits.v }.store(self.out);
            hits.hit.bits()
        }
    }

    /// Small integers, so that some rays pass exactly through edges, vertices and planes.
    #[test]
    fn each_lane_is_the_ray_alone() {
        let mut random = Random::new(1);
        let mut draw = || (random.unit() * 7.0).floor() - 3.0;
        let mut hits = 0;
        let sets: Vec<InstructionSet> = InstructionSet::available().collect();
        for round in 0..4000 {
            let mut origin = [Block::default(); 3];
            let mut direction = [Block::default(); 3];
            let mut corners = [[Block32::default(); 3]; 3];
            for lane in 0..LANES {
                for axis in 0..3 {
                    origin[axis].0[lane] = draw() * 0.25;
                    direction[axis].0[lane] = draw();
                    for corner in &mut corners {
                        corner[axis].0[lane] = draw() as f32;
                    }
                }
            }
            let mut out = [Block::default(); 3];
            let set = sets[round % sets.len()];
            let hit = dispatch(
                set,
                Intersect { origin: &origin, direction: &direction, corners: &corners, out: &mut out },
            );
            for lane in 0..LANES {
                let vector = |v: &[Block; 3]| DVec3::from(v.each_ref().map(|v| v.0[lane]));
                let d = vector(&direction);
                if d == DVec3::ZERO {
                    continue;
                }
                let triangle = corners.each_ref().map(|c| c.each_ref().map(|v| v.0[lane]));
                let alone = RayShear::new(&Ray::new(vector(&origin), d)).triangle(&triangle);
                let alone = alone.filter(|hit| hit.t.is_finite());
                assert_eq!(hit >> lane & 1 == 1, alone.is_some());
                if let Some(hit) = alone {
                    let lanes = out.map(|v| v.0[lane].to_bits());
                    assert_eq!(lanes, [hit.t, hit.u, hit.v].map(f64::to_bits));
                    hits += 1;
                }
            }
        }
        assert!(hits > 1000, "{hits}");
    }
}
