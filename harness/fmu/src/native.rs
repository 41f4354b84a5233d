//! The library of an FMU: loaded, and called.

mod three;
mod two;

use crate::Loaded;
use crate::archive::Copied;
use crate::model::{Kind, Model, Version};
use described::FmuInstance;
use libloading::os::unix::{Library as Object, RTLD_LOCAL, RTLD_NOW};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::fmt;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

type Component = *mut c_void;

/// Longest message of a library that is shown.
const MESSAGE_CHARS_MAX: usize = 300;

/// `fmi2Status` and `fmi3Status`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Status(c_int);

impl Status {
    const OK: Self = Self(0);
    const WARNING: Self = Self(1);
    const FATAL: Self = Self(4);
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const NAMES: [&str; 6] = ["OK", "Warning", "Discard", "Error", "Fatal", "Pending"];
        let name = usize::try_from(self.0).ok().and_then(|place| NAMES.get(place));
        match name {
            Some(name) => f.write_str(name),
            None => write!(f, "status {}", self.0),
        }
    }
}

struct Stepped {
    status: Status,
    /// Where it ended if that is not the end of the step.
    early: Option<f64>,
    wants_end: bool,
}

/// The functions of one version of the standard.
///
/// # Safety
///
/// Each `component` is a live instance of this library that no other thread uses now. After [`Self::free`] it is gone.
trait Calls: fmt::Debug + Send + Sync {
    /// The prefix of their names.
    fn prefix(&self) -> &'static str;
    /// The type of a variable in the names of functions.
    fn type_name(&self, kind: Kind) -> String;
    unsafe fn instantiate(&self, token: &CStr, resources: &Path, log: &Arc<Log>) -> Component;
    unsafe fn enter_initialization(&self, component: Component) -> Status;
    unsafe fn exit_initialization(&self, component: Component) -> Status;
    unsafe fn set(&self, component: Component, reference: u32, kind: Kind, value: f64) -> Status;
    unsafe fn get(&self, component: Component, reference: u32, kind: Kind) -> (Status, f64);
    unsafe fn step(&self, component: Component, from_s: f64, length_s: f64) -> Stepped;
    unsafe fn terminate(&self, component: Component) -> Status;
    unsafe fn free(&self, component: Component);
}

/// A loaded library.
#[derive(Debug)]
pub struct Library {
    calls: Box<dyn Calls>,
    // Behind its functions: it goes last.
    _object: Object,
}

impl Library {
    /// Loads the library in this file.
    pub fn load(path: &Path, version: Version) -> Result<Self, String> {
        if cfg!(target_feature = "crt-static") {
            return Err("this hil is a static program, which loads no libraries: use one of the other packages".to_owned());
        }
        // SAFETY: what runs when it is loaded is up to whoever names the FMU, as with any program.
        let object = unsafe { Object::open(Some(path), RTLD_NOW | RTLD_LOCAL) };
        let object = object.map_err(|error| {
            let text =
                std::error::Error::source(&error).map_or(error.to_string(), ToString::to_string);
            // The folder is another one each time.
            let folder = path.parent().unwrap_or(path).display().to_string();
            format!("failed to load its library: {}", text.replace(&format!("{folder}/"), ""))
        })?;
        let calls: Box<dyn Calls> = match version {
            Version::Two => Box::new(two::Functions::of(&object)?),
            Version::Three => Box::new(three::Functions::of(&object)?),
        };
        Ok(Self { calls, _object: object })
    }
}

/// Finds a function of a library.
///
/// # Safety
///
/// `F` is the type of that function.
unsafe fn function<F: Copy>(object: &Object, name: &CStr) -> Result<F, String> {
    // SAFETY: the caller knows its type.
    let found = unsafe { object.get::<F>(name.to_bytes_with_nul()) };
    found.map(|found| *found).map_err(|_| format!("its library has no {}", name.to_string_lossy()))
}

/// Declares the functions of a version, and finds them in a library.
macro_rules! functions {
    ($($field:ident: $symbol:literal, $kind:ty;)*) => {
        #[derive(Debug)]
        pub(super) struct Functions {
            $($field: $kind,)*
        }

        impl Functions {
            pub(super) fn of(object: &libloading::os::unix::Library) -> Result<Self, String> {
                // SAFETY: the types are those of the standard.
                unsafe { Ok(Self { $($field: super::function(object, $symbol)?,)* }) }
            }
        }
    };
}
use functions;

/// The last message of a library that warns or complains.
#[derive(Debug, Default)]
struct Log(Mutex<String>);

impl Log {
    fn pointer(self: &Arc<Self>) -> *mut c_void {
        Arc::as_ptr(self).cast_mut().cast()
    }

