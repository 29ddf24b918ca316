//! What both versions have in common in C: the handle of an instance, functions of a library, messages.

use std::{
    ffi::{CStr, c_char, c_int, c_void},
    sync::Mutex,
};

use super::super::super::lock::open;

/// An instance, as the library knows it.
pub(super) type Handle = *mut c_void;

/// Copies the function of a name out of a library.
macro_rules! symbol {
    ($library:expr, $name:literal) => {
        *$library.get($name).map_err(|error| error.to_string())?
    };
}
pub(super) use symbol;

/// Keeps the last message that is no praise.
///
/// # Safety
///
/// The environment is null or the `Mutex` of the component that calls, which outlives it; the message is null or ends
/// with a null character. Both are so by the standard.
pub(super) unsafe fn keep(environment: *mut c_void, status: c_int, message: *const c_char) {
    if environment.is_null() || message.is_null() || status == 0 {
        return;
    }
    // SAFETY: as the caller promises; the message is copied.
    let (last, text) = unsafe {
        let last = &*environment.cast::<Mutex<String>>();
        (last, CStr::from_ptr(message).to_string_lossy().into_owned())
    };
    *open(last) = text;
}
