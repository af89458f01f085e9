//! One task of a frame: the pixels of a band of rows.

use std::sync::atomic::Ordering;

use crate::color::Spectrum;
use crate::preview::buffers::{Grid, GuidesPart, LightPart, Still};
use crate::preview::fill::between;
use crate::preview::history::{MOST_MOVING, Past};
use crate::preview::walk::{Frame, Group, Walk};
use crate::preview::{PreviewOptions, ROWS, Worker};

/// Columns of the groups of pixels that are traced together: a multiple of four.
const GROUP: usize = 32;

/// The most frames in a mean.
const MOST_STILL: f32 = 4096.0;

/// Indirect and glossy light of one sample is at most this multiple of what is shown as white.
const MOST_INDIRECT: f32 = 4.0;
const MOST_GLOSS: f32 = 6.0;

/// Reflections on rougher surfaces move little with the camera.
const BLURRED: f32 = 0.3;

/// The rows of a task.
pub(super) struct Band<'a> {
    pub(super) index: usize,
    pub(super) guides: GuidesPart<'a>,
    pub(super) grid: Grid,
    pub(super) heads: GuidesPart<'a>,
    pub(super) still: &'a mut [Still],
    pub(super) count: &'a mut f32,
    pub(super) direct: LightPart<'a>,
    pub(super) gloss: LightPart<'a>,
    pub(super) indirect: LightPart<'a>,
    pub(super) second: LightPart<'a>,
    pub(super) has_gloss: &'a mut bool,
    pub(super) object: &'a mut [u32],
    pub(super) depth: &'a mut [f32],
}

/// Light of at most this luminance: rare bright samples would be spots.
fn capped(light: Spectrum, most: f32) -> Spectrum {
    let luminance = light.luminance();
    if luminance > most { light * (most / luminance) } else { light }
}

/// Traces the pixels of a band.
pub(super) fn trace_band(
    frame: &Frame<'_>,
    worker: &mut Worker,
    mut band: Band<'_>,
    past: Option<&Past<'_>>,
    options: &PreviewOptions<'_>,
) {
    let width = frame.view.film.width as usize;
    let rows = band.still.len() / width;
    *band.count = (*band.count + 1.0).min(MOST_STILL);
    for left in (0..width).step_by(GROUP) {
        if options.cancel.load(Ordering::Relaxed) {
            return;
        }
        let walk = &mut worker.walk;
        walk.begin(Group {
            left: left as u32,
            top: (band.index * ROWS) as u32,
            columns: GROUP.min(width - left) as u32,
            rows: rows as u32,
        });
        trace_group(frame, walk);
        keep_group(frame, walk, &mut band, past);
    }
}

/// Columns and rows of the grid of pixels from which the mean of indirect light is estimated before the first frame.
const PROBES: [u32; 2] = [24, 14];

/// The mean of the indirect light of a picture, from a few pixels.
pub(super) fn estimate_ambient(frame: &Frame<'_>, walk: &mut Walk) -> Spectrum {
    let (width, height) = (frame.view.film.width, frame.view.film.height);
    let (mut light, mut albedo, mut count) = (Spectrum::BLACK, Spectrum::BLACK, 0.0);
    for row in 0..PROBES[1] {
        for column in 0..PROBES[0] {
            let (left, top) = (column * width / PROBES[0] / 4 * 4, row * height / PROBES[1] / 4 * 4);
            let (columns, rows) = (4.min(width - left), 4.min(height - top));
            walk.begin(Group { left, top, columns, rows });
            walk.traced.clear();
            let gathers = |pixel: &u32| frame.pattern.gathers(left + pixel % columns, top + pixel / columns);
            walk.traced.extend((0..columns * rows).filter(gathers));
            walk.trace(frame);
            let found = walk.traced.iter().filter_map(|pixel| walk.found.get(*pixel as usize));
            for sample in found.filter(|sample| !sample.albedo.is_black() && sample.indirect.is_finite()) {
                light += capped(sample.indirect, MOST_INDIRECT * frame.white);
                albedo += sample.second;
                count += 1.0;
            }
        }
    }
    if count == 0.0 {
        return Spectrum::BLACK;
    }
    let mean = |light: f32, albedo: f32| light / count / (1.0 - (albedo / count).min(0.9));
    Spectrum::new(mean(light.r, albedo.r), mean(light.g, albedo.g), mean(light.b, albedo.b))
}

