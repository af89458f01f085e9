//! Reciprocity: exchanging wo and wi gives the same f, or f · eta² across the surface.

use crate::bsdf::{Bsdf, PrincipledPoint};
use crate::testing::{direction, materials, reciprocity_error};

const ROUNDING: f64 = 2e-5;

#[test]
fn reflection_is_reciprocal() {
    for (name, point) in materials() {
        let error = reciprocity_error(&Bsdf::new(&point), None, 200);
        assert!(error < ROUNDING, "{name}: {error}");
    }
}

#[test]
fn transmission_is_reciprocal_up_to_the_square_of_the_index() {
    let mut transmitting = 0;
    for (name, point) in materials() {
        // Seen from the other side, the anisotropy rotates the other way.
        let rotation = -point.anisotropy_rotation;
        let back = PrincipledPoint { entering: !point.entering, anisotropy_rotation: rotation, ..point };
        let eta = match (point.thin_walled, point.entering) {
            (true, _) => 1.0,
            (false, true) => point.specular_ior,
            (false, false) => 1.0 / point.specular_ior,
        };
        let error = reciprocity_error(&Bsdf::new(&point), Some((&Bsdf::new(&back), eta)), 300);
        assert!(error < ROUNDING, "{name}: {error}");
        let through = Bsdf::new(&point).eval(direction(0.8, 0.0), -direction(0.9, 3.0));
        transmitting += u32::from(through.max_component() > 0.0);
    }
    assert!(transmitting >= 5, "{transmitting}");
}
