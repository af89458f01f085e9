//! The AOVs of one tile.

use super::tile::TileBuffers;
use crate::film::{LabelChannel, PixelRect, SampleValues, TileLabels};
use crate::integrator::aovs::SampleAovs;
use crate::integrator::{Prepared, Radiance, SampleDetails};
use crate::math::DVec2;
use crate::sampler::SampleId;
use crate::view::{place, take_points};

/// A worker's AOVs: of the samples of the present batch, and the labels of the tile.
pub(super) struct TileAovs<'a> {
    pub(super) of_samples: SampleAovs<'a>,
    /// Values and labels of the strips of this tile that are already traced.
    earlier: (Vec<f32>, Vec<u32>),
    pub(super) labels: TileLabels,
    label_channels: Vec<LabelChannel>,
    channels: usize,
}

impl<'a> TileAovs<'a> {
    /// `None` if the film has none.
    pub(super) fn new(p: &'a Prepared) -> Option<TileAovs<'a>> {
        Some(TileAovs {
            of_samples: SampleAovs::new(&p.scene, &p.view)?,
            earlier: (Vec::new(), Vec::new()),
            labels: TileLabels::default(),
            label_channels: p.view.film.labels(),
            channels: p.view.film.channels().len(),
        })
    }

    /// Before the first strip of a tile.
    pub(super) fn forget_earlier(&mut self) {
        self.earlier.0.clear();
        self.earlier.1.clear();
    }

    /// Keeps the samples of a strip.
    pub(super) fn keep(&mut self) {
        self.of_samples.append_to(&mut self.earlier);
    }

    /// After the last strip: all samples of the tile.
    pub(super) fn take_kept(&mut self) {
        self.of_samples.swap(&mut self.earlier);
    }
}

impl TileBuffers<'_> {
    /// Clears the sums for a tile.
    pub(super) fn begin_sums(&mut self, tile: &PixelRect) {
        let reach = tile.grown(self.p.view.film.reach(), &self.region);
        let channels = self.aovs.as_ref().map_or(0, |aovs| aovs.channels);
        self.sums.reset(reach, channels, self.estimates_error);
        self.sums.keep_brightest(self.p.view.film.removes_fireflies());
        if let Some(aovs) = &mut self.aovs {
            aovs.labels.reset(*tile, reach, &aovs.label_channels);
        }
    }

    /// Adds the samples of one index, with their AOVs, to the sums.
    pub(super) fn add_samples_with_aovs(&mut self) {
        let Some(aovs) = &mut self.aovs else { return };
        let filter = self.reconstruction.as_ref();
        let rect = self.sums.rect();
        for (i, (id, &Radiance { color, alpha })) in self.samples.ids.iter().zip(&self.radiance).enumerate() {
            let at = place(&self.p.view, &self.filter, id);
            let values = SampleValues { color, alpha, extra: aovs.of_samples.values(i), index: id.index };
            let finite = match filter {
                Some(filter) => self.sums.splat(filter, at, &values),
                None => {
                    let pixel = (id.y - rect.y) * rect.width + id.x - rect.x;
                    self.sums.add_weighted(pixel as usize, &values, 1.0)
                }
            };
            if finite {
                aovs.labels.add((id.x, id.y), id.index, at, filter, aovs.of_samples.labels(i));
            } else {
                self.non_finite.note(id.x, id.y, id.index);
            }
        }
    }

    /// With adaptive anti-aliasing: adds the colours of the tile's pixels, and the AOVs of one ray through the centre of
    /// each pixel.
    pub(super) fn add_aovs_of_centers(&mut self, tile: &PixelRect) {
        if self.aovs.is_none() {
            return;
        }
        self.begin_sums(tile);
        let seed = u64::from(self.p.view.film.seed);
        let pixels = (0..tile.area() as u32).map(|i| (tile.x + i % tile.width, tile.y + i / tile.width));
        let points = pixels.map(|(x, y)| {
            let center = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            (SampleId { x, y, index: 0, seed }, center)
        });
        self.samples.clear();
        take_points(&self.p.view, &mut self.samples, points);
        let Some(aovs) = &mut self.aovs else { return };
        aovs.of_samples.take(&self.samples, &self.pixels, SampleDetails::default());
        for (i, (id, &Radiance { color, alpha })) in self.samples.ids.iter().zip(&self.pixels).enumerate() {
            let values = SampleValues { color, alpha, extra: aovs.of_samples.values(i), index: id.index };
            // The pixel is already counted if it is not finite.
            if self.sums.add_weighted(i, &values, 1.0) {
                let center = DVec2::new(f64::from(id.x) + 0.5, f64::from(id.y) + 0.5);
                aovs.labels.add((id.x, id.y), 0, center, None, aovs.of_samples.labels(i));
            }
        }
    }
}
