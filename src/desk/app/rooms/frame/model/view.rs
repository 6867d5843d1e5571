//! The views of the window.

/// Something to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub(crate) enum DockView {
    Source,
    Live,
    Compare,
    Pixel,
    Cameras,
    Matrix,
    Time,
    Memory,
    Thresholds,
    Report,
    Tradeoff,
    Stability,
    Path,
    Log,
    View,
    Color,
    Edits,
}

impl DockView {
    /// Every view in the order of the menu: its name on its tab, and what it shows.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 17] = [
        (Self::Source, "Source", "What a camera saw, and what became of each of its pixels."),
        (Self::Live, "Live view", "The kept samples, rendered from any viewpoint."),
        (
            Self::Compare,
            "Compare",
            "Two pictures of one place: before and after, two settings, the truth, kernels.",
        ),
        (Self::Pixel, "Pixel", "The explanation of one pixel, with the evidence of every camera."),
        (Self::Cameras, "Cameras", "Every camera with its kept share, and where it sees the pixel."),
        (Self::Matrix, "Matrix", "Which camera's samples replace whose, and how well cameras agree."),
        (Self::Time, "Time", "For how many frames samples are stored, and when."),
        (Self::Memory, "Memory", "How much memory the samples of each camera take."),
        (Self::Thresholds, "Settings", "What counts as redundant, and how what is left is rendered."),
        (Self::Report, "Report", "How many samples each rule pruned, and for which cameras."),
        (Self::Tradeoff, "Sweep", "What each setting costs, and how close it comes to the truth."),
        (Self::Stability, "Stress test", "When accuracy breaks under disturbances."),
        (
            Self::View,
            "View",
            "The live view's lens, pose and guides, and the cameras whose samples it shows.",
        ),
        (
            Self::Color,
            "Color",
            "How both views show color: exposure, tone curve, channel, background; histograms.",
        ),
        (
            Self::Edits,
            "Edits",
            "Select samples by place, outline or evidence; delete them, keep them alone, leave cameras out.",
        ),
        (Self::Path, "Camera path", "A camera path: set keys, play it, export it as pictures."),
        (Self::Log, "Log", "What happened, in order."),
    ];

    /// Its name on its tab, and what it shows.
    pub(crate) fn name_and_help(self) -> (&'static str, &'static str) {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or(("", ""), |(_, name, help)| (*name, *help))
    }

    /// The area that it is hidden and shown with; `None` for those in the middle.
    pub(crate) fn area(self) -> Option<Area> {
        match self {
            Self::Source => Some(Area::Source),
            Self::Live | Self::Compare | Self::Tradeoff | Self::Stability => None,
            Self::Thresholds | Self::Report | Self::View | Self::Color | Self::Edits => Some(Area::Side),
            _ => Some(Area::Lower),
        }
    }

    /// The view beside which it opens.
    pub(crate) fn neighbor(self) -> Self {
        match self {
            Self::Source | Self::Live | Self::Compare | Self::Tradeoff | Self::Stability => Self::Live,
            Self::Thresholds | Self::Report | Self::View | Self::Color | Self::Edits => Self::Thresholds,
            _ => Self::Pixel,
        }
    }
}

/// Views that are hidden and shown together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub(crate) enum Area {
    /// The picture of a camera.
    Source,
    /// Settings and the report.
    Side,
    /// The views about pixels, cameras, time and memory.
    Lower,
}

impl Area {
    /// Every area in the order of the menu: its name, and the keys that hide and show it.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Source, "Source picture", ""),
        (Self::Side, "Side panel", "Ctrl+B"),
        (Self::Lower, "Lower panel", "Ctrl+J"),
    ];
}
