//! Per-pixel values of a frame, and their accumulation over frames.

use crate::color::Spectrum;
use crate::preview::picture::NO_OBJECT;

/// What a frame found in one pixel.
///
/// ```text
///   colour = seen + bounced · ambient  +  albedo · (direct + indirect)  +  gloss
/// ```
///
/// `direct`, `indirect` and `gloss` are noisy and are filtered; the others are not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Emission, background, and what is seen beside the pixel's surface.
    pub(super) seen: Spectrum,
    pub(super) alpha: f32,
    /// Albedos of surfaces whose indirect light is estimated from the mean of the picture.
    pub(super) bounced: Spectrum,
    /// The diffuse albedo of the pixel's surface, times the throughput to it.
    pub(super) albedo: Spectrum,
    /// Direct light over albedo.
    pub(super) direct: Spectrum,
    /// Light that other lobes reflect.
    pub(super) gloss: Spectrum,
    pub(super) roughness: f32,
    pub(super) is_lit: bool,
    /// Whether the surface is a shadow catcher: `direct` then holds the light with and without what is in the way.
    pub(super) is_catcher: bool,
    /// Indirect light over albedo, and the albedo of the surfaces that it comes from.
    pub(super) indirect: Spectrum,
    pub(super) second: Spectrum,
    /// The pixel's surface: normal, 1 / path length, and a number that differs where surfaces must not be mixed.
    pub(super) normal: [f32; 3],
    pub(super) near: f32,
    pub(super) key: u32,
    /// What is hit first, and 1 / its distance.
    pub(super) object: u32,
    pub(super) first_near: f32,
}

impl Sample {
    pub(super) const NOTHING: Sample = Sample {
        seen: Spectrum::BLACK,
        alpha: 1.0,
        bounced: Spectrum::BLACK,
        albedo: Spectrum::BLACK,
        direct: Spectrum::BLACK,
        gloss: Spectrum::BLACK,
        roughness: 1.0,
        is_lit: false,
        is_catcher: false,
        indirect: Spectrum::BLACK,
        second: Spectrum::BLACK,
        normal: [0.0; 3],
        near: 0.0,
        key: NO_KEY,
        object: NO_OBJECT,
        first_near: 0.0,
    };
}

/// The key of pixels without a surface.
pub(super) const NO_KEY: u32 = u32::MAX;
/// Added to the key of shadow catchers.
pub(super) const CATCHER: u32 = 1 << 31;

/// Light of all pixels with the number of samples that each is the mean of.
#[derive(Clone, Debug, Default)]
pub(super) struct Light {
    pub(super) rgb: [Vec<f32>; 3],
    pub(super) count: Vec<f32>,
}

impl Light {
    /// Forgets all samples.
    pub(super) fn begin(&mut self, count: usize) {
        self.set_len(count);
        self.count.fill(0.0);
    }

    /// Changes the number of pixels and leaves any values.
    pub(super) fn set_len(&mut self, count: usize) {
        for plane in self.rgb.iter_mut().chain([&mut self.count]) {
            plane.resize(count, 0.0);
        }
    }

    /// The parts of `size` elements.
    pub(super) fn parts(&mut self, size: usize) -> impl Iterator<Item = LightPart<'_>> {
        let [r, g, b] = &mut self.rgb;
        let rgb = r.chunks_mut(size).zip(g.chunks_mut(size)).zip(b.chunks_mut(size));
        rgb.zip(self.count.chunks_mut(size)).map(|(((r, g), b), count)| LightPart { rgb: [r, g, b], count })
    }
}

/// Rows of [`Light`].
pub(super) struct LightPart<'a> {
    pub(super) rgb: [&'a mut [f32]; 3],
    pub(super) count: &'a mut [f32],
}

