//! The supported image formats: one table for extensions, signatures and listings.

use super::{ImageError, bmp, ktx2, pfm, tga};
use crate::assets::{nearest, printable};
use std::path::Path;

/// An entry of the table.
struct Row {
    format: ImageFormat,
    name: &'static str,
    extensions: &'static [&'static str],
    description: &'static str,
    /// Whether the bytes are in this format.
    is: fn(&[u8]) -> bool,
    can_write: bool,
    /// Typical bytes per pixel and channel of an image with incompressible noise.
    bytes_per_channel: u64,
}

/// Defines the formats: each entry is a variant and its table row.
macro_rules! formats {
    ($($(#[doc = $doc:literal])+ $variant:ident { $($line:tt)+ })+) => {
                /// An image file format.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum ImageFormat { $($(#[doc = $doc])+ $variant,)+ }

        const TABLE: &[Row] = &[$(Row { format: ImageFormat::$variant, $($line)+ },)+];
    };
}

formats! {
    /// 8 or 16 bits, display-encoded, lossless.
    Png {
        name: "PNG",
        extensions: &["png"],
        description: "8 or 16 bits per channel, display-encoded, lossless",
        is: |b| b.starts_with(b"\x89PNG\r\n\x1a\n"),
        can_write: true,
        bytes_per_channel: 1,
    }
    /// OpenEXR: linear floats, lossless, with metadata.
    Exr {
        name: "OpenEXR",
        extensions: &["exr"],
        description: "linear 16- or 32-bit floats, lossless, with further channels and metadata",
        is: |b| b.starts_with(b"\x76\x2f\x31\x01"),
        can_write: true,
        bytes_per_channel: 4,
    }
    /// Radiance RGBE: linear, 8 bits of mantissa with a shared exponent.
    Hdr {
        name: "Radiance HDR",
        extensions: &["hdr", "pic", "rgbe"],
        description: "linear, 4 bytes per pixel, accurate to 0.4 % of the brightest channel",
        is: |b| b.starts_with(b"#?"),
        can_write: true,
        bytes_per_channel: 2,
    }
    /// 8 bits, display-encoded, lossy.
    Jpeg {
        name: "JPEG",
        extensions: &["jpg", "jpeg", "jpe"],
        description: "8 bits per channel, lossy",
        is: |b| b.starts_with(b"\xff\xd8\xff"),
        can_write: true,
        bytes_per_channel: 1,
    }
    /// 8 bits, display-encoded, lossy or lossless. Written without loss.
    WebP {
        name: "WebP",
        extensions: &["webp"],
        description: "8 bits per channel, lossy or lossless, with or without alpha",
        is: |b| b.starts_with(b"RIFF") && b.get(8..12) == Some(b"WEBP"),
        can_write: true,
        bytes_per_channel: 1,
    }
    /// 8 bits, display-encoded. Read only.
    Bmp {
        name: "BMP",
        extensions: &["bmp", "dib"],
        description: "8 bits per channel, lossless",
        is: bmp::is_bmp,
        can_write: false,
        bytes_per_channel: 1,
    }
    /// 8 bits, display-encoded. Read only.
    Tga {
        name: "TGA",
        extensions: &["tga", "icb", "vda", "vst"],
        description: "8 bits per channel, lossless; recognised by footer or extension",
        is: |b| b.ends_with(tga::FOOTER),
        can_write: false,
        bytes_per_channel: 1,
    }
    /// Linear floats. Read only.
    Pfm {
        name: "PFM",
        extensions: &["pfm"],
        description: "linear 32-bit floats, grey or RGB",
        is: pfm::is_pfm,
        can_write: false,
        bytes_per_channel: 4,
    }
    /// Textures for GPUs: Basis Universal, or uncompressed samples. Read only.
    Ktx2 {
        name: "KTX2",
        extensions: &["ktx2"],
        description: "Basis Universal textures, or samples of 8, 16 or 32 bits",
        is: |b| b.starts_with(ktx2::SIGNATURE),
        can_write: false,
        bytes_per_channel: 1,
    }
}

/// Remedies for unsupported formats.
const CONVERT: &str = "convert it to PNG, or to OpenEXR if its samples are floats";
const CONVERT_GPU: &str = "convert it to PNG with the format's tools (`ktx extract`, `texconv`, …)";
const CONVERT_STILL: &str = "save the image (or one frame of it) as PNG or JPEG";

/// Well-known formats that are not supported, for better messages: offset of the signature, signature, name, remedy.
const FOREIGN: &[(usize, &[u8], &str, &str)] = &[
    (0, b"\xabKTX", "a KTX 1 texture", CONVERT_GPU),
    (0, b"sB\x13\0", "a Basis Universal texture", CONVERT_GPU),
    (0, b"DDS ", "a DDS texture", CONVERT_GPU),
    (4, b"ftypavi", "an AVIF image", CONVERT_STILL),
    (4, b"ftyphe", "a HEIC image", CONVERT_STILL),
    (4, b"ftypmif1", "a HEIF image", CONVERT_STILL),
    (4, b"ftypmsf1", "a HEIF image", CONVERT_STILL),
    (0, b"GIF8", "a GIF image", CONVERT_STILL),
    (0, b"II*\0", "a TIFF image", CONVERT),
    (0, b"MM\0*", "a TIFF image", CONVERT),
    (0, b"II+\0", "a BigTIFF image", CONVERT),
    (0, b"MM\0+", "a BigTIFF image", CONVERT),
    (0, b"RIFF", "a RIFF file other than WebP", CONVERT),
    (0, b"8BPS", "a Photoshop document", CONVERT),
    (0, b"\0\0\0\x0cjP", "a JPEG 2000 image", CONVERT),
    (0, b"\xff\x0a", "a JPEG XL image", CONVERT),
    (0, b"\0\0\0\x0cJXL", "a JPEG XL image", CONVERT),
    (0, b"qoif", "a QOI image", CONVERT),
    (0, b"\0\0\x01\0", "an icon (ICO)", CONVERT),
    (0, b"P3", "a PPM image", CONVERT),
    (0, b"P6", "a PPM image", CONVERT),
    (0, b"%PDF", "a PDF document", CONVERT_STILL),
    (0, b"\x89P", "a PNG with damaged first bytes (transferred as text?)", "export or download it again"),
    (0, b"version https://git-lfs", "a Git LFS pointer", "run `git lfs pull`"),
];

/// A guess at an unsupported file's format, and the remedy.
fn foreign(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    if bytes.is_empty() {
        return Some(("an empty file", "export or download it again"));
    }
    let is = |(at, magic): (usize, &[u8])| bytes.get(at..).is_some_and(|b| b.starts_with(magic));
    if let Some(&(_, _, what, remedy)) = FOREIGN.iter().find(|(at, magic, ..)| is((*at, magic))) {
        return Some((what, remedy));
    }
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if !text.starts_with(b"<") {
        return None;
    }
    let head = &text[..text.len().min(1024)];
    let svg = head.windows(4).any(|w| w.eq_ignore_ascii_case(b"<svg"));
    Some(if svg {
        ("an SVG drawing", "convert it to a PNG of the required size")
    } else {
        ("markup text (an error page?)", "download it again")
    })
}

impl ImageFormat {
    /// All formats, in the order of the table.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|row| row.format)
    }

    fn row(self) -> &'static Row {
        // Every variant has a row; the fallback only avoids a panic.
        TABLE.iter().find(|row| row.format == self).unwrap_or(&TABLE[0])
    }

    /// An estimate of the largest file size of an opaque image, for one with incompressible noise and, in
    /// display-encoded formats, 8 bits per channel.
    pub fn most_bytes(self, width: u32, height: u32) -> u64 {
        let pixels = u64::from(width) * u64::from(height);
        pixels.saturating_mul(3 * self.row().bytes_per_channel).saturating_add(4096)
    }

    /// The format's name: `PNG`, `OpenEXR`, …
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// The extensions of the format, in lower case, the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        self.row().extensions
    }

    /// A short description, for listings.
    pub fn description(self) -> &'static str {
        self.row().description
    }

    /// Whether [`super::decode`] reads it: true for all formats.
    pub fn can_read(self) -> bool {
        true
    }

    /// Whether [`super::encode`] writes it.
    pub fn can_write(self) -> bool {
        self.row().can_write
    }

    /// The writable format of an output path, by its extension in upper or lower case.
    pub fn of_path(path: &Path) -> Result<Self, ImageError> {
        let extension = lower_extension(path);
        let every =
            || TABLE.iter().filter(|row| row.can_write).flat_map(|row| row.extensions.iter().copied());
        let row = TABLE.iter().find(|row| extension.as_deref().is_some_and(|e| row.extensions.contains(&e)));
        if let Some(row) = row.filter(|row| row.can_write) {
            return Ok(row.format);
        }
        let (found, problem) = match (&extension, row) {
            (_, Some(row)) => (row.name.to_owned(), "can be read but not written"),
            (Some(e), None) => (format!("the extension .{}", printable(e)), "is not an image format"),
            (None, None) => ("a name with no extension".to_owned(), "does not select an image format"),
        };
        Err(ImageError::UnknownExtension {
            name: printable(&path.to_string_lossy()),
            found,
            problem,
            valid: every().map(|e| format!(".{e}")).collect::<Vec<_>>().join(" "),
            nearest: extension
                .filter(|_| row.is_none())
                .and_then(|e| nearest(&e, every()))
                .map_or_else(String::new, |e| format!("; the nearest is .{e}")),
        })
    }

    /// The format of a file by its bytes, or for TGA, which has no signature, by the extension of `name`.
    pub fn of_bytes(bytes: &[u8], name: &str) -> Result<Self, ImageError> {
        if let Some(row) = TABLE.iter().find(|row| (row.is)(bytes)) {
            return Ok(row.format);
        }
        let foreign = foreign(bytes);
        let is_tga = |e: String| ImageFormat::Tga.extensions().contains(&e.as_str());
        if foreign.is_none() && lower_extension(Path::new(name)).is_some_and(is_tga) {
            return Ok(ImageFormat::Tga);
        }
        let (found, remedy) = match foreign {
            Some((what, remedy)) => (what.to_owned(), remedy),
            None => (format!("a file that begins with {:02x?}", &bytes[..bytes.len().min(8)]), CONVERT),
        };
        Err(ImageError::NotAnImage {
            name: printable(name),
            found,
            valid: TABLE.iter().map(|row| row.name).collect::<Vec<_>>().join(", "),
            remedy,
        })
    }
}

