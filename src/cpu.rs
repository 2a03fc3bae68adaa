//! Whether this CPU can run this build.
//!
//! The build assumes x86-64-v3, so the compiler may put AVX2 anywhere, and
//! `is_x86_feature_detected!` answers "yes" without looking. This asks the CPU itself, with
//! nothing but integer arithmetic on the way to the answer and to the message: a test runs the
//! command on an emulated CPU without AVX, where any other instruction would end it.

use std::io::Write;

/// Whether the CPU has what the build assumes.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
#[inline(never)]
pub fn suffices() -> bool {
    use std::arch::x86_64::__cpuid;

    // Intel SDM vol. 2A, CPUID: FMA, MOVBE, OSXSAVE (the system keeps wide registers), AVX,
    // F16C in leaf 1; BMI1, AVX2, BMI2 in leaf 7; LZCNT in leaf 8000_0001.
    const LEAF_1_ECX: u32 = 1 << 12 | 1 << 22 | 1 << 27 | 1 << 28 | 1 << 29;
    const LEAF_7_EBX: u32 = 1 << 3 | 1 << 5 | 1 << 8;
    __cpuid(0).eax >= 7
        && __cpuid(1).ecx & LEAF_1_ECX == LEAF_1_ECX
        && __cpuid(7).ebx & LEAF_7_EBX == LEAF_7_EBX
        && __cpuid(0x8000_0001).ecx & (1 << 5) != 0
}

/// Portable builds run everywhere.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
pub fn suffices() -> bool {
    true
}

/// Says what to do, and ends the command with exit code 2 at once: the way back through `main`
/// is compiled for the CPU that is not there.
#[inline(never)]
pub fn explain() -> ! {
    const MESSAGE: &[u8] = b"petzval: error: this CPU lacks AVX2 or FMA, which this build needs \
        (x86-64-v3: Intel Haswell 2013, AMD Zen 2017 and later)\n\
        Build a portable version, slower but with the same commands and pictures to rounding:\n    \
        RUSTFLAGS=\"-C target-cpu=x86-64\" cargo build --release\n";
    // Where even this cannot be said, the exit code still can.
    let _ = std::io::stderr().write_all(MESSAGE);
    std::process::exit(2)
}
