//! Saves pictures to files, in one call.

use std::borrow::Cow;
use std::io::{self, Cursor};
use std::ops::Range;
use std::path::Path;

use turner::color::{self, DisplaySpace, srgb_decode, srgb_encode};
use turner::film::{Developed, DisplayTransform, Picture};
use turner::image::{Image, Pixels};

use crate::image::{
    ExrOptions, ExtraChannel, ImageError, ImageFormat, Metadata, OutputError, OutputFile, OutputImage, Strip,
    StripImage, Transfer, WriteSeek, write,
};

/// How to save a picture.
#[derive(Clone, Debug)]
pub struct SaveOptions<'a> {
    /// The file format. `None`: by the path's extension.
    pub format: Option<ImageFormat>,
    /// The display encoding that a PNG declares. Nothing is converted: the picture is already encoded. With `display`
    /// it follows from the transform.
    pub transfer: Transfer,
    /// Display values for PNG, JPEG and WebP, computed from the linear samples. `None`: those of the picture, which have
    /// 8 bits.
    pub display: Option<DisplayOptions>,
    /// Metadata for PNG and EXR.
    pub metadata: Metadata,
    /// Further channels of an EXR file, such as albedo and normals; other formats do not store them.
    pub channels: Vec<ExtraChannel<'a>>,
    /// Compression and precision of an EXR file.
    pub exr: ExrOptions,
    /// Threads for display values and compression; 0 uses all. The bytes do not depend on it.
    pub threads: usize,
}

impl Default for SaveOptions<'_> {
    fn default() -> Self {
        SaveOptions {
            format: None,
            transfer: Transfer::Unstated,
            display: None,
            metadata: Metadata::new(),
            channels: Vec::new(),
            exr: ExrOptions::default(),
            threads: 0,
        }
    }
}

/// Display values computed from linear samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayOptions {
    /// Exposure, tone mapping, colour space and curve.
    pub transform: DisplayTransform,
    /// How values are rounded.
    pub rounding: Rounding,
}

/// The precision of display values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Rounding {
    /// To the nearest of 256 values.
    #[default]
    EightBits,
    /// To 256 values with ordered dither, which hides bands in smooth gradients.
    Dithered,
    /// To the nearest of 65536 values: for PNG.
    SixteenBits,
}

impl DisplayOptions {
    /// What a PNG declares.
    fn transfer(&self) -> Transfer {
        match (self.transform.transfer, self.transform.space) {
            (color::Transfer::None, _) => Transfer::Unstated,
            (_, DisplaySpace::Srgb) => Transfer::Srgb,
            (_, DisplaySpace::DisplayP3) => Transfer::DisplayP3,
            (_, DisplaySpace::Rec2100Pq) => Transfer::Rec2100Pq,
        }
    }
}

/// Why a picture could not be saved. Displayed as the problem, then the remedy on a second line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SaveError {
    /// The extension is not that of a writable format, or the format cannot hold the picture.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Anything that can be saved: a developed [`Picture`], a film's [`Developed`] rows, or an [`Image`].
pub trait Save: Sync {
    /// Columns and rows.
    fn size(&self) -> (u32, u32);

    /// Whether alpha is written.
    fn has_alpha(&self) -> bool;

    /// Linear RGBA of these rows, premultiplied: for EXR and HDR. Row 0 is at the top. `threads` of 0 uses all.
    fn linear(&self, rows: Range<u32>, threads: usize) -> Cow<'_, [[f32; 4]]>;

    /// Display-encoded RGBA of these rows, straight alpha: for PNG, JPEG and WebP.
    fn display(&self, rows: Range<u32>, threads: usize) -> Cow<'_, [[u8; 4]]>;
}

/// The part of a picture of `width` columns that these rows are.
fn part<T>(all: &[T], width: u32, rows: Range<u32>) -> &[T] {
    let width = width as usize;
    all.get(rows.start as usize * width..rows.end as usize * width).unwrap_or_default()
}

impl Save for Picture {
    fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    fn linear(&self, rows: Range<u32>, _: usize) -> Cow<'_, [[f32; 4]]> {
        Cow::Borrowed(part(&self.linear, self.width, rows))
    }

    fn display(&self, rows: Range<u32>, _: usize) -> Cow<'_, [[u8; 4]]> {
        Cow::Borrowed(part(&self.display, self.width, rows))
    }
}

impl Save for Developed<'_> {
    fn size(&self) -> (u32, u32) {
        Developed::size(self)
    }

    fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    fn linear(&self, rows: Range<u32>, threads: usize) -> Cow<'_, [[f32; 4]]> {
        Developed::linear(self, rows, threads)
    }

    fn display(&self, rows: Range<u32>, threads: usize) -> Cow<'_, [[u8; 4]]> {
        Cow::Owned(self.transform().to_8_bits(&Developed::linear(self, rows, threads), threads))
    }
}

/// Integer samples are read as sRGB, floating-point samples as linear values. A PNG clamps linear values to 0..=1.
impl Save for Image {
    fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn has_alpha(&self) -> bool {
        matches!(self.channels, 2 | 4)
    }

