//! Spot light: light from one point, or from a sphere, into a cone.
//!
//! A spot light with a `radius` emits from points inside a sphere. At r times the radius their density is proportional to
//! 1 / √(1 − r²). With this density (the inverse Abel transform of a disk) the sphere looks like a uniform disk from every
//! direction, so it casts the soft shadows of a disk that faces the lit point. The irradiance is that of the disk, too; it
//! stays finite inside the sphere.

use std::f64::consts::PI;
use std::sync::Arc;

use super::point::from_point;
use super::profile::OrientedProfile;
use super::slide::{Projection, Slide, SlideUnits, slide_of};
use super::{Attenuation, DEFAULT_POSITION, Illumination, LightBound, ProfileUnits};
use crate::color::Spectrum;
use crate::image::Image;
use crate::math::elementary::{cos, sin};
use crate::math::{DVec2, DVec3, Frame, radians};
use crate::sampler::concentric_disk;
use crate::schema::{Asset, ErrorCode, ImageId, ProfileFile, Range, SceneError, params};
use crate::texture::Wrap;

params! {
    /// Light from one point into a cone with a soft edge. A `radius` makes its shadows soft.
    pub struct SpotDesc as "spot" {
        /// Position of the light.
        position: DVec3, required, default DEFAULT_POSITION;
        /// The point that the light is aimed at.
        look_at: DVec3 = DVec3::ZERO;
        /// Angle from the axis to the edge of the cone, in degrees; there is no light outside.
        angle: f64 = 30.0, in Range { min: 0.0, open_min: true, max: 180.0, open_max: false };
        /// Width of the soft edge, in degrees inwards from `angle`.
        penumbra: f64 = 5.0, in Range::closed(0.0, 180.0);
        /// Colour of the light.
        color: Spectrum = Spectrum::WHITE;
        /// Strength of the light on the axis.
        intensity: f64 = 1.0, in Range::NON_NEGATIVE;
        /// Radius of the light in scene units: the larger, the softer its shadows. The light itself is invisible.
        radius: f64 = 0.0, in Range::NON_NEGATIVE;
        /// How the light falls off with distance.
        attenuation: Attenuation = Attenuation::NONE;
        /// IES file with the measured intensity in each direction, as for the point light. The cone still limits it.
        ies: Option<ProfileFile> = None;
        /// How the values of the IES file are used.
        ies_units: ProfileUnits = ProfileUnits::Relative;
        /// Rotation of the IES profile about the axis of the spot, degrees.
        ies_rotation: f64 = 0.0;
        /// An image that the light projects like a slide, its centre on the axis; there is no light beside it. The cone
        /// still limits it.
        image: Option<ImageId> = None;
        /// The angle that the image fills from left to right, degrees. Default: the cone. At most 170.
        image_fov: Option<f64> = None, in Range { min: 0.0, open_min: true, max: 180.0, open_max: false };
        /// Width over height of the projected image. Default: that of the file, with square pixels.
        image_aspect: Option<f64> = None, in Range::POSITIVE;
        /// Where the upper edge of the image is.
        image_up: DVec3 = DVec3::Y;
        /// What the values of the image are.
        image_units: SlideUnits = SlideUnits::Intensity;
        /// What the outer halves of the border pixels fade to: with "repeat", the pixels at the opposite border.
        image_wrap: Wrap = Wrap::Clamp;
    }
    example r#"[[light]]
type = "spot"
position = [0, 5, 3]
look_at = [0, 0, 0]
angle = 20
penumbra = 6
"#
}

/// A spot light, prepared.
#[derive(Clone, Debug)]
pub struct Spot {
    position: DVec3,
    /// Its z is the axis.
    frame: Frame,
    radius: f64,
    /// Cosines of the angle at the edge and of the angle at which full intensity begins.
    cos_rim: f64,
    cos_full: f64,
    intensity: Spectrum,
    attenuation: Attenuation,
    profile: Option<OrientedProfile>,
    slide: Option<Arc<Slide>>,
}

impl SpotDesc {
    pub(super) fn prepare(&self, images: &[Asset<Image>]) -> Result<Spot, SceneError> {
        let axis = (self.look_at - self.position).try_normalize().ok_or_else(|| {
            SceneError::new(
                ErrorCode::OutOfRange,
                "a spot light's `position` and `look_at` are the same point",
            )
        })?;
        let orient = |file| OrientedProfile::new(file, axis, self.ies_rotation, self.ies_units);
        let profile = self.ies.as_ref().map(orient).transpose()?;
        let fov = self.image_fov.unwrap_or(2.0 * self.angle);
        let projection = Projection {
            up: self.image_up,
            fov,
            aspect: self.image_aspect,
            units: self.image_units,
            wrap: self.image_wrap,
        };
        let slide = self.image.map(|id| slide_of(id, images, axis, &projection)).transpose()?.map(Arc::new);
        Ok(Spot {
            position: self.position,
            frame: Frame::from_z(axis),
            radius: self.radius,
            cos_rim: cos(radians(self.angle)),
            cos_full: cos(radians((self.angle - self.penumbra).max(0.0))),
            intensity: self.color * self.intensity as f32,
            attenuation: self.attenuation,
            profile,
            slide,
        })
    }
}

