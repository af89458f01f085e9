//! A device, and the filter for ray-traced pictures.

use std::ffi::{CStr, c_int};
use std::marker::PhantomData;
use std::sync::Arc;

use turner::denoise::Rgb;

use crate::ffi::{self, Functions, Object};
use crate::{OidnError, Quality};

/// The processor.
pub(crate) struct Device {
    functions: Arc<Functions>,
    object: Object,
}

impl Device {
    /// `threads` of 0 uses all.
    pub(crate) fn new(functions: &Arc<Functions>, threads: usize) -> Result<Device, OidnError> {
        // SAFETY: the functions are OIDN's.
        let object = unsafe { (functions.new_device)(ffi::DEVICE_CPU) };
        let device = Device { functions: Arc::clone(functions), object };
        if object.is_null() {
            device.check()?;
            return Err(OidnError::Device("there is no device for this processor".to_owned()));
        }
        let threads = c_int::try_from(threads).unwrap_or(0);
        // SAFETY: the device is alive and the names are null-terminated.
        unsafe {
            (functions.set_device_int)(object, c"numThreads".as_ptr(), threads);
            (functions.set_device_bool)(object, c"setAffinity".as_ptr(), false);
            (functions.commit_device)(object);
        }
        device.check()?;
        Ok(device)
    }

    /// 10000 * major + 100 * minor + patch.
    pub(crate) fn version(&self) -> i32 {
        // SAFETY: the device is alive and the name is null-terminated.
        unsafe { (self.functions.device_int)(self.object, c"version".as_ptr()) }
    }

    /// The error since the last call, if any.
    fn check(&self) -> Result<(), OidnError> {
        let mut message = std::ptr::null();
        // SAFETY: a null device means the error of the calling thread.
        let code = unsafe { (self.functions.device_error)(self.object, &mut message) };
        if code == 0 {
            return Ok(());
        }
        if message.is_null() {
            return Err(OidnError::Device(format!("error {code}")));
        }
        // SAFETY: the message is null-terminated and lives until the next call for an error.
        let message = unsafe { CStr::from_ptr(message) };
        Err(OidnError::Device(message.to_string_lossy().into_owned()))
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        if !self.object.is_null() {
            // SAFETY: the device is alive, and filters borrow it.
            unsafe { (self.functions.release_device)(self.object) };
        }
    }
}

/// OIDN's filter "RT", for ray-traced pictures. It holds pointers to its images, so it borrows them.
pub(crate) struct Filter<'a> {
    device: &'a Device,
    object: Object,
    size: [usize; 2],
    images: PhantomData<&'a mut [Rgb]>,
}

impl<'a> Filter<'a> {
    /// A filter of pictures of this width and height.
    pub(crate) fn new(device: &'a Device, size: [usize; 2]) -> Result<Filter<'a>, OidnError> {
        // SAFETY: the device is alive and the name is null-terminated.
        let object = unsafe { (device.functions.new_filter)(device.object, c"RT".as_ptr()) };
        device.check()?;
        match object.is_null() {
            true => Err(OidnError::Device("it has no filter \"RT\"".to_owned())),
            false => Ok(Filter { device, object, size, images: PhantomData }),
        }
    }

    /// Sets an image. It must have width times height pixels.
    pub(crate) fn image(&mut self, name: &CStr, pixels: &'a mut [Rgb]) {
        let [width, height] = self.size;
        assert_eq!(pixels.len(), width * height, "an image of another size");
        // SAFETY: the filter is alive; it borrows the pixels for as long as it lives; 0 means that there are no gaps.
        unsafe {
            (self.device.functions.filter_image)(
                self.object,
                name.as_ptr(),
                pixels.as_mut_ptr().cast(),
                ffi::FORMAT_FLOAT3,
                width,
                height,
                0,
                0,
                0,
            );
        }
    }

    /// Fills the output.
    pub(crate) fn run(&mut self, quality: Quality) -> Result<(), OidnError> {
        let functions = &self.device.functions;
        let quality = match quality {
            Quality::Fast => ffi::QUALITY_FAST,
            Quality::Balanced => ffi::QUALITY_BALANCED,
            Quality::High => ffi::QUALITY_HIGH,
        };
        // SAFETY: the filter is alive and the names are null-terminated.
        unsafe {
            (functions.set_filter_bool)(self.object, c"hdr".as_ptr(), true);
            (functions.set_filter_int)(self.object, c"quality".as_ptr(), quality);
            (functions.commit_filter)(self.object);
            (functions.execute_filter)(self.object);
        }
        self.device.check()
    }
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: the filter is alive.
        unsafe { (self.device.functions.release_filter)(self.object) };
    }
}
