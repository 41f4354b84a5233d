//! The functions of FMI 2.0.
//!
//! What the standard says of their arguments is what makes them safe: an instance is one of `fmi2Instantiate` and arrays have
//! the given length.

#![expect(clippy::undocumented_unsafe_blocks, reason = "callers follow the standard")]

use crate::c::{self, text, with};
use crate::{common, lacking};
use percent_encoding::percent_decode;
use std::ffi::{CStr, OsStr, c_char, c_int, c_void};
use std::os::unix::ffi::OsStrExt as _;
use std::path::Path;

type Logger =
    unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

#[repr(C)]
#[derive(Debug)]
pub struct Callbacks {
    logger: Option<Logger>,
    allocate: *const c_void,
    free: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    _kind: c_int,
    _guid: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    _visible: c_int,
    _logging: c_int,
) -> *mut c_void {
    let name = unsafe { text(name) }.to_owned();
    let (logger, environment) = unsafe { callbacks.as_ref() }
        .map_or((None, std::ptr::null_mut()), |callbacks| {
            (callbacks.logger, callbacks.environment)
        });
    let tell = move |why: &CStr| {
        if let Some(logger) = logger {
            let category = c"logStatusError".as_ptr();
            let format = c"%s".as_ptr();
            unsafe { logger(environment, name.as_ptr(), c::ERROR, category, format, why.as_ptr()) };
        }
    };
    let resources = unsafe { text(resources) }.to_bytes();
    // `file:///folder`, `file:/folder` and `file://localhost/folder` are the same.
    let path = resources.strip_prefix(b"file:").unwrap_or(resources);
    let path =
        path.strip_prefix(b"//localhost").or_else(|| path.strip_prefix(b"//")).unwrap_or(path);
    let path: Vec<u8> = percent_decode(path).collect();
    c::instantiate(Path::new(OsStr::from_bytes(&path)), Box::new(tell))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(instance: *mut c_void) -> c_int {
    unsafe { with(instance, |_| Ok(())) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const f64,
) -> c_int {
    unsafe { c::set(instance, (references, count), values) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut f64,
) -> c_int {
    unsafe { c::get(instance, (references, count), values) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    instance: *mut c_void,
    from_s: f64,
    length_s: f64,
    _no_state_before: c_int,
) -> c_int {
    unsafe { with(instance, |unit| unit.step(from_s, length_s)) }
}

common! {
    fmi2SetDebugLogging fmi2FreeInstance fmi2SetupExperiment(c_int) fmi2ExitInitializationMode fmi2Terminate fmi2Reset
    fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate
}

lacking! {
    fmi2CancelStep fmi2DeSerializeFMUstate fmi2GetBoolean fmi2GetBooleanStatus fmi2GetDirectionalDerivative
    fmi2GetInteger fmi2GetIntegerStatus fmi2GetRealOutputDerivatives fmi2GetRealStatus fmi2GetStatus fmi2GetString
    fmi2GetStringStatus fmi2SerializeFMUstate fmi2SerializedFMUstateSize fmi2SetBoolean fmi2SetInteger
    fmi2SetRealInputDerivatives fmi2SetString
}
