//! The part of Embree's C interface that Turner uses, from the headers of version 4.4.
//!
//! Structures are laid out for `RTC_MAX_INSTANCE_LEVEL_COUNT` = 1, as in Embree's releases. The optional fields
//! (`instPrimID`, `minWidthDistanceFactor`) come last, so a library built without them uses a prefix of the same
//! structure.

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::mem::ManuallyDrop;

pub(crate) const INVALID: u32 = u32::MAX;

pub(crate) const FORMAT_UINT3: c_int = 0x5003;
pub(crate) const FORMAT_FLOAT3: c_int = 0x9003;
pub(crate) const FORMAT_FLOAT3X4_ROW_MAJOR: c_int = 0x9134;

pub(crate) const BUFFER_INDEX: c_int = 0;
pub(crate) const BUFFER_VERTEX: c_int = 1;

pub(crate) const GEOMETRY_TRIANGLE: c_int = 0;
pub(crate) const GEOMETRY_INSTANCE: c_int = 121;

pub(crate) const SCENE_ROBUST: c_int = 1 << 2;

pub(crate) const PROPERTY_VERSION: c_int = 0;

pub(crate) const QUERY_COHERENT: c_int = 1 << 16;
pub(crate) const FEATURE_ALL: c_uint = u32::MAX;

/// An opaque object of the library.
pub(crate) type Object = *mut c_void;

#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(crate) struct RtcRay {
    pub(crate) origin: [f32; 3],
    pub(crate) t_near: f32,
    pub(crate) direction: [f32; 3],
    pub(crate) time: f32,
    pub(crate) t_far: f32,
    pub(crate) mask: u32,
    pub(crate) id: u32,
    pub(crate) flags: u32,
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(crate) struct RtcHit {
    pub(crate) normal: [f32; 3],
    pub(crate) u: f32,
    pub(crate) v: f32,
    pub(crate) primitive: u32,
    pub(crate) geometry: u32,
    pub(crate) instance: u32,
    pub(crate) instance_primitive: u32,
}

#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct RtcRayHit {
    pub(crate) ray: RtcRay,
    pub(crate) hit: RtcHit,
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct RtcRay16 {
    pub(crate) origin: [[f32; 16]; 3],
    pub(crate) t_near: [f32; 16],
    pub(crate) direction: [[f32; 16]; 3],
    pub(crate) time: [f32; 16],
    pub(crate) t_far: [f32; 16],
    pub(crate) mask: [u32; 16],
    pub(crate) id: [u32; 16],
    pub(crate) flags: [u32; 16],
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct RtcHit16 {
    pub(crate) normal: [[f32; 16]; 3],
    pub(crate) u: [f32; 16],
    pub(crate) v: [f32; 16],
    pub(crate) primitive: [u32; 16],
    pub(crate) geometry: [u32; 16],
    pub(crate) instance: [u32; 16],
    pub(crate) instance_primitive: [u32; 16],
}

#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct RtcRayHit16 {
    pub(crate) ray: RtcRay16,
    pub(crate) hit: RtcHit16,
}

// The sizes in the header's comments.
const _: () = assert!(size_of::<RtcRay>() == 48 && size_of::<RtcHit>() == 48 && size_of::<RtcRayHit>() == 96);
const _: () = assert!(size_of::<RtcRay16>() == 12 * 64 && size_of::<RtcHit16>() == 9 * 64);

/// `RTCIntersectArguments` and, with the same fields, `RTCOccludedArguments`.
#[derive(Debug)]
#[repr(C)]
pub(crate) struct RtcArguments {
    pub(crate) flags: c_int,
    pub(crate) feature_mask: c_uint,
    pub(crate) context: *mut c_void,
    pub(crate) filter: *mut c_void,
    pub(crate) function: *mut c_void,
    pub(crate) min_width_distance_factor: f32,
}

impl RtcArguments {
    pub(crate) const COHERENT: RtcArguments = RtcArguments {
        flags: QUERY_COHERENT,
        feature_mask: FEATURE_ALL,
        context: std::ptr::null_mut(),
        filter: std::ptr::null_mut(),
        function: std::ptr::null_mut(),
        min_width_distance_factor: 0.0,
    };
}

pub(crate) type MemoryMonitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;

/// Declares the function table and its loader.
macro_rules! functions {
    ($($field:ident = $symbol:literal: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions of the library. The library is never unloaded: its thread pool runs its code, and threads that
        /// have traced rays call it again when they end.
        #[derive(Debug)]
        pub(crate) struct Functions {
            $(pub(crate) $field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            _library: ManuallyDrop<libloading::Library>,
        }

        impl Functions {
            /// Finds all functions by name.
            ///
            /// # Safety
            ///
            /// Functions of these names must have the C types that Embree 4 declares.
            pub(crate) unsafe fn find(library: libloading::Library) -> Result<Functions, libloading::Error> {
                Ok(Functions {
                    // SAFETY: the caller guarantees the types, and the library is stored with the pointers.
                    $($field: unsafe { *library.get($symbol)? },)*
                    _library: ManuallyDrop::new(library),
                })
            }
        }
    };
}

functions! {
    new_device = b"rtcNewDevice": fn(*const c_char) -> Object;
    release_device = b"rtcReleaseDevice": fn(Object);
    device_property = b"rtcGetDeviceProperty": fn(Object, c_int) -> isize;
    device_error = b"rtcGetDeviceError": fn(Object) -> c_int;
    device_memory_monitor = b"rtcSetDeviceMemoryMonitorFunction": fn(Object, Option<MemoryMonitor>, *mut c_void);
    new_scene = b"rtcNewScene": fn(Object) -> Object;
    release_scene = b"rtcReleaseScene": fn(Object);
    scene_quality = b"rtcSetSceneBuildQuality": fn(Object, c_int);
    scene_flags = b"rtcSetSceneFlags": fn(Object, c_int);
    commit_scene = b"rtcCommitScene": fn(Object);
    attach_geometry = b"rtcAttachGeometryByID": fn(Object, Object, c_uint);
    new_geometry = b"rtcNewGeometry": fn(Object, c_int) -> Object;
    release_geometry = b"rtcReleaseGeometry": fn(Object);
    geometry_quality = b"rtcSetGeometryBuildQuality": fn(Object, c_int);
    geometry_buffer = b"rtcSetSharedGeometryBuffer":
        fn(Object, c_int, c_uint, c_int, *const c_void, usize, usize, usize);
    geometry_scene = b"rtcSetGeometryInstancedScene": fn(Object, Object);
    geometry_transform = b"rtcSetGeometryTransform": fn(Object, c_uint, c_int, *const c_void);
    commit_geometry = b"rtcCommitGeometry": fn(Object);
    intersect_1 = b"rtcIntersect1": fn(Object, *mut RtcRayHit, *mut RtcArguments);
    occluded_1 = b"rtcOccluded1": fn(Object, *mut RtcRay, *mut RtcArguments);
    intersect_16 = b"rtcIntersect16": fn(*const c_int, Object, *mut RtcRayHit16, *mut RtcArguments);
    occluded_16 = b"rtcOccluded16": fn(*const c_int, Object, *mut RtcRay16, *mut RtcArguments);
}
