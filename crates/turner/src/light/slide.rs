//! Slides: the image that a spot light projects.
//!
//! ```text
//!          up
//!           |  .-----. (0,0) at the upper left, seen from the light
//!   light o-|--|--+--|---> axis through the centre of the image
//!              '-----'
//!             distance 1: half a width of tan(fov / 2)
//! ```

use crate::color::{Spectrum, srgb_decode};
use crate::image::Image;
use crate::math::elementary::tan;
use crate::math::{DVec2, DVec3, radians};
use crate::schema::error::escape;
use crate::schema::{Asset, ErrorCode, ImageId, SceneError, choice};
use crate::texture::Wrap;

choice! {
    /// What the values of a projected image are.
    pub enum SlideUnits {
        /// Factors of the radiant intensity in each direction, as in pbrt.
        Intensity = "intensity",
        /// Factors of the irradiance on a screen at right angles to the axis, which a projector keeps even: the intensity
        /// grows with 1 / cos³ of the angle from the axis.
        Irradiance = "irradiance",
    }
}

/// Widest field of view, degrees.
const MAX_FOV: f64 = 170.0;

/// A slide in front of a light.
#[derive(Clone, Debug)]
pub(super) struct Slide {
    width: u32,
    height: u32,
    /// Linear colours, row by row.
    pixels: Vec<[f32; 3]>,
    axis: DVec3,
    right: DVec3,
    down: DVec3,
    /// Half of the sides at distance 1.
    half: DVec2,
    units: SlideUnits,
    wrap: Wrap,
}

/// How an image is projected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Projection {
    /// Where the upper edge is.
    pub(super) up: DVec3,
    /// The angle that the image fills from left to right, degrees.
    pub(super) fov: f64,
    /// Width over height; that of the image with square pixels if not given.
    pub(super) aspect: Option<f64>,
    pub(super) units: SlideUnits,
    /// What is beside the outermost pixel centres.
    pub(super) wrap: Wrap,
}

impl Slide {
    /// `axis` is a unit vector.
    pub(super) fn new(
        asset: &Asset<Image>,
        axis: DVec3,
        projection: &Projection,
    ) -> Result<Slide, SceneError> {
        let Projection { up, fov, aspect, units, wrap } = *projection;
        let image = &*asset.data;
        if !image.is_consistent() || image.width == 0 || image.height == 0 {
            let message = format!("the samples of {} do not fit its size", escape(&asset.uri));
            return Err(SceneError::new(ErrorCode::Image, message));
        }
        let right = axis.cross(up).try_normalize().unwrap_or_else(|| axis.any_orthonormal_vector());
        let is_encoded = image.is_display_encoded();
        let count = image.width as usize * image.height as usize;
        let mut pixels = Vec::new();
        pixels.try_reserve_exact(count).map_err(|_| {
            let message = format!("{} is too large to be projected", escape(&asset.uri));
            SceneError::new(ErrorCode::TooLarge, message)
        })?;
        for y in 0..image.height {
            pixels.extend((0..image.width).map(|x| {
                image.rgb(x, y).map(|v| {
                    let v = if is_encoded { srgb_decode(v) } else { v };
                    if v >= 0.0 && v.is_finite() { v } else { 0.0 }
                })
            }));
        }
        let half = tan(radians(0.5 * fov.clamp(1e-3, MAX_FOV)));
        let aspect = aspect.unwrap_or(f64::from(image.width) / f64::from(image.height));
        let half = DVec2::new(half, half / aspect);
        let (width, height) = (image.width, image.height);
        Ok(Slide { width, height, pixels, axis, right, down: axis.cross(right), half, units, wrap })
    }

    /// The largest factor of the intensity, on average over the colours.
    pub(super) fn peak(&self) -> f64 {
        let most = self.pixels.iter().map(|p| Spectrum::from(*p).luminance()).fold(0.0, f32::max);
        let corner = 1.0 + self.half.length_squared();
        f64::from(most) * if self.units == SlideUnits::Irradiance { corner * corner.sqrt() } else { 1.0 }
    }

