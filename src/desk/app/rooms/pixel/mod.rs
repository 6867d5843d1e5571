//! The selected pixel, and the whole argument about it.

mod control;
pub(crate) mod state;
pub(crate) mod ui;
pub(crate) mod work;

use crate::app::model::camera_text::CameraText;
use crate::app::model::scene::OpenScene;
use crate::app::model::state::State;
use crate::app::rooms::pixel::state::Probed;
use crate::text;
use overlook_engine::capture::Camera;
use overlook_engine::plural::{counted, either};
use overlook_engine::preprocess::inspect::{CameraEvidence, ChainLink};
use overlook_engine::preprocess::pruning::{Rule, Verdict};
use overlook_engine::preprocess::registration::Outcome;
use overlook_engine::samples::{Vote, VoteCounts};
use overlook_engine::settings::{AgreementRule, PruningSettings};

/// A verdict as a sentence that names the witness and where it is.
pub(crate) fn verdict(cameras: &[Camera], verdict: Verdict) -> CameraText {
    let index = verdict.witness_camera as usize;
    let Some(witness) = cameras.get(index).filter(|_| !verdict.is_kept()) else {
        return CameraText::new(verdict.rule.sentence());
    };
    let place = place(witness, verdict.witness_pixel, ", at");
    let told =
        |before: &str, after: &str| CameraText::new(before).camera(index).words(format!(" {after}{place}."));
    match verdict.rule {
        Rule::LowerRate => told("Dropped: ", "samples this point more densely"),
        Rule::Tie => told("Dropped: ", "samples it as densely and comes first"),
        Rule::LaterCamera => told("Dropped: ", "shows this point and comes first"),
        Rule::MixedYields => told("Dropped: edge-blended here; the sample of ", "is clean"),
        Rule::UnsureYields => told("Dropped: no normal is known here; ", "knows it"),
        rule => {
            CameraText::new(format!("{} Witness: ", rule.sentence())).camera(index).words(format!("{place}."))
        }
    }
}

/// The text in place of a frame that could not be computed.
pub(crate) const FAILED_FRAME: &str = "This frame could not be computed: see the reason in Help > Log.";

/// Shown while a verdict is not known yet, of the pinned pixel or of the one under the pointer.
pub(crate) fn pending_verdict(state: &State, is_kept: bool) -> &'static str {
    if state.is_frame_failed() {
        FAILED_FRAME
    } else if state.timeline.playing && is_kept {
        "Playing: pause to read its verdict."
    } else if state.timeline.playing {
        "Playing: pause, or click a pixel, to read its verdict."
    } else {
        "Computing its verdict."
    }
}

/// The explanation of a doubtful sample.
pub(crate) const DOUBTFUL: &str = "Doubtful: other cameras had a free view of this place, and none confirms it. It is shown only where no other sample is.";

/// How many other cameras confirm a sample and how many look past it, and whether it flies; `None` where none does anything.
pub(crate) fn votes(counts: VoteCounts, is_flying: bool) -> Option<String> {
    let VoteCounts { confirm, look_past } = counts;
    let flying = if is_flying {
        " It is a flying pixel between foreground and background: its own camera contradicts it, too."
    } else {
        ""
    };
    let told = |cameras, none: &str, one, many| match cameras {
        0 => none.to_owned(),
        _ => format!("{} {} it", counted(cameras, "camera"), either(cameras, one, many)),
    };
    let confirming = told(confirm, "No other camera confirms it", "confirms", "confirm");
    let looking_past = told(look_past, "none contradicts it", "contradicts", "contradict");
    (is_flying || confirm + look_past > 0).then(|| format!("{confirming}, {looking_past}.{flying}"))
}

/// How votes drop a sample, with the settings that decide it.
pub(crate) fn rule_of_votes(pruning: &PruningSettings) -> String {
    let cameras = counted(pruning.agreement_margin, "camera");
    let is_off = match pruning.agreement {
        AgreementRule::Majority => "",
        AgreementRule::Off => {
            "The cross-camera check is off, so that no sample is dropped by votes. By majority: "
        }
    };
    format!(
        "{is_off}A sample without a witness is dropped if the cameras that contradict it outnumber those that confirm it, its own \
         among these, by {cameras} (vote margin)."
    )
}

/// Column and row of a pixel, behind some words; nothing where no pixel is known: a store knows the camera of a witness alone.
fn place(camera: &Camera, pixel: u32, before: &str) -> String {
    let width = camera.intrinsics.width.max(1);
    if pixel == Verdict::NO_PIXEL {
        String::new()
    } else {
        format!("{before} {}, {}", pixel % width, pixel / width)
    }
}

