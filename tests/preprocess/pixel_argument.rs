//! The argument for a pixel agrees with the verdict, and a rendered pixel leads back to the sample that painted it.

use glam::DVec2;
use overlook_engine::capture::Capture;
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::job::Job;
use overlook_engine::preprocess::inspect::{
    CameraEvidence, FrameInspection, PixelExplanation, explain_pixel, pair_quantities, spans_of_pixel,
};
use overlook_engine::preprocess::pruning::{Rule, Verdict};
use overlook_engine::preprocess::registration::Outcome;
use overlook_engine::preprocess::{self, PreparedScan};
use overlook_engine::render::output::pick;
use overlook_engine::render::{CpuRenderer, Vantage};
use overlook_engine::settings::{Kernel, RateModel, Settings};
use std::collections::BTreeMap;
use std::sync::Arc;

fn capture() -> Capture {
    demo("orrery")
}

fn demo(scene: &str) -> Capture {
    let spec = DemoSpec::new(scene).cameras(4).frames(3).size((96, 72));
    Demo::new(&spec).unwrap().capture(&Settings::default().capture)
}

fn inspected(capture: &Capture, settings: &Settings) -> (Arc<PreparedScan>, FrameInspection) {
    let job = Job::new();
    let scan = preprocess::scan(capture, settings, &job).unwrap();
    let inspection = preprocess::inspect_frame(capture, Some(&scan), settings, 1, &job).unwrap();
    (scan, inspection)
}

/// A scene with normals, and an antialiased one whose normals have to be estimated, which leaves some unknown.
fn cases() -> [(Capture, Settings); 2] {
    let mut paper = Settings::default();
    paper.pruning.rate = RateModel::Paper;
    [(capture(), Settings::default()), (demo("nine-cameras"), paper)]
}

/// Whose samples yield to whose, however dense: clean ones last.
fn class(row: &CameraEvidence) -> (bool, bool) {
    (row.is_mixed, row.is_unsure)
}

/// The arguments of every fifth pixel of every camera.
fn arguments(inspection: &FrameInspection) -> Vec<PixelExplanation> {
    let mut arguments = Vec::new();
    for (camera, inspected) in inspection.cameras.iter().enumerate() {
        let (width, height) = inspected.verdict.size();
        for y in (0..height).step_by(5) {
            for x in (0..width).step_by(5) {
                arguments.push(explain_pixel(inspection, camera, x, y).unwrap());
            }
        }
    }
    arguments
}

#[test]
fn every_dropped_pixel_is_outweighed_by_its_winner_in_the_numbers_shown() {
    let mut by_rule = BTreeMap::<_, u32>::new();
    for (capture, settings) in cases() {
        hold_against_winners(&capture, &settings, &mut by_rule);
    }
    for rule in [Rule::LowerRate, Rule::MixedYields, Rule::UnsureYields] {
        assert!(by_rule.get(&rule).is_some_and(|count| *count > 5), "{by_rule:?}");
    }
}

fn hold_against_winners(capture: &Capture, settings: &Settings, by_rule: &mut BTreeMap<Rule, u32>) {
    let (scan, inspection) = inspected(capture, settings);
    // Colors may differ by the tolerance and by what noise explains: three standard deviations of both samples' together.
    let noise =
        scan.cameras.iter().map(|camera| camera.noise.color_steps.iter().copied().fold(0.0, f32::max));
    let noise = 3.0 * std::f32::consts::SQRT_2 * noise.fold(0.0, f32::max);
    let color_limit = f64::from(settings.pruning.color_tolerance + noise) * 1.001;
    let mut lost = 0;
    for argument in arguments(&inspection) {
        let Some(witness) = argument.chain.get(1).filter(|_| !argument.verdict.is_kept()) else { continue };
        lost += 1;
        assert_eq!(argument.winner, Some(witness.camera));
        assert!(witness.verdict.is_kept(), "the last of the chain stays");
        let row = &argument.evidence[witness.camera];
        assert_eq!(row.outcome, Some(Outcome::Same(witness.pixel)));
        assert!(row.plane_distance_footprints <= f64::from(settings.pruning.depth_tolerance) * 1.001 + 1e-3);
        let own = &argument.evidence[argument.camera];
        assert!(own.is_mixed || row.color_difference_steps <= color_limit, "{row:?}");
        *by_rule.entry(argument.verdict.rule).or_default() += 1;
        match argument.verdict.rule {
            Rule::LowerRate => assert!(class(row) == class(own) && row.paper_r > 1.0, "{argument:?}"),
            Rule::Tie => assert_eq!(class(row), class(own)),
            Rule::MixedYields => assert!(own.is_mixed && !row.is_mixed, "{argument:?}"),
            Rule::UnsureYields => assert!(own.is_unsure && !row.is_unsure, "{argument:?}"),
            rule => panic!("{rule:?} has a witness"),
        }
    }
    assert!(lost > 100, "{lost}");
}

