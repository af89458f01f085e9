//! Reads EXR files.

use super::FORMAT;
use super::channels::{Choice, choose};
use crate::image::contain::contain;
use crate::image::limits::{Source, buffer};
use crate::image::{DecodeLimits, ImageError};
use exr::block::UncompressedBlock;
use exr::compression::Compression;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::f16;
use std::collections::HashSet;
use std::io::Cursor;
use turner::image::{Image, Pixels};

/// Reads an EXR file. Colours are divided by alpha, because [`Image`] has straight alpha. Where alpha is 0 the colour
/// (emission without coverage) is kept.
pub fn decode(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    let mut image = decode_as_stored(bytes, name, limits)?;
    if let (Pixels::F32(samples), n @ (2 | 4)) = (&mut image.pixels, usize::from(image.channels)) {
        for pixel in samples.chunks_exact_mut(n) {
            let alpha = pixel[n - 1];
            if alpha > 0.0 && alpha != 1.0 {
                pixel[..n - 1].iter_mut().for_each(|v| *v /= alpha);
            }
        }
    }
    Ok(image)
}

/// Reads an EXR file with the values as stored: colours stay premultiplied by alpha.
pub fn decode_as_stored(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    contain(name, FORMAT, || read(bytes, name, limits))
}

fn read(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    let damaged = |e: exr::error::Error| match e {
        exr::error::Error::NotSupported(what) => {
            let found = what.trim_end_matches("not supported yet").trim_end();
            ImageError::unsupported(name, FORMAT, found, "flat R, G, B, A or Y at full resolution")
        }
        other => ImageError::damaged(name, FORMAT, other),
    };
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(damaged)?;
    let choice = choose(reader.headers(), name)?;
    let header = reader.headers()[choice.layer].clone();
    check_tables(reader.headers(), bytes, name)?;
    let channels = usize::from(choice.channels);
    let source = Source { name, format: FORMAT, bytes: bytes.len() };
    let window = header.shared_attributes.display_window;
    // The display window can be larger than the data in the file; the data window cannot.
    let size =
        limits.check(source, window.size.0 as u64, window.size.1 as u64, 4 * channels as u64, u64::MAX)?;
    let stored_pixel = header.channels.bytes_per_pixel as u64;
    let data = header.layer_size;
    let density = pixels_per_byte(&header);
    let data_size = limits.check(source, data.0 as u64, data.1 as u64, stored_pixel, density)?;

    let position = header.own_attributes.layer_position;
    let offset = (
        i64::from(position.0) - i64::from(window.position.0),
        i64::from(position.1) - i64::from(window.position.1),
    );
    let overlaps = |at: i64, length: usize, side: u32| at < i64::from(side) && at + length as i64 > 0;
    if !overlaps(offset.0, data.0, size.width) || !overlaps(offset.1, data.1, size.height) {
        return Err(ImageError::damaged(name, FORMAT, "the data window lies outside the display window"));
    }
    let mut picture = Picture {
        samples: buffer(size.pixels * channels, name)?,
        width: i64::from(size.width),
        height: i64::from(size.height),
        offset,
    };
    let layer = choice.layer;
    let wanted = reader
        .filter_chunks(false, |_, tile, block| block.layer == layer && tile.is_largest_resolution_level())
        .map_err(damaged)?;
    let meta = exr::block::reader::ChunksReader::meta_data(&wanted).clone();
    let mut seen = HashSet::new();
    let mut pixels = 0_usize;
    for chunk in wanted {
        let block =
            UncompressedBlock::decompress_chunk(chunk.map_err(damaged)?, &meta, false).map_err(damaged)?;
        let at = block.index.pixel_position;
        let area = block.index.pixel_size.0.saturating_mul(block.index.pixel_size.1);
        if block.index.layer != layer || block.index.level.0 != 0 || block.index.level.1 != 0 {
            return Err(ImageError::damaged(
                name,
                FORMAT,
                "the offset table refers to a block of another part",
            ));
        }
        if !seen.insert((at.0, at.1)) {
            return Err(ImageError::damaged(name, FORMAT, "the offset table refers to a block twice"));
        }
        pixels = pixels.saturating_add(area);
        picture.add(&block, &header, &choice);
    }
    if pixels != data_size.pixels {
        let problem = format!("found {pixels} pixels, expected {}", data_size.pixels);
        return Err(ImageError::damaged(name, FORMAT, problem));
    }
    let (width, height) = (size.width, size.height);
    Ok(Image { width, height, channels: choice.channels, pixels: Pixels::F32(picture.samples) })
}

/// Checks that the offset tables, eight bytes per chunk, fit in the file before they are used.
fn check_tables(headers: &[Header], bytes: &[u8], name: &str) -> Result<(), ImageError> {
    let chunks = headers.iter().fold(0_usize, |sum, h| sum.saturating_add(h.chunk_count));
    if chunks > bytes.len() / 8 {
        let problem = format!("{chunks} blocks announced in a file of {} bytes", bytes.len());
        return Err(ImageError::damaged(name, FORMAT, problem));
    }
    Ok(())
}

/// Most pixels that a byte of the file can represent. Deflate expands at most 1032 times, other methods less, except
/// DWA, which deflates data that is already reduced.
fn pixels_per_byte(header: &Header) -> u64 {
    match header.compression {
        Compression::DWAA(_) | Compression::DWAB(_) => 1 << 17,
        _ => 1100,
    }
}

/// The image under construction: the samples of the display window.
struct Picture {
    samples: Vec<f32>,
    width: i64,
    height: i64,
    /// Position of the data window in the display window.
    offset: (i64, i64),
}

impl Picture {
    /// Copies the selected channels of a block, clipped to the display window.
    fn add(&mut self, block: &UncompressedBlock, header: &Header, choice: &Choice) {
        let n = usize::from(choice.channels);
        for line in block.lines(&header.channels) {
            let channel = line.location.channel;
            let (Some(Some(to)), Some(description)) =
                (choice.to.get(channel), header.channels.list.get(channel))
            else {
                continue;
            };
            let count = line.location.sample_count as i64;
            let x = self.offset.0 + line.location.position.0 as i64;
            let y = self.offset.1 + line.location.position.1 as i64;
            let (first, last) = (x.max(0), (x + count).min(self.width));
            if y < 0 || y >= self.height || first >= last {
                continue;
            }
            let skip = (first - x) as usize;
            let row = ((y * self.width + first) as usize) * n;
            let end = row + (last - first) as usize * n;
            let Some(out) = self.samples.get_mut(row..end) else { continue };
            let out = out.chunks_exact_mut(n).map(|p| &mut p[usize::from(*to)]);
            // The exr crate returns samples in native byte order.
            match description.sample_type {
                SampleType::F16 => copy(line.value, skip, out, |b| f16::from_ne_bytes(b).to_f32()),
                SampleType::F32 => copy(line.value, skip, out, f32::from_ne_bytes),
                SampleType::U32 => copy(line.value, skip, out, |b| u32::from_ne_bytes(b) as f32),
            }
        }
    }
}

fn copy<'a, const N: usize>(
    bytes: &[u8],
    skip: usize,
    out: impl Iterator<Item = &'a mut f32>,
    convert: impl Fn([u8; N]) -> f32,
) {
    let (samples, _) = bytes.as_chunks::<N>();
    out.zip(samples.iter().skip(skip)).for_each(|(to, from)| *to = convert(*from));
}
