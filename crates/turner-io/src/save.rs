//! Saves pictures to files, in one call.

use std::borrow::Cow;
use std::path::Path;

use turner::color::{self, DisplaySpace, srgb_decode, srgb_encode};
use turner::film::{DisplayTransform, Picture};
use turner::image::{Image, Pixels};

use crate::image::{
    Display, ExrOptions, ExtraChannel, ImageError, ImageFormat, Metadata, OutputError, OutputFile,
    OutputImage, Transfer, encode,
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

/// Anything that can be saved: a developed [`Picture`] or an [`Image`].
pub trait Save {
    /// The samples to write.
    fn samples(&self) -> Samples<'_>;
}

/// The samples of a picture, row 0 at the top: linear for HDR formats, display-encoded for 8-bit formats.
#[derive(Clone, Debug)]
pub struct Samples<'a> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Whether alpha is written.
    pub alpha: bool,
    /// Linear RGBA, premultiplied: for EXR and HDR.
    pub linear: Cow<'a, [[f32; 4]]>,
    /// Display-encoded RGBA, straight alpha: for PNG, JPEG and WebP.
    pub display: Cow<'a, [[u8; 4]]>,
}

impl Save for Picture {
    fn samples(&self) -> Samples<'_> {
        Samples {
            width: self.width,
            height: self.height,
            alpha: self.has_alpha,
            linear: Cow::Borrowed(&self.linear),
            display: Cow::Borrowed(&self.display),
        }
    }
}

impl Save for Image {
    /// Integer samples are read as sRGB, floating-point samples as linear values. A PNG clamps linear values to
    /// 0..=1.
    fn samples(&self) -> Samples<'_> {
        let is_linear = matches!(self.pixels, Pixels::F32(_));
        let (mut linear, mut display) = (Vec::new(), Vec::new());
        let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
        for (x, y) in (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y))) {
            let (rgb, alpha) = (self.rgb(x, y), self.alpha(x, y));
            let (scene, shown) = match is_linear {
                true => (rgb, rgb.map(|v| srgb_encode(v.clamp(0.0, 1.0)))),
                false => (rgb.map(srgb_decode), rgb),
            };
            let [r, g, b] = scene.map(|v| v * alpha);
            linear.push([r, g, b, alpha]);
            let [r, g, b] = shown.map(byte);
            display.push([r, g, b, byte(alpha)]);
        }
        let alpha = matches!(self.channels, 2 | 4);
        let (linear, display) = (Cow::Owned(linear), Cow::Owned(display));
        Samples { width: self.width, height: self.height, alpha, linear, display }
    }
}

/// Writes a picture to a file: PNG, EXR, HDR, JPEG or WebP by the path's extension. The file is written under a temporary
/// name in the same folder and then renamed, so at any moment either the old file or the complete new file exists.
pub fn save(path: impl AsRef<Path>, picture: &impl Save) -> Result<(), SaveError> {
    save_with(path, picture, &SaveOptions::default())
}

/// Like [`save`], with an explicit format and metadata.
pub fn save_with(
    path: impl AsRef<Path>,
    picture: &impl Save,
    options: &SaveOptions<'_>,
) -> Result<(), SaveError> {
    let path = path.as_ref();
    let format = options.format.map_or_else(|| ImageFormat::of_path(path), Ok)?;
    let file = OutputFile::create(path)?;
    let bytes = to_bytes(picture, format, options)?;
    file.check_space(bytes.len() as u64)?;
    Ok(file.commit(&bytes)?)
}

/// The bytes that [`save_with`] would write, in the given format; `options.format` is ignored.
pub fn to_bytes(
    picture: &impl Save,
    format: ImageFormat,
    options: &SaveOptions<'_>,
) -> Result<Vec<u8>, ImageError> {
    let samples = picture.samples();
    let (linear, threads) = (&samples.linear, options.threads);
    let (mut eight, mut sixteen) = (Vec::new(), Vec::new());
    let is_shown = !matches!(format, ImageFormat::Exr | ImageFormat::Hdr);
    let display = match &options.display {
        Some(DisplayOptions { transform, rounding }) if is_shown => {
            match rounding {
                Rounding::EightBits => eight = transform.to_8_bits(linear, threads),
                Rounding::Dithered => eight = transform.to_8_bits_dithered(linear, samples.width, threads),
                Rounding::SixteenBits => sixteen = transform.to_16_bits(linear, threads),
            }
            if *rounding == Rounding::SixteenBits { Display::U16(&sixteen) } else { Display::U8(&eight) }
        }
        _ => Display::U8(&samples.display),
    };
    let image = OutputImage {
        width: samples.width,
        height: samples.height,
        alpha: samples.alpha,
        linear: Some(linear),
        display: Some(display),
        transfer: options.display.map_or(options.transfer, |d| d.transfer()),
        metadata: &options.metadata,
        channels: &options.channels,
        exr: options.exr,
        threads: options.threads,
    };
    encode(&image, format)
}
