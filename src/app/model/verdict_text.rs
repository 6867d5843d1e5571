//! Verdicts and evidence in words: for the read-out, the table and the clipboard.

use super::document::State;
use super::pixel::Probed;
use super::scene::OpenScene;
use super::text;
use crate::capture::Camera;
use crate::preprocess::agreement::{Vote, VoteCounts};
use crate::preprocess::inspect::{CameraEvidence, ChainLink};
use crate::preprocess::pruning::{Rule, Verdict};
use crate::preprocess::registration::Outcome;
use crate::settings::{AgreementRule, PruningSettings};

/// A verdict as a sentence that names the witness and where it is.
pub(crate) fn verdict(cameras: &[Camera], verdict: Verdict) -> String {
    let Some(witness) = cameras.get(verdict.witness_camera as usize).filter(|_| !verdict.is_kept()) else {
        return verdict.rule.sentence().to_owned();
    };
    let name = &witness.name;
    let (x, y) = column_and_row(witness, verdict.witness_pixel);
    match verdict.rule {
        Rule::LowerRate => format!("Dropped: {name} samples this point more densely, at {x}, {y}."),
        Rule::Tie => format!("Dropped: {name} samples it as densely and comes first, at {x}, {y}."),
        Rule::LaterCamera => format!("Dropped: {name} shows this point and comes first, at {x}, {y}."),
        Rule::MixedYields => format!("Dropped: mixed at a silhouette; {name} is clean, at {x}, {y}."),
        Rule::UnsureYields => format!("Dropped: no normal is known here; {name} knows it, at {x}, {y}."),
        rule => format!("{} Witness: {name} at {x}, {y}.", rule.sentence()),
    }
}

/// What stands where a frame could not be worked out.
pub(crate) const FAILED_FRAME: &str = "This frame could not be worked out: the Log view says why.";

/// Shown while a verdict is not known yet, of the pinned pixel or of the one under the pointer.
pub(crate) fn pending_verdict(state: &State, is_kept: bool) -> &'static str {
    if state.is_frame_failed() {
        FAILED_FRAME
    } else if state.timeline.playing && is_kept {
        "In motion: pause to read its verdict."
    } else if state.timeline.playing {
        "In motion: pause, or click a pixel, to read its verdict."
    } else {
        "Its verdict is being worked out."
    }
}

/// How many other cameras confirm a sample and how many look past it, and whether it flies; `None` where none does anything.
pub(crate) fn votes(counts: VoteCounts, is_flying: bool) -> Option<String> {
    let VoteCounts { confirm, look_past } = counts;
    let flying = if is_flying {
        " It flies between foreground and background: its own camera looks past it, too."
    } else {
        ""
    };
    let confirming = match confirm {
        0 => "No other camera confirms it".to_owned(),
        1 => "1 camera confirms it".to_owned(),
        _ => format!("{confirm} cameras confirm it"),
    };
    let looking_past = match look_past {
        0 => "none looks past it".to_owned(),
        1 => "1 camera looks past it".to_owned(),
        _ => format!("{look_past} cameras look past it"),
    };
    (is_flying || confirm + look_past > 0).then(|| format!("{confirming}, {looking_past}.{flying}"))
}

/// The rule by which votes drop a sample, with the settings it goes by.
pub(crate) fn rule_of_votes(pruning: &PruningSettings) -> String {
    let margin = pruning.agreement_margin;
    let cameras = if margin == 1 { "1 camera".to_owned() } else { format!("{margin} cameras") };
    let rule = format!(
        "A sample that no kept one represents is dropped where the cameras that look past it outnumber its own and those that \
         confirm it by {cameras} (agreement margin)."
    );
    match pruning.agreement {
        AgreementRule::Majority => rule,
        AgreementRule::Off => format!("Agreement is off, so that nothing follows. By majority: {rule}"),
    }
}

