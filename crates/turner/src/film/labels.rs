//! Labels of samples: numbers of objects and materials, which have no mean.
//!
//! A film keeps labels in one of two ways ([`LabelRule`]):
//!
//! - `Nearest`: the label of the sample that is nearest to the pixel's centre, among the samples of the pixel itself;
//!   of equally near ones that with the smallest index.
//! - `Coverage`: for each label the sum of the filter weights of its samples.
//!
//! A minimum and an integer sum do not depend on the order of samples, so films with labels can be split and merged
//! like sums of colour.

use super::fixed::ONE;
use super::tile_sums::{MAX_REACHED, reached};
use super::{PixelRect, TILE};
use crate::filter::Filter;
use crate::math::DVec2;

/// The label of a sample that hit nothing. It is kept by neither rule.
pub const NO_LABEL: u32 = u32::MAX;

/// What a film keeps of the labels of a pixel's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelRule {
    /// That of the sample nearest to the pixel's centre.
    Nearest,
    /// The weight of each.
    Coverage,
}

/// A channel of labels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LabelChannel {
    /// Its name.
    pub name: String,
    /// What is kept.
    pub rule: LabelRule,
}

/// How near the nearest sample is: its squared distance as ordered bits, then its index. Smaller is nearer.
pub(super) type Nearness = u64;

/// No sample.
pub(super) const NOWHERE: Nearness = u64::MAX;

/// The nearness of a sample at a distance in pixels from the pixel's centre. The bits of non-negative floats are in the
/// order of their values.
fn nearness(distance2: f64, index: u32) -> Nearness {
    u64::from((distance2 as f32).to_bits()) << 32 | u64::from(index)
}

/// The weight of a label in a pixel, in units of 2^-32.
pub(super) type Weight = i64;

/// Number of labels of a pixel that need no search.
const SLOTS: usize = 2;

/// The labels of one tile while its samples are traced. A worker fills them and then adds them to the film.
#[derive(Clone, Debug, Default)]
pub struct TileLabels {
    tile: Option<PixelRect>,
    /// The tile and the border that its samples reach.
    pub(super) reach: Option<PixelRect>,
    rules: Vec<LabelRule>,
    /// For each pixel of the tile.
    pub(super) nearness: Vec<Nearness>,
    /// For each pixel of the tile, its labels by the rule `Nearest`.
    pub(super) nearest: Vec<u32>,
    /// For each channel of the rule `Coverage` and each pixel of the reach, the first labels.
    slots: Vec<[(u32, Weight); SLOTS]>,
    /// For each channel of the rule `Coverage`, further ones: pixel of the reach, label, weight.
    more: Vec<Vec<(u32, u32, Weight)>>,
}

/// Further labels are summed when there are so many.
const MOST_PENDING: usize = 1 << 14;

impl TileLabels {
    /// Clears the labels and sets their tile and the pixels that its samples reach.
    pub fn reset(&mut self, tile: PixelRect, reach: PixelRect, channels: &[LabelChannel]) {
        self.rules.clear();
        self.rules.extend(channels.iter().map(|c| c.rule));
        (self.tile, self.reach) = (Some(tile), Some(reach));
        let (own, reached) = (tile.area() as usize, reach.area() as usize);
        let nearest = self.nearest_count();
        let covers = self.rules.len() - nearest;
        self.nearness.clear();
        self.nearness.resize(if nearest > 0 { own } else { 0 }, NOWHERE);
        self.nearest.clear();
        self.nearest.resize(own * nearest, NO_LABEL);
        self.slots.clear();
        self.slots.resize(reached * covers, [(NO_LABEL, 0); SLOTS]);
        self.more.iter_mut().for_each(Vec::clear);
        self.more.resize(covers, Vec::new());
    }

    /// The pixels of the tile.
    pub(super) fn tile(&self) -> Option<PixelRect> {
        self.tile
    }

    /// The number of channels of the rule `Nearest`.
    pub(super) fn nearest_count(&self) -> usize {
        self.rules.iter().filter(|r| **r == LabelRule::Nearest).count()
    }

    /// Adds a sample of pixel (`x`, `y`) with index `index` at a position of the picture. `labels` has one label for
    /// each channel. With a filter, it counts in all pixels that the filter reaches.
    pub fn add(
        &mut self,
        (x, y): (u32, u32),
        index: u32,
        place: DVec2,
        filter: Option<&Filter>,
        labels: &[u32],
    ) {
        let (Some(tile), Some(reach)) = (self.tile, self.reach) else { return };
        if !(tile.x..tile.x + tile.width).contains(&x) || !(tile.y..tile.y + tile.height).contains(&y) {
            return;
        }
        let count = self.nearest_count();
        if count > 0 {
            let pixel = ((y - tile.y) * tile.width + x - tile.x) as usize;
            let center = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let near = nearness(place.distance_squared(center), index);
            if near < self.nearness[pixel] {
                self.nearness[pixel] = near;
                let own = &mut self.nearest[pixel * count..(pixel + 1) * count];
                let values = self.rules.iter().zip(labels).filter(|(r, _)| **r == LabelRule::Nearest);
                own.iter_mut().zip(values).for_each(|(own, (_, label))| *own = *label);
            }
        }
        if self.more.is_empty() {
            return;
        }
        let Some(filter) = filter else {
            self.cover(((y - reach.y) * reach.width + x - reach.x) as usize, labels, ONE as Weight);
            return;
        };
        let mut along_x = [0.0; MAX_REACHED];
        let columns = reached(filter, place.x, reach.x, reach.width, &mut along_x);
        let mut along_y = [0.0; MAX_REACHED];
        let rows = reached(filter, place.y, reach.y, reach.height, &mut along_y);
        for (row, vertical) in rows.zip(along_y) {
            for (column, horizontal) in columns.clone().zip(along_x) {
                let weight = (horizontal * vertical) as f32;
                if weight != 0.0 {
                    let pixel = (row - reach.y) * reach.width + column - reach.x;
                    self.cover(pixel as usize, labels, (f64::from(weight) * ONE) as Weight);
                }
            }
        }
    }

