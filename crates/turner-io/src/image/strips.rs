//! Pictures that are written strip by strip, so that they are never in memory as a whole.

use std::borrow::Cow;
use std::io::{self, Cursor, Seek, Write};
use std::ops::Range;

use super::{Display, ImageError, ImageFormat, OutputImage, exr, hdr, jpeg, png, webp};

/// The samples of some rows, as in an [`OutputImage`].
#[derive(Clone, Debug)]
pub enum Strip<'a> {
    /// Linear RGBA, premultiplied.
    Linear(Cow<'a, [[f32; 4]]>),
    /// Display-encoded RGBA, straight alpha.
    Display(Cow<'a, [[u8; 4]]>),
    /// The same with 16 bits.
    Display16(Cow<'a, [[u16; 4]]>),
}

/// An image to be written whose samples are asked for while it is written.
#[derive(Clone, Copy)]
pub struct StripImage<'a> {
    /// Everything but the samples.
    pub image: &'a OutputImage<'a>,
    /// Whether display samples have 16 bits.
    pub is_deep: bool,
    /// The samples of these rows, which the format stores, computed on a number of threads.
    pub rows: &'a (dyn Fn(Range<u32>, usize) -> Strip<'a> + Sync),
}

/// What a picture is written to.
pub trait WriteSeek: Write + Seek {}

impl<W: Write + Seek> WriteSeek for W {}

/// Writes an image. The same input gives the same bytes on any machine and with any number of threads.
///
/// Errors: those of `out`; for an image that the format cannot hold an error that contains an [`ImageError`].
pub fn write(image: &StripImage<'_>, format: ImageFormat, out: &mut dyn WriteSeek) -> io::Result<()> {
    let all = 0..image.image.height;
    match format {
        ImageFormat::Png => png::write(image, out),
        ImageFormat::Exr => exr::write(image, out),
        ImageFormat::Hdr => hdr::write(image, out),
        ImageFormat::Jpeg | ImageFormat::WebP => {
            image.image.pixels(format).map_err(refused)?;
            let strip = (image.rows)(all, image.image.threads);
            let display = match &strip {
                Strip::Linear(_) => None,
                Strip::Display(samples) => Some(Display::U8(samples)),
                Strip::Display16(samples) => Some(Display::U16(samples)),
            };
            let whole = OutputImage { display, linear: None, ..image.image.clone() };
            let encode = if format == ImageFormat::Jpeg { jpeg::encode } else { webp::encode };
            out.write_all(&encode(&whole).map_err(refused)?)
        }
        ImageFormat::Tga | ImageFormat::Bmp | ImageFormat::Pfm | ImageFormat::Ktx2 => {
            Err(refused(ImageError::encode(format, "the format can be read but not written; use PNG")))
        }
    }
}

/// The bytes of an image whose samples are in memory.
pub(super) fn encode(image: &OutputImage<'_>, format: ImageFormat) -> Result<Vec<u8>, ImageError> {
    let is_linear = matches!(format, ImageFormat::Exr | ImageFormat::Hdr);
    let (linear, display) = match is_linear {
        true => (image.linear(format)?, None),
        false => (&[][..], Some(image.display(format)?)),
    };
    let width = image.width as usize;
    let rows = |rows: Range<u32>, _| {
        let pixels = rows.start as usize * width..rows.end as usize * width;
        match display {
            None => Strip::Linear(Cow::Borrowed(linear.get(pixels).unwrap_or_default())),
            Some(Display::U8(s)) => Strip::Display(Cow::Borrowed(s.get(pixels).unwrap_or_default())),
            Some(Display::U16(s)) => Strip::Display16(Cow::Borrowed(s.get(pixels).unwrap_or_default())),
        }
    };
    let is_deep = matches!(display, Some(Display::U16(_)));
    let mut out = Cursor::new(Vec::new());
    match write(&StripImage { image, is_deep, rows: &rows }, format, &mut out) {
        Ok(()) => Ok(out.into_inner()),
        Err(error) => Err(error.downcast::<ImageError>().unwrap_or_else(|e| ImageError::encode(format, e))),
    }
}

/// The error of a writer for an image that the format cannot hold.
pub(super) fn refused(error: ImageError) -> io::Error {
    io::Error::other(error)
}

impl<'a> StripImage<'a> {
    /// The linear samples of rows.
    pub(super) fn linear(&self, rows: Range<u32>, threads: usize) -> io::Result<Cow<'a, [[f32; 4]]>> {
        match (self.rows)(rows.clone(), threads) {
            Strip::Linear(samples) if samples.len() == self.pixels_of(&rows) => Ok(samples),
            _ => Err(missing("linear", rows)),
        }
    }

    /// Appends the display samples of rows as bytes, big-endian, with or without alpha.
    pub(super) fn append_display(&self, rows: Range<u32>, bytes: &mut Vec<u8>) -> io::Result<()> {
        let channels = if self.image.alpha { 4 } else { 3 };
        let pixels = self.pixels_of(&rows);
        match (self.rows)(rows.clone(), self.image.threads) {
            Strip::Display(s) if s.len() == pixels && !self.is_deep => match channels {
                4 => bytes.extend_from_slice(s.as_flattened()),
                _ => bytes.extend(s.iter().flat_map(|p| [p[0], p[1], p[2]])),
            },
            Strip::Display16(s) if s.len() == pixels && self.is_deep => {
                bytes.extend(s.iter().flat_map(|p| p[..channels].iter().flat_map(|v| v.to_be_bytes())));
            }
            _ => return Err(missing("display", rows)),
        }
        Ok(())
    }

    /// The rows of the image in strips of about `pixels` pixels.
    pub(super) fn strips(&self, pixels: u32) -> impl Iterator<Item = Range<u32>> + use<> {
        let height = self.image.height;
        let strip = (pixels / self.image.width.max(1)).max(1);
        (0..height).step_by(strip as usize).map(move |y| y..y.saturating_add(strip).min(height))
    }

    fn pixels_of(&self, rows: &Range<u32>) -> usize {
        rows.len() * self.image.width as usize
    }
}

fn missing(kind: &str, rows: Range<u32>) -> io::Error {
    io::Error::other(format!("{kind} samples of rows {rows:?} are missing"))
}
