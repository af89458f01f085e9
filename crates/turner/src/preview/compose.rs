//! The colour of each pixel from its light and albedo.

use crate::color::Spectrum;
use crate::preview::buffers::{CATCHER, Guides, Light, NO_KEY, Still};
use crate::preview::draw::grid_size;

/// The parts of a picture.
pub(super) struct Composed<'a> {
    pub(super) size: [usize; 2],
    pub(super) guides: &'a Guides,
    pub(super) grid: &'a Guides,
    pub(super) still: &'a [Still],
    pub(super) direct: &'a Light,
    /// The same without a filter.
    pub(super) unfiltered: &'a Light,
    pub(super) gloss: Option<&'a Light>,
    pub(super) indirect: &'a Light,
    /// Light that arrives at a surface from others, over π, as the mean of the picture.
    pub(super) ambient: [f32; 3],
}

impl Composed<'_> {
    /// Direct light without a filter.
    fn unfiltered_direct(&self, i: usize) -> Spectrum {
        if self.unfiltered.count[i] > 0.0 { at(self.unfiltered, i) } else { Spectrum::BLACK }
    }
}

fn at(light: &Light, i: usize) -> Spectrum {
    let [r, g, b] = &light.rgb;
    Spectrum::new(r[i], g[i], b[i])
}

/// Composes rows.
pub(super) fn compose(of: &Composed<'_>, first: usize, color: &mut [[f32; 3]], alpha: &mut [f32]) {
    let [width, _] = of.size;
    let ambient = Spectrum::from(of.ambient);
    for (j, (color, alpha)) in color.iter_mut().zip(alpha).enumerate() {
        let (x, y) = (j % width, first + j / width);
        let i = y * width + x;
        let still = &of.still[i];
        let mut sum = still.seen + still.bounced * ambient;
        *alpha = still.alpha;
        let key = of.guides.key[i];
        if key != NO_KEY && key & CATCHER != 0 {
            let light = at(of.direct, i);
            if light.g > 0.0 {
                let left = (light.r / light.g).clamp(0.0, 1.0);
                let off = (1.0 - left) * still.catcher;
                sum *= 1.0 - off;
                *alpha += off * (1.0 - *alpha);
            }
        } else if key != NO_KEY {
            let mut light = at(of.direct, i);
            if !still.albedo.is_black() {
                light += indirect(of, x, y, i, ambient);
            }
            sum += still.albedo * light;
            if let Some(gloss) = of.gloss.filter(|_| of.guides.roughness[i] < 1.0) {
                sum += at(gloss, i);
            }
        }
        if key == NO_KEY && !still.albedo.is_black() {
            // A surface that some frames find within the pixel, but not the first one.
            sum += still.albedo * (of.unfiltered_direct(i) + ambient);
        }
        *color = sum.to_array();
    }
}

/// Indirect light, from the nearest cells of the grid that lie on the same surface.
fn indirect(of: &Composed<'_>, x: usize, y: usize, i: usize, ambient: Spectrum) -> Spectrum {
    let [width, height] = of.size;
    let [grid_width, grid_height] = grid_size(width, height);
    let (right, below) = ((x / 2 + x % 2).min(grid_width - 1), (y / 2 + y % 2).min(grid_height - 1));
    let cells = [(x / 2, y / 2), (right, y / 2), (x / 2, below), (right, below)];
    let used = match (x % 2, y % 2) {
        (0, 0) => &cells[..1],
        (1, 0) => &cells[..2],
        (0, _) => &[cells[0], cells[2]],
        _ => &cells[..],
    };
    let (guides, grid) = (of.guides, of.grid);
    let mut sum = Spectrum::BLACK;
    let mut weights = 0.0;
    for &(cx, cy) in used {
        let cell = cy * grid_width + cx;
        if of.indirect.count[cell] <= 0.0 || grid.key[cell] != guides.key[i] {
            continue;
        }
        let dot: f32 = (0..3).map(|a| guides.normal[a][i] * grid.normal[a][cell]).sum();
        let off = (guides.near[i] - grid.near[cell]).abs() / (0.1 * guides.near[i]).max(1e-30);
        let w = (dot.max(0.0) * dot.max(0.0)) * (1.0 - off).max(0.0) + 1e-4;
        sum += at(of.indirect, cell) * w;
        weights += w;
    }
    if weights > 0.0 { sum * (1.0 / weights) } else { ambient }
}
