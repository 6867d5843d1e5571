//! Small pictures of recent scenes, for the window without an open scene.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use egui::{Color32, ColorImage};

/// Columns and rows that a small picture has at most.
pub(crate) const RECENT_SIDES: [usize; 2] = [116, 78];

/// What the live view showed last of a file or folder.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RecentPicture {
    pub path: PathBuf,
    pub image: Arc<ColorImage>,
}

impl RecentPicture {
    /// Of a picture of any size.
    pub(crate) fn new(path: &Path, picture: &ColorImage) -> Self {
        Self { path: path.to_path_buf(), image: Arc::new(smaller(picture)) }
    }

    /// As text: a PNG in base64; `None` where it has no pixels.
    pub(crate) fn to_text(&self) -> Option<String> {
        let [width, height] = self.image.size;
        let bytes: Vec<u8> =
            self.image.pixels.iter().flat_map(|color| [color.r(), color.g(), color.b()]).collect();
        let mut png = std::io::Cursor::new(Vec::new());
        let picture = image::RgbImage::from_raw(width as u32, height as u32, bytes)?;
        picture.write_to(&mut png, image::ImageFormat::Png).ok()?;
        Some(STANDARD.encode(png.into_inner()))
    }

    /// From text; `None` where it is no such picture.
    pub(crate) fn from_text(path: PathBuf, text: &str) -> Option<Self> {
        let bytes = STANDARD.decode(text).ok()?;
        let picture = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png).ok()?.to_rgb8();
        let size = [picture.width() as usize, picture.height() as usize];
        let is_small = size[0] <= RECENT_SIDES[0] && size[1] <= RECENT_SIDES[1];
        is_small.then(|| Self { path, image: Arc::new(ColorImage::from_rgb(size, picture.as_raw())) })
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recent_picture_is_small_and_comes_back_from_text() {
        let pixels = (0..300 * 200).map(|i| Color32::from_gray((i % 300) as u8)).collect();
        let recent = RecentPicture::new(Path::new("/a"), &ColorImage::new([300, 200], pixels));
        assert_eq!(recent.image.size, [100, 66]);
        assert_eq!(recent.image.pixels[1], Color32::from_gray(4), "the mean of columns 3 to 5");
        let text = recent.to_text().unwrap();
        assert_eq!(RecentPicture::from_text("/a".into(), &text), Some(recent));
        assert_eq!(RecentPicture::from_text("/a".into(), "no picture"), None);
    }
}
