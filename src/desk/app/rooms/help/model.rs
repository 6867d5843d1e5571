//! The pages of help, and the palette.

/// A page of help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HelpPage {
    Guide,
    /// What a capture is known by.
    Sources,
    Shortcuts,
    About,
}

/// What is typed into the palette, and which entry is chosen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct CommandPalette {
    pub text: String,
    /// Index of the chosen entry among those that match.
    pub chosen: usize,
}
