//! Films as bytes, for files and for other machines.
//!
//! All integers are little endian. A set is the number of its ranges (u32), then the begin and end of each (u64).
//!
//! ```text
//! header       TURNFILM, version (u32)
//! picture      width, height, region and crop (x, y, width, height each), samples per pixel, seed (u32 each);
//!              hash of the sampling settings, light paths per sample index (u64 each); whether samples count by weight
//!              in several pixels (u8), whether there are sums for an error estimate (u8),
//!              whether the film is adaptive (u8), whether fireflies are removed (u8), whether pixels share paths (u8);
//!              whether a scene fingerprint follows (u8), fingerprint (u64)
//! channels     number of additional channels (u32); for each: length (u16) and name in UTF-8
//!              then the channels of labels: see label_bytes.rs
//! adaptive     only if it is: mean of the goals (u32)
//! row of tiles number of non-finite samples (u64), whether the first one follows (u8), its row, column and index
//!              (u32 each); then the tiles of the row
//! tile         set of its samples; in an adaptive film, the set of its odd half, two goals (u32), rays (u64); u8: 0 without pixels, 1 for single samples (4 x u32 per pixel), 2 for sums
//!              (13 x u32 per pixel); the pixels row by row; for sums, 3 x u32 per pixel and additional channel, and five times for
//!              the error estimate
//! light        only with light paths: number of non-finite splats (u64), set of light paths; u8: 0 without light,
//!              1 if 12 x u32 per pixel of the region follow
//! labels       only with channels of labels: those of each tile; then, if fireflies are removed: see brightest.rs
//! end          hash of all bytes before it (u64)
//! ```

use std::io;
use std::ops::Range;

use super::band::{Band, Pixels};
use super::checksum::{Checksum, checksum};
use super::{
    Channel, Film, Fixed96, Identity, MAX_CHANNELS, MAX_PIXELS, NonFinite, PixelRect, PixelSum, SampleSet,
};
use crate::schema::{ErrorCode, Limits, SceneError};

const MAGIC: &[u8; 8] = b"TURNFILM";

/// The version that is written and read.
const VERSION: u32 = 7;

/// Size of the hash in bytes.
const HASH: usize = 8;

/// Size of a [`Fixed96`] in bytes.
const FIXED: usize = 12;

/// About the bytes of a piece of a film.
const PIECE: usize = 1 << 16;

