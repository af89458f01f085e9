//! The formats there are: one table for extensions, first bytes and listings.

use super::ImageError;
use crate::assets::{nearest, printable};
use std::path::Path;

/// A file format for pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImageFormat {
    /// 8 or 16 bits, display-encoded, lossless.
    Png,
    /// OpenEXR: linear floats, lossless, with metadata.
    Exr,
    /// Radiance RGBE: linear, 8 bits of mantissa with a shared exponent.
    Hdr,
    /// 8 bits, display-encoded, lossy.
    Jpeg,
}

/// One line of the table.
struct Row {
    format: ImageFormat,
    name: &'static str,
    extensions: &'static [&'static str],
    description: &'static str,
    magic: &'static [u8],
}

const TABLE: &[Row] = &[
    Row {
        format: ImageFormat::Png,
        name: "PNG",
        extensions: &["png"],
        description: "8 or 16 bits per channel, lossless: what the display shows",
        magic: b"\x89PNG\r\n\x1a\n",
    },
    Row {
        format: ImageFormat::Exr,
        name: "OpenEXR",
        extensions: &["exr"],
        description: "linear 32-bit floats with metadata, lossless: what was computed",
        magic: b"\x76\x2f\x31\x01",
    },
    Row {
        format: ImageFormat::Hdr,
        name: "Radiance HDR",
        extensions: &["hdr", "pic", "rgbe"],
        description: "linear light in 4 bytes per pixel, to 0.4 % of the brightest channel",
        magic: b"#?",
    },
    Row {
        format: ImageFormat::Jpeg,
        name: "JPEG",
        extensions: &["jpg", "jpeg", "jpe"],
        description: "8 bits per channel, lossy: for looking at, not for comparing",
        magic: b"\xff\xd8\xff",
    },
];

/// First bytes of formats that people try and that are not read, so that the message can name them.
const FOREIGN: &[(&[u8], &str)] = &[
    (b"GIF8", "a GIF picture"),
    (b"BM", "a BMP picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"RIFF", "a RIFF file (WebP?)"),
    (b"DDS ", "a DDS texture"),
    (b"\xabKTX", "a KTX texture"),
    (b"8BPS", "a Photoshop document"),
    (b"\0\0\0\x0cjP", "a JPEG 2000 picture"),
    (b"\xff\x0a", "a JPEG XL picture"),
    (b"P3", "a PPM picture"),
    (b"P6", "a PPM picture"),
    (b"PF", "a PFM picture"),
    (b"\x89P", "a PNG with damaged first bytes (transferred as text?)"),
    (b"<", "a text file (an error page or SVG?)"),
    (b"version https://git-lfs", "a Git LFS pointer; run `git lfs pull`"),
];

impl ImageFormat {
    /// Every format, in the order of the table.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|row| row.format)
    }

    fn row(self) -> &'static Row {
        // The table has a line for each variant: see the test below. The fallback keeps this free of panics.
        TABLE.iter().find(|row| row.format == self).unwrap_or(&TABLE[0])
    }

    /// The format's name in messages: `PNG`, `OpenEXR`, …
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// The extensions that mean this format, lower case, the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        self.row().extensions
    }

    /// What the format keeps, in a few words, for listings.
    pub fn description(self) -> &'static str {
        self.row().description
    }

    /// Whether [`super::decode`] reads it. All four, today.
    pub fn can_read(self) -> bool {
        true
    }

    /// Whether [`super::encode`] writes it. All four, today.
    pub fn can_write(self) -> bool {
        true
    }

    /// The format that an output path asks for by its extension, in upper or lower case.
    pub fn of_path(path: &Path) -> Result<Self, ImageError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let every = || TABLE.iter().flat_map(|row| row.extensions.iter().copied());
        if let Some(row) =
            TABLE.iter().find(|row| extension.as_deref().is_some_and(|e| row.extensions.contains(&e)))
        {
            return Ok(row.format);
        }
        let found = match &extension {
            Some(e) => format!("the extension .{}", printable(e)),
            None => "no extension".to_owned(),
        };
        Err(ImageError::UnknownExtension {
            name: printable(&path.to_string_lossy()),
            found,
            valid: every().map(|e| format!(".{e}")).collect::<Vec<_>>().join(" "),
            nearest: extension
                .and_then(|e| nearest(&e, every()))
                .map_or_else(String::new, |e| format!("; the nearest is .{e}")),
        })
    }

    /// The format of a file by its first bytes; `name` is for the message.
    pub fn of_bytes(bytes: &[u8], name: &str) -> Result<Self, ImageError> {
        if let Some(row) = TABLE.iter().find(|row| bytes.starts_with(row.magic)) {
            return Ok(row.format);
        }
        let found = match FOREIGN.iter().find(|(magic, _)| bytes.starts_with(magic)) {
            _ if bytes.is_empty() => "an empty file".to_owned(),
            Some((_, what)) => (*what).to_owned(),
            None => format!("a file beginning with {:02x?}", &bytes[..bytes.len().min(8)]),
        };
        Err(ImageError::NotAnImage {
            name: printable(name),
            found,
            valid: TABLE.iter().map(|row| row.name).collect::<Vec<_>>().join(", "),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_each_format_once() {
        for format in [ImageFormat::Png, ImageFormat::Exr, ImageFormat::Hdr, ImageFormat::Jpeg] {
            assert_eq!(TABLE.iter().filter(|row| row.format == format).count(), 1);
            assert_eq!(format.row().format, format);
        }
        assert_eq!(ImageFormat::all().count(), TABLE.len());
    }

    #[test]
    fn extensions_are_found_in_any_case_and_the_nearest_is_named() {
        assert_eq!(ImageFormat::of_path(Path::new("a/b.PNG")).ok(), Some(ImageFormat::Png));
        assert_eq!(ImageFormat::of_path(Path::new("x.jpeg")).ok(), Some(ImageFormat::Jpeg));
        let message = ImageFormat::of_path(Path::new("x.pmg")).unwrap_err().to_string();
        assert!(message.contains("nearest is .png") && message.contains(".exr"), "{message}");
        let message = ImageFormat::of_path(Path::new("x")).unwrap_err().to_string();
        assert!(message.contains("no extension"), "{message}");
    }

    #[test]
    fn a_foreign_format_is_named() {
        let message = ImageFormat::of_bytes(b"GIF89a...", "logo.png").unwrap_err().to_string();
        assert!(message.contains("logo.png") && message.contains("GIF"), "{message}");
    }
}
