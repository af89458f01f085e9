//! Reads the blocks of a part of an EXR file.

use super::FORMAT;
use crate::image::limits::{Checked, Source};
use crate::image::{DecodeLimits, ImageError};
use exr::block::UncompressedBlock;
use exr::compression::Compression;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use std::collections::HashSet;
use std::io::Cursor;

/// A file whose headers are read.
pub(super) struct Opened<'a> {
    bytes: &'a [u8],
    name: &'a str,
    reader: exr::block::reader::Reader<Cursor<&'a [u8]>>,
}

/// The rectangle of a part that is read: its display window.
pub(super) struct Window {
    /// Columns, rows and pixels of the display window.
    pub(super) size: Checked,
    /// Position of the data window in the display window.
    offset: (i64, i64),
    /// Pixels of the data window.
    stored: usize,
}

/// The samples of one channel in one row of a block, clipped to the display window.
pub(super) struct Line<'a> {
    /// Index of the channel in the header.
    pub(super) channel: usize,
    /// Index of the first pixel in the display window, row by row.
    pub(super) first: usize,
    /// How the samples are stored, in the machine's byte order.
    pub(super) kind: SampleType,
    /// The samples.
    pub(super) bytes: &'a [u8],
}

impl<'a> Opened<'a> {
    /// Reads the headers and checks the offset tables.
    pub(super) fn new(bytes: &'a [u8], name: &'a str) -> Result<Opened<'a>, ImageError> {
        let reader = exr::block::read(Cursor::new(bytes), false).map_err(|error| damaged(name, error))?;
        check_tables(reader.headers(), bytes, name)?;
        Ok(Opened { bytes, name, reader })
    }

    /// The headers of all parts.
    pub(super) fn headers(&self) -> &[Header] {
        self.reader.headers()
    }

    /// Checks the windows of a part against the limits, for `pixel_bytes` bytes of result per pixel.
    pub(super) fn window(
        &self,
        part: usize,
        pixel_bytes: u64,
        limits: &DecodeLimits,
    ) -> Result<Window, ImageError> {
        let outside = || self.damaged("the data window lies outside the display window");
        let Some(header) = self.headers().get(part) else { return Err(outside()) };
        let source = Source { name: self.name, format: FORMAT, bytes: self.bytes.len() };
        let window = header.shared_attributes.display_window;
        // The display window can be larger than the data in the file; the data window cannot.
        let size = limits.check(source, window.size.0 as u64, window.size.1 as u64, pixel_bytes, u64::MAX)?;
        let stored_pixel = header.channels.bytes_per_pixel as u64;
        let data = header.layer_size;
        let density = pixels_per_byte(header);
        let stored = limits.check(source, data.0 as u64, data.1 as u64, stored_pixel, density)?.pixels;
        let position = header.own_attributes.layer_position;
        let offset = (
            i64::from(position.0) - i64::from(window.position.0),
            i64::from(position.1) - i64::from(window.position.1),
        );
        let overlaps = |at: i64, length: usize, side: u32| at < i64::from(side) && at + length as i64 > 0;
        if !overlaps(offset.0, data.0, size.width) || !overlaps(offset.1, data.1, size.height) {
            return Err(outside());
        }
        Ok(Window { size, offset, stored })
    }

    /// Calls `take` for each row of each channel of a part.
    pub(super) fn lines(
        self,
        part: usize,
        window: &Window,
        mut take: impl FnMut(Line<'_>),
    ) -> Result<(), ImageError> {
        let name = self.name;
        let damaged = |error| damaged(name, error);
        let problem = |what: &str| ImageError::damaged(name, FORMAT, what);
        let Some(header) = self.headers().get(part).cloned() else { return Ok(()) };
        let wanted = self
            .reader
            .filter_chunks(false, |_, tile, block| block.layer == part && tile.is_largest_resolution_level())
            .map_err(damaged)?;
        let meta = exr::block::reader::ChunksReader::meta_data(&wanted).clone();
        let mut seen = HashSet::new();
        let mut pixels = 0_usize;
        for chunk in wanted {
            let chunk = chunk.map_err(damaged)?;
            let block = UncompressedBlock::decompress_chunk(chunk, &meta, false).map_err(damaged)?;
            let at = block.index.pixel_position;
            let area = block.index.pixel_size.0.saturating_mul(block.index.pixel_size.1);
            if block.index.layer != part || block.index.level.0 != 0 || block.index.level.1 != 0 {
                return Err(problem("the offset table refers to a block of another part"));
            }
            if !seen.insert((at.0, at.1)) {
                return Err(problem("the offset table refers to a block twice"));
            }
            pixels = pixels.saturating_add(area);
            window.clip(&block, &header, &mut take);
        }
        if pixels != window.stored {
            return Err(problem(&format!("found {pixels} pixels, expected {}", window.stored)));
        }
        Ok(())
    }

    fn damaged(&self, problem: &str) -> ImageError {
        ImageError::damaged(self.name, FORMAT, problem)
    }
}

impl Window {
    /// The rows of a block, clipped to the display window.
    fn clip(&self, block: &UncompressedBlock, header: &Header, take: &mut impl FnMut(Line<'_>)) {
        let (width, height) = (i64::from(self.size.width), i64::from(self.size.height));
        for line in block.lines(&header.channels) {
            let channel = line.location.channel;
            let Some(description) = header.channels.list.get(channel) else { continue };
            let count = line.location.sample_count as i64;
            let x = self.offset.0 + line.location.position.0 as i64;
            let y = self.offset.1 + line.location.position.1 as i64;
            let (first, last) = (x.max(0), (x + count).min(width));
            if y < 0 || y >= height || first >= last {
                continue;
            }
            let size = description.sample_type.bytes_per_sample();
            let (skip, samples) = ((first - x) as usize * size, (last - first) as usize * size);
            let Some(bytes) = line.value.get(skip..skip + samples) else { continue };
            let first = (y * width + first) as usize;
            take(Line { channel, first, kind: description.sample_type, bytes });
        }
    }
}

fn damaged(name: &str, error: exr::error::Error) -> ImageError {
    match error {
        exr::error::Error::NotSupported(what) => {
            let found = what.trim_end_matches("not supported yet").trim_end();
            ImageError::unsupported(name, FORMAT, found, "flat R, G, B, A or Y at full resolution")
        }
        other => ImageError::damaged(name, FORMAT, other),
    }
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
