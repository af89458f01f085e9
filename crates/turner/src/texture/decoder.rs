//! Decoding image samples to scene values.

use crate::color::{Spectrum, Transfer};
use crate::image::{Image, Pixels};

/// Lookup tables from integer samples to scene values, shared by all images of a scene.
#[derive(Clone, Debug)]
pub(super) struct Decoder {
    eight: Box<[f32; 256]>,
    /// Empty until a 16-bit image needs it.
    sixteen: Box<[f32]>,
}

impl Default for Decoder {
    fn default() -> Decoder {
        Decoder::new(Transfer::default())
    }
}

impl Decoder {
    /// With the table for 8 bits; [`Decoder::include`] adds the one for 16 bits.
    pub(super) fn new(transfer: Transfer) -> Decoder {
        let eight = std::array::from_fn(|v| transfer.decode(v as f32 / 255.0));
        Decoder { eight: Box::new(eight), sixteen: Box::default() }
    }

    /// Adds the table that an image needs.
    pub(super) fn include(&mut self, image: &Image, transfer: Transfer) {
        if matches!(image.pixels, Pixels::U16(_)) && self.sixteen.is_empty() {
            self.sixteen = (0..=u16::MAX).map(|v| transfer.decode(f32::from(v) / 65535.0)).collect();
        }
    }

    /// Bytes of the tables.
    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.eight) + size_of_val(&*self.sixteen)
    }

    /// The texels at these (x, y), which must be inside the image.
    #[inline]
    pub(super) fn texels<const N: usize>(&self, image: &Image, at: [[u32; 2]; N]) -> [Spectrum; N] {
        match &image.pixels {
            Pixels::U8(v) => bands(image, v, at, |v| self.eight[usize::from(v)]),
            Pixels::U16(v) => bands(image, v, at, |v| self.sixteen[usize::from(v)]),
            Pixels::F32(v) => bands(image, v, at, |v| if v.is_finite() { v } else { 0.0 }),
        }
    }
}

/// The bands at these (x, y) of an image with these samples. Greyscale repeats its channel.
#[inline(always)]
fn bands<V: Copy, const N: usize>(
    image: &Image,
    samples: &[V],
    at: [[u32; 2]; N],
    decode: impl Fn(V) -> f32,
) -> [Spectrum; N] {
    let (n, width) = (usize::from(image.channels), image.width as usize);
    let first = at.map(|[x, y]| (y as usize * width + x as usize) * n);
    if n < 3 {
        return first.map(|i| Spectrum::grey(decode(samples[i])));
    }
    first.map(|i| match samples[i..] {
        [r, g, b, ..] => Spectrum::new(decode(r), decode(g), decode(b)),
        _ => Spectrum::BLACK,
    })
}
