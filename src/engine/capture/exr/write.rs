//! Writing OpenEXR pictures: one part, scan lines, ZIP, channel names that every reader knows.
//!
//! | channel | type | meaning |
//! |---|---|---|
//! | `R G B` | half | linear Rec.709 |
//! | `A` | half | 1 where the pixel shows something, 0 in holes (rendered pictures only) |
//! | `sampled.V` | half | 1 where a sample was seen, 0 where the pixel was filled or is a hole (rendered pictures only) |
//! | `Z` | float | planar z; 1e10 where nothing was hit, NaN for no depth |
//! | `N.X N.Y N.Z` | float | unit normal in world space, 0 for no normal |
//! | `value.NAME` | float | a scalar value; NaN where it is missing |

use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, LineOrder, Text, WritableImage,
};
use half::f16;

use super::depth::HALF_MAX;
use crate::capture::frame::Frame;
use crate::capture::values::{ValueChannel, Values};
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::whole_file;

/// Depth written where nothing was hit, as Blender does.
const MISS_DEPTH: f32 = 1e10;

/// The channel of a scalar value.
pub(crate) fn value_channel(name: &str) -> String {
    format!("value.{name}")
}

/// Writes a frame of a capture with these channels of scalar values as `R G B Z`, `N.X N.Y N.Z` where it has normals, and its values where
/// it has some. Reading it gives the same frame, but for the
/// rounding of the reciprocal.
///
/// The file appears under its name only when it is complete.
///
/// # Errors
/// `Io` where the file cannot be written, `Invalid` for a frame without pixels.
pub(crate) fn write_frame(path: &Path, frame: &Frame, values: &[ValueChannel]) -> Result<()> {
    let depth = frame.inverse_depth.as_slice().iter().map(|&inverse| depth_of(inverse)).collect();
    let mut channels = color_channels(|channel| frame.color.as_slice().iter().map(|c| c[channel]).collect());
    channels.push(AnyChannel::new("Z", FlatSamples::F32(depth)));
    if let Some(normals) = &frame.normal_in_world {
        for (axis, name) in ["N.X", "N.Y", "N.Z"].into_iter().enumerate() {
            let plane = normals.as_slice().iter().map(|normal| normal[axis]).collect();
            channels.push(AnyChannel::new(name, FlatSamples::F32(plane)));
        }
    }
    channels.extend(value_layers(values, &frame.values));
    write_channels(path, frame.size(), channels)
}

/// The channel that tells what was sampled from what was invented.
const SAMPLED: &str = "sampled.V";

/// Writes a rendered picture as linear `R G B A Z` and [`SAMPLED`]. `shown` and `sampled` are 1 or 0: whether a pixel shows anything,
/// and whether that is a sample and no filling, `values` are channels of scalar values and those of every pixel, if any. `inverse_depth` is as in [`Frame::inverse_depth`], 1e10 being written where it is
/// negative. All are of one size.
///
/// The file appears under its name only when it is complete.
///
/// # Errors
/// `Io` where the file cannot be written, `Invalid` for a picture without pixels or grids that differ in size.
pub(crate) fn write_picture(
    path: &Path,
    color: &Grid<[f32; 3]>,
    [shown, sampled]: [&Grid<f32>; 2],
    inverse_depth: &Grid<f32>,
    (value_channels, values): (&[ValueChannel], &Values),
) -> Result<()> {
    if [shown.size(), sampled.size(), inverse_depth.size()].iter().any(|size| *size != color.size()) {
        return Err(Error::invalid(path.display(), "color, coverage and depth differ in size"));
    }
    let mut channels = color_channels(|channel| {
        // Brighter light saturates instead of becoming infinite.
        color.as_slice().iter().map(|c| f16::from_f32(c[channel].clamp(-HALF_MAX, HALF_MAX))).collect()
    });
    for (name, shares) in [("A", shown), (SAMPLED, sampled)] {
        let shares = shares.as_slice().iter().map(|&share| f16::from_f32(share)).collect();
        channels.push(AnyChannel::new(name, FlatSamples::F16(shares)));
    }
    let depth = inverse_depth.as_slice().iter().map(|&w| if w > 0.0 { depth_of(w) } else { MISS_DEPTH });
    channels.push(AnyChannel::new("Z", FlatSamples::F32(depth.collect())));
    channels.extend(value_layers(value_channels, values));
    write_channels(path, color.size(), channels)
}

/// Layers of scalar values; none where there are no values.
fn value_layers(channels: &[ValueChannel], values: &Values) -> Vec<AnyChannel<FlatSamples>> {
    let of_channel = |(index, channel): (usize, &ValueChannel)| {
        let name = Text::from(value_channel(&channel.name).as_str());
        AnyChannel::new(name, FlatSamples::F32(values.channel(index).collect()))
    };
    channels.iter().enumerate().filter(|_| !values.is_empty()).map(of_channel).collect()
}

fn depth_of(inverse_depth: f32) -> f32 {
    if inverse_depth < 0.0 {
        f32::NAN
    } else if inverse_depth == 0.0 {
        MISS_DEPTH
    } else {
        1.0 / inverse_depth
    }
}

fn color_channels(plane: impl Fn(usize) -> Vec<f16>) -> Vec<AnyChannel<FlatSamples>> {
    ["R", "G", "B"]
        .into_iter()
        .enumerate()
        .map(|(channel, name)| AnyChannel::new(name, FlatSamples::F16(plane(channel))))
        .collect()
}

fn write_channels(path: &Path, size: (usize, usize), channels: Vec<AnyChannel<FlatSamples>>) -> Result<()> {
    if size.0 == 0 || size.1 == 0 {
        return Err(Error::invalid(path.display(), "a picture without pixels cannot be written"));
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: exr::image::Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let image = Image::from_encoded_channels(size, encoding, AnyChannels::sort(channels.into()));
    whole_file::write(path, |writer| {
        // Callers write many pictures at once; one thread each keeps all cores busy without contention.
        image.write().non_parallel().to_buffered(writer).map_err(|error| match error {
            exr::error::Error::Io(error) => Error::io(path, error),
            other => Error::invalid(path.display(), other.to_string()),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::exr::channels::ChannelPlane;
    use crate::capture::exr::file::ExrFile;

    #[test]
    fn a_rendered_picture_keeps_its_holes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        let color = Grid::from_vec(2, 1, vec![[0.5, 1e9, -0.25], [0.0; 3]]);
        let shown = Grid::from_vec(2, 1, vec![1.0, 0.0]);
        let sampled = Grid::from_vec(2, 1, vec![0.0, 0.0]);
        let inverse_depth = Grid::from_vec(2, 1, vec![0.25, -1.0]);
        write_picture(&path, &color, [&shown, &sampled], &inverse_depth, (&[], &Values::default())).unwrap();
        let file = ExrFile::open(&path, "picture").unwrap();
        let names: Vec<&str> = file.channels().iter().map(|channel| channel.name.as_str()).collect();
        assert_eq!(names, ["A", "B", "G", "R", "Z", "sampled.V"]);
        let planes = file.decode(&[0, 1, 2, 3, 4, 5], file.window(None).unwrap()).unwrap();
        let planes: Vec<Vec<f32>> = planes.into_iter().map(ChannelPlane::into_single).collect();
        assert_eq!(
            planes,
            [[1.0, 0.0], [-0.25, 0.0], [HALF_MAX, 0.0], [0.5, 0.0], [4.0, MISS_DEPTH], [0.0, 0.0]]
        );
    }
}