    /// The factor of the intensity in a direction of any length; black beside the image.
    pub(super) fn factor(&self, direction: DVec3) -> Spectrum {
        let z = direction.dot(self.axis);
        let x = direction.dot(self.right) / (z * self.half.x);
        let y = direction.dot(self.down) / (z * self.half.y);
        // Also false for NaN.
        if !(z > 0.0 && x.abs() <= 1.0 && y.abs() <= 1.0) {
            return Spectrum::BLACK;
        }
        let color = self.at(0.5 + 0.5 * x, 0.5 + 0.5 * y);
        match self.units {
            SlideUnits::Intensity => color,
            SlideUnits::Irradiance => {
                let per_cosine = direction.length() / z;
                color * (per_cosine * per_cosine * per_cosine) as f32
            }
        }
    }

    /// The colour at (u, v), bilinear between pixel centres.
    fn at(&self, u: f64, v: f64) -> Spectrum {
        let (x0, x1, fx) = self.wrap.neighbours(u, self.width);
        let (y0, y1, fy) = self.wrap.neighbours(v, self.height);
        let pixel = |x: u32, y: u32| {
            let i = y as usize * self.width as usize + x as usize;
            self.pixels.get(i).map_or(Spectrum::BLACK, |p| Spectrum::from(*p))
        };
        let row = |y: u32| pixel(x0, y).lerp(pixel(x1, y), fx);
        row(y0).lerp(row(y1), fy)
    }
}

/// The slide of a light that has one.
pub(super) fn slide_of(
    id: ImageId,
    images: &[Asset<Image>],
    axis: DVec3,
    projection: &Projection,
) -> Result<Slide, SceneError> {
    let asset = images.get(id.index()).ok_or_else(|| {
        SceneError::new(ErrorCode::Internal, "a spot light refers to an image that the scene does not have")
    })?;
    Slide::new(asset, axis, projection)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Pixels;
    use std::sync::Arc;

    fn slide(units: SlideUnits) -> Slide {
        let pixels = Pixels::F32((0..4 * 2).map(|i| i as f32).collect());
        let image = Image { width: 4, height: 2, channels: 1, pixels };
        let asset = Asset { uri: String::new(), data: Arc::new(image) };
        let wrap = Wrap::Clamp;
        let projection = Projection { up: DVec3::Y, fov: 90.0, aspect: None, units, wrap };
        Slide::new(&asset, DVec3::NEG_Z, &projection).unwrap()
    }

    /// At the left edge an image that repeats is the mean of its first and last column.
    #[test]
    fn edges_fade_to_what_the_image_continues_with() {
        let edge = DVec3::new(-0.9999, -0.25, -1.0);
        let clamped = slide(SlideUnits::Intensity);
        assert!((clamped.factor(edge).g - 4.0).abs() < 1e-5, "{:?}", clamped.factor(edge));
        let repeated = Slide { wrap: Wrap::Repeat, ..clamped };
        assert!((repeated.factor(edge).g - 5.5).abs() < 0.01, "{:?}", repeated.factor(edge));
    }

    /// At distance 1 the image of 4 x 2 pixels spans x of −1 to 1 and y of −0.5 to 0.5.
    #[test]
    fn pixels_lie_where_the_light_projects_them() {
        let slide = slide(SlideUnits::Intensity);
        for (i, x) in [-0.75, -0.25, 0.25, 0.75].into_iter().enumerate() {
            for (j, y) in [0.25, -0.25].into_iter().enumerate() {
                let found = slide.factor(DVec3::new(x, y, -1.0) * 3.0);
                assert!((found.g - (4 * j + i) as f32).abs() < 1e-5, "{x} {y}: {found:?}");
            }
        }
        assert!((slide.factor(DVec3::new(0.0, 0.0, -1.0)).g - 3.5).abs() < 1e-5);
        for beside in [DVec3::new(1.01, 0.0, -1.0), DVec3::new(0.0, 0.51, -1.0), DVec3::Z, DVec3::ZERO] {
            assert_eq!(slide.factor(beside), Spectrum::BLACK);
        }
    }

    /// E = I cos³ / d² on a screen at distance d.
    #[test]
    fn irradiance_on_a_screen_is_even() {
        let (plain, even) = (slide(SlideUnits::Intensity), slide(SlideUnits::Irradiance));
        for p in [DVec3::new(0.8, 0.1, -1.0), DVec3::new(-0.5, -0.4, -1.0), DVec3::NEG_Z] {
            let cos = p.normalize().z.abs();
            let irradiance = f64::from(even.factor(p).g) * cos * cos * cos;
            assert!((irradiance - f64::from(plain.factor(p).g)).abs() < 1e-5);
            assert!(f64::from(even.factor(p).g) <= even.peak() + 1e-6);
        }
    }
}
