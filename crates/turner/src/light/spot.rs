//! Spot light: light from one point into a cone.

use std::sync::Arc;

use super::point::from_point;
use super::profile::OrientedProfile;
use super::slide::{Projection, Slide, SlideUnits, slide_of};
use super::{Attenuation, DEFAULT_POSITION, Illumination, LightBound, ProfileUnits};
use crate::color::Spectrum;
use crate::image::Image;
use crate::math::elementary::cos;
use crate::math::{DVec3, radians};
use crate::schema::{Asset, ErrorCode, ImageId, ProfileFile, Range, SceneError, params};
use crate::texture::Wrap;

params! {
    /// Light from one point into a cone with a soft edge.
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
    axis: DVec3,
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
            axis,
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
    /// Its position.
    pub(super) fn position(&self) -> DVec3 {
        self.position
    }

    pub(super) fn bound(&self) -> Option<LightBound> {
        let peak = self.profile.as_ref().map_or(1.0, OrientedProfile::peak)
            * self.slide.as_ref().map_or(1.0, |slide| slide.peak());
        let power = f64::from(self.intensity.luminance()) * peak * self.attenuation.far()?;
        Some(LightBound::cone(self.position, self.axis, self.cos_full, self.cos_rim, power))
    }

    #[inline]
    pub(super) fn illuminate(&self, p: DVec3) -> Option<Illumination> {
        let mut light = from_point(self.position, self.intensity, &self.attenuation, p)?;
        let cos = -light.to_light.dot(self.axis) / light.to_light.length();
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
