//! How often a window is drawn that the processor draws: it leaves time for the pictures in it.
//!
//! Every event of a mouse asks for the window to be drawn, a hundred times a second. Where a graphics card draws, that costs nothing, and
//! the display sets the pace. A processor would be busy with it all the time.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use eframe::{EframeWinitApplication, UserEvent};
use winit::application::ApplicationHandler;
use winit::event::{DeviceEvent, DeviceId, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::WindowId;

/// Pause after the window was drawn, as a share of the time that took.
const PAUSE: f64 = 0.25;

/// Longest pause.
const LONGEST_PAUSE: Duration = Duration::from_millis(40);

/// Time from one drawing of the window to the next, microseconds at least: while time passes, the picture of a frame is drawn together with
/// the step to the next.
pub(crate) type LeastPeriod = Arc<AtomicU32>;

/// When the window may be drawn again.
#[derive(Debug, Default)]
struct Pace {
    least_period: LeastPeriod,
    free_at: Option<Instant>,
}

impl Pace {
    /// The window was drawn until `now`, which took some time.
    fn drawn(&mut self, now: Instant, took: Duration) {
        let period = Duration::from_micros(self.least_period.load(Ordering::Relaxed).into());
        let pause = took.mul_f64(PAUSE).max(period.saturating_sub(took));
        self.free_at = Some(now + pause.min(LONGEST_PAUSE));
    }

    /// Until when the window is not to be drawn; `None` if it may be.
    fn pause(&self, now: Instant) -> Option<Instant> {
        self.free_at.filter(|free_at| now < *free_at)
    }
}

/// A window that pauses after it was drawn.
pub(crate) struct PacedWindow<'a> {
    window: EframeWinitApplication<'a>,
    pace: Pace,
    /// What waits to be drawn.
    waiting: Option<WindowId>,
}

impl<'a> PacedWindow<'a> {
    pub(crate) fn new(window: EframeWinitApplication<'a>, least_period: LeastPeriod) -> Self {
        Self { window, pace: Pace { least_period, free_at: None }, waiting: None }
    }

    fn draw(&mut self, event_loop: &ActiveEventLoop, window: WindowId) {
        let started = Instant::now();
        self.window.window_event(event_loop, window, WindowEvent::RedrawRequested);
        let now = Instant::now();
        self.pace.drawn(now, now - started);
    }
}

impl ApplicationHandler<UserEvent> for PacedWindow<'_> {
    fn new_events(&mut self, event_loop: &ActiveEventLoop, cause: StartCause) {
        self.window.new_events(event_loop, cause);
    }

    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        self.window.resumed(event_loop);
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, window: WindowId, event: WindowEvent) {
        if event != WindowEvent::RedrawRequested {
            self.window.window_event(event_loop, window, event);
        } else if self.pace.pause(Instant::now()).is_some() {
            self.waiting = Some(window);
        } else {
            self.draw(event_loop, window);
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, event: UserEvent) {
        self.window.user_event(event_loop, event);
    }

    fn device_event(&mut self, event_loop: &ActiveEventLoop, device: DeviceId, event: DeviceEvent) {
        self.window.device_event(event_loop, device, event);
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let pause = self.pace.pause(Instant::now());
        if let Some(window) = self.waiting.take_if(|_| pause.is_none()) {
            self.draw(event_loop, window);
        }
        self.window.about_to_wait(event_loop);
        if let (Some(free_at), Some(_)) = (pause, self.waiting) {
            let until = match event_loop.control_flow() {
                ControlFlow::WaitUntil(before) => before.min(free_at),
                _ => free_at,
            };
            event_loop.set_control_flow(ControlFlow::WaitUntil(until));
        }
    }

    fn exiting(&mut self, event_loop: &ActiveEventLoop) {
        self.window.exiting(event_loop);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_that_takes_long_to_draw_pauses_longer_but_never_for_long() {
        let now = Instant::now();
        let mut pace = Pace::default();
        assert_eq!(pace.pause(now), None, "nothing was drawn");
        for (took, pause) in [(0, 0), (20, 5), (40, 10), (500, 40)] {
            pace.drawn(now, Duration::from_millis(took));
            let until = (pause > 0).then(|| now + Duration::from_millis(pause));
            assert_eq!(pace.pause(now), until, "{took}");
            assert_eq!(pace.pause(now + Duration::from_millis(pause)), None, "{took}");
        }
        pace.least_period.store(30_000, Ordering::Relaxed);
        pace.drawn(now, Duration::from_millis(12));
        assert_eq!(pace.pause(now), Some(now + Duration::from_millis(18)));
    }
}
