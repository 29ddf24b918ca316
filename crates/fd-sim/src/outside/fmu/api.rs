//! The functions of an FMI 2.0 co-simulation, behind safe methods: the only unsafe code of this crate.
//!
//! # Why this is sound, as far as a library of somebody else can be
//!
//! * Types and signatures are those of `fmi2FunctionTypes.h` (FMI 2.0.4, section 2.1): pointers, `double`,
//!   `unsigned int`, `int` for Booleans and enumerations. They are taken for what they are only after
//!   `fmi2GetVersion` has said `2.0`.
//! * Function pointers are copies out of a [`Library`] that lives in the same [`Api`], which every [`Component`]
//!   holds by an `Arc`: no function is called after it was unloaded.
//! * A component is freed once, by `drop`, and never used after; after a *fatal* error nothing is called for it any
//!   more, not even that, as the standard asks (section 2.1.3): it leaks.
//! * What the FMU may keep for its life, names, callbacks and their environment, lives in the component in boxes
//!   of their own, which do not move, and is dropped after it.
//! * Slices are handed over with their own lengths; both sides of each call have the same length, by construction.
//! * A component is used by one thread at a time, as `&mut self` says, but not always by the same one, which the
//!   standard allows; that is what `Send` rests on.
//! * Callbacks do not unwind: they allocate and free by the C library, and copy a text.
//!
//! What an FMU does inside is beyond any proof: one with a bug can corrupt or end this process. Whoever does not
//! trust one runs it in a process of its own (`kind = "process"`).
#![allow(unsafe_code, reason = "functions of a C library")]

use std::{
    ffi::{CStr, CString, c_char, c_int, c_uint, c_void},
    path::Path,
    ptr,
    sync::{Arc, Mutex},
};

use libloading::Library;

use super::super::lock::open;

type Handle = *mut c_void;
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
type Setup = unsafe extern "C" fn(Handle, c_int, f64, f64, c_int, f64) -> c_int;
type SetReal = unsafe extern "C" fn(Handle, *const c_uint, usize, *const f64) -> c_int;
type GetReal = unsafe extern "C" fn(Handle, *const c_uint, usize, *mut f64) -> c_int;
type DoStep = unsafe extern "C" fn(Handle, f64, f64, c_int) -> c_int;

/// `fmi2CallbackFunctions`. The logger is variadic in C; what comes after the message is not looked at, and the
/// calling conventions of all platforms with FMUs pass the fixed arguments alike.
#[repr(C)]
struct Callbacks {
    logger: extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char),
    allocate: extern "C" fn(usize, usize) -> *mut c_void,
    free: extern "C" fn(*mut c_void),
    finished: *const c_void,
    environment: *const c_void,
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

/// Keeps the last message that is no praise.
extern "C" fn log(
    environment: *mut c_void,
    _instance: *const c_char,
    status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    if environment.is_null() || message.is_null() || status == 0 {
        return;
    }
    // SAFETY: the environment is the `Mutex` of the component that calls, which outlives it; the message ends
    // with a null character by the standard, and is copied.
    let (last, text) = unsafe {
        let last = &*environment.cast::<Mutex<String>>();
        (last, CStr::from_ptr(message).to_string_lossy().into_owned())
    };
    *open(last) = text;
}

/// How a call ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Failure {
    /// `fmi2Discard` or `fmi2Error`: the run is lost, the instance can be reset.
    Run(String),
    /// `fmi2Fatal`, or something that no FMU should do: nothing more may be asked.
    Fatal(String),
}

/// The library of an FMU.
#[derive(Debug)]
pub(super) struct Api {
    instantiate: Instantiate,
    free_instance: unsafe extern "C" fn(Handle),
    setup: Setup,
    enter: Simple,
    exit: Simple,
    reset: Simple,
    set_real: SetReal,
    get_real: GetReal,
    do_step: DoStep,
    /// Last, so that it is unloaded after all else.
    _library: Library,
}

impl Api {
    /// Loads a library.
    pub(super) fn load(path: &Path) -> Result<Arc<Self>, String> {
        // SAFETY: what a library does when it is loaded is for who has asked for it to know; symbols are copied
        // while it is there, with the types that the standard gives them, after it has told its version.
        unsafe {
            let library = Library::new(path).map_err(|error| error.to_string())?;
            macro_rules! symbol {
                ($name:literal) => {
                    *library.get($name).map_err(|error| error.to_string())?
                };
            }
            let version: unsafe extern "C" fn() -> *const c_char = symbol!(b"fmi2GetVersion\0");
            let version = version();
            let is_two =
                !version.is_null() && CStr::from_ptr(version).to_bytes().starts_with(b"2.");
            if !is_two {
                return Err("its version is not 2.0".to_owned());
            }
            Ok(Arc::new(Self {
                instantiate: symbol!(b"fmi2Instantiate\0"),
                free_instance: symbol!(b"fmi2FreeInstance\0"),
                setup: symbol!(b"fmi2SetupExperiment\0"),
                enter: symbol!(b"fmi2EnterInitializationMode\0"),
                exit: symbol!(b"fmi2ExitInitializationMode\0"),
                reset: symbol!(b"fmi2Reset\0"),
                set_real: symbol!(b"fmi2SetReal\0"),
                get_real: symbol!(b"fmi2GetReal\0"),
                do_step: symbol!(b"fmi2DoStep\0"),
                _library: library,
            }))
        }
    }
}

