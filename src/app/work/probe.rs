//! Explains the pixel that is looked at, whichever view it was pointed at in.

use crate::app::model::{Content, ProbeKey, Probed, Spot};
use crate::preprocess::inspect::{pixel_argument, spans_of_pixel};
use crate::render::output::pick;

/// Works out what there is to say; `None` where the spot shows nothing.
pub(crate) fn probe(key: &ProbeKey) -> Option<Probed> {
    let (camera, x, y, seen) = match key.spot {
        Spot::Source { camera, x, y } => (camera, x, y, None),
        Spot::Live { x, y } => {
            let (live, shown) = key.live.as_ref()?;
            let picked = pick(&shown.samples, &live.vantage, shown.rendered()?, x, y)?;
            (picked.camera, picked.x, picked.y, picked.point_in_world)
        }
    };
    let argument = key.inspection.as_ref().and_then(|inspection| pixel_argument(inspection, camera, x, y));
    let point_in_world = argument.as_ref().map_or(seen, |argument| argument.point_in_world.or(seen));
    let samples = match &key.scene.content {
        // Of a store played from disk only the frame shown is in memory.
        Content::Store { .. } => None,
        Content::Capture { .. } => key.whole.as_ref(),
    };
    let spans = samples.map(|samples| spans_of_pixel(samples, camera, x, y));
    Some(Probed { spot: key.spot, camera, x, y, point_in_world, argument, spans })
}
