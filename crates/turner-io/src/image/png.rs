//! PNG: 8 or 16 bits, display-encoded, lossless.
//!
//! Palettes, 1-, 2- and 4-bit grey, and transparent colours are expanded. An animated PNG gives its default image.
//! Gamma and profile chunks are not applied, and compressed text chunks are not decompressed.

use super::contain::contain;
use super::icc::display_p3;
use super::limits::{Source, buffer, reserve};
use super::strips::refused;
use super::{
    DecodeLimits, ImageError, ImageFormat, MetaValue, Metadata, OutputImage, StripImage, Transfer, WriteSeek,
};
use miniz_oxide::deflate::compress_to_vec_zlib;
use png::chunk::ChunkType;
use png::{BitDepth, ColorType, DecodeOptions, Decoder, DecodingError, Encoder, Transformations};
use std::io::{self, Cursor, Write};
use turner::color::DisplaySpace;
use turner::image::{Image, Pixels};

const FORMAT: ImageFormat = ImageFormat::Png;

/// Deflate expands at most 1032 times, and a byte holds at most eight 1-bit pixels.
const PIXELS_PER_BYTE: u64 = 1032 * 8;

/// Reads a PNG: [`Pixels::U16`] from 16-bit files, [`Pixels::U8`] from all others.
pub fn decode(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    contain(name, FORMAT, || decode_inner(bytes, name, limits))
}

fn decode_inner(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    let damaged = |e: DecodingError| {
        let text = e.to_string();
        let found = if text.starts_with("CRC error") { "the checksum of a chunk is wrong" } else { &text };
        ImageError::damaged(name, FORMAT, found)
    };
    let mut options = DecodeOptions::default();
    options.set_ignore_text_chunk(true);
    options.set_ignore_iccp_chunk(true);
    options.set_ignore_adler32(false);
    let mut decoder = Decoder::new_with_options(Cursor::new(bytes), options);
    let header = decoder.read_header_info().map_err(damaged)?;
    let (width, height) = header.size();
    let deep = header.bit_depth == BitDepth::Sixteen;
    // Four channels, because a transparent colour defined later adds one.
    let pixel_bytes = if deep { 8 } else { 4 };
    let source = Source { name, format: FORMAT, bytes: bytes.len() };
    let size = limits.check(source, width.into(), height.into(), pixel_bytes, PIXELS_PER_BYTE)?;

    // Memory for the decoder itself: rows, palettes, small chunks.
    let rows = size.pixels / height as usize * 32;
    decoder.set_limits(png::Limits { bytes: rows.saturating_add(64 << 20) });
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(damaged)?;
    let (color, depth) = reader.output_color_type();
    let channels = match color {
        ColorType::Grayscale => 1,
        ColorType::GrayscaleAlpha => 2,
        ColorType::Rgb => 3,
        ColorType::Rgba => 4,
        ColorType::Indexed => return Err(ImageError::damaged(name, FORMAT, "a palette is missing")),
    };
    let samples = size.pixels * usize::from(channels);
    let expected = samples * if depth == BitDepth::Sixteen { 2 } else { 1 };
    if reader.output_buffer_size() != Some(expected) {
        return Err(ImageError::damaged(name, FORMAT, "the header is inconsistent"));
    }
    let mut data = buffer::<u8>(expected, name)?;
    reader.next_frame(&mut data).map_err(damaged)?;
    // Read the rest of the stream with its checksum, and the end of the file.
    reader.finish().map_err(damaged)?;
    let pixels = if depth == BitDepth::Sixteen {
        let mut wide = Vec::new();
        reserve(&mut wide, samples, name)?;
        wide.extend(data.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])));
        Pixels::U16(wide)
    } else {
        Pixels::U8(data)
    };
    Ok(Image { width: size.width, height: size.height, channels, pixels })
}

/// Encodes the display samples with 8 or 16 bits, RGB or RGBA, and declares the transfer and the metadata.
pub fn encode(image: &OutputImage<'_>) -> Result<Vec<u8>, ImageError> {
    super::encode(image, FORMAT)
}

/// Images of more bytes are compressed while their rows are computed; others all at once, which stores noise that cannot
/// be compressed as it is.
const WHOLE: u64 = 64 << 20;

/// Pixels of a strip.
const STRIP: u32 = 1 << 20;

/// Bytes of a chunk of a large image.
const CHUNK: usize = 1 << 18;

