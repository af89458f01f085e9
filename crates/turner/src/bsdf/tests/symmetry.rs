//! Reciprocity: a way through the surface carries the same light both ways.

use super::energy::{direction, spread};
use super::materials::materials;
use crate::bsdf::{Bsdf, PrincipledPoint};
use crate::math::DVec3;

fn assert_close(a: crate::color::Spectrum, b: crate::color::Spectrum, what: &str) {
    for (x, y) in a.to_array().into_iter().zip(b.to_array()) {
        assert!((x - y).abs() <= 2e-5 * x.abs().max(y.abs()) + 1e-7, "{what}: {a:?} and {b:?}");
    }
}

#[test]
fn reflection_is_reciprocal() {
    for (name, point) in materials() {
        let bsdf = Bsdf::new(&point);
        for k in 0..200 {
            let [a, b, c] = spread(k);
            let (wo, wi) = (direction(a * 0.99 + 0.01, c * 7.0), direction(b * 0.99 + 0.01, c * 23.0));
            assert_close(bsdf.eval(wo, wi), bsdf.eval(wi, wo), name);
        }
    }
}

/// The same surface and direction seen from the other side: the frame turned by half a turn around x.
fn behind(w: DVec3) -> DVec3 {
    DVec3::new(w.x, -w.y, -w.z)
}

#[test]
fn transmission_is_reciprocal_up_to_the_square_of_the_index() {
    let mut compared = 0;
    for (name, point) in materials() {
        let there = Bsdf::new(&point);
        // Turned around, the direction of anisotropy runs the other way.
        let turned = -point.anisotropy_rotation;
        let back =
            Bsdf::new(&PrincipledPoint { entering: !point.entering, anisotropy_rotation: turned, ..point });
        let eta = match (point.thin_walled, point.entering) {
            (true, _) => 1.0,
            (false, true) => point.specular_ior,
            (false, false) => 1.0 / point.specular_ior,
        };
        for k in 0..300 {
            let [a, b, c] = spread(k);
            let (wo, wi) = (direction(a * 0.99 + 0.01, c * 7.0), -direction(b * 0.99 + 0.01, c * 23.0));
            let f = there.eval(wo, wi);
            compared += u32::from(f.max_component() > 0.0);
            assert_close(f * (eta * eta) as f32, back.eval(behind(wi), behind(wo)), name);
        }
    }
    assert!(compared > 1000, "{compared}");
}
