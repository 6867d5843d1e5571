//! What a camera sees of a point of another one is asked in one place, `capture/sighting`, and for runs of samples in
//! `preprocess/registration`.

use super::{code, sources, untested};

/// Where depths are compared between cameras, as prefixes of paths.
const ROOMS: [&str; 2] = ["engine/capture/sighting/", "engine/preprocess/registration/"];

/// Files that carry points and compare something by a share, and what, since the rooms have no such rule.
const OTHERS: [(&str, &str); 11] = [
    ("engine/alignment/exposure.rs", "compares pixels of one picture around a point"),
    (
        "engine/capture/conventions/agreement.rs",
        "reads depth under a reading that is on trial, in any of nine pixels",
    ),
    ("engine/capture/exr/depth.rs", "compares numbers of a file with the one for no depth"),
    ("engine/capture/transforms/depth_camera.rs", "compares shapes of pictures"),
    ("engine/preprocess/agreement/consensus.rs", "compares in deviations of both cameras' noise"),
    ("engine/preprocess/diagnostics/pair_residuals.rs", "compares frames of one camera"),
    ("engine/render/gather/interpolate.rs", "compares a camera with the picture that is painted"),
    ("lab/rivals/layered_depth_image.rs", "compares layers of one picture, as its authors do"),
    ("lab/truth/error_classes.rs", "finds steps in one picture"),
    ("lab/truth/folds.rs", "compares in footprints of a pixel"),
    ("desk/app/rooms/live/ui/guides.rs", "finds the axis among lines of the ground"),
];

/// What carries a point into a camera.
const CARRIES: [&str; 5] = [".project(", "camera_from_world", "Projector::new(", "Landing::", "reproject"];

/// Whether code, without its spaces, compares how far two values are apart with a share: `(a/b-1.0).abs()<share`, or
/// `(a-b).abs()<=share*b`.
fn compares_by_a_share(code: &str) -> bool {
    code.match_indices(".abs()").any(|(at, found)| {
        let (before, after) = (&code[..at], &code[at + found.len()..]);
        let Some(limit) = after.strip_prefix(['<', '>']) else { return false };
        let end = limit.find([';', '{', '}', ',', '&', '|']).unwrap_or(limit.len());
        let is_ratio = ["-1.0)", "-1.)", "-1.0_f32)", "-1.0_f64)"].iter().any(|end| before.ends_with(end));
        is_ratio || limit[..end].contains('*')
    })
}

/// Whether a file carries points into a camera and compares depths by a share, in code that is not a test.
fn compares_depths_between_cameras(text: &str) -> bool {
    let code: String = code(untested(text)).collect();
    let speaks_of_depth = ["depth", ".z"].iter().any(|word| code.contains(word));
    let carries = CARRIES.iter().any(|word| code.contains(word));
    let packed: String = code.chars().filter(|letter| !letter.is_whitespace()).collect();
    speaks_of_depth && carries && compares_by_a_share(&packed)
}

#[test]
fn depths_are_compared_between_cameras_in_one_place() {
    let is_known = |name: &str| {
        ROOMS.iter().any(|room| name.starts_with(room)) || OTHERS.iter().any(|(file, _)| *file == name)
    };
    let mut found: Vec<String> = sources()
        .into_iter()
        .filter(|(_, text)| compares_depths_between_cameras(text))
        .map(|(name, _)| name)
        .collect();
    for (file, reason) in OTHERS {
        assert!(found.iter().any(|name| name == file), "{file} does not compare any more ({reason})");
    }
    found.retain(|name| !is_known(name));
    assert!(found.is_empty(), "ask `engine/capture/sighting` instead: {found:#?}");
}

#[test]
fn a_planted_comparison_is_found_however_it_is_written() {
    let carried = "let Some((at, depth)) = camera.project(point) else { return false };";
    for compared in [
        "(seen * depth - 1.0).abs() < 0.03",
        "(found / depth - 1.0)\n    .abs()\n    > SAME_DEPTH",
        "(found - depth).abs() <= SAME * depth",
    ] {
        let planted = format!("fn sees() -> bool {{\n{carried}\n{compared}\n}}\n");
        assert!(compares_depths_between_cameras(&planted), "{compared}");
        // Neither half is a comparison between cameras, nor is what a comment or a test says.
        assert!(!compares_depths_between_cameras(&format!("fn is_same() -> bool {{ {compared} }}")));
        assert!(!compares_depths_between_cameras(&format!("{carried}\n// {}", compared.replace('\n', " "))));
        assert!(!compares_depths_between_cameras(&format!("#[cfg(test)]\nmod tests {{ {planted} }}")));
    }
    assert!(!compares_depths_between_cameras(carried));
}
