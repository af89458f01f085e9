//! Pictures to files, in one call.

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
    /// The format; by the path's extension if not given.
    pub format: Option<ImageFormat>,
    /// The display encoding that a PNG states. Pictures have theirs already: nothing is converted.
    pub transfer: Transfer,
    /// Written into PNG and EXR.
    pub metadata: Metadata,
    /// Threads that may compress; 0 takes all there are. The bytes do not depend on it.
    pub threads: usize,
}

impl Default for SaveOptions {
    fn default() -> SaveOptions {
        SaveOptions { format: None, transfer: Transfer::Unstated, metadata: Metadata::new(), threads: 0 }
    }
}

/// Why a picture could not be saved. Displayed as what is wrong, then the remedy in a second line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SaveError {
    /// The file name's extension is of no format that can be written, or the format cannot hold the picture.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// What can be saved: a developed [`Picture`] and an [`Image`].
pub trait Save {
    /// The samples that files hold.
    fn samples(&self) -> Samples<'_>;
}

/// The samples of a picture, row 0 at the top, in both shapes that files have.
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
    /// Whole numbers are taken for sRGB, floats for linear values, of which a PNG shows 0 to 1.
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

/// Writes a picture to a file: PNG, EXR, HDR or JPEG by the path's extension. It is written under a temporary name in the same folder and renamed, so that there is
/// the old file or the new one, whole, at any moment.
pub fn save(path: impl AsRef<Path>, picture: &impl Save) -> Result<(), SaveError> {
    save_with(path, picture, &SaveOptions::default())
}

/// As [`save`], in a format of choice and with metadata.
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

/// The bytes of the file that [`save_with`] writes, whatever format the options name.
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
