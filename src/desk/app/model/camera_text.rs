//! Sentences that name cameras: the window draws each name as a chip in the camera's color, plain text puts it in quotes. Cameras are
//! called *high*, *above* or *close* as often as *cam07*; among the words of a sentence such a name would read as one of them.

use overlook_engine::capture::Camera;

/// A part of a [`CameraText`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum TextPart {
    Words(String),
    /// The name of a camera, by its index.
    Camera(usize),
}

/// Words with the names of cameras among them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct CameraText {
    parts: Vec<TextPart>,
}

impl CameraText {
    /// Words without a name so far.
    pub(crate) fn new(words: impl Into<String>) -> Self {
        Self::default().words(words)
    }

    /// Goes on with words.
    pub(crate) fn words(mut self, words: impl Into<String>) -> Self {
        self.parts.push(TextPart::Words(words.into()));
        self
    }

    /// Goes on with the name of a camera.
    pub(crate) fn camera(mut self, index: usize) -> Self {
        self.parts.push(TextPart::Camera(index));
        self
    }

    /// Goes on with another text.
    pub(crate) fn then(mut self, other: Self) -> Self {
        self.parts.extend(other.parts);
        self
    }

    /// Words and names in their order.
    pub(crate) fn parts(&self) -> &[TextPart] {
        &self.parts
    }

    /// As plain text, names in quotes.
    pub(crate) fn plain(&self, cameras: &[Camera]) -> String {
        let part = |part: &TextPart| match part {
            TextPart::Words(words) => words.clone(),
            TextPart::Camera(index) => {
                cameras.get(*index).map_or_else(String::new, |camera| format!("'{}'", camera.name))
            }
        };
        self.parts.iter().map(part).collect()
    }
}
