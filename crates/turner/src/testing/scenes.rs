//! Scenes built in code and the means of their renders, for the tests of integrators, lights and materials.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::{CompareOptions, Estimate, Reference, Runs, compare, render_runs};
use crate::camera::{
    CameraDesc, EquirectangularDesc, FisheyeDesc, OrthographicDesc, PinholeDesc, RealisticDesc, ThinLensDesc,
};
use crate::color::{Spectrum, named};
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::{Antialias, Picture};
use crate::integrator::{IntegratorDesc, PathDesc, Prepared, RayStats};
use crate::light::{Attenuation, LightDesc, PointDesc};
use crate::material::{
    ClassicMaterial, DielectricMaterial, InterfaceMaterial, MaterialDesc, MetalMaterial, MixMaterial,
    PrincipledMaterial,
};
use crate::math::{DAffine3, DVec3};
use crate::medium::{HomogeneousMedium, MediumDesc, SmokeMedium};
use crate::render::{PassOptions, Renderer};
use crate::schema::transform::rotation;
use crate::schema::{
    Asset, ColorSource, MaterialId, MediumId, MeshData, MeshId, PrepareOptions, TextureId, Transform,
};
use crate::shape::{BoxDesc, MeshDesc, PlaneDesc, PointsDesc, RectangleDesc, ShapeDesc, SphereDesc};
use crate::texture::TextureDesc;

/// A point or a direction.
pub(crate) fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A grey colour source.
pub(crate) fn grey(value: f64) -> ColorSource {
    rgb([value; 3])
}

/// A constant colour source.
pub(crate) fn rgb([r, g, b]: [f64; 3]) -> ColorSource {
    ColorSource::Constant(Spectrum::new(r as f32, g as f32, b as f32))
}

/// A grey for parameters that take no texture.
pub(crate) fn even(value: f64) -> Option<Spectrum> {
    bands([value; 3])
}

/// A colour for parameters that take no texture.
pub(crate) fn bands([r, g, b]: [f64; 3]) -> Option<Spectrum> {
    Some(Spectrum::new(r as f32, g as f32, b as f32))
}

/// A named colour.
pub(crate) fn called(name: &str) -> ColorSource {
    ColorSource::Constant(named(name).unwrap())
}

/// A Lambertian surface without a specular lobe.
pub(crate) fn matte(color: ColorSource) -> PrincipledMaterial {
    PrincipledMaterial { base_color: color, specular_weight: grey(0.0), ..PrincipledMaterial::default() }
}

/// A surface that emits and does not reflect.
pub(crate) fn emissive(luminance: f64, color: ColorSource) -> PrincipledMaterial {
    PrincipledMaterial {
        base_weight: grey(0.0),
        specular_weight: grey(0.0),
        emission_luminance: luminance,
        emission_color: color,
        ..PrincipledMaterial::default()
    }
}

/// A point light that falls off with 1/d².
pub(crate) fn lamp(position: DVec3, intensity: f64) -> LightDesc {
    let attenuation = Attenuation { coefficients: [0.0, 0.0, 1.0] };
    LightDesc::Point(PointDesc { position, intensity, attenuation, ..PointDesc::default() })
}

/// Conversions from descriptions to their families.
macro_rules! kinds {
    ($($family:ident::$variant:ident($kind:ty),)*) => {
        $(impl From<$kind> for $family {
            fn from(value: $kind) -> $family {
                $family::$variant(value)
            }
        })*
    };
}

kinds! {
    CameraDesc::Pinhole(PinholeDesc),
    CameraDesc::Orthographic(OrthographicDesc),
    CameraDesc::ThinLens(ThinLensDesc),
    CameraDesc::Equirectangular(EquirectangularDesc),
    CameraDesc::Fisheye(FisheyeDesc),
    CameraDesc::Realistic(RealisticDesc),
    MaterialDesc::Classic(ClassicMaterial),
    MaterialDesc::Metal(MetalMaterial),
    MaterialDesc::Mix(MixMaterial),
    MaterialDesc::Principled(PrincipledMaterial),
    MaterialDesc::Dielectric(DielectricMaterial),
    MaterialDesc::Interface(InterfaceMaterial),
    MediumDesc::Homogeneous(HomogeneousMedium),
    MediumDesc::Smoke(SmokeMedium),
}

/// An empty scene with this integrator.
pub(crate) fn scene(integrator: IntegratorDesc) -> SceneDesc {
    SceneDesc { integrator, ..SceneDesc::default() }
}

/// An empty scene for path tracing.
pub(crate) fn path(desc: PathDesc) -> SceneDesc {
    scene(IntegratorDesc::Path(desc))
}

pub(crate) fn sphere(center: DVec3, radius: f64) -> ShapeDesc {
    ShapeDesc::Sphere(SphereDesc { center, radius })
}

pub(crate) fn rectangle(center: DVec3, edge_u: DVec3, edge_v: DVec3) -> ShapeDesc {
    ShapeDesc::Rectangle(RectangleDesc { center, edge_u, edge_v })
}

