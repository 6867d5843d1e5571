//! Pictures: each kernel alone, without filling of holes; and the default picture with every default on.

use std::fmt;
use std::sync::{Arc, Mutex};

use divan::Bencher;
use divan::counter::ItemsCount;

use crate::scene::{ANIMATIONS, Animation, CAMERA_SIZE, FRAMES, MEASURED, without_filling};
use overlook_engine::job::Job;
use overlook_engine::render::gpu::{AdapterChoice, GpuRenderer};
use overlook_engine::render::{Renderer, StageTimes, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{Antialias, Backend, Kernel, RenderSettings};

/// Viewpoints of an orbit, there and back.
const VIEWPOINTS: usize = 12;

/// The CPU, and a graphics adapter where there is one.
fn backends() -> Vec<Backend> {
    let adapter = GpuRenderer::new(AdapterChoice::Hardware).ok().map(|_| Backend::Gpu);
    [Backend::Cpu].into_iter().chain(adapter).collect()
}

/// Each default picture: the sum of the times of its stages, and of how many runs.
static STAGE_TIMES: Mutex<Vec<(String, StageTimes, usize)>> = Mutex::new(Vec::new());

/// Prints how the time of each default picture is split among its stages.
pub(crate) fn print_stage_times() {
    for (name, sum, pictures) in STAGE_TIMES.lock().unwrap().iter() {
        let parts = sum.parts().map(|(stage, ms)| format!("{stage} {:.1}", ms / *pictures as f64));
        println!("{name}: ms a stage: {}", parts.join(", "));
    }
}

/// Paints one vantage after the other in a cycle. Gives the sum of the times of stages, and of how many pictures.
fn paint(
    bencher: Bencher,
    set: &Arc<SampleSet>,
    settings: &RenderSettings,
    vantages: &[Vantage],
    is_from_nothing: bool,
) -> (StageTimes, usize) {
    let mut renderer = Renderer::strict(settings.backend).unwrap();
    let mut turns = vantages.iter().cycle();
    let (mut stages, mut pictures) = (StageTimes::default(), 0);
    bencher.bench_local(|| {
        if is_from_nothing {
            renderer.forget_background();
        }
        let (picture, stats) = renderer.render(set, turns.next().unwrap(), settings, &Job::new()).unwrap();
        stages.add(&stats.stages);
        pictures += 1;
        assert!(renderer.notice().is_none(), "{:?}", renderer.notice());
        // Giving its memory back is not measured.
        picture
    });
    (stages, pictures)
}

/// What a kernel paints.
#[derive(Clone, Copy, Debug)]
enum Painted {
    /// All samples, anew each time.
    Unpruned,
    /// What pruning keeps, anew each time.
    Pruned,
    /// A part that moves, frame by frame, everything anew since the viewpoint moves too.
    MovingVantage,
    /// The same from a still viewpoint: the background is cached (the paper, §3.3).
    StillVantage,
}

/// One picture of a kernel.
struct KernelCase {
    backend: Backend,
    kernel: Kernel,
    painted: Painted,
    size: (u32, u32),
}

impl fmt::Display for KernelCase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { backend, kernel, painted, size: (width, height) } = self;
        write!(f, "{backend}/{kernel}/{painted:?}/{width}x{height}")
    }
}

fn kernel_cases() -> Vec<KernelCase> {
    use Painted::{MovingVantage, Pruned, StillVantage, Unpruned};
    let mut cases = Vec::new();
    for backend in backends() {
        for &kernel in Kernel::ALL {
            for painted in [Unpruned, Pruned, MovingVantage, StillVantage] {
                if matches!(painted, Unpruned | Pruned) {
                    cases.push(KernelCase { backend, kernel, painted, size: CAMERA_SIZE });
                }
                cases.push(KernelCase { backend, kernel, painted, size: (1280, 720) });
            }
        }
    }
    cases
}

#[divan::bench(args = kernel_cases())]
fn kernels(bencher: Bencher, case: &KernelCase) {
    let KernelCase { backend, kernel, painted, size } = *case;
    // A stage is what it takes at its own size.
    let settings = RenderSettings { antialias: Antialias::Off, kernel, backend, ..without_filling() };
    let (set, frames) = match painted {
        Painted::Unpruned => (&MEASURED.unpruned, 1),
        Painted::Pruned => (&MEASURED.pruned, 1),
        Painted::MovingVantage | Painted::StillVantage => (&MEASURED.split, FRAMES),
    };
    let is_still = matches!(painted, Painted::StillVantage);
    let at_frame = |frame| MEASURED.vantages(size, frame).into_iter().take(if is_still { 1 } else { 2 });
    let vantages: Vec<Vantage> = (0..frames).flat_map(at_frame).collect();
    let images = set.images_at(0).filter(|image| !is_still || image.span.len() == 1);
    let samples: usize = images.map(|image| image.len()).sum();
    paint(bencher.counter(ItemsCount::new(samples)), set, &settings, &vantages, false);
}

/// What changes from one default picture to the next.
#[derive(Clone, Copy, Debug)]
enum Motion {
    Rest,
    Orbit,
    Play,
    PlayAndOrbit,
}

impl Motion {
    /// Which viewpoint and which frame the `nth` picture shows.
    fn at(self, nth: usize) -> (usize, usize) {
        let there_and_back = (nth % (2 * VIEWPOINTS - 2)).abs_diff(VIEWPOINTS - 1);
        match self {
            Self::Rest => (0, 0),
            Self::Orbit => (there_and_back, 0),
            Self::Play => (0, nth % FRAMES),
            Self::PlayAndOrbit => (there_and_back, nth % FRAMES),
        }
    }
}

/// One way to look at one animation.
struct PictureCase {
    backend: Backend,
    motion: Motion,
    animation: &'static str,
    size: (u32, u32),
}

impl fmt::Display for PictureCase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { backend, motion, animation, size: (width, height) } = self;
        write!(f, "{backend}/{motion:?}/{animation}/{width}x{height}")
    }
}

fn picture_cases() -> Vec<PictureCase> {
    let mut cases = Vec::new();
    for backend in backends() {
        for animation in ANIMATIONS {
            for motion in [Motion::Rest, Motion::Orbit, Motion::Play, Motion::PlayAndOrbit] {
                let sizes = [(640, 480), (1280, 720), (1920, 1080)];
                cases.extend(sizes.map(|size| PictureCase { backend, motion, animation, size }));
            }
        }
    }
    cases
}

/// As people see it: at rest from nothing, orbiting, playing, and both at once.
#[divan::bench(args = picture_cases())]
fn default_pictures(bencher: Bencher, case: &PictureCase) {
    let PictureCase { backend, motion, animation, size } = *case;
    let animation = Animation::named(animation);
    let settings = RenderSettings { backend, ..RenderSettings::default() };
    let nths = 0..(2 * VIEWPOINTS - 2) * FRAMES;
    let vantages: Vec<Vantage> = nths.map(|nth| animation.vantage(motion.at(nth), size)).collect();
    let samples: usize = animation.samples.images_at(0).map(|image| image.len()).sum();
    let bencher = bencher.counter(ItemsCount::new(samples));
    let is_from_nothing = matches!(motion, Motion::Rest);
    let (stages, pictures) = paint(bencher, &animation.samples, &settings, &vantages, is_from_nothing);
    STAGE_TIMES.lock().unwrap().push((case.to_string(), stages, pictures));
}