impl Spot {
    /// Its radius; 0 for a point.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// The point of the light sampled by `u` in the unit square.
    #[inline]
    pub(super) fn point(&self, u: DVec2) -> DVec3 {
        if self.radius == 0.0 {
            return self.position;
        }
        let d = concentric_disk(u);
        // The third number: the place within one of 4096 strata of the first.
        let w = (u.x * 4096.0).fract();
        let depth = (1.0 - d.length_squared()).max(0.0).sqrt() * sin(PI * (w - 0.5));
        self.position + self.radius * self.frame.to_world(d.extend(depth))
    }

    /// Its position, the centre.
    pub(super) fn position(&self) -> DVec3 {
        self.position
    }

    pub(super) fn bound(&self) -> Option<LightBound> {
        let peak = self.profile.as_ref().map_or(1.0, OrientedProfile::peak)
            * self.slide.as_ref().map_or(1.0, |slide| slide.peak());
        let power = f64::from(self.intensity.luminance()) * peak * self.attenuation.far()?;
        let cone = LightBound::cone(self.position, self.frame.z, self.cos_full, self.cos_rim, power);
        Some(LightBound { radius: self.radius, ..cone })
    }

    /// Light at `p` from a point of the sphere, with the intensity of its projection onto the disk that faces `p`.
    fn light_of_disk(&self, point: DVec3, p: DVec3) -> Option<Illumination> {
        let (to_light, to_center) = (point - p, self.position - p);
        let distance = to_center.length();
        if distance == 0.0 || to_light == DVec3::ZERO {
            return None;
        }
        let beside = (point - self.position).reject_from(to_center);
        let to_disk = (distance * distance + beside.length_squared()).sqrt();
        let factor = self.attenuation.factor(to_disk) * (distance / to_disk);
        Some(Illumination { to_light, finite: true, intensity: self.intensity * factor as f32 })
    }

    /// Light at `p` from the point of the light sampled by `u`, with the intensity of the whole light.
    #[inline]
    pub(super) fn illuminate(&self, p: DVec3, u: DVec2) -> Option<Illumination> {
        let mut light = if self.radius == 0.0 {
            from_point(self.position, self.intensity, &self.attenuation, p)?
        } else {
            self.light_of_disk(self.point(u), p)?
        };
        let cos = -light.to_light.dot(self.frame.z) / light.to_light.length();
        if cos < self.cos_rim {
            return None;
        }
        if let Some(profile) = &self.profile {
            light.intensity *= profile.factor(-light.to_light);
        }
        if let Some(slide) = &self.slide {
            light.intensity = light.intensity * slide.factor(-light.to_light);
        }
        if cos < self.cos_full {
            // Hermite smooth step over the penumbra.
            let x = (cos - self.cos_rim) / (self.cos_full - self.cos_rim);
            light.intensity *= (x * x * (3.0 - 2.0 * x)) as f32;
        }
        Some(light)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::Light;
    use crate::testing::Random;

    fn soft(radius: f64) -> Spot {
        let desc =
            SpotDesc { position: DVec3::new(1.0, 2.0, 3.0), radius, angle: 90.0, ..SpotDesc::default() };
        desc.prepare(&[]).unwrap()
    }

    /// From every side the points cover a disk evenly.
    #[test]
    fn it_looks_like_a_disk_from_every_side() {
        const POINTS: u32 = 1 << 20;
        let spot = soft(2.0);
        let mut random = Random::new(3);
        for view in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 2.0, 3.0), DVec3::new(-1.0, 0.4, 0.2)] {
            let frame = Frame::from_z(view.normalize());
            // Rings and sectors of equal areas.
            let mut counts = [[0u32; 8]; 8];
            for _ in 0..POINTS {
                let [x, y, ..] = random.units::<4>();
                let u = DVec2::new(x, y);
                let at = frame.to_local(spot.point(u) - spot.position()) / 2.0;
                let ring = at.x * at.x + at.y * at.y;
                assert!(at.length() <= 1.0 + 1e-12);
                let quarter = (usize::from(at.x > 0.0) << 1) | usize::from(at.y > 0.0);
                let sector = quarter << 1 | usize::from(at.x.abs() > at.y.abs());
                counts[((ring * 8.0) as usize).min(7)][sector] += 1;
            }
            let expected = f64::from(POINTS) / 64.0;
            for count in counts.as_flattened() {
                let ratio = f64::from(*count) / expected;
                assert!((ratio - 1.0).abs() < 0.04, "{view}: {ratio}");
            }
        }
    }

    #[test]
    fn samples_share_the_intensity() {
        for (radius, samples) in [(0.0, 1), (0.5, 16)] {
            let light = Light::Spot(soft(radius));
            assert_eq!((light.samples(), light.is_jittered()), (samples, radius > 0.0));
            // So far away that the cosine at the light is 1.
            let p = DVec3::new(1.0, 2.0, 3.0) * -1000.0;
            let share = |i| light.illuminate(p, i, DVec2::new(0.3, 0.8)).unwrap().intensity.g;
            assert!(((0..samples).map(share).sum::<f32>() - 1.0).abs() < 1e-5);
        }
    }
}
