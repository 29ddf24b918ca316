//! Functions of FMI 2.0.

use std::{
    ffi::{c_char, c_int, c_uint, c_void},
    ptr,
};

use libloading::Library;

use super::raw::{Handle, keep, symbol};

type Instantiate = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const Callbacks,
    c_int,
    c_int,
) -> Handle;
type Simple = unsafe extern "C" fn(Handle) -> c_int;

/// The functions, as `fmi2FunctionTypes.h` has them.
#[derive(Debug)]
pub(super) struct Two {
    instantiate: Instantiate,
    pub free: unsafe extern "C" fn(Handle),
    pub setup: unsafe extern "C" fn(Handle, c_int, f64, f64, c_int, f64) -> c_int,
    pub enter: Simple,
    pub exit: Simple,
    pub reset: Simple,
    pub set: unsafe extern "C" fn(Handle, *const c_uint, usize, *const f64) -> c_int,
    pub get: unsafe extern "C" fn(Handle, *const c_uint, usize, *mut f64) -> c_int,
    pub step: unsafe extern "C" fn(Handle, f64, f64, c_int) -> c_int,
}

impl Two {
    /// Copies the functions out of a library.
    ///
    /// # Safety
    ///
    /// The library has said that it is of this version, and outlives the copies.
    pub(super) unsafe fn of(library: &Library) -> Result<Self, String> {
        // SAFETY: names and types are those of the standard.
        unsafe {
            Ok(Self {
                instantiate: symbol!(library, b"fmi2Instantiate\0"),
                free: symbol!(library, b"fmi2FreeInstance\0"),
                setup: symbol!(library, b"fmi2SetupExperiment\0"),
                enter: symbol!(library, b"fmi2EnterInitializationMode\0"),
                exit: symbol!(library, b"fmi2ExitInitializationMode\0"),
                reset: symbol!(library, b"fmi2Reset\0"),
                set: symbol!(library, b"fmi2SetReal\0"),
                get: symbol!(library, b"fmi2GetReal\0"),
                step: symbol!(library, b"fmi2DoStep\0"),
            })
        }
    }

    /// An instance for co-simulation; null where there is none.
    ///
    /// # Safety
    ///
    /// Texts and callbacks outlive the instance.
    pub(super) unsafe fn instance(
        &self,
        [name, guid, resources]: [*const c_char; 3],
        callbacks: &Callbacks,
    ) -> Handle {
        // SAFETY: as the caller promises; 1 is `fmi2CoSimulation`.
        unsafe { (self.instantiate)(name, 1, guid, resources, callbacks, 0, 0) }
    }
}

/// `fmi2CallbackFunctions`. The logger is variadic in C; what comes after the message is not looked at, and the
/// calling conventions of all platforms with FMUs pass the fixed arguments alike.
#[repr(C)]
pub(super) struct Callbacks {
    logger: extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char),
    allocate: extern "C" fn(usize, usize) -> *mut c_void,
    free: extern "C" fn(*mut c_void),
    finished: *const c_void,
    environment: *const c_void,
}

impl std::fmt::Debug for Callbacks {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Callbacks")
    }
}

impl Callbacks {
    pub(super) fn new(environment: *const c_void) -> Self {
        Self { logger: log, allocate, free, finished: ptr::null(), environment }
    }
}

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    #[link_name = "free"]
    fn release(memory: *mut c_void);
}

extern "C" fn allocate(count: usize, size: usize) -> *mut c_void {
    // SAFETY: any two numbers may be given to it.
    unsafe { calloc(count, size) }
}

extern "C" fn free(memory: *mut c_void) {
    // SAFETY: the FMU gives back what it has got from `allocate`, once, or null.
    unsafe { release(memory) }
}

extern "C" fn log(
    environment: *mut c_void,
    _instance: *const c_char,
    status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is that of the callbacks, which the component keeps.
    unsafe { keep(environment, status, message) }
}