#[test]
fn what_is_kept_as_the_only_witness_is_shown_by_no_sample_that_stays_in_the_table() {
    let (_, inspection) = inspected(&capture(), &Settings::default());
    let (mut alone, mut shorter) = (0, 0);
    for argument in arguments(&inspection) {
        let rows = || argument.evidence.iter();
        shorter += rows().filter(|row| row.outcome == Some(Outcome::ShorterSpan)).count();
        if argument.verdict.rule == Rule::OnlyWitness {
            alone += 1;
            let shown_by = rows().find(|row| {
                let same = matches!(row.outcome, Some(Outcome::Same(_)));
                same && row.verdict.is_some_and(Verdict::is_kept)
            });
            assert!(shown_by.is_none(), "{argument:?}");
        }
    }
    assert!(alone > 50 && shorter > 50, "{alone}, {shorter}");
}

#[test]
fn who_is_kept_though_a_better_sample_is_in_the_table_is_kept_because_that_one_does_not_stand() {
    let mut across = Settings::default();
    across.pruning.across_spans = false;
    let (mut better_beside, mut denser_beside) = (0, 0);
    for (capture, settings) in cases().into_iter().chain([(capture(), across)]) {
        let (_, inspection) = inspected(&capture, &settings);
        for argument in arguments(&inspection).iter().filter(|argument| argument.verdict.is_kept()) {
            let own = &argument.evidence[argument.camera];
            let rows = argument.evidence.iter().filter(|row| matches!(row.outcome, Some(Outcome::Same(_))));
            let (mut better, mut denser) = (false, false);
            for row in rows {
                better |= class(row) < class(own) || (class(row) == class(own) && row.paper_r > 1.001);
                denser |= class(row) > class(own) && row.paper_r > 1.001;
            }
            if better {
                better_beside += 1;
                assert_eq!(argument.verdict.rule, Rule::Coverage, "{argument:?}");
            } else if denser && argument.verdict.rule == Rule::BestRate {
                denser_beside += 1;
                assert!(argument.verdict.rule.sentence().contains("reliable"), "{argument:?}");
            }
        }
    }
    assert!(better_beside > 20 && denser_beside > 0, "{better_beside}, {denser_beside}");
}

#[test]
fn a_camera_that_is_blocked_found_something_nearer_and_one_that_looks_past_something_farther() {
    let (_, inspection) = inspected(&capture(), &Settings::default());
    let (mut blocked, mut past) = (0, 0);
    for row in arguments(&inspection).iter().flat_map(|argument| &argument.evidence) {
        match row.outcome {
            Some(Outcome::Occluded) if row.depth_expected.is_finite() => {
                blocked += 1;
                assert!(row.depth_found < row.depth_expected * 1.001, "{row:?}");
            }
            Some(Outcome::SeesPast) => {
                past += 1;
                assert!(row.depth_found > row.depth_expected * 0.999, "{row:?}");
            }
            None => {
                assert_eq!(row.color_difference_steps, 0.0);
                assert!(row.paper_r.is_nan() || (row.paper_r - 1.0).abs() < 1e-6);
                let off = (row.depth_expected - row.depth_found).abs();
                assert!(off.is_nan() || off < 1e-4 * row.depth_expected, "{row:?}");
            }
            _ => {}
        }
    }
    assert!(blocked > 20 && past > 20, "{blocked} {past}");
}

