//! Films as bytes, for files and for other machines.
//!
//! All integers are little endian. A set is the number of its ranges (u32), then the begin and end of each (u64).
//!
//! ```text
//! header       TURNFILM, version (u32)
//! picture      width, height, region and crop (x, y, width, height each), samples per pixel, seed (u32 each);
//!              hash of the sampling settings, light paths per sample index (u64 each);
//!              whether a scene fingerprint follows (u8), fingerprint (u64)
//! channels     number of additional channels (u32); for each: length (u16) and name in UTF-8
//! row of tiles number of non-finite samples (u64), whether the first one follows (u8), its row, column and index
//!              (u32 each); then the tiles of the row
//! tile         set of its samples; u8: 0 without pixels, 1 for single samples (4 x u32 per pixel), 2 for sums
//!              (13 x u32 per pixel); the pixels row by row; for sums, 3 x u32 per pixel and additional channel
//! light        only with light paths: number of non-finite splats (u64), set of light paths; u8: 0 without light,
//!              1 if 9 x u32 per pixel of the region follow
//! end          hash of all bytes before it (u64)
//! ```

use std::ops::Range;

use super::band::{Band, Pixels};
use super::checksum::checksum;
use super::{
    Channel, Film, Fixed96, Identity, MAX_CHANNELS, MAX_PIXELS, NonFinite, PixelRect, PixelSum, SampleSet,
};
use crate::schema::{ErrorCode, Limits, SceneError};

const MAGIC: &[u8; 8] = b"TURNFILM";

/// The version that is written and read.
const VERSION: u32 = 1;

/// Size of the hash in bytes.
const HASH: usize = 8;

impl Film {
    /// The film without its preview, as bytes that [`Film::from_bytes`] reads on any machine. Films with the same
    /// samples have the same bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer { bytes: Vec::new() };
        out.bytes.extend(MAGIC);
        out.u32(VERSION);
        out.identity(&self.identity);
        out.u32(self.channels().len() as u32);
        for channel in self.channels() {
            out.bytes.extend((channel.name.len() as u16).to_le_bytes());
            out.bytes.extend(channel.name.as_bytes());
        }
        self.bands.iter().for_each(|band| out.band(band));
        if let Some(splats) = &self.splats {
            out.u64(splats.non_finite);
            out.set(&splats.held);
            let light = splats.sums.iter().any(|sums| *sums != [Fixed96::default(); 3]);
            out.bytes.push(u8::from(light));
            if light {
                splats.sums.iter().flatten().for_each(|sum| out.words(&sum.to_words()));
            }
        }
        out.u64(checksum(&out.bytes));
        out.bytes
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
            return Err(SceneError::new(ErrorCode::Film, message));
        }
        if check != checksum(content).to_le_bytes() {
            return Err(damaged("its checksum is wrong"));
        }
        input.film(limits)
    }
}

fn damaged(what: &str) -> SceneError {
    SceneError::new(ErrorCode::Film, format!("the film cannot be read: {what}"))
        .help("copy the file again, or render it again")
}

struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    fn u32(&mut self, v: u32) {
        self.bytes.extend(v.to_le_bytes());
    }

    fn u64(&mut self, v: u64) {
        self.bytes.extend(v.to_le_bytes());
    }

    fn words(&mut self, words: &[u32]) {
        words.iter().for_each(|w| self.u32(*w));
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
        self.bytes.push(u8::from(i.scene.is_some()));
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
        for (column, held) in band.held.iter().enumerate() {
            self.set(held);
            let indices = band.indices(&band.tile(column));
            let extra = |i: usize| band.extra(i).iter().any(|sum| *sum != [0; 3]);
            match &band.pixels {
                Pixels::Samples(pixels) if indices.clone().any(|i| pixels[i] != [0; 4]) => {
                    self.bytes.push(1);
                    indices.for_each(|i| self.words(&pixels[i]));
                }
                Pixels::Sums(pixels)
                    if indices.clone().any(|i| pixels[i] != [0; PixelSum::WORDS] || extra(i)) =>
                {
                    self.bytes.push(2);
                    indices.clone().for_each(|i| self.words(&pixels[i]));
                    indices.for_each(|i| band.extra(i).iter().for_each(|sum| self.words(sum)));
                }
                _ => self.bytes.push(0),
            }
        }
    }
}

struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], SceneError> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or_else(|| damaged("it ends too early"))?;
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], SceneError> {
        let mut out = [0; N];
        out.copy_from_slice(self.take(N)?);
        Ok(out)
    }

    fn u32(&mut self) -> Result<u32, SceneError> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, SceneError> {
        self.array().map(u64::from_le_bytes)
    }

    fn words<const N: usize>(&mut self) -> Result<[u32; N], SceneError> {
        let mut out = [0; N];
        for word in &mut out {
            *word = self.u32()?;
        }
        Ok(out)
    }

    /// A byte that is 0 or 1.
    fn flag(&mut self) -> Result<bool, SceneError> {
        match self.array()? {
            [0] => Ok(false),
            [1] => Ok(true),
            [other] => Err(damaged(&format!("a byte is {other}; expected 0 or 1"))),
        }
    }

    /// An error unless `count` items of `bytes` bytes each can follow.
    fn expect(&self, count: u64, bytes: u64) -> Result<(), SceneError> {
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
        let (sampling, light_paths) = (self.u64()?, self.u64()?);
        let scene = if self.flag()? { Some(self.u64()?) } else { None };
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
        Ok(Identity { size, region, crop, samples, seed, sampling, light_paths, scene })
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
        let (region, light) = (identity.region, identity.light_paths);
        // Each tile takes at least a set and a byte.
        let tiles = super::TileGrid::new(region).count() as u64;
        self.expect(tiles, 5)?;
        let splats = if light > 0 { super::Splats::BYTES } else { 0 };
        let bytes_per_pixel = Film::pixel_bytes(&identity, &channels) + splats;
        limits.memory.need(region.area() * bytes_per_pixel as u64, || {
            format!("the film of {}x{} pixels", region.width, region.height)
        })?;
        let samples = identity.samples;
        let mut film = Film::empty(identity, channels)?;
        film.take_light(light)?;
        for band in &mut film.bands {
            self.band(band, samples)?;
        }
        if let Some(splats) = &mut film.splats {
            splats.non_finite = self.u64()?;
            splats.held = self.set(light * u64::from(samples))?;
            if self.flag()? {
                self.expect(region.area(), super::Splats::BYTES as u64)?;
                for sum in splats.sums.iter_mut().flatten() {
                    *sum = Fixed96::from_words(self.words()?);
                }
            }
        }
        if !self.rest.is_empty() {
            return Err(damaged("it has more bytes than it should"));
        }
        film.count_non_finite();
        Ok(film)
    }

    fn band(&mut self, band: &mut Band, samples: u32) -> Result<(), SceneError> {
        let count = self.u64()?;
        let first = match self.flag()? {
            true => self.words().map(|[y, x, index]| Some((y, x, index)))?,
            false => None,
        };
        band.non_finite = NonFinite { count, first };
        for column in 0..band.held.len() {
            band.held[column] = self.set(u64::from(samples))?;
            let rect = band.tile(column);
            let indices = band.indices(&rect);
            match self.array()? {
                [0] => {}
                [1] => {
                    let Pixels::Samples(pixels) = &mut band.pixels else {
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
