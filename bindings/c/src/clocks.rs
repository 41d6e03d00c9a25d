//! Clocks beside the driver's: the system's, and a device's learnt from pairs of times.

use crate::border::{Failure, border, calm};
use crate::handles::{Handles, alone};
use crate::pointers::{Place, values};
use crate::status::Status;
use crate::structs::{ClockChange, ClockMap, ClockRules};
use sinew_ipc::{self as ipc, Mapped, Update};
use std::sync::Mutex;

static MAPS: Handles<Mutex<ipc::ClockMap>> = Handles::of("clock map");

/// The clock of all times in messages: CLOCK_MONOTONIC, ns.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_monotonic_ns() -> u64 {
    calm(0, ipc::monotonic_ns)
}

/// The system's time of a driver's stamp, ns since 1970 (UTC), and what that is off by at the most, ns: by a
/// comparison of the two clocks, made now. A stamp from before the system's clock was set comes out as that is set
/// now.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_system_time(monotonic_ns: u64, system_ns: *mut i64, error_ns: *mut u64) -> Status {
    border(|| {
        // SAFETY: the same pointers, handed on.
        unsafe { put(system_ns, "system_ns", error_ns, || Ok(Some(ipc::Clocks::now().system(monotonic_ns)))) }
    })
}

/// What is usual of another clock: to be changed where more is known, and handed to `sinew_clock_map`.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_clock_rules(rules: *mut ClockRules) -> Status {
    border(|| {
        // SAFETY: room for them.
        unsafe { Place::at(rules, "rules") }?.put(ipc::ClockRules::default().into());
        Ok(Status::SINEW_OK)
    })
}

/// Opens a map of a device's clock, a data acquisition's or a camera's, that knows nothing yet. `rules` may be
/// null: what is usual. Needs no driver.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_clock_map(rules: *const ClockRules, map: *mut *mut ClockMap) -> Status {
    border(|| {
        // SAFETY: room for a pointer.
        let place = unsafe { Place::at(map, "map") }?;
        place.put(std::ptr::null_mut());
        // SAFETY: one set of rules, or null.
        let rules = unsafe { values(rules, usize::from(!rules.is_null()), "rules") }?;
        let rules = rules.first().map_or_else(ipc::ClockRules::default, |rules| (*rules).into());
        place.put(MAPS.open(Mutex::new(ipc::ClockMap::new(rules))));
        Ok(Status::SINEW_OK)
    })
}

/// Adds a time the device showed between two of the driver's: before it was asked and after its answer came.
/// `change`, which may be null, gets whether the device's clock has been set meanwhile.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_clock_map_bracket(
    map: *mut ClockMap,
    before_ns: u64,
    other_ns: i64,
    after_ns: u64,
    change: *mut ClockChange,
) -> Status {
    // SAFETY: the same pointer, handed on.
    border(|| unsafe { add(map, change, |map| map.bracket(before_ns, other_ns, after_ns)) })
}

/// Adds two times of one moment, of which the driver's is off by `error_ns` at the most. `change` as above.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_clock_map_pair(
    map: *mut ClockMap,
    driver_ns: u64,
    other_ns: i64,
    error_ns: u64,
    change: *mut ClockChange,
) -> Status {
    // SAFETY: the same pointer, handed on.
    border(|| unsafe { add(map, change, |map| map.pair(driver_ns, other_ns, error_ns)) })
}

/// Adds a stamp of the device and when it was received, some unknown time later and never earlier, in the order in
/// which they were received. `change` as above.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_clock_map_late(
    map: *mut ClockMap,
    received_ns: u64,
    other_ns: i64,
    change: *mut ClockChange,
) -> Status {
    // SAFETY: the same pointer, handed on.
    border(|| unsafe { add(map, change, |map| map.late(received_ns, other_ns)) })
}

/// The driver's time of a time of the device, and what that is off by at the most, ns; `SINEW_NOTHING` where it is
/// not known: before enough pairs, and before the first pair since the device's clock was set.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_clock_map_driver_at(
    map: *const ClockMap,
    other_ns: i64,
    driver_ns: *mut u64,
    error_ns: *mut u64,
) -> Status {
    border(|| {
        // SAFETY: the same pointers, handed on.
        unsafe { put(driver_ns, "driver_ns", error_ns, || with(map, |map| map.driver_at(other_ns))) }
    })
}

/// The device's time of a driver's stamp, as above.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_clock_map_other_at(
    map: *const ClockMap,
    driver_ns: u64,
    other_ns: *mut i64,
    error_ns: *mut u64,
) -> Status {
    border(|| {
        // SAFETY: the same pointers, handed on.
        unsafe { put(other_ns, "other_ns", error_ns, || with(map, |map| map.other_at(driver_ns))) }
    })
}

/// What the device's clock runs fast by as of the latest pair, and what that is off by at the most, ppm;
/// `SINEW_NOTHING` where it is not known.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_clock_map_rate(map: *const ClockMap, rate_ppm: *mut f64, error_ppm: *mut f64) -> Status {
    border(|| {
        // SAFETY: room for a number each.
        let (rate, error) = unsafe { (Place::at(rate_ppm, "rate_ppm")?, Place::at(error_ppm, "error_ppm")?) };
        let Some((found, off)) = with(map, |map| map.rate_ppm())? else { return Ok(Status::SINEW_NOTHING) };
        rate.put(found);
        error.put(off);
        Ok(Status::SINEW_OK)
    })
}

/// Closes a map of a clock. Null is fine.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_clock_map_close(map: *mut ClockMap) -> Status {
    border(|| MAPS.close(map))
}

fn with<T>(map: *const ClockMap, act: impl FnOnce(&mut ipc::ClockMap) -> T) -> Result<T, Failure> {
    let map = MAPS.get(map)?;
    let mut map = alone("clock map", &map)?;
    Ok(act(&mut map))
}

/// # Safety
/// `change` is null or room for it.
unsafe fn add(
    map: *mut ClockMap,
    change: *mut ClockChange,
    add: impl FnOnce(&mut ipc::ClockMap) -> Update,
) -> Result<Status, Failure> {
    // SAFETY: the caller's word.
    let place = unsafe { Place::if_any(change, "change") }?;
    let update = with(map, add)?;
    place.inspect(|place| place.put(update.into()));
    Ok(Status::SINEW_OK)
}

/// # Safety
/// `ns` and `error_ns` are null, or each room for a number.
unsafe fn put<T: Copy>(
    ns: *mut T,
    name: &str,
    error_ns: *mut u64,
    find: impl FnOnce() -> Result<Option<Mapped<T>>, Failure>,
) -> Result<Status, Failure> {
    // SAFETY: the caller's word.
    let (time, error) = unsafe { (Place::at(ns, name)?, Place::at(error_ns, "error_ns")?) };
    let Some(at) = find()? else { return Ok(Status::SINEW_NOTHING) };
    time.put(at.ns);
    error.put(at.error_ns);
    Ok(Status::SINEW_OK)
}
