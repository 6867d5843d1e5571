//! Regions as a person puts them together: what they are called, and which part is changed next.

use overlook_engine::edits::Region;

/// Adds a region to others: strokes of one brush in one picture become one region, as they are painted one after the other.
pub(crate) fn join_stroke(parts: &mut Vec<Region>, region: Region) {
    let last = parts.last_mut();
    match (last, region) {
        (
            Some(Region::Pixels { camera: of, frame: at, outline: before, strokes }),
            Region::Pixels { camera, frame, outline, strokes: more },
        ) if *of == camera && *at == frame && before.is_empty() && outline.is_empty() => strokes.extend(more),
        (
            Some(Region::View { viewpoint: from, frame: at, outline: before, strokes, depth: within }),
            Region::View { viewpoint, frame, outline, strokes: more, depth },
        ) if *from == viewpoint
            && *at == frame
            && *within == depth
            && before.is_empty()
            && outline.is_empty() =>
        {
            strokes.extend(more);
        }
        (_, region) => parts.push(region),
    }
}

/// A region in a few words.
pub(crate) fn words(region: &Region) -> String {
    match region {
        Region::Box { .. } => "box".to_owned(),
        Region::Sphere { .. } => "sphere".to_owned(),
        Region::HalfSpace { .. } => "half space".to_owned(),
        Region::Depth { .. } => "range of depth".to_owned(),
        Region::Cameras(names) => names.join(", "),
        Region::Pixels { camera, frame: None, .. } => format!("pixels of {camera}"),
        Region::Pixels { camera, .. } => format!("seen by {camera}"),
        Region::View { .. } => "outline".to_owned(),
        Region::SameSurface { .. } => "surface".to_owned(),
        Region::Grow { region, .. } => format!("{}, grown", words(region)),
        Region::Shrink { region, .. } => format!("{}, shrunk", words(region)),
        Region::Doubtful => "doubtful".to_owned(),
        Region::Contradicted => "contradicted".to_owned(),
        Region::ConfirmedByFewerThan(count) => format!("confirmed by fewer than {count}"),
        Region::SeenByOneCamera => "seen by one camera".to_owned(),
        Region::Footprint { .. } => "range of sampling rate".to_owned(),
        Region::Angle { .. } => "range of angle".to_owned(),
        Region::Color { .. } => "color".to_owned(),
        Region::Value { name, .. } => format!("range of {name}"),
        Region::Any(parts) => join(parts, " + "),
        Region::All(parts) => join(parts, " and "),
        Region::Without(parts) => join(parts, " − "),
        Region::Not(part) => format!("not {}", words(part)),
    }
}

fn join(parts: &[Region], sign: &str) -> String {
    parts.iter().map(words).collect::<Vec<_>>().join(sign)
}

/// The part of a selection that was chosen last, where it has numbers to be turned: a box, sphere, surface, color or range.
pub(crate) fn last_shape(region: &mut Region) -> Option<&mut Region> {
    match region {
        Region::Box { .. }
        | Region::Sphere { .. }
        | Region::SameSurface { .. }
        | Region::Color { .. }
        | Region::Depth { .. }
        | Region::Angle { .. }
        | Region::Value { .. } => Some(region),
        Region::Any(parts) | Region::All(parts) | Region::Without(parts) => {
            parts.last_mut().and_then(last_shape)
        }
        Region::Grow { region: part, .. } | Region::Shrink { region: part, .. } | Region::Not(part) => {
            last_shape(part)
        }
        _ => None,
    }
}
