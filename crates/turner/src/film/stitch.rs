//! Stitching films of parts of a picture (crops) into one.
//!
//! A film counts in the pixels of its `crop` only. Its `region` may be larger by a border, whose sums may lack what
//! the pixels beyond it contribute.

use super::band::Pixels;
use super::merge::{SAME_CHANNELS, SAME_PICTURE, conflict};
use super::{Film, Identity, MAX_PIXELS, PixelRect};
use crate::schema::{ErrorCode, SceneError};

impl Film {
    /// One film of the parts of a picture: their crops are disjoint and cover a rectangle, and all hold the same
    /// samples and light paths. The rectangle is the whole picture, or any if the parts have no borders. The result
    /// equals the film of a render of the rectangle bit for bit; only the rows to which non-finite samples are
    /// attributed may differ.
    ///
    /// Errors: the films belong to different pictures, overlap, leave gaps, or hold different samples
    /// ([`ErrorCode::Conflict`]); not enough memory ([`ErrorCode::TooLarge`]).
    pub fn stitch(films: &[Film]) -> Result<Film, SceneError> {
        let Some(first) = films.first() else {
            return Err(conflict("there are no films to stitch", "name the films of all parts"));
        };
        let whole = union(films);
        for film in films {
            same_picture(first, film)?;
        }
        if first.identity.adaptive {
            let message = "films of parts of a picture with adaptive sampling cannot be stitched: each has allotted its samples alone";
            let help = "render the picture in one piece, or its parts without `film.adaptive_sampling`";
            return Err(conflict(message, help));
        }
        covers(films, &whole)?;
        let [width, height] = first.identity.size;
        let picture = PixelRect { x: 0, y: 0, width, height };
        if whole != picture && films.iter().any(|film| film.region != film.crop) {
            let message = format!(
                "the films cover {} of {width}x{height} pixels; with this anti-aliasing or filter they must cover the whole picture",
                text(&whole)
            );
            return Err(conflict(message, MISSING_PARTS));
        }
        if whole.area() > MAX_PIXELS {
            let message = format!("{} are more than the {MAX_PIXELS} that a film may have", text(&whole));
            let help = "merge fewer parts at a time, or render a smaller picture";
            return Err(SceneError::new(ErrorCode::TooLarge, message).help(help));
        }
        let identity = Identity { region: whole, crop: whole, ..first.identity.clone() };
        let mut out = Film::empty(Identity { light_paths: 0, ..identity }, first.channels().to_vec())?;
        out.take_light(first.identity.light_paths)?;
        out.take_labels(first.labels())?;
        let held = first.held(0).clone();
        for band in &mut out.bands {
            band.held.fill(held.clone());
        }
        // Single samples become sums as they do in a film that was merged.
        if films.iter().any(|f| f.bands.iter().any(|b| matches!(b.pixels(), Pixels::Sums(_)))) {
            for band in &mut out.bands {
                band.sums_mut();
            }
        }
        for film in films {
            out.copy_pixels(film);
            out.copy_labels(film);
        }
        if let (Some(own), Some(theirs)) = (&mut out.splats, &first.splats) {
            own.held = theirs.held.clone();
            own.non_finite = theirs.non_finite;
        }
        for film in films {
            for band in &film.bands {
                out.note(&band.non_finite);
            }
        }
        out.count_non_finite();
        Ok(out)
    }

    /// Copies the pixels of another film's crop.
    fn copy_pixels(&mut self, other: &Film) {
        let PixelRect { x: left, y: top, width, height } = other.crop;
        for y in top..top + height {
            for x in left..left + width {
                let Some((theirs, from)) = other.place(x, y) else { continue };
                let row = y - self.region.y;
                let Some(own) = self.bands.get_mut((row / super::TILE) as usize) else { continue };
                let to =
                    (row % super::TILE) as usize * self.region.width as usize + (x - self.region.x) as usize;
                match (own.pixels_mut(), theirs.pixels()) {
                    (Pixels::Samples(own), Pixels::Samples(theirs)) => own[to] = theirs[from],
                    (Pixels::Sums(own), _) => own[to] = theirs.sum(from).to_words(),
                    // There are no single samples next to sums.
                    (Pixels::Samples(_), Pixels::Sums(_)) => {}
                }
                own.extra_mut(to).copy_from_slice(theirs.extra(from));
                own.merge_brightest_pixel(to, theirs, from);
                if let (Some(own), Some(theirs)) = (&mut self.splats, &other.splats) {
                    let at = |region: &PixelRect| {
                        (y - region.y) as usize * region.width as usize + (x - region.x) as usize
                    };
                    own.sums[at(&self.region)] = theirs.sums[at(&other.region)];
                }
            }
        }
    }

