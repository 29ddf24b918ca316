//! The functions of an FMI 2.0 or 3.0 co-simulation, behind safe methods: the only unsafe code of this crate.
//!
//! # Why this is sound, as far as a library of somebody else can be
//!
//! * Types and signatures are those of `fmi2FunctionTypes.h` (FMI 2.0.4, section 2.1) and `fmi3FunctionTypes.h` (FMI
//!   3.0.2, section 2.2): pointers, `double`, `unsigned int`, `int` for enumerations; Booleans are `int` in 2.0 and
//!   `bool` of C in 3.0. They are taken for what they are only after `fmi2GetVersion` or `fmi3GetVersion` has said so.
//! * Function pointers are copies out of a [`Library`] that lives in the same [`Api`], which every [`Component`]
//!   holds by an `Arc`: no function is called after it was unloaded.
//! * A component is freed once, by `drop`, and never used after; after a *fatal* error nothing is called for it any
//!   more, not even that, as the standard asks: it leaks.
//! * What the FMU may keep for its life, names, callbacks and their environment, lives in the component in boxes
//!   of their own, which do not move, and is dropped after it.
//! * Slices are handed over with their own lengths; both sides of each call have the same length, by construction.
//! * A component is used by one thread at a time, as `&mut self` says, but not always by the same one, which the
//!   standard allows; that is what `Send` rests on.
//! * Callbacks do not unwind: they allocate and free by the C library, and copy a text.
//!
//! What an FMU does inside is beyond any proof: one with a bug can corrupt or end this process. Therefore it is one for
//! this FMU alone, where that can be had (`host_fmus`).
#![allow(unsafe_code, reason = "functions of a C library")]

mod raw;
mod three;
mod two;

use std::{
    ffi::{CStr, CString, c_char, c_int},
    path::Path,
    sync::{Arc, Mutex},
};

use libloading::Library;

use self::{raw::Handle, three::Three, two::Two};
use super::{super::lock::open, description::Version};

/// How a call ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Failure {
    /// "Discard" or "error": the run is lost, the instance can be reset.
    Run(String),
    /// "Fatal", or something that no FMU should do: nothing more may be asked.
    Fatal(String),
}

/// The functions of a version.
#[derive(Debug)]
enum Functions {
    Two(Two),
    Three(Three),
}

/// The library of an FMU.
#[derive(Debug)]
pub(super) struct Api {
    functions: Functions,
    /// Last, so that it is unloaded after all else.
    _library: Library,
}

