//! The functions of `twin.h`: a reduced tail for C.
//!
//! Pointers are those that these functions gave, or null, which is an error and no crash. No panic passes into C.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_long};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use twin::{Twin, TwinState};

/// A tail with its names as C reads them.
pub struct Tail {
    twin: Twin,
    chambers: Vec<CString>,
    outputs: Vec<CString>,
}

thread_local! {
    static ERROR: RefCell<CString> = RefCell::default();
}

/// Keeps `message` for `twin_error`.
fn set_error(message: &str) {
    // a file's name may hold what ends a text of C
    ERROR.with(|error| *error.borrow_mut() = CString::new(message.replace('\0', " ")).unwrap_or_default());
}

/// What `call` gives, or `otherwise` with the error kept.
fn guarded<T>(otherwise: T, call: impl FnOnce() -> Result<T, String>) -> T {
    let outcome = catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|_| Err("a defect of the library".to_owned()));
    outcome.unwrap_or_else(|message| {
        set_error(&message);
        otherwise
    })
}

/// The thing at `pointer`.
///
/// # Safety
/// `pointer` is null, or of this library and not freed.
unsafe fn borrowed<'a, T>(pointer: *const T) -> Result<&'a T, String> {
    unsafe { pointer.as_ref() }.ok_or_else(|| "a null pointer was given\n  do:  give what twin_open or twin_start returned".to_owned())
}

/// The text at `pointer`.
///
/// # Safety
/// `pointer` is null, or of a text that ends in a zero.
unsafe fn text<'a>(pointer: *const c_char) -> Result<&'a str, String> {
    unsafe { borrowed(pointer) }?;
    unsafe { CStr::from_ptr(pointer) }.to_str().map_err(|_| "a text is not UTF-8".to_owned())
}

fn message_of(error: impl std::fmt::Display) -> String {
    error.to_string()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_open(path: *const c_char) -> *mut Tail {
    guarded(std::ptr::null_mut(), || {
        let twin = Twin::new(twin::file::read(Path::new(unsafe { text(path) }?)).map_err(message_of)?).map_err(message_of)?;
        let names = |names: Vec<&str>| names.into_iter().map(CString::new).collect::<Result<Vec<_>, _>>().map_err(message_of);
        let chambers = names(twin.chambers().iter().map(|chamber| &*chamber.name).collect())?;
        let outputs = names(twin.outputs().collect())?;
        Ok(Box::into_raw(Box::new(Tail { twin, chambers, outputs })))
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_free(tail: *mut Tail) {
    if !tail.is_null() {
        drop(unsafe { Box::from_raw(tail) });
    }
}

#[unsafe(no_mangle)]
pub extern "C" fn twin_error() -> *const c_char {
    ERROR.with(|error| error.borrow().as_ptr())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_chambers(tail: *const Tail) -> usize {
    guarded(0, || Ok(unsafe { borrowed(tail) }?.chambers.len()))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_outputs(tail: *const Tail) -> usize {
    guarded(0, || Ok(unsafe { borrowed(tail) }?.outputs.len()))
}

/// The name with this number.
fn name(names: &[CString], number: usize) -> Result<*const c_char, String> {
    names.get(number).map(|name| name.as_ptr()).ok_or_else(|| format!("there is no number {number} of {}", names.len()))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_chamber_name(tail: *const Tail, chamber: usize) -> *const c_char {
    guarded(std::ptr::null(), || name(&unsafe { borrowed(tail) }?.chambers, chamber))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_output_name(tail: *const Tail, output: usize) -> *const c_char {
    guarded(std::ptr::null(), || name(&unsafe { borrowed(tail) }?.outputs, output))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_output_number(tail: *const Tail, name: *const c_char) -> c_long {
    guarded(-1, || {
        let number = unsafe { borrowed(tail) }?.twin.output_number(unsafe { text(name) }?).map_err(message_of)?;
        c_long::try_from(number).map_err(message_of)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_chamber_range(tail: *const Tail, chamber: usize, range: *mut f64) -> c_int {
    guarded(1, || {
        let chambers = unsafe { borrowed(tail) }?.twin.chambers();
        let known = chambers.get(chamber).ok_or_else(|| format!("there is no chamber {chamber} of {}", chambers.len()))?;
        unsafe { borrowed(range) }?;
        unsafe { range.cast::<[f64; 2]>().write(known.range) };
        Ok(0)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_start(tail: *const Tail) -> *mut TwinState {
    guarded(std::ptr::null_mut(), || Ok(Box::into_raw(Box::new(unsafe { borrowed(tail) }?.twin.start()))))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_state_free(state: *mut TwinState) {
    if !state.is_null() {
        drop(unsafe { Box::from_raw(state) });
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_step(
    tail: *const Tail,
    state: *mut TwinState,
    pressures: *const f64,
    duration: f64,
) -> c_int {
    guarded(1, || {
        let (tail, _) = (unsafe { borrowed(tail) }?, unsafe { borrowed(state) }?);
        let pressures = match tail.chambers.len() {
            0 => &[],
            chambers => {
                unsafe { borrowed(pressures) }?;
                unsafe { std::slice::from_raw_parts(pressures, chambers) }
            }
        };
        tail.twin.step(unsafe { &mut *state }, pressures, duration).map_err(message_of)?;
        Ok(0)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_time(state: *const TwinState) -> f64 {
    guarded(f64::NAN, || Ok(unsafe { borrowed(state) }?.time()))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_output(tail: *const Tail, state: *const TwinState, output: usize) -> f64 {
    guarded(f64::NAN, || {
        let (tail, state) = (unsafe { borrowed(tail) }?, unsafe { borrowed(state) }?);
        name(&tail.outputs, output)?;
        Ok(tail.twin.output(state, output))
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_volume(tail: *const Tail, state: *const TwinState, chamber: usize) -> f64 {
    guarded(f64::NAN, || {
        let (tail, state) = (unsafe { borrowed(tail) }?, unsafe { borrowed(state) }?);
        name(&tail.chambers, chamber)?;
        Ok(tail.twin.chamber_volume(state, chamber))
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_excursion(tail: *const Tail, state: *const TwinState) -> f64 {
    guarded(f64::NAN, || Ok(unsafe { borrowed(tail) }?.twin.excursion(unsafe { borrowed(state) }?)))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_save(
    tail: *const Tail,
    state: *const TwinState,
    bytes: *mut u8,
    length: *mut usize,
) -> c_int {
    guarded(1, || {
        let saved = unsafe { borrowed(tail) }?.twin.saved(unsafe { borrowed(state) }?).map_err(message_of)?;
        let room = *unsafe { borrowed(length) }?;
        unsafe { length.write(saved.len()) };
        if bytes.is_null() {
            return Ok(0);
        }
        if room < saved.len() {
            return Err(format!("the state has {} bytes, and there is room for {room}", saved.len()));
        }
        unsafe { std::ptr::copy_nonoverlapping(saved.as_ptr(), bytes, saved.len()) };
        Ok(0)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn twin_restore(tail: *const Tail, bytes: *const u8, length: usize) -> *mut TwinState {
    guarded(std::ptr::null_mut(), || {
        let tail = unsafe { borrowed(tail) }?;
        unsafe { borrowed(bytes) }?;
        let state = tail.twin.restored(unsafe { std::slice::from_raw_parts(bytes, length) }).map_err(message_of)?;
        Ok(Box::into_raw(Box::new(state)))
    })
}
