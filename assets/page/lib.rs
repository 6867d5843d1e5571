//! The page that plays a scene in a browser, as texts.
//!
//! The files beside this one are plain HTML, CSS and JavaScript: the engine joins them with the samples of a store (`page/html.rs`).
//! `template.html` has a comment where each of the others goes, and `decode.js` says how samples are packed.

/// The markup, with a comment in place of everything else.
pub const TEMPLATE: &str = include_str!("template.html");
/// How it looks.
pub const STYLE: &str = include_str!("style.css");
/// The modules of the script by their names, each after those that it imports.
pub const MODULES: [(&str, &str); 16] = [
    ("math.js", include_str!("math.js")),
    ("decode.js", include_str!("decode.js")),
    ("decoders.js", include_str!("decoders.js")),
    ("shaders.js", include_str!("shaders.js")),
    ("gather.js", include_str!("gather.js")),
    ("sky.js", include_str!("sky.js")),
    ("round.js", include_str!("round.js")),
    ("fill.js", include_str!("fill.js")),
    ("canvas.js", include_str!("canvas.js")),
    ("seen.js", include_str!("seen.js")),
    ("renderer.js", include_str!("renderer.js")),
    ("view.js", include_str!("view.js")),
    ("address.js", include_str!("address.js")),
    ("controls.js", include_str!("controls.js")),
    ("load.js", include_str!("load.js")),
    ("main.js", include_str!("main.js")),
];
