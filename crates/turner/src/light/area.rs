//! Area lights: rectangle, disk and sphere, for the classic soft shadow. Shadow rays go to several points of the
//! light, one in each stratum, and the results are averaged.

use super::point::from_point;
use super::{Attenuation, DEFAULT_POSITION, Illumination, LightBound};
use crate::color::Spectrum;
use crate::math::{DVec2, DVec3, Frame};
use crate::sampler::{concentric_disk, stratified, uniform_sphere};
use crate::schema::{ErrorCode, Range, SceneError, params};

params! {
    /// A rectangular light for soft shadows. The light itself is invisible.
    pub struct RectangleLightDesc as "rectangle" {
        /// The centre.
        center: DVec3, required, default DEFAULT_POSITION;
        /// One edge, as a vector.
        edge_u: DVec3 = DVec3::X;
        /// The other edge.
        edge_v: DVec3 = DVec3::Z;
        /// Number of shadow rays per shading point, one in each stratum of the light.
        samples: u32 = 16, in Range::closed(1.0, 65536.0);
        /// Whether each shadow ray goes to a random point of its stratum (noise) or to its centre (banding).
        jitter: bool = true;
        /// Colour of the light.
        color: Spectrum = Spectrum::WHITE;
        /// Strength of the light, summed over its area.
        intensity: f64 = 1.0, in Range::NON_NEGATIVE;
        /// How the light falls off with distance.
        attenuation: Attenuation = Attenuation::NONE;
    }
    example r#"[[light]]
type = "rectangle"
center = [0, 5, 2]
edge_u = [2, 0, 0]
edge_v = [0, 0, 2]
samples = 16
"#
}

params! {
    /// A disk-shaped light for soft shadows. The light itself is invisible.
    pub struct DiskLightDesc as "disk" {
        /// The centre.
        center: DVec3, required, default DEFAULT_POSITION;
        /// The direction of its axis.
        normal: DVec3 = DVec3::NEG_Y;
        /// The radius.
        radius: f64 = 1.0, in Range::POSITIVE;
        /// Number of shadow rays per shading point, one in each stratum of the light.
        samples: u32 = 16, in Range::closed(1.0, 65536.0);
        /// Whether each shadow ray goes to a random point of its stratum (noise) or to its centre (banding).
        jitter: bool = true;
        /// Colour of the light.
        color: Spectrum = Spectrum::WHITE;
        /// Strength of the light, summed over its area.
        intensity: f64 = 1.0, in Range::NON_NEGATIVE;
        /// How the light falls off with distance.
        attenuation: Attenuation = Attenuation::NONE;
    }
    example r#"[[light]]
type = "disk"
center = [0, 5, 2]
radius = 1
"#
}

params! {
    /// A spherical light for soft shadows. The light itself is invisible.
    pub struct SphereLightDesc as "sphere" {
        /// The centre.
        center: DVec3, required, default DEFAULT_POSITION;
        /// The radius.
        radius: f64 = 0.5, in Range::POSITIVE;
        /// Number of shadow rays per shading point, one in each stratum of the light.
        samples: u32 = 16, in Range::closed(1.0, 65536.0);
        /// Whether each shadow ray goes to a random point of its stratum (noise) or to its centre (banding).
        jitter: bool = true;
        /// Colour of the light.
        color: Spectrum = Spectrum::WHITE;
        /// Strength of the light, summed over its area.
        intensity: f64 = 1.0, in Range::NON_NEGATIVE;
        /// How the light falls off with distance.
        attenuation: Attenuation = Attenuation::NONE;
    }
    example r#"[[light]]
type = "sphere"
center = [2, 5, 2]
radius = 0.8
"#
}

/// An area light, prepared.
#[derive(Clone, Copy, Debug)]
pub struct AreaLight {
    center: DVec3,
    form: Form,
    /// Shadow rays per shading point.
    pub samples: u32,
    /// Whether they are jittered.
    pub jitter: bool,
    /// Intensity of one sample.
    intensity: Spectrum,
    attenuation: Attenuation,
}

