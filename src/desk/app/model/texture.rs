//! Textures that views show: sent through egui, or written by the renderer on the window's own device.

use std::sync::Arc;

use eframe::egui_wgpu::RenderState;
use egui::{Color32, ColorImage, TextureFilter, TextureHandle, TextureId, TextureOptions};

use overlook_engine::render::gpu::ScreenTexture;

/// A texture that a view shows. Its memory is given back when it is dropped.
pub(crate) enum Texture {
    /// Sent through egui.
    Sent(TextureHandle),
    /// Written by the renderer.
    Painted(PaintedTexture),
}

impl Texture {
    /// What egui knows it by.
    pub(crate) fn id(&self) -> TextureId {
        match self {
            Self::Sent(handle) => handle.id(),
            Self::Painted(painted) => painted.id,
        }
    }

    /// How pictures are shown whose single pixels are to be told apart.
    pub(crate) const PIXELS: TextureOptions =
        TextureOptions { magnification: TextureFilter::Nearest, ..TextureOptions::LINEAR };

    /// Sends a picture: into the replaced texture if that was sent too, otherwise into a new one.
    pub(crate) fn send(
        ctx: &egui::Context,
        name: &str,
        options: TextureOptions,
        image: &Arc<ColorImage>,
        replaced: Option<Self>,
    ) -> Self {
        match replaced {
            Some(Self::Sent(mut texture)) => {
                texture.set(image.clone(), options);
                Self::Sent(texture)
            }
            Some(Self::Painted(_)) | None => Self::Sent(ctx.load_texture(name, image.clone(), options)),
        }
    }

    /// Shows what the renderer wrote on the device of `window`, in place of what was shown before.
    pub(crate) fn painted(
        window: &RenderState,
        options: TextureOptions,
        texture: &ScreenTexture,
        replaced: Option<Self>,
    ) -> Self {
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let (filter, mut renderer) = (filter_of(options), window.renderer.write());
        match replaced {
            Some(Self::Painted(painted)) => {
                renderer.update_egui_texture_from_wgpu_texture(&window.device, &view, filter, painted.id);
                Self::Painted(painted)
            }
            Some(Self::Sent(_)) | None => {
                let id = renderer.register_native_texture(&window.device, &view, filter);
                Self::Painted(PaintedTexture { window: window.clone(), id })
            }
        }
    }
}

/// A name that the window's device knows a texture of the renderer by; dropping it takes the name back.
pub(crate) struct PaintedTexture {
    window: RenderState,
    id: TextureId,
}

impl Drop for PaintedTexture {
    fn drop(&mut self) {
        self.window.renderer.write().free_texture(&self.id);
    }
}

fn filter_of(options: TextureOptions) -> wgpu::FilterMode {
    match options.magnification {
        TextureFilter::Nearest => wgpu::FilterMode::Nearest,
        TextureFilter::Linear => wgpu::FilterMode::Linear,
    }
}

/// Columns and rows that a small picture has at most.
pub(crate) const RECENT_SIDES: [usize; 2] = [116, 78];

/// The picture reduced by means over blocks of pixels until it fits; small pictures stay as they are.
pub(crate) fn smaller(picture: &ColorImage) -> ColorImage {
    let [width, height] = picture.size;
    let side = width.div_ceil(RECENT_SIDES[0]).max(height.div_ceil(RECENT_SIDES[1])).max(1);
    let size = [width / side, height / side];
    let mean = |x: usize, y: usize| {
        let mut sum = [0; 3];
        for row in y * side..(y + 1) * side {
            for color in &picture.pixels[row * width + x * side..row * width + (x + 1) * side] {
                for (sum, value) in sum.iter_mut().zip(color.to_array()) {
                    *sum += usize::from(value);
                }
            }
        }
        let [r, g, b] = sum.map(|sum| (sum / (side * side)) as u8);
        Color32::from_rgb(r, g, b)
    };
    let pixels =
        (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect();
    ColorImage::new(size, pixels)
}
