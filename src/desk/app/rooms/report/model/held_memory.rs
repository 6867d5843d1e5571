//! What the window holds in memory, by part.

use crate::app::model::state::State;
use crate::app::rooms::live::model::picture::PixelSource;

/// Bytes of a displayed color.
const COLOR: usize = 4;

/// Bytes of a rendered pixel: color, inverse depth, and the image that it comes from.
const RENDERED: usize = 20;

impl State {
    /// The parts that are largest, in bytes, and the whole program where the system tells.
    pub(crate) fn held_memory(&self) -> Vec<(&'static str, u64)> {
        let samples = self.whole_samples().map_or(0, |samples| samples.bytes());
        let decoded =
            self.doc.scene.as_ref().and_then(|scene| scene.playback()).map_or(0, |it| it.cached_bytes());
        let live = self.doc.live_shown.as_ref().map_or(0, |shown| match &shown.picture.pixels {
            PixelSource::InMemory { rendered, .. } => rendered.image.len() * (RENDERED + COLOR),
            PixelSource::OnAdapter(_) => 0,
        });
        let source =
            self.doc.source_shown.as_ref().map_or(0, |shown| shown.picture.image.pixels.len() * COLOR);
        let mut parts = vec![
            ("Samples", samples),
            ("Samples decoded from the store", decoded),
            ("Pictures shown", (live + source) as u64),
        ];
        parts.retain(|(_, bytes)| *bytes > 0);
        parts.extend(resident().map(|bytes| ("The whole program", bytes)));
        parts
    }
}

/// Bytes of the program that are in memory; `None` where the system does not tell.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()? * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_with_nothing_open_holds_no_samples() {
        let parts = State::default().held_memory();
        assert!(parts.iter().all(|(name, bytes)| *name == "The whole program" && *bytes > 0), "{parts:?}");
    }
}
