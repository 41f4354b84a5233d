//! What the functions of both versions have in common.

use crate::files::read;
use crate::unit::Unit;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

pub const OK: c_int = 0;
pub const ERROR: c_int = 3;

/// Receiver of log messages.
pub type Tell = Box<dyn Fn(&CStr)>;

fn say(tell: &Tell, why: &str) {
    tell(&CString::new(why.replace('\0', " ")).unwrap_or_default());
}

/// What a `fmi2Component` or `fmi3Instance` points to.
pub struct Instance {
    pub unit: Unit,
    tell: Tell,
}

/// A text from C; empty for null.
///
/// # Safety
///
/// The pointer is null or to a text.
pub unsafe fn text<'a>(pointer: *const c_char) -> &'a CStr {
    // SAFETY: the caller says so.
    if pointer.is_null() { c"" } else { unsafe { CStr::from_ptr(pointer) } }
}

/// A new instance of the device in these resources; null if it cannot be read.
pub fn instantiate(resources: &Path, tell: Tell) -> *mut c_void {
    let read = catch_unwind(|| read(resources)).unwrap_or_else(|_| Err("it panicked".to_owned()));
    match read {
        Ok(description) => {
            Box::into_raw(Box::new(Instance { unit: Unit::new(description), tell })).cast()
        }
        Err(why) => {
            say(&tell, &why);
            std::ptr::null_mut()
        }
    }
}

/// Frees an instance.
///
/// # Safety
///
/// It is null or of [`instantiate`], and used no more.
pub unsafe fn free(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: the caller says so.
        drop(unsafe { Box::from_raw(instance.cast::<Instance>()) });
    }
}

/// Does something with an instance. An error is logged and becomes a status.
///
/// # Safety
///
/// It is null or of [`instantiate`], and nobody else uses it now.
pub unsafe fn with(
    instance: *mut c_void,
    act: impl FnOnce(&mut Unit) -> Result<(), String>,
) -> c_int {
    // SAFETY: the caller says so.
    let Some(instance) = (unsafe { instance.cast::<Instance>().as_mut() }) else { return ERROR };
    // A panic must not reach C.
    let done = catch_unwind(AssertUnwindSafe(|| act(&mut instance.unit)));
    match done.unwrap_or_else(|_| Err("it panicked".to_owned())) {
        Ok(()) => OK,
        Err(why) => {
            say(&instance.tell, &why);
            ERROR
        }
    }
}

/// Sets or gets several variables.
///
/// # Safety
///
/// As [`with`], and both arrays have `count` elements.
pub unsafe fn set(
    instance: *mut c_void,
    (references, count): (*const u32, usize),
    values: *const f64,
) -> c_int {
    // SAFETY: the caller says so.
    unsafe {
        with(instance, |unit| {
            (0..count)
                .try_for_each(|place| unit.set(*references.add(place) as usize, *values.add(place)))
        })
    }
}

/// See [`set`].
///
/// # Safety
///
/// As [`set`].
pub unsafe fn get(
    instance: *mut c_void,
    (references, count): (*const u32, usize),
    values: *mut f64,
) -> c_int {
    // SAFETY: the caller says so.
    unsafe {
        with(instance, |unit| {
            (0..count).try_for_each(|place| {
                *values.add(place) = unit.get(*references.add(place) as usize)?;
                Ok(())
            })
        })
    }
}

/// Copies the state into `*state`, which is null or an earlier copy.
///
/// # Safety
///
/// As [`with`], and `state` is a place for a pointer.
pub unsafe fn get_state(instance: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: the caller says so.
    unsafe {
        with(instance, |unit| {
            free_state(state);
            *state = Box::into_raw(Box::new(unit.clone())).cast();
            Ok(())
        })
    }
}

/// Takes a copied state.
///
/// # Safety
///
/// As [`with`], and `state` is of [`get_state`].
pub unsafe fn set_state(instance: *mut c_void, state: *mut c_void) -> c_int {
    // SAFETY: the caller says so.
    unsafe {
        with(instance, |unit| {
            let state = state.cast::<Unit>().as_ref().ok_or("there is no state")?;
            unit.clone_from(state);
            Ok(())
        })
    }
}

/// Frees a copied state.
///
/// # Safety
///
/// `state` is a place for a pointer that is null or of [`get_state`].
pub unsafe fn free_state(state: *mut *mut c_void) -> c_int {
    // SAFETY: the caller says so.
    unsafe {
        if let Some(state) = state.as_mut().filter(|state| !state.is_null()) {
            drop(Box::from_raw(state.cast::<Unit>()));
            *state = std::ptr::null_mut();
        }
    }
    OK
}

/// The functions that are the same in both versions, under their names there; `$flag` is a truth value.
#[macro_export]
macro_rules! common {
    ($debug:ident $free:ident $start:ident($flag:ty) $begin:ident $terminate:ident $reset:ident
        $get_state:ident $set_state:ident $free_state:ident) => {
        #[unsafe(no_mangle)]
        pub extern "C" fn $debug() -> c_int {
            $crate::c::OK
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $free(instance: *mut c_void) {
            unsafe { $crate::c::free(instance) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $start(
            instance: *mut c_void,
            _has_tolerance: $flag,
            _tolerance: f64,
            start_s: f64,
            _has_stop: $flag,
            _stop_s: f64,
        ) -> c_int {
            unsafe { with(instance, |unit| Ok(unit.start_at(start_s))) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $begin(instance: *mut c_void) -> c_int {
            unsafe { with(instance, $crate::unit::Unit::begin) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $terminate(instance: *mut c_void) -> c_int {
            unsafe { with(instance, |_| Ok(())) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $reset(instance: *mut c_void) -> c_int {
            unsafe { with(instance, |unit| Ok(unit.reset())) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get_state(
            instance: *mut c_void,
            state: *mut *mut c_void,
        ) -> c_int {
            unsafe { $crate::c::get_state(instance, state) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set_state(instance: *mut c_void, state: *mut c_void) -> c_int {
            unsafe { $crate::c::set_state(instance, state) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $free_state(
            _instance: *mut c_void,
            state: *mut *mut c_void,
        ) -> c_int {
            unsafe { $crate::c::free_state(state) }
        }
    };
}

/// Functions of the standard that a unit of numbers without modes and clocks does not have. Tools look for all.
#[macro_export]
macro_rules! lacking {
    ($($name:ident)*) => {
        $(
            #[doc = "Not supported."]
            #[unsafe(no_mangle)]
            pub extern "C" fn $name() -> std::ffi::c_int {
                $crate::c::ERROR
            }
        )*
    };
}
