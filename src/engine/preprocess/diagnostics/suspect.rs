//! What a warning about a capture takes for wrong.

/// What a warning takes for wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suspect {
    /// The pose of one camera, or its lens.
    Pose,
    /// When one camera's frames were taken.
    Clock,
    /// How the depth of all cameras is read, or their lens or poses.
    Depth,
    /// The space of given normals.
    Normals,
}

impl Suspect {
    /// In a word or two.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pose => "Pose error",
            Self::Clock => "Time offset",
            Self::Depth => "Depth or poses of all cameras",
            Self::Normals => "Normals",
        }
    }
}
