//! Panics of libraries, which become refusals: their text is not printed.

use std::cell::Cell;
use std::panic::{UnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether a panic of this thread is caught by [`quietly`].
    static CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// Once, so that hooks do not pile up.
static HOOK: Once = Once::new();

/// The result of `call`, or its panic, of which nothing is printed. Panics of other threads are printed as before.
///
/// # Errors
/// The panic's payload.
pub fn quietly<T>(call: impl FnOnce() -> T + UnwindSafe) -> std::thread::Result<T> {
    // The hook belongs to the process and is shared by its threads: each decides for itself, rather than take the hook away from all.
    HOOK.call_once(|| {
        let previous = take_hook();
        set_hook(Box::new(move |panic| {
            if !CAUGHT.try_with(Cell::get).unwrap_or(false) {
                previous(panic);
            }
        }));
    });
    let before = CAUGHT.replace(true);
    let result = catch_unwind(call);
    CAUGHT.set(before);
    result
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn a_caught_panic_is_not_printed_and_one_of_another_thread_is() {
        static PRINTED: Mutex<Vec<String>> = Mutex::new(Vec::new());
        set_hook(Box::new(|panic| {
            PRINTED.lock().unwrap().extend(panic.payload().downcast_ref::<&str>().map(|text| (*text).to_owned()));
        }));
        let caught = quietly(|| {
            assert!(std::thread::spawn(|| panic!("other")).join().is_err());
            assert!(quietly(|| panic!("inner")).is_err());
            panic!("own")
        });
        assert!(caught.is_err() && quietly(|| 3).is_ok_and(|three| three == 3));
        assert!(catch_unwind(|| panic!("later")).is_err());
        assert_eq!(*PRINTED.lock().unwrap(), ["other", "later"]);
    }
}
