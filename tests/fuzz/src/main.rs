//! The fuzzer of one target, named by the environment variable `FUZZ_TARGET`; its arguments are libFuzzer's.

#![no_main]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::OnceLock;

use fuzz::{Target, target};
use libfuzzer_sys::fuzz_target;

static TARGET: OnceLock<&'static Target> = OnceLock::new();

/// The target that is asked for.
fn chosen() -> &'static Target {
    let name = std::env::var("FUZZ_TARGET").unwrap_or_default();
    target(&name).unwrap_or_else(|| {
        diagnostics::output::note(format_args!(
            "error: FUZZ_TARGET is `{name}`\n  do:  name one of the folders in tests/fuzz/seeds"
        ));
        std::process::exit(1)
    })
}

fuzz_target!(
    init: {
        // A reader may catch a panic of a library that it calls. The engine's own hook would end the program before it does.
        std::panic::set_hook(Box::new(|_| {}));
    },
    |bytes: &[u8]| {
        let run = TARGET.get_or_init(chosen).run;
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| run(bytes))) {
            let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
            diagnostics::output::note(format_args!("the reader panicked: {}", text.unwrap_or("no message")));
            std::process::abort();
        }
    }
);
