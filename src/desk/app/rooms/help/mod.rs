//! Help, and the palette that finds every command.

pub(crate) mod ui;

/// A word that may be typed, several written together, and words of the palette with its meaning: every entry that holds one of
/// them is found, in their order.
const SYNONYMS: &[(&str, &[&str])] = &[
    ("about", &["about", "version"]),
    ("axes", &["axes", "view from", "compare readings"]),
    ("background", &["open view: color", "holes", "share: pictures", "theme"]),
    ("bigger", &["larger", "maximize"]),
    ("blender", &["share: splats", "share: pictures", "what opens"]),
    ("bookmark", &["keep view", "go to view"]),
    ("brightness", &["open view: color", "reset colors"]),
    ("chart", &["chart", "open view: sweep", "open view: stress test"]),
    ("colmap", &["what opens"]),
    ("colormap", &["open view: color", "live view shows", "source shows"]),
    ("contrast", &["open view: color"]),
    ("conventions", &["compare readings"]),
    ("crop", &["edit: keep only", "edit"]),
    ("csv", &["camera table as csv", "as csv", "copy"]),
    ("dark", &["dark theme"]),
    ("delete", &["edit: delete", "leave out camera", "remove", "reset", "forget"]),
    ("denoise", &["noise", "cross-camera check"]),
    ("detect", &["compare readings"]),
    ("dpi", &["share: figure", "interface"]),
    ("erase", &["edit: delete", "edit: mask"]),
    ("expand", &["edit: grow"]),
    ("export", &["share"]),
    ("exposure", &["open view: color", "reset colors"]),
    ("exr", &["share: pictures"]),
    ("fieldofview", &["open view: view", "view from", "reset view"]),
    ("figure", &["share: figure"]),
    ("fill", &["hole filling", "same surface"]),
    ("film", &["share: video"]),
    ("flood", &["same surface"]),
    ("font", &["interface"]),
    ("fov", &["open view: view", "view from", "reset view"]),
    ("fps", &["open view: time", "share: video"]),
    ("full", &["full screen", "maximize"]),
    ("fullscreen", &["full screen", "maximize"]),
    ("gamma", &["open view: color"]),
    ("gaussian", &["share: splats"]),
    ("gif", &["share: video"]),
    ("glb", &["share: splats"]),
    ("gltf", &["share: splats"]),
    ("gpu", &["renderer: gpu", "renderer", "about"]),
    ("hdr", &["open view: color"]),
    ("help", &["guide", "shortcuts", "about"]),
    ("histogram", &["open view: color", "open view: settings"]),
    ("hide", &["hide the", "edit"]),
    ("hole", &["hole", "line-of-sight"]),
    ("html", &["share: interactive page"]),
    ("image", &["share: pictures", "copy picture", "source shows: picture"]),
    ("inpaint", &["hole"]),
    ("keybindings", &["shortcuts"]),
    ("keys", &["shortcuts"]),
    ("latex", &["camera table as latex", "as latex"]),
    ("lens", &["open view: view", "lens"]),
    ("link", &["address"]),
    ("load", &["open", "load"]),
    ("manual", &["guide"]),
    ("markdown", &["camera table as markdown", "as markdown"]),
    ("mask", &["edit: mask", "edit"]),
    ("maximise", &["maximize", "full screen"]),
    ("measure", &["measure", "distance", "sweep", "stress test", "copy explanation"]),
    ("mesh", &["share: splats", "share: points"]),
    ("movie", &["share: video"]),
    ("mp4", &["share: video"]),
    ("obj", &["share: splats", "share: points"]),
    ("object", &["edit: select", "edit: delete"]),
    ("paint", &["edit: select by brush", "edit: mask"]),
    ("path", &["path", "open path", "share: video"]),
    ("pdf", &["share: figure", "save the"]),
    ("performance", &["renderer"]),
    ("ply", &["share: points", "share: splats"]),
    ("png", &["share: pictures"]),
    ("pose", &["open view: view", "pose"]),
    ("print", &["share: figure"]),
    ("quality", &["kernel", "antialiasing", "sweep"]),
    ("recent", &["open recent", "recent"]),
    ("record", &["share: video", "camera path"]),
    ("redo", &["redo"]),
    ("redundant", &["open view: report", "source shows: kept by", "open view: settings"]),
    ("refresh", &["recompute"]),
    ("rerun", &["recompute"]),
    ("resolution", &["share: pictures", "share: figure", "coarse pictures"]),
    ("restore", &["reset", "restore"]),
    ("revert", &["undo", "reset"]),
    ("save", &["save", "share"]),
    ("scale", &["interface", "scale"]),
    ("screenshot", &["share: pictures", "copy picture"]),
    ("select", &["edit: select", "edit"]),
    ("shortcut", &["shortcuts"]),
    ("sideways", &["up:"]),
    ("size", &["interface", "size"]),
    ("snapshot", &["share: pictures", "copy picture"]),
    ("solo", &["solo", "show camera"]),
    ("speed", &["open view: view", "renderer", "coarse pictures"]),
    ("spz", &["share: splats"]),
    ("svg", &["share: figure", "save the"]),
    ("theme", &["theme"]),
    ("tone", &["open view: color"]),
    ("tutorial", &["guide", "introduction"]),
    ("upright", &["up:"]),
    ("url", &["address"]),
    ("usd", &["share: splats"]),
    ("values", &["open view: color"]),
    ("video", &["share: video"]),
    ("viewpoint", &["view from", "reset view"]),
    ("wand", &["same surface"]),
    ("web", &["share: interactive page"]),
    ("why", &["open view: report", "open view: pixel", "copy explanation"]),
    ("zoom", &["interface", "zoom", "reset view", "center view"]),
];

/// Letters of a word from which on it is taken for the beginning of one that is meant.
const LETTERS: usize = 3;

/// Ranks of what is found, the first being 0. What another word means goes before names that merely hold that word:
/// who types `exposure` means the one of the view, and not that of the alignment.
const MEANT: usize = 1;
const A_WORD_BEGINS_WITH_IT: usize = 30;
const HELD: usize = 40;
const PERHAPS_MEANT: usize = 60;

/// How well `text` asks for an entry, both in lower case: the lower the better, `None` where it does not. Either the text as a
/// whole does, or every word of it.
pub(crate) fn rank(text: &str, name: &str) -> Option<usize> {
    let as_a_whole = rank_of_word(text.trim(), name);
    let ranks: Option<Vec<usize>> = text.split_whitespace().map(|word| rank_of_word(word, name)).collect();
    as_a_whole.into_iter().chain(ranks.map(|ranks| ranks.iter().sum())).min()
}

fn rank_of_word(word: &str, name: &str) -> Option<usize> {
    let begins_a_word = |at: usize| !name[..at].ends_with(char::is_alphanumeric);
    let held = name.match_indices(word).map(|(at, _)| match at {
        0 => 0,
        at if begins_a_word(at) => A_WORD_BEGINS_WITH_IT,
        _ => HELD,
    });
    let together = word.replace(' ', "");
    let meant = SYNONYMS.iter().filter_map(|(typed, names)| {
        let first = if *typed == together {
            MEANT
        } else if together.chars().count() >= LETTERS && typed.starts_with(&together) {
            PERHAPS_MEANT
        } else {
            return None;
        };
        let place = names.iter().position(|known| name.contains(known))?;
        Some(first + 2 * place + usize::from(!name.starts_with(names[place])))
    });
    held.chain(meant).min()
}