/// Whether a camera sees the point, and the rule behind that.
pub(crate) fn sees(row: &CameraEvidence) -> (&'static str, &'static str) {
    match row.outcome {
        None => ("this pixel", "The selected pixel itself."),
        Some(Outcome::Same(_)) => (
            "visible",
            "Depth, normal and color agree within the tolerances: it shows the same surface point.",
        ),
        Some(Outcome::Behind) => ("behind camera", "The point lies behind this camera."),
        Some(Outcome::OutsideView) => ("out of view", "The point falls outside this camera's picture."),
        Some(Outcome::NoDepth) => ("no depth", "The camera recorded no depth where the point falls."),
        Some(Outcome::ShorterSpan) => (
            "stored for fewer frames",
            "It shows the same surface point, but for a shorter span, and a shorter span never replaces a longer one.",
        ),
        Some(Outcome::Occluded) => {
            ("occluded", "The camera recorded something nearer where the point falls.")
        }
        Some(Outcome::SeesPast) if row.vote == Some(Vote::LooksPast) => (
            "misses (empty space)",
            "The camera recorded only farther surfaces around the point, so that the point would be in empty space: it contradicts the sample.",
        ),
        Some(Outcome::SeesPast) => (
            "looks past this point",
            "The camera recorded something farther where the point falls, but may have missed the surface: that contradicts nothing.",
        ),
        Some(Outcome::NormalDiffers) => {
            ("other normal", "The depth agrees, but the surfaces face different ways.")
        }
        Some(Outcome::ColorDiffers) => ("other color", "The depth agrees, but the colors differ."),
        Some(Outcome::ValueDiffers) => ("other value", "The depth agrees, but scalar values differ."),
        Some(Outcome::Seam) => (
            "at a depth edge",
            "The surface ends beside the pixel and cannot be interpolated there, so that the pixel may not replace another.",
        ),
    }
}

/// The indices of rows of evidence, in the order of what matters: the pixel itself, its witness, other cameras that show the point
/// (the densest first), cameras that nearly do, and last the cameras whose pictures do not hold it.
pub(crate) fn ordered(evidence: &[CameraEvidence], winner: Option<usize>) -> Vec<usize> {
    let rank = |place: &usize| {
        let row = &evidence[*place];
        let group = match row.outcome {
            None => 0,
            Some(_) if winner == Some(row.camera) => 1,
            Some(Outcome::Same(_)) => 2,
            Some(Outcome::SeesPast) if row.vote == Some(Vote::LooksPast) => 4,
            Some(Outcome::SeesPast | Outcome::Occluded) => 5,
            Some(Outcome::NoDepth) => 6,
            Some(Outcome::OutsideView | Outcome::Behind) => 7,
            Some(_) => 3,
        };
        // This pixel's r beside that camera's: the larger, the denser that camera is.
        let denser = if is_same_point(row) && row.footprint_r.is_finite() { -row.footprint_r } else { 0.0 };
        (group, denser)
    };
    let mut order: Vec<usize> = (0..evidence.len()).collect();
    order.sort_by(|a, b| {
        let ((a_group, a_denser), (b_group, b_denser)) = (rank(a), rank(b));
        a_group.cmp(&b_group).then(a_denser.total_cmp(&b_denser))
    });
    order
}

/// What became of a pixel, in a word or two.
pub(crate) fn fate(verdict: Verdict) -> CameraText {
    match verdict.rule {
        Rule::NoSample => CameraText::new("no sample"),
        rule if rule.keeps() => CameraText::new("kept"),
        _ if verdict.witness_camera == Verdict::NO_CAMERA => CameraText::new("dropped"),
        _ => CameraText::new("dropped for ").camera(verdict.witness_camera as usize),
    }
}

