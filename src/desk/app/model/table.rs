//! Tables that can be copied and saved.

/// A table that can be copied or saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Table {
    Sweep,
    StressTest,
    /// Which camera's samples replace whose.
    Replacements,
    /// How far cameras are off each other.
    Agreement,
    /// What was corrected of cameras.
    Alignment,
    /// The evidence of every camera about the selected pixel.
    Pixel,
    Cameras,
}

impl Table {
    /// Every table: what it is called in commands, and its file.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 7] = [
        (Self::Sweep, "sweep", "sweep.csv"),
        (Self::StressTest, "stress test", "stress.csv"),
        (Self::Replacements, "matrix of replaced samples", "replacements.csv"),
        (Self::Agreement, "matrix of agreement", "agreement.csv"),
        (Self::Alignment, "table of corrections", "alignment.csv"),
        (Self::Pixel, "pixel table", "pixel.csv"),
        (Self::Cameras, "camera table", "cameras.csv"),
    ];

    /// What it is called in commands.
    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or("", |(_, name, _)| name)
    }

    /// Name of its file.
    pub(crate) fn file(self) -> &'static str {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or("", |(.., file)| file)
    }
}