impl Film {
    /// The film without its preview, as bytes that [`Film::from_bytes`] reads on any machine. Films with the same
    /// samples have the same bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.bytes_length() as usize);
        // A vector takes all bytes.
        let _ = self.write_to(&mut |part| {
            bytes.extend_from_slice(part);
            Ok(())
        });
        bytes
    }

    /// The number of bytes of [`Film::to_bytes`].
    pub fn bytes_length(&self) -> u64 {
        let mut out = Writer { bytes: Vec::new(), skipped: Some(0) };
        self.put_start(&mut out);
        // A counter takes all bytes.
        let _ = self.put_tiles(&mut out, |_| Ok(()));
        let _ = self.put_end(&mut out, |_| Ok(()));
        out.bytes.len() as u64 + out.skipped.unwrap_or(0) + HASH as u64
    }

    /// Gives the bytes of [`Film::to_bytes`] to `sink` in pieces that a processor's cache holds, so that no copy of the
    /// film is needed.
    ///
    /// Errors: those of `sink`, after which it gets no more.
    pub fn write_to(&self, sink: &mut dyn FnMut(&[u8]) -> io::Result<()>) -> io::Result<()> {
        let mut sum = Checksum::new(self.bytes_length() - HASH as u64);
        let mut out = Writer { bytes: Vec::new(), skipped: None };
        let mut flush = |out: &mut Writer| {
            sum.add(&out.bytes);
            let sent = sink(&out.bytes);
            out.bytes.clear();
            sent
        };
        let mut some = |out: &mut Writer| if out.bytes.len() < PIECE { Ok(()) } else { flush(out) };
        self.put_start(&mut out);
        self.put_tiles(&mut out, &mut some)?;
        self.put_end(&mut out, &mut some)?;
        flush(&mut out)?;
        sink(&sum.finish().to_le_bytes())
    }

    fn put_tiles(
        &self,
        out: &mut Writer,
        mut flush: impl FnMut(&mut Writer) -> io::Result<()>,
    ) -> io::Result<()> {
        for band in &self.bands {
            out.band(band);
            for column in 0..band.held.len() {
                out.tile(band, column);
                flush(out)?;
            }
        }
        Ok(())
    }

    fn put_start(&self, out: &mut Writer) {
        out.bytes.extend(MAGIC);
        out.u32(VERSION);
        out.identity(&self.identity);
        out.u32(self.channels().len() as u32);
        for channel in self.channels() {
            out.bytes.extend((channel.name.len() as u16).to_le_bytes());
            out.bytes.extend(channel.name.as_bytes());
        }
        out.label_channels(self.labels());
        if self.identity.adaptive {
            out.u32(self.step);
        }
    }

    fn put_end(
        &self,
        out: &mut Writer,
        mut flush: impl FnMut(&mut Writer) -> io::Result<()>,
    ) -> io::Result<()> {
        if let Some(splats) = &self.splats {
            out.u64(splats.non_finite);
            out.set(&splats.held);
            let light = splats.sums.iter().any(|sums| *sums != [Fixed96::default(); 4]);
            out.bytes.push(u8::from(light));
            if light && !out.skips(splats.sums.len() * 4 * 3) {
                for pixels in splats.sums.chunks(PIECE / (4 * FIXED)) {
                    pixels.iter().flatten().for_each(|sum| out.words(&sum.to_words()));
                    flush(out)?;
                }
            }
        }
        for held in self.bands.iter().flat_map(|band| &band.labels) {
            out.labels_of_tile(held);
            flush(out)?;
        }
        self.put_brightest(out, flush)
    }

    /// Reads the bytes of [`Film::to_bytes`]. Memory is requested from `limits` before it is allocated.
    ///
    /// Errors: bytes that are not a film, of another version, truncated, damaged or inconsistent
    /// ([`ErrorCode::Film`]); more pixels or memory than allowed ([`ErrorCode::TooLarge`]).
    pub fn from_bytes(bytes: &[u8], limits: &Limits) -> Result<Film, SceneError> {
        if !bytes.starts_with(MAGIC) {
            return Err(damaged("it is not a Turner film"));
        }
        let Some((content, check)) = bytes.len().checked_sub(HASH).map(|at| bytes.split_at(at)) else {
            return Err(damaged("it ends too early"));
        };
        let mut input = Reader { rest: &content[MAGIC.len().min(content.len())..] };
        let version = input.u32()?;
        if version != VERSION {
            let message = format!("the film's bytes have version {version}; expected {VERSION}");
            return Err(SceneError::new(ErrorCode::Film, message).help(super::merge::OWN_VERSION));
        }
        if check != checksum(content).to_le_bytes() {
            return Err(damaged("its checksum is wrong"));
        }
        input.film(limits)
    }
}

pub(super) fn damaged(what: &str) -> SceneError {
    SceneError::new(ErrorCode::Film, format!("the film cannot be read: {what}"))
        .help("copy the file again, or render it again")
}

pub(super) struct Writer {
    pub(super) bytes: Vec<u8>,
    /// Bytes of pixels that were counted instead of written.
    skipped: Option<u64>,
}

impl Writer {
    pub(super) fn u32(&mut self, v: u32) {
        self.bytes.extend(v.to_le_bytes());
    }

    pub(super) fn u64(&mut self, v: u64) {
        self.bytes.extend(v.to_le_bytes());
    }

    pub(super) fn words(&mut self, words: &[u32]) {
        self.bytes.extend(words.iter().flat_map(|w| w.to_le_bytes()));
    }

    /// Whether `words` words are only counted.
    pub(super) fn skips(&mut self, words: usize) -> bool {
        match &mut self.skipped {
            Some(skipped) => {
                *skipped += 4 * words as u64;
                true
            }
            None => {
                self.bytes.reserve(4 * words);
                false
            }
        }
    }

    fn set(&mut self, set: &SampleSet) {
        self.u32(set.ranges().len() as u32);
        for range in set.ranges() {
            self.u64(range.start);
            self.u64(range.end);
        }
    }

    fn identity(&mut self, i: &Identity) {
        self.words(&i.size);
        for rect in [i.region, i.crop] {
            self.words(&[rect.x, rect.y, rect.width, rect.height]);
        }
        self.words(&[i.samples, i.seed]);
        self.u64(i.sampling);
        self.u64(i.light_paths);
        let flags = [i.weighted, i.estimates_error, i.adaptive, i.removes_fireflies, i.scene.is_some()];
        self.bytes.extend(flags.map(u8::from));
        self.u32(i.cluster);
        if let Some(scene) = i.scene {
            self.u64(scene);
        }
    }

    fn band(&mut self, band: &Band) {
        self.u64(band.non_finite.count);
        self.bytes.push(u8::from(band.non_finite.first.is_some()));
        if let Some((y, x, index)) = band.non_finite.first {
            self.words(&[y, x, index]);
        }
    }