    /// Attributes non-finite samples to the row of the first one.
    fn note(&mut self, found: &super::NonFinite) {
        let row = found.first.map_or(0, |(y, ..)| y.saturating_sub(self.region.y) / super::TILE);
        let last = self.bands.len().saturating_sub(1);
        if let Some(band) = self.bands.get_mut((row as usize).min(last)) {
            band.non_finite.merge(found);
        }
    }
}

/// The remedy for parts with a gap.
const MISSING_PARTS: &str = "add the films of the missing parts";

/// The remedy for parts that hold different samples.
const SAME_SAMPLES: &str = "render the missing samples of each part, and merge the films of each crop first";

fn text(r: &PixelRect) -> String {
    format!("{}x{} pixels at ({}, {})", r.width, r.height, r.x, r.y)
}

/// The smallest rectangle with all crops.
fn union(films: &[Film]) -> PixelRect {
    let crops = || films.iter().map(|film| film.crop);
    let x = crops().map(|c| c.x).min().unwrap_or(0);
    let y = crops().map(|c| c.y).min().unwrap_or(0);
    let right = crops().map(|c| c.x + c.width).max().unwrap_or(x);
    let bottom = crops().map(|c| c.y + c.height).max().unwrap_or(y);
    PixelRect { x, y, width: right - x, height: bottom - y }
}

/// An error unless the films belong to one picture and hold the same samples and light paths in all tiles.
fn same_picture(first: &Film, film: &Film) -> Result<(), SceneError> {
    let place = &first.identity;
    let at_first = Identity { region: place.region, crop: place.crop, ..film.identity.clone() };
    if let Some(difference) = place.difference(&at_first) {
        return Err(conflict(format!("the films are of different pictures; {difference}"), SAME_PICTURE));
    }
    if first.channels() != film.channels() || first.labels() != film.labels() {
        return Err(conflict("the films have different channels in addition to colour", SAME_CHANNELS));
    }
    let held = first.held(0);
    for tile in 0..film.tiles().count() {
        if film.held(tile) != held {
            let rect = text(&film.tiles().rect(tile));
            let words = |set: &super::SampleSet| match set.ranges() {
                [] => "none".to_owned(),
                ranges => {
                    let words = ranges.iter().map(|r| format!("{}..{}", r.start, r.end));
                    words.collect::<Vec<_>>().join(", ")
                }
            };
            let message = format!(
                "the films hold different samples: {} in {}, but {} in {rect}",
                words(held),
                text(&first.crop),
                words(film.held(tile)),
            );
            return Err(conflict(message, SAME_SAMPLES));
        }
    }
    let light = |film: &Film| film.splats.as_ref().map(|splats| splats.held.clone());
    if light(first) != light(film) {
        return Err(conflict("the films hold different light paths", SAME_SAMPLES));
    }
    Ok(())
}

/// An error unless the crops are disjoint and cover the rectangle.
fn covers(films: &[Film], whole: &PixelRect) -> Result<(), SceneError> {
    let apart = |a: u32, size: u32, b: u32, other: u32| a + size <= b || b + other <= a;
    for (i, film) in films.iter().enumerate() {
        for other in &films[..i] {
            let (a, b) = (&film.crop, &other.crop);
            if !apart(a.x, a.width, b.x, b.width) && !apart(a.y, a.height, b.y, b.height) {
                let message = format!("the films overlap: {} and {}", text(b), text(a));
                return Err(conflict(message, "give each part pixels of its own, and merge each film once"));
            }
        }
    }
    let covered: u64 = films.iter().map(|film| film.crop.area()).sum();
    if covered != whole.area() {
        let missing = whole.area().saturating_sub(covered);
        let message = format!("the films leave a gap: {missing} of {} are missing", text(whole));
        return Err(conflict(message, MISSING_PARTS));
    }
    Ok(())
}