#[test]
fn the_spans_of_a_pixel_hold_it_at_exactly_the_frames_where_it_was_kept() {
    let (capture, settings, job) = (capture(), Settings::default(), Job::new());
    let (scan, inspection) = inspected(&capture, &settings);
    let whole = preprocess::prune(&capture, &scan, &settings, &job).unwrap();
    let mut kept = 0;
    for argument in arguments(&inspection) {
        let spans = spans_of_pixel(&whole.samples, argument.camera, argument.x, argument.y);
        let stored_here = spans.iter().any(|span| span.contains(1));
        assert_eq!(stored_here, argument.verdict.is_kept(), "{argument:?}");
        kept += usize::from(stored_here);
    }
    assert!(kept > 100);
}

#[test]
fn outside_the_picture_there_is_nothing_to_argue_about() {
    let (_, inspection) = inspected(&capture(), &Settings::default());
    assert!(explain_pixel(&inspection, 9, 0, 0).is_none());
    assert!(explain_pixel(&inspection, 0, 96, 0).is_none());
    assert!(pair_quantities(&inspection, 5000).len() > 500);
}

#[test]
fn pairs_of_one_surface_need_no_more_than_the_depth_tolerance_whatever_noise_they_have() {
    let settings = Settings::default();
    let noisy = DemoSpec::new("orrery").cameras(4).frames(3).size((96, 72)).noise(0.05);
    let noisy = Demo::new(&noisy).unwrap().capture(&settings.capture);
    for capture in [capture(), noisy] {
        let (_, inspection) = inspected(&capture, &settings);
        let pairs = pair_quantities(&inspection, 5000);
        let same: Vec<f32> = pairs
            .iter()
            .filter(|pair| matches!(pair.outcome, Outcome::Same(_)))
            .map(|pair| pair.depth_tolerance_needed)
            .collect();
        let most = same.iter().copied().fold(0.0, f32::max);
        assert!(same.len() > 100 && most <= settings.pruning.depth_tolerance * 1.001, "{most}");
        let beyond = pairs.iter().filter(|pair| pair.depth_tolerance_needed > 2.0).count();
        assert!(beyond > 10, "{beyond} pairs are of two surfaces");
    }
}

#[test]
fn a_rendered_pixel_leads_back_to_the_sample_that_painted_it() {
    let (_, inspection) = inspected(&capture(), &Settings::default());
    let samples = &inspection.samples;
    let (a, b) = (&samples.cameras[0], &samples.cameras[1]);
    let mut camera = a.clone();
    camera.world_from_camera.translation =
        a.world_from_camera.translation.lerp(b.world_from_camera.translation, 0.2);
    let vantage = Vantage { camera, frame: 1 };
    // Footprints of surfaces seen from the side reach farther than the samples around them.
    for (kernel, reach, share) in
        [(Kernel::Point, 0.7072, 1.0), (Kernel::Block, 1.5, 1.0), (Kernel::Gather, 2.0, 0.97)]
    {
        let mut settings = Settings::default().render;
        settings.kernel = kernel;
        let (picture, _) = CpuRenderer::new().render(samples, &vantage, &settings, &Job::new()).unwrap();
        let (mut found, mut near) = (0_u32, 0_u32);
        for y in (0..72).step_by(3) {
            for x in (0..96).step_by(3) {
                let Some(picked) = pick(samples, &vantage, &picture, x, y) else {
                    let hole = picture.image[(x, y)] == overlook_engine::render::NO_IMAGE;
                    assert!(hole, "{kernel:?}: nothing at {x}, {y}");
                    continue;
                };
                found += 1;
                let image = &samples.images[picked.image];
                assert_eq!(image.camera as usize, picked.camera);
                let inverse_depth = image.inverse_depths()[picked.index];
                if inverse_depth <= 0.0 {
                    near += 1;
                    continue;
                }
                let center = DVec2::new(picked.x as f64 + 0.5, picked.y as f64 + 0.5);
                let point = samples.cameras[picked.camera].unproject(center, 1.0 / f64::from(inverse_depth));
                let (position, _) = vantage.camera.project(point).unwrap();
                let off = (position - DVec2::new(x as f64 + 0.5, y as f64 + 0.5)).length();
                near += u32::from(off <= reach);
            }
        }
        assert!(found > 300, "{kernel:?}: {found}");
        assert!(f64::from(near) >= share * f64::from(found), "{kernel:?}: {near} of {found}");
    }
}
