//! From the manifest's numbers to the intrinsics of a camera.

use std::f64::consts::PI;

use super::manifest::Keys;
use crate::capture::camera::{Intrinsics, MAX_PIXELS, MAX_SIDE, Projection, is_believable_size};
use crate::error::{Error, Result};

/// Focal lengths beyond this many pixels see less than a thousandth of a degree.
const MAX_FOCAL_PX: f64 = 1e9;

/// Focal lengths below this share of a pinhole's picture see more than 160°: they are shares or millimeters.
const LEAST_FOCAL: f64 = 0.088;

/// Intrinsics from the manifest's keys; `size` is that of the picture, for manifests that do not give one, and `pixel_aspect` the
/// width of its pixels over their height, for those that give one focal length for both directions.
///
/// # Errors
/// `Invalid` for missing, absurd or non-finite numbers, `Unsupported` for too many pixels.
pub(super) fn intrinsics(
    keys: &Keys,
    size: impl FnOnce() -> Result<(usize, usize)>,
    pixel_aspect: impl FnOnce() -> f64,
    place: &str,
) -> Result<Intrinsics> {
    let (width, height) = picture_size(keys, size, place)?;
    let (w, h) = (f64::from(width), f64::from(height));
    let projection = keys.lens.projection(keys.camera_model.as_deref());
    if projection == Projection::Orthographic {
        refuse_for_orthographic(keys, place)?;
    }
    let degrees = |value: Option<f64>| value.map(f64::to_radians);
    let scale = keys.lens.ortho_scale().filter(|_| projection == Projection::Orthographic);
    let scaled = scale.map(|scale| w.max(h) / scale);
    let mut keys = Keys { fl_x: keys.fl_x.or(scaled), ..keys.clone() };
    if projection == Projection::Orthographic {
        // Angles of view that exporters write whatever the camera is.
        (keys.camera_angle_x, keys.camera_angle_y, keys.x_fov, keys.y_fov) = (None, None, None, None);
    }
    let keys = &keys;
    let fx = focal_px(keys.fl_x, "camera_angle_x", keys.camera_angle_x, w, place)?;
    let fx = focal_px(fx, "x_fov, in radians,", degrees(keys.x_fov), w, place)?;
    let fy = focal_px(keys.fl_y, "camera_angle_y", keys.camera_angle_y, h, place)?;
    let fy = focal_px(fy, "y_fov, in radians,", degrees(keys.y_fov), h, place)?;
    let (fx, fy) = match (fx, fy) {
        (Some(fx), Some(fy)) => (fx, fy),
        (Some(fx), None) => (fx, fx * pixel_aspect()),
        (None, Some(fy)) => (fy / pixel_aspect(), fy),
        (None, None) if projection == Projection::Orthographic => {
            let what = "there is no scale of the orthographic camera; give fl_x, pixels per world unit, or ortho_scale, world units along the longer side";
            return Err(Error::invalid(place, what));
        }
        (None, None) => {
            let what = "there is no focal length; give fl_x (pixels) or camera_angle_x";
            return Err(Error::invalid(place, what));
        }
    };
    for (name, focal) in [("fl_x", fx), ("fl_y", fy)] {
        if !(focal > 0.0 && focal < MAX_FOCAL_PX) {
            return Err(Error::invalid(
                place,
                format!("{name} is {focal}, which is no focal length in pixels"),
            ));
        }
    }
    if projection == Projection::Perspective
        && fx < LEAST_FOCAL * w
        && fy < LEAST_FOCAL * h
        && matches!(keys.distortion(place), Ok(None))
    {
        let angle = 2.0 * (0.5 * w / fx).atan().to_degrees();
        let what = format!(
            "fl_x is {fx}, an angle of view of {angle:.0}°, but it is in pixels: multiply a share of the width by {w}, or millimeters by {w} over the \
             width of the sensor in millimeters"
        );
        return Err(Error::invalid(place, what));
    }
    let offset = keys.pixel_center_offset.unwrap_or(0.5);
    if !(0.0..=1.0).contains(&offset) {
        let what =
            format!("pixel_center_offset is {offset}; it must be between 0 and 1, and is 0.5 or 0 as a rule");
        return Err(Error::invalid(place, what));
    }
    let shift = 0.5 - offset;
    let cx = keys.cx.map_or(w / 2.0, |cx| cx + shift);
    let cy = keys.cy.map_or(h / 2.0, |cy| cy + shift);
    for (name, center, side) in [("cx", cx, w), ("cy", cy, h)] {
        // Shifted lenses and crops put it outside the picture, but not this far.
        if center.is_nan() || (center - side / 2.0).abs() > 100.0 * side {
            return Err(Error::invalid(place, format!("{name} is {center}, far outside the picture")));
        }
    }
    Ok(Intrinsics { width, height, fx, fy, cx, cy, projection })
}

