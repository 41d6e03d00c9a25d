//! The C interface of FMI 3.0 over an [`Instance`]: the functions of co-simulation, and every other one with the answer that it is not
//! provided, because tools look all of them up when they load a library.
//!
//! A handle is used by one thread at a time, as FMI demands; handles do not know of each other. No panic crosses the border: it is
//! an error of the instance, with its words in the simulator's log.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_void};
use std::panic::{self, AssertUnwindSafe};
use std::path::PathBuf;

use crate::instance::{Instance, Refusal};
use crate::package::{CHANNEL, RIG, token};

/// `fmi3Status`: done.
pub const OK: i32 = 0;
/// `fmi3Status`: the instance is as before, and this was refused.
pub const ERROR: i32 = 3;

type Handle = *mut c_void;
type LogMessage = Option<unsafe extern "C" fn(Handle, i32, *const c_char, *const c_char)>;

/// What a handle points to.
struct Slave {
    instance: Instance,
    log: LogMessage,
    environment: Handle,
}

impl Slave {
    fn say(&self, words: &str) {
        let (Some(log), Ok(words)) = (self.log, CString::new(words.replace('\0', " "))) else { return };
        // SAFETY: the simulator's own function with its own environment, and texts that live through the call.
        unsafe { log(self.environment, ERROR, c"logStatusError".as_ptr(), words.as_ptr()) };
    }
}

/// Does something with what a handle points to; what it refuses is said in the simulator's log.
///
/// # Safety
/// `handle` is null or one of [`fmi3InstantiateCoSimulation`] that has not been freed, used by this thread alone.
unsafe fn with(handle: Handle, work: impl FnOnce(&mut Instance) -> Result<(), Refusal>) -> i32 {
    // SAFETY: as the caller promises.
    let Some(slave) = (unsafe { handle.cast::<Slave>().as_mut() }) else { return ERROR };
    let done = panic::catch_unwind(AssertUnwindSafe(|| work(&mut slave.instance)));
    match done.unwrap_or_else(|_| Err(Refusal("a fault of the program: please report it".into()))) {
        Ok(()) => OK,
        Err(refusal) => {
            slave.say(&refusal.0);
            ERROR
        }
    }
}

/// The numbers a caller points to; `None` where there are none to point to.
///
/// # Safety
/// `values` is null or points to `count` of them that live through the call.
unsafe fn slice<'a, T>(values: *const T, count: usize) -> Option<&'a [T]> {
    match (count, values.is_null()) {
        (0, _) => Some(&[]),
        (_, true) => None,
        // SAFETY: as the caller promises.
        _ => Some(unsafe { std::slice::from_raw_parts(values, count) }),
    }
}

/// A text of the caller's.
///
/// # Safety
/// `text` is null or a string that ends with a zero and lives through the call.
unsafe fn text(text: *const c_char) -> Option<String> {
    // SAFETY: as the caller promises.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned())
}

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Makes an instance; null where that cannot be, with the reason in the log.
///
/// # Safety
/// As FMI 3.0 demands of the caller: strings end with a zero, and `log_message` is its own function.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // they are the standard's
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _instance_name: *const c_char,
    instantiation_token: *const c_char,
    resource_path: *const c_char,
    _visible: bool,
    _logging_on: bool,
    _event_mode_used: bool,
    _early_return_allowed: bool,
    _required_intermediate_variables: *const u32,
    _n_required_intermediate_variables: usize,
    instance_environment: Handle,
    log_message: LogMessage,
    _intermediate_update: *const c_void,
) -> Handle {
    // SAFETY: as the caller promises.
    let (given, resources) = unsafe { (text(instantiation_token), text(resource_path)) };
    let made = panic::catch_unwind(|| instance(given, resources));
    let made = made.unwrap_or_else(|_| Err(Refusal("a fault of the program: please report it".into())));
    match made {
        Ok(instance) => {
            Box::into_raw(Box::new(Slave { instance, log: log_message, environment: instance_environment })).cast()
        }
        Err(refusal) => {
            if let (Some(log), Ok(words)) = (log_message, CString::new(refusal.0.replace('\0', " "))) {
                // SAFETY: the simulator's own function with its own environment, and texts that live through the call.
                unsafe { log(instance_environment, ERROR, c"logStatusError".as_ptr(), words.as_ptr()) };
            }
            std::ptr::null_mut()
        }
    }
}

