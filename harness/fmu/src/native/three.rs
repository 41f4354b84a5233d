//! FMI 3.0.

use super::{Calls, Component, Log, Status, Stepped, functions};
use crate::model::Kind;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::os::unix::ffi::OsStrExt as _;
use std::path::Path;
use std::sync::Arc;

type Logger = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

type Instantiate = unsafe extern "C" fn(
    *const c_char,
    *const c_char,
    *const c_char,
    bool,
    bool,
    bool,
    bool,
    *const u32,
    usize,
    *mut c_void,
    Option<Logger>,
    *const c_void,
) -> Component;
type Plain = unsafe extern "C" fn(Component) -> c_int;
type Free = unsafe extern "C" fn(Component);
type Enter = unsafe extern "C" fn(Component, bool, f64, f64, bool, f64) -> c_int;
type Set<T> = unsafe extern "C" fn(Component, *const u32, usize, *const T, usize) -> c_int;
type Get<T> = unsafe extern "C" fn(Component, *const u32, usize, *mut T, usize) -> c_int;
type DoStep =
    unsafe extern "C" fn(Component, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;

functions! {
    instantiate: c"fmi3InstantiateCoSimulation", Instantiate;
    free: c"fmi3FreeInstance", Free;
    enter: c"fmi3EnterInitializationMode", Enter;
    exit: c"fmi3ExitInitializationMode", Plain;
    terminate: c"fmi3Terminate", Plain;
    do_step: c"fmi3DoStep", DoStep;
    set_float32: c"fmi3SetFloat32", Set<f32>;
    set_float64: c"fmi3SetFloat64", Set<f64>;
    set_int8: c"fmi3SetInt8", Set<i8>;
    set_uint8: c"fmi3SetUInt8", Set<u8>;
    set_int16: c"fmi3SetInt16", Set<i16>;
    set_uint16: c"fmi3SetUInt16", Set<u16>;
    set_int32: c"fmi3SetInt32", Set<i32>;
    set_uint32: c"fmi3SetUInt32", Set<u32>;
    set_int64: c"fmi3SetInt64", Set<i64>;
    set_uint64: c"fmi3SetUInt64", Set<u64>;
    set_boolean: c"fmi3SetBoolean", Set<bool>;
    get_float32: c"fmi3GetFloat32", Get<f32>;
    get_float64: c"fmi3GetFloat64", Get<f64>;
    get_int8: c"fmi3GetInt8", Get<i8>;
    get_uint8: c"fmi3GetUInt8", Get<u8>;
    get_int16: c"fmi3GetInt16", Get<i16>;
    get_uint16: c"fmi3GetUInt16", Get<u16>;
    get_int32: c"fmi3GetInt32", Get<i32>;
    get_uint32: c"fmi3GetUInt32", Get<u32>;
    get_int64: c"fmi3GetInt64", Get<i64>;
    get_uint64: c"fmi3GetUInt64", Get<u64>;
    get_boolean: c"fmi3GetBoolean", Get<u8>;
}

unsafe extern "C" fn logger(
    environment: *mut c_void,
    status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is that of the instance, and a library passes texts.
    unsafe { Log::keep(environment, Status(status), message) }
}

/// Sets one value.
///
/// # Safety
///
/// As in [`Calls`].
unsafe fn set<T>(function: Set<T>, component: Component, reference: u32, value: T) -> c_int {
    // SAFETY: the pointers are to one value each.
    unsafe { function(component, &raw const reference, 1, &raw const value, 1) }
}

/// Gets one value.
///
/// # Safety
///
/// As in [`Calls`].
unsafe fn get<T: Default>(function: Get<T>, component: Component, reference: u32) -> (c_int, T) {
    let mut value = T::default();
    // SAFETY: the pointers are to one value each.
    let status = unsafe { function(component, &raw const reference, 1, &raw mut value, 1) };
    (status, value)
}

// The trait says what is safe.
#[expect(clippy::undocumented_unsafe_blocks, reason = "each call passes the component on")]
impl Calls for Functions {
    fn prefix(&self) -> &'static str {
        "fmi3"
    }

    fn type_name(&self, kind: Kind) -> String {
        format!("{kind:?}")
    }

    unsafe fn instantiate(&self, token: &CStr, resources: &Path, log: &Arc<Log>) -> Component {
        let mut path = resources.as_os_str().as_bytes().to_vec();
        path.push(b'/');
        let path = CString::new(path).unwrap_or_default();
        let (name, token, path) = (c"hil".as_ptr(), token.as_ptr(), path.as_ptr());
        let (none, environment) = (std::ptr::null(), log.pointer());
        let (visible, logging, events, early) = (false, false, false, false);
        let logger: Option<Logger> = Some(logger);
        unsafe {
            (self.instantiate)(
                name,
                token,
                path,
                visible,
                logging,
                events,
                early,
                none,
                0,
                environment,
                logger,
                std::ptr::null(),
            )
        }
    }

    unsafe fn enter_initialization(&self, component: Component) -> Status {
        Status(unsafe { (self.enter)(component, false, 0.0, 0.0, false, 0.0) })
    }

    unsafe fn exit_initialization(&self, component: Component) -> Status {
        Status(unsafe { (self.exit)(component) })
    }

    unsafe fn set(&self, component: Component, reference: u32, kind: Kind, value: f64) -> Status {
        let whole = value.round();
        let status = unsafe {
            match kind {
                Kind::Float32 => set(self.set_float32, component, reference, value as f32),
                Kind::Int8 => set(self.set_int8, component, reference, whole as i8),
                Kind::UInt8 => set(self.set_uint8, component, reference, whole as u8),
                Kind::Int16 => set(self.set_int16, component, reference, whole as i16),
                Kind::UInt16 => set(self.set_uint16, component, reference, whole as u16),
                Kind::Int32 => set(self.set_int32, component, reference, whole as i32),
                Kind::UInt32 => set(self.set_uint32, component, reference, whole as u32),
                Kind::Int64 => set(self.set_int64, component, reference, whole as i64),
                Kind::UInt64 => set(self.set_uint64, component, reference, whole as u64),
                Kind::Boolean => set(self.set_boolean, component, reference, value != 0.0),
                Kind::Float64 | Kind::Other => set(self.set_float64, component, reference, value),
            }
        };
        Status(status)
    }

    unsafe fn get(&self, component: Component, reference: u32, kind: Kind) -> (Status, f64) {
        macro_rules! number {
            ($function:ident) => {{
                let (status, value) = unsafe { get(self.$function, component, reference) };
                (status, value as f64)
            }};
        }
        let (status, value) = match kind {
            Kind::Float32 => number!(get_float32),
            Kind::Int8 => number!(get_int8),
            Kind::UInt8 => number!(get_uint8),
            Kind::Int16 => number!(get_int16),
            Kind::UInt16 => number!(get_uint16),
            Kind::Int32 => number!(get_int32),
            Kind::UInt32 => number!(get_uint32),
            Kind::Int64 => number!(get_int64),
            Kind::UInt64 => number!(get_uint64),
            // A byte that is neither 0 nor 1 is no `bool` of Rust.
            Kind::Boolean => {
                let (status, value) = unsafe { get(self.get_boolean, component, reference) };
                (status, f64::from(u8::from(value != 0)))
            }
            Kind::Float64 | Kind::Other => number!(get_float64),
        };
        (Status(status), value)
    }

    unsafe fn step(&self, component: Component, from_s: f64, length_s: f64) -> Stepped {
        // Bytes, for the same reason.
        let (mut event, mut end, mut early, mut last) = (0, 0, 0, f64::NAN);
        let status = unsafe {
            (self.do_step)(
                component,
                from_s,
                length_s,
                true,
                &raw mut event,
                &raw mut end,
                &raw mut early,
                &raw mut last,
            )
        };
        let early = (early != 0).then_some(last);
        Stepped { status: Status(status), early, wants_end: end != 0 }
    }

    unsafe fn terminate(&self, component: Component) -> Status {
        Status(unsafe { (self.terminate)(component) })
    }

    unsafe fn free(&self, component: Component) {
        unsafe { (self.free)(component) }
    }
}
