//! Limits of image sizes, checked before memory is reserved.

use turner::schema::Limits;

use super::{ImageError, ImageFormat, SizeHelp};
use crate::assets::printable;

/// Limits for images to read. The defaults suit any texture that fits in a workstation's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DecodeLimits {
    /// Most columns and most rows; default 32768.
    pub max_side: u32,
    /// Most pixels; default 2^28 (16384 x 16384).
    pub max_pixels: u64,
    /// Most bytes of decoded samples; default 2 GiB.
    pub max_bytes: u64,
    /// Images of at most this many columns and rows are accepted whatever their compression ratio; default 0.
    pub meant_side: u32,
}

/// Decoded size from which a compression ratio above [`PACKED`] is suspicious: 256 MiB.
const SUSPICIOUS: u64 = 256 << 20;

/// Compression ratio that real images do not reach.
const PACKED: u64 = 100;

/// Peak memory of decoding, as a multiple of the decoded size.
const PEAK: u64 = 2;

impl DecodeLimits {
    /// The limits for each of `many` images that are decoded together, given the limits of the scene. Images up
    /// to `max_texture_size` were requested explicitly and are accepted.
    pub fn of_scene(limits: &Limits, max_texture_size: Option<u32>, many: u64) -> DecodeLimits {
        let asked = max_texture_size.unwrap_or(0);
        let default = DecodeLimits::default();
        let left = limits.memory.left();
        let budget = left / (PEAK * many.max(1));
        DecodeLimits {
            max_side: default.max_side.max(asked),
            max_pixels: default.max_pixels.max(u64::from(asked) * u64::from(asked)),
            max_bytes: if left == u64::MAX { default.max_bytes } else { budget },
            meant_side: asked,
        }
    }
}

impl Default for DecodeLimits {
    fn default() -> Self {
        Self { max_side: 32768, max_pixels: 1 << 28, max_bytes: 2 << 30, meant_side: 0 }
    }
}

/// A size that passed [`DecodeLimits::check`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Checked {
    pub(super) width: u32,
    pub(super) height: u32,
    /// `width * height`.
    pub(super) pixels: usize,
}

/// The file being read.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) name: &'a str,
    pub(super) format: ImageFormat,
    /// Length of the file, in bytes.
    pub(super) bytes: usize,
}

impl DecodeLimits {
    /// Checks a claimed size: not empty; within the limits at `pixel_bytes` decoded bytes per pixel; at most
    /// `pixels_per_byte` pixels (the most that the format can represent) per byte of the file.
    pub(super) fn check(
        &self,
        source: Source<'_>,
        width: u64,
        height: u64,
        pixel_bytes: u64,
        pixels_per_byte: u64,
    ) -> Result<Checked, ImageError> {
        let fail = |problem: String, help| {
            let (name, format) = (printable(source.name), source.format.name());
            Err(ImageError::Size { name, format, width, height, problem, help })
        };
        if width == 0 || height == 0 {
            return fail("is empty".to_owned(), SizeHelp::Empty);
        }
        let (Ok(w), Ok(h)) = (u32::try_from(width), u32::try_from(height)) else {
            return fail(format!("exceeds {} on a side", self.max_side), SizeHelp::Damaged);
        };
        if w > self.max_side || h > self.max_side {
            return fail(format!("exceeds {} on a side", self.max_side), SizeHelp::Sides);
        }
        // Both sides are below 2^32, so the product fits in a u64.
        let pixels = width * height;
        if pixels > self.max_pixels {
            return fail(format!("exceeds {} pixels", self.max_pixels), SizeHelp::Sides);
        }
        if pixels.checked_mul(pixel_bytes).is_none_or(|b| b > self.max_bytes) {
            let problem = format!("with {pixel_bytes} bytes per pixel exceeds {} bytes", self.max_bytes);
            return fail(problem, SizeHelp::Memory);
        }
        if pixels > (source.bytes as u64).saturating_mul(pixels_per_byte) {
            let problem = format!("cannot be held in a file of {} bytes", source.bytes);
            return fail(problem, SizeHelp::Damaged);
        }
        let bytes = pixels.saturating_mul(pixel_bytes);
        let packed = bytes > SUSPICIOUS && bytes / PACKED > source.bytes as u64;
        if packed && (w > self.meant_side || h > self.meant_side) {
            let problem = format!("becomes {bytes} bytes from {} in the file", source.bytes);
            return fail(problem, SizeHelp::Packed);
        }
        let Ok(pixels) = usize::try_from(pixels) else {
            return fail("exceeds this machine's address space".to_owned(), SizeHelp::Machine);
        };
        Ok(Checked { width: w, height: h, pixels })
    }
}

/// A buffer of `len` default values; an error instead of an abort when memory runs out.
pub(super) fn buffer<T: Clone + Default>(len: usize, name: &str) -> Result<Vec<T>, ImageError> {
    let mut v = Vec::new();
    reserve(&mut v, len, name)?;
    v.resize(len, T::default());
    Ok(v)
}

/// Reserves `more` elements; an error instead of an abort when memory runs out.
pub(super) fn reserve<T>(v: &mut Vec<T>, more: usize, name: &str) -> Result<(), ImageError> {
    v.try_reserve_exact(more).map_err(|_| ImageError::OutOfMemory {
        name: printable(name),
        bytes: (more as u64).saturating_mul(size_of::<T>() as u64),
    })
}

/// Checks that `bytes` more could be allocated, before a decoder allocates them without checking.
pub(super) fn probe(bytes: usize, name: &str) -> Result<(), ImageError> {
    reserve(&mut Vec::<u8>::new(), bytes, name)
}
