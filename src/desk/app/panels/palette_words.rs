//! Words that people type when they do not know the name of a command.

/// A word that may be typed, and words of the palette with its meaning: every entry that holds one of them is found.
const SYNONYMS: &[(&str, &[&str])] = &[
    ("about", &["about", "version"]),
    ("axes", &["axes", "view from", "compare readings"]),
    ("background", &["background", "open view: color", "hole", "theme", "save picture"]),
    ("bigger", &["larger", "maximize"]),
    ("brightness", &["open view: color", "reset colors"]),
    ("contrast", &["open view: color"]),
    ("conventions", &["compare readings"]),
    ("csv", &["csv", "copy", "export"]),
    ("dark", &["dark theme"]),
    ("delete", &["remove", "reset", "forget"]),
    ("denoise", &["noise", "cross-camera check"]),
    ("detect", &["compare readings"]),
    ("dpi", &["interface"]),
    ("exposure", &["exposure", "open view: color", "reset colors"]),
    ("fieldofview", &["open view: view", "view from", "reset view"]),
    ("film", &["video"]),
    ("font", &["interface"]),
    ("fov", &["open view: view", "view from", "reset view"]),
    ("fps", &["frame times"]),
    ("full", &["full screen", "maximize"]),
    ("fullscreen", &["full screen", "maximize"]),
    ("gamma", &["open view: color"]),
    ("gpu", &["renderer", "about"]),
    ("hdr", &["open view: color"]),
    ("help", &["guide", "shortcuts", "about"]),
    ("hole", &["hole", "line-of-sight"]),
    ("inpaint", &["hole"]),
    ("keybindings", &["shortcuts"]),
    ("keys", &["shortcuts"]),
    ("lens", &["lens", "open view: view"]),
    ("load", &["open", "load"]),
    ("manual", &["guide"]),
    ("maximise", &["maximize", "full screen"]),
    ("measure", &["measure", "distance", "sweep", "stress test", "copy explanation"]),
    ("movie", &["video"]),
    ("path", &["path", "open path"]),
    ("performance", &["frame times", "renderer"]),
    ("pose", &["pose", "open view: view"]),
    ("quality", &["kernel", "antialiasing", "sweep"]),
    ("recent", &["recent"]),
    ("record", &["video", "camera path"]),
    ("redo", &["redo"]),
    ("refresh", &["recompute"]),
    ("rerun", &["recompute"]),
    ("restore", &["reset", "restore"]),
    ("revert", &["undo", "reset"]),
    ("scale", &["interface", "scale"]),
    ("screenshot", &["save picture", "copy picture"]),
    ("shortcut", &["shortcuts"]),
    ("sideways", &["up:"]),
    ("size", &["interface", "size"]),
    ("snapshot", &["save picture", "copy picture"]),
    ("solo", &["solo", "show camera"]),
    ("theme", &["theme"]),
    ("tone", &["open view: color"]),
    ("tutorial", &["guide", "introduction"]),
    ("viewpoint", &["view from", "reset view"]),
    ("upright", &["up:"]),
    ("zoom", &["interface", "zoom", "reset view", "center view"]),
];

/// Letters of a word from which on it is taken for the beginning of one that is meant.
const LETTERS: usize = 3;

/// Whether `word` finds an entry of this name, in lower case: the name holds the word or one of its synonyms.
pub(super) fn asks_for(word: &str, name: &str) -> bool {
    let means = |(typed, names): &(&str, &[&str])| {
        let is_meant = *typed == word || (word.chars().count() >= LETTERS && typed.starts_with(word));
        is_meant && names.iter().any(|known| name.contains(known))
    };
    name.contains(word) || SYNONYMS.iter().any(means)
}