/// Refuses keys that mean nothing for an orthographic camera, or are not read for one.
fn refuse_for_orthographic(keys: &Keys, place: &str) -> Result<()> {
    let has_scale = keys.fl_x.or(keys.fl_y).or(keys.lens.ortho_scale()).is_some();
    let angles = [
        ("camera_angle_x", keys.camera_angle_x),
        ("camera_angle_y", keys.camera_angle_y),
        ("x_fov", keys.x_fov),
        ("y_fov", keys.y_fov),
    ];
    // Blender's exporters write an angle whatever the camera is.
    let angle = angles.iter().find(|(_, angle)| !has_scale && angle.is_some());
    let what = if let Some((name, _)) = angle {
        format!(
            "{name} is no angle of view of an orthographic camera; give fl_x, pixels per world unit, or ortho_scale, world units along the longer side"
        )
    } else if keys.depth_camera.is_some() {
        "depth_camera is not read for an orthographic camera; write color and depth of one camera".to_owned()
    } else if keys.raw_video.depth_range.is_some() {
        "depth_range is even in 1/z, as depth buffers in perspective are, and that of an orthographic camera is even in z; write planar_z, the distance from the camera's plane".to_owned()
    } else {
        return Ok(());
    };
    Err(Error::invalid(place, what))
}

/// A focal length as it is given, or else from the angle of view over `side` pixels.
fn focal_px(
    focal: Option<f64>,
    name: &str,
    angle: Option<f64>,
    side: f64,
    place: &str,
) -> Result<Option<f64>> {
    match (focal, angle) {
        (None, Some(angle)) if !(angle > 0.0 && angle < PI) => {
            Err(Error::invalid(place, format!("{name} is {angle}; it is in radians, between 0 and π")))
        }
        (None, Some(angle)) => Ok(Some(0.5 * side / (0.5 * angle).tan())),
        _ => Ok(focal),
    }
}

/// Columns and rows as the manifest has them, or else the picture; where the manifest has one of them, the picture must agree.
fn picture_size(
    keys: &Keys,
    size: impl FnOnce() -> Result<(usize, usize)>,
    place: &str,
) -> Result<(u32, u32)> {
    let given = |name: &str, value: Option<f64>| value.map(|value| side(name, value, place)).transpose();
    let (width, height) = match (given("w", keys.w)?, given("h", keys.h)?) {
        (Some(width), Some(height)) => (width, height),
        (w, h) => {
            let (width, height) = size()?;
            let (width, height) = (width as u32, height as u32);
            for (name, given, found) in [("w", w, width), ("h", h, height)] {
                if let Some(given) = given
                    && given != found
                {
                    let what = format!(
                        "{name} is {given} but the picture is {width}×{height}; give both w and h, or neither, as the picture has them"
                    );
                    return Err(Error::invalid(place, what));
                }
            }
            (width, height)
        }
    };
    if !is_believable_size(width as usize, height as usize) {
        let what = format!("{width}×{height} pixels are too many; a picture has at most {MAX_PIXELS}");
        return Err(Error::unsupported(place, what));
    }
    Ok((width, height))
}

