//! The default picture on a graphics card, stage by stage, by the card's own clock. Painted from a vantage that moves a little each time, so
//! that no background is kept.

use super::case::{Bench, Case};
use super::measure::{Times, repeat};
use super::report::{MeasuredStage, PaintingStage};
use overlook_engine::error::{Error, Result};
use overlook_engine::render::gpu::{AdapterChoice, GpuRenderer, StageTime};
use overlook_engine::settings::{Backend, RenderSettings};

/// The stages of the default kernel that run for every picture, and all together.
const STAGES: [&str; 6] = ["surface", "silhouette", "gather", "free-space", "fill", ALL];

/// The sum of all stages of a picture.
const ALL: &str = "all";

/// Every stage at every size. Stages are left out on adapters that do not tell times, and sizes that they have no memory for.
pub(crate) fn cases(backends: &[Backend], sizes: &[(u32, u32)]) -> Vec<Case> {
    let case = |&(width, height): &(u32, u32)| Case {
        names: STAGES.map(|stage| name_of(stage, (width, height))).to_vec(),
        measure: Box::new(move |bench| measure(bench, (width, height))),
    };
    if backends.contains(&Backend::Gpu) { sizes.iter().map(case).collect() } else { Vec::new() }
}

fn name_of(stage: &str, size: (u32, u32)) -> String {
    format!("card/{stage}/{}x{}", size.0, size.1)
}

fn measure(bench: &Bench<'_>, size: (u32, u32)) -> Result<Vec<MeasuredStage>> {
    let set = &bench.scene.pruned;
    let settings = RenderSettings::default();
    let mut gpu = GpuRenderer::new(AdapterChoice::Any)?;
    let vantages = bench.scene.vantages(size, 0);
    let mut turns = vantages.iter().cycle();
    let (mut holes, mut pictures) = (0, Vec::new());
    let painted = repeat(bench.budget, bench.job, || {
        let Some(vantage) = turns.next() else { return Ok(None) };
        let (picture, stats) = gpu.render(set, vantage, &settings, bench.job)?;
        holes = stats.holes;
        pictures.push(gpu.stage_times().to_vec());
        Ok(Some(picture))
    });
    match painted {
        Err(Error::Gpu { .. }) => return Ok(Vec::new()),
        painted => painted.map(drop)?,
    }
    let counted = &pictures[bench.budget.warm_ups.min(pictures.len())..];
    let pixels = f64::from(size.0) * f64::from(size.1);
    let stage = |name: &&str| {
        let is_meant = |stage: &str| *name == ALL || *name == stage;
        let of_picture = |times: &Vec<StageTime>| {
            times.iter().filter(|time| is_meant(time.stage)).map(|time| time.milliseconds).sum::<f64>()
        };
        let times = Times::of(counted.iter().map(of_picture).collect());
        (times.median_ms() > 0.0).then(|| MeasuredStage {
            name: name_of(name, size),
            backend: Backend::Gpu,
            samples: set.sample_count(),
            times,
            bytes: None,
            painting: Some(PaintingStage {
                kernel: settings.kernel,
                width: size.0,
                height: size.1,
                coverage: 1.0 - holes as f64 / pixels,
                bytes_per_sample: set.bytes() as f64 / set.sample_count().max(1) as f64,
                background_reused: false,
                speedup_over_full_repaint: None,
            }),
        })
    };
    Ok(STAGES.iter().filter_map(stage).collect())
}
