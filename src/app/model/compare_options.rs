//! What is compared with what, from where, and how.

/// What one side shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum CompareSide {
    /// The kept samples.
    Kept,
    /// All samples, nothing pruned.
    Everything,
    /// Settings A.
    A,
    /// Settings B.
    B,
    /// What a camera recorded there.
    Truth,
    /// The kept samples, one pixel each.
    Point,
    /// The kept samples, blended over 2×2 pixels.
    Block,
    /// The kept samples as oriented footprints.
    Surfel,
    /// The kept samples, surface first and color second.
    Gather,
    /// The kept samples, by the processor.
    Cpu,
    /// The kept samples, by the graphics adapter.
    Gpu,
}

impl CompareSide {
    /// Every side, in the order of the list: name and what it is.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 11] = [
        (Self::Kept, "Kept samples", "After pruning, with the settings on the sliders."),
        (Self::Everything, "All samples", "Before pruning: every pixel of this frame."),
        (Self::A, "Settings A", "After pruning with settings A."),
        (Self::B, "Settings B", "After pruning with settings B."),
        (Self::Truth, "Truth", "What a camera recorded there; known at truth vantages and hold-out cameras."),
        (Self::Point, "Kernel point", "The kept samples, one pixel each."),
        (Self::Block, "Kernel block", "The kept samples, blended over 2×2 pixels."),
        (Self::Surfel, "Kernel surfel", "The kept samples as oriented footprints."),
        (Self::Gather, "Kernel gather", "The kept samples, surface first and color second."),
        (Self::Cpu, "CPU", "The kept samples, painted by the processor."),
        (Self::Gpu, "GPU", "The kept samples, painted by the graphics adapter."),
    ];
}

/// From where.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub(crate) enum CompareVantage {
    /// Where the live view stands.
    #[default]
    Live,
    /// A vantage whose truth is known, by its place among those.
    Truth(usize),
    /// A camera, whose own samples are left out.
    HoldOut(usize),
}

/// How the two are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// One over the other, cut at a line.
    Wipe,
    /// One at a time.
    Flip,
    /// Where they differ.
    Difference,
}

impl Mode {
    /// Every mode: name and what it does.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Wipe, "Wipe", "One over the other, cut at a line that is dragged."),
        (Self::Flip, "Flip", "One at a time: hold X for the other."),
        (Self::Difference, "Difference", "Where and how much they differ."),
    ];
}

/// What the map of a difference shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) enum CompareMeasure {
    /// The largest difference of a channel, 8-bit steps.
    #[default]
    Steps,
    /// By how much the right side is brighter (or darker), 8-bit steps of luma.
    Brightness,
    /// The difference that a person sees who flips between the two, 0 to 1.
    Flip,
}

impl CompareMeasure {
    /// Every measure: name and what it shows.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Steps, "Steps", "The largest difference of a color channel, in 8-bit steps."),
        (
            Self::Brightness,
            "Brighter",
            "Where the right side is brighter (orange) or darker (purple), in 8-bit steps of luma.",
        ),
        (
            Self::Flip,
            "FLIP",
            "What a person sees who flips between the two, from 0 to 1 (LDR-FLIP, 67 pixels per degree).",
        ),
    ];
}

/// How the comparison looks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CompareLook {
    /// The sides.
    pub sides: [CompareSide; 2],
    /// From where.
    pub place: CompareVantage,
    /// How the two are shown.
    pub mode: Mode,
    /// Where the line is, as a share of the width.
    pub wipe: f32,
    /// Magnification beyond fitting the view.
    pub zoom: f32,
    /// The picture's point in the middle of the view, as shares of its size.
    pub center: egui::Vec2,
    /// What the map of their difference shows.
    pub measure: CompareMeasure,
    /// See [`crate::app::work::CompareKey::range`].
    pub range: Option<f32>,
}

impl Default for CompareLook {
    fn default() -> Self {
        Self {
            sides: [CompareSide::Everything, CompareSide::Kept],
            place: CompareVantage::Live,
            mode: Mode::Wipe,
            wipe: 0.5,
            zoom: 1.0,
            center: egui::Vec2::splat(0.5),
            measure: CompareMeasure::Steps,
            range: None,
        }
    }
}
