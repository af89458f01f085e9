//! The part of OIDN's C interface that Turner uses, from the headers of version 2.

use std::ffi::{c_char, c_int, c_void};
use std::mem::ManuallyDrop;

pub(crate) const DEVICE_CPU: c_int = 1;
pub(crate) const FORMAT_FLOAT3: c_int = 3;
pub(crate) const QUALITY_FAST: c_int = 4;
pub(crate) const QUALITY_BALANCED: c_int = 5;
pub(crate) const QUALITY_HIGH: c_int = 6;

/// An opaque object of the library.
pub(crate) type Object = *mut c_void;

/// A null-terminated string.
type Text = *const c_char;

/// Declares the function table and its loader.
macro_rules! functions {
    ($($field:ident = $symbol:literal: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions of the library. The library is never unloaded: its thread pool runs its code.
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
            /// Functions of these names must have the C types that OIDN 2 declares.
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
    new_device = b"oidnNewDevice": fn(c_int) -> Object;
    release_device = b"oidnReleaseDevice": fn(Object);
    device_int = b"oidnGetDeviceInt": fn(Object, Text) -> c_int;
    set_device_int = b"oidnSetDeviceInt": fn(Object, Text, c_int);
    set_device_bool = b"oidnSetDeviceBool": fn(Object, Text, bool);
    commit_device = b"oidnCommitDevice": fn(Object);
    device_error = b"oidnGetDeviceError": fn(Object, *mut Text) -> c_int;
    new_filter = b"oidnNewFilter": fn(Object, Text) -> Object;
    release_filter = b"oidnReleaseFilter": fn(Object);
    filter_image = b"oidnSetSharedFilterImage":
        fn(Object, Text, *mut c_void, c_int, usize, usize, usize, usize, usize);
    set_filter_int = b"oidnSetFilterInt": fn(Object, Text, c_int);
    set_filter_bool = b"oidnSetFilterBool": fn(Object, Text, bool);
    commit_filter = b"oidnCommitFilter": fn(Object);
    execute_filter = b"oidnExecuteFilter": fn(Object);
}
