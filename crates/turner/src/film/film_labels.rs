//! The labels of a film: see [`super::labels`].

use super::fixed::ONE;
use super::labels::{HeldLabels, LabelRule, NO_LABEL, NOWHERE, TileLabels, Weight};
use super::{Film, LabelChannel, PixelRect, SharedFilm, TILE};
use crate::schema::{ErrorCode, SceneError};

impl Film {
    /// Estimated bytes per pixel of the labels of these channels.
    pub(super) fn label_bytes(channels: &[LabelChannel]) -> usize {
        let nearest = channels.iter().filter(|c| c.rule == LabelRule::Nearest).count();
        // A pixel at an edge has several labels, and a list may have spare room.
        let covers = (channels.len() - nearest) * 4 * size_of::<((u16, u32), Weight)>();
        covers + if nearest > 0 { 8 + 4 * nearest } else { 0 }
    }

    /// Adds room for labels. Does nothing if there is room already.
    ///
    /// Errors: not enough memory.
    pub(super) fn take_labels(&mut self, channels: &[LabelChannel]) -> Result<(), SceneError> {
        if channels.is_empty() || !self.labels.is_empty() {
            return Ok(());
        }
        let bytes = Film::label_bytes(channels);
        if Vec::<u8>::new().try_reserve_exact(self.region.area() as usize * bytes).is_err() {
            let PixelRect { width, height, .. } = self.region;
            let message = format!("not enough memory for the labels of a film of {width}x{height}");
            return Err(SceneError::new(ErrorCode::TooLarge, message).help("render it in parts with `crop`"));
        }
        self.labels = channels.to_vec();
        self.bytes_per_pixel += bytes;
        for band in &mut self.bands {
            let tiles = 0..band.held.len();
            band.labels =
                tiles.map(|column| HeldLabels::new(band.tile(column).area() as usize, channels)).collect();
        }
        Ok(())
    }

    /// The channels of labels.
    pub fn labels(&self) -> &[LabelChannel] {
        &self.labels
    }

    /// The labels of a pixel's tile, and the index of the pixel in the tile.
    fn labels_at(&self, x: u32, y: u32) -> Option<(&HeldLabels, usize)> {
        let (column, row) = (x.checked_sub(self.region.x)?, y.checked_sub(self.region.y)?);
        let band = self.bands.get((row / TILE) as usize)?;
        let tile = (column / TILE) as usize;
        let labels = band.labels.get(tile)?;
        Some((labels, ((row % TILE) * band.tile(tile).width + column % TILE) as usize))
    }

    /// The position of a channel among those with its rule.
    fn label_channel(&self, name: &str, rule: LabelRule) -> Option<usize> {
        self.labels.iter().filter(|c| c.rule == rule).position(|c| c.name == name)
    }

    /// The label of the sample nearest to the centre of a pixel of the region; `None` without such a channel, or
    /// where that sample hit nothing.
    pub fn nearest_label(&self, name: &str, x: u32, y: u32) -> Option<u32> {
        let channel = self.label_channel(name, LabelRule::Nearest)?;
        let (held, pixel) = self.labels_at(x, y)?;
        let label = *held.nearest.get(pixel * held.nearest_count() + channel)?;
        (label != NO_LABEL).then_some(label)
    }

    /// The labels of a pixel of the region and the fraction of the pixel that each covers, by ascending label. Empty
    /// without such a channel.
    pub fn label_coverage(&self, name: &str, x: u32, y: u32) -> impl Iterator<Item = (u32, f32)> + '_ {
        let channel = self.label_channel(name, LabelRule::Coverage);
        let found =
            channel.and_then(|c| self.labels_at(x, y).map(|(held, pixel)| held.of_pixel(c, pixel as u16)));
        let weight = self.weight(x, y);
        let entries = found.unwrap_or_default().iter().filter(move |_| weight > 0.0);
        entries.map(move |((_, label), sum)| (*label, (*sum as f64 / (ONE * weight)) as f32))
    }

    /// Adds the labels of a film of the same picture.
    pub(super) fn merge_labels(&mut self, other: &Film) {
        for (own, theirs) in self.bands.iter_mut().zip(&other.bands) {
            own.labels.iter_mut().zip(&theirs.labels).for_each(|(own, theirs)| own.merge(theirs));
        }
    }

    /// Copies the labels of the pixels of another film's crop.
    pub(super) fn copy_labels(&mut self, other: &Film) {
        let PixelRect { x: left, y: top, width, height } = other.crop;
        for (x, y) in (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y))) {
            let Some((theirs, from)) = other.labels_at(x, y) else { continue };
            let (column, row) = (x - self.region.x, y - self.region.y);
            let Some(band) = self.bands.get_mut((row / TILE) as usize) else { continue };
            let tile = (column / TILE) as usize;
            let to = ((row % TILE) * band.tile(tile).width + column % TILE) as usize;
            let Some(own) = band.labels.get_mut(tile) else { continue };
            let count = theirs.nearest_count();
            if let Some(near) = theirs.nearness.get(from).filter(|near| **near != NOWHERE) {
                own.keep_nearer(to, *near, &theirs.nearest[from * count..(from + 1) * count]);
            }
            for channel in 0..theirs.covers.len() {
                let of_pixel = theirs.of_pixel(channel, from as u16);
                let mut added = of_pixel.iter().map(|((_, l), w)| ((to as u16, *l), *w)).collect();
                own.cover(channel, &mut added);
            }
        }
    }
}

impl SharedFilm<'_> {
    /// Adds the labels of the samples of a tile, to the tile and to the border that their filter reaches. The caller
    /// has added their sums: [`SharedFilm::deposit_sums`].
    pub fn deposit_labels(&self, tile: usize, labels: &TileLabels) {
        let (Some(rect), Some(reach)) = (labels.tile(), labels.reach) else { return };
        let count = labels.nearest_count();
        self.in_band(tile, |band, column, _| {
            let Some(held) = band.labels.get_mut(column) else { return };
            for (pixel, near) in labels.nearness.iter().enumerate().take(rect.area() as usize) {
                held.keep_nearer(pixel, *near, &labels.nearest[pixel * count..(pixel + 1) * count]);
            }
        });
        let mut added = Vec::new();
        for other in self.grid.touching(&reach) {
            self.in_band(other as usize, |band, column, own| {
                let Some(held) = band.labels.get_mut(column) else { return };
                for channel in 0..held.covers.len() {
                    let inside = |x: u32, y: u32| {
                        (own.x..own.x + own.width).contains(&x) && (own.y..own.y + own.height).contains(&y)
                    };
                    let here = labels.covered(channel).filter(|(x, y, ..)| inside(*x, *y));
                    added.extend(here.map(|(x, y, label, weight)| {
                        ((((y - own.y) * own.width + x - own.x) as u16, label), weight)
                    }));
                    held.cover(channel, &mut added);
                }
            });
        }
    }
}
