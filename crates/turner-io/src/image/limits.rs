//! How large a picture may claim to be, checked before any memory is reserved for it.

use turner::schema::Limits;

use super::{ImageError, ImageFormat, SizeHelp};
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
    /// Pictures of up to so many columns and rows are meant, however well they are packed. Default 0.
    pub meant_side: u32,
}

/// Decoded bytes from which on a picture is suspicious that is packed [`PACKED`] to one: 256 MiB.
const SUSPICIOUS: u64 = 256 << 20;

/// No picture of anything is packed so well.
const PACKED: u64 = 100;

/// Memory that decoding takes at its peak, in sizes of what comes out.
const PEAK: u64 = 2;

impl DecodeLimits {
    /// What the limits of a scene leave for a picture, when `many` are decoded together. Whoever asks for pictures of up to
    /// `max_texture_size` means those of that size.
    pub fn of_scene(limits: &Limits, max_texture_size: Option<u32>, many: u64) -> DecodeLimits {
        let asked = max_texture_size.unwrap_or(0);
        let default = DecodeLimits::default();
        let left = limits.memory.left();
        let share = left / (PEAK * many.max(1));
        DecodeLimits {
            max_side: default.max_side.max(asked),
            max_pixels: default.max_pixels.max(u64::from(asked) * u64::from(asked)),
            max_bytes: if left == u64::MAX { default.max_bytes } else { share },
            meant_side: asked,
        }
    }
}

impl Default for DecodeLimits {
    fn default() -> Self {
        Self { max_side: 32768, max_pixels: 1 << 28, max_bytes: 2 << 30, meant_side: 0 }
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
        // Both sides are below 2^32: the product fits a u64.
        let pixels = width * height;
        if pixels > self.max_pixels {
            return fail(format!("exceeds {} pixels", self.max_pixels), SizeHelp::Sides);
        }
        if pixels.checked_mul(pixel_bytes).is_none_or(|b| b > self.max_bytes) {
            let problem = format!("at {pixel_bytes} bytes each exceeds {} bytes", self.max_bytes);
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
            return fail("exceeds this machine's memory".to_owned(), SizeHelp::Machine);
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
