//! Vectors, rays, bounds, frames and elementary functions.
//!
//! Positions and directions outside `turner-bvh` are `f64`: the classic documents assume real numbers, and a
//! sphere of radius 5000 seen from one unit away needs them. Colours are `f32` ([`crate::color::Spectrum`]).

mod bounds;
pub mod elementary;
pub mod elementary_x8;
mod frame;
pub mod frame_x8;
mod ray;
mod ray_cone;

pub use bounds::Bounds;
pub use frame::Frame;
pub use glam::{DAffine3, DMat3, DVec2, DVec3};
pub use ray::Ray;
pub use ray_cone::RayCone;

/// The point on the sphere's or lobe's far side: `d` mirrored at the plane with unit normal `n`.
///
/// `d` points towards the surface, the result away from it: d − 2 (d·n) n.
pub fn reflect(d: DVec3, n: DVec3) -> DVec3 {
    d - 2.0 * d.dot(n) * n
}

/// Snell's law: unit direction `d` towards a surface with unit normal `n` on the side it comes from
/// (d·n ≤ 0), `eta` = index of refraction of the incident medium over that of the transmitting one.
/// `None` is total internal reflection.
pub fn refract(d: DVec3, n: DVec3, eta: f64) -> Option<DVec3> {
    let cos_i = -d.dot(n);
    let sin2_t = eta * eta * (1.0 - cos_i * cos_i).max(0.0);
    if sin2_t > 1.0 {
        return None;
    }
    Some(eta * d + (eta * cos_i - (1.0 - sin2_t).sqrt()) * n)
}

/// Degrees to radians.
pub fn radians(degrees: f64) -> f64 {
    degrees * (std::f64::consts::PI / 180.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use elementary::{asin, sin, sin_cos};

    #[test]
    fn snells_law() {
        for degrees in [0.0, 1.0, 30.0, 41.8, 60.0, 89.9] {
            let (s, c) = sin_cos(radians(degrees));
            let d = DVec3::new(s, -c, 0.0);
            let t = refract(d, DVec3::Y, 1.0 / 1.5).unwrap();
            assert!((t.x - s / 1.5).abs() < 1e-12 && (t.length() - 1.0).abs() < 1e-12);
            assert!(t.y < 0.0 && t.z == 0.0);
            // And back again: a ray's way can be reversed.
            let back = refract(-t, DVec3::NEG_Y, 1.5).unwrap();
            assert!((back + d).length() < 1e-6, "{degrees}: {back} and {d}");
        }
    }

    #[test]
    fn critical_angle_at_ior_1_5_is_41_81_degrees() {
        let at = |degrees: f64| {
            let (s, c) = sin_cos(radians(degrees));
            refract(DVec3::new(s, -c, 0.0), DVec3::Y, 1.5)
        };
        assert!(at(41.80).is_some() && at(41.82).is_none());
        assert!((asin(1.0 / 1.5) / radians(1.0) - 41.81).abs() < 0.005);
        assert!(sin(radians(41.81)) * 1.5 > 0.999_9);
    }

    #[test]
    fn reflection_keeps_length_and_angle() {
        let n = DVec3::new(0.6, 0.8, 0.0);
        let d = DVec3::new(0.2, -3.0, 1.0);
        let r = reflect(d, n);
        assert!((r.length() - d.length()).abs() < 1e-12 && (r.dot(n) + d.dot(n)).abs() < 1e-12);
    }
}
