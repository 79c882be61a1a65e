//! A step takes no memory from the system: nothing in a controller's loop waits for it.
#![allow(clippy::unwrap_used)] // tests

use std::alloc::System;

use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use twin::Twin;
use twin::example::beam;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

// one test alone in its program: another thread's memory would be counted
#[test]
fn no_step_takes_memory_in_air_or_in_water_the_first_included() {
    // the test program's main thread still takes memory as it begins to wait, later the busier the machine
    std::thread::sleep(std::time::Duration::from_millis(500));
    for wet in [false, true] {
        let twin = Twin::new(beam(wet)).unwrap();
        let mut state = twin.start();
        let tangents = state.work().tangents;
        let region = Region::new(ALLOCATOR);
        for n in 0..2000 {
            let pressure = 2e4 * (0.012 * f64::from(n)).sin();
            twin.step(&mut state, &[pressure.max(0.0), (-pressure).max(0.0)], 1e-3).unwrap();
        }
        let change = region.change();
        assert_eq!((change.allocations, change.reallocations), (0, 0), "wet: {wet}");
        assert!(state.work().tangents > tangents && state.work().steps == 2000, "no step was halved");
    }
}
