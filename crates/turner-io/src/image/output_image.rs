//! An image to be written, as linear and as display samples.

use super::{ExrOptions, ExtraChannel, ImageError, ImageFormat, Metadata};

/// The input of [`super::encode`]. The caller provides the samples that the format stores: `linear` for EXR and HDR,
/// `display` for PNG, JPEG and WebP. No conversion takes place, so a PNG is the EXR after the caller's own display
/// transform.
#[derive(Clone, Debug)]
pub struct OutputImage<'a> {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Whether the alpha channel is written. HDR and JPEG never store it.
    pub alpha: bool,
    /// Linear RGBA, row 0 at the top, colours premultiplied by alpha as in EXR.
    pub linear: Option<&'a [[f32; 4]]>,
    /// Display-encoded RGBA, row 0 at the top, straight alpha as in PNG.
    pub display: Option<Display<'a>>,
    /// The encoding of `display`: declared in the PNG, not applied.
    pub transfer: Transfer,
    /// Metadata for PNG and EXR.
    pub metadata: &'a Metadata,
    /// Further channels, for EXR alone.
    pub channels: &'a [ExtraChannel<'a>],
    /// How an EXR file is written.
    pub exr: ExrOptions,
    /// Threads for compression; 0 uses all. The bytes do not depend on it.
    pub threads: usize,
}

impl Default for OutputImage<'_> {
    /// No pixels, no metadata, all threads.
    fn default() -> Self {
        static NONE: Metadata = Metadata::new();
        OutputImage {
            width: 0,
            height: 0,
            alpha: false,
            linear: None,
            display: None,
            transfer: Transfer::Unstated,
            metadata: &NONE,
            channels: &[],
            exr: ExrOptions::default(),
            threads: 0,
        }
    }
}

/// Display-encoded samples.
#[derive(Clone, Copy, Debug)]
pub enum Display<'a> {
    /// 8 bits per channel.
    U8(&'a [[u8; 4]]),
    /// 16 bits per channel; JPEG and WebP round them to 8.
    U16(&'a [[u16; 4]]),
}

/// The display encoding that a file declares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transfer {
    /// IEC 61966-2-1, as an sRGB chunk.
    Srgb,
    /// `encoded = linear^(1 / gamma)`, as a gAMA chunk; 1 for linear samples; between 0.01 and 100.
    Gamma(f32),
    /// Display P3: the primaries of SMPTE EG 432-1 and the curve of sRGB, as cICP and iCCP chunks.
    DisplayP3,
    /// Rec. 2100 PQ: the primaries of BT.2020 and the curve of SMPTE ST 2084, as a cICP chunk.
    Rec2100Pq,
    /// None declared.
    Unstated,
}

impl<'a> OutputImage<'a> {
    /// The number of pixels. Both sides must be from 1 to 2^31 - 1, which every format can store.
    pub(super) fn pixels(&self, format: ImageFormat) -> Result<usize, ImageError> {
        let most = i32::MAX as u32;
        let ok = (1..=most).contains(&self.width) && (1..=most).contains(&self.height);
        let pixels = (self.width as usize).checked_mul(self.height as usize);
        // 16 bytes per pixel must be addressable, for intermediate buffers.
        match pixels.filter(|p| ok && p.checked_mul(16).is_some()) {
            Some(pixels) => Ok(pixels),
            None => {
                let problem = format!("{} x {} pixels; expected 1 to {most}", self.width, self.height);
                Err(ImageError::encode(format, problem))
            }
        }
    }

    /// The linear samples; an error if they are missing or their number is wrong.
    pub(super) fn linear(&self, format: ImageFormat) -> Result<&'a [[f32; 4]], ImageError> {
        let pixels = self.pixels(format)?;
        match self.linear {
            Some(s) if s.len() == pixels => Ok(s),
            other => Err(self.missing(format, "linear", other.map(<[_]>::len))),
        }
    }

    /// The display samples; an error if they are missing or their number is wrong.
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

    /// The display samples as 8-bit RGB or, with `alpha`, RGBA, for formats that say nothing about colour spaces.
    pub(super) fn eight_bit_srgb(&self, format: ImageFormat, alpha: bool) -> Result<Vec<u8>, ImageError> {
        if matches!(self.transfer, Transfer::DisplayP3 | Transfer::Rec2100Pq) {
            let problem = "it is written as sRGB; use PNG for Display P3 and Rec. 2100";
            return Err(ImageError::encode(format, problem));
        }
        let n = if alpha { 4 } else { 3 };
        // The nearest 8-bit value; 257 = 65535 / 255.
        let byte = |v: &u16| ((u32::from(*v) + 128) / 257) as u8;
        Ok(match self.display(format)? {
            Display::U8(s) => s.iter().flat_map(|p| p[..n].iter().copied()).collect(),
            Display::U16(s) => s.iter().flat_map(|p| p[..n].iter().map(byte)).collect(),
        })
    }

    fn missing(&self, format: ImageFormat, kind: &str, len: Option<usize>) -> ImageError {
        let found = len.map_or_else(|| "none".to_owned(), |n| n.to_string());
        let problem =
            format!("{kind} samples are required: found {found}, expected {} x {}", self.width, self.height);
        ImageError::encode(format, problem)
    }
}

/// Number of threads for `jobs` independent jobs; `threads` is the allowed number (0: all).
pub(super) fn workers(threads: usize, jobs: usize) -> usize {
    let most = match threads {
        0 => turner_host::thread::available(),
        n => n,
    };
    most.min(jobs).max(1)
}
