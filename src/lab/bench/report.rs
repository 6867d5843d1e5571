//! What was measured, with every figure as a share of a limit too.

use serde::Serialize;

use super::measure::Times;
use overlook_engine::render::StageTimes;
use overlook_engine::settings::{Backend, Instructions, Kernel};

/// The speed of every stage, beside the limits of the machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpeedReport {
    pub(crate) version: &'static str,
    /// Whether this was a test run on a small scene.
    pub(crate) quick: bool,
    /// What measured.
    pub machine: Machine,
    /// Samples of the unpruned set: every pixel of every camera.
    pub samples: u64,
    /// Samples of the pruned set.
    pub samples_pruned: u64,
    /// What the machine can do, by number of threads.
    pub limits: Vec<Limit>,
    /// The stages, in the order in which they were measured; a name and a thread count occur once together.
    pub stages: Vec<StageSpeed>,
}

/// The machine and the build.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// The name of the processor, if the system reports it.
    pub cpu: Option<String>,
    /// The name of the graphics adapter, if one was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adapter: Option<String>,
    /// Architecture the program was built for, as `x86_64`.
    pub arch: &'static str,
    /// Operating system the program was built for, as `linux`.
    pub os: &'static str,
    /// Threads that the system runs at once for this process.
    pub threads_available: usize,
    /// The vector instructions that the stages were measured with.
    pub instructions: Instructions,
    /// Whether this is a release build; times of others mean nothing.
    pub optimized: bool,
}

impl Machine {
    /// This machine.
    pub(crate) fn this() -> Self {
        Self {
            cpu: cpu_name(),
            adapter: None,
            arch: std::env::consts::ARCH,
            os: std::env::consts::OS,
            threads_available: std::thread::available_parallelism().map_or(1, usize::from),
            instructions: overlook_engine::simd::widest(),
            optimized: !cfg!(debug_assertions),
        }
    }
}

fn cpu_name() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// The speed of one stage with some number of threads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageSpeed {
    /// What was done to what, as `render/block/pruned/640x480`.
    pub name: String,
    /// What did it: `Cpu` or `Gpu`.
    pub(crate) backend: Backend,
    /// Threads that worked on it.
    pub threads: usize,
    /// Samples (or pixels, before pruning) that were worked on.
    pub(crate) samples: u64,
    /// Median of the repeats, milliseconds.
    pub median_ms: f64,
    /// Interquartile range of the repeats, milliseconds.
    pub spread_ms: f64,
    /// How often it was measured.
    pub repeats: usize,
    /// Million samples a second.
    pub mpts_per_s: f64,
    /// The limit that it is compared with.
    pub limit: LimitKind,
    /// That limit at the same thread count: million points a second or 10⁹ bytes a second, see [`LimitKind`].
    pub(crate) limit_value: f64,
    /// The share of it that the stage reached; above 1 if the stage uses memory in a better order than the limit.
    pub fraction_of_limit: f64,
    /// Processor time of all threads, milliseconds, a repeat; `None` where it was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cpu_ms: Option<f64>,
    /// Bytes read or written at least once, for stages compared with reading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) bytes: Option<u64>,
    /// What is known of a stage that paints; `None` for others.
    #[serde(flatten)]
    pub painting: Option<PaintingStage>,
}

/// What the machine can do at most with some number of threads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Limit {
    /// Threads that were measured.
    pub threads: usize,
    /// Reading memory in sequence, 10⁹ bytes a second.
    pub read_gb_per_s: f64,
    /// Scattering random points into a picture of the size of the scene's cameras, million points a second.
    pub scatter_mpts_per_s: f64,
    /// Copying in the graphics adapter's memory, 10⁹ bytes a second; `None` where no adapter was measured.
    pub gpu_copy_gb_per_s: Option<f64>,
}

/// The limit that a stage is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LimitKind {
    /// [`Limit::scatter_mpts_per_s`], against samples a second.
    Scatter,
    /// [`Limit::read_gb_per_s`], against bytes a second.
    Read,
    /// [`Limit::gpu_copy_gb_per_s`], against bytes of samples a second.
    Copy,
}

/// What is known about a stage that paints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PaintingStage {
    pub(crate) kernel: Kernel,
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Share of the picture that got a sample, 0 to 1. The scene fills the picture: what is missing are gaps.
    pub coverage: f64,
    /// Memory of the sample set, bytes a sample.
    pub(crate) bytes_per_sample: f64,
    /// Whether the samples that outlast the frame came from a cache.
    pub(crate) background_reused: bool,
    /// How many times faster this is than painting all samples of the same set, with the same threads.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speedup_over_full_repaint: Option<f64>,
    /// Mean wall-clock milliseconds of each stage of the picture, where the renderer tells them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stages: Option<StageTimes>,
}

/// A stage that was measured, before the limits are known.
pub(crate) struct MeasuredStage {
    pub(crate) name: String,
    pub(crate) backend: Backend,
    pub(crate) samples: u64,
    pub(crate) times: Times,
    /// See [`StageSpeed::cpu_ms`].
    pub(crate) cpu_ms: Option<f64>,
    /// See [`StageSpeed::bytes`].
    pub(crate) bytes: Option<u64>,
    pub(crate) painting: Option<PaintingStage>,
}

impl MeasuredStage {
    /// Holds the stage against the limits at its thread count.
    pub(crate) fn against(self, limit: &Limit) -> StageSpeed {
        let mpts_per_s = self.times.millions_per_s(self.samples);
        let (kind, limit_value, reached) = match (&self.painting, self.bytes, limit.gpu_copy_gb_per_s) {
            (Some(painting), _, Some(copy)) if self.backend == Backend::Gpu => {
                (LimitKind::Copy, copy, mpts_per_s * painting.bytes_per_sample * 1e-3)
            }
            (None, Some(bytes), _) => (LimitKind::Read, limit.read_gb_per_s, self.times.gb_per_s(bytes)),
            _ => (LimitKind::Scatter, limit.scatter_mpts_per_s, mpts_per_s),
        };
        StageSpeed {
            name: self.name,
            backend: self.backend,
            threads: limit.threads,
            samples: self.samples,
            median_ms: self.times.median_ms(),
            spread_ms: self.times.spread_ms(),
            repeats: self.times.repeats(),
            mpts_per_s,
            limit: kind,
            limit_value,
            fraction_of_limit: reached / limit_value,
            cpu_ms: self.cpu_ms,
            bytes: self.bytes,
            painting: self.painting,
        }
    }
}
