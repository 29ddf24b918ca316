//! Functions of FMI 3.0.

use std::{
    ffi::{c_char, c_int, c_uint, c_void},
    ptr,
};

use libloading::Library;

use super::raw::{Handle, keep, symbol};

/// `fmi3LogMessageCallback`.
type Log = extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);
type Instantiate = unsafe extern "C" fn(
    *const c_char,
    *const c_char,
    *const c_char,
    bool,
    bool,
    bool,
    bool,
    *const c_uint,
    usize,
    *mut c_void,
    Log,
    *const c_void,
) -> Handle;
type Simple = unsafe extern "C" fn(Handle) -> c_int;
type DoStep =
    unsafe extern "C" fn(Handle, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;

/// `fmi3Discard`.
const DISCARD: c_int = 2;

/// The functions, as `fmi3FunctionTypes.h` has them.
#[derive(Debug)]
pub(super) struct Three {
    instantiate: Instantiate,
    pub free: unsafe extern "C" fn(Handle),
    pub enter: unsafe extern "C" fn(Handle, bool, f64, f64, bool, f64) -> c_int,
    pub exit: Simple,
    pub reset: Simple,
    pub set: unsafe extern "C" fn(Handle, *const c_uint, usize, *const f64, usize) -> c_int,
    pub get: unsafe extern "C" fn(Handle, *const c_uint, usize, *mut f64, usize) -> c_int,
    do_step: DoStep,
}

impl Three {
    /// Copies the functions out of a library.
    ///
    /// # Safety
    ///
    /// The library has said that it is of this version, and outlives the copies.
    pub(super) unsafe fn of(library: &Library) -> Result<Self, String> {
        // SAFETY: names and types are those of the standard.
        unsafe {
            Ok(Self {
                instantiate: symbol!(library, b"fmi3InstantiateCoSimulation\0"),
                free: symbol!(library, b"fmi3FreeInstance\0"),
                enter: symbol!(library, b"fmi3EnterInitializationMode\0"),
                exit: symbol!(library, b"fmi3ExitInitializationMode\0"),
                reset: symbol!(library, b"fmi3Reset\0"),
                set: symbol!(library, b"fmi3SetFloat64\0"),
                get: symbol!(library, b"fmi3GetFloat64\0"),
                do_step: symbol!(library, b"fmi3DoStep\0"),
            })
        }
    }

    /// An instance without events, early returns and intermediate updates; null where there is none.
    ///
    /// # Safety
    ///
    /// Texts and environment outlive the instance.
    pub(super) unsafe fn instance(
        &self,
        [name, token, resources]: [*const c_char; 3],
        environment: *mut c_void,
    ) -> Handle {
        let none = ptr::null();
        // SAFETY: as the caller promises; no intermediate variable is asked for.
        unsafe {
            (self.instantiate)(
                name,
                token,
                resources,
                false,
                false,
                false,
                false,
                none,
                0,
                environment,
                log,
                ptr::null(),
            )
        }
    }

    /// One step. An FMU that ends the simulation, or returns early though it must not, discards it.
    ///
    /// # Safety
    ///
    /// The handle is live.
    pub(super) unsafe fn step(&self, handle: Handle, time: f64, step: f64) -> c_int {
        // Booleans of C that the FMU writes: whatever is not zero is true.
        let (mut has_event, mut is_over, mut is_early, mut reached) = (0_u8, 0_u8, 0_u8, time);
        // SAFETY: as the caller promises; all places live for the call.
        let status = unsafe {
            (self.do_step)(
                handle,
                time,
                step,
                true,
                &raw mut has_event,
                &raw mut is_over,
                &raw mut is_early,
                &raw mut reached,
            )
        };
        if status < DISCARD && (is_over != 0 || is_early != 0) { DISCARD } else { status }
    }
}

extern "C" fn log(
    environment: *mut c_void,
    status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is that of the instance, which the component keeps.
    unsafe { keep(environment, status, message) }
}