    fn take(&self) -> String {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Keeps a message.
    ///
    /// # Safety
    ///
    /// `environment` is null or of [`Self::pointer`] of a live log, and `message` is null or a text.
    unsafe fn keep(environment: *mut c_void, status: Status, message: *const c_char) {
        if environment.is_null() || message.is_null() || status == Status::OK {
            return;
        }
        // SAFETY: the caller says so; a log is only ever shared.
        let (log, message) = unsafe { (&*environment.cast::<Self>(), CStr::from_ptr(message)) };
        let message = message.to_string_lossy();
        let message = message.trim().chars().take(MESSAGE_CHARS_MAX).collect();
        *log.0.lock().unwrap_or_else(PoisonError::into_inner) = message;
    }
}

/// A running instance.
#[derive(Debug)]
pub struct Instance {
    component: Component,
    /// Whether it may still be terminated, and freed.
    state: State,
    model: Arc<Model>,
    log: Arc<Log>,
    /// The library, if it is a copy for this instance alone, and its file.
    own: Option<(Library, Copied)>,
    loaded: Arc<Loaded>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Initialising,
    Running,
    Failed,
    /// After a fatal error the library must not be called again.
    Dead,
}

// SAFETY: an instance is used by one thread at a time, as every function that calls it takes it exclusively, and the
// standard lets instances of one library live in several threads.
unsafe impl Send for Instance {}
// SAFETY: nothing calls it by a shared reference.
unsafe impl Sync for Instance {}

impl Instance {
    pub fn start(
        model: &Arc<Model>,
        loaded: &Arc<Loaded>,
        parameters: &[(usize, f64)],
    ) -> Result<Self, String> {
        let own = match model.once_per_process {
            false => None,
            // A copy of the file is another library, with variables of its own.
            true => {
                let copied = loaded.files.copy()?;
                Some((Library::load(&copied.path, model.version)?, copied))
            }
        };
        let library = own.as_ref().map_or(&loaded.library, |(library, _)| library);
        let log = Arc::new(Log::default());
        let token = CString::new(model.token.as_str()).unwrap_or_default();
        // SAFETY: the log outlives the instance, which has it.
        let component = unsafe { library.calls.instantiate(&token, &loaded.files.resources, &log) };
        if component.is_null() {
            return Err(format!("it makes no instance of itself{}", behind(&log.take())));
        }
        let (model, loaded) = (Arc::clone(model), Arc::clone(loaded));
        let state = State::Initialising;
        let mut instance = Self { component, state, model, log, own, loaded };
        for (place, value) in parameters {
            instance.set(*place, *value)?;
        }
        instance.call("EnterInitializationMode", |calls, component| {
            // SAFETY: the instance is live.
            unsafe { calls.enter_initialization(component) }
        })?;
        Ok(instance)
    }

    fn calls(&self) -> &dyn Calls {
        &*self.own.as_ref().map_or(&self.loaded.library, |(library, _)| library).calls
    }

    fn call(
        &mut self,
        name: &str,
        act: impl FnOnce(&dyn Calls, Component) -> Status,
    ) -> Result<(), String> {
        let status = act(self.calls(), self.component);
        self.judged(name, status)
    }

    fn judged(&mut self, name: &str, status: Status) -> Result<(), String> {
        if [Status::OK, Status::WARNING].contains(&status) {
            return Ok(());
        }
        self.state = if status == Status::FATAL { State::Dead } else { State::Failed };
        let prefix = self.calls().prefix();
        Err(format!("{prefix}{name} returned {status}{}", behind(&self.log.take())))
    }

    fn about(&self, variable: usize, error: &str) -> String {
        let variable = &self.model.variables[variable];
        let (kind, name) = (self.calls().type_name(variable.kind), &variable.public.name);
        error.replacen("et returned", &format!("et{kind} of `{name}` returned"), 1)
    }
}

fn behind(message: &str) -> String {
    if message.is_empty() { String::new() } else { format!(": {message}") }
}

impl FmuInstance for Instance {
    fn begin(&mut self) -> Result<(), String> {
        self.call("ExitInitializationMode", |calls, component| {
            // SAFETY: the instance is live.
            unsafe { calls.exit_initialization(component) }
        })?;
        self.state = State::Running;
        Ok(())
    }

    fn set(&mut self, variable: usize, value: f64) -> Result<(), String> {
        let (reference, kind) = self.model.variables[variable].place();
        if kind.range().is_some_and(|range| !range.contains(&value.round())) {
            return Err(format!(
                "`{}` cannot be {value}",
                self.model.variables[variable].public.name
            ));
        }
        self.call("Set", |calls, component| {
            // SAFETY: the instance is live.
            unsafe { calls.set(component, reference, kind, value) }
        })
        .map_err(|error| self.about(variable, &error))
    }

    fn get(&mut self, variable: usize) -> Result<f64, String> {
        let (reference, kind) = self.model.variables[variable].place();
        // SAFETY: the instance is live.
        let (status, value) = unsafe { self.calls().get(self.component, reference, kind) };
        self.judged("Get", status).map_err(|error| self.about(variable, &error))?;
        Ok(value)
    }

    fn step(&mut self, from_s: f64, length_s: f64) -> Result<(), String> {
        // SAFETY: the instance is live.
        let stepped = unsafe { self.calls().step(self.component, from_s, length_s) };
        self.judged("DoStep", stepped.status)?;
        match stepped {
            Stepped { wants_end: true, .. } => {
                Err("it asks for the end of the simulation".to_owned())
            }
            Stepped { early: Some(early), .. } => {
                Err(format!("its step ended early, at {early} s"))
            }
            _ => Ok(()),
        }
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: the instance is live, and this is the last call.
        unsafe {
            if self.state == State::Running {
                self.calls().terminate(self.component);
            }
            if self.state != State::Dead {
                self.calls().free(self.component);
            }
        }
    }
}
