//! What worker threads compute for the window.

mod accuracy;
mod colormap;
mod compare;
mod difference;
mod histograms;
mod live_image;
mod memory_map;
mod probe;
mod scheduler;
mod source_image;
mod study;
mod thread_priority;
mod thumbnails;
mod worker;
mod workers;

pub(crate) use colormap::{camera, diverging, sequential};
pub(crate) use compare::{CompareKey, Comparer, ShownComparison};
pub(crate) use difference::PictureDifference;
pub(crate) use histograms::{BARS, CUT, ThresholdAxis, ThresholdHistogram, histograms};
pub(crate) use live_image::{ColorBy, LiveKey, LivePicture, PixelSource};
pub(crate) use memory_map::{CameraMemory, by_camera};
pub(crate) use probe::{ProbeKey, Probed, Spot, probe};
pub(crate) use scheduler::Scheduled;
pub(crate) use source_image::{Legend, Overlay, RATIO_RANGE, SourceKey, SourcePicture};
pub(crate) use study::{StudyRequest, study};
pub(crate) use thread_priority::cpu_time;
pub(crate) use thumbnails::paint;
pub(crate) use worker::{Lane, Outbox, Supersede};
pub(crate) use workers::{FileRequest, OpenRequest, Workers, or_stopped, pool};
