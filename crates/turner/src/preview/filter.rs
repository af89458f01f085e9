//! A filter that stops at edges: à-trous passes of 3 x 3 taps, further apart from pass to pass (Dammertz et al. 2010,
//! "Edge-avoiding À-Trous wavelet transform for fast global illumination filtering").
//!
//! ```text
//!  pass 1   pass 2     pass 3          weight of a tap = kernel · samples there
//!   ***     * * *     *   *   *              · max(0, n·n')^8
//!   ***                                      · max(0, 1 − |distance from the pixel's plane| / tolerance)
//!   ***     * * *     *   *   *              · [same key]
//! ```
//!
//! 1 / path length is linear over a plane, so the distance from the plane is that from a linear function of the position.

use turner_bvh::InstructionSet;
use turner_bvh::lanes::{Simd, Work, dispatch};

use crate::preview::buffers::{Guides, Light, LightPart};

/// One pass over rows of a picture.
pub(super) struct Pass<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) guides: &'a Guides,
    pub(super) from: &'a Light,
    /// Distance between taps.
    pub(super) step: usize,
    /// Whether smooth surfaces are filtered less.
    pub(super) by_roughness: bool,
    /// Pixels of the picture from one of these to the next.
    pub(super) pixels: usize,
}

/// Scratch memory of one thread.
#[derive(Default)]
pub(super) struct FilterRow {
    slopes: [Vec<f32>; 2],
    tolerance: Vec<f32>,
    sums: [Vec<f32>; 4],
    /// Sum of the weights without the numbers of samples.
    weights: Vec<f32>,
}

impl FilterRow {
    fn resize(&mut self, width: usize) {
        let [x, y] = &mut self.slopes;
        let [r, g, b, w] = &mut self.sums;
        for row in [x, y, r, g, b, w, &mut self.weights, &mut self.tolerance] {
            row.clear();
            row.resize(width, 0.0);
        }
    }
}

/// Pixels over which a rough surface of roughness 1 may be filtered.
const REACH: f32 = 20.0;

/// Relative tolerance of the distance from a plane, for each pixel between taps.
const TOLERANCE: f32 = 0.02;

impl Pass<'_> {
    /// Filters rows from `first` on.
    pub(super) fn rows(
        &self,
        set: InstructionSet,
        first: usize,
        to: &mut LightPart<'_>,
        scratch: &mut FilterRow,
    ) {
        scratch.resize(self.width);
        dispatch(set, Rows { pass: self, first, to, scratch });
    }
}

struct Rows<'a, 'b> {
    pass: &'a Pass<'a>,
    first: usize,
    to: &'a mut LightPart<'b>,
    scratch: &'a mut FilterRow,
}

impl Work for Rows<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Rows { pass, first, to, scratch } = self;
        let width = pass.width;
        for i in 0..to.count.len() / width {
            prepare_row(pass, first + i, scratch);
            for dy in [-1i32, 0, 1] {
                let y = (first + i) as i64 + i64::from(dy) * pass.step as i64;
                if y < 0 || y >= pass.height as i64 {
                    continue;
                }
                for dx in [-1i32, 0, 1] {
                    tap(pass, first + i, y as usize, [dx, dy], scratch);
                }
            }
            finish_row(pass, first + i, i, to, scratch);
        }
    }
}

/// The slopes of 1 / length, and the tolerance.
#[inline(always)]
fn prepare_row(pass: &Pass<'_>, y: usize, scratch: &mut FilterRow) {
    let (width, near) = (pass.width, &pass.guides.near[..]);
    let row = &near[y * width..][..width];
    let above = &near[y.saturating_sub(1) * width..][..width];
    let below = &near[(y + 1).min(pass.height - 1) * width..][..width];
    let [slopes_x, slopes_y] = &mut scratch.slopes;
    let (slopes_x, slopes_y) = (&mut slopes_x[..width], &mut slopes_y[..width]);
    let tolerance = &mut scratch.tolerance[..width];
    for x in 0..width {
        let (a, b) = (row[x] - above[x], below[x] - row[x]);
        slopes_y[x] = if a.abs() < b.abs() { a } else { b };
        tolerance[x] = 1.0 / (TOLERANCE * row[x] * pass.step as f32).max(1e-30);
    }
    if y == 0 || y + 1 == pass.height {
        for x in 0..width {
            slopes_y[x] = if y == 0 { below[x] - row[x] } else { row[x] - above[x] };
        }
    }
    for x in 1..width.saturating_sub(1) {
        let (a, b) = (row[x] - row[x - 1], row[x + 1] - row[x]);
        slopes_x[x] = if a.abs() < b.abs() { a } else { b };
    }
    if width > 1 {
        slopes_x[0] = row[1] - row[0];
        slopes_x[width - 1] = row[width - 1] - row[width - 2];
    }
    for sums in scratch.sums.iter_mut().chain([&mut scratch.weights]) {
        sums.fill(0.0);
    }
}