/// Column and row of a pixel index.
pub(crate) fn column_and_row(camera: &Camera, pixel: u32) -> (u32, u32) {
    let width = camera.intrinsics.width.max(1);
    (pixel % width, pixel / width)
}

/// Whether a camera sees the point, and the rule behind that.
pub(crate) fn sees(row: &CameraEvidence) -> (&'static str, &'static str) {
    match row.outcome {
        None => ("its own pixel", "The pixel that is argued about."),
        Some(Outcome::Same(_)) => (
            "sees it",
            "Depth, normal and color agree within the tolerances: it shows the same surface point.",
        ),
        Some(Outcome::Behind) => ("behind it", "The point lies behind this camera."),
        Some(Outcome::OutsideView) => ("out of view", "The point falls outside this camera's picture."),
        Some(Outcome::NoDepth) => ("no depth there", "The camera recorded no depth where the point falls."),
        Some(Outcome::ShorterSpan) => (
            "not as long",
            "It shows the same surface point, but for a shorter span: it is decided after this sample and cannot stand for it.",
        ),
        Some(Outcome::Occluded) => {
            ("hidden from it", "The camera recorded something nearer where the point falls.")
        }
        Some(Outcome::SeesPast) if row.vote == Some(Vote::LooksPast) => (
            "looks past it",
            "All that the camera recorded around the point is farther: it contradicts the sample.",
        ),
        Some(Outcome::SeesPast) => (
            "sees farther",
            "The camera recorded something farther where the point falls, but may have missed the surface: that contradicts nothing.",
        ),
        Some(Outcome::NormalDiffers) => {
            ("other normal", "The depth agrees, but the surfaces face different ways.")
        }
        Some(Outcome::ColorDiffers) => ("other color", "The depth agrees, but the colors differ."),
        Some(Outcome::Seam) => (
            "at its seam",
            "The surface ends beside the pixel, so that it cannot be interpolated there: it may not stand for another.",
        ),
    }
}

/// What became of a pixel, in a word or two.
pub(crate) fn fate(cameras: &[Camera], verdict: Verdict) -> String {
    let witness = cameras.get(verdict.witness_camera as usize).filter(|_| !verdict.is_kept());
    match (verdict.rule, witness) {
        (Rule::NoSample, _) => "no sample".to_owned(),
        (rule, _) if rule.keeps() => "kept".to_owned(),
        (_, Some(witness)) => format!("dropped for {}", witness.name),
        _ => "dropped".to_owned(),
    }
}

/// What became of a camera's own pixel, and for what it yields to others however dense it is; `None` outside its picture.
pub(crate) fn there(cameras: &[Camera], row: &CameraEvidence) -> Option<String> {
    let mut words = fate(cameras, row.verdict?);
    for (yields, why) in [(row.is_mixed, ", mixed"), (row.is_unsure, ", no normal")] {
        if yields {
            words.push_str(why);
        }
    }
    Some(words)
}

/// Whether a row speaks of the surface point that is argued about.
pub(crate) fn is_same_point(row: &CameraEvidence) -> bool {
    matches!(row.outcome, None | Some(Outcome::Same(_)))
}

/// The paper's rate and the footprint's, in the table and on the clipboard: of two different surface points none can be compared.
pub(crate) fn rates(row: &CameraEvidence) -> [String; 2] {
    [row.paper_r, row.footprint_r].map(|rate| number(if is_same_point(row) { rate } else { f64::NAN }))
}

/// A number that is compared with a tolerance of about one: far below it, rounded to hundredths.
pub(crate) fn distance(value: f64) -> String {
    if value.abs() < 0.1 { format!("{:.2}", value.abs()) } else { number(value) }
}

/// A number with three digits; `–` where it is not known, `infinite` where it has no end.
pub(crate) fn number(value: f64) -> String {
    if value.is_nan() {
        "–".to_owned()
    } else if value.is_infinite() {
        "infinite".to_owned()
    } else {
        text::significant(value)
    }
}