/// The verdict on a camera's own pixel, with the reasons for which it yields at any density; `None` outside its picture.
pub(crate) fn own_sample(row: &CameraEvidence) -> Option<CameraText> {
    let mut text = fate(row.verdict?);
    for (yields, why) in [(row.is_mixed, ", edge-blended"), (row.is_unsure, ", no normal")] {
        if yields {
            text = text.words(why);
        }
    }
    Some(text)
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

/// A number with three digits; `–` for NaN, `infinite` for infinity.
pub(crate) fn number(value: f64) -> String {
    if value.is_nan() {
        "–".to_owned()
    } else if value.is_infinite() {
        "infinite".to_owned()
    } else {
        text::significant(value)
    }
}

/// A chain as `'front' 210, 143 (dropped) » 'high' 96, 40 (kept)`.
pub(crate) fn chain(cameras: &[Camera], links: &[ChainLink]) -> CameraText {
    let mut text = CameraText::default();
    for (index, link) in links.iter().enumerate() {
        let Some(camera) = cameras.get(link.camera) else { continue };
        let place = place(camera, link.pixel, "");
        let fate = if link.verdict.is_kept() { "kept" } else { "dropped" };
        let before = if index == 0 { "" } else { " » " };
        text = text.words(before).camera(link.camera).words(format!("{place} ({fate})"));
    }
    text
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
        lines.push(verdict(cameras, explanation.verdict).plain(cameras));
        lines.extend(votes(explanation.votes, explanation.is_flying));
        lines.extend(explanation.is_doubtful.then(|| DOUBTFUL.to_owned()));
        if explanation.chain.len() > 1 {
            lines.push(format!("Chain: {}", chain(cameras, &explanation.chain).plain(cameras)));
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
            "camera\tvisible\tdepth expected\tdepth found\tdepth error (footprints)\tincidence (°)\tpaper r\tfootprint density\t\
             color (8-bit steps)\tits own sample"
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
    cells.push(own_sample(row).unwrap_or_default().plain(cameras));
    cells.join("\t")
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use overlook_engine::capture::Intrinsics;

    #[test]
    fn what_is_far_below_any_tolerance_is_told_in_hundredths_and_what_is_not_known_is_a_dash() {
        let told = [1.33e-5, -1e-9, 0.094, 0.77, 78.6, f64::INFINITY, f64::NAN].map(distance);
        assert_eq!(told, ["0.00", "0.00", "0.09", "0.77", "78.6", "infinite", "–"]);
    }

    #[test]
    fn a_dropped_pixel_names_its_witness_and_where_it_is() {
        let lens = Intrinsics::from_horizontal_angle(64, 48, 1.0);
        let camera = |name| Camera::look_at(name, lens, DVec3::ZERO, DVec3::X, DVec3::Z);
        let cameras = [camera("front"), camera("left")];
        let mut lost = Verdict::without_witness(Rule::LowerRate);
        lost.witness_camera = 1;
        lost.witness_pixel = 64 * 3 + 5;
        assert_eq!(
            verdict(&cameras, lost).plain(&cameras),
            "Dropped: 'left' samples this point more densely, at 5, 3."
        );
        assert_eq!(fate(lost).plain(&cameras), "dropped for 'left'");
        let of_store = Verdict { witness_pixel: Verdict::NO_PIXEL, ..lost };
        assert_eq!(
            verdict(&cameras, of_store).plain(&cameras),
            "Dropped: 'left' samples this point more densely."
        );
        let kept = Verdict::without_witness(Rule::BestRate);
        assert!(verdict(&cameras, kept).plain(&cameras).starts_with("Kept:"));
        let links = [
            ChainLink { camera: 0, pixel: 0, verdict: lost },
            ChainLink { camera: 1, pixel: 64 * 3 + 5, verdict: kept },
        ];
        assert_eq!(chain(&cameras, &links).plain(&cameras), "'front' 0, 0 (dropped) » 'left' 5, 3 (kept)");
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
    fn rows_are_ordered_by_what_they_say_of_the_point() {
        let at = |camera, outcome, footprint_r| CameraEvidence { camera, footprint_r, ..row(outcome) };
        let evidence = [
            at(0, Some(Outcome::OutsideView), 1.0),
            at(1, Some(Outcome::Same(0)), 0.5),
            at(2, None, 1.0),
            at(3, Some(Outcome::Same(0)), 2.0),
            at(4, Some(Outcome::Occluded), 3.0),
            at(5, Some(Outcome::Same(0)), 1.5),
        ];
        assert_eq!(ordered(&evidence, Some(5)), [2, 5, 3, 1, 4, 0]);
    }

    #[test]
    fn a_denser_sample_that_yields_says_why() {
        let mixed = CameraEvidence { is_mixed: true, is_unsure: true, ..row(Some(Outcome::Same(0))) };
        assert_eq!(own_sample(&mixed).unwrap().plain(&[]), "kept, edge-blended, no normal");
        assert_eq!(own_sample(&row(None)).unwrap().plain(&[]), "kept");
    }

    #[test]
    fn votes_are_told_where_any_camera_has_one() {
        let told = |confirm, look_past| votes(VoteCounts { confirm, look_past }, false);
        assert_eq!(told(0, 0), None);
        assert_eq!(told(1, 0).unwrap(), "1 camera confirms it, none contradicts it.");
        assert_eq!(told(0, 3).unwrap(), "No other camera confirms it, 3 cameras contradict it.");
        assert_eq!(told(2, 1).unwrap(), "2 cameras confirm it, 1 camera contradicts it.");
        let flying = votes(VoteCounts::default(), true).unwrap();
        assert!(
            flying.starts_with("No other camera confirms it") && flying.contains("flying pixel"),
            "{flying}"
        );
    }

    #[test]
    fn a_camera_that_may_have_missed_a_surface_is_not_said_to_look_past_it() {
        let sees_with = |vote| sees(&CameraEvidence { vote, ..row(Some(Outcome::SeesPast)) });
        assert_eq!(sees_with(Some(Vote::LooksPast)).0, "misses (empty space)");
        let (words, why) = sees_with(Some(Vote::CannotTell));
        assert!(words == "looks past this point" && why.ends_with("that contradicts nothing."));
    }

    #[test]
    fn the_rule_of_votes_names_its_margin_and_says_where_it_is_off() {
        let mut pruning = PruningSettings::default();
        assert!(rule_of_votes(&pruning).contains("by 1 camera (vote margin)"));
        pruning.agreement_margin = 2;
        pruning.agreement = AgreementRule::Off;
        let told = rule_of_votes(&pruning);
        assert!(told.starts_with("The cross-camera check is off") && told.contains("by 2 cameras"), "{told}");
    }
}
