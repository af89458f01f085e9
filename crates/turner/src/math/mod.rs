//! Vectors, rays, bounds, frames and elementary functions.
//!
//! Positions and directions outside `turner-bvh` are `f64`: the classic documents assume real numbers, and a
//! sphere of radius 5000 seen from one unit away needs them. Colours are `f32` ([`crate::color::Spectrum`]).

mod bounds;
pub mod elementary;
mod frame;
mod ray;

pub use bounds::Bounds;
pub use frame::Frame;
pub use glam::{DAffine3, DMat3, DVec2, DVec3};
pub use ray::Ray;

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
