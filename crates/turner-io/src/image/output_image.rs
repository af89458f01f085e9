//! A finished picture, in the two shapes that files want.

use super::{ImageError, ImageFormat, Metadata};

/// What [`super::encode`] writes. The caller fills the samples that the format stores and may leave the other
/// kind out: EXR and HDR store `linear`, PNG and JPEG store `display`. A PNG is thus the EXR seen through the
/// caller's documented transform, and nothing is transformed here.
#[derive(Clone, Debug)]
pub struct OutputImage<'a> {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Whether the fourth channel is meant; without it, it is not written. HDR and JPEG never store it.
    pub alpha: bool,
    /// Linear RGBA, row 0 at the top, colour associated with (premultiplied by) alpha as EXR has it.
    pub linear: Option<&'a [[f32; 4]]>,
    /// Display-encoded RGBA, row 0 at the top, straight alpha as PNG has it.
    pub display: Option<Display<'a>>,
    /// How `display` is encoded: stated in the PNG, not applied.
    pub transfer: Transfer,
    /// Written into PNG and EXR.
    pub metadata: &'a Metadata,
    /// Threads that may compress; 0 for as many as the machine has. The bytes do not depend on it.
    pub threads: usize,
}

/// Display-encoded samples.
#[derive(Clone, Copy, Debug)]
pub enum Display<'a> {
    /// 8 bits per channel.
    U8(&'a [[u8; 4]]),
    /// 16 bits per channel; JPEG rounds them to 8.
    U16(&'a [[u16; 4]]),
}

/// The display encoding that a file states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transfer {
    /// IEC 61966-2-1: an sRGB chunk.
    Srgb,
    /// `encoded = linear^(1 / gamma)`: a gAMA chunk. 1 for linear samples. Between 0.01 and 100.
    Gamma(f32),
    /// Nothing is stated.
    Unstated,
}

impl<'a> OutputImage<'a> {
    /// A checked pixel count: both sides at least 1 and at most 2^31 - 1 (what every format can state).
    pub(super) fn pixels(&self, format: ImageFormat) -> Result<usize, ImageError> {
        let most = i32::MAX as u32;
        let ok = (1..=most).contains(&self.width) && (1..=most).contains(&self.height);
        let pixels = (self.width as usize).checked_mul(self.height as usize);
        // 16 bytes per pixel must be addressable, for the buffers made on the way.
        match pixels.filter(|p| ok && p.checked_mul(16).is_some()) {
            Some(pixels) => Ok(pixels),
            None => {
                let problem = format!("{} x {} pixels; expected 1 to {most}", self.width, self.height);
                Err(ImageError::encode(format, problem))
            }
        }
    }

    /// The linear samples, or an error that says what is missing.
    pub(super) fn linear(&self, format: ImageFormat) -> Result<&'a [[f32; 4]], ImageError> {
        let pixels = self.pixels(format)?;
        match self.linear {
            Some(s) if s.len() == pixels => Ok(s),
            other => Err(self.missing(format, "linear", other.map(<[_]>::len))),
        }
    }

    /// The display samples, or an error that says what is missing.
    pub(super) fn display(&self, format: ImageFormat) -> Result<Display<'a>, ImageError> {
        let pixels = self.pixels(format)?;
        let len = self.display.map(|d| match d {
            Display::U8(s) => s.len(),
            Display::U16(s) => s.len(),
        });
        match self.display {
            Some(d) if len == Some(pixels) => Ok(d),
            _ => Err(self.missing(format, "display", len)),
        }
    }

    fn missing(&self, format: ImageFormat, kind: &str, len: Option<usize>) -> ImageError {
        let found = len.map_or_else(|| "none".to_owned(), |n| n.to_string());
        let problem =
            format!("it stores {kind} samples: found {found}, expected {} x {}", self.width, self.height);
        ImageError::encode(format, problem)
    }
}

/// Threads to use for `jobs` independent pieces of work, of as many as are allowed (0: all there are).
pub(super) fn workers(threads: usize, jobs: usize) -> usize {
    let most = match threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        n => n,
    };
    most.min(jobs).max(1)
}