/// Adds one tap to all pixels of a row.
#[inline(always)]
fn tap(pass: &Pass<'_>, y: usize, yq: usize, [dx, dy]: [i32; 2], scratch: &mut FilterRow) {
    let (width, step) = (pass.width, pass.step);
    // Pixels p = low.. and their taps q = p + dx · step.
    let (low, low_q) = match dx {
        -1 => (step, 0),
        0 => (0, 0),
        _ => (0, step),
    };
    let Some(count) = width.checked_sub(step * usize::from(dx != 0)).filter(|n| *n > 0) else { return };
    let kernel = [2.0f32, 1.0][usize::from(dx != 0)] * [2.0f32, 1.0][usize::from(dy != 0)];
    let guides = pass.guides;
    let (at, at_q) = (y * width + low, yq * width + low_q);
    let [nx, ny, nz] = &guides.normal;
    let (px, py, pz) = (&nx[at..][..count], &ny[at..][..count], &nz[at..][..count]);
    let (qx, qy, qz) = (&nx[at_q..][..count], &ny[at_q..][..count], &nz[at_q..][..count]);
    let (near_p, near_q) = (&guides.near[at..][..count], &guides.near[at_q..][..count]);
    let (key_p, key_q) = (&guides.key[at..][..count], &guides.key[at_q..][..count]);
    let samples = &pass.from.count[at_q..][..count];
    let [r, g, b] = &pass.from.rgb;
    let (r, g, b) = (&r[at_q..][..count], &g[at_q..][..count], &b[at_q..][..count]);
    let [slopes_x, slopes_y] = &scratch.slopes;
    let (slopes_x, slopes_y) = (&slopes_x[low..][..count], &slopes_y[low..][..count]);
    let tolerance = &scratch.tolerance[low..][..count];
    let [sr, sg, sb, sw] = &mut scratch.sums;
    let (sr, sg, sb, sw) =
        (&mut sr[low..][..count], &mut sg[low..][..count], &mut sb[low..][..count], &mut sw[low..][..count]);
    let weights = &mut scratch.weights[low..][..count];
    let (fx, fy) = (dx as f32 * step as f32, dy as f32 * step as f32);
    for i in 0..count {
        let dot = px[i] * qx[i] + py[i] * qy[i] + pz[i] * qz[i];
        let dot = if dot > 0.0 { dot } else { 0.0 };
        let d2 = dot * dot;
        let d4 = d2 * d2;
        let off = (near_q[i] - near_p[i] - slopes_x[i] * fx - slopes_y[i] * fy).abs() * tolerance[i];
        let close = if off < 1.0 { 1.0 - off } else { 0.0 };
        let same = if key_p[i] == key_q[i] { kernel } else { 0.0 };
        let w = d4 * d4 * close * same;
        let ws = w * samples[i];
        sr[i] += ws * r[i];
        sg[i] += ws * g[i];
        sb[i] += ws * b[i];
        sw[i] += ws;
        weights[i] += w;
    }
}

#[inline(always)]
fn finish_row(pass: &Pass<'_>, y: usize, i: usize, to: &mut LightPart<'_>, scratch: &FilterRow) {
    let (width, at) = (pass.width, pass.width * i);
    let [sr, sg, sb, sw] = &scratch.sums;
    let [r, g, b] = &mut to.rgb;
    let (r, g, b) = (&mut r[at..][..width], &mut g[at..][..width], &mut b[at..][..width]);
    let count = &mut to.count[at..][..width];
    let (sr, sg, sb, sw) = (&sr[..width], &sg[..width], &sb[..width], &sw[..width]);
    let weights = &scratch.weights[..width];
    for x in 0..width {
        let k = 1.0 / sw[x].max(1e-20);
        (r[x], g[x], b[x]) = (sr[x] * k, sg[x] * k, sb[x] * k);
        count[x] = sw[x] / weights[x].max(1e-20);
    }
    if pass.by_roughness {
        let [fr, fg, fb] = &pass.from.rgb;
        let at = y * width;
        let (fr, fg, fb) = (&fr[at..][..width], &fg[at..][..width], &fb[at..][..width]);
        let own = &pass.from.count[at..][..width];
        let roughness = &pass.guides.roughness[at..][..width];
        let step = (pass.step * pass.pixels) as f32;
        for x in 0..width {
            // A pixel without a sample of its own takes those of its neighbours.
            let keep = if own[x] > 0.0 { (1.0 - REACH * roughness[x] / step).max(0.0) } else { 0.0 };
            r[x] += (fr[x] - r[x]) * keep;
            g[x] += (fg[x] - g[x]) * keep;
            b[x] += (fb[x] - b[x]) * keep;
        }
    }
}