impl LightPart<'_> {
    /// Continues from a mean of an earlier frame, of at most `most` samples.
    #[inline]
    pub(super) fn continue_from(&mut self, i: usize, past: &Light, from: usize, most: f32) {
        self.count[i] = past.count[from].min(most);
        for (plane, past) in self.rgb.iter_mut().zip(&past.rgb) {
            plane[i] = past[from];
        }
    }

    /// Adds a sample to the mean of at most `most` samples.
    #[inline]
    pub(super) fn add(&mut self, i: usize, light: Spectrum, most: f32) {
        if !light.is_finite() {
            return;
        }
        let count = self.count[i].min(most - 1.0) + 1.0;
        self.count[i] = count;
        for (plane, v) in self.rgb.iter_mut().zip(light.to_array()) {
            plane[i] = if count == 1.0 { v } else { plane[i] + (v - plane[i]) / count };
        }
    }
}

/// The surfaces of all pixels, for filters.
#[derive(Clone, Debug, Default)]
pub(super) struct Guides {
    pub(super) normal: [Vec<f32>; 3],
    /// 1 / path length: linear over a plane.
    pub(super) near: Vec<f32>,
    pub(super) key: Vec<u32>,
    pub(super) roughness: Vec<f32>,
}

impl Guides {
    /// Changes the number of pixels and leaves any values.
    pub(super) fn set_len(&mut self, count: usize) {
        for plane in self.normal.iter_mut().chain([&mut self.near, &mut self.roughness]) {
            plane.resize(count, 0.0);
        }
        self.key.resize(count, NO_KEY);
    }

    pub(super) fn parts(&mut self, size: usize) -> impl Iterator<Item = GuidesPart<'_>> {
        let [x, y, z] = &mut self.normal;
        let normal = x.chunks_mut(size).zip(y.chunks_mut(size)).zip(z.chunks_mut(size));
        let others =
            self.near.chunks_mut(size).zip(self.key.chunks_mut(size)).zip(self.roughness.chunks_mut(size));
        normal.zip(others).map(|(((x, y), z), ((near, key), roughness))| GuidesPart {
            normal: [x, y, z],
            near,
            key,
            roughness,
        })
    }
}

/// Rows of [`Guides`].
pub(super) struct GuidesPart<'a> {
    pub(super) normal: [&'a mut [f32]; 3],
    pub(super) near: &'a mut [f32],
    pub(super) key: &'a mut [u32],
    pub(super) roughness: &'a mut [f32],
}

impl GuidesPart<'_> {
    #[inline]
    pub(super) fn set(&mut self, i: usize, sample: &Sample) {
        for (plane, v) in self.normal.iter_mut().zip(sample.normal) {
            plane[i] = v;
        }
        self.near[i] = sample.near;
        self.key[i] = sample.key;
        self.roughness[i] = sample.roughness;
    }
}

/// What is filtered, with its guides: the values that the next frame may continue from.
#[derive(Clone, Debug, Default)]
pub(super) struct Layers {
    pub(super) guides: Guides,
    pub(super) grid: Grid,
    /// The guides of the heads of cells.
    pub(super) heads: Guides,
    /// On the grid of cells after the first frame of a view, else of all pixels.
    pub(super) direct: Light,
    pub(super) gloss: Light,
    /// On the grid.
    pub(super) indirect: Light,
    pub(super) second: Light,
}

impl Layers {
    /// Forgets all samples, for the first frame of a view.
    pub(super) fn begin(&mut self, size: [usize; 2], grid: Grid) {
        self.grid = grid;
        self.guides.set_len(size[0] * size[1]);
        self.heads.set_len(grid.count());
        for light in [&mut self.direct, &mut self.gloss, &mut self.indirect, &mut self.second] {
            light.begin(grid.count());
        }
    }

    /// Whether direct light and gloss are on the grid.
    pub(super) fn is_on_grid(&self) -> bool {
        self.direct.count.len() < self.guides.key.len()
    }

