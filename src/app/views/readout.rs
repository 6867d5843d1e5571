//! The pixel under the pointer, in words.

use egui::{Label, RichText, Ui};

use super::super::state::State;
use super::super::text;
use super::super::theme::Tokens;
use crate::capture::Camera;
use crate::color::srgb8_from_linear;
use crate::preprocess::registration::Outcome;
use crate::preprocess::{CameraInspection, PixelClass, Rule, Verdict};

const HINT: &str = "Point at a pixel to see what became of it, and why.";
const MOUSE: &str = "Wheel to zoom, drag to shift, double-click to fit.";

/// Three lines below the source picture: what became of the pixel, what was recorded, and what the other cameras say.
pub(super) fn readout_ui(ui: &mut Ui, state: &State, pixel: Option<(usize, usize)>) {
    let tokens = Tokens::in_ui(ui);
    let (lines, color) = match pixel {
        Some((x, y)) => (about_pixel(state, x, y), tokens.text),
        None => ([camera_facts(state), HINT.to_owned(), MOUSE.to_owned()], tokens.text_weak),
    };
    ui.spacing_mut().item_spacing.y = 1.0;
    let [first, second, third] = lines.map(RichText::new);
    ui.add(Label::new(first.color(color)).truncate());
    ui.add(Label::new(second.color(tokens.text_weak)).truncate());
    ui.add(Label::new(third.small().color(tokens.text_weak)).truncate());
}

/// The camera shown at this frame, in figures.
fn camera_facts(state: &State) -> String {
    let Some(inspected) = state.inspected.as_ref().filter(|_| state.inspection_here().is_some()) else {
        return "Working out what is redundant here.".to_owned();
    };
    let pixels = inspected.inspection.cameras[state.source.camera].verdict.len() as u64;
    let kept = inspected.kept[state.source.camera];
    format!(
        "{} of {} pixels are kept ({}).",
        text::count(kept),
        text::count(pixels),
        text::percent(kept, pixels)
    )
}

fn about_pixel(state: &State, x: usize, y: usize) -> [String; 3] {
    let (Some(scene), Some(inspection)) = (&state.scene, state.inspection_here()) else {
        return ["Its verdict is being worked out.".to_owned(), format!("Pixel {x}, {y}"), String::new()];
    };
    let shown = state.source.camera;
    let camera = &inspection.cameras[shown];
    if camera.verdict.get(x, y).is_none() {
        return Default::default();
    }
    let others: Vec<_> = inspection
        .argument(shown, x, y)
        .into_iter()
        .map(|argument| {
            let name = &scene.cameras[argument.camera].name;
            format!("{name}: {}", outcome(argument.outcome, argument.log2_ratio))
        })
        .collect();
    [verdict(&scene.cameras, camera.verdict[(x, y)]), recorded(camera, x, y), others.join(" · ")]
}

fn recorded(camera: &CameraInspection, x: usize, y: usize) -> String {
    let depth = match camera.frame.inverse_depth[(x, y)] {
        w if w < 0.0 => "no depth".to_owned(),
        0.0 => "infinitely far".to_owned(),
        w => format!("depth {}", text::significant(1.0 / f64::from(w))),
    };
    let [r, g, b] = camera.frame.color[(x, y)].map(|c| srgb8_from_linear(c.to_f32()));
    let class = match camera.class[(x, y)] {
        PixelClass::Background => "same over all frames",
        PixelClass::Lasting => "same over some frames",
        PixelClass::Foreground => "of this frame",
        PixelClass::Invalid => "takes part in nothing",
    };
    format!("Pixel {x}, {y} · {depth} · color {r} {g} {b} · {class}")
}

fn verdict(cameras: &[Camera], verdict: Verdict) -> String {
    let Some(witness) = cameras.get(verdict.witness_camera as usize).filter(|_| !verdict.is_kept()) else {
        return verdict.rule.sentence().to_owned();
    };
    let name = &witness.name;
    let width = witness.intrinsics.width.max(1);
    let (x, y) = (verdict.witness_pixel % width, verdict.witness_pixel / width);
    match verdict.rule {
        Rule::LowerRate => format!("Dropped: {name} samples this point more densely, at {x}, {y}."),
        Rule::Tie => format!("Dropped: {name} samples it as densely and comes first, at {x}, {y}."),
        Rule::LaterCamera => format!("Dropped: {name} shows this point and comes first, at {x}, {y}."),
        Rule::MixedYields => format!("Dropped: blended at a silhouette; {name} is clean, at {x}, {y}."),
        rule => format!("{} Witness: {name} at {x}, {y}.", rule.sentence()),
    }
}

/// What another camera says, in a few words; its density beside this one's where it shows the same point.
fn outcome(outcome: Outcome, log2_ratio: f32) -> String {
    match outcome {
        Outcome::Same(_) => format!("{} as dense", times(log2_ratio)),
        Outcome::Behind | Outcome::OutsideView => "out of view".to_owned(),
        Outcome::NoDepth => "no depth".to_owned(),
        Outcome::Occluded => "hidden".to_owned(),
        Outcome::SeesPast => "looks past it".to_owned(),
        Outcome::NormalDiffers => "another normal".to_owned(),
        Outcome::ColorDiffers => "another color".to_owned(),
        Outcome::Seam => "at its seam".to_owned(),
    }
}

fn times(log2_ratio: f32) -> String {
    format!("{}×", text::significant(f64::from(log2_ratio.exp2())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use glam::DVec3;

    #[test]
    fn a_dropped_pixel_names_its_witness_and_where_it_is() {
        let lens = Intrinsics::from_horizontal_angle(64, 48, 1.0);
        let camera = |name| Camera::look_at(name, lens, DVec3::ZERO, DVec3::X, DVec3::Z);
        let lost =
            Verdict { rule: Rule::LowerRate, witness_level: 0, witness_camera: 1, witness_pixel: 64 * 3 + 5 };
        let sentence = verdict(&[camera("front"), camera("left")], lost);
        assert_eq!(sentence, "Dropped: left samples this point more densely, at 5, 3.");
        let kept = verdict(&[camera("front")], Verdict::without_witness(Rule::BestRate));
        assert!(kept.starts_with("Kept:"));
    }

    #[test]
    fn another_cameras_density_is_told_in_multiples() {
        assert_eq!(outcome(Outcome::Same(0), 1.0), "2.00× as dense");
        assert_eq!(outcome(Outcome::Occluded, f32::NAN), "hidden");
    }
}
