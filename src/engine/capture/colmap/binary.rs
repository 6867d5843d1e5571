//! `cameras.bin` and `images.bin`.

use super::lens_model::LensModel;
use super::model::{ColmapCamera, ColmapImage};
use crate::error::{Error, Result};
use crate::plural::counted;

/// Bytes of a camera, at least.
const CAMERA_BYTES: u64 = 4 + 4 + 8 + 8;
/// Bytes of an image, at least: a name of no letters and no points.
const IMAGE_BYTES: u64 = 4 + 7 * 8 + 4 + 1 + 8;
/// Bytes of a point in an image.
const POINT_BYTES: usize = 8 + 8 + 8;

/// The cameras of `cameras.bin`; `place` is named in errors.
///
/// # Errors
/// `Invalid` with the byte at which the file is damaged or ends.
pub fn cameras_of_bytes(bytes: &[u8], place: &str) -> Result<Vec<ColmapCamera>> {
    let mut from = ColmapBytes { bytes, at: 0, place };
    let count = from.count(CAMERA_BYTES, "cameras")?;
    let mut cameras = Vec::new();
    for _ in 0..count {
        let id = u64::from(from.u32()?);
        let start = from.at;
        let number = from.i32()?;
        let model = LensModel::of_number(number).ok_or_else(|| {
            let what = format!("byte {start}: model {number} of camera {id} is not known; undistort the images (colmap image_undistorter), and open that folder");
            Error::unsupported(place, what)
        })?;
        let (width, height) = (from.u64()?, from.u64()?);
        let parameters = model.parameters.iter().map(|_| from.f64()).collect::<Result<_>>()?;
        cameras.push(ColmapCamera { id, model, width, height, parameters });
    }
    Ok(cameras)
}

/// The images of `images.bin`; `place` is named in errors.
///
/// # Errors
/// `Invalid` with the byte at which the file is damaged or ends.
pub fn images_of_bytes(bytes: &[u8], place: &str) -> Result<Vec<ColmapImage>> {
    let mut from = ColmapBytes { bytes, at: 0, place };
    let count = from.count(IMAGE_BYTES, "images")?;
    let mut images = Vec::new();
    for _ in 0..count {
        let id = u64::from(from.u32()?);
        let quaternion = [from.f64()?, from.f64()?, from.f64()?, from.f64()?];
        let translation = [from.f64()?, from.f64()?, from.f64()?];
        let camera = u64::from(from.u32()?);
        let name = from.text()?;
        from.skip_points()?;
        images.push(ColmapImage { id, name, camera, quaternion, translation });
    }
    Ok(images)
}

/// Bytes, and how far they are read.
struct ColmapBytes<'a> {
    bytes: &'a [u8],
    at: usize,
    place: &'a str,
}

impl ColmapBytes<'_> {
    fn error(&self, what: &str) -> Error {
        let what = format!("byte {}: {what}; it is damaged, or no file of COLMAP", self.at);
        Error::invalid(self.place, what)
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        let found = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>());
        let found = *found.ok_or_else(|| {
            self.error(&format!(
                "it ends {} too early",
                counted((self.at + N).saturating_sub(self.bytes.len()), "byte")
            ))
        })?;
        self.at += N;
        Ok(found)
    }

    fn u32(&mut self) -> Result<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn i32(&mut self) -> Result<i32> {
        self.take().map(i32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64> {
        self.take().map(u64::from_le_bytes)
    }

    fn f64(&mut self) -> Result<f64> {
        self.take().map(f64::from_le_bytes)
    }

    /// The number of things that follow, each of at least `bytes_each` bytes.
    fn count(&mut self, bytes_each: u64, things: &str) -> Result<u64> {
        let count = self.u64()?;
        let most = (self.bytes.len() - self.at) as u64 / bytes_each;
        if count <= most {
            return Ok(count);
        }
        self.at -= 8;
        Err(self.error(&format!("{count} {things} are said to follow, and there are bytes for {most}")))
    }

    /// A text that ends in a byte of 0.
    fn text(&mut self) -> Result<String> {
        let rest = &self.bytes[self.at..];
        let length =
            rest.iter().position(|byte| *byte == 0).ok_or_else(|| self.error("a name does not end"))?;
        let text = std::str::from_utf8(&rest[..length]).map_err(|_| self.error("a name is no text"))?;
        self.at += length + 1;
        Ok(text.to_owned())
    }

    fn skip_points(&mut self) -> Result<()> {
        let count = self.count(POINT_BYTES as u64, "points")?;
        self.at += count as usize * POINT_BYTES;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn image(name: &[u8], points: u64) -> Vec<u8> {
        let mut bytes = 1_u64.to_le_bytes().to_vec();
        bytes.extend(7_i32.to_le_bytes());
        bytes.extend([1.0_f64, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0].iter().flat_map(|value| value.to_le_bytes()));
        bytes.extend(2_i32.to_le_bytes());
        bytes.extend(name);
        bytes.extend(points.to_le_bytes());
        bytes.extend(vec![0; points as usize * POINT_BYTES]);
        bytes
    }

    #[test]
    fn images_are_read_with_their_points_passed_over() {
        let found = images_of_bytes(&image(b"a/b.jpg\0", 3), "").unwrap();
        assert_eq!((found[0].id, found[0].camera, found[0].name.as_str()), (7, 2, "a/b.jpg"));
        let pose = found[0].world_from_camera().unwrap();
        assert_eq!(pose.translation, DVec3::new(-1.0, -2.0, -3.0));
    }

    #[test]
    fn damage_names_its_byte() {
        let whole = image(b"a.jpg\0", 1);
        let said = |bytes: &[u8]| images_of_bytes(bytes, "images.bin").unwrap_err().to_string();
        assert!(said(&whole[..4]).starts_with("images.bin: byte 0: it ends 4 bytes too early"));
        assert!(said(&[255; 80]).contains("byte 0: 18446744073709551615 images are said to follow"));
        assert!(said(&image(b"abc", 0)[..80]).contains("byte"), "{}", said(&image(b"abc", 0)[..80]));
        assert!(said(&image(b"\xff\0", 0)).contains("byte 72: a name is no text"));
        for end in 0..whole.len() {
            assert!(images_of_bytes(&whole[..end], "").is_err(), "{end}");
        }
        let mut camera = 1_u64.to_le_bytes().to_vec();
        camera.extend(1_i32.to_le_bytes());
        camera.extend(99_i32.to_le_bytes());
        camera.extend([0; 16]);
        let said = cameras_of_bytes(&camera, "cameras.bin").unwrap_err().to_string();
        assert!(said.starts_with("cameras.bin: byte 12: model 99 of camera 1 is not known"), "{said}");
    }
}