/// Traces the pixels of a group, or fills them.
fn trace_group(frame: &Frame<'_>, walk: &mut Walk) {
    let Group { columns, rows, .. } = walk.group;
    let is_traced = |walk: &Walk, pixel: u32| {
        let (x, y) = walk.place(pixel);
        frame.pattern.traces(x, y)
    };
    walk.traced.clear();
    // Squares of 4 x 4 pixels are coherent packets.
    for top in (0..rows).step_by(4) {
        for left in (0..columns).step_by(4) {
            for y in top..rows.min(top + 4) {
                for x in left..columns.min(left + 4) {
                    if is_traced(walk, y * columns + x) {
                        walk.traced.push(y * columns + x);
                    }
                }
            }
        }
    }
    walk.trace(frame);
    if !frame.pattern.is_first {
        return;
    }
    walk.traced.clear();
    for y in 0..rows {
        for x in 0..columns {
            let at = y * columns + x;
            if is_traced(walk, at) {
                continue;
            }
            let of = |inside: bool, at: u32| if inside { walk.found.get(at as usize) } else { None };
            let neighbours = [
                of(x > 0, at.wrapping_sub(1)),
                of(x + 1 < columns, at + 1),
                of(y > 0, at.wrapping_sub(columns)),
                of(y + 1 < rows, at + columns),
            ];
            match between(neighbours) {
                Some(sample) => walk.found[at as usize] = sample,
                None => walk.traced.push(at),
            }
        }
    }
    walk.trace(frame);
}

/// Keeps what a group shows, and adds its light to the means.
fn keep_group(frame: &Frame<'_>, walk: &Walk, band: &mut Band<'_>, past: Option<&Past<'_>>) {
    let width = frame.view.film.width as usize;
    let grid = band.grid;
    let Group { left, columns, .. } = walk.group;
    let is_first = frame.pattern.is_first;
    for (row, samples) in walk.found.chunks_exact(columns as usize).enumerate() {
        let first = row * width + left as usize;
        if is_first {
            for (sample, i) in samples.iter().zip(first..) {
                band.guides.set(i, sample);
                band.object[i] = sample.object;
                band.depth[i] = 1.0 / sample.first_near;
                band.still[i] = Still::of(sample);
            }
        } else {
            for (sample, still) in samples.iter().zip(&mut band.still[first..]) {
                still.add(&Still::of(sample), *band.count);
            }
        }
        for (column, sample) in samples.iter().enumerate() {
            let (x, y) = walk.place((row * columns as usize + column) as u32);
            let cell = row / grid.cell * grid.columns + x as usize / grid.cell;
            let mut i = first + column;
            if is_first {
                if !frame.pattern.is_head(x, y) {
                    continue;
                }
                i = cell;
                band.heads.set(cell, sample);
                if let Some(past) = past {
                    let random = frame.pattern.random(x, y);
                    if let Some(from) = past.find(frame.view, [x, y], sample, random) {
                        let layers = past.layers;
                        band.direct.continue_from(cell, &layers.direct, from, MOST_MOVING);
                        if sample.roughness > BLURRED && sample.roughness < 1.0 {
                            band.gloss.continue_from(cell, &layers.gloss, from, MOST_MOVING);
                        }
                        band.indirect.continue_from(cell, &layers.indirect, from, MOST_MOVING);
                        band.second.continue_from(cell, &layers.second, from, MOST_MOVING);
                    }
                }
            }
            if sample.is_lit {
                band.direct.add(i, sample.direct, MOST_STILL);
                if sample.roughness < 1.0 {
                    band.gloss.add(i, capped(sample.gloss, MOST_GLOSS * frame.white), MOST_STILL);
                    *band.has_gloss = true;
                }
            }
            if frame.pattern.gathers(x, y) && !sample.albedo.is_black() {
                band.indirect.add(cell, capped(sample.indirect, MOST_INDIRECT * frame.white), MOST_STILL);
                band.second.add(cell, sample.second, MOST_STILL);
            }
        }
    }
}
