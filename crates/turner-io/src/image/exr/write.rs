//! Writes EXR files.

use super::columns::{Column, Source};
use super::sorted_header::SortedHeader;
use super::{ExrCompression, FORMAT};
use crate::image::output_image::workers;
use crate::image::strips::refused;
use crate::image::{
    ImageError, MetaValue, Metadata, OutputImage, SampleKind, StripImage, WriteSeek, extra_channel,
};
use exr::block::BlockIndex;
use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use exr::block::writer::ChunksWriter;
use exr::compression::Compression;
use exr::error::Error;
use exr::meta::BlockDescription;
use exr::meta::attribute::{AttributeValue, IntegerBounds, LineOrder, Text};
use exr::meta::header::{Header, standard_names};
use miniz_oxide::deflate::compress_to_vec_zlib;
use std::borrow::Cow;
use std::cell::Cell;
use std::io::{self, Cursor};
use std::ops::Range;
use turner::image::{Image, Pixels};

/// Encodes the linear samples, the further channels and the metadata, as one part.
pub fn encode(image: &OutputImage<'_>) -> Result<Vec<u8>, ImageError> {
    crate::image::encode(image, FORMAT)
}

/// Writes the same with samples that are computed block by block.
pub(in crate::image) fn write(strips: &StripImage<'_>, out: &mut dyn WriteSeek) -> io::Result<()> {
    let image = strips.image;
    let pixels = image.pixels(FORMAT).map_err(refused)?;
    extra_channel::check(image.channels, pixels, FORMAT).map_err(refused)?;
    let kind = if image.exr.half { SampleKind::Half } else { SampleKind::Float };
    let names = if image.alpha { &["R", "G", "B", "A"][..] } else { &["R", "G", "B"] };
    let color = names.iter().enumerate().map(|(i, name)| Column { name, kind, source: Source::Strip(i) });
    let columns = color.chain(image.channels.iter().map(Column::extra)).collect();
    let size = (image.width, image.height);
    let mut file = File::new(size, columns, image.exr.compression);
    // Blocks are computed on all threads at once, each block on one.
    let rows = |rows: Range<u32>| strips.linear(rows, 1);
    file.rows = Some(&rows);
    file.write(image.metadata, image.threads, out)
}