fn side(name: &str, value: f64, place: &str) -> Result<u32> {
    if value.fract() == 0.0 && (1.0..=MAX_SIDE as f64).contains(&value) {
        Ok(value as u32)
    } else {
        Err(Error::invalid(place, format!("{name} is {value}; a picture has 1 to {MAX_SIDE} pixels a side")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::transforms::lens::LensKeys;

    const SIZE: (usize, usize) = (640, 480);

    #[test]
    fn angle_and_pixel_center_stand_in_for_focal_length_and_principal_point() {
        let keys = Keys { camera_angle_x: Some(std::f64::consts::FRAC_PI_2), ..Keys::default() };
        let found = intrinsics(&keys, || Ok(SIZE), || 1.0, "").unwrap();
        assert!((found.fx - 320.0).abs() < 1e-9 && found.fx == found.fy);
        assert_eq!((found.width, found.height, found.cx, found.cy), (640, 480, 320.0, 240.0));
        let keys = Keys {
            fl_x: Some(500.0),
            cx: Some(319.5),
            cy: Some(239.5),
            pixel_center_offset: Some(0.0),
            ..Keys::default()
        };
        let found = intrinsics(&keys, || Ok(SIZE), || 1.0, "").unwrap();
        assert_eq!((found.fy, found.cx, found.cy), (500.0, 320.0, 240.0));
    }

    #[test]
    fn an_angle_that_cannot_be_in_radians_is_refused_by_its_own_name() {
        for angle in [52.0, 0.0, -1.0, PI, f64::NAN] {
            let keys = Keys { camera_angle_x: Some(angle), ..Keys::default() };
            let error = intrinsics(&keys, || Ok(SIZE), || 1.0, "test").unwrap_err().to_string();
            let expected = format!("test: camera_angle_x is {angle}; it is in radians, between 0 and π");
            assert_eq!(error, expected);
            let keys = Keys { camera_angle_y: Some(angle), ..Keys::default() };
            let error = intrinsics(&keys, || Ok(SIZE), || 1.0, "test").unwrap_err().to_string();
            assert!(error.contains("camera_angle_y is"), "{error}");
            let unused = Keys { fl_x: Some(500.0), fl_y: Some(500.0), ..keys };
            assert!(intrinsics(&unused, || Ok(SIZE), || 1.0, "test").is_ok());
        }
    }

    #[test]
    fn lenses_that_bend_are_known_and_others_refused() {
        let with = |model: &str, key: &str, value: f64| {
            let lens = LensKeys::from(serde_json::Map::from_iter([(key.to_owned(), value.into())]));
            let camera_model = Some(model.to_owned());
            Keys { fl_x: Some(500.0), camera_model, lens, ..Keys::default() }.distortion("")
        };
        for model in ["PINHOLE", "OPENCV", "SIMPLE_RADIAL", "RADIAL", "FULL_OPENCV"] {
            assert_eq!(with(model, "k1", 0.0).unwrap(), None, "{model}");
            assert!(with(model, "k1", 0.01).unwrap().is_some(), "{model}");
        }
        assert!(with("OPENCV_FISHEYE", "k1", 0.0).unwrap().is_some());
        assert!(with("FOV", "omega", 0.9).unwrap().is_some());
        for (model, key) in
            [("OPENCV", "ftheta_p1"), ("THIN_PRISM_FISHEYE", "k1"), ("OPENCV", "k4"), ("PINHOLE", "p3")]
        {
            assert!(with(model, key, 0.01).is_err(), "{model} {key}");
        }
    }

    #[test]
    fn absurd_and_contradictory_numbers_are_refused() {
        let good = Keys { fl_x: Some(500.0), w: Some(64.0), h: Some(48.0), ..Keys::default() };
        assert!(intrinsics(&good, || Ok(SIZE), || 1.0, "").is_ok());
        let bad = [
            Keys { fl_x: Some(0.0), ..good.clone() },
            Keys { fl_y: Some(-1.0), ..good.clone() },
            Keys { w: Some(1e6), ..good.clone() },
            Keys { h: Some(0.0), ..good.clone() },
            Keys { w: Some(10.5), ..good.clone() },
            Keys { cx: Some(1e9), ..good.clone() },
            Keys { fl_x: None, ..good.clone() },
            Keys { pixel_center_offset: Some(-40.0), ..good.clone() },
            Keys { h: None, w: Some(64.0), ..good.clone() },
            Keys { w: Some(32_768.0), h: Some(32_768.0), ..good.clone() },
        ];
        for keys in bad {
            assert!(intrinsics(&keys, || Ok(SIZE), || 1.0, "").is_err(), "{keys:?}");
        }
        assert!(intrinsics(&Keys { w: None, h: Some(480.0), ..good }, || Ok(SIZE), || 1.0, "").is_ok());
    }
}
