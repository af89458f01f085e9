//! Embree scenes: one mesh, or instances of meshes.

use std::ffi::c_int;
use std::sync::Arc;

use turner_bvh::Ray;

use crate::device::DeviceInner;
use crate::ffi::{self, Object, RtcHit, RtcRay, RtcRayHit};
use crate::{Device, EmbreeError};

/// `RTCBuildQuality`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// A BVH by Morton codes.
    Low,
    /// Binned SAH, Embree's default.
    Medium,
    /// SAH with spatial splits.
    High,
}

/// How to build a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneOptions {
    /// Build quality.
    pub quality: Quality,
    /// `RTC_SCENE_FLAG_ROBUST`: watertight.
    pub robust: bool,
}

/// The nearest hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The ray parameter; infinite on a miss.
    pub t: f32,
    /// Barycentric coordinate of the second vertex.
    pub u: f32,
    /// Barycentric coordinate of the third vertex.
    pub v: f32,
    /// Index of the triangle; `u32::MAX` on a miss.
    pub primitive: u32,
    /// Index of the instance; `u32::MAX` on a miss and in a scene without instances.
    pub instance: u32,
}

impl Hit {
    /// A miss.
    pub const MISS: Hit = Hit { t: f32::INFINITY, u: 0.0, v: 0.0, primitive: u32::MAX, instance: u32::MAX };
}

/// An indexed triangle mesh.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'a> {
    /// Vertices.
    pub positions: &'a [[f32; 3]],
    /// Three vertex indices each.
    pub triangles: &'a [[u32; 3]],
}

/// An instance of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    /// Index of the mesh.
    pub mesh: u32,
    /// Object-to-world transform: the rows of a 3x4 matrix.
    pub transform: [[f32; 4]; 3],
}

/// A mesh as Embree reads it. Scenes built over it keep it in memory.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// Has one extra vertex, because Embree reads 16 bytes at the last one.
    positions: Arc<Vec<[f32; 3]>>,
    triangles: Arc<Vec<[u32; 3]>>,
}

impl Geometry {
    /// Copies a mesh.
    pub fn new(mesh: Mesh<'_>) -> Result<Geometry, EmbreeError> {
        let count = mesh.positions.len();
        if let Some(&index) = mesh.triangles.iter().flatten().find(|&&i| i as usize >= count) {
            return Err(EmbreeError::Index { index, count });
        }
        let positions = mesh.positions.iter().copied().chain([[0.0; 3]]).collect();
        Ok(Geometry { positions: Arc::new(positions), triangles: Arc::new(mesh.triangles.to_vec()) })
    }
}

/// A built scene.
#[derive(Debug)]
pub struct Scene {
    pub(crate) device: Arc<DeviceInner>,
    pub(crate) object: Object,
    bytes: usize,
    /// Data that the scene reads; dropped after the scene is released.
    _geometry: Option<Geometry>,
    _parts: Vec<Arc<Scene>>,
}

// SAFETY: a committed scene may be used and released from any thread.
unsafe impl Send for Scene {}
// SAFETY: as above; tracing a committed scene is thread-safe, and nothing here changes one.
unsafe impl Sync for Scene {}

impl Scene {
    /// Builds the BVH of a mesh. The buffers of `geometry` are shared, not copied, so the call measures the build
    /// alone.
    pub fn build(device: &Device, geometry: &Geometry, options: SceneOptions) -> Result<Scene, EmbreeError> {
        let before = device.bytes();
        let mut scene = Scene::new(device, options);
        let functions = &scene.device.functions;
        // SAFETY: device, scene and geometry are alive; both buffers have the given lengths, with 16 readable bytes at
        // the last vertex; all indices are in range; and `_geometry` keeps both until the scene is released.
        unsafe {
            let object = (functions.new_geometry)(scene.device.object, ffi::GEOMETRY_TRIANGLE);
            (functions.geometry_quality)(object, quality(options.quality));
            (functions.geometry_buffer)(
                object,
                ffi::BUFFER_VERTEX,
                0,
                ffi::FORMAT_FLOAT3,
                geometry.positions.as_ptr().cast(),
                0,
                size_of::<[f32; 3]>(),
                geometry.positions.len() - 1,
            );
            (functions.geometry_buffer)(
                object,
                ffi::BUFFER_INDEX,
                0,
                ffi::FORMAT_UINT3,
                geometry.triangles.as_ptr().cast(),
                0,
                size_of::<[u32; 3]>(),
                geometry.triangles.len(),
            );
            (functions.commit_geometry)(object);
            (functions.attach_geometry)(scene.object, object, 0);
            (functions.release_geometry)(object);
        }
        scene._geometry = Some(geometry.clone());
        scene.commit(device, before)
    }

