//! What the measurements ran on.

use serde::Serialize;

use crate::settings::Instructions;

/// The machine and the build, as far as they say so themselves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// The processor's own name, where the system tells.
    pub cpu: Option<String>,
    /// Architecture the program was built for, as `x86_64`.
    pub arch: &'static str,
    /// Operating system the program was built for, as `linux`.
    pub os: &'static str,
    /// Threads that the system runs at once for this process.
    pub threads_available: usize,
    /// Vector instructions that the processor has, whether or not they are used; empty where unknown.
    pub simd: Vec<&'static str>,
    /// The vector instructions that the stages were measured with.
    pub instructions: Instructions,
    /// Whether this is a release build. Times of any other build say nothing about the program.
    pub optimized: bool,
}

impl Machine {
    /// This machine.
    #[must_use]
    pub fn this() -> Self {
        Self {
            cpu: cpu_name(),
            arch: std::env::consts::ARCH,
            os: std::env::consts::OS,
            threads_available: std::thread::available_parallelism().map_or(1, usize::from),
            simd: simd(),
            instructions: crate::simd::widest(),
            optimized: !cfg!(debug_assertions),
        }
    }
}

fn cpu_name() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

#[cfg(target_arch = "x86_64")]
fn simd() -> Vec<&'static str> {
    let features = [
        ("sse4.2", std::arch::is_x86_feature_detected!("sse4.2")),
        ("avx", std::arch::is_x86_feature_detected!("avx")),
        ("f16c", std::arch::is_x86_feature_detected!("f16c")),
        ("avx2", std::arch::is_x86_feature_detected!("avx2")),
        ("fma", std::arch::is_x86_feature_detected!("fma")),
        ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
        ("avx512vl", std::arch::is_x86_feature_detected!("avx512vl")),
        ("avx512dq", std::arch::is_x86_feature_detected!("avx512dq")),
    ];
    features.into_iter().filter(|(_, has)| *has).map(|(name, _)| name).collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn simd() -> Vec<&'static str> {
    Vec::new()
}