    /// Moves direct light and gloss from the grid to the pixels, for the second frame of a view.
    pub(super) fn spread(&mut self, width: usize) {
        let grid = self.grid;
        for light in [&mut self.direct, &mut self.gloss] {
            let cells = std::mem::take(light);
            light.begin(self.guides.key.len());
            for (cell, count) in cells.count.iter().enumerate().filter(|(_, count)| **count > 0.0) {
                let [x, y] = grid.head(cell);
                let i = y * width + x;
                light.count[i] = *count;
                for (plane, from) in light.rgb.iter_mut().zip(&cells.rgb) {
                    plane[i] = from[cell];
                }
            }
        }
    }

    /// Moves direct light and gloss from the pixels to the grid, as means over each cell's pixels of one surface.
    pub(super) fn gather(&mut self, width: usize) {
        if self.is_on_grid() || width == 0 {
            return;
        }
        let grid = self.grid;
        let keys = &self.guides.key;
        for light in [&mut self.direct, &mut self.gloss] {
            let pixels = std::mem::take(light);
            light.begin(grid.count());
            for cell in 0..grid.count() {
                let [x, y] = grid.head(cell);
                let head = y * width + x;
                let (mut sum, mut count) = ([0.0; 3], 0.0);
                for j in 0..grid.cell * grid.cell {
                    let (dx, dy) = (j % grid.cell, j / grid.cell);
                    let i = head + dy * width + dx;
                    if x + dx >= width || i >= keys.len() || keys[i] != keys[head] {
                        continue;
                    }
                    let n = pixels.count[i];
                    count += n;
                    for (sum, plane) in sum.iter_mut().zip(&pixels.rgb) {
                        // A pixel without samples may hold any value.
                        *sum += if n > 0.0 { n * plane[i] } else { 0.0 };
                    }
                }
                light.count[cell] = count;
                for (plane, sum) in light.rgb.iter_mut().zip(sum) {
                    plane[cell] = if count > 0.0 { sum / count } else { 0.0 };
                }
            }
        }
    }
}

/// The grid of cells: squares of pixels that share sampled light. Their heads are the pixels at the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Grid {
    /// Pixels along a side of a cell: 2 or 4.
    pub(super) cell: usize,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Default for Grid {
    fn default() -> Grid {
        Grid::new([0, 0], 2)
    }
}

impl Grid {
    pub(super) fn new(size: [usize; 2], cell: usize) -> Grid {
        let [columns, rows] = size.map(|side| side.div_ceil(cell));
        Grid { cell, columns, rows }
    }

    pub(super) fn count(self) -> usize {
        self.columns * self.rows
    }

    /// Column and row of a cell's head.
    pub(super) fn head(self, cell: usize) -> [usize; 2] {
        [cell % self.columns, cell / self.columns].map(|side| side * self.cell)
    }
}

/// What is not filtered: the mean over frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Still {
    pub(super) seen: Spectrum,
    pub(super) alpha: f32,
    pub(super) bounced: Spectrum,
    pub(super) albedo: Spectrum,
    pub(super) catcher: f32,
}

impl Still {
    #[inline]
    pub(super) fn of(sample: &Sample) -> Still {
        Still {
            seen: sample.seen,
            alpha: sample.alpha,
            bounced: sample.bounced,
            albedo: sample.albedo,
            catcher: if sample.is_catcher { 1.0 } else { 0.0 },
        }
    }

    /// Adds a frame to the mean of `count` frames in all.
    #[inline]
    pub(super) fn add(&mut self, new: &Still, count: f32) {
        if count <= 1.0 {
            *self = *new;
            return;
        }
        let k = 1.0 / count;
        self.seen += (new.seen - self.seen) * k;
        self.alpha += (new.alpha - self.alpha) * k;
        self.bounced += (new.bounced - self.bounced) * k;
        self.albedo += (new.albedo - self.albedo) * k;
        self.catcher += (new.catcher - self.catcher) * k;
    }
}
