//! What concerns files: opening, and the paths that are chosen or typed.

use std::path::PathBuf;

use super::purpose::Purpose;

/// What concerns files: opening, and the paths that are chosen or typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FileCommand {
    /// Open something, after a question where something is lost by it.
    Open(Opening),
    /// Ask for a path by the system's dialog.
    AskPath(Purpose),
    /// Show the field for typing a path.
    TypePath(Purpose),
    /// What is in the field now.
    TypedPath(String),
    /// Take the path in the field.
    TakeTypedPath,
    CloseTypedPath,
    /// Copy the command that prunes what is open without a window.
    CopyCommandLine,
    ForgetRecent,
    /// Cancel the question before closing or opening.
    Stay,
    /// Close or open in spite of what is lost.
    GoOnAnyway,
    /// Close the sentence about the room that comes with the program.
    RoomExplained,
    /// The introduction of the first run was read.
    Introduced,
}

/// What can be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Opening {
    /// A built-in scene, by its name.
    Demo(String),
    /// The room that comes with the program.
    Room,
    /// A capture or a store, perhaps with the address of a view.
    Path(PathBuf),
    /// What is open, under the other reading (true) or under the one of its files.
    Reading(bool),
}