/// Writes the display samples strip by strip.
pub(super) fn write(strips: &StripImage<'_>, out: &mut dyn WriteSeek) -> io::Result<()> {
    let image = strips.image;
    image.pixels(FORMAT).map_err(refused)?;
    super::metadata::check(image.metadata, FORMAT).map_err(refused)?;
    let mut encoder = Encoder::new(out, image.width, image.height);
    encoder.set_color(if image.alpha { ColorType::Rgba } else { ColorType::Rgb });
    encoder.set_depth(if strips.is_deep { BitDepth::Sixteen } else { BitDepth::Eight });
    encoder.set_compression(png::Compression::Fast);
    match image.transfer {
        Transfer::Srgb => encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric),
        Transfer::Gamma(gamma) if (0.01..=100.0).contains(&gamma) => {
            // In units of 10^-5, rounded; the crate's own conversion truncates.
            let scaled = (100_000.0 / f64::from(gamma)).round() as u32;
            encoder.set_source_gamma(png::ScaledFloat::from_scaled(scaled));
        }
        Transfer::Gamma(gamma) => {
            let problem = format!("display gamma {gamma}; expected 0.01 to 100");
            return Err(refused(ImageError::encode(FORMAT, problem)));
        }
        Transfer::DisplayP3 | Transfer::Rec2100Pq | Transfer::Unstated => {}
    }
    for (name, value) in image.metadata {
        // tEXt is Latin-1; other text needs iTXt.
        let (name, text) = (name.clone(), value.to_string());
        let added = if text.is_ascii() {
            encoder.add_text_chunk(name, text)
        } else {
            encoder.add_itxt_chunk(name, text)
        };
        added.map_err(failed)?;
    }
    let mut writer = encoder.write_header().map_err(failed)?;
    for (kind, data) in color_chunks(image.transfer) {
        writer.write_chunk(kind, &data).map_err(failed)?;
    }
    let mut bytes = Vec::new();
    let pixel = if image.alpha { 4 } else { 3 } * if strips.is_deep { 2 } else { 1 };
    if u64::from(image.width) * u64::from(image.height) * pixel <= WHOLE {
        strips.append_display(0..image.height, &mut bytes)?;
        writer.write_image_data(&bytes).map_err(failed)?;
        return writer.finish().map_err(failed);
    }
    let mut stream = writer.stream_writer_with_size(CHUNK).map_err(failed)?;
    for rows in strips.strips(STRIP) {
        bytes.clear();
        strips.append_display(rows, &mut bytes)?;
        stream.write_all(&bytes)?;
    }
    stream.finish().map_err(failed)?;
    writer.finish().map_err(failed)
}

/// The error of a writer.
fn failed(error: png::EncodingError) -> io::Error {
    match error {
        png::EncodingError::IoError(error) => error,
        other => refused(ImageError::encode(FORMAT, other)),
    }
}

/// The chunks of colour spaces that the png crate does not write: cICP, with the code points of ITU-T H.273 for
/// primaries, transfer, no matrix, full range; and for Display P3 an ICC profile for older programs.
fn color_chunks(transfer: Transfer) -> Vec<(ChunkType, Vec<u8>)> {
    let cicp = |space: DisplaySpace| {
        let [primaries, curve] = space.code_points();
        (ChunkType(*b"cICP"), vec![primaries, curve, 0, 1])
    };
    match transfer {
        Transfer::DisplayP3 => {
            let mut profile = b"Display P3\0\0".to_vec();
            profile.extend(compress_to_vec_zlib(&display_p3(), 9));
            vec![cicp(DisplaySpace::DisplayP3), (ChunkType(*b"iCCP"), profile)]
        }
        Transfer::Rec2100Pq => vec![cicp(DisplaySpace::Rec2100Pq)],
        Transfer::Srgb | Transfer::Gamma(_) | Transfer::Unstated => Vec::new(),
    }
}

/// Encodes an image of 8 or 16 bits as it is: grey or RGB, with or without alpha, without a declared encoding.
pub fn encode_samples(image: &Image) -> Result<Vec<u8>, ImageError> {
    let failed = |e: png::EncodingError| ImageError::encode(FORMAT, e);
    if !image.is_consistent() {
        return Err(ImageError::encode(FORMAT, "the number of samples does not match the size"));
    }
    let mut out = Vec::new();
    let mut encoder = Encoder::new(&mut out, image.width, image.height);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_color(match image.channels {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    });
    let wide: Vec<u8>;
    let bytes = match &image.pixels {
        Pixels::U8(samples) => samples,
        Pixels::U16(samples) => {
            encoder.set_depth(BitDepth::Sixteen);
            wide = samples.iter().flat_map(|v| v.to_be_bytes()).collect();
            &wide
        }
        Pixels::F32(_) => return Err(ImageError::encode(FORMAT, "the samples are floats")),
    };
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(bytes).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(out)
}

/// The uncompressed text of a PNG (tEXt and uncompressed iTXt chunks). Checksums are not verified.
pub fn read_metadata(bytes: &[u8], name: &str) -> Result<Metadata, ImageError> {
    let mut metadata = Metadata::new();
    let mut rest = bytes.get(8..).unwrap_or_default();
    // A chunk: length, four letters, data, checksum.
    while let Some((head, tail)) = rest.split_first_chunk::<8>() {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(data) = tail.get(..length) else {
            return Err(ImageError::damaged(name, FORMAT, "a chunk extends beyond the end of the file"));
        };
        let entry = match &head[4..] {
            b"tEXt" => split_at_nul(data).map(|(k, v)| (k, latin_1(v))),
            b"iTXt" => international(data),
            b"IEND" => break,
            _ => None,
        };
        if let Some((key, text)) = entry {
            metadata.insert(latin_1(key), MetaValue::Text(text));
        }
        rest = tail.get(length.saturating_add(4)..).unwrap_or_default();
    }
    Ok(metadata)
}

/// Parses iTXt: keyword, NUL, compression flag, compression method, language, NUL, translated keyword, NUL, UTF-8
/// text.
fn international(data: &[u8]) -> Option<(&[u8], String)> {
    let (key, rest) = split_at_nul(data)?;
    let rest = rest.strip_prefix(&[0, 0])?;
    let (_language, rest) = split_at_nul(rest)?;
    let (_translated, text) = split_at_nul(rest)?;
    Some((key, String::from_utf8(text.to_vec()).ok()?))
}

fn split_at_nul(data: &[u8]) -> Option<(&[u8], &[u8])> {
    let nul = data.iter().position(|&b| b == 0)?;
    Some((&data[..nul], &data[nul + 1..]))
}

fn latin_1(bytes: &[u8]) -> String {
    bytes.iter().map(|&b| char::from(b)).collect()
}
