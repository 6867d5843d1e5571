//! What the measurements ran on.

use serde::Serialize;

use crate::settings::Instructions;

/// The machine and the build.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Machine {
    /// The name of the processor, if the system reports it.
    pub(crate) cpu: Option<String>,
    /// Architecture the program was built for, as `x86_64`.
    pub(crate) arch: &'static str,
    /// Operating system the program was built for, as `linux`.
    pub(crate) os: &'static str,
    /// Threads that the system runs at once for this process.
    pub(crate) threads_available: usize,
    /// The vector instructions that the stages were measured with.
    pub(crate) instructions: Instructions,
    /// Whether this is a release build; times of others mean nothing.
    pub(crate) optimized: bool,
}

impl Machine {
    /// This machine.
    pub(crate) fn this() -> Self {
        Self {
            cpu: cpu_name(),
            arch: std::env::consts::ARCH,
            os: std::env::consts::OS,
            threads_available: std::thread::available_parallelism().map_or(1, usize::from),
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