/// An instance of an FMU.
#[derive(Debug)]
pub(super) struct Component {
    handle: Handle,
    is_fatal: bool,
    api: Arc<Api>,
    /// What the FMU may keep.
    _texts: [CString; 3],
    _callbacks: Box<Callbacks>,
    last: Box<Mutex<String>>,
}

impl std::fmt::Debug for Callbacks {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Callbacks")
    }
}

// SAFETY: the handle belongs to this component alone, and calls need `&mut self`.
unsafe impl Send for Component {}

impl Component {
    /// Makes an instance.
    pub(super) fn new(api: &Arc<Api>, texts: [&str; 3]) -> Result<Self, String> {
        let c =
            |text: &str| CString::new(text).map_err(|_| format!("a null character in `{text}`"));
        let texts = [c(texts[0])?, c(texts[1])?, c(texts[2])?];
        let last = Box::new(Mutex::new(String::new()));
        let environment: *const Mutex<String> = &raw const *last;
        let callbacks = Box::new(Callbacks {
            logger: log,
            allocate,
            free,
            finished: ptr::null(),
            environment: environment.cast(),
        });
        let [name, guid, resources] = texts.each_ref().map(|text| text.as_ptr());
        // SAFETY: texts and callbacks live in boxes that the component keeps; 1 is `fmi2CoSimulation`.
        let handle =
            unsafe { (api.instantiate)(name, 1, guid, resources, &raw const *callbacks, 0, 0) };
        if handle.is_null() {
            let last = open(&last).clone();
            return Err(if last.is_empty() { "no instance".to_owned() } else { last });
        }
        let api = Arc::clone(api);
        Ok(Self { handle, is_fatal: false, api, _texts: texts, _callbacks: callbacks, last })
    }

    /// What a status means, after `what` was called.
    fn judge(&mut self, what: &str, status: c_int) -> Result<(), Failure> {
        let name = match status {
            // Warnings are for people.
            0 | 1 => return Ok(()),
            2 => "discard",
            3 => "error",
            4 => "fatal",
            5 => "pending",
            _ => "no status",
        };
        let last = std::mem::take(&mut *open(&self.last));
        let text = format!("{what}: {name} ({status}) {last}");
        if matches!(status, 2 | 3) {
            return Err(Failure::Run(text));
        }
        self.is_fatal = true;
        Err(Failure::Fatal(text))
    }

    /// Refuses to call what must not be called any more.
    fn ready(&self) -> Result<Handle, Failure> {
        if self.is_fatal {
            return Err(Failure::Fatal("called after a fatal error".to_owned()));
        }
        Ok(self.handle)
    }

    pub(super) fn reset(&mut self) -> Result<(), Failure> {
        let handle = self.ready()?;
        // SAFETY: a live handle (see above), as in all calls below.
        let status = unsafe { (self.api.reset)(handle) };
        self.judge("fmi2Reset", status)
    }

    /// Experiments begin at a time and have no end and no tolerance.
    pub(super) fn setup(&mut self, start: f64) -> Result<(), Failure> {
        let handle = self.ready()?;
        // SAFETY: as above.
        let status = unsafe { (self.api.setup)(handle, 0, 0.0, start, 0, 0.0) };
        self.judge("fmi2SetupExperiment", status)
    }

    pub(super) fn enter_initialization(&mut self) -> Result<(), Failure> {
        let handle = self.ready()?;
        // SAFETY: as above.
        let status = unsafe { (self.api.enter)(handle) };
        self.judge("fmi2EnterInitializationMode", status)
    }

    pub(super) fn exit_initialization(&mut self) -> Result<(), Failure> {
        let handle = self.ready()?;
        // SAFETY: as above.
        let status = unsafe { (self.api.exit)(handle) };
        self.judge("fmi2ExitInitializationMode", status)
    }

    /// Sets variables; as many values as references are set, whichever are fewer.
    pub(super) fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), Failure> {
        let (handle, n) = (self.ready()?, references.len().min(values.len()));
        // SAFETY: as above, and both slices have at least `n` entries.
        let status =
            unsafe { (self.api.set_real)(handle, references.as_ptr(), n, values.as_ptr()) };
        self.judge("fmi2SetReal", status)
    }

    /// Gets variables; as many as references or room for values, whichever are fewer.
    pub(super) fn get(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Failure> {
        let (handle, n) = (self.ready()?, references.len().min(values.len()));
        // SAFETY: as above, and both slices have at least `n` entries.
        let status =
            unsafe { (self.api.get_real)(handle, references.as_ptr(), n, values.as_mut_ptr()) };
        self.judge("fmi2GetReal", status)
    }

    pub(super) fn step(&mut self, time: f64, step: f64) -> Result<(), Failure> {
        let handle = self.ready()?;
        // SAFETY: as above; 1 says that no earlier state will be asked for.
        let status = unsafe { (self.api.do_step)(handle, time, step, 1) };
        self.judge("fmi2DoStep", status)
    }
}

impl Drop for Component {
    fn drop(&mut self) {
        if !self.is_fatal {
            // SAFETY: the handle was not freed before and is not used after.
            unsafe { (self.api.free_instance)(self.handle) }
        }
    }
}