/// A chain as `front 210, 143 (dropped) » high 96, 40 (kept)`.
pub(crate) fn chain(cameras: &[Camera], links: &[ChainLink]) -> String {
    let link = |link: &ChainLink| {
        let Some(camera) = cameras.get(link.camera) else { return String::new() };
        let (x, y) = column_and_row(camera, link.pixel);
        let fate = if link.verdict.is_kept() { "kept" } else { "dropped" };
        format!("{} {x}, {y} ({fate})", camera.name)
    };
    links.iter().map(link).collect::<Vec<_>>().join(" » ")
}

/// The explanation for a pixel as text, for the clipboard.
pub(crate) fn explanation(scene: &OpenScene, probed: &Probed) -> String {
    let cameras = &scene.cameras;
    let name = cameras.get(probed.camera).map_or("", |camera| &camera.name);
    let mut lines = vec![format!("{}: camera {name}, pixel {}, {}", scene.name, probed.x, probed.y)];
    if let Some(point) = probed.point_in_world {
        lines.push(format!("Point: {:.4} {:.4} {:.4}", point.x, point.y, point.z));
    }
    if let Some(explanation) = &probed.explanation {
        lines.push(format!("Frame {}", explanation.frame + 1));
        lines.push(verdict(cameras, explanation.verdict));
        lines.extend(votes(explanation.votes, explanation.is_flying));
        if explanation.chain.len() > 1 {
            lines.push(format!("Chain: {}", chain(cameras, &explanation.chain)));
        }
    }
    if let Some(spans) = &probed.spans {
        let spans: Vec<String> =
            spans.iter().map(|span| format!("{}–{}", span.start + 1, span.end)).collect();
        let stored = if spans.is_empty() { "not stored".to_owned() } else { spans.join(", ") };
        lines.push(format!("Stored in frames: {stored}"));
    }
    if let Some(explanation) =
        probed.explanation.as_ref().filter(|explanation| !explanation.evidence.is_empty())
    {
        lines.push(
            "camera\tsees it\tdepth expected\tdepth found\toff (footprints)\tincidence (°)\tr (paper)\tr (footprint)\t\
             color (8-bit steps)\tthere"
                .to_owned(),
        );
        lines.extend(explanation.evidence.iter().map(|row| line(cameras, row)));
    }
    lines.join("\n")
}