    fn tile(&mut self, band: &Band, column: usize) {
        self.set(&band.held[column]);
        if let Some(adaptive) = band.adaptive.get(column) {
            self.set(&adaptive.odd);
            self.words(&adaptive.goals);
            self.u64(adaptive.rays);
        }
        let indices = band.indices(&band.tile(column));
        let extra = |i: usize| band.extra(i).iter().any(|sum| *sum != [0; 3]);
        match band.pixels() {
            Pixels::Samples(pixels) if indices.clone().any(|i| pixels[i] != [0; 4]) => {
                self.bytes.push(1);
                if !self.skips(indices.clone().count() * 4) {
                    indices.for_each(|i| self.words(&pixels[i]));
                }
            }
            Pixels::Sums(pixels)
                if indices.clone().any(|i| pixels[i] != [0; PixelSum::WORDS] || extra(i)) =>
            {
                self.bytes.push(2);
                let sums = indices.clone().next().map_or(0, |i| band.extra(i).len());
                if !self.skips(indices.clone().count() * (PixelSum::WORDS + 3 * sums)) {
                    indices.clone().for_each(|i| self.words(&pixels[i]));
                    indices.for_each(|i| self.words(band.extra(i).as_flattened()));
                }
            }
            _ => self.bytes.push(0),
        }
    }
}

