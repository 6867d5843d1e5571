//! The kinds of work that the window hands out.

/// A kind of work; each has a worker of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WorkKind {
    Open,
    /// The whole capture.
    Prune,
    InspectFrame,
    PrepareFrame,
    SourcePicture,
    LiveView,
    CarriedPicture,
    MeasureAccuracy,
    /// Saves and loads.
    File,
    Dialog,
    MeasureSizes,
    PreviewShare,
    ShowInFolder,
    CheckPath,
    PixelExplanation,
    Thumbnails,
    MemoryByCamera,
    Histograms,
    Change,
    CountValues,
    Compare,
    CompareReadings,
    EditSamples,
    Export,
    /// A sweep, a stress test, tuning, or the ranking of cameras.
    Study,
}

impl WorkKind {
    /// Title of the message that it failed.
    pub(crate) fn failure(self) -> &'static str {
        match self {
            Self::Open => "Could not open",
            Self::Prune => "Could not prune the capture",
            Self::InspectFrame => "Could not read this frame",
            Self::PrepareFrame => "Could not prepare this frame",
            Self::SourcePicture => "Could not show this frame",
            Self::LiveView | Self::CarriedPicture => "Could not render this view",
            Self::MeasureAccuracy => "Could not measure accuracy",
            Self::File => "Could not save or load",
            Self::Dialog => "Could not ask for a path",
            Self::MeasureSizes => "Could not measure sizes",
            Self::PreviewShare => "Could not preview what is shared",
            Self::ShowInFolder => "Could not show the folder",
            Self::CheckPath => "Could not check the path",
            Self::PixelExplanation => "Could not explain this pixel",
            Self::Thumbnails => "Could not draw the pictures of the cameras",
            Self::MemoryByCamera => "Could not count memory by camera",
            Self::Histograms => "Could not count the histograms",
            Self::Change => "Could not show what changed",
            Self::CountValues => "Could not count the values",
            Self::Compare => "Could not compare",
            Self::CompareReadings => "Could not compare readings",
            Self::EditSamples => "Could not apply the edits",
            Self::Export => "Could not export",
            Self::Study => "Could not measure",
        }
    }
}