/// Encodes an image of floats with its channels as Y, Y A, R G B or R G B A; colours are premultiplied by alpha, as
/// EXR requires.
pub fn encode_samples(image: &Image) -> Result<Vec<u8>, ImageError> {
    let Pixels::F32(samples) = &image.pixels else {
        return Err(ImageError::encode(FORMAT, "the samples are not floats"));
    };
    if !image.is_consistent() {
        return Err(ImageError::encode(FORMAT, "the number of samples does not match the size"));
    }
    let names: &[&str] = match image.channels {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    let stride = names.len();
    let column = |(channel, name): (usize, &&'static str)| {
        let times_alpha = stride.is_multiple_of(2) && *name != "A";
        let source = Source::Interleaved { samples, stride, channel, times_alpha };
        Column { name, kind: SampleKind::Float, source }
    };
    let columns = names.iter().enumerate().map(column).collect();
    let file = File::new((image.width, image.height), columns, ExrCompression::Zip);
    let mut out = Cursor::new(Vec::new());
    match file.write(&Metadata::new(), 0, &mut out) {
        Ok(()) => Ok(out.into_inner()),
        Err(error) => Err(ImageError::encode(FORMAT, error)),
    }
}

/// Computes the linear samples of rows.
type Rows<'a> = &'a (dyn Fn(Range<u32>) -> io::Result<Cow<'a, [[f32; 4]]>> + Sync);

/// A file to be written.
struct File<'a> {
    width: usize,
    height: usize,
    /// In the order of the names, as the format requires.
    columns: Vec<Column<'a>>,
    /// The samples of columns from [`Source::Strip`].
    rows: Option<Rows<'a>>,
    compression: ExrCompression,
}

/// Pixels that are compressed before they are written: enough for many threads.
const BATCH: usize = 1 << 20;

impl<'a> File<'a> {
    fn new((width, height): (u32, u32), mut columns: Vec<Column<'a>>, compression: ExrCompression) -> Self {
        columns.sort_by_key(|c| c.name);
        File { width: width as usize, height: height as usize, columns, rows: None, compression }
    }

    fn write(&self, metadata: &Metadata, threads: usize, out: &mut dyn WriteSeek) -> io::Result<()> {
        let failed = |e: Error| match e {
            Error::Io(error) => error,
            other => refused(ImageError::encode(FORMAT, other)),
        };
        let mut header = self.header();
        add_metadata(&mut header, metadata).map_err(refused)?;
        let has_long_names = self.columns.iter().any(|c| c.name.len() > SHORT_NAME);
        let is_whole = Cell::new(false);
        let mut out = SortedHeader::new(out, has_long_names, &is_whole);
        exr::block::write(&mut out, [header].into_iter().collect(), true, |meta, writer| {
            is_whole.set(true);
            let Some(header) = meta.headers.first() else { return Ok(()) };
            let mut blocks = meta.enumerate_ordered_header_block_indices().map(|(_, block)| block).peekable();
            let mut index = 0;
            while let Some(next) = blocks.peek() {
                let batch = (BATCH / next.pixel_size.area().max(1)).max(1);
                let some: Vec<BlockIndex> = blocks.by_ref().take(batch).collect();
                for chunk in self.compress(threads, header, &some)? {
                    writer.write_chunk(index, chunk)?;
                    index += 1;
                }
            }
            Ok(())
        })
        .map_err(failed)?;
        out.finish()
    }

    fn header(&self) -> Header {
        let channels = self.columns.iter().map(Column::description).collect();
        let name = Text::new_or_none("").unwrap_or_default();
        let compression = match self.compression {
            ExrCompression::None => Compression::Uncompressed,
            ExrCompression::Zip => Compression::ZIP16,
            ExrCompression::Piz => Compression::PIZ,
        };
        let mut header = Header::new(name, (self.width, self.height), channels).with_encoding(
            compression,
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        );
        // A single part needs no name.
        header.own_attributes.layer_name = None;
        header
    }

    /// Compresses blocks; each thread takes a contiguous range. The result is in row order.
    fn compress(&self, threads: usize, header: &Header, blocks: &[BlockIndex]) -> Result<Vec<Chunk>, Error> {
        let workers = workers(threads, blocks.len());
        if workers == 1 {
            return blocks.iter().map(|block| self.chunk(block, header)).collect();
        }
        let some = |part: &[BlockIndex]| {
            part.iter().map(|block| self.chunk(block, header)).collect::<Result<Vec<_>, Error>>()
        };
        turner_host::thread::scope(|scope| {
            let parts: Vec<_> = blocks
                .chunks(blocks.len().div_ceil(workers))
                .map(|part| scope.spawn(move || some(part)))
                .collect();
            let mut chunks = Vec::with_capacity(blocks.len());
            for part in parts {
                let done = part.join().map_err(|_| Error::Invalid("a compression thread failed".into()))?;
                chunks.extend(done?);
            }
            Ok(chunks)
        })
    }

    /// One block: row by row, in each row channel by channel.
    fn chunk(&self, block: &BlockIndex, header: &Header) -> Result<Chunk, Error> {
        let (width, rows) = (block.pixel_size.0, block.pixel_size.1);
        let pixel: usize = self.columns.iter().map(Column::bytes).sum();
        let mut data = Vec::with_capacity(rows * width * pixel);
        let first = block.pixel_position.1;
        let strip = match self.rows {
            Some(of) => of(first as u32..(first + rows) as u32)?,
            None => Cow::Borrowed(&[][..]),
        };
        for y in first..first + rows {
            let row = strip.get((y - first) * width..(y + 1 - first) * width).unwrap_or_default();
            self.columns.iter().for_each(|column| column.append(row, y * width, width, &mut data));
        }
        let compressed_pixels_le = match self.compression {
            ExrCompression::None => data,
            ExrCompression::Zip => compress_zip(data),
            ExrCompression::Piz => {
                // The crate expects the machine's byte order: little-endian on all of Turner's targets.
                let area = IntegerBounds::new((0, first as i32), (width, rows));
                Compression::PIZ.compress_image_section_to_le(header, data, area)?
            }
        };
        let block = CompressedScanLineBlock { y_coordinate: first as i32, compressed_pixels_le };
        Ok(Chunk { layer_index: 0, compressed_block: CompressedBlock::ScanLine(block) })
    }
}

/// Length in bytes up to which the name of a channel is valid in files of OpenEXR 1.
const SHORT_NAME: usize = 31;

fn add_metadata(header: &mut Header, metadata: &Metadata) -> Result<(), ImageError> {
    crate::image::metadata::check(metadata, FORMAT)?;
    for (name, value) in metadata {
        if standard_names::ALL.contains(&name.as_bytes()) {
            let problem =
                format!("metadata \"{name}\" is a standard attribute; choose a name such as turner:{name}");
            return Err(ImageError::encode(FORMAT, problem));
        }
        let value = match value {
            MetaValue::Integer(i) => AttributeValue::I32(*i),
            // EXR text is UTF-8; the crate's own conversion produces Latin-1.
            MetaValue::Text(t) => AttributeValue::Text(Text::from_slice_unchecked(t.as_bytes())),
        };
        header.own_attributes.other.insert(Text::from_slice_unchecked(name.as_bytes()), value);
    }
    Ok(())
}

/// Deflate level, of 10. For a noisy 1920 x 1080 image on one thread, level 1 gives 16.9 MB in 0.38 s and the exr
/// crate's level 4 gives 15.8 MB in 1.1 s. fdeflate takes 0.17 s but does not compress it at all.
const LEVEL: u8 = 1;

/// EXR's ZIP method: even bytes followed by odd bytes, as differences to the previous byte, deflated; uncompressed if
/// that is not shorter.
fn compress_zip(data: Vec<u8>) -> Vec<u8> {
    let mut packed = vec![0; data.len()];
    let (even, odd) = packed.split_at_mut(data.len().div_ceil(2));
    let mut pairs = data.chunks_exact(2);
    for ((pair, even), odd) in pairs.by_ref().zip(even.iter_mut()).zip(odd) {
        (*even, *odd) = (pair[0], pair[1]);
    }
    if let ([last], Some(even)) = (pairs.remainder(), even.last_mut()) {
        *even = *last;
    }
    let mut before = packed.first().copied().unwrap_or_default();
    for byte in packed.iter_mut().skip(1) {
        let own = std::mem::replace(&mut before, *byte);
        *byte = byte.wrapping_sub(own).wrapping_add(128);
    }
    let deflated = compress_to_vec_zlib(&packed, LEVEL);
    if deflated.len() < data.len() { deflated } else { data }
}