    fn linear(&self, rows: Range<u32>, _: usize) -> Cow<'_, [[f32; 4]]> {
        let is_linear = matches!(self.pixels, Pixels::F32(_));
        let pixel = |(x, y)| {
            let (rgb, alpha) = (self.rgb(x, y), self.alpha(x, y));
            let scene = if is_linear { rgb } else { rgb.map(srgb_decode) };
            let [r, g, b] = scene.map(|v| v * alpha);
            [r, g, b, alpha]
        };
        places(self.width, rows).map(pixel).collect()
    }

    fn display(&self, rows: Range<u32>, _: usize) -> Cow<'_, [[u8; 4]]> {
        let is_linear = matches!(self.pixels, Pixels::F32(_));
        let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
        let pixel = |(x, y)| {
            let rgb = self.rgb(x, y);
            let shown = if is_linear { rgb.map(|v| srgb_encode(v.clamp(0.0, 1.0))) } else { rgb };
            let [r, g, b] = shown.map(byte);
            [r, g, b, byte(self.alpha(x, y))]
        };
        places(self.width, rows).map(pixel).collect()
    }
}

/// The pixels of rows.
fn places(width: u32, rows: Range<u32>) -> impl Iterator<Item = (u32, u32)> {
    rows.flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// Writes a picture to a file: PNG, EXR, HDR, JPEG or WebP by the path's extension. The file is written under a temporary
/// name in the same folder and then renamed, so at any moment either the old file or the complete new file exists.
pub fn save(path: impl AsRef<Path>, picture: &(impl Save + ?Sized)) -> Result<(), SaveError> {
    save_with(path, picture, &SaveOptions::default())
}

/// Like [`save`], with an explicit format and metadata.
pub fn save_with(
    path: impl AsRef<Path>,
    picture: &(impl Save + ?Sized),
    options: &SaveOptions<'_>,
) -> Result<(), SaveError> {
    let path = path.as_ref();
    let format = options.format.map_or_else(|| ImageFormat::of_path(path), Ok)?;
    let file = OutputFile::create(path)?;
    write_file(file, picture, format, options)
}

/// Writes a picture to a file that was created before, strip by strip: the file is never in memory as a whole, unless it
/// is a JPEG or WebP.
pub fn write_file(
    file: OutputFile,
    picture: &(impl Save + ?Sized),
    format: ImageFormat,
    options: &SaveOptions<'_>,
) -> Result<(), SaveError> {
    let mut refused = None;
    let result = file.commit_seeking(|out| {
        write_samples(picture, format, options, out).map_err(|error| match error.downcast::<ImageError>() {
            Ok(error) => {
                refused = Some(error);
                io::ErrorKind::InvalidInput.into()
            }
            Err(error) => error,
        })
    });
    match refused {
        Some(error) => Err(SaveError::Image(error)),
        None => Ok(result?),
    }
}

/// The bytes that [`save_with`] would write, in the given format; `options.format` is ignored.
pub fn to_bytes(
    picture: &(impl Save + ?Sized),
    format: ImageFormat,
    options: &SaveOptions<'_>,
) -> Result<Vec<u8>, ImageError> {
    let mut out = Cursor::new(Vec::new());
    match write_samples(picture, format, options, &mut out) {
        Ok(()) => Ok(out.into_inner()),
        Err(error) => Err(error.downcast::<ImageError>().unwrap_or_else(|e| ImageError::encode(format, e))),
    }
}

/// Writes the samples that the format stores.
fn write_samples(
    picture: &(impl Save + ?Sized),
    format: ImageFormat,
    options: &SaveOptions<'_>,
    out: &mut dyn WriteSeek,
) -> io::Result<()> {
    let (width, height) = picture.size();
    let is_shown = !matches!(format, ImageFormat::Exr | ImageFormat::Hdr);
    let display = options.display.filter(|_| is_shown);
    let rows = |rows: Range<u32>, threads| {
        let first = rows.start;
        let Some(DisplayOptions { transform, rounding }) = display else {
            return match is_shown {
                true => Strip::Display(picture.display(rows, threads)),
                false => Strip::Linear(picture.linear(rows, threads)),
            };
        };
        let linear = picture.linear(rows, threads);
        match rounding {
            Rounding::EightBits => Strip::Display(transform.to_8_bits(&linear, threads).into()),
            Rounding::Dithered => {
                Strip::Display(transform.to_8_bits_dithered(&linear, width, first, threads).into())
            }
            Rounding::SixteenBits => Strip::Display16(transform.to_16_bits(&linear, threads).into()),
        }
    };
    let image = OutputImage {
        width,
        height,
        alpha: picture.has_alpha(),
        linear: None,
        display: None,
        transfer: options.display.map_or(options.transfer, |d| d.transfer()),
        metadata: &options.metadata,
        channels: &options.channels,
        exr: options.exr,
        threads: options.threads,
    };
    let is_deep = display.is_some_and(|d| d.rounding == Rounding::SixteenBits);
    write(&StripImage { image: &image, is_deep, rows: &rows }, format, out)
}
