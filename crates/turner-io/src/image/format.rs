//! The formats there are: one table for extensions, first bytes and listings.

use super::{ImageError, bmp, pfm, tga};
use crate::assets::{nearest, printable};
use std::path::Path;

/// One line of the table.
struct Row {
    format: ImageFormat,
    name: &'static str,
    extensions: &'static [&'static str],
    description: &'static str,
    /// Whether a file is in this format, by its bytes.
    is: fn(&[u8]) -> bool,
    can_write: bool,
    /// Bytes per pixel and channel of a picture whose noise does not let it be packed.
    bytes_per_channel: u64,
}

/// The table of formats: each entry is a variant and its line.
macro_rules! formats {
    ($($(#[doc = $doc:literal])+ $variant:ident { $($line:tt)+ })+) => {
        /// A file format for pictures.
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
        description: "8 or 16 bits per channel, lossless: what the display shows",
        is: |b| b.starts_with(b"\x89PNG\r\n\x1a\n"),
        can_write: true,
        bytes_per_channel: 1,
    }
    /// OpenEXR: linear floats, lossless, with metadata.
    Exr {
        name: "OpenEXR",
        extensions: &["exr"],
        description: "linear 32-bit floats with metadata, lossless: what was computed",
        is: |b| b.starts_with(b"\x76\x2f\x31\x01"),
        can_write: true,
        bytes_per_channel: 4,
    }
    /// Radiance RGBE: linear, 8 bits of mantissa with a shared exponent.
    Hdr {
        name: "Radiance HDR",
        extensions: &["hdr", "pic", "rgbe"],
        description: "linear light in 4 bytes per pixel, to 0.4 % of the brightest channel",
        is: |b| b.starts_with(b"#?"),
        can_write: true,
        bytes_per_channel: 2,
    }
    /// 8 bits, display-encoded, lossy.
    Jpeg {
        name: "JPEG",
        extensions: &["jpg", "jpeg", "jpe"],
        description: "8 bits per channel, lossy: for looking at, not for comparing",
        is: |b| b.starts_with(b"\xff\xd8\xff"),
        can_write: true,
        bytes_per_channel: 1,
    }
    /// 8 bits, display-encoded, lossy or lossless. Read only.
    WebP {
        name: "WebP",
        extensions: &["webp"],
        description: "8 bits per channel, lossy or lossless, with or without alpha",
        is: |b| b.starts_with(b"RIFF") && b.get(8..12) == Some(b"WEBP"),
        can_write: false,
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
        description: "8 bits per channel, lossless; known by its footer or its extension",
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
}

/// What to do about most formats that are not read.
const CONVERT: &str = "convert it to PNG, or to OpenEXR if its samples are floats";
const CONVERT_GPU: &str =
    "convert it to PNG: the texture tools of its maker do that (`ktx extract`, `texconv`, …)";
const CONVERT_STILL: &str = "save the picture (or the one frame of it that is meant) as PNG or JPEG";

/// Formats that people try and that are not read, so that the message can name them: where their signature stands,
/// the signature, the name, the remedy.
const FOREIGN: &[(usize, &[u8], &str, &str)] = &[
    (0, b"\xabKTX 20\xbb", "a KTX2 (Basis Universal) texture", CONVERT_GPU),
    (0, b"\xabKTX", "a KTX texture", CONVERT_GPU),
    (0, b"sB\x13\0", "a Basis Universal texture", CONVERT_GPU),
    (0, b"DDS ", "a DDS texture", CONVERT_GPU),
    (4, b"ftypavi", "an AVIF picture", CONVERT_STILL),
    (4, b"ftyphe", "a HEIC picture", CONVERT_STILL),
    (4, b"ftypmif1", "a HEIF picture", CONVERT_STILL),
    (4, b"ftypmsf1", "a HEIF picture", CONVERT_STILL),
    (0, b"GIF8", "a GIF picture", CONVERT_STILL),
    (0, b"II*\0", "a TIFF picture", CONVERT),
    (0, b"MM\0*", "a TIFF picture", CONVERT),
    (0, b"II+\0", "a BigTIFF picture", CONVERT),
    (0, b"MM\0+", "a BigTIFF picture", CONVERT),
    (0, b"RIFF", "a RIFF file that is no WebP", CONVERT),
    (0, b"8BPS", "a Photoshop document", CONVERT),
    (0, b"\0\0\0\x0cjP", "a JPEG 2000 picture", CONVERT),
    (0, b"\xff\x0a", "a JPEG XL picture", CONVERT),
    (0, b"\0\0\0\x0cJXL", "a JPEG XL picture", CONVERT),
    (0, b"qoif", "a QOI picture", CONVERT),
    (0, b"\0\0\x01\0", "an icon (ICO)", CONVERT),
    (0, b"P3", "a PPM picture", CONVERT),
    (0, b"P6", "a PPM picture", CONVERT),
    (0, b"%PDF", "a PDF document", CONVERT_STILL),
    (0, b"\x89P", "a PNG with damaged first bytes (transferred as text?)", "export or download it again"),
    (0, b"version https://git-lfs", "a Git LFS pointer", "run `git lfs pull`"),
];

/// What a file without a known signature is, as far as that can be told, and what to do about it.
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
        ("an SVG drawing", "draw it into a PNG of the size that is needed")
    } else {
        ("a text in angle brackets (an error page?)", "download it again")
    })
}

