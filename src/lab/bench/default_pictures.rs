//! The default picture, with every default on, as people see it: at rest, orbiting, playing, and both at once.
//!
//! Each picture's time is split into that of its stages. A picture at rest is rendered from nothing; while the view orbits, each picture is
//! another viewpoint of one frame; while the animation plays at a still viewpoint, each is another frame.

use super::animation::{FRAMES, SCENES};
use super::case::{Bench, Case};
use super::measure::{cpu_ms, repeat};
use super::report::{MeasuredStage, PaintingStage};
use overlook_engine::error::{Error, Result};
use overlook_engine::render::{RenderStats, Renderer, StageTimes};
use overlook_engine::settings::{Backend, RenderSettings};

/// Viewpoints of an orbit, there and back.
const VIEWPOINTS: usize = 12;

/// What changes from one picture to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    Rest,
    Orbit,
    Play,
    PlayAndOrbit,
}

impl Motion {
    const ALL: [Self; 4] = [Self::Rest, Self::Orbit, Self::Play, Self::PlayAndOrbit];

    fn name(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Orbit => "orbit",
            Self::Play => "play",
            Self::PlayAndOrbit => "play-and-orbit",
        }
    }

    /// Which viewpoint and which frame the `nth` picture shows.
    fn at(self, nth: usize) -> (usize, usize) {
        let there_and_back = |nth: usize| {
            let at = nth % (2 * VIEWPOINTS - 2);
            at.min(2 * VIEWPOINTS - 2 - at)
        };
        match self {
            Self::Rest => (0, 0),
            Self::Orbit => (there_and_back(nth), 0),
            Self::Play => (0, nth % FRAMES),
            Self::PlayAndOrbit => (there_and_back(nth), nth % FRAMES),
        }
    }
}

/// One way to look at one scene.
#[derive(Clone, Copy, Debug)]
struct PictureCase {
    backend: Backend,
    /// Index in [`SCENES`].
    scene: usize,
    motion: Motion,
    size: (u32, u32),
}

/// Every scene and motion at each size.
pub(crate) fn cases(backend: Backend, sizes: &[(u32, u32)]) -> Vec<Case> {
    let mut cases = Vec::new();
    for scene in 0..SCENES.len() {
        for motion in Motion::ALL {
            for &size in sizes {
                let case = PictureCase { backend, scene, motion, size };
                let names = vec![case.name()];
                cases.push(Case { names, measure: Box::new(move |bench| case.measure(bench)) });
            }
        }
    }
    cases
}

impl PictureCase {
    fn name(&self) -> String {
        let (width, height) = self.size;
        // The CPU goes without saying.
        let backend = match self.backend {
            Backend::Cpu => String::new(),
            other => format!("{other}/"),
        };
        format!("picture/{backend}{}/{}/{width}x{height}", self.motion.name(), SCENES[self.scene])
    }

    fn measure(&self, bench: &Bench<'_>) -> Result<Vec<MeasuredStage>> {
        let animation = &bench.scene.animations(bench.job)?[self.scene];
        let settings = RenderSettings { backend: self.backend, ..RenderSettings::default() };
        let mut renderer = Renderer::strict(self.backend)?;
        let (mut nth, mut last) = (0, RenderStats::default());
        let (mut stages, began_ms) = (StageTimes::default(), cpu_ms());
        let times = repeat(bench.budget, bench.job, || {
            if self.motion == Motion::Rest {
                renderer.forget_background();
            }
            let vantage = animation.vantage(self.motion.at(nth), self.size);
            nth += 1;
            let (picture, stats) = renderer.render(&animation.samples, &vantage, &settings, bench.job)?;
            if let Some(what) = renderer.notice() {
                return Err(Error::Gpu { what: what.to_owned() });
            }
            stages.add(&stats.stages);
            last = stats;
            // Giving its memory back is not measured.
            Ok(picture)
        })?;
        let (width, height) = self.size;
        let set = &animation.samples;
        Ok(vec![MeasuredStage {
            name: self.name(),
            backend: self.backend,
            samples: last.samples,
            times,
            cpu_ms: cpu_ms().zip(began_ms).map(|(end, began)| (end - began) / nth as f64),
            bytes: None,
            painting: Some(PaintingStage {
                kernel: settings.kernel,
                width,
                height,
                coverage: 1.0 - last.holes as f64 / (f64::from(width) * f64::from(height)),
                bytes_per_sample: set.bytes() as f64 / set.sample_count().max(1) as f64,
                background_reused: last.background_reused,
                speedup_over_full_repaint: None,
                stages: Some(stages.divided_by(nth as f64)),
            }),
        }])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orbits_go_there_and_back_and_animations_loop() {
        let viewpoints: Vec<usize> = (0..2 * VIEWPOINTS).map(|nth| Motion::Orbit.at(nth).0).collect();
        assert_eq!(viewpoints[..4], [0, 1, 2, 3]);
        assert_eq!(viewpoints[VIEWPOINTS - 2..=VIEWPOINTS], [10, 11, 10]);
        assert_eq!(viewpoints[2 * VIEWPOINTS - 3..], [1, 0, 1]);
        assert_eq!([0, 1, 2, 3].map(|nth| Motion::Play.at(nth)), [(0, 0), (0, 1), (0, 2), (0, 0)]);
    }
}