/// A box between two corners.
pub(crate) fn cuboid(min: DVec3, max: DVec3) -> ShapeDesc {
    ShapeDesc::Box(BoxDesc { min: Some(min), max: Some(max), ..BoxDesc::default() })
}

/// The ground plane.
pub(crate) fn plane() -> ShapeDesc {
    ShapeDesc::Plane(PlaneDesc::default())
}

/// A shape with a transform.
pub(crate) fn placed(shape: ShapeDesc, transform: DAffine3) -> ObjectDesc {
    ObjectDesc { transform: Transform(transform), ..ObjectDesc::new(shape) }
}

/// A rotation about x, then y, then z, in degrees.
pub(crate) fn turned(x: f64, y: f64, z: f64) -> DAffine3 {
    let about = |axis, degrees| DAffine3::from_mat3(rotation(axis, degrees));
    about(DVec3::Z, z) * about(DVec3::Y, y) * about(DVec3::X, x)
}

impl SceneDesc {
    /// With this camera.
    pub(crate) fn seen(mut self, camera: impl Into<CameraDesc>) -> SceneDesc {
        self.camera = Some(camera.into().into());
        self
    }

    /// With a camera 0.2 above the origin that looks straight down: all pixels see nearly the same point.
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

    /// With a light added.
    pub(crate) fn lit(mut self, light: LightDesc) -> SceneDesc {
        self.lights.push(light.into());
        self
    }

    /// With a shape and a material of its own.
    pub(crate) fn with(self, shape: ShapeDesc, material: impl Into<MaterialDesc>) -> SceneDesc {
        self.with_object(ObjectDesc::new(shape), material)
    }

    /// With an object and a material of its own.
    pub(crate) fn with_object(mut self, object: ObjectDesc, material: impl Into<MaterialDesc>) -> SceneDesc {
        let id = MaterialId(self.materials.len() as u32);
        self.materials.push(material.into().into());
        self.objects.push(ObjectDesc { material: Some(id), ..object });
        self
    }

    /// With a camera on the z axis that looks at the origin.
    pub(crate) fn seen_from_front(self, distance: f64, fov: f64) -> SceneDesc {
        self.seen_at(v(0.0, 0.0, distance), DVec3::ZERO, fov)
    }

    /// With a camera at one point that looks at another.
    pub(crate) fn seen_at(self, position: DVec3, look_at: DVec3, fov: f64) -> SceneDesc {
        self.seen(PinholeDesc { position, look_at, fov: Some(fov), ..PinholeDesc::default() })
    }

    /// With an emissive grey background.
    pub(crate) fn before(mut self, grey: f64) -> SceneDesc {
        self.background.color = Spectrum::grey(grey as f32);
        self
    }

    /// Adds a material, for objects and mixes.
    pub(crate) fn material(&mut self, material: MaterialDesc) -> MaterialId {
        self.materials.push(material.into());
        MaterialId(self.materials.len() as u32 - 1)
    }

    /// With a shape of an existing material.
    pub(crate) fn with_shared(mut self, shape: ShapeDesc, material: MaterialId) -> SceneDesc {
        self.objects.push(ObjectDesc { material: Some(material), ..ObjectDesc::new(shape) });
        self
    }

    /// Adds a texture; returns it as a colour source.
    pub(crate) fn texture(&mut self, texture: TextureDesc) -> ColorSource {
        self.textures.push(texture.into());
        ColorSource::Texture(TextureId(self.textures.len() as u32 - 1))
    }

    /// Adds a mesh; returns it as a shape.
    pub(crate) fn mesh(&mut self, data: MeshData) -> ShapeDesc {
        self.meshes.push(Asset { uri: String::new(), data: Arc::new(data) });
        ShapeDesc::Mesh(MeshDesc { mesh: MeshId(self.meshes.len() as u32 - 1), ..MeshDesc::default() })
    }

    /// With this film size and number of random samples per pixel.
    pub(crate) fn filmed(self, size: [u32; 2], samples: u32) -> SceneDesc {
        let mut desc = self.sized(size);
        (desc.film.antialias, desc.film.samples) = (Antialias::MonteCarlo, samples);
        desc
    }

    /// With this film size.
    pub(crate) fn sized(mut self, [width, height]: [u32; 2]) -> SceneDesc {
        (self.film.width, self.film.height) = (width, height);
        self
    }

    /// Adds a point cloud; returns it as a shape.
    pub(crate) fn points(&mut self, positions: Vec<[f32; 3]>, radii: Vec<f32>) -> ShapeDesc {
        let data = MeshData { positions, ..MeshData::default() };
        self.meshes.push(Asset { uri: String::new(), data: Arc::new(data) });
        ShapeDesc::Points(PointsDesc { points: MeshId(self.meshes.len() as u32 - 1), radius: None, radii })
    }

    /// Adds a medium, for the inside of a shape.
    pub(crate) fn medium(&mut self, medium: impl Into<MediumDesc>) -> Option<MediumId> {
        self.media.push(medium.into().into());
        Some(MediumId(self.media.len() as u32 - 1))
    }

