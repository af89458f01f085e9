//! How large a picture may claim to be, checked before any memory is reserved for it.

use super::{ImageError, ImageFormat};
use crate::assets::printable;

/// Limits on a picture that is read. The defaults hold for any texture that fits a workstation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DecodeLimits {
    /// Most columns and most rows. Default 32768.
    pub max_side: u32,
    /// Most pixels. Default 2^28 (16384 x 16384).
    pub max_pixels: u64,
    /// Most bytes of decoded samples. Default 2 GiB.
    pub max_bytes: u64,
}

impl Default for DecodeLimits {
    fn default() -> Self {
        Self { max_side: 32768, max_pixels: 1 << 28, max_bytes: 2 << 30 }
    }
}

/// A size that has passed [`DecodeLimits::check`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Checked {
    pub(super) width: u32,
    pub(super) height: u32,
    /// `width * height`.
    pub(super) pixels: usize,
}

/// What is being read, for messages, and how much of it there is.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) name: &'a str,
    pub(super) format: ImageFormat,
    /// Bytes in the file.
    pub(super) bytes: usize,
}

impl DecodeLimits {
    /// Checks a claimed size: not empty, within the limits at `pixel_bytes` decoded bytes per pixel, and no more
    /// pixels than `pixels_per_byte` (the most that the format can hold in a byte) times the file's length.
    pub(super) fn check(
        &self,
        source: Source<'_>,
        width: u64,
        height: u64,
        pixel_bytes: u64,
        pixels_per_byte: u64,
    ) -> Result<Checked, ImageError> {
        let fail = |problem: String, remedy| {
            let (name, format) = (printable(source.name), source.format.name());
            Err(ImageError::Size { name, format, width, height, problem, remedy })
        };
        if width == 0 || height == 0 {
            return fail("is empty".to_owned(), "export or download it again");
        }
        let (Ok(w), Ok(h)) = (u32::try_from(width), u32::try_from(height)) else {
            return fail(format!("exceeds {} on a side", self.max_side), "the file is damaged");
        };
        if w > self.max_side || h > self.max_side {
            return fail(format!("exceeds {} on a side", self.max_side), "scale it down");
        }
        // Both sides are below 2^32: the product fits a u64.
        let pixels = width * height;
        if pixels > self.max_pixels {
            return fail(format!("exceeds {} pixels", self.max_pixels), "scale it down");
        }
        if pixels.checked_mul(pixel_bytes).is_none_or(|b| b > self.max_bytes) {
            let problem = format!("at {pixel_bytes} bytes each exceeds {} bytes", self.max_bytes);
            return fail(problem, "scale it down");
        }
        if pixels > (source.bytes as u64).saturating_mul(pixels_per_byte) {
            let problem = format!("cannot be held in a file of {} bytes", source.bytes);
            return fail(problem, "the file is damaged: export or download it again");
        }
        let Ok(pixels) = usize::try_from(pixels) else {
            return fail("exceeds this machine's memory".to_owned(), "scale it down");
        };
        Ok(Checked { width: w, height: h, pixels })
    }
}

/// A buffer of `len` default values, or an error instead of an abort where memory is short.
pub(super) fn buffer<T: Clone + Default>(len: usize, name: &str) -> Result<Vec<T>, ImageError> {
    let mut v = Vec::new();
    reserve(&mut v, len, name)?;
    v.resize(len, T::default());
    Ok(v)
}

/// Room for `more` values, or an error instead of an abort where memory is short.
pub(super) fn reserve<T>(v: &mut Vec<T>, more: usize, name: &str) -> Result<(), ImageError> {
    v.try_reserve_exact(more).map_err(|_| ImageError::OutOfMemory {
        name: printable(name),
        bytes: (more as u64).saturating_mul(size_of::<T>() as u64),
    })
}

/// Asks whether there is room for `bytes` more, which a decoder is about to take without asking.
pub(super) fn probe(bytes: usize, name: &str) -> Result<(), ImageError> {
    reserve(&mut Vec::<u8>::new(), bytes, name)
}
