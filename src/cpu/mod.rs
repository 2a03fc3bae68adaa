//! Check of the CPU against the instruction set of the build.
//!
//! The default build assumes x86-64-v3, so the compiler may put AVX2 anywhere, and
//! `is_x86_feature_detected!` returns true without a look at the CPU. This module asks the CPU
//! itself, with integer instructions alone: a test runs the command on an emulated CPU without AVX,
//! where any other instruction would end it.

#[cfg(all(target_arch = "x86_64", not(target_feature = "avx2")))]
mod universal;

use std::io::Write;

/// Returns the notice of a portable build, such as that of a plain `cargo install`, which does not
/// read this repository's .cargo/config.toml, on a CPU that has AVX2.
#[cfg(all(target_arch = "x86_64", not(target_feature = "avx2")))]
pub fn portable_notice() -> Option<&'static str> {
    universal::has_avx2().then_some(
        "this is the portable build: pictures take about 1.5 times as long as with AVX2, lens \
         traces 3 times; build the other one with RUSTFLAGS=\"-C target-cpu=x86-64-v3\" cargo install --path . --force",
    )
}

/// Returns no notice: the build uses AVX2, or the architecture has none.
#[cfg(not(all(target_arch = "x86_64", not(target_feature = "avx2"))))]
pub fn portable_notice() -> Option<&'static str> {
    None
}

/// Replaces this process by the AVX2 program that a universal executable carries, if the CPU can run
/// it. Returns if this is another kind of build or the CPU is older; then this program goes on.
#[cfg(all(target_arch = "x86_64", not(target_feature = "avx2")))]
pub fn prefer_avx2() {
    if universal::has_avx2()
        && let Err(error) = universal::start()
    {
        // The exit code of the portable program counts, even if stderr is closed.
        let _ = writeln!(std::io::stderr(), "petzval: cannot start the AVX2 program: {error}");
    }
}

/// Does nothing: this program uses AVX2, or the architecture has none.
#[cfg(not(all(target_arch = "x86_64", not(target_feature = "avx2"))))]
pub fn prefer_avx2() {}

/// Returns whether the CPU has the instructions that the build assumes.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
#[inline(never)]
pub fn is_supported() -> bool {
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

/// Returns true: a portable build runs on every CPU.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
pub fn is_supported() -> bool {
    true
}

/// Prints what to do and exits with code 2 at once, as the code after a return is compiled for
/// another CPU.
#[inline(never)]
pub fn explain() -> ! {
    const MESSAGE: &[u8] = b"petzval: error: this CPU lacks AVX2 or FMA, which this build needs \
        (x86-64-v3: Intel Haswell 2013, AMD Zen 2017 and later)\n\
        Build a portable version, slower but with the same commands and pictures to rounding:\n    \
        RUSTFLAGS=\"-C target-cpu=x86-64\" cargo build --release\n";
    // The exit code remains if stderr is closed.
    let _ = std::io::stderr().write_all(MESSAGE);
    std::process::exit(2)
}
