//! Sources that another program has to convert first, or that hold no depth.

use super::place::{SourceFolder, names_in};
use crate::error::Error;
use crate::whole_file;

/// A source that is recognized and not read.
struct Convertible {
    /// Ending of the file, lower case.
    ending: &'static str,
    /// What it is, and the command or export to use instead.
    advice: &'static str,
}

/// Sources by the ending of their files.
const BY_ENDING: [Convertible; 16] = [
    Convertible {
        ending: ".mkv",
        advice: "is an Azure Kinect recording; convert it with Open3D: python azure_kinect_mkv_reader.py --input FILE.mkv --output FOLDER, then open FOLDER with a trajectory.log of poses",
    },
    Convertible {
        ending: ".bag",
        advice: "is a RealSense or ROS recording; convert it: rs-convert -i FILE.bag -p FOLDER/frame, then estimate poses (COLMAP, RTAB-Map) and open that",
    },
    Convertible {
        ending: ".sens",
        advice: "is a ScanNet recording; export it: python reader.py --filename FILE.sens --output_path FOLDER --export_depth_images --export_color_images --export_poses --export_intrinsics, then open FOLDER",
    },
    Convertible {
        ending: ".r3d",
        advice: "is Record3D's own archive; export the recording again in the app as \"EXR + RGB\", and open the folder EXR_RGBD, which holds EXR depth and metadata.json",
    },
    Convertible {
        ending: ".svo",
        advice: "is a ZED recording; export it with the ZED SDK's sample: python export_svo.py FILE.svo FOLDER 4 (color and 16-bit depth), then write the poses of positional tracking into a transforms.json beside the pictures",
    },
    Convertible {
        ending: ".svo2",
        advice: "is a ZED recording; export it with the ZED SDK's sample: python export_svo.py FILE.svo2 FOLDER 4 (color and 16-bit depth), then write the poses of positional tracking into a transforms.json beside the pictures",
    },
    Convertible {
        ending: ".mcap",
        advice: "is a ROS 2 recording; export its topics of color and depth as pictures (RTAB-Map: rtabmap-export), and write their poses into a transforms.json",
    },
    Convertible {
        ending: ".db3",
        advice: "is a ROS 2 recording; export its topics of color and depth as pictures (RTAB-Map: rtabmap-export), and write their poses into a transforms.json",
    },
    Convertible {
        ending: ".oni",
        advice: "is an OpenNI recording; export its color and depth as pictures, estimate poses (COLMAP, RTAB-Map) and open that",
    },
    Convertible {
        ending: ".mp4",
        advice: "is a video, which holds no depth; cut it into pictures (ffmpeg -i FILE.mp4 images/%06d.png), compute poses and dense depth with COLMAP, and open its dense folder",
    },
    Convertible {
        ending: ".mov",
        advice: "is a video, which holds no depth; cut it into pictures (ffmpeg -i FILE.mov images/%06d.png), compute poses and dense depth with COLMAP, and open its dense folder",
    },
    Convertible {
        ending: ".hdf5",
        advice: "is HDF5; export pictures instead (BlenderProc: bproc.writer.write_bop), and open that folder",
    },
    Convertible { ending: ".tar.gz", advice: "is an archive; unpack it: tar xzf FILE, then open the folder" },
    Convertible { ending: ".tgz", advice: "is an archive; unpack it: tar xzf FILE, then open the folder" },
    Convertible { ending: ".zip", advice: "is an archive; unpack it: unzip FILE, then open the folder" },
    Convertible {
        ending: ".db",
        advice: "is COLMAP's database of features; run its mapper, image_undistorter and patch_match_stereo, then open the dense folder",
    },
];

/// What the names of the files with a frame's poses end in.
const SOLO_FRAME: &str = ".frame_data.json";

const SOLO: &str = "is a sequence of Unity Perception (SOLO), whose poses are not read; write a transforms.json beside it: for every picture \
file_path, its .Depth.exr as depth_file_path with \"depth_channel\": \"R\", position and rotation of its frame_data.json as transform_matrix \
with \"camera_axes\": [\"right\", \"up\", \"forward\"], and the angle of view as camera_angle_x";

/// What to do with a split of a data set of radiance fields.
fn radiance_field_split(place: &SourceFolder, split: &str) -> String {
    let has_depth = whole_file::read_all(&place.join(split)).is_ok_and(|text| {
        ["\"depth_file_path\"", "\"depth_path\""]
            .iter()
            .any(|key| text.windows(key.len()).any(|part| part == key.as_bytes()))
    });
    if has_depth {
        return format!(
            "is one split of a data set; open it by its name: overlook {}",
            place.join(split).display()
        );
    }
    "is one split of a data set of radiance fields, without depth; name each picture's depth in it as depth_file_path, with its unit as \
     depth_unit_scale_factor, and open this file"
        .to_owned()
}

/// The advice on a place that is recognized and cannot be read.
pub(super) fn advice(place: &SourceFolder) -> Option<Error> {
    let names: Vec<&str> = place.file.as_deref().map_or_else(|| place.names().collect(), |name| vec![name]);
    let has = |name: &str| place.has(name);
    let refuse = |name: &str, what: &str| Some(Error::unsupported(place.join(name).display(), what));
    if has("odometry.csv") && has("rgb.mp4") {
        let what = "is a Stray Scanner recording with its colors in a video; decode it (ffmpeg -i rgb.mp4 -start_number 0 rgb/%06d.png), and write the poses of odometry.csv into a transforms.json beside it";
        return refuse("rgb.mp4", what);
    }
    if has("poses_bounds.npy") {
        let what = "are poses without depth (LLFF, DyNeRF, Neu3D); compute dense depth with COLMAP for every frame, and open its dense folder";
        return refuse("poses_bounds.npy", what);
    }
    if place.file.is_none()
        && let Some(split) =
            place.first_of(&["transforms_train.json", "transforms_test.json", "transforms_val.json"])
    {
        return refuse(split, &radiance_field_split(place, split));
    }
    let is_sequence = |name: &&str| name.starts_with("sequence.");
    if place.file.is_none()
        && let Some(sequence) = place.names().find(is_sequence)
        && names_in(&place.join(sequence))
            .is_ok_and(|names| names.iter().any(|name| name.ends_with(SOLO_FRAME)))
    {
        return refuse(sequence, SOLO);
    }
    names.iter().find_map(|name| {
        let lower = name.to_ascii_lowercase();
        let found = BY_ENDING.iter().find(|known| lower.ends_with(known.ending))?;
        refuse(name, found.advice)
    })
}
