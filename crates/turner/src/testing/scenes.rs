//! Scenes made in code, and means of their pictures: for the tests that stand beside integrators, lights and materials.

use super::{CompareOptions, Estimate, Reference, Runs, compare, render_runs};
use crate::camera::{CameraDesc, PinholeDesc};
use crate::color::Spectrum;
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::Antialias;
use crate::integrator::IntegratorDesc;
use crate::light::LightDesc;
use crate::material::{MaterialDesc, PrincipledMaterial};
use crate::math::DVec3;
use crate::schema::{ColorSource, MaterialId, PrepareOptions};
use crate::shape::ShapeDesc;

/// A point or a direction.
pub(crate) fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// The same number in all bands.
pub(crate) fn grey(value: f64) -> ColorSource {
    rgb([value; 3])
}

/// The same colour everywhere.
pub(crate) fn rgb([r, g, b]: [f64; 3]) -> ColorSource {
    ColorSource::Constant(Spectrum::new(r as f32, g as f32, b as f32))
}

/// A Lambertian surface and nothing else.
pub(crate) fn matte(color: ColorSource) -> PrincipledMaterial {
    PrincipledMaterial { base_color: color, specular_weight: grey(0.0), ..PrincipledMaterial::default() }
}

/// A surface that shines and reflects nothing.
pub(crate) fn shining(luminance: f64, color: ColorSource) -> PrincipledMaterial {
    PrincipledMaterial {
        base_weight: grey(0.0),
        specular_weight: grey(0.0),
        emission_luminance: luminance,
        emission_color: color,
        ..PrincipledMaterial::default()
    }
}

/// An empty scene whose light is computed so.
pub(crate) fn scene(integrator: IntegratorDesc) -> SceneDesc {
    SceneDesc { integrator, ..SceneDesc::default() }
}

impl SceneDesc {
    /// Seen by this camera.
    pub(crate) fn seen(mut self, camera: PinholeDesc) -> SceneDesc {
        self.camera = Some(CameraDesc::Pinhole(camera).into());
        self
    }

    /// Seen from 0.2 above the origin, straight down at it: all pixels look at the same point.
    pub(crate) fn seen_down(self) -> SceneDesc {
        self.seen_down_from(0.2)
    }

    /// The same from another height.
    pub(crate) fn seen_down_from(self, height: f64) -> SceneDesc {
        self.seen(PinholeDesc {
            position: v(0.0, height, 0.0),
            up: v(0.0, 0.0, -1.0),
            fov: Some(0.001),
            ..PinholeDesc::default()
        })
    }

    /// With a light.
    pub(crate) fn lit(mut self, light: LightDesc) -> SceneDesc {
        self.lights.push(light.into());
        self
    }

    /// With a shape of a material of its own.
    pub(crate) fn with(self, shape: ShapeDesc, material: PrincipledMaterial) -> SceneDesc {
        self.with_object(ObjectDesc::new(shape), material)
    }

    /// With an object of a material of its own.
    pub(crate) fn with_object(mut self, object: ObjectDesc, material: PrincipledMaterial) -> SceneDesc {
        let id = MaterialId(self.materials.len() as u32);
        self.materials.push(MaterialDesc::Principled(material).into());
        self.objects.push(ObjectDesc { material: Some(id), ..object });
        self
    }
}

/// Independent renders of one scene.
#[derive(Clone, Debug)]
pub(crate) struct Mean(Runs);

/// Runs of a scene of which all pixels look at the same thing.
const RUNS: u32 = 8;

/// Of 6 × 6 pixels.
pub(crate) fn mean(samples: u32, desc: SceneDesc) -> Mean {
    mean_of(6, samples, desc)
}

/// Of that many rows and columns.
pub(crate) fn mean_of(size: u32, samples: u32, mut desc: SceneDesc) -> Mean {
    [desc.film.width, desc.film.height] = [size, size];
    desc.film.antialias = Antialias::MonteCarlo;
    desc.film.samples = samples;
    let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
    let runs = render_runs(&prepared, RUNS, 7, 2).unwrap();
    assert_eq!(runs.non_finite.count, 0);
    Mean(runs)
}

/// How probable chance must be to count as chance: of some hundred comparisons, one in a thousand runs fails with other seeds.
const LEVEL: f64 = 1e-5;

impl Mean {
    /// In the three bands.
    pub(crate) fn value(&self) -> [f64; 3] {
        [0, 1, 2].map(|band| self.0.mean(band).mean)
    }

    pub(crate) fn alpha(&self) -> f64 {
        self.0.alpha
    }

    /// The colour everywhere, with a standard error of no more than `cap` times its value: a noisy test cannot pass.
    #[track_caller]
    pub(crate) fn is(&self, expected: [f64; 3], cap: f64) {
        let (width, height) = self.0.size();
        self.matches(&Reference::constant(width, height, expected), cap);
    }

    #[track_caller]
    pub(crate) fn is_grey(&self, expected: f64, cap: f64) {
        self.is([expected; 3], cap);
    }

    #[track_caller]
    fn matches(&self, other: &dyn Estimate, cap: f64) {
        // Sums of colours are of single precision.
        let options = CompareOptions { tolerance: 4e-6, absolute: 1e-9, ..CompareOptions::default() };
        let found = compare(&self.0, other, &options);
        assert!(found.ratio_error <= cap + 1e-6, "too noisy: {found:?}");
        assert!(found.p_value > LEVEL, "{found:?}");
    }
}
