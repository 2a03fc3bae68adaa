//! Whether this CPU can run this build.
//!
//! The build assumes x86-64-v3, so the compiler may use AVX2 anywhere, and
//! `is_x86_feature_detected!` answers "yes" without looking. This asks the CPU itself, in
//! integer instructions that every x86-64 has; a test runs it on an emulated CPU without AVX2.

use std::process::ExitCode;

/// The first feature that the build assumes and the CPU lacks.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
#[inline(never)]
pub fn missing() -> Option<&'static str> {
    use std::arch::x86_64::__cpuid;

    // For tests on CPUs that have everything. Read first: it is the same precompiled code.
    if std::env::var_os("PETZVAL_PRETEND_OLD_CPU").is_some() {
        return Some("AVX2 (or so PETZVAL_PRETEND_OLD_CPU says)");
    }
    if __cpuid(0).eax < 7 {
        return Some("AVX2");
    }
    let (basic, extended) = (__cpuid(1).ecx, __cpuid(7).ebx);
    // OSXSAVE says that the system keeps the wide registers.
    for (word, bit, name) in [
        (basic, 27, "OSXSAVE"),
        (basic, 28, "AVX"),
        (basic, 12, "FMA"),
        (basic, 22, "MOVBE"),
        (basic, 29, "F16C"),
        (extended, 5, "AVX2"),
        (extended, 3, "BMI1"),
        (extended, 8, "BMI2"),
    ] {
        if word & (1 << bit) == 0 {
            return Some(name);
        }
    }
    None
}

/// Portable builds run everywhere.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
pub fn missing() -> Option<&'static str> {
    None
}

/// Says what to do.
#[inline(never)]
pub fn explain(feature: &str) -> ExitCode {
    eprintln!(
        "petzval: error: this CPU lacks {feature}, and this build needs AVX2 and FMA (x86-64-v3: \
         Intel Haswell 2013, AMD Zen 2017 and later)"
    );
    eprintln!("Build a portable version, slower but with the same commands:");
    eprintln!("    RUSTFLAGS=\"-C target-cpu=x86-64\" cargo build --release");
    ExitCode::from(2)
}
