//! Carries the last finished live picture to where the view is now.

use std::sync::Arc;

use egui::{Color32, ColorImage};

use crate::app::model::Message;
use crate::app::rooms::live::model::{CarriedLook, CarryKey, PixelSource};
use overlook_engine::render::{PictureCarrier, ScreenPicture};

/// Answers a request; without a picture where nothing of it is in view, or its pixels cannot be read.
pub(crate) fn carry(carrier: &mut PictureCarrier, key: CarryKey) -> Message {
    let carried = match &key.picture.pixels {
        PixelSource::OnAdapter(_) => None,
        PixelSource::InMemory { image, rendered } => {
            let picture = ScreenPicture {
                colors: bytemuck::cast_slice(&image.pixels),
                inverse_depth: &rendered.inverse_depth,
                camera: &key.from,
            };
            carrier.carry(&picture, &key.to)
        }
    };
    let carried = carried.map(|carried| {
        let (width, height) = carried.inverse_depth.size();
        let pixels =
            carried.colors.iter().map(|[r, g, b, a]| Color32::from_rgba_premultiplied(*r, *g, *b, *a));
        let image = ColorImage::new([width, height], pixels.collect());
        CarriedLook { image: Arc::new(image), inverse_depth: carried.inverse_depth }
    });
    Message::LiveCarried { key, carried }
}