fn instance(given: Option<String>, resources: Option<String>) -> Result<Instance, Refusal> {
    let folder = PathBuf::from(resources.ok_or_else(|| Refusal("no path of resources was given".into()))?);
    let read = |name: &str| {
        let path = folder.join(name);
        std::fs::read_to_string(&path).map_err(|error| Refusal(format!("{}: {error}", path.display())))
    };
    let (rig, channel) = (read(RIG)?, read(CHANNEL)?);
    if given.as_deref() != Some(token(&rig, &channel).as_str()) {
        return Err(Refusal("the instantiation token is not of this FMU: its files have been changed or mixed".into()));
    }
    Instance::new(&rig, RIG, &channel)
}

/// Frees an instance; null is nothing.
///
/// # Safety
/// `instance` is null or a handle that has not been freed; it is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: Handle) {
    if !instance.is_null() {
        // SAFETY: it was made by `Box::into_raw`, and as the caller promises is not freed twice.
        drop(unsafe { Box::from_raw(instance.cast::<Slave>()) });
    }
}

/// Nothing is logged but errors, which are always said.
///
/// # Safety
/// None is needed: nothing is read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(_: Handle, _: bool, _: usize, _: *const *const c_char) -> i32 {
    OK
}

/// Remembers the start; the wire is at rest when the initialisation ends, under the inputs as they are then.
///
/// # Safety
/// `instance` is null or a handle that has not been freed, used by this thread alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: Handle,
    _tolerance_defined: bool,
    _tolerance: f64,
    start_time: f64,
    _stop_time_defined: bool,
    _stop_time: f64,
) -> i32 {
    // SAFETY: as the caller promises.
    unsafe { with(instance, |instance| instance.begin(start_time)) }
}

/// The wire is at rest under the inputs as they are.
///
/// # Safety
/// `instance` is null or a handle that has not been freed, used by this thread alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: Handle) -> i32 {
    // SAFETY: as the caller promises.
    unsafe { with(instance, Instance::initialise) }
}

/// Steps the wire.
///
/// # Safety
/// `instance` is null or a handle that has not been freed, used by this thread alone; the four results are null or writable.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // they are the standard's
pub unsafe extern "C" fn fmi3DoStep(
    instance: Handle,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_fmu_state_prior_to_current_point: bool,
    event_handling_needed: *mut bool,
    terminate_simulation: *mut bool,
    early_return: *mut bool,
    last_successful_time: *mut f64,
) -> i32 {
    for flag in [event_handling_needed, terminate_simulation, early_return] {
        if !flag.is_null() {
            // SAFETY: writable, as the caller promises.
            unsafe { flag.write(false) };
        }
    }
    let mut reached_s = current_communication_point;
    let step = |instance: &mut Instance| {
        let stepped = instance.step(current_communication_point, communication_step_size);
        reached_s = instance.time_s();
        stepped
    };
    // SAFETY: as the caller promises.
    let status = unsafe { with(instance, step) };
    if !last_successful_time.is_null() {
        // SAFETY: writable, as the caller promises.
        unsafe { last_successful_time.write(reached_s) };
    }
    status
}

/// Values of variables.
///
/// # Safety
/// `instance` is null or a handle that has not been freed, used by this thread alone; `references` and `values` point to as many as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: Handle,
    references: *const u32,
    n_references: usize,
    values: *mut f64,
    n_values: usize,
) -> i32 {
    let get = |instance: &mut Instance| {
        // SAFETY: as the caller promises.
        let references = unsafe { slice(references, n_references) };
        let Some(references) = references.filter(|r| r.len() == n_values && (n_values == 0 || !values.is_null()))
        else {
            return Err(Refusal("as many values as references are needed".into()));
        };
        for (place, reference) in references.iter().enumerate() {
            let value = instance.get(*reference)?;
            // SAFETY: there are `n_values`, as the caller promises.
            unsafe { values.add(place).write(value) };
        }
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { with(instance, get) }
}

/// Sets variables.
///
/// # Safety
/// `instance` is null or a handle that has not been freed, used by this thread alone; `references` and `values` point to as many as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: Handle,
    references: *const u32,
    n_references: usize,
    values: *const f64,
    n_values: usize,
) -> i32 {
    let set = |instance: &mut Instance| {
        // SAFETY: as the caller promises.
        let (references, values) = unsafe { (slice(references, n_references), slice(values, n_values)) };
        match (references, values) {
            (Some(references), Some(values)) if references.len() == values.len() => {
                references.iter().zip(values).try_for_each(|(reference, value)| instance.set(*reference, *value))
            }
            _ => Err(Refusal("as many values as references are needed".into())),
        }
    };
    // SAFETY: as the caller promises.
    unsafe { with(instance, set) }
}