    /// Adds an interface material around a medium.
    pub(crate) fn boundary(&mut self, medium: impl Into<MediumDesc>) -> MaterialId {
        let interior = self.medium(medium);
        self.material(InterfaceMaterial { interior }.into())
    }

    /// With a medium in a shape that has no surface.
    pub(crate) fn filled(mut self, shape: ShapeDesc, medium: impl Into<MediumDesc>) -> SceneDesc {
        let boundary = self.boundary(medium);
        self.with_shared(shape, boundary)
    }

    /// With a medium that fills the open space.
    pub(crate) fn in_fog(mut self, medium: HomogeneousMedium) -> SceneDesc {
        self.background.medium = self.medium(medium);
        self
    }

    /// With a shape of the default material.
    pub(crate) fn with_default(mut self, shape: ShapeDesc) -> SceneDesc {
        self.objects.push(ObjectDesc::new(shape));
        self
    }

    /// With an emissive background of this colour.
    pub(crate) fn before_color(mut self, color: [f64; 3]) -> SceneDesc {
        self.background.color = bands(color).unwrap_or_default();
        self
    }
}

/// Renders with two threads.
pub(crate) fn render(desc: &SceneDesc) -> (Picture, RayStats) {
    render_with(desc, 2, u32::MAX)
}

/// Renders with this many threads and samples per pass.
pub(crate) fn render_with(desc: &SceneDesc, threads: usize, pass: u32) -> (Picture, RayStats) {
    render_prepared(
        desc.prepare(&PrepareOptions { threads, ..PrepareOptions::default() }).unwrap(),
        threads,
        pass,
    )
}

/// The same for a prepared scene.
pub(crate) fn render_prepared(scene: Prepared, threads: usize, pass: u32) -> (Picture, RayStats) {
    let mut renderer = Renderer::new(scene).unwrap();
    let cancel = AtomicBool::new(false);
    while !renderer.is_complete() {
        assert!(renderer.pass(pass, &PassOptions { threads, cancel: &cancel, progress: None }).unwrap());
    }
    assert_eq!(renderer.film.non_finite.count, 0);
    (renderer.develop(), renderer.stats)
}

pub(crate) fn pixel(picture: &Picture, x: u32, y: u32) -> [f32; 3] {
    let [r, g, b, _] = picture.linear[(y * picture.width + x) as usize];
    [r, g, b]
}

/// Independent renders of one scene.
#[derive(Clone, Debug)]
pub(crate) struct Mean(Runs);

/// Runs of a scene in which all pixels see the same.
const RUNS: u32 = 8;

/// Renders 6 x 6 pixels.
pub(crate) fn mean(samples: u32, desc: SceneDesc) -> Mean {
    mean_of(6, samples, desc)
}

/// Renders `size` x `size` pixels.
pub(crate) fn mean_of(size: u32, samples: u32, desc: SceneDesc) -> Mean {
    let prepared = desc.filmed([size; 2], samples).prepare(&PrepareOptions::default()).unwrap();
    let runs = render_runs(&prepared, RUNS, 7, 2).unwrap();
    assert_eq!(runs.non_finite.count, 0);
    Mean(runs)
}

/// Smallest accepted p-value. With some hundred comparisons, one of a thousand runs with other seeds fails.
const LEVEL: f64 = 1e-5;

impl Mean {
    /// The mean of each channel.
    pub(crate) fn value(&self) -> [f64; 3] {
        [0, 1, 2].map(|band| self.0.mean(band).mean)
    }

    /// The standard error of each channel.
    pub(crate) fn error(&self) -> [f64; 3] {
        [0, 1, 2].map(|band| self.0.mean(band).error())
    }

    pub(crate) fn alpha(&self) -> f64 {
        self.0.alpha
    }

    /// Asserts that the picture has this colour everywhere. The standard error may be at most `cap` times the
    /// value, so that a noisy test cannot pass.
    #[track_caller]
    pub(crate) fn is(&self, expected: [f64; 3], cap: f64) {
        let (width, height) = self.0.size();
        self.matches(&Reference::constant(width, height, expected), cap);
    }

    #[track_caller]
    pub(crate) fn is_grey(&self, expected: f64, cap: f64) {
        self.is([expected; 3], cap);
    }

    /// Asserts that two renders estimate the same picture.
    #[track_caller]
    pub(crate) fn agrees(&self, other: &Mean, cap: f64) {
        self.matches(&other.0, cap);
    }

    #[track_caller]
    fn matches(&self, other: &dyn Estimate, cap: f64) {
        // Sums of colours have single precision.
        let options = CompareOptions { tolerance: 4e-6, absolute: 1e-9, ..CompareOptions::default() };
        let found = compare(&self.0, other, &options);
        assert!(found.ratio_error <= cap + 1e-6, "too noisy: {found:?}");
        assert!(found.p_value > LEVEL, "{found:?}");
    }
}
