//! Ray cones: the width of the footprint of a ray, for texture filtering.
//!
//! A path carries the diameter of a cone around its ray and the growth of that diameter per unit of length
//! (Akenine-Möller et al. 2019, "Texture level of detail strategies for real-time ray tracing", and 2021, "Improved
//! shader and texture level of detail using ray cones"):
//!
//! ```text
//!              _,-'
//!          _,-'    | width + spread · t
//!    o <-:----------->  ray
//!          `-,_    |
//!              `-,_
//! ```
//!
//! Flat mirrors keep the spread, curved mirrors add to it, and refraction follows paraxial optics. After scattering
//! by a wide lobe the spread grows by the angle that the sampled direction represents, similar to Bekaert et al.
//! 2003, "Custom-made footprints". Cones only select the texture resolution.

/// The cone around a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayCone {
    /// Diameter at the start of the ray, in scene units.
    pub width: f32,
    /// Growth of the diameter per unit of length; negative where the cone narrows.
    pub spread: f32,
}

/// Upper bound of `spread`.
const MAX_SPREAD: f32 = 2.0;

impl RayCone {
    /// The diameter at distance `t`, at least 0.
    #[inline]
    pub fn width_at(&self, t: f64) -> f32 {
        let width = (self.width + self.spread * t as f32).abs();
        if width.is_nan() { 0.0 } else { width.min(1e30) }
    }

    /// The cone that starts at distance `t`.
    #[inline]
    pub fn advanced(self, t: f64) -> RayCone {
        // Past the point where its diameter is 0 the cone widens again.
        let end = self.width + self.spread * t as f32;
        let spread = if end < 0.0 { -self.spread } else { self.spread };
        RayCone { width: self.width_at(t), spread }
    }

    /// After reflection by a mirror whose normal changes by `curvature` radians per unit of length, positive where
    /// convex.
    #[inline]
    pub fn reflected(self, curvature: f64) -> RayCone {
        self.with_spread(self.spread + 2.0 * curvature as f32 * self.width)
    }

    /// After refraction into a medium with `eta` times the index of refraction (paraxial).
    #[inline]
    pub fn refracted(self, eta: f64, curvature: f64) -> RayCone {
        let inverse = if eta > 0.0 { (1.0 / eta) as f32 } else { 1.0 };
        let bend = curvature as f32 * self.width;
        self.with_spread(self.spread * inverse - bend * (1.0 - inverse))
    }

    /// After scattering by a lobe into a direction sampled with the density `pdf` per solid angle. The cone grows by
    /// a quarter of the angle that the direction represents, times `fraction`, which decreases with the samples per
    /// pixel.
    #[inline]
    pub fn scattered(self, pdf: f64, fraction: f32) -> RayCone {
        let angle = if pdf > 0.0 { (0.25 / pdf.sqrt()) as f32 } else { 0.0 };
        self.with_spread(self.spread.abs() + fraction * angle)
    }

    #[inline]
    fn with_spread(self, spread: f32) -> RayCone {
        let spread = if spread.is_nan() { 0.0 } else { spread.clamp(-MAX_SPREAD, MAX_SPREAD) };
        RayCone { spread, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cone_grows_narrows_and_grows_again() {
        let cone = RayCone { width: 1.0, spread: 0.5 };
        assert_eq!(cone.width_at(4.0), 3.0);
        assert_eq!(cone.advanced(4.0), RayCone { width: 3.0, spread: 0.5 });
        let narrowing = RayCone { width: 1.0, spread: -0.5 };
        assert_eq!(narrowing.width_at(2.0), 0.0);
        assert_eq!(narrowing.advanced(4.0), RayCone { width: 1.0, spread: 0.5 });
        assert_eq!(RayCone { width: f32::NAN, spread: 0.0 }.width_at(1.0), 0.0);
        assert!(RayCone { width: 1.0, spread: 1.0 }.width_at(f64::INFINITY) <= 1e30);
    }

    #[test]
    fn mirrors_and_lenses_follow_paraxial_optics() {
        // A concave mirror of radius 2 focuses parallel light at distance 1.
        let parallel = RayCone { width: 0.01, spread: 0.0 };
        let focused = parallel.reflected(-1.0 / 2.0);
        assert!(focused.width_at(1.0) < 1e-9);
        // A surface of radius 1 into glass of index 1.5 focuses at n·R/(n − 1) = 3.
        let inside = parallel.refracted(1.5, 1.0);
        assert!(inside.width_at(3.0) < 1e-8);
        // Flat glass divides the spread by its index.
        let entering = RayCone { width: 1.0, spread: 0.3 }.refracted(1.5, 0.0);
        assert!((entering.spread - 0.2).abs() < 1e-6);
        // Flat mirrors change nothing.
        assert_eq!(entering.reflected(0.0), entering);
        assert!(entering.scattered(0.3, 1.0).spread > entering.spread);
        assert_eq!(entering.scattered(1e-30, 1.0).spread, MAX_SPREAD);
    }
}
