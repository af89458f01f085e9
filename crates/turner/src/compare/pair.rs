//! Two images prepared for comparison, or the reason why they cannot be compared.

use std::fmt;

use crate::color::srgb_encode;
use crate::image::Image;

/// An image prepared for comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Canvas {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Colours multiplied by alpha, and alpha; row by row from the top.
    pub pixels: Vec<[f32; 4]>,
    /// Whether a pixel has an alpha other than 1.
    pub has_alpha: bool,
    /// Whether colours are linear light rather than display values.
    pub is_linear: bool,
}

impl Canvas {
    /// From an image; grey becomes equal red, green and blue. `associated` means that its colours are already
    /// multiplied by alpha.
    pub fn new(image: &Image, associated: bool) -> Canvas {
        let places = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
        let pixels: Vec<[f32; 4]> = places
            .map(|(x, y)| {
                let (rgb, a) = (image.rgb(x, y), image.alpha(x, y));
                let [r, g, b] = if associated || a == 1.0 { rgb } else { rgb.map(|v| v * a) };
                [r, g, b, a]
            })
            .collect();
        let has_alpha = pixels.iter().any(|p| p[3] != 1.0);
        let is_linear = !image.is_display_encoded();
        Canvas { width: image.width, height: image.height, pixels, has_alpha, is_linear }
    }
}

/// Why two images cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mismatch {
    /// Their sizes differ.
    Size((u32, u32), (u32, u32)),
    /// Only one of them has transparent pixels.
    Alpha {
        /// Whether the first one is transparent.
        first: bool,
    },
    /// One holds linear light, the other display values.
    Encoding {
        /// Whether the first one is linear.
        first: bool,
    },
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let order = |first| if first { ["the first", "the second"] } else { ["the second", "the first"] };
        match *self {
            Mismatch::Size((w, h), (width, height)) => {
                write!(f, "{w}x{h} pixels against {width}x{height}")
            }
            Mismatch::Alpha { first } => {
                let [one, other] = order(first);
                write!(f, "{one} is transparent in places, {other} nowhere")
            }
            Mismatch::Encoding { first } => {
                let [one, other] = order(first);
                write!(f, "{one} holds linear light, {other} display values")
            }
        }
    }
}

impl std::error::Error for Mismatch {}

/// Pixels that are NaN or infinite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NonFinite {
    /// How many.
    pub count: u64,
    /// Column and row of the first.
    pub first: Option<(u32, u32)>,
}

impl NonFinite {
    fn add(&mut self, x: u32, y: u32) {
        self.count += 1;
        self.first.get_or_insert((x, y));
    }
}

/// Two images of the same size and encoding.
///
/// A pixel that is non-finite in either image is black in both for all metrics, because its difference would
/// make every sum non-finite. Such pixels are counted. Those that differ between the images are counted in
/// `unlike` as well; a test should treat any of them as a failure.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Whether there are transparent pixels.
    pub has_alpha: bool,
    /// Whether colours are linear light rather than display values.
    pub is_linear: bool,
    /// Non-finite pixels of the first and of the second image.
    pub non_finite: [NonFinite; 2],
    /// Pixels that are non-finite in one image and not the same in the other (NaN, or an infinity of the same
    /// sign, in the same channels).
    pub unlike: NonFinite,
    /// The reference, and the image that is compared with it.
    pub(super) pixels: [Vec<[f32; 4]>; 2],
}

impl Pair {
    /// The first is the reference.
    pub fn new(mut a: Canvas, mut b: Canvas) -> Result<Pair, Mismatch> {
        let (width, height) = (a.width, a.height);
        let pixels = width as usize * height as usize;
        if (width, height) != (b.width, b.height) || a.pixels.len() != pixels || b.pixels.len() != pixels {
            return Err(Mismatch::Size((width, height), (b.width, b.height)));
        }
        if a.is_linear != b.is_linear {
            return Err(Mismatch::Encoding { first: a.is_linear });
        }
        if a.has_alpha != b.has_alpha {
            return Err(Mismatch::Alpha { first: a.has_alpha });
        }
        let (mut non_finite, mut unlike) = ([NonFinite::default(); 2], NonFinite::default());
        for (i, (p, q)) in a.pixels.iter_mut().zip(&mut b.pixels).enumerate() {
            let bad = [&*p, &*q].map(|p| !p.iter().all(|v| v.is_finite()));
            if bad == [false; 2] {
                continue;
            }
            let (x, y) = ((i % width as usize) as u32, (i / width as usize) as u32);
            bad.iter().zip(&mut non_finite).filter(|(bad, _)| **bad).for_each(|(_, n)| n.add(x, y));
            if !p.iter().zip(q.iter()).all(|(v, w)| same(*v, *w)) {
                unlike.add(x, y);
            }
            (*p, *q) = ([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]);
        }
        let (has_alpha, is_linear) = (a.has_alpha, a.is_linear);
        let pixels = [a.pixels, b.pixels];
        Ok(Pair { width, height, has_alpha, is_linear, non_finite, unlike, pixels })
    }

