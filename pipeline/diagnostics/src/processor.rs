//! The processor that a program is compiled for: on an older one it ends with a sentence instead of an illegal instruction.
//!
//! `is_x86_feature_detected!` is no help: in a program that is compiled for a feature it is true, whatever the processor. So the
//! instruction `cpuid` is asked, and nothing else runs before: a string that is formatted or a struct that is moved may take AVX.

use std::process::ExitCode;

/// What a processor without them reads.
const REFUSAL: &[u8] = b"error: this program cannot run on this processor\n  \
    why: it is compiled for x86-64-v3, of which AVX2, FMA or another instruction set is missing here\n  \
    do:  run it on an Intel Core or Xeon since 2013 or an AMD processor since 2015, or compile it here with RUSTFLAGS=-Ctarget-cpu=native\n";

/// Runs a program where the processor has what the program is compiled for; says so and fails otherwise.
// Not inlined, nor is the program, whose first instructions may be of the newer kind.
#[inline(never)]
pub fn run(program: fn() -> ExitCode) -> ExitCode {
    if is_new_enough() { program() } else { refuse_processor() }
}

#[inline(never)]
fn refuse_processor() -> ExitCode {
    use std::io::Write;
    // where the reader of standard error has gone, the exit code still tells
    drop(std::io::stderr().write_all(REFUSAL));
    ExitCode::FAILURE
}

#[cfg(not(target_arch = "x86_64"))]
fn is_new_enough() -> bool {
    true
}

/// Bits of a register that features have which the program is compiled for.
#[cfg(target_arch = "x86_64")]
const fn feature_bits(features: &[(bool, u32)]) -> u32 {
    let (mut bits, mut k) = (0, 0);
    while k < features.len() {
        bits |= (features[k].0 as u32) << features[k].1;
        k += 1;
    }
    bits
}

/// ECX of leaf 1; bit 27: the system keeps AVX registers.
#[cfg(target_arch = "x86_64")]
const FIRST: u32 = feature_bits(&[
    (cfg!(target_feature = "sse3"), 0),
    (cfg!(target_feature = "ssse3"), 9),
    (cfg!(target_feature = "fma"), 12),
    (cfg!(target_feature = "cmpxchg16b"), 13),
    (cfg!(target_feature = "sse4.1"), 19),
    (cfg!(target_feature = "sse4.2"), 20),
    (cfg!(target_feature = "movbe"), 22),
    (cfg!(target_feature = "popcnt"), 23),
    (cfg!(target_feature = "avx"), 27),
    (cfg!(target_feature = "avx"), 28),
    (cfg!(target_feature = "f16c"), 29),
]);
/// EBX of leaf 7.
#[cfg(target_arch = "x86_64")]
const SEVENTH: u32 = feature_bits(&[
    (cfg!(target_feature = "bmi1"), 3),
    (cfg!(target_feature = "avx2"), 5),
    (cfg!(target_feature = "bmi2"), 8),
    (cfg!(target_feature = "avx512f"), 16),
]);
/// ECX of leaf 0x8000_0001.
#[cfg(target_arch = "x86_64")]
const EXTENDED: u32 = feature_bits(&[(cfg!(target_feature = "lzcnt"), 5)]);

/// Whether the processor has the features that the program is compiled for, of those of x86-64-v3.
#[cfg(target_arch = "x86_64")]
fn is_new_enough() -> bool {
    use std::arch::x86_64::__cpuid;
    let has = |leaf: u32, of: fn(u32) -> u32, bits: u32| {
        bits == 0 || __cpuid(leaf & 0x8000_0000).eax >= leaf && of(leaf) & bits == bits
    };
    has(1, |leaf| __cpuid(leaf).ecx, FIRST)
        && has(7, |leaf| __cpuid(leaf).ebx, SEVENTH)
        && has(0x8000_0001, |leaf| __cpuid(leaf).ecx, EXTENDED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_processor_that_compiles_runs_the_program() {
        assert!(is_new_enough());
        assert_eq!(run(|| ExitCode::from(7)), ExitCode::from(7));
    }

    #[test]
    fn a_processor_that_cannot_run_it_fails_with_three_parts() {
        assert_eq!(refuse_processor(), ExitCode::FAILURE);
        let text = std::str::from_utf8(REFUSAL).unwrap();
        assert!(text.contains("\n  why: ") && text.contains("\n  do:  ") && text.lines().count() == 3);
    }
}