fn line(cameras: &[Camera], row: &CameraEvidence) -> String {
    let name = cameras.get(row.camera).map_or("", |camera| &camera.name);
    let mut cells = vec![name.to_owned(), sees(row).0.to_owned()];
    cells.extend(
        [row.depth_expected, row.depth_found, row.plane_distance_footprints, row.incidence_degrees]
            .map(number),
    );
    cells.extend(rates(row));
    cells.push(number(row.color_difference_steps));
    cells.push(there(cameras, row).unwrap_or_default());
    cells.join("\t")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use glam::DVec3;

    #[test]
    fn what_is_far_below_any_tolerance_is_told_in_hundredths() {
        let told = [1.33e-5, -1e-9, 0.094, 0.77, 78.6, f64::NAN].map(distance);
        assert_eq!(told, ["0.00", "0.00", "0.09", "0.77", "78.6", "–"]);
    }

    #[test]
    fn a_dropped_pixel_names_its_witness_and_where_it_is() {
        let lens = Intrinsics::from_horizontal_angle(64, 48, 1.0);
        let camera = |name| Camera::look_at(name, lens, DVec3::ZERO, DVec3::X, DVec3::Z);
        let cameras = [camera("front"), camera("left")];
        let mut lost = Verdict::without_witness(Rule::LowerRate);
        lost.witness_camera = 1;
        lost.witness_pixel = 64 * 3 + 5;
        assert_eq!(verdict(&cameras, lost), "Dropped: left samples this point more densely, at 5, 3.");
        assert_eq!(fate(&cameras, lost), "dropped for left");
        let kept = Verdict::without_witness(Rule::BestRate);
        assert!(verdict(&cameras, kept).starts_with("Kept:"));
        let links = [
            ChainLink { camera: 0, pixel: 0, verdict: lost },
            ChainLink { camera: 1, pixel: 64 * 3 + 5, verdict: kept },
        ];
        assert_eq!(chain(&cameras, &links), "front 0, 0 (dropped) » left 5, 3 (kept)");
    }

    fn row(outcome: Option<Outcome>) -> CameraEvidence {
        CameraEvidence {
            camera: 0,
            outcome,
            position: None,
            pixel: Some(0),
            depth_expected: 4.0,
            depth_found: 2.0,
            footprint: 0.1,
            plane_distance_footprints: 20.0,
            incidence_degrees: 30.0,
            normal_angle_degrees: 10.0,
            color_difference_steps: 3.0,
            paper_r: 1.25,
            footprint_r: 1.5,
            is_mixed: false,
            is_unsure: false,
            vote: None,
            verdict: Some(Verdict::without_witness(Rule::BestRate)),
        }
    }

    #[test]
    fn no_rates_are_told_of_a_camera_that_does_not_see_the_point() {
        let copied = line(&[], &row(Some(Outcome::Occluded)));
        assert!(copied.contains("\t–\t–\t") && !copied.contains("1.25"), "{copied}");
        assert!(line(&[], &row(Some(Outcome::Same(0)))).contains("\t1.25\t1.50\t"));
        assert_eq!(rates(&row(Some(Outcome::SeesPast))), ["–", "–"]);
    }

    #[test]
    fn a_denser_sample_that_yields_says_why() {
        let mixed = CameraEvidence { is_mixed: true, is_unsure: true, ..row(Some(Outcome::Same(0))) };
        assert_eq!(there(&[], &mixed).unwrap(), "kept, mixed, no normal");
        assert_eq!(there(&[], &row(None)).unwrap(), "kept");
    }

    #[test]
    fn votes_are_told_where_any_camera_has_one() {
        let told = |confirm, look_past| votes(VoteCounts { confirm, look_past }, false);
        assert_eq!(told(0, 0), None);
        assert_eq!(told(1, 0).unwrap(), "1 camera confirms it, none looks past it.");
        assert_eq!(told(0, 3).unwrap(), "No other camera confirms it, 3 cameras look past it.");
        assert_eq!(told(2, 1).unwrap(), "2 cameras confirm it, 1 camera looks past it.");
        let flying = votes(VoteCounts::default(), true).unwrap();
        assert!(flying.starts_with("No other camera confirms it") && flying.contains("It flies"), "{flying}");
    }

    #[test]
    fn a_camera_that_may_have_missed_a_surface_is_not_said_to_look_past_it() {
        let sees_with = |vote| sees(&CameraEvidence { vote, ..row(Some(Outcome::SeesPast)) });
        assert_eq!(sees_with(Some(Vote::LooksPast)).0, "looks past it");
        let (words, why) = sees_with(Some(Vote::CannotTell));
        assert!(words == "sees farther" && why.ends_with("that contradicts nothing."));
    }

    #[test]
    fn the_rule_of_votes_names_its_margin_and_says_where_it_is_off() {
        let mut pruning = PruningSettings::default();
        assert!(rule_of_votes(&pruning).contains("by 1 camera (agreement margin)"));
        pruning.agreement_margin = 2;
        pruning.agreement = AgreementRule::Off;
        let told = rule_of_votes(&pruning);
        assert!(told.starts_with("Agreement is off") && told.contains("by 2 cameras"), "{told}");
    }

    #[test]
    fn what_is_not_known_is_a_dash() {
        assert_eq!(
            (number(f64::NAN), number(f64::INFINITY), number(1.0)),
            ("–".into(), "infinite".into(), "1.00".into())
        );
    }
}
