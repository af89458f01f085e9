//! Axis-aligned boxes, intersected by the slab method (Kay and Kajiya 1986).

use super::{ROUNDING, ShapeHit, SurfacePoint, convex_hit};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, Range, SceneError, params};

params! {
    /// A box with its edges along the axes; rotate it with the object's `transform`. Give either `min` and
    /// `max`, or `center` and `size`; with none of them the box extends from −1 to 1 on each axis. Each face
    /// has its own (u, v) in 0..1: on the sides, seen from outside with +y up, u runs to the right and v up. On
    /// the top (+y) u runs along +x and v along −z; on the bottom u runs along +x and v along +z. Normals point
    /// outwards.
    pub struct BoxDesc as "box" {
        /// Corner with the smallest coordinates.
        min: Option<DVec3> = None;
        /// Corner with the largest coordinates.
        max: Option<DVec3> = None;
        /// Centre; [0, 0, 0] if only `size` is given.
        center: Option<DVec3> = None;
        /// Edge lengths along x, y and z; [2, 2, 2] if only `center` is given.
        size: Option<DVec3> = None, in Range::POSITIVE;
    }
    example r#"[[object]]
type = "box"
center = [0, 0.5, 0]
size = [2, 1, 3]
material = { color = "peru" }
"#
}

/// An axis-aligned box. Parts 0 to 5 are the faces −x, +x, −y, +y, −z, +z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Smallest coordinates.
    pub min: DVec3,
    /// Largest coordinates.
    pub max: DVec3,
}

impl BoxDesc {
    /// Converts it to the form that rays are intersected with.
    pub fn prepare(&self) -> Result<Cuboid, SceneError> {
        let (min, max) = match (self.min, self.max, self.center, self.size) {
            (Some(min), Some(max), None, None) => (min, max),
            (None, None, center, size) => {
                let (center, half) = (center.unwrap_or(DVec3::ZERO), 0.5 * size.unwrap_or(DVec3::splat(2.0)));
                (center - half, center + half)
            }
            _ => {
                let message = "a box needs both `min` and `max`, or `center` and `size`";
                return Err(SceneError::new(ErrorCode::Conflict, message)
                    .help("give two corners, or the centre and the edge lengths"));
            }
        };
        if min.cmplt(max).all() && min.is_finite() && max.is_finite() {
            return Ok(Cuboid { min, max });
        }
        let message = format!("each coordinate of `min` must be less than that of `max`: found {min}, {max}");
        Err(SceneError::new(ErrorCode::OutOfRange, message).help("use a rectangle for a flat box"))
    }
}

impl Cuboid {
    /// Bounding box: the box itself.
    pub fn bounds(&self) -> Bounds {
        Bounds::new(self.min, self.max)
    }

    /// Entry and exit parameters and faces. For a ray within the plane of a face the division is 0 / 0; the NaN
    /// imposes no constraint, because comparisons with it are false.
    #[inline]
    fn slabs(&self, ray: &Ray) -> ((f64, u32), (f64, u32)) {
        let inv = ray.direction.recip();
        let t0 = (self.min - ray.origin) * inv;
        let t1 = (self.max - ray.origin) * inv;
        let (mut enter, mut exit) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
        for axis in 0..3 {
            let flip = u32::from(inv[axis].is_sign_negative());
            let (near, far) = if flip == 1 { (t1[axis], t0[axis]) } else { (t0[axis], t1[axis]) };
            let face = 2 * axis as u32;
            if near > enter.0 {
                enter = (near, face + flip);
            }
            if far < exit.0 {
                exit = (far, face + 1 - flip);
            }
        }
        (enter, exit)
    }

