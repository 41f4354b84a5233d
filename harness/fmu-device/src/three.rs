//! The functions of FMI 3.0.
//!
//! What the standard says of their arguments is what makes them safe: an instance is one of `fmi3InstantiateCoSimulation` and
//! arrays have the given length.

#![expect(clippy::undocumented_unsafe_blocks, reason = "callers follow the standard")]

use crate::c::{self, OK, text, with};
use crate::{common, lacking};
use std::ffi::{CStr, OsStr, c_char, c_int, c_void};
use std::os::unix::ffi::OsStrExt as _;
use std::path::Path;

type Logger = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    _token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    _event_mode: bool,
    _early_return: bool,
    _required: *const u32,
    _required_count: usize,
    environment: *mut c_void,
    logger: Option<Logger>,
    _intermediate_update: *const c_void,
) -> *mut c_void {
    let tell = move |why: &CStr| {
        if let Some(logger) = logger {
            unsafe { logger(environment, c::ERROR, c"logStatusError".as_ptr(), why.as_ptr()) };
        }
    };
    let resources = OsStr::from_bytes(unsafe { text(resources) }.to_bytes());
    c::instantiate(Path::new(resources), Box::new(tell))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const f64,
    _value_count: usize,
) -> c_int {
    unsafe { c::set(instance, (references, count), values) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut f64,
    _value_count: usize,
) -> c_int {
    unsafe { c::get(instance, (references, count), values) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    from_s: f64,
    length_s: f64,
    _no_state_before: bool,
    event: *mut bool,
    end: *mut bool,
    early: *mut bool,
    last_s: *mut f64,
) -> c_int {
    for flag in [event, end, early] {
        if let Some(flag) = unsafe { flag.as_mut() } {
            *flag = false;
        }
    }
    let status = unsafe { with(instance, |unit| unit.step(from_s, length_s)) };
    if let Some(last_s) = unsafe { last_s.as_mut() } {
        *last_s = if status == OK { from_s + length_s } else { from_s };
    }
    status
}

common! {
    fmi3SetDebugLogging fmi3FreeInstance fmi3EnterInitializationMode(bool) fmi3ExitInitializationMode fmi3Terminate fmi3Reset
    fmi3GetFMUState fmi3SetFMUState fmi3FreeFMUState
}

/// Kinds of units that a device is not.
macro_rules! none {
    ($($name:ident)*) => {
        $(
            #[unsafe(no_mangle)]
            pub extern "C" fn $name() -> *mut c_void {
                std::ptr::null_mut()
            }
        )*
    };
}

none! { fmi3InstantiateModelExchange fmi3InstantiateScheduledExecution }

lacking! {
    fmi3ActivateModelPartition fmi3CompletedIntegratorStep fmi3DeserializeFMUState fmi3EnterConfigurationMode
    fmi3EnterContinuousTimeMode fmi3EnterEventMode fmi3EnterStepMode fmi3EvaluateDiscreteStates
    fmi3ExitConfigurationMode fmi3GetAdjointDerivative fmi3GetBinary fmi3GetBoolean fmi3GetClock
    fmi3GetContinuousStateDerivatives fmi3GetContinuousStates fmi3GetDirectionalDerivative fmi3GetEventIndicators
    fmi3GetFloat32 fmi3GetInt16 fmi3GetInt32 fmi3GetInt64 fmi3GetInt8 fmi3GetIntervalDecimal
    fmi3GetIntervalFraction fmi3GetNominalsOfContinuousStates fmi3GetNumberOfContinuousStates
    fmi3GetNumberOfEventIndicators fmi3GetNumberOfVariableDependencies fmi3GetOutputDerivatives fmi3GetShiftDecimal
    fmi3GetShiftFraction fmi3GetString fmi3GetUInt16 fmi3GetUInt32 fmi3GetUInt64 fmi3GetUInt8
    fmi3GetVariableDependencies fmi3SerializeFMUState fmi3SerializedFMUStateSize fmi3SetBinary fmi3SetBoolean
    fmi3SetClock fmi3SetContinuousStates fmi3SetFloat32 fmi3SetInt16 fmi3SetInt32 fmi3SetInt64 fmi3SetInt8
    fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction fmi3SetString
    fmi3SetTime fmi3SetUInt16 fmi3SetUInt32 fmi3SetUInt64 fmi3SetUInt8 fmi3UpdateDiscreteStates
}
