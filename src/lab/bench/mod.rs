//! Speed of each stage, and the limits of this machine.
//!
//! ```text
//! Scene (seeded) ─┬─ limits ──────────────────────────────────────┐
//!                 ├─ preprocess_stages ─┐                         │
//!                 ├─ default_pictures ──┤                         │
//!                 └─ render_stages ─────┴─ repeat ─▶ Times ─ against ─▶ SpeedReport
//! ```
//!
//! Every stage is measured with one thread and with all. The limits are measured before and after the stages, and all repeats
//! count, so that a machine that changes speed meanwhile distorts no share.

mod animation;
mod case;
mod default_pictures;
mod limits;
mod measure;
mod preprocess_stages;
mod render_stages;
mod report;
mod scene;

pub use report::{Limit, LimitKind, Machine, SpeedReport, StageSpeed};

use rayon::ThreadPool;

use case::{Bench, Case};
use limits::LimitMeter;
use measure::RepeatLimits;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::plural::counted;
use overlook_engine::render::gpu::{AdapterChoice, GpuRenderer};
use overlook_engine::settings::{Backend, Instructions};
use scene::BenchScene;

/// What is measured, and how thoroughly.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// What *all threads* means; at least 1.
    pub threads: usize,
    /// Few repeats on a small scene: to see that everything works.
    pub quick: bool,
    /// The CPU is always measured; besides, the adapter that is named, or with `auto` a graphics card if there is one.
    pub backend: Backend,
    /// The widest vector instructions that the stages may use.
    pub instructions: Instructions,
    /// Parts of the names of the stages that are measured; all stages where empty.
    pub only: Vec<String>,
}

impl Options {
    /// Columns and rows of the cameras, which is also the first size of picture that is painted.
    fn camera_size(&self) -> (u32, u32) {
        if self.quick { (160, 120) } else { (640, 480) }
    }

    fn picture_sizes(&self) -> [(u32, u32); 2] {
        [self.camera_size(), if self.quick { (320, 180) } else { (1280, 720) }]
    }

    /// Sizes of the default pictures: those of cameras and of screens.
    fn default_sizes(&self, backend: Backend) -> &'static [(u32, u32)] {
        match backend {
            _ if self.quick => &[(160, 120)],
            Backend::Gpu => &[(1280, 720), (1920, 1080), (3840, 2160)],
            Backend::Auto | Backend::Cpu => &[(640, 480), (1280, 720), (1920, 1080)],
        }
    }

    fn budget(&self) -> RepeatLimits {
        if self.quick { RepeatLimits::QUICK } else { RepeatLimits::FULL }
    }

    /// The name of the adapter that is measured; `None` if none is.
    fn adapter(&self) -> Result<Option<String>> {
        let adapter = match self.backend {
            Backend::Cpu => None,
            Backend::Auto => GpuRenderer::new(AdapterChoice::Hardware).ok(),
            Backend::Gpu => Some(GpuRenderer::new(AdapterChoice::Any)?),
        };
        Ok(adapter.map(|gpu| gpu.adapter_name().to_owned()))
    }

    fn wants(&self, name: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|part| name.contains(part.as_str()))
    }
}

/// Measures the stages and the machine's limits.
///
/// # Errors
///
/// `Invalid` if no stage has the name; `Unsupported` if the processor lacks the instructions; `Gpu` if an adapter is named and
/// there is none; `Cancelled`.
pub fn measure(options: &Options, job: &Job) -> Result<SpeedReport> {
    overlook_engine::simd::limited(options.instructions, || measure_all(options, job))
}