impl ImageFormat {
    /// Every format, in the order of the table.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|row| row.format)
    }

    fn row(self) -> &'static Row {
        // Each variant has its line. The fallback keeps this free of panics.
        TABLE.iter().find(|row| row.format == self).unwrap_or(&TABLE[0])
    }

    /// Bytes that an opaque picture may take whose noise does not let it be packed, with 8 bits a channel where the format
    /// holds display values.
    pub fn most_bytes(self, width: u32, height: u32) -> u64 {
        let pixels = u64::from(width) * u64::from(height);
        pixels.saturating_mul(3 * self.row().bytes_per_channel).saturating_add(4096)
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

    /// Whether [`super::decode`] reads it: all of them, today.
    pub fn can_read(self) -> bool {
        true
    }

    /// Whether [`super::encode`] writes it.
    pub fn can_write(self) -> bool {
        self.row().can_write
    }

    /// The format that an output path asks for by its extension, in upper or lower case: one that is written.
    pub fn of_path(path: &Path) -> Result<Self, ImageError> {
        let extension = lower_extension(path);
        let every =
            || TABLE.iter().filter(|row| row.can_write).flat_map(|row| row.extensions.iter().copied());
        let row = TABLE.iter().find(|row| extension.as_deref().is_some_and(|e| row.extensions.contains(&e)));
        if let Some(row) = row.filter(|row| row.can_write) {
            return Ok(row.format);
        }
        let (found, problem) = match (&extension, row) {
            (_, Some(row)) => (row.name.to_owned(), "is read, not written"),
            (Some(e), None) => (format!("the extension .{}", printable(e)), "names no picture format"),
            (None, None) => ("no extension".to_owned(), "names no picture format"),
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

    /// The format of a file by its bytes; for TGA, which has no signature, by the extension of `name`.
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
            None => (format!("a file beginning with {:02x?}", &bytes[..bytes.len().min(8)]), CONVERT),
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
        let message = ImageFormat::of_path(Path::new("x.webp")).unwrap_err().to_string();
        assert!(message.contains("WebP is read, not written") && !message.contains(".tga"), "{message}");
    }

    #[test]
    fn a_foreign_format_is_named_with_a_remedy() {
        let cases: &[(&[u8], &str, &str)] = &[
            (b"GIF89a...", "GIF", "PNG"),
            (b"\xabKTX 20\xbb\r\n\x1a\n", "KTX2", "ktx extract"),
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
