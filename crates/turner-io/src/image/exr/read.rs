//! Reads the blocks of a part of an EXR file.

use super::FORMAT;
use super::deep;
use super::subsampled::{decompress, full, has_subsampled, repeated, restore, rows};
use crate::image::limits::{Checked, Source};
use crate::image::{DecodeLimits, ImageError};
use exr::block::UncompressedBlock;
use exr::compression::Compression;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use std::borrow::Cow;
use std::collections::HashSet;
use std::io::Cursor;

/// A file whose headers are read.
pub(super) struct Opened<'a> {
    bytes: &'a [u8],
    name: &'a str,
    /// With the samplings of the file; those of the reader are 1.
    headers: Vec<Header>,
    reader: exr::block::reader::Reader<Cursor<Cow<'a, [u8]>>>,
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
        // The exr crate refuses deep parts. Their headers are read as those of flat ones, and their chunks here.
        let flat = deep::flat_headers(bytes);
        let is_deep = flat.is_some();
        let (readable, samplings) = match (flat, full(bytes, name)?) {
            (Some(headers), _) => (Cow::Owned(headers), Vec::new()),
            (None, Some((copy, samplings))) => (Cow::Owned(copy), samplings),
            (None, None) => (Cow::Borrowed(bytes), Vec::new()),
        };
        let reader = exr::block::read(Cursor::new(readable), false).map_err(|error| damaged(name, error))?;
        check_tables(reader.headers(), bytes, name)?;
        let mut headers = reader.headers().to_vec();
        restore(&mut headers, &samplings, name)?;
        headers.iter_mut().for_each(|header| header.deep = is_deep);
        Ok(Opened { bytes, name, headers, reader })
    }

    /// The headers of all parts.
    pub(super) fn headers(&self) -> &[Header] {
        &self.headers
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
        let Some(mut header) = self.headers().get(part).cloned() else { return Ok(()) };
        let wanted = self
            .reader
            .filter_chunks(false, |_, tile, block| block.layer == part && tile.is_largest_resolution_level())
            .map_err(damaged)?;
        let meta = exr::block::reader::ChunksReader::meta_data(&wanted).clone();
        let mut seen = HashSet::new();
        let mut pixels = 0_usize;
        for chunk in wanted {
            let chunk = chunk.map_err(damaged)?;
            let block = decompress(chunk, &meta, &mut header).map_err(damaged)?;
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
    /// The window of all pixels that are stored.
    pub(super) fn of_data(&self, header: &Header) -> Window {
        // The window is checked, so that its sides have 32 bits.
        let (width, height) = (header.layer_size.0 as u32, header.layer_size.1 as u32);
        let size = Checked { width, height, pixels: self.stored };
        Window { size, offset: (0, 0), stored: self.stored }
    }

    /// Copies pixels of the data window, `channels` values each, to where they lie in the display window.
    pub(super) fn place(&self, data: &Window, pixels: &[f32], channels: usize, out: &mut [f32]) {
        let width = data.size.width as usize;
        for (y, row) in pixels.chunks_exact((width * channels).max(1)).enumerate() {
            let Some((first, from, count)) = self.cut((0, y), width) else { continue };
            let to = out.get_mut(first * channels..(first + count) * channels).unwrap_or_default();
            to.copy_from_slice(row.get(from * channels..(from + count) * channels).unwrap_or_default());
        }
    }

    /// The part of `count` pixels at `x`, `y` of the data window that lies in the display window: the index of its
    /// first pixel there, how many are cut before it, and how many there are.
    fn cut(&self, (x, y): (usize, usize), count: usize) -> Option<(usize, usize, usize)> {
        let (width, height) = (i64::from(self.size.width), i64::from(self.size.height));
        let (x, y) = (self.offset.0 + x as i64, self.offset.1 + y as i64);
        let (first, last) = (x.max(0), (x + count as i64).min(width));
        if y < 0 || y >= height || first >= last {
            return None;
        }
        Some(((y * width + first) as usize, (first - x) as usize, (last - first) as usize))
    }

    /// The rows of a block, clipped to the display window. A sample of a channel that has less than one per pixel
    /// counts for the pixels up to the next one.
    fn clip(&self, block: &UncompressedBlock, header: &Header, take: &mut impl FnMut(Line<'_>)) {
        let mut line = |channel: usize, (x, y): (usize, usize), count: usize, bytes: &[u8]| {
            let Some(description) = header.channels.list.get(channel) else { return };
            let Some((first, skip, samples)) = self.cut((x, y), count) else { return };
            let size = description.sample_type.bytes_per_sample();
            let Some(bytes) = bytes.get(skip * size..(skip + samples) * size) else { return };
            take(Line { channel, first, kind: description.sample_type, bytes });
        };
        if !has_subsampled(header) {
            for l in block.lines(&header.channels) {
                let at = (l.location.position.0, l.location.position.1);
                line(l.location.channel, at, l.location.sample_count, l.value);
            }
            return;
        }
        for row in rows(header, block.index) {
            let Some(description) = header.channels.list.get(row.channel) else { continue };
            let Some(bytes) = block.data.get(row.bytes) else { continue };
            let pixels = repeated(bytes, description.sample_type.bytes_per_sample(), row.step);
            let count = block.index.pixel_size.0;
            for y in row.y..(row.y + row.rows).min(header.layer_size.1) {
                line(row.channel, (block.index.pixel_position.0, y), count, &pixels);
            }
        }
    }
}

fn damaged(name: &str, error: exr::error::Error) -> ImageError {
    match error {
        exr::error::Error::NotSupported(what) => {
            let found = what.trim_end_matches("not supported yet").trim_end();
            let expected = "one of the compressions none, rle, zips, zip, piz, pxr24, b44, b44a, dwaa, dwab";
            ImageError::unsupported(name, FORMAT, found, expected)
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
