//! Vectors, rays, bounds, frames and elementary functions.
//!
//! Positions and directions outside `turner-bvh` are `f64`: the classic documents assume real numbers, and a sphere
//! of radius 5000 seen from one unit away needs the precision. Colours are `f32` ([`crate::color::Spectrum`]).

pub mod block;
mod bounds;
pub mod elementary;
pub mod elementary_x8;
mod frame;
pub mod frame_x8;
pub mod gaussian;
pub mod gaussian_x8;
mod ray;
mod ray_cone;

pub use bounds::Bounds;
pub use frame::Frame;
pub use glam::{DAffine3, DMat3, DVec2, DVec3};
pub use ray::Ray;
pub use ray_cone::RayCone;

/// Mirror reflection: the direction `d` reflected at the plane with unit normal `n`, d − 2 (d·n) n. `d` points
/// towards the surface, the result away from it.
pub fn reflect(d: DVec3, n: DVec3) -> DVec3 {
    d - 2.0 * d.dot(n) * n
}

/// Refraction by Snell's law. `d` is the unit direction towards the surface, `n` the unit normal on the side `d`
/// comes from (d·n ≤ 0), `eta` the index of refraction of the incident medium divided by that of the transmitting
/// one. `None` is total internal reflection.
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

/// Radians to degrees: the value that [`radians`] converts back to the same bits if there is one, else the nearest.
pub fn degrees(radians: f64) -> f64 {
    let nearest = radians * (180.0 / std::f64::consts::PI);
    if !nearest.is_finite() {
        return nearest;
    }
    let distance = |d: &f64| (self::radians(*d) - radians).abs();
    // The first of equal candidates: integers stay integers.
    [nearest.round(), nearest, nearest.next_up(), nearest.next_down()]
        .into_iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap_or(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use elementary::{asin, sin, sin_cos};

    #[test]
    fn degrees_round_trip() {
        use std::f64::consts::{FRAC_PI_2, PI, TAU};
        assert_eq!([0.0, FRAC_PI_2, -PI, TAU].map(degrees), [0.0, 90.0, -180.0, 360.0]);
        let (mut same, n) = (0, 1000);
        for i in 0..n {
            let angle = (f64::from(i) - 300.0) * 0.012_345;
            let back = radians(degrees(angle));
            assert!((back - angle).abs() <= 2.0 * f64::EPSILON * angle.abs(), "{angle}: {back}");
            same += u32::from(back == angle);
        }
        // Just above a power of two, degrees are coarser than radians.
        assert!(same > 900, "{same} of {n}");
        assert!(degrees(f64::NAN).is_nan() && degrees(f64::INFINITY) == f64::INFINITY);
    }

    #[test]
    fn snells_law() {
        for degrees in [0.0, 1.0, 30.0, 41.8, 60.0, 89.9] {
            let (s, c) = sin_cos(radians(degrees));
            let d = DVec3::new(s, -c, 0.0);
            let t = refract(d, DVec3::Y, 1.0 / 1.5).unwrap();
            assert!((t.x - s / 1.5).abs() < 1e-12 && (t.length() - 1.0).abs() < 1e-12);
            assert!(t.y < 0.0 && t.z == 0.0);
            // The path of light is reversible.
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