/// As it was made.
///
/// # Safety
/// `instance` is null or a handle that has not been freed, used by this thread alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: Handle) -> i32 {
    let reset = |instance: &mut Instance| {
        instance.reset();
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { with(instance, reset) }
}

/// Keeps a copy of the simulation.
///
/// # Safety
/// `instance` is null or a handle that has not been freed, used by this thread alone; `state` is writable, and null or a copy of this library's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: Handle, state: *mut Handle) -> i32 {
    let keep = |instance: &mut Instance| {
        if state.is_null() {
            return Err(Refusal("there is no place for the state".into()));
        }
        // SAFETY: writable, and null or of `Box::into_raw`, as the caller promises.
        unsafe {
            match (*state).cast::<Instance>().as_mut() {
                Some(kept) => *kept = instance.clone(),
                None => *state = Box::into_raw(Box::new(instance.clone())).cast(),
            }
        }
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { with(instance, keep) }
}

/// Goes back to a copy.
///
/// # Safety
/// `instance` is null or a handle that has not been freed, used by this thread alone; `state` is null or a copy of this library's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: Handle, state: Handle) -> i32 {
    let go_back = |instance: &mut Instance| {
        // SAFETY: as the caller promises.
        match unsafe { state.cast::<Instance>().as_ref() } {
            Some(kept) => *instance = kept.clone(),
            None => return Err(Refusal("there is no state to go back to".into())),
        }
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { with(instance, go_back) }
}

/// Frees a copy.
///
/// # Safety
/// `state` is writable, and null or a copy of this library's that is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(_: Handle, state: *mut Handle) -> i32 {
    // SAFETY: as the caller promises.
    unsafe {
        if !state.is_null() && !(*state).is_null() {
            drop(Box::from_raw((*state).cast::<Instance>()));
            *state = std::ptr::null_mut();
        }
    }
    OK
}

/// Functions that have nothing to do here and succeed.
macro_rules! nothing_to_do {
    ($($name:ident)+) => { $(
        /// Nothing has to be done for it.
        ///
        /// # Safety
        /// None is needed: nothing is read.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(_: Handle) -> i32 {
            OK
        }
    )+ };
}

nothing_to_do! { fmi3Terminate fmi3EnterStepMode fmi3EnterEventMode fmi3EnterConfigurationMode fmi3ExitConfigurationMode }

/// Functions of other kinds of simulation and of variables there are none of. Whatever the arguments, they touch none of them: in the C calling
/// conventions of the machines this is built for, the caller clears them away.
macro_rules! not_provided {
    ($($name:ident)+) => { $(
        /// Not provided.
        ///
        /// # Safety
        /// None is needed: nothing is read.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name() -> i32 {
            ERROR
        }
    )+ };
}

not_provided! {
    fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetInt32 fmi3GetUInt32 fmi3GetInt64 fmi3GetUInt64
    fmi3GetBoolean fmi3GetString fmi3GetBinary fmi3GetClock
    fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt16 fmi3SetInt32 fmi3SetUInt32 fmi3SetInt64 fmi3SetUInt64
    fmi3SetBoolean fmi3SetString fmi3SetBinary fmi3SetClock
    fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies
    fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState
    fmi3GetDirectionalDerivative fmi3GetAdjointDerivative
    fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetShiftDecimal fmi3GetShiftFraction
    fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction
    fmi3EvaluateDiscreteStates fmi3UpdateDiscreteStates
    fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep fmi3SetTime fmi3SetContinuousStates fmi3GetContinuousStateDerivatives
    fmi3GetEventIndicators fmi3GetContinuousStates fmi3GetNominalsOfContinuousStates fmi3GetNumberOfEventIndicators
    fmi3GetNumberOfContinuousStates fmi3GetOutputDerivatives fmi3ActivateModelPartition
}

/// Functions that would make an instance of another kind.
macro_rules! no_such_instance {
    ($($name:ident)+) => { $(
        /// There is no instance of this kind.
        ///
        /// # Safety
        /// None is needed: nothing is read.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name() -> Handle {
            std::ptr::null_mut()
        }
    )+ };
}

no_such_instance! { fmi3InstantiateModelExchange fmi3InstantiateScheduledExecution }
