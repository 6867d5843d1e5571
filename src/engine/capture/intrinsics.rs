//! How a camera projects: through a pinhole, or along parallel lines of sight.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.3, the unprojection
//! `x = ((w·u − w)/rw − w/2)/(fl/a)·d`. With a normalized image plane (`w = h`) that equals
//! `x = (u_px − cx)/fx · z` for `fx = fl·rw/(a·w)`, `cx = rw/2`. What differs: we use the intrinsics form, pixel
//! indices start at 0, and pixel centers lie at `+0.5` where the paper samples the corner of a 1-based index. An orthographic camera is
//! the same without the division by depth: `x = (u_px − cx)/fx`, with `fx` in pixels per world unit.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// How points of camera space come into the picture.
///
/// A pinhole camera far behind cannot stand for an orthographic one. It would also look through what lies behind the picture plane, and
/// pruning drops what cameras look through. Its lines of sight spread, and its depths are rounded: by a fifth of a pixel and a tenth of a
/// footprint at 1,000 columns, where the sum is least.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// Through a pinhole: all lines of sight meet in the camera's position.
    #[default]
    Perspective,
    /// Along lines of sight that are parallel to the z axis, wherever a pixel lies. Planar depth counts from the plane through the
    /// camera's position, above 0 in front of it.
    Orthographic,
}

impl Projection {
    /// Whether lines of sight meet in one point.
    #[must_use]
    pub fn is_perspective(&self) -> bool {
        *self == Self::Perspective
    }
}

/// Image size and projection of a camera, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Intrinsics {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Horizontal focal length, pixels; of an orthographic camera pixels per world unit.
    pub fx: f64,
    /// The same vertically.
    pub fy: f64,
    /// Principal point, pixels from the left edge of the image.
    pub cx: f64,
    /// Principal point, pixels from the top edge of the image.
    pub cy: f64,
    /// What `fx` and `fy` mean. Left out where it is perspective, as in everything that was written before there was another one.
    #[serde(default, skip_serializing_if = "Projection::is_perspective")]
    pub projection: Projection,
}

/// The side of a pixel that is called its width, where pixels are not square.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelSide {
    /// The longer one.
    Longer,
    /// The geometric mean of both: the side of a square of the same area.
    Mean,
}

impl Intrinsics {
    /// A pinhole camera of `width × height` square pixels with the principal point in the middle and this focal length in pixels.
    #[must_use]
    pub const fn centered(width: u32, height: u32, focal_px: f64) -> Self {
        Self {
            width,
            height,
            fx: focal_px,
            fy: focal_px,
            cx: width as f64 / 2.0,
            cy: height as f64 / 2.0,
            projection: Projection::Perspective,
        }
    }

    /// A camera of `width × height` square pixels with the principal point in the middle and the given horizontal
    /// angle of view in radians.
    #[must_use]
    pub fn from_horizontal_angle(width: u32, height: u32, angle_x_rad: f64) -> Self {
        let focal_px = f64::from(width) / (2.0 * (angle_x_rad / 2.0).tan());
        Self::centered(width, height, focal_px)
    }

    /// An orthographic camera of `width × height` square pixels that shows `width_in_world` world units from its left edge to its right
    /// one, with its position in the middle of the picture.
    #[must_use]
    pub fn orthographic(width: u32, height: u32, width_in_world: f64) -> Self {
        let pixels_per_unit = f64::from(width) / width_in_world;
        let lens = Self::centered(width, height, pixels_per_unit);
        Self { projection: Projection::Orthographic, ..lens }
    }

    /// Whether lines of sight are parallel.
    #[must_use]
    pub fn is_orthographic(&self) -> bool {
        self.projection == Projection::Orthographic
    }

