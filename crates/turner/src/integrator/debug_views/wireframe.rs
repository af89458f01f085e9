//! Edges of triangles, and lines of equal u and v on other shapes.
//!
//! The distance of a line from the camera ray, divided by the size of a pixel at the hit, gives its distance in
//! pixels. The coverage of the pixel follows from it, so lines are antialiased with one sample per pixel.

use super::{DebugView, FirstHit, opaque};
use crate::color::Spectrum;
use crate::integrator::{Radiance, RayStats};
use crate::math::{DVec2, DVec3, Ray};
use crate::scene::Scene;
use crate::schema::{Range, params};

params! {
    /// Shows the edges of triangles as antialiased lines of constant width in the image. Other shapes get lines
    /// of equal u and v, eight in each direction (on planes one per scene unit), which fade where they come too
    /// close. Surfaces are shaded by their angle to the viewer.
    pub struct WireframeDesc as "wireframe" {
        /// Width of the lines in pixels.
        width: f64 = 1.0, in Range { min: 0.0, open_min: true, max: 1000.0, open_max: false };
        /// Colour of the lines.
        line: Spectrum = Spectrum::BLACK;
        /// Colour of surfaces that face the viewer.
        fill: Spectrum = Spectrum::WHITE;
    }
    example r##"[integrator]
type = "wireframe"
width = 1.5
line = "#102040"
"##
}

impl DebugView for WireframeDesc {
    fn type_name(&self) -> &'static str {
        WireframeDesc::DOC.name
    }

    fn at_hit(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        let pixel = Pixel::of(hit);
        let drawn = match hit.scene.triangle_at(&hit.hit) {
            Some(corners) => self.edges(hit, &corners, &pixel),
            None => self.coordinate_lines(hit, &pixel),
        };
        let facing = hit.normal().dot(hit.ray.direction).abs() as f32;
        let fill = self.fill * (0.4 + 0.6 * facing);
        opaque(fill.lerp(self.line, drawn as f32))
    }

    fn at_miss(&self, scene: &Scene, _: &Ray) -> Radiance {
        if scene.background.transparent { super::TRANSPARENT } else { opaque(self.fill) }
    }
}

/// Ray differentials: how a camera ray changes from one pixel to the next.
struct Pixel {
    /// Per pixel to the right and down: the changes of the origin and of the unit direction.
    steps: [(DVec3, DVec3); 2],
    /// Width of a pixel at the hit, perpendicular to the ray.
    side: f64,
}

impl Pixel {
    fn of(hit: &FirstHit<'_>) -> Pixel {
        let film = &hit.view.film;
        let ray = |dx: f64, dy: f64| {
            let (x, y) = (f64::from(hit.id.x) + 0.5 + dx, f64::from(hit.id.y) + 0.5 + dy);
            let screen =
                DVec2::new(2.0 * x / f64::from(film.width) - 1.0, 1.0 - 2.0 * y / f64::from(film.height));
            let ray = hit.view.camera.ray(screen, DVec2::splat(0.5));
            (ray.origin, ray.direction.normalize())
        };
        let (o, d) = ray(0.0, 0.0);
        let steps = [ray(1.0, 0.0), ray(0.0, 1.0)].map(|(p, e)| (p - o, e - d));
        let t = hit.hit.shape.t;
        let across = steps.map(|(o, d)| {
            let step = o + t * d;
            (step - step.dot(hit.ray.direction) * hit.ray.direction).length()
        });
        Pixel { steps, side: (across[0] * across[1]).sqrt() }
    }

    /// The camera ray one pixel to the right (0) or down (1).
    fn neighbour(&self, ray: &Ray, i: usize) -> Ray {
        let (o, d) = self.steps[i];
        Ray { origin: ray.origin + o, direction: (ray.direction + d).normalize(), ..*ray }
    }
}

impl WireframeDesc {
    /// The fraction of a pixel that a line covers, by the distance of its centre line in pixels.
    fn covered(&self, distance: f64) -> f64 {
        // The overlap of line and pixel; lines thinner than a pixel become pale instead of broken.
        (0.5 * self.width + 0.5 - distance).clamp(0.0, 1.0).min(self.width)
    }

    /// The coverage of the nearest edge, by the distance between the ray and the edge's line, which is its
    /// distance in the image.
    fn edges(&self, hit: &FirstHit<'_>, corners: &[DVec3; 3], pixel: &Pixel) -> f64 {
        let distance = |i: usize| {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            let normal = hit.ray.direction.cross(b - a);
            let (distance, length) = ((a - hit.ray.origin).dot(normal).abs(), normal.length());
            if length > 0.0 { distance / length } else { (a - hit.surface.p).length() }
        };
        let nearest = (0..3).map(distance).fold(f64::INFINITY, f64::min);
        self.covered(nearest / pixel.side)
    }

    /// Lines of equal u and v. The rays of neighbouring pixels give their derivatives.
    fn coordinate_lines(&self, hit: &FirstHit<'_>, pixel: &Pixel) -> f64 {
        let scene = hit.scene;
        // On a plane, u and v change by 1 in two scene units.
        let unbounded = scene.is_unbounded(&hit.hit);
        let spacing = if unbounded { 0.5 } else { 0.125 };
        let uv = scene.texture_point(&hit.surface).uv;
        let mut change = DVec2::ZERO;
        for i in 0..2 {
            let ray = pixel.neighbour(&hit.ray, i);
            let Some(next_hit) = scene.intersect(&ray) else { continue };
            let same = scene.primitive_id(&next_hit) == scene.primitive_id(&hit.hit)
                && next_hit.shape.part == hit.hit.shape.part;
            if same {
                let next = scene.texture_point(&scene.surface(&ray, &next_hit)).uv;
                // Across a seam of u or v, use the shorter difference.
                let step = (next - uv).abs();
                let step = if unbounded { step } else { step.min((step - 1.0).abs()) };
                change += step * step;
            }
        }
        let line = |v: f64, change: f64| {
            if change <= 0.0 || change.is_nan() {
                return 0.0;
            }
            let off = v / spacing - (v / spacing).round();
            let apart = spacing / change;
            // Fades from a spacing of six line widths to two.
            let fade = ((apart / self.width.max(1.0) - 2.0) / 4.0).clamp(0.0, 1.0);
            fade * self.covered(off.abs() * apart)
        };
        line(uv.x, change.x.sqrt()).max(line(uv.y, change.y.sqrt()))
    }
}