    /// Adds a weight to the labels of a pixel of the reach.
    fn cover(&mut self, pixel: usize, labels: &[u32], weight: Weight) {
        let pixels = self.slots.len() / self.more.len().max(1);
        let covers = self.rules.iter().zip(labels).filter(|(r, _)| **r == LabelRule::Coverage);
        for (channel, (_, &label)) in covers.enumerate() {
            if label == NO_LABEL {
                continue;
            }
            let slots = &mut self.slots[channel * pixels + pixel];
            let slot = slots.iter_mut().find(|(own, _)| *own == label || *own == NO_LABEL);
            if let Some((own, sum)) = slot {
                (*own, *sum) = (label, *sum + weight);
                continue;
            }
            let more = &mut self.more[channel];
            more.push((pixel as u32, label, weight));
            if more.len() >= MOST_PENDING {
                sum_equal(more);
            }
        }
    }

    /// The labels of one channel in a part of the reach, as (x, y, label, weight), in no particular order.
    pub(super) fn covered(&self, channel: usize) -> impl Iterator<Item = (u32, u32, u32, Weight)> + '_ {
        let reach = self.reach.unwrap_or(PixelRect { x: 0, y: 0, width: 1, height: 0 });
        let pixels = reach.area() as usize;
        let at = move |pixel: u32| (reach.x + pixel % reach.width, reach.y + pixel / reach.width);
        let slots = self.slots.iter().skip(channel * pixels).take(pixels).enumerate();
        let first = slots.flat_map(|(pixel, slots)| slots.iter().map(move |(l, w)| (pixel as u32, *l, *w)));
        let more = self.more.get(channel).into_iter().flatten().copied();
        first.filter(|(_, label, _)| *label != NO_LABEL).chain(more).map(move |(pixel, label, weight)| {
            let (x, y) = at(pixel);
            (x, y, label, weight)
        })
    }
}

/// Sums the weights of equal labels of a pixel.
fn sum_equal(all: &mut Vec<(u32, u32, Weight)>) {
    all.sort_unstable_by_key(|(pixel, label, _)| (*pixel, *label));
    all.dedup_by(|later, kept| {
        let same = (later.0, later.1) == (kept.0, kept.1);
        if same {
            kept.2 = kept.2.wrapping_add(later.2);
        }
        same
    });
}

/// The labels of a tile's pixels on the film.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct HeldLabels {
    /// For each pixel, if a channel has the rule `Nearest`.
    pub(super) nearness: Vec<Nearness>,
    /// For each pixel the labels of these channels.
    pub(super) nearest: Vec<u32>,
    /// For each channel with the rule `Coverage`: the weight of each pair of a pixel and a label, sorted by pixel and label.
    pub(super) covers: Vec<Vec<((u16, u32), Weight)>>,
}

impl HeldLabels {
    /// No labels of a tile with this number of pixels.
    pub(super) fn new(pixels: usize, channels: &[LabelChannel]) -> HeldLabels {
        let nearest = channels.iter().filter(|c| c.rule == LabelRule::Nearest).count();
        HeldLabels {
            nearness: vec![NOWHERE; if nearest > 0 { pixels } else { 0 }],
            nearest: vec![NO_LABEL; nearest * pixels],
            covers: vec![Vec::new(); channels.len() - nearest],
        }
    }

    /// The number of channels of the rule `Nearest`.
    pub(super) fn nearest_count(&self) -> usize {
        self.nearest.len() / self.nearness.len().max(1)
    }

    /// Keeps the nearer one of two samples of a pixel.
    pub(super) fn keep_nearer(&mut self, pixel: usize, near: Nearness, labels: &[u32]) {
        let count = self.nearest_count();
        if near < self.nearness[pixel] {
            self.nearness[pixel] = near;
            self.nearest[pixel * count..(pixel + 1) * count].copy_from_slice(labels);
        }
    }

    /// Adds weights to labels; `added` becomes empty.
    pub(super) fn cover(&mut self, channel: usize, added: &mut Vec<((u16, u32), Weight)>) {
        let Some(own) = self.covers.get_mut(channel) else { return };
        own.append(added);
        own.sort_unstable_by_key(|(key, _)| *key);
        own.dedup_by(|later, kept| {
            let same = later.0 == kept.0;
            if same {
                kept.1 = kept.1.wrapping_add(later.1);
            }
            same
        });
    }

    /// Adds the labels of the same tile of another film.
    pub(super) fn merge(&mut self, other: &HeldLabels) {
        let count = self.nearest_count();
        for (pixel, near) in other.nearness.iter().enumerate() {
            self.keep_nearer(pixel, *near, &other.nearest[pixel * count..(pixel + 1) * count]);
        }
        for (channel, theirs) in other.covers.iter().enumerate() {
            self.cover(channel, &mut theirs.clone());
        }
    }

    /// The labels and weights of a channel in a pixel of the tile.
    pub(super) fn of_pixel(&self, channel: usize, pixel: u16) -> &[((u16, u32), Weight)] {
        let all = self.covers.get(channel).map_or(&[][..], Vec::as_slice);
        let start = all.partition_point(|((p, _), _)| *p < pixel);
        let end = all.partition_point(|((p, _), _)| *p <= pixel);
        &all[start..end]
    }
}

/// The number of pixels of a tile fits into the index of a pixel.
const _: () = assert!(TILE * TILE <= u16::MAX as u32);
