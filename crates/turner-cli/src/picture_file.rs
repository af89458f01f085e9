//! Picture files as input of commands.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use turner::compare::Canvas;
use turner::image::Image;
use turner::schema::error::escape;
use turner::schema::{ErrorCode, SceneError};
use turner_io::Save;
use turner_io::assets::{AssetSource, DEFAULT_BUDGET, FolderAssets};
use turner_io::image::{DecodeLimits, ImageError, ImageFormat, Metadata, decode, exr, read_metadata};

use crate::failure::{Failure, two_lines};

/// A picture file that was read but not decoded.
pub(crate) struct PictureFile {
    /// Its path as given.
    pub(crate) name: String,
    pub(crate) bytes: Vec<u8>,
    pub(crate) format: ImageFormat,
}

/// An error of the image as a failure of the command.
pub(crate) fn failed(error: &ImageError) -> Failure {
    Failure::new(two_lines(ErrorCode::Image, &error.to_string()))
}

impl PictureFile {
    /// Reads a file, which must be an image.
    pub(crate) fn read(path: &Path) -> Result<PictureFile, Failure> {
        let name = path.to_string_lossy().into_owned();
        let file = |message: &str| Failure::new(two_lines(ErrorCode::File, message));
        let Some(own) = path.file_name() else {
            let message = format!("{}: names no file", escape(&name));
            return Err(Failure::new(SceneError::new(ErrorCode::File, message).help("name a picture")));
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        let assets = FolderAssets::new(folder).map_err(|e| file(&e.to_string()))?.allow_outside(true);
        let bytes = assets.read(&own.to_string_lossy(), DEFAULT_BUDGET).map_err(|e| file(&e.to_string()))?;
        let format = ImageFormat::of_bytes(&bytes, &name).map_err(|e| failed(&e))?;
        Ok(PictureFile { name, bytes, format })
    }

    /// The picture, or a layer of an EXR file, and whether its colours are premultiplied by alpha. EXR values are taken
    /// as stored.
    pub(crate) fn image(&self, layer: Option<&str>) -> Result<(Image, bool), Failure> {
        let (bytes, name, limits) = (&self.bytes, &self.name, DecodeLimits::default());
        let image = match (self.format, layer) {
            (ImageFormat::Exr, None) => exr::decode_as_stored(bytes, name, &limits),
            (ImageFormat::Exr, Some(layer)) => exr::decode_layer(bytes, name, layer, &limits),
            (_, None) => decode(bytes, name, &limits),
            (format, Some(_)) => return Err(self.without_layers(format)),
        };
        Ok((image.map_err(|e| failed(&e))?, self.format == ImageFormat::Exr))
    }

    /// Text and integers in the file.
    pub(crate) fn metadata(&self) -> Result<Metadata, Failure> {
        read_metadata(&self.bytes, &self.name).map_err(|e| failed(&e))
    }

    fn without_layers(&self, format: ImageFormat) -> Failure {
        let message = format!("{}: {} has no layers", escape(&self.name), format.name());
        Failure::new(SceneError::new(ErrorCode::Image, message).help("omit --layer, or name an EXR file"))
    }
}

/// A picture with scene values, to be saved with display values.
pub(crate) struct Linear {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// RGBA, premultiplied.
    pub(crate) pixels: Vec<[f32; 4]>,
    /// Whether a pixel has an alpha other than 1.
    pub(crate) has_alpha: bool,
}

impl Linear {
    /// The pixels of an image; `associated`: its colours are premultiplied.
    pub(crate) fn new(image: &Image, associated: bool) -> Linear {
        let Canvas { width, height, pixels, has_alpha, .. } = Canvas::new(image, associated);
        Linear { width, height, pixels, has_alpha }
    }
}

impl Save for Linear {
    fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    fn linear(&self, rows: Range<u32>, _: usize) -> Cow<'_, [[f32; 4]]> {
        let width = self.width as usize;
        let part = self.pixels.get(rows.start as usize * width..rows.end as usize * width);
        Cow::Borrowed(part.unwrap_or_default())
    }

    /// There are none: they are computed from the linear values.
    fn display(&self, _: Range<u32>, _: usize) -> Cow<'_, [[u8; 4]]> {
        Cow::Borrowed(&[])
    }
}
