//! The brightest samples of each pixel: what [`super::fireflies`] needs to tell a spike from light.
//!
//! A pixel keeps its [`KEPT`] brightest samples. The brightest of a union are the brightest of the brightest of its parts,
//! and ties are decided by the bits of a sample. So the list depends on no order, and lists can be split and merged like
//! sums.
//!
//! As bytes, behind the labels ([`super::bytes`]): for each row of tiles a byte, 0 without any, or 1 and for each pixel
//! of the rows [`KEPT`] samples, each of them the bits of red, green and blue times weight, and its number (u32 each).

use std::io;

use super::bytes::{Reader, Writer, damaged};
use super::{Film, TileSums};
use crate::color::Spectrum;
use crate::film::band::{Band, Pixels};
use crate::math::DVec2;
use crate::schema::SceneError;

/// Samples that a pixel keeps.
pub(super) const KEPT: usize = 4;

/// A sample of a pixel: the bits of its colour times coverage times weight, and a number that it has in all pixels that
/// it reaches. Zeros are no sample.
type Words = [u32; 4];

/// The brightest samples of a pixel, brightest first. 64 bytes on the film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Brightest([Words; KEPT]);

/// A bright sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bright {
    /// Colour times coverage times weight.
    pub(super) color: Spectrum,
    /// The luminance of that; greater than 0.
    pub(super) luminance: f32,
    /// The same number in all pixels that the sample reaches.
    pub(super) number: u32,
}

impl Bright {
    fn of([r, g, b, number]: Words) -> Bright {
        let color = Spectrum::from([r, g, b].map(f32::from_bits));
        Bright { color, luminance: color.luminance(), number }
    }
}

impl Brightest {
    /// Bytes per pixel.
    pub(super) const BYTES: usize = size_of::<Brightest>();

    /// Adds a finite sample.
    #[inline]
    fn add(&mut self, color: Spectrum, number: u32) {
        // The luminance of the darkest one that is kept; nearly all samples are darker.
        let luminance = color.luminance();
        if luminance > 0.0 && luminance >= Bright::of(self.0[KEPT - 1]).luminance {
            let [r, g, b] = color.to_array().map(f32::to_bits);
            self.insert([r, g, b, number]);
        }
    }

    fn insert(&mut self, new: Words) {
        let key = |words: Words| (Bright::of(words).luminance.to_bits(), words);
        let at = self.0.partition_point(|kept| key(*kept) >= key(new));
        if at < KEPT {
            self.0.copy_within(at..KEPT - 1, at + 1);
            self.0[at] = new;
        }
    }

    fn merge(&mut self, other: &Brightest) {
        for words in other.0 {
            if words == Words::default() {
                return;
            }
            self.insert(words);
        }
    }

    /// The samples, brightest first.
    pub(super) fn iter(&self) -> impl Iterator<Item = Bright> + '_ {
        self.0.iter().map(|words| Bright::of(*words)).take_while(|bright| bright.luminance > 0.0)
    }
}

/// A number of a sample, which other samples near it do not have.
fn number(place: DVec2, index: u32) -> u32 {
    let [x, y] = [place.x, place.y].map(|v| v.to_bits().wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32);
    (x as u32).rotate_left(9) ^ (y as u32) ^ index.wrapping_mul(0x85eb_ca6b)
}

impl TileSums {
    /// Whether the film keeps the brightest samples; after [`TileSums::reset`].
    pub(crate) fn keep_brightest(&mut self, keeps: bool) {
        self.brightest.clear();
        if keeps {
            self.brightest.resize(self.pixels.len(), Brightest::default());
        }
    }

    /// Notes a finite sample of a pixel.
    #[inline]
    pub(super) fn note_bright(
        &mut self,
        pixel: usize,
        color: Spectrum,
        weight: f32,
        at: Option<DVec2>,
        index: u32,
    ) {
        if let Some(brightest) = self.brightest.get_mut(pixel) {
            brightest.add(color * weight, at.map_or(index, |place| number(place, index)));
        }
    }
}

impl Band {
    /// Adds room for the brightest samples of its pixels.
    pub(super) fn keep_brightest(&mut self) {
        self.brightest = vec![Brightest::default(); self.pixel_count()];
    }

    /// Adds the brightest samples of a row of a tile's sums, `first` being its first pixel and `start` that of the band.
    pub(super) fn merge_brightest(&mut self, start: usize, sums: &TileSums, first: usize, width: usize) {
        let (Some(own), Some(theirs)) =
            (self.brightest.get_mut(start..start + width), sums.brightest.get(first..first + width))
        else {
            return;
        };
        own.iter_mut().zip(theirs).for_each(|(own, theirs)| own.merge(theirs));
    }

    /// Adds those of a pixel of another band.
    pub(super) fn merge_brightest_pixel(&mut self, to: usize, other: &Band, from: usize) {
        if let (Some(own), Some(theirs)) = (self.brightest.get_mut(to), other.brightest.get(from)) {
            own.merge(theirs);
        }
    }
}

impl Film {
    /// Keeps the brightest samples of a film that holds at most sample 0 of each pixel, in sums or unchanged.
    pub(crate) fn begin_brightest(&mut self) {
        if self.identity.removes_fireflies {
            return;
        }
        self.identity.removes_fireflies = true;
        self.bytes_per_pixel += Brightest::BYTES;
        for band in &mut self.bands {
            band.keep_brightest();
            for i in 0..band.brightest.len() {
                let value = match band.pixels() {
                    Pixels::Sums(_) => band.sum(i).mean(),
                    Pixels::Samples(_) => band.single(i),
                };
                if let Some([r, g, b, _]) = value.filter(|v| v.iter().all(|v| v.is_finite())) {
                    band.brightest[i].add(Spectrum::new(r, g, b), 0);
                }
            }
        }
    }
}

impl Film {
    /// The brightest samples, if fireflies are removed.
    pub(super) fn put_brightest(
        &self,
        out: &mut Writer,
        mut flush: impl FnMut(&mut Writer) -> io::Result<()>,
    ) -> io::Result<()> {
        for band in self.bands.iter().filter(|_| self.identity.removes_fireflies) {
            out.brightest(band);
            flush(out)?;
        }
        Ok(())
    }
}

impl Writer {
    /// The brightest samples of a row of tiles.
    fn brightest(&mut self, band: &Band) {
        let any = band.brightest.iter().any(|brightest| *brightest != Brightest::default());
        self.bytes.push(u8::from(any));
        if any && !self.skips(band.brightest.len() * 4 * KEPT) {
            band.brightest.iter().for_each(|brightest| self.words(brightest.0.as_flattened()));
        }
    }
}

impl Reader<'_> {
    pub(super) fn brightest(&mut self, film: &mut Film) -> Result<(), SceneError> {
        if !film.identity.removes_fireflies {
            return Ok(());
        }
        for band in &mut film.bands {
            if !self.flag()? {
                continue;
            }
            self.expect(band.brightest.len() as u64, Brightest::BYTES as u64)?;
            for brightest in &mut band.brightest {
                let mut last = f32::INFINITY;
                for words in &mut brightest.0 {
                    *words = self.words()?;
                    let luminance = Bright::of(*words).luminance;
                    if !(0.0..=last).contains(&luminance) || luminance == 0.0 && *words != Words::default() {
                        return Err(damaged("bright samples are out of order"));
                    }
                    last = luminance;
                }
            }
        }
        Ok(())
    }
}
