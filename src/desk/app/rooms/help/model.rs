//! The pages of help, the keys, and the palette.

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

/// A heading, and keys or mouse actions with what they do.
pub(crate) type Shortcuts = (&'static str, &'static [(&'static str, &'static str)]);

/// Keys, mouse actions and what they do, for the help.
pub(crate) const HELP: &[Shortcuts] = &[
    (
        "Anywhere",
        &[
            ("Ctrl + P", "find any command by name"),
            ("?", "keyboard and mouse shortcuts"),
            ("Ctrl + O", "open a file"),
            ("Ctrl + S, Ctrl + E", "share the store, or in another way"),
            ("Ctrl + Z, Ctrl + Y", "undo, redo"),
            ("Shift + Space", "maximize the view under the pointer, or restore it"),
            ("F11", "full screen"),
            ("Ctrl + 1 – 4", "workspaces"),
            ("Ctrl + B, Ctrl + J", "hide or show the side panel, the lower panel"),
            ("Ctrl + +, −, 0", "interface size: larger, smaller, normal"),
            ("Esc", "close a message, cancel, or unpin the pixel"),
            ("Ctrl + Q", "quit"),
        ],
    ),
    (
        "Time and cameras",
        &[
            ("Space", "play or pause"),
            (", and . or the arrows", "step back and forward; arrows with Shift ten frames"),
            ("Ctrl + Home, Ctrl + End", "first and last frame"),
            ("I, O, Shift + I", "loop from here, loop to here, loop over all frames"),
            ("Shift + M", "mark this frame, or take its marker away"),
            ("Ctrl + arrows", "previous and next marker"),
            ("1 – 9", "show a camera"),
            ("Shift + 1 – 9", "view from a camera"),
            ("K", "add a key to the camera path"),
        ],
    ),
    (
        "Pixel",
        &[
            ("Click", "pin the pixel under the pointer"),
            ("P", "pin or unpin the pixel"),
            ("F", "center view on the selected pixel"),
            ("Ctrl + Shift + C, F", "copy the explanation, or a figure"),
        ],
    ),
    (
        "Live view",
        &[
            ("Drag", "orbit"),
            ("Right drag, middle drag, Shift + drag", "pan"),
            ("Wheel", "zoom to the pointer"),
            ("W A S D, Q E", "fly, down and up; faster with Shift"),
            ("[ and ]", "fly slower, faster"),
            ("Alt + X, Y, Z", "view along an axis; from the other side with Shift"),
            ("M", "measure a distance between two points"),
            ("Ctrl + C, V, D", "copy the view, go to a copied one, keep it"),
            ("Double-click", "orbit about a point; beside all surfaces as Home"),
            ("Home", "reset to the start view"),
            ("H", "hatch holes, or fill them"),
        ],
    ),
    (
        "Edits",
        &[
            ("R, L, B, T", "select: rectangle, lasso, brush, surface"),
            ("[ and ], Shift + B", "size of the brush, mask"),
            ("G, Shift + G, Ctrl + I", "grow, shrink, invert"),
            ("Delete", "delete what is selected"),
        ],
    ),
    (
        "Source and Compare",
        &[
            ("Wheel", "zoom to the pointer"),
            ("Drag", "pan; in a wipe, move the line"),
            ("Double-click", "fit the picture"),
            ("X", "show the other side of a comparison"),
        ],
    ),
    (
        "Cameras",
        &[
            ("Click on a picture", "show the camera in the source view"),
            ("Click on a camera in the live view", "the same; double-click and right-click too"),
            ("Double-click", "view from the camera"),
        ],
    ),
];
