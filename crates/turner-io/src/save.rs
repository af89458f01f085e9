//! Saves pictures to files, in one call.

use std::borrow::Cow;
use std::path::Path;

use turner::color::{srgb_decode, srgb_encode};
use turner::film::Picture;
use turner::image::{Image, Pixels};

use crate::image::{
    Display, ImageError, ImageFormat, Metadata, OutputError, OutputFile, OutputImage, Transfer, encode,
};

/// How to save a picture.
#[derive(Clone, Debug)]
pub struct SaveOptions {
    /// The file format. `None`: by the path's extension.
    pub format: Option<ImageFormat>,
    /// The display encoding that a PNG declares. Nothing is converted: the picture is already encoded.
    pub transfer: Transfer,
    /// Metadata for PNG and EXR.
    pub metadata: Metadata,
    /// Threads for compression; 0 uses all. The bytes do not depend on it.
    pub threads: usize,
}

impl Default for SaveOptions {
    fn default() -> SaveOptions {
        SaveOptions { format: None, transfer: Transfer::Unstated, metadata: Metadata::new(), threads: 0 }
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
    /// Display-encoded RGBA, straight alpha: for PNG and JPEG.
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

/// Writes a picture to a file: PNG, EXR, HDR or JPEG by the path's extension. The file is written under a temporary
/// name in the same folder and then renamed, so at any moment either the old file or the complete new file exists.
pub fn save(path: impl AsRef<Path>, picture: &impl Save) -> Result<(), SaveError> {
    save_with(path, picture, &SaveOptions::default())
}

/// Like [`save`], with an explicit format and metadata.
pub fn save_with(
    path: impl AsRef<Path>,
    picture: &impl Save,
    options: &SaveOptions,
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
    options: &SaveOptions,
) -> Result<Vec<u8>, ImageError> {
    let samples = picture.samples();
    let image = OutputImage {
        width: samples.width,
        height: samples.height,
        alpha: samples.alpha,
        linear: Some(&samples.linear),
        display: Some(Display::U8(&samples.display)),
        transfer: options.transfer,
        metadata: &options.metadata,
        threads: options.threads,
    };
    encode(&image, format)
}
