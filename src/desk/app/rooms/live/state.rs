//! What is known of the live view: how it looks, what can be done in it, the views that were left, and those that are kept.

use std::time::{Duration, Instant};

use egui::TextureHandle;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::address::ViewAddress;
use crate::app::model::camera::OrbitCamera;
use crate::app::model::look::{Guides, Ruler, ShownCameras, Unit};
use crate::app::model::motion_budget::MotionBudget;
use crate::app::model::picture::{ColorBy, HoleDisplay, LiveKey, LivePicture};
use crate::app::model::same::Same;
use crate::app::model::scene::OpenScene;
use overlook_engine::render::Vantage;
use overlook_engine::samples::SampleSet;

/// Size of the live view before it was first laid out, in pixels: other views want its picture while it lies behind them.
pub(crate) const FIRST_SIZE: [u32; 2] = [960, 720];

/// How the live view looks.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "switches of the view, each by its name")]
pub(crate) struct LiveLook {
    /// The virtual camera; `None` while nothing is open.
    pub orbit: Option<OrbitCamera>,
    pub color_by: ColorBy,
    /// As chosen; see [`State::holes_shown`].
    pub holes: HoleDisplay,
    pub show_cameras: bool,
    /// Whether samples that a change of settings drops or brings back are seen doing so.
    pub shows_changes: bool,
    pub size: [u32; 2],
    pub guides: Guides,
    /// The cameras whose samples are shown.
    pub cameras: ShownCameras,
    pub ruler: Ruler,
    pub unit: Unit,
    /// The chosen direction of up in world space; `None` takes the one of the capture.
    pub up: Option<DVec3>,
    /// The frame of the window in which somebody asked where up is chosen.
    pub up_wanted_at: Option<u64>,
    /// How fast keys fly, in the speed of a first run.
    pub fly_speed: f64,
    /// Whether the GPU may paint on the device that draws the window.
    pub shares_device: bool,
    /// Whether a button of the mouse is held.
    pub is_held: bool,
}

impl LiveLook {
    /// How it looks at another scene: what belongs to the one before is forgotten.
    pub(crate) fn at_scene(&self, scene: &OpenScene) -> Self {
        Self {
            orbit: OrbitCamera::home(scene, scene.up_in_world),
            cameras: ShownCameras::default(),
            ruler: Ruler::default(),
            unit: Unit::default(),
            up: None,
            ..self.clone()
        }
    }
}

impl Default for LiveLook {
    fn default() -> Self {
        Self {
            orbit: None,
            color_by: ColorBy::Picture,
            holes: HoleDisplay::Filled,
            show_cameras: true,
            shows_changes: true,
            size: FIRST_SIZE,
            guides: Guides::default(),
            cameras: ShownCameras::default(),
            ruler: Ruler::default(),
            unit: Unit::default(),
            up: None,
            up_wanted_at: None,
            fly_speed: 1.0,
            shares_device: false,
            is_held: false,
        }
    }
}

/// Views that were left.
#[derive(Default)]
pub(crate) struct ViewHistory {
    past: Vec<OrbitCamera>,
    future: Vec<OrbitCamera>,
}

impl ViewHistory {
    /// Notes a view that was left.
    pub(crate) fn left(&mut self, view: OrbitCamera) {
        self.future.clear();
        self.past.push(view);
    }

    /// The view before `now`, or after it.
    pub(crate) fn step(&mut self, back: bool, now: OrbitCamera) -> Option<OrbitCamera> {
        let (from, to) =
            if back { (&mut self.past, &mut self.future) } else { (&mut self.future, &mut self.past) };
        let view = from.pop()?;
        to.push(now);
        Some(view)
    }
}

/// The live view is at rest after this long at one vantage.
const REST: Duration = Duration::from_millis(120);

/// As `REST`, while a button is held: whoever drags may pause.
const REST_WHILE_HELD: Duration = Duration::from_millis(200);

/// How the live view moves, and how finely it is painted meanwhile.
#[derive(Default)]
pub(crate) struct ViewMotion {
    /// Where it looked from and when.
    vantage: Option<Vantage>,
    /// The samples that edits and the selection left.
    edited: Option<Same<SampleSet>>,
    /// When it last looked elsewhere, or at another frame or other edits.
    moved_at: Option<Instant>,
    was_held: bool,
    pub budget: MotionBudget,
}

impl ViewMotion {
    /// Notes where the view looks from now, and at what.
    pub(crate) fn follow(
        &mut self,
        vantage: Vantage,
        edited: Option<Same<SampleSet>>,
        is_held: bool,
        playing: bool,
    ) {
        let is_first = self.vantage.is_none();
        if self.vantage.as_ref() != Some(&vantage) {
            // The first picture is not in motion, unless time passes from the start.
            self.moved_at = (!is_first || playing).then(Instant::now);
            self.vantage = Some(vantage);
        }
        if std::mem::replace(&mut self.was_held, is_held) && !is_held {
            // Whoever lets go has arrived.
            self.moved_at = None;
        }
        // What is selected or cut anew is shown at once, as if the view had moved.
        if edited.is_some() && edited != self.edited && !is_first {
            self.moved_at = Some(Instant::now());
        }
        self.edited = edited;
    }

    /// How long until the view rests; `None` once it does. `changed_at` is when a setting was last changed.
    pub(crate) fn rests_in(&self, changed_at: Option<Instant>) -> Option<Duration> {
        let rest = if self.was_held { REST_WHILE_HELD } else { REST };
        let since = [self.moved_at, changed_at].into_iter().flatten().map(|at| at.elapsed()).min()?;
        rest.checked_sub(since).filter(|left| !left.is_zero())
    }

    /// Takes in what a picture took; `frame_rate` while time passes.
    pub(crate) fn painted(&mut self, key: &LiveKey, picture: &LivePicture, frame_rate: Option<f32>) {
        let took_ms = picture.took.as_secs_f64() * 1e3;
        match key.quality {
            // A background that is painted anew for another quality tells nothing of the next ones.
            Some(_) if frame_rate.is_some() && !picture.stats.background_reused => {}
            Some(quality) => self.budget.moved(quality, took_ms, frame_rate),
            None => self.budget.rested(took_ms, key.per_coarse_pixel.powi(2)),
        }
    }
}

/// A view that is kept.
#[serde_with::serde_as]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct KeptView {
    pub name: String,
    #[serde_as(as = "serde_with::DisplayFromStr")]
    pub view: ViewAddress,
}

/// What views showed, small: of kept views, and of the keys of the camera path. A view has a picture once it was painted.
#[derive(Default)]
pub(crate) struct ViewPictures(Vec<(ViewAddress, TextureHandle)>);

impl ViewPictures {
    /// The picture of a view.
    pub(crate) fn of(&self, view: &ViewAddress) -> Option<&TextureHandle> {
        self.0.iter().find(|(known, _)| known == view).map(|(_, picture)| picture)
    }

    /// Takes the picture of a view; of views that are not `wanted` none stays.
    pub(crate) fn keep(&mut self, view: ViewAddress, picture: TextureHandle, wanted: &[ViewAddress]) {
        self.0.retain(|(known, _)| *known != view && wanted.contains(known));
        self.0.push((view, picture));
    }
}

/// The name of the next view: its number, the first that none has.
pub(crate) fn next_name(kept: &[KeptView]) -> String {
    let mut names = (1..).map(|number| format!("View {number}"));
    names.find(|name| kept.iter().all(|known| known.name != *name)).unwrap_or_default()
}
