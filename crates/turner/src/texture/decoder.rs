//! Decoding image samples to scene values.

use crate::color::{Spectrum, Transfer};
use crate::image::{Image, Pixels};

/// Lookup tables from integer samples to scene values, shared by all images of a scene.
#[derive(Clone, Debug)]
pub(super) struct Decoder {
    eight: Box<[f32]>,
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
        let eight = (0..=u8::MAX).map(|v| transfer.decode(f32::from(v) / 255.0)).collect();
        Decoder { eight, sixteen: Box::default() }
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

    /// Texel (x, y), which must be inside the image.
    #[inline]
    pub(super) fn texel(&self, image: &Image, x: u32, y: u32) -> Spectrum {
        let n = usize::from(image.channels);
        let i = (y as usize * image.width as usize + x as usize) * n;
        // Greyscale, with or without alpha: repeat the first channel.
        let (g, b) = if n < 3 { (i, i) } else { (i + 1, i + 2) };
        let bands = match &image.pixels {
            Pixels::U8(v) => [v[i], v[g], v[b]].map(|v| self.eight[usize::from(v)]),
            Pixels::U16(v) => [v[i], v[g], v[b]].map(|v| self.sixteen[usize::from(v)]),
            Pixels::F32(v) => [v[i], v[g], v[b]].map(|v| if v.is_finite() { v } else { 0.0 }),
        };
        Spectrum::from(bands)
    }
}
