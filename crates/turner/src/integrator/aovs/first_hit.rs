//! Properties of the first hit of a camera ray.

use crate::camera::CameraFrame;
use crate::color::Spectrum;
use crate::integrator::footprint;
use crate::math::{DVec2, DVec3, Ray, RayCone};
use crate::scene::{Hit, Scene, SurfaceInteraction};
use crate::view::View;

/// A camera ray and its first hit.
pub(super) struct AovHit<'a> {
    pub(super) scene: &'a Scene,
    pub(super) view: &'a View,
    pub(super) frame: &'a CameraFrame,
    pub(super) ray: Ray,
    pub(super) hit: Hit,
    /// The point, and the geometric and the shading normal there.
    pub(super) p: DVec3,
    pub(super) ng: DVec3,
    pub(super) ns: DVec3,
    /// The cone of the ray at its origin, where textures are filtered.
    pub(super) cone: Option<RayCone>,
}

impl AovHit<'_> {
    /// The shading normal, towards the viewer.
    pub(super) fn normal(&self) -> DVec3 {
        if self.ng.dot(self.ray.direction) > 0.0 { -self.ns } else { self.ns }
    }

    /// All about the surface, with the footprint of the ray.
    fn surface(&self) -> SurfaceInteraction {
        let mut surface = self.scene.surface(&self.ray, &self.hit);
        if let Some(mut cone) = self.cone {
            footprint::arrive(&mut cone, &mut surface, self.ray.direction, self.hit.shape.t);
        }
        surface
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
        let outside = self.ng.dot(self.ray.direction) <= 0.0;
        self.scene.material_at(&self.hit).base_color(self.scene, &self.surface(), outside)
    }

    /// Distance from the ray's origin along the viewing direction.
    pub(super) fn depth(&self) -> f64 {
        -self.in_camera(self.p - self.ray.origin).z
    }

    /// Distance from the ray's origin.
    pub(super) fn distance(&self) -> f64 {
        (self.p - self.ray.origin).length()
    }

    /// Texture coordinates.
    pub(super) fn uv(&self) -> [f64; 3] {
        let uv = self.scene.texture_point(&self.surface()).uv;
        [uv.x, uv.y, 0.0]
    }

    /// Motion in the picture from the opening of the shutter to its closing, in pixels: x to the right, y up. 0 where
    /// the camera does not see both ends.
    pub(super) fn motion(&self) -> [f64; 3] {
        let film = &self.view.film;
        let ends = self.scene.ends_of_motion(&self.hit, self.p, self.ray.time, film.shutter);
        let camera = self.view.motion.as_ref();
        let ends = match (ends, camera) {
            (None, None) => return [0.0; 3],
            (ends, _) => ends.unwrap_or([self.p; 2]),
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
