//! Models of lenses by their numbers and names, and the order of their parameters.

/// A model of COLMAP's `sensor/models.h`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LensModel {
    /// Its name, as `SIMPLE_RADIAL`.
    pub name: &'static str,
    /// Names of its parameters in the manifest, in COLMAP's order; `f` is both focal lengths. Empty names have no key.
    pub parameters: &'static [&'static str],
}

/// Models by their numbers in binary files.
const MODELS: [LensModel; 12] = [
    LensModel { name: "SIMPLE_PINHOLE", parameters: &["f", "cx", "cy"] },
    LensModel { name: "PINHOLE", parameters: &["fx", "fy", "cx", "cy"] },
    LensModel { name: "SIMPLE_RADIAL", parameters: &["f", "cx", "cy", "k1"] },
    LensModel { name: "RADIAL", parameters: &["f", "cx", "cy", "k1", "k2"] },
    LensModel { name: "OPENCV", parameters: &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"] },
    LensModel { name: "OPENCV_FISHEYE", parameters: &["fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"] },
    LensModel {
        name: "FULL_OPENCV",
        parameters: &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"],
    },
    LensModel { name: "FOV", parameters: &["fx", "fy", "cx", "cy", "omega"] },
    LensModel { name: "SIMPLE_RADIAL_FISHEYE", parameters: &["f", "cx", "cy", "k1"] },
    LensModel { name: "RADIAL_FISHEYE", parameters: &["f", "cx", "cy", "k1", "k2"] },
    LensModel {
        name: "THIN_PRISM_FISHEYE",
        parameters: &["fx", "fy", "cx", "cy", "", "", "", "", "", "", "", ""],
    },
    LensModel {
        name: "RAD_TAN_THIN_PRISM_FISHEYE",
        parameters: &["fx", "fy", "cx", "cy", "", "", "", "", "", "", "", "", "", "", "", ""],
    },
];

impl LensModel {
    /// The model of a number.
    #[must_use]
    pub fn of_number(number: i32) -> Option<Self> {
        usize::try_from(number).ok().and_then(|number| MODELS.get(number)).copied()
    }

    /// The model of a name.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        MODELS.into_iter().find(|model| model.name == name)
    }

    /// Whether a manifest can express it.
    #[must_use]
    pub fn is_read(&self) -> bool {
        self.parameters.iter().all(|name| !name.is_empty())
    }
}