    /// Builds the BVH over instances of scenes that are already built.
    pub fn instances(
        device: &Device,
        parts: &[Arc<Scene>],
        instances: &[Instance],
        options: SceneOptions,
    ) -> Result<Scene, EmbreeError> {
        let before = device.bytes();
        let mut scene = Scene::new(device, options);
        scene._parts = parts.to_vec();
        let functions = &scene.device.functions;
        for (id, instance) in (0..).zip(instances) {
            let count = parts.len();
            let part = parts
                .get(instance.mesh as usize)
                .ok_or(EmbreeError::Index { index: instance.mesh, count })?;
            // SAFETY: all objects are alive, and `_parts` keeps the instanced ones; a transform of this format is read
            // immediately: twelve numbers.
            unsafe {
                let object = (functions.new_geometry)(scene.device.object, ffi::GEOMETRY_INSTANCE);
                (functions.geometry_scene)(object, part.object);
                let matrix = instance.transform.as_ptr().cast();
                (functions.geometry_transform)(object, 0, ffi::FORMAT_FLOAT3X4_ROW_MAJOR, matrix);
                (functions.commit_geometry)(object);
                (functions.attach_geometry)(scene.object, object, id);
                (functions.release_geometry)(object);
            }
        }
        scene.commit(device, before)
    }

    /// An empty scene.
    fn new(device: &Device, options: SceneOptions) -> Scene {
        let device = Arc::clone(&device.inner);
        // SAFETY: the device is alive, and so is the scene it returns.
        let object = unsafe {
            let object = (device.functions.new_scene)(device.object);
            (device.functions.scene_quality)(object, quality(options.quality));
            (device.functions.scene_flags)(object, if options.robust { ffi::SCENE_ROBUST } else { 0 });
            object
        };
        Scene { device, object, bytes: 0, _geometry: None, _parts: Vec::new() }
    }

    fn commit(mut self, device: &Device, before: usize) -> Result<Scene, EmbreeError> {
        // SAFETY: scene and buffers are alive.
        unsafe { (self.device.functions.commit_scene)(self.object) };
        self.device.check()?;
        self.bytes = device.bytes().saturating_sub(before);
        Ok(self)
    }

    /// Bytes that the device allocated for this scene and still holds, without the instanced scenes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The nearest hit: `rtcIntersect1`.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Hit {
        let mut query = RtcRayHit { ray: single(ray), hit: NO_HIT };
        // SAFETY: the scene is committed; the structure has the right size and alignment; null arguments are allowed.
        unsafe { (self.device.functions.intersect_1)(self.object, &mut query, std::ptr::null_mut()) };
        let RtcRayHit { ray, hit } = query;
        if hit.geometry == ffi::INVALID {
            return Hit::MISS;
        }
        Hit { t: ray.t_far, u: hit.u, v: hit.v, primitive: hit.primitive, instance: hit.instance }
    }

    /// Whether anything is hit: `rtcOccluded1`.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        let mut query = single(ray);
        // SAFETY: as in `intersect`.
        unsafe { (self.device.functions.occluded_1)(self.object, &mut query, std::ptr::null_mut()) };
        // Embree reports a hit as t_far = -inf.
        query.t_far == f32::NEG_INFINITY
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: this is the only reference from `rtcNewScene`.
        unsafe { (self.device.functions.release_scene)(self.object) };
    }
}

const NO_HIT: RtcHit = RtcHit {
    normal: [0.0; 3],
    u: 0.0,
    v: 0.0,
    primitive: ffi::INVALID,
    geometry: ffi::INVALID,
    instance: ffi::INVALID,
    instance_primitive: ffi::INVALID,
};

#[inline]
fn single(ray: &Ray) -> RtcRay {
    RtcRay {
        origin: ray.origin,
        t_near: ray.t_min,
        direction: ray.direction,
        time: 0.0,
        t_far: ray.t_max,
        mask: u32::MAX,
        id: 0,
        flags: 0,
    }
}

fn quality(quality: Quality) -> c_int {
    match quality {
        Quality::Low => 0,
        Quality::Medium => 1,
        Quality::High => 2,
    }
}
