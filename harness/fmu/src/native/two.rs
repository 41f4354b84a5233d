//! FMI 2.0.

use super::{Calls, Component, Log, Status, Stepped, functions};
use crate::model::Kind;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::path::Path;
use std::sync::Arc;

const CO_SIMULATION: c_int = 1;
const FALSE: c_int = 0;
const TRUE: c_int = 1;

/// What stays as it is in the path of a URI.
const PATH: &AsciiSet = &NON_ALPHANUMERIC.remove(b'/').remove(b'-').remove(b'.').remove(b'_');

type Logger =
    unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

unsafe extern "C" {
    /// Formats the message and passes it to [`log`].
    fn hil_fmi2_logger(
        environment: *mut c_void,
        instance: *const c_char,
        status: c_int,
        category: *const c_char,
        format: *const c_char,
        ...
    );
}

#[repr(C)]
struct Callbacks {
    logger: Logger,
    allocate: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
    step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    environment: *mut c_void,
}

type Instantiate = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const Callbacks,
    c_int,
    c_int,
) -> Component;
type Plain = unsafe extern "C" fn(Component) -> c_int;
type Free = unsafe extern "C" fn(Component);
type Setup = unsafe extern "C" fn(Component, c_int, f64, f64, c_int, f64) -> c_int;
type Set<T> = unsafe extern "C" fn(Component, *const c_uint, usize, *const T) -> c_int;
type Get<T> = unsafe extern "C" fn(Component, *const c_uint, usize, *mut T) -> c_int;
type DoStep = unsafe extern "C" fn(Component, f64, f64, c_int) -> c_int;

functions! {
    instantiate: c"fmi2Instantiate", Instantiate;
    free: c"fmi2FreeInstance", Free;
    setup: c"fmi2SetupExperiment", Setup;
    enter: c"fmi2EnterInitializationMode", Plain;
    exit: c"fmi2ExitInitializationMode", Plain;
    terminate: c"fmi2Terminate", Plain;
    set_real: c"fmi2SetReal", Set<f64>;
    set_integer: c"fmi2SetInteger", Set<c_int>;
    set_boolean: c"fmi2SetBoolean", Set<c_int>;
    get_real: c"fmi2GetReal", Get<f64>;
    get_integer: c"fmi2GetInteger", Get<c_int>;
    get_boolean: c"fmi2GetBoolean", Get<c_int>;
    do_step: c"fmi2DoStep", DoStep;
}

/// Takes a message of the logger.
#[unsafe(export_name = "hil_fmi2_log")]
unsafe extern "C" fn log(environment: *mut c_void, status: c_int, message: *const c_char) {
    // SAFETY: the environment is that of the callbacks, and the logger passes a text.
    unsafe { Log::keep(environment, Status(status), message) }
}

// The trait says what is safe.
#[expect(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes the component on, with pointers to one value"
)]
impl Calls for Functions {
    fn prefix(&self) -> &'static str {
        "fmi2"
    }

    fn type_name(&self, kind: Kind) -> String {
        let name = match kind {
            Kind::Float64 => "Real",
            Kind::Boolean => "Boolean",
            _ => "Integer",
        };
        name.to_owned()
    }

    unsafe fn instantiate(&self, token: &CStr, resources: &Path, log: &Arc<Log>) -> Component {
        let resources = utf8_percent_encode(&resources.to_string_lossy(), PATH).to_string();
        let resources = CString::new(format!("file://{resources}")).unwrap_or_default();
        let callbacks = Callbacks {
            logger: hil_fmi2_logger,
            allocate: libc::calloc,
            free: libc::free,
            step_finished: None,
            environment: log.pointer(),
        };
        // Libraries keep the pointer, and never say until when: a few bytes of each instance stay.
        let callbacks = Box::leak(Box::new(callbacks));
        let (name, co_simulation) = (c"hil".as_ptr(), CO_SIMULATION);
        let (token, resources) = (token.as_ptr(), resources.as_ptr());
        unsafe {
            (self.instantiate)(name, co_simulation, token, resources, callbacks, FALSE, FALSE)
        }
    }

    unsafe fn enter_initialization(&self, component: Component) -> Status {
        let status = unsafe { (self.setup)(component, FALSE, 0.0, 0.0, FALSE, 0.0) };
        match Status(status) {
            Status::OK | Status::WARNING => Status(unsafe { (self.enter)(component) }),
            failed => failed,
        }
    }

    unsafe fn exit_initialization(&self, component: Component) -> Status {
        Status(unsafe { (self.exit)(component) })
    }

    unsafe fn set(&self, component: Component, reference: u32, kind: Kind, value: f64) -> Status {
        Status(match kind {
            Kind::Float64 => unsafe {
                (self.set_real)(component, &raw const reference, 1, &raw const value)
            },
            Kind::Boolean => {
                let value = if value == 0.0 { FALSE } else { TRUE };
                unsafe { (self.set_boolean)(component, &raw const reference, 1, &raw const value) }
            }
            _ => {
                let value = value.round() as c_int;
                unsafe { (self.set_integer)(component, &raw const reference, 1, &raw const value) }
            }
        })
    }

    unsafe fn get(&self, component: Component, reference: u32, kind: Kind) -> (Status, f64) {
        let (mut real, mut integer) = (f64::NAN, 0);
        let reference = &raw const reference;
        let status = match kind {
            Kind::Float64 => unsafe { (self.get_real)(component, reference, 1, &raw mut real) },
            Kind::Boolean => unsafe {
                (self.get_boolean)(component, reference, 1, &raw mut integer)
            },
            _ => unsafe { (self.get_integer)(component, reference, 1, &raw mut integer) },
        };
        (Status(status), if kind == Kind::Float64 { real } else { f64::from(integer) })
    }

    unsafe fn step(&self, component: Component, from_s: f64, length_s: f64) -> Stepped {
        let status = Status(unsafe { (self.do_step)(component, from_s, length_s, TRUE) });
        Stepped { status, early: None, wants_end: false }
    }

    unsafe fn terminate(&self, component: Component) -> Status {
        Status(unsafe { (self.terminate)(component) })
    }

    unsafe fn free(&self, component: Component) {
        unsafe { (self.free)(component) }
    }
}