fn lower_extension(path: &Path) -> Option<String> {
    path.extension().map(|e| e.to_string_lossy().to_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_extension_means_one_format() {
        for format in ImageFormat::all() {
            assert_eq!(format.row().format, format);
            for extension in format.extensions() {
                let rows = TABLE.iter().filter(|row| row.extensions.contains(extension));
                assert_eq!((rows.count(), *extension), (1, extension.to_lowercase().as_str()), "{extension}");
            }
        }
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
    fn formats_that_are_read_only_are_no_outputs() {
        let message = ImageFormat::of_path(Path::new("x.bmp")).unwrap_err().to_string();
        assert!(
            message.contains("BMP can be read but not written") && !message.contains(".tga"),
            "{message}"
        );
    }

    #[test]
    fn a_foreign_format_is_named_with_a_remedy() {
        let cases: &[(&[u8], &str, &str)] = &[
            (b"GIF89a...", "GIF", "PNG"),
            (b"\xabKTX 11\xbb\r\n\x1a\n", "KTX 1", "ktx extract"),
            (b"sB\x13\0....", "Basis", "PNG"),
            (b"DDS |...", "DDS", "texconv"),
            (b"\0\0\0\x20ftypavif", "AVIF", "PNG"),
            (b"\0\0\0\x20ftypheic", "HEIC", "PNG"),
            (b"II*\0....", "TIFF", "OpenEXR"),
            (b"\xef\xbb\xbf<?xml version='1.0'?>\n<svg width='3'>", "SVG", "PNG"),
            (b" <!DOCTYPE html>", "error page", "download"),
            (b"", "empty", "again"),
        ];
        for (bytes, what, remedy) in cases {
            for name in ["logo.png", "logo.tga"] {
                let message = ImageFormat::of_bytes(bytes, name).unwrap_err().to_string();
                assert!(message.starts_with(name), "{message}");
                assert!(message.contains(what) && message.contains(remedy), "{message}");
            }
        }
    }

    #[test]
    fn content_counts_before_the_extension() {
        assert_eq!(ImageFormat::of_bytes(b"\xff\xd8\xff", "x.tga").ok(), Some(ImageFormat::Jpeg));
        assert_eq!(ImageFormat::of_bytes(b"\0\0\x02\0", "x.TGA").ok(), Some(ImageFormat::Tga));
        assert_eq!(ImageFormat::of_bytes(b"\0\0\x02TRUEVISION-XFILE.\0", "x").ok(), Some(ImageFormat::Tga));
        assert!(ImageFormat::of_bytes(b"\0\0\x02\0", "x").is_err());
        assert!(ImageFormat::of_bytes(b"BM is a text", "x").is_err());
    }
}
