//! Properties of the first hit of a camera ray.

use crate::camera::CameraFrame;
use crate::color::Spectrum;
use crate::math::{DVec2, DVec3, Ray};
use crate::scene::{Hit, Scene, SurfaceInteraction};
use crate::view::View;

/// A camera ray and its first hit.
pub(super) struct AovHit<'a> {
    pub(super) scene: &'a Scene,
    pub(super) view: &'a View,
    pub(super) frame: &'a CameraFrame,
    pub(super) ray: Ray,
    pub(super) hit: Hit,
    pub(super) surface: SurfaceInteraction,
}

impl AovHit<'_> {
    /// The shading normal, towards the viewer.
    pub(super) fn normal(&self) -> DVec3 {
        if self.surface.ng.dot(self.ray.direction) > 0.0 { -self.surface.ns } else { self.surface.ns }
    }

    /// A direction in the axes of the camera: x right, y up, z towards the viewer.
    pub(super) fn in_camera(&self, v: DVec3) -> DVec3 {
        let v = match &self.view.motion {
            Some(motion) => motion.at(f64::from(self.ray.time)).inverse().transform_vector3(v),
            None => v,
        };
        DVec3::new(v.dot(self.frame.right), v.dot(self.frame.up), -v.dot(self.frame.forward))
    }

    /// Base colour of the material.
    pub(super) fn albedo(&self) -> Spectrum {
        let outside = self.surface.ng.dot(self.ray.direction) <= 0.0;
        self.scene.material_at(&self.hit).base_color(self.scene, &self.surface, outside)
    }

    /// Distance from the ray's origin along the viewing direction.
    pub(super) fn depth(&self) -> f64 {
        -self.in_camera(self.surface.p - self.ray.origin).z
    }

    /// Distance from the ray's origin.
    pub(super) fn distance(&self) -> f64 {
        (self.surface.p - self.ray.origin).length()
    }

    /// Texture coordinates.
    pub(super) fn uv(&self) -> [f64; 3] {
        let uv = self.scene.texture_point(&self.surface).uv;
        [uv.x, uv.y, 0.0]
    }

    /// Motion in the picture from the opening of the shutter to its closing, in pixels: x to the right, y up. 0 where
    /// the camera does not see both ends.
    pub(super) fn motion(&self) -> [f64; 3] {
        let film = &self.view.film;
        let ends = self.scene.ends_of_motion(&self.hit, self.surface.p, self.ray.time, film.shutter);
        let camera = self.view.motion.as_ref();
        let ends = match (ends, camera) {
            (None, None) => return [0.0; 3],
            (ends, _) => ends.unwrap_or([self.surface.p; 2]),
        };
        let seen = |(p, time): (DVec3, f64)| {
            let p = camera.map_or(p, |camera| camera.still(time, p));
            self.view.camera.project(film, p, DVec2::splat(0.5))
        };
        let [from, to] = ends;
        let (open, close) = (seen((from, film.shutter[0])), seen((to, film.shutter[1])));
        match (open, close) {
            (Some(open), Some(close)) => {
                let moved = close.place - open.place;
                [moved.x, -moved.y, 0.0]
            }
            _ => [0.0; 3],
        }
    }
}