#[derive(Clone, Copy, Debug)]
enum Form {
    Rectangle(DVec3, DVec3),
    Disk(Frame, f64),
    Sphere(f64),
}

impl RectangleLightDesc {
    pub(super) fn prepare(&self) -> Result<AreaLight, SceneError> {
        if self.edge_u.cross(self.edge_v).length_squared() == 0.0 {
            let message = "the edges of a rectangle light are zero or parallel: it has no area";
            return Err(SceneError::new(ErrorCode::OutOfRange, message));
        }
        Ok(AreaLight {
            center: self.center,
            form: Form::Rectangle(self.edge_u, self.edge_v),
            samples: self.samples,
            jitter: self.jitter,
            intensity: self.color * (self.intensity / f64::from(self.samples)) as f32,
            attenuation: self.attenuation,
        })
    }
}

impl DiskLightDesc {
    pub(super) fn prepare(&self) -> Result<AreaLight, SceneError> {
        let normal = self.normal.try_normalize().ok_or_else(|| {
            SceneError::new(ErrorCode::OutOfRange, "the normal of a disk light must not be zero")
        })?;
        Ok(AreaLight {
            center: self.center,
            form: Form::Disk(Frame::from_z(normal), self.radius),
            samples: self.samples,
            jitter: self.jitter,
            intensity: self.color * (self.intensity / f64::from(self.samples)) as f32,
            attenuation: self.attenuation,
        })
    }
}

impl SphereLightDesc {
    pub(super) fn prepare(&self) -> AreaLight {
        AreaLight {
            center: self.center,
            form: Form::Sphere(self.radius),
            samples: self.samples,
            jitter: self.jitter,
            intensity: self.color * (self.intensity / f64::from(self.samples)) as f32,
            attenuation: self.attenuation,
        }
    }
}

impl AreaLight {
    /// Points of the light emit equally in all directions.
    pub(super) fn bound(&self) -> Option<LightBound> {
        let radius = match &self.form {
            Form::Rectangle(a, b) => 0.5 * (*a + *b).length().max((*a - *b).length()),
            Form::Disk(_, radius) | Form::Sphere(radius) => *radius,
        };
        let power =
            f64::from(self.intensity.luminance()) * f64::from(self.samples) * self.attenuation.far()?;
        Some(LightBound::everywhere(self.center, radius, power))
    }

    pub(super) fn illuminate(&self, p: DVec3, i: u32, jitter: DVec2) -> Option<Illumination> {
        let u = stratified(i, self.samples, if self.jitter { jitter } else { DVec2::splat(0.5) });
        from_point(self.point(u), self.intensity, &self.attenuation, p)
    }

    /// Light from the point at `u` in the unit square, which carries the power of the complete light.
    pub(super) fn illuminate_at(&self, p: DVec3, u: DVec2) -> Option<Illumination> {
        from_point(self.point(u), self.intensity * self.samples as f32, &self.attenuation, p)
    }

    /// The point of the light at `u` in the unit square.
    pub(super) fn point(&self, u: DVec2) -> DVec3 {
        match &self.form {
            Form::Rectangle(a, b) => self.center + (u.x - 0.5) * *a + (u.y - 0.5) * *b,
            Form::Disk(frame, radius) => {
                let d = concentric_disk(u) * *radius;
                self.center + d.x * frame.x + d.y * frame.y
            }
            Form::Sphere(radius) => self.center + *radius * uniform_sphere(u),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_share_the_intensity_and_stay_on_the_light() {
        let light = DiskLightDesc {
            center: DVec3::new(0.0, 5.0, 0.0),
            radius: 2.0,
            samples: 7,
            intensity: 3.0,
            ..DiskLightDesc::default()
        }
        .prepare()
        .unwrap();
        let mut total = 0.0;
        for i in 0..7 {
            let l = light.illuminate(DVec3::ZERO, i, DVec2::new(0.3, 0.9)).unwrap();
            assert!((l.to_light.y - 5.0).abs() < 1e-12 && l.to_light.length() <= 29.0f64.sqrt() + 1e-12);
            total += l.intensity.g;
        }
        assert!((total - 3.0).abs() < 1e-5);
    }
}
