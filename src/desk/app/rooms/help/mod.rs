//! Help, and the palette that finds every command.

pub(crate) mod ui;

/// Words that may be typed, each without spaces, and words of the palette with their meaning: every entry that holds one of those is
/// found, in their order.
const SYNONYMS: &[(&str, &[&str])] = &[
    ("axes", &["axes", "view from", "compare readings"]),
    ("background", &["open view: color", "holes", "share: pictures", "theme"]),
    ("bigger", &["larger", "maximize"]),
    ("blender", &["share: splats", "share: pictures", "what opens"]),
    ("bookmark", &["keep view", "go to view"]),
    ("brightness exposure", &["open view: color", "reset colors"]),
    ("chart", &["chart", "open view: sweep", "open view: stress test"]),
    ("colmap", &["what opens"]),
    ("colormap", &["open view: color", "live view shows", "source shows"]),
    ("contrast gamma hdr tone values", &["open view: color"]),
    ("conventions detect", &["compare readings"]),
    ("crop", &["edit: keep only", "edit"]),
    ("csv", &["camera table as csv", "as csv", "copy"]),
    ("dark", &["dark theme"]),
    ("delete", &["edit: delete", "leave out camera", "remove", "reset", "forget"]),
    ("denoise", &["noise", "cross-camera check"]),
    ("dpi", &["share: figure", "interface"]),
    ("erase", &["edit: delete", "edit: mask"]),
    ("expand", &["edit: grow"]),
    ("export", &["share"]),
    ("exr png", &["share: pictures"]),
    ("fieldofview fov", &["open view: view", "view from", "reset view"]),
    ("figure print", &["share: figure"]),
    ("fill", &["hole filling", "same surface"]),
    ("film gif movie mp4 video", &["share: video"]),
    ("flood wand", &["same surface"]),
    ("font", &["interface"]),
    ("fps", &["open view: time", "share: video"]),
    ("full fullscreen", &["full screen", "maximize"]),
    ("gaussian glb gltf spz usd", &["share: splats"]),
    ("gpu", &["renderer: gpu", "renderer", "about"]),
    ("help", &["guide", "shortcuts", "about"]),
    ("histogram", &["open view: color", "open view: settings"]),
    ("hide", &["hide the", "edit"]),
    ("hole", &["hole", "line-of-sight"]),
    ("html web", &["share: interactive page"]),
    ("image", &["share: pictures", "copy picture", "source shows: picture"]),
    ("inpaint", &["hole"]),
    ("keybindings keys shortcut", &["shortcuts"]),
    ("latex", &["camera table as latex", "as latex"]),
    ("lens", &["open view: view", "lens"]),
    ("link url", &["address"]),
    ("load", &["open", "load"]),
    ("manual", &["guide"]),
    ("markdown", &["camera table as markdown", "as markdown"]),
    ("mask", &["edit: mask", "edit"]),
    ("maximise", &["maximize", "full screen"]),
    ("measure", &["measure", "distance", "sweep", "stress test", "copy explanation"]),
    ("mesh obj", &["share: splats", "share: points"]),
    ("object", &["edit: select", "edit: delete"]),
    ("paint", &["edit: select by brush", "edit: mask"]),
    ("path", &["path", "open path", "share: video"]),
    ("pdf svg", &["share: figure", "save the"]),
    ("performance", &["renderer"]),
    ("ply", &["share: points", "share: splats"]),
    ("pose", &["open view: view", "pose"]),
    ("quality", &["kernel", "antialiasing", "sweep"]),
    ("recent", &["open recent", "recent"]),
    ("record", &["share: video", "camera path"]),
    ("redundant", &["open view: report", "source shows: kept by", "open view: settings"]),
    ("refresh rerun", &["recompute"]),
    ("resolution", &["share: pictures", "share: figure", "coarse pictures"]),
    ("restore", &["reset", "restore"]),
    ("revert", &["undo", "reset"]),
    ("save", &["save", "share"]),
    ("scale", &["interface", "scale"]),
    ("screenshot snapshot", &["share: pictures", "copy picture"]),
    ("select", &["edit: select", "edit"]),
    ("sideways upright", &["up:"]),
    ("size", &["interface", "size"]),
    ("solo", &["solo", "show camera"]),
    ("speed", &["open view: view", "renderer", "coarse pictures"]),
    ("tutorial", &["guide", "introduction"]),
    ("viewpoint", &["view from", "reset view"]),
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
    let means = |typed: &str| match typed.strip_prefix(&*together)? {
        "" => Some(MEANT),
        _ if together.chars().count() >= LETTERS => Some(PERHAPS_MEANT),
        _ => None,
    };
    let meant = SYNONYMS.iter().filter_map(|(words, names)| {
        let first = words.split(' ').filter_map(means).min()?;
        let place = names.iter().position(|known| name.contains(known))?;
        Some(first + 2 * place + usize::from(!name.starts_with(names[place])))
    });
    held.chain(meant).min()
}