    /// Channels per pixel: three colours, and alpha if there is any.
    pub(super) fn channels(&self) -> usize {
        if self.has_alpha { 4 } else { 3 }
    }

    /// Both images, pixel by pixel: the reference first.
    pub(super) fn both(&self) -> impl Iterator<Item = (&[f32; 4], &[f32; 4])> {
        self.pixels[0].iter().zip(&self.pixels[1])
    }

    /// The grey backgrounds on which transparent images are compared.
    pub(super) fn backgrounds(&self) -> &'static [f32] {
        if self.has_alpha { &[0.0, 1.0] } else { &[0.0] }
    }

    /// A pixel of one of the images on a background, in stored values.
    pub(super) fn on(&self, picture: usize, index: usize, background: f32) -> [f32; 3] {
        let [r, g, b, a] = self.pixels[picture].get(index).copied().unwrap_or([0.0, 0.0, 0.0, 1.0]);
        [r, g, b].map(|v| if a == 1.0 { v } else { v + background * (1.0 - a) })
    }

    /// [`on`](Self::on) in display values from 0 to 1: linear light is clamped and encoded as sRGB.
    pub(super) fn shown(&self, picture: usize, index: usize, background: f32) -> [f32; 3] {
        let clamped = self.on(picture, index, background).map(|v| v.clamp(0.0, 1.0));
        if self.is_linear { clamped.map(srgb_encode) } else { clamped }
    }
}

/// Equal, both NaN, or both finite.
fn same(v: f32, w: f32) -> bool {
    v == w || (v.is_nan() && w.is_nan()) || (v.is_finite() && w.is_finite())
}

#[cfg(test)]
mod tests {
    use super::super::testing::{canvas, pair};
    use super::*;
    use crate::image::Pixels;

    #[test]
    fn what_does_not_fit_is_refused() {
        let a = canvas(2, 1, |_, _| [0.5; 3]);
        let small = canvas(1, 2, |_, _| [0.5; 3]);
        let error = Pair::new(a.clone(), small).unwrap_err();
        assert_eq!(error.to_string(), "2x1 pixels against 1x2");
        let linear = Canvas { is_linear: true, ..a.clone() };
        let error = Pair::new(a.clone(), linear).unwrap_err();
        assert_eq!(error.to_string(), "the second holds linear light, the first display values");
        let see_through = Canvas { has_alpha: true, ..a.clone() };
        let error = Pair::new(see_through, a).unwrap_err();
        assert_eq!(error.to_string(), "the first is transparent in places, the second nowhere");
    }

    #[test]
    fn pixels_that_are_no_numbers_are_counted_and_black() {
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        let a = [[nan, 0.0, 0.0], [inf, 1.0, 1.0], [1.0; 3], [0.0; 3], [0.0, inf, 0.0]];
        let b = [[nan, 0.5, 0.0], [-inf, 1.0, 1.0], [1.0; 3], [nan; 3], [0.0, inf, 0.0]];
        let pair = pair(5, 1, true, |x, _| a[x as usize], |x, _| b[x as usize]);
        assert_eq!(pair.non_finite.map(|n| n.count), [3, 4]);
        assert_eq!(pair.non_finite[0].first, Some((0, 0)));
        assert_eq!(pair.unlike, NonFinite { count: 2, first: Some((1, 0)) });
        assert!(pair.both().all(|(p, q)| p == q && p.iter().all(|v| v.is_finite())));
    }

    #[test]
    fn alpha_is_multiplied_once() {
        let image = |pixels| Image { width: 1, height: 1, channels: 4, pixels };
        let straight = Canvas::new(&image(Pixels::F32(vec![0.5, 1.0, 0.0, 0.5])), false);
        assert_eq!(straight.pixels, [[0.25, 0.5, 0.0, 0.5]]);
        let stored = Canvas::new(&image(Pixels::F32(vec![0.5, 1.0, 0.0, 0.5])), true);
        assert_eq!(stored.pixels, [[0.5, 1.0, 0.0, 0.5]]);
        let opaque = Canvas::new(&image(Pixels::U8(vec![255, 0, 51, 255])), false);
        assert_eq!((opaque.pixels[0], opaque.has_alpha), ([1.0, 0.0, 0.2, 1.0], false));
        let pair = Pair::new(straight.clone(), straight).unwrap();
        assert_eq!(pair.on(0, 0, 1.0), [0.75, 1.0, 0.5]);
    }
}