impl Api {
    /// Loads a library of this version.
    pub(super) fn load(path: &Path, version: Version) -> Result<Arc<Self>, String> {
        // SAFETY: what a library does when it is loaded is for who has asked for it to know; symbols are copied
        // while it is there, with the types that the standard gives them, after it has told its version.
        unsafe {
            let library = Library::new(path).map_err(|error| error.to_string())?;
            let (name, begin): (&[u8], &[u8]) = match version {
                Version::Two => (b"fmi2GetVersion\0", b"2."),
                Version::Three => (b"fmi3GetVersion\0", b"3."),
            };
            let said: unsafe extern "C" fn() -> *const c_char =
                *library.get(name).map_err(|error| error.to_string())?;
            let said = said();
            if said.is_null() || !CStr::from_ptr(said).to_bytes().starts_with(begin) {
                return Err(format!("its version is not {version}"));
            }
            let functions = match version {
                Version::Two => Functions::Two(Two::of(&library)?),
                Version::Three => Functions::Three(Three::of(&library)?),
            };
            Ok(Arc::new(Self { functions, _library: library }))
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
    _callbacks: Option<Box<two::Callbacks>>,
    last: Box<Mutex<String>>,
}

// SAFETY: the handle belongs to this component alone, and calls need `&mut self`.
unsafe impl Send for Component {}

impl Component {
    /// Makes an instance, of a name, a token and a place of resources.
    pub(super) fn new(api: &Arc<Api>, texts: [&str; 3]) -> Result<Self, String> {
        let c =
            |text: &str| CString::new(text).map_err(|_| format!("a null character in `{text}`"));
        let texts = [c(texts[0])?, c(texts[1])?, c(texts[2])?];
        let last = Box::new(Mutex::new(String::new()));
        let environment: *const Mutex<String> = &raw const *last;
        let pointers = texts.each_ref().map(|text| text.as_ptr());
        // SAFETY: texts, callbacks and their environment live in boxes that the component keeps.
        let (handle, callbacks) = unsafe {
            match &api.functions {
                Functions::Two(two) => {
                    let callbacks = Box::new(two::Callbacks::new(environment.cast()));
                    (two.instance(pointers, &callbacks), Some(callbacks))
                }
                Functions::Three(three) => {
                    (three.instance(pointers, environment.cast_mut().cast()), None)
                }
            }
        };
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
        let prefix = match &self.api.functions {
            Functions::Two(_) => "fmi2",
            Functions::Three(_) => "fmi3",
        };
        let text = format!("{prefix}{what}: {name} ({status}) {last}");
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
        let status = unsafe {
            match &self.api.functions {
                Functions::Two(two) => (two.reset)(handle),
                Functions::Three(three) => (three.reset)(handle),
            }
        };
        self.judge("Reset", status)
    }

    /// Initialises it for an experiment that begins at a time and has no end and no tolerance.
    pub(super) fn initialise(&mut self, start: f64) -> Result<(), Failure> {
        let handle = self.ready()?;
        if let Functions::Two(two) = &self.api.functions {
            // SAFETY: as above.
            let status = unsafe { (two.setup)(handle, 0, 0.0, start, 0, 0.0) };
            self.judge("SetupExperiment", status)?;
        }
        // SAFETY: as above.
        let status = unsafe {
            match &self.api.functions {
                Functions::Two(two) => (two.enter)(handle),
                Functions::Three(three) => (three.enter)(handle, false, 0.0, start, false, 0.0),
            }
        };
        self.judge("EnterInitializationMode", status)?;
        // SAFETY: as above.
        let status = unsafe {
            match &self.api.functions {
                Functions::Two(two) => (two.exit)(handle),
                Functions::Three(three) => (three.exit)(handle),
            }
        };
        self.judge("ExitInitializationMode", status)
    }

    /// Sets variables; as many values as references are set, whichever are fewer.
    pub(super) fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), Failure> {
        let (handle, n) = (self.ready()?, references.len().min(values.len()));
        let (references, values) = (references.as_ptr(), values.as_ptr());
        // SAFETY: as above, and both slices have at least `n` entries.
        let (what, status) = unsafe {
            match &self.api.functions {
                Functions::Two(two) => ("SetReal", (two.set)(handle, references, n, values)),
                Functions::Three(three) => {
                    ("SetFloat64", (three.set)(handle, references, n, values, n))
                }
            }
        };
        self.judge(what, status)
    }

    /// Gets variables; as many as references or room for values, whichever are fewer.
    pub(super) fn get(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Failure> {
        let (handle, n) = (self.ready()?, references.len().min(values.len()));
        let (references, values) = (references.as_ptr(), values.as_mut_ptr());
        // SAFETY: as above, and both slices have at least `n` entries.
        let (what, status) = unsafe {
            match &self.api.functions {
                Functions::Two(two) => ("GetReal", (two.get)(handle, references, n, values)),
                Functions::Three(three) => {
                    ("GetFloat64", (three.get)(handle, references, n, values, n))
                }
            }
        };
        self.judge(what, status)
    }

    pub(super) fn step(&mut self, time: f64, step: f64) -> Result<(), Failure> {
        let handle = self.ready()?;
        // SAFETY: as above; the FMU is told that no earlier state will be asked for.
        let status = unsafe {
            match &self.api.functions {
                Functions::Two(two) => (two.step)(handle, time, step, 1),
                Functions::Three(three) => three.step(handle, time, step),
            }
        };
        self.judge("DoStep", status)
    }
}

impl Drop for Component {
    fn drop(&mut self) {
        if !self.is_fatal {
            // SAFETY: the handle was not freed before and is not used after.
            unsafe {
                match &self.api.functions {
                    Functions::Two(two) => (two.free)(self.handle),
                    Functions::Three(three) => (three.free)(self.handle),
                }
            }
        }
    }
}