    /// The nearest of entry and exit in range. Faces, edges and corners belong to the box.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let (enter, exit) = self.slabs(ray);
        convex_hit(ray, enter, exit).filter(|_| ray.is_finite())
    }

    /// The surface point at a hit.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let (axis, upper) = (hit.part as usize / 2, hit.part % 2 == 1);
        let mut p = ray.at(hit.t).clamp(self.min, self.max);
        p[axis] = if upper { self.max[axis] } else { self.min[axis] };
        let mut n = DVec3::ZERO;
        n[axis] = if upper { 1.0 } else { -1.0 };
        SurfacePoint { p, error: ROUNDING * self.min.abs().max(self.max.abs()).max_element(), ng: n, ns: n }
    }

    /// (u, v) on the face that was hit.
    pub fn uv(&self, part: u32, p: DVec3) -> DVec2 {
        let a = (p - self.min) / (self.max - self.min);
        match part {
            0 => DVec2::new(a.z, a.y),
            1 => DVec2::new(1.0 - a.z, a.y),
            2 => DVec2::new(a.x, a.z),
            3 => DVec2::new(a.x, 1.0 - a.z),
            4 => DVec2::new(1.0 - a.x, a.y),
            _ => DVec2::new(a.x, a.y),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Cuboid = Cuboid { min: DVec3::NEG_ONE, max: DVec3::ONE };

    fn hit(o: [f64; 3], d: [f64; 3]) -> Option<(f64, u32)> {
        UNIT.intersect(&Ray::new(o.into(), d.into())).map(|h| (h.t, h.part))
    }

    #[test]
    fn each_face_from_outside_and_inside() {
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut d = [0.0; 3];
                d[axis] = sign * 0.5;
                let mut o = [0.1, 0.2, 0.3];
                o[axis] = -3.0 * sign;
                let (near, far) = (u32::from(sign < 0.0), u32::from(sign > 0.0));
                assert_eq!(hit(o, d), Some((4.0, 2 * axis as u32 + near)));
                o[axis] = 0.0;
                assert_eq!(hit(o, d), Some((2.0, 2 * axis as u32 + far)));
                o[axis] = 1.5 * sign;
                assert_eq!(hit(o, d), None);
            }
        }
    }

    #[test]
    fn rays_within_faces_and_edges_are_defined() {
        for zero in [0.0, -0.0] {
            assert_eq!(hit([1.0, 0.0, -3.0], [zero, zero, 1.0]), Some((2.0, 4)));
            assert_eq!(hit([1.0, -1.0, -3.0], [zero, zero, 1.0]), Some((2.0, 4)));
            assert_eq!(hit([1.0 + 1e-15, 0.0, -3.0], [zero, zero, 1.0]), None);
            assert_eq!(hit([0.0, 0.0, 0.0], [zero, zero, zero]), None);
        }
        assert_eq!(hit([-3.0, -3.0, -3.0], [1.0, 1.0, 1.0]).map(|h| h.0), Some(2.0));
        assert_eq!(hit([0.0, 0.0, 0.0], [f64::INFINITY, 0.0, 0.0]), None);
    }

    #[test]
    fn faces_are_upright_from_outside() {
        // right × up of each face's (u, v) points outwards.
        for part in 0..6u32 {
            let axis = part as usize / 2;
            let grad = |dir: DVec3| UNIT.uv(part, DVec3::ZERO + dir) - UNIT.uv(part, DVec3::ZERO);
            let (mut right, mut up) = (DVec3::ZERO, DVec3::ZERO);
            for (i, e) in DVec3::AXES.into_iter().enumerate() {
                right[i] = grad(e).x;
                up[i] = grad(e).y;
            }
            let n = right.cross(up).normalize();
            let sign = if part % 2 == 1 { 1.0 } else { -1.0 };
            assert_eq!(n[axis], sign, "face {part}");
            assert!(axis == 1 || up.y > 0.0);
        }
    }

    #[test]
    fn corners_or_middle() {
        let none = BoxDesc { min: None, max: None, center: None, size: None };
        assert_eq!(none.prepare(), Ok(UNIT));
        let sized = BoxDesc { size: Some(DVec3::new(2.0, 4.0, 6.0)), ..none.clone() };
        assert_eq!(sized.prepare().unwrap().max, DVec3::new(1.0, 2.0, 3.0));
        assert!(BoxDesc { min: Some(DVec3::ZERO), ..none.clone() }.prepare().is_err());
        assert!(BoxDesc { min: Some(DVec3::ZERO), max: Some(DVec3::X), ..none.clone() }.prepare().is_err());
        assert!(
            BoxDesc { min: Some(DVec3::ZERO), max: Some(DVec3::X), size: Some(DVec3::ONE), ..none }
                .prepare()
                .is_err()
        );
    }
}
