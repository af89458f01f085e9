//! Embree devices: threads and memory.

use std::ffi::{CString, c_int, c_void};
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering};

use crate::ffi::{self, Functions, Object};
use crate::{Embree, EmbreeError};

/// A device builds scenes with a fixed number of threads. Scenes keep their device alive.
#[derive(Clone, Debug)]
pub struct Device {
    pub(crate) inner: Arc<DeviceInner>,
}

#[derive(Debug)]
pub(crate) struct DeviceInner {
    pub(crate) functions: Arc<Functions>,
    pub(crate) object: Object,
    /// Bytes that the device currently holds, as it reports them.
    bytes: Box<AtomicIsize>,
}

// SAFETY: Embree's devices and scenes may be used and released from any thread.
unsafe impl Send for DeviceInner {}
// SAFETY: as above; all functions called through a shared reference are documented as thread-safe.
unsafe impl Sync for DeviceInner {}

impl Embree {
    /// Creates a device that builds with this many threads. The system chooses their affinities.
    pub fn device(&self, threads: usize) -> Result<Device, EmbreeError> {
        let threads = threads.max(1);
        let config = CString::new(format!("threads={threads},set_affinity=0")).unwrap_or_default();
        let functions = Arc::clone(&self.functions);
        // SAFETY: `config` is a null-terminated string.
        let object = unsafe { (functions.new_device)(config.as_ptr()) };
        if object.is_null() {
            // SAFETY: a null device is allowed and means the error of the calling thread.
            let code = unsafe { (functions.device_error)(std::ptr::null_mut()) };
            return Err(EmbreeError::Device(name(code)));
        }
        let inner = DeviceInner { functions, object, bytes: Box::default() };
        // SAFETY: the device is alive.
        let version = unsafe { (inner.functions.device_property)(object, ffi::PROPERTY_VERSION) } as i64;
        if version / 10_000 != 4 {
            return Err(EmbreeError::Version(version));
        }
        let counter: *const AtomicIsize = &*inner.bytes;
        // SAFETY: the counter is in a box that is dropped after the device is released.
        unsafe { (inner.functions.device_memory_monitor)(object, Some(count), counter.cast_mut().cast()) };
        Ok(Device { inner: Arc::new(inner) })
    }
}

impl Device {
    /// Bytes that the device currently holds: BVHs and everything else.
    pub fn bytes(&self) -> usize {
        usize::try_from(self.inner.bytes.load(Ordering::Relaxed)).unwrap_or(0)
    }

    /// The version: 10000 * major + 100 * minor + patch.
    pub fn version(&self) -> i64 {
        // SAFETY: the device is alive.
        (unsafe { (self.inner.functions.device_property)(self.inner.object, ffi::PROPERTY_VERSION) }) as i64
    }
}

impl DeviceInner {
    /// The error since the last call, if any.
    pub(crate) fn check(&self) -> Result<(), EmbreeError> {
        // SAFETY: the device is alive.
        match unsafe { (self.functions.device_error)(self.object) } {
            0 => Ok(()),
            code => Err(EmbreeError::Device(name(code))),
        }
    }
}

impl Drop for DeviceInner {
    fn drop(&mut self) {
        // SAFETY: this is the only reference from `rtcNewDevice`; scenes hold an `Arc` of this struct.
        unsafe { (self.functions.release_device)(self.object) };
    }
}

/// Embree's memory monitor: counts the bytes that it allocates and frees.
unsafe extern "C" fn count(counter: *mut c_void, bytes: isize, _after: bool) -> bool {
    // SAFETY: Embree passes the pointer it was given, to a counter that outlives the device.
    let counter = unsafe { &*counter.cast_const().cast::<AtomicIsize>() };
    counter.fetch_add(bytes, Ordering::Relaxed);
    true
}

fn name(code: c_int) -> &'static str {
    const NAMES: [&str; 8] = [
        "RTC_ERROR_NONE",
        "RTC_ERROR_UNKNOWN",
        "RTC_ERROR_INVALID_ARGUMENT",
        "RTC_ERROR_INVALID_OPERATION",
        "RTC_ERROR_OUT_OF_MEMORY",
        "RTC_ERROR_UNSUPPORTED_CPU",
        "RTC_ERROR_CANCELLED",
        "RTC_ERROR_LEVEL_ZERO_RAYTRACING_SUPPORT_MISSING",
    ];
    usize::try_from(code).ok().and_then(|i| NAMES.get(i)).copied().unwrap_or("an unknown error")
}