    /// `(width, height)` as indices.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width as usize, self.height as usize)
    }

    /// Pixels in the image.
    #[must_use]
    pub fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Width of a pixel on a surface that faces the camera at planar depth `depth`, in the unit of `depth`; of an orthographic camera the
    /// same at any depth.
    #[must_use]
    pub fn pixel_width(&self, depth: f64, side: PixelSide) -> f64 {
        let focal = match side {
            PixelSide::Longer => self.fx.min(self.fy),
            PixelSide::Mean => (self.fx * self.fy).sqrt(),
        };
        match self.projection {
            Projection::Perspective => depth / focal,
            Projection::Orthographic => focal.recip(),
        }
    }

    /// How many times as wide pixels are at planar depth `depth` as at depth 1: the depth, or 1 where lines of sight are parallel.
    #[must_use]
    pub fn spread_at(&self, depth: f64) -> f64 {
        match self.projection {
            Projection::Perspective => depth,
            Projection::Orthographic => 1.0,
        }
    }

    /// What shares of a depth are shares of, for a point at planar depth `depth`: the depth itself, as noise and errors of a pinhole
    /// camera grow with it. Depths of an orthographic camera count from a plane that was put anywhere; for it the width of the picture,
    /// longer side, stands in: the depth at which a pinhole camera with an angle of view of 53° has pixels as wide. World units.
    ///
    /// This is the one place that decides it. Everything else of an orthographic camera is measured in footprints.
    #[must_use]
    pub fn depth_scale(&self, depth: f64) -> f64 {
        match self.projection {
            Projection::Perspective => depth,
            Projection::Orthographic => {
                (f64::from(self.width) / self.fx).max(f64::from(self.height) / self.fy)
            }
        }
    }

    /// The lens of the same picture with other columns and rows.
    #[must_use]
    pub fn resized(&self, width: u32, height: u32) -> Self {
        let (across, down) =
            (f64::from(width) / f64::from(self.width), f64::from(height) / f64::from(self.height));
        let [fx, cx] = [self.fx, self.cx].map(|pixels| pixels * across);
        let [fy, cy] = [self.fy, self.cy].map(|pixels| pixels * down);
        Self { width, height, fx, fy, cx, cy, ..*self }
    }

    /// The lens of a pinhole camera that shows what is at this depth as large; a pinhole camera's own.
    #[must_use]
    pub fn in_perspective_from(&self, depth: f64) -> Self {
        match self.projection {
            Projection::Perspective => *self,
            Projection::Orthographic => Self {
                fx: self.fx * depth,
                fy: self.fy * depth,
                projection: Projection::Perspective,
                ..*self
            },
        }
    }

    /// The line of sight through image position `pixel` (pixels, centers at +0.5), in camera space, scaled to `z = 1`. For a pinhole camera
    /// it is the point at planar depth 1; of an orthographic one the z axis everywhere. Points: [`Intrinsics::point_in_camera`].
    #[must_use]
    pub fn ray_in_camera(&self, pixel: DVec2) -> DVec3 {
        match self.projection {
            Projection::Perspective => {
                DVec3::new((pixel.x - self.cx) / self.fx, (pixel.y - self.cy) / self.fy, 1.0)
            }
            Projection::Orthographic => DVec3::Z,
        }
    }

    /// The point at image position `pixel` (pixels, centers at +0.5) and planar depth `depth`, in camera space.
    #[must_use]
    pub fn point_in_camera(&self, pixel: DVec2, depth: f64) -> DVec3 {
        match self.projection {
            Projection::Perspective => self.ray_in_camera(pixel) * depth,
            Projection::Orthographic => {
                DVec3::new((pixel.x - self.cx) / self.fx, (pixel.y - self.cy) / self.fy, depth)
            }
        }
    }

    /// Image position (pixels) of a point in camera space, or `None` where `z ≤ 0`. It may lie outside the image.
    #[must_use]
    pub fn project(&self, point_in_camera: DVec3) -> Option<DVec2> {
        let divisor = match self.projection {
            Projection::Perspective => point_in_camera.z,
            Projection::Orthographic => 1.0,
        };
        (point_in_camera.z > 0.0).then(|| {
            DVec2::new(
                self.cx + self.fx * point_in_camera.x / divisor,
                self.cy + self.fy * point_in_camera.y / divisor,
            )
        })
    }
}