fn measure_all(options: &Options, job: &Job) -> Result<SpeedReport> {
    let adapter = options.adapter()?;
    let backends = if adapter.is_some() { vec![Backend::Cpu, Backend::Gpu] } else { vec![Backend::Cpu] };
    let cases = wanted_cases(options, &backends)?;
    let scene = BenchScene::new(options.camera_size(), job)?;
    let bench = Bench { scene: &scene, budget: options.budget(), job };
    let pools = pools(options.threads)?;
    let pixels = scene.capture.cameras[0].intrinsics.pixel_count();
    let with_gpu = backends.contains(&Backend::Gpu);
    let mut limits = LimitMeter::new(scene.unpruned.sample_count(), pixels, with_gpu, options.quick)?;
    measure_limits(&mut limits, &pools, &bench)?;
    let mut measured = Vec::new();
    for (index, case) in cases.iter().enumerate() {
        for pool in &pools {
            job.start(case.names.join(", "), cases.len());
            job.advance(index);
            for stage in pool.install(|| (case.measure)(&bench))? {
                measured.push((pool.current_num_threads(), stage));
            }
        }
    }
    measure_limits(&mut limits, &pools, &bench)?;
    let stages = measured.into_iter().map(|(threads, stage)| stage.against(&limits.limit(threads)));
    Ok(SpeedReport {
        version: env!("CARGO_PKG_VERSION"),
        quick: options.quick,
        machine: Machine { adapter, ..Machine::this() },
        samples: scene.unpruned.sample_count(),
        samples_pruned: scene.pruned.sample_count(),
        limits: pools.iter().map(|pool| limits.limit(pool.current_num_threads())).collect(),
        stages: stages.filter(|stage| options.wants(&stage.name)).collect(),
    })
}

fn wanted_cases(options: &Options, backends: &[Backend]) -> Result<Vec<Case>> {
    let mut cases = preprocess_stages::cases();
    cases.extend(render_stages::cases(backends, options.picture_sizes()));
    for &backend in backends {
        cases.extend(default_pictures::cases(backend, options.default_sizes(backend)));
    }
    let (wanted, others): (Vec<Case>, Vec<Case>) =
        cases.into_iter().partition(|case| case.names.iter().any(|name| options.wants(name)));
    if wanted.is_empty() {
        let names: Vec<_> = others.into_iter().flat_map(|case| case.names).collect();
        return Err(Error::invalid(
            options.only.join(", "),
            format!("is in no stage's name; there are {}", names.join(", ")),
        ));
    }
    Ok(wanted)
}

/// One thread, and all.
fn pools(threads: usize) -> Result<Vec<ThreadPool>> {
    let mut counts = vec![1, threads.max(1)];
    counts.dedup();
    let pool = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(move |index| format!("bench {index} of {threads}"))
            .build()
            .map_err(|error| Error::unsupported(counted(threads, "thread"), error.to_string()))
    };
    counts.into_iter().map(pool).collect()
}

fn measure_limits(limits: &mut LimitMeter, pools: &[ThreadPool], bench: &Bench<'_>) -> Result<()> {
    bench.job.start("Measuring the machine's limits", pools.len());
    for pool in pools {
        pool.install(|| limits.measure(bench))?;
        bench.job.advance(1);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn names(only: &[&str]) -> Vec<String> {
        let only = only.iter().map(|part| (*part).to_owned()).collect();
        let instructions = Instructions::Auto;
        let options = Options { threads: 1, quick: false, backend: Backend::Auto, instructions, only };
        let cases = wanted_cases(&options, &[Backend::Cpu, Backend::Gpu]);
        cases.unwrap().into_iter().flat_map(|case| case.names).collect()
    }

    #[test]
    fn every_stage_has_a_name_of_its_own() {
        let all = names(&[]);
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len());
        for name in [
            "preprocess/scan",
            "render/point/unpruned/640x480",
            "render/gpu/block/still-vantage/1280x720",
            "picture/gpu/orbit/nine-cameras/1920x1080",
        ] {
            assert!(all.iter().any(|found| found == name), "{name} in {all:?}");
        }
        assert_eq!(
            names(&["store/", "preprocess/pack"]),
            [
                "preprocess/pack",
                "store/write",
                "store/read",
                "store/decode-foreground",
                "store/first-picture"
            ]
        );
    }

    #[test]
    fn one_thread_is_measured_once_where_it_is_all_there_is() {
        let counts = |threads| -> Vec<usize> {
            pools(threads).unwrap().iter().map(ThreadPool::current_num_threads).collect()
        };
        assert_eq!((counts(1), counts(3)), (vec![1], vec![1, 3]));
    }

    #[test]
    fn a_cancelled_measurement_gives_no_report() {
        let job = Job::new();
        job.cancel();
        let (backend, instructions) = (Backend::Cpu, Instructions::Auto);
        let options = Options { threads: 1, quick: true, backend, instructions, only: Vec::new() };
        assert!(matches!(measure(&options, &job), Err(Error::Cancelled)));
    }
}