pub(super) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], SceneError> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or_else(|| damaged("it ends too early"))?;
        self.rest = rest;
        Ok(taken)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N], SceneError> {
        let mut out = [0; N];
        out.copy_from_slice(self.take(N)?);
        Ok(out)
    }

    pub(super) fn u32(&mut self) -> Result<u32, SceneError> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64, SceneError> {
        self.array().map(u64::from_le_bytes)
    }

    pub(super) fn words<const N: usize>(&mut self) -> Result<[u32; N], SceneError> {
        let mut out = [0; N];
        for word in &mut out {
            *word = self.u32()?;
        }
        Ok(out)
    }

    /// A byte that is 0 or 1.
    pub(super) fn flag(&mut self) -> Result<bool, SceneError> {
        match self.array()? {
            [0] => Ok(false),
            [1] => Ok(true),
            [other] => Err(damaged(&format!("a byte is {other}; expected 0 or 1"))),
        }
    }

    /// An error unless `count` items of `bytes` bytes each can follow.
    pub(super) fn expect(&self, count: u64, bytes: u64) -> Result<(), SceneError> {
        let fits = count.checked_mul(bytes).is_some_and(|need| need <= self.rest.len() as u64);
        if fits { Ok(()) } else { Err(damaged("it ends too early")) }
    }

    /// A set of integers below `end`.
    fn set(&mut self, end: u64) -> Result<SampleSet, SceneError> {
        let count = self.u32()?;
        self.expect(u64::from(count), 16)?;
        let ranges: Vec<Range<u64>> =
            (0..count).map(|_| Ok(self.u64()?..self.u64()?)).collect::<Result<_, SceneError>>()?;
        let set = SampleSet::from_ranges(ranges).ok_or_else(|| damaged("samples are out of order"))?;
        if set.ranges().last().is_some_and(|last| last.end > end) {
            return Err(damaged("there are more samples than the picture has"));
        }
        Ok(set)
    }

    fn rect(&mut self) -> Result<PixelRect, SceneError> {
        let [x, y, width, height] = self.words()?;
        Ok(PixelRect { x, y, width, height })
    }

    fn identity(&mut self) -> Result<Identity, SceneError> {
        let (size, region, crop) = (self.words()?, self.rect()?, self.rect()?);
        let [samples, seed] = self.words()?;
        let (sampling, light_paths, weighted) = (self.u64()?, self.u64()?, self.flag()?);
        let (estimates_error, adaptive) = (self.flag()?, self.flag()?);
        let (removes_fireflies, has_scene, cluster) = (self.flag()?, self.flag()?, self.u32()?);
        if adaptive && !estimates_error || ![1, 4, 8, 16].contains(&cluster) {
            return Err(damaged("its settings contradict one another"));
        }
        let scene = if has_scene { Some(self.u64()?) } else { None };
        let within = |r: &PixelRect, [x, y, width, height]: [u32; 4]| {
            let fits = |from: u32, size: u32, begin: u32, all: u32| {
                size > 0
                    && from >= begin
                    && u64::from(from) + u64::from(size) <= u64::from(begin) + u64::from(all)
            };
            fits(r.x, r.width, x, width) && fits(r.y, r.height, y, height)
        };
        let inside = within(&region, [0, 0, size[0], size[1]])
            && within(&crop, [region.x, region.y, region.width, region.height]);
        if !inside || samples == 0 {
            return Err(damaged("region, crop and size are inconsistent"));
        }
        if light_paths.checked_mul(u64::from(samples)).is_none() {
            return Err(damaged("there are too many light paths"));
        }
        if region.area() > MAX_PIXELS {
            let message = format!(
                "a picture of {}x{} has more than the {MAX_PIXELS} pixels a film may have",
                region.width, region.height
            );
            return Err(SceneError::new(ErrorCode::TooLarge, message));
        }
        Ok(Identity {
            size,
            region,
            crop,
            samples,
            seed,
            sampling,
            weighted,
            estimates_error,
            adaptive,
            removes_fireflies,
            light_paths,
            cluster,
            scene,
        })
    }

    fn channels(&mut self) -> Result<Vec<Channel>, SceneError> {
        let count = self.u32()?;
        self.expect(u64::from(count), 2)?;
        if count as usize > MAX_CHANNELS {
            return Err(damaged("there are too many channels"));
        }
        let mut channels = Vec::new();
        for _ in 0..count {
            let length = u16::from_le_bytes(self.array()?);
            let name = std::str::from_utf8(self.take(usize::from(length))?);
            channels.push(Channel::new(name.map_err(|_| damaged("a channel's name is not UTF-8"))?));
        }
        Channel::check(&channels).map_err(|e| damaged(&e.message))?;
        Ok(channels)
    }

    fn film(&mut self, limits: &Limits) -> Result<Film, SceneError> {
        let identity = self.identity()?;
        let channels = self.channels()?;
        let labels = self.label_channels()?;
        let step = if identity.adaptive { self.u32()? } else { 0 };
        if step > identity.samples || identity.adaptive && step == 0 {
            return Err(damaged("it has allotted more samples than the picture has"));
        }
        let (region, light) = (identity.region, identity.light_paths);
        // Each tile takes at least a set and a byte.
        let tiles = super::TileGrid::new(region).count() as u64;
        self.expect(tiles, 5)?;
        let splats = if light > 0 { super::Splats::BYTES } else { 0 };
        let bytes_per_pixel = Film::pixel_bytes(&identity, &channels) + splats + Film::label_bytes(&labels);
        limits.memory.need(region.area() * bytes_per_pixel as u64, || {
            format!("the film of {}x{} pixels", region.width, region.height)
        })?;
        let (end, adaptive) = (identity.index_end(), identity.adaptive);
        let mut film = Film::empty(identity, channels)?;
        film.take_light(light)?;
        film.take_labels(&labels)?;
        if adaptive {
            film.sample_adaptively();
            film.step = step;
        }
        for band in &mut film.bands {
            self.band(band, end)?;
        }
        if let Some(splats) = &mut film.splats {
            splats.non_finite = self.u64()?;
            splats.held = self.set(light.saturating_mul(u64::from(end)))?;
            if self.flag()? {
                self.expect(region.area(), super::Splats::BYTES as u64)?;
                for sum in splats.sums.iter_mut().flatten() {
                    *sum = Fixed96::from_words(self.words()?);
                }
            }
        }
        self.labels(&mut film)?;
        self.brightest(&mut film)?;
        if !self.rest.is_empty() {
            return Err(damaged("it has more bytes than it should"));
        }
        film.count_non_finite();
        Ok(film)
    }

    /// Sample indices are below `end`.
    fn band(&mut self, band: &mut Band, end: u32) -> Result<(), SceneError> {
        let count = self.u64()?;
        let first = match self.flag()? {
            true => self.words().map(|[y, x, index]| Some((y, x, index)))?,
            false => None,
        };
        band.non_finite = NonFinite { count, first };
        for column in 0..band.held.len() {
            band.held[column] = self.set(u64::from(end))?;
            if let Some(adaptive) = band.adaptive.get_mut(column) {
                adaptive.odd = self.set(u64::from(end))?;
                adaptive.goals = self.words()?;
                adaptive.rays = self.u64()?;
                if adaptive.goals.iter().any(|goal| *goal > end) {
                    return Err(damaged("it has allotted more samples than it may have"));
                }
            }
            let rect = band.tile(column);
            let indices = band.indices(&rect);
            match self.array()? {
                [0] => {}
                [1] => {
                    let Pixels::Samples(pixels) = band.pixels_mut() else {
                        return Err(damaged("it has single samples instead of sums"));
                    };
                    self.expect(rect.area(), 16)?;
                    for i in indices {
                        pixels[i] = self.words()?;
                    }
                }
                [2] => {
                    self.expect(rect.area(), PixelSum::BYTES as u64)?;
                    let pixels = band.sums_mut();
                    for i in indices.clone() {
                        pixels[i] = self.words()?;
                    }
                    for i in indices {
                        for sum in band.extra_mut(i) {
                            *sum = self.words()?;
                        }
                    }
                }
                [other] => return Err(damaged(&format!("a tile has type {other}; expected 0, 1 or 2"))),
            }
        }
        Ok(())
    }
}
