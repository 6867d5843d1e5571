//! What the colors of a picture mean, in the words of the window, as a figure shows it below the picture.

use std::collections::BTreeMap;

use egui::Color32;

use crate::app::camera_cues;
use crate::app::colormap::{dimmed, diverging, sequential};
use crate::app::model::percent;
use crate::app::model::picture::{
    ColorBy, HoleDisplay, Legend, LiveKey, Overlay, RATIO_RANGE, VIEW_DEPENDENCE_RANGE, ranked,
};
use crate::app::rooms::compare::state::{CLASSES, CompareMeasure, ComparisonFigure, ShownSides};
use crate::app::rooms::source::work::{UNKNOWN, empty_tiles};
use crate::app::theme::Tokens;
use crate::ways_out::figure::Unit;
use overlook_engine::capture::Camera;
use overlook_engine::preprocess::agreement::SampleAgreement;
use overlook_engine::render::{BACKGROUND_COLOR, MISSING_COLOR, NO_IMAGE, Picture, ValueColors};
use overlook_lab::chart::{ColorBar, LegendEntry};

/// Colors of a bar.
const STEPS: usize = 128;

/// What is written below a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Meaning {
    pub(crate) legend: Vec<LegendEntry>,
    pub(crate) color_bar: Option<ColorBar>,
}

impl Meaning {
    fn of(legend: impl IntoIterator<Item = LegendEntry>) -> Self {
        Self { legend: legend.into_iter().collect(), color_bar: None }
    }

    fn with_bar(self, color_bar: ColorBar) -> Self {
        Self { color_bar: Some(color_bar), ..self }
    }
}

/// What the colors of a source picture mean.
pub(crate) fn of_source(
    overlay: Overlay,
    legend: &Legend,
    cameras: &[Camera],
    dark: bool,
    unit: Unit,
) -> Meaning {
    let tokens = Tokens::of(dark);
    let no_depth = |invalid: u64, total: u64| {
        (invalid > 0).then(|| entry(tokens.invalid, format!("no depth {}", percent(invalid, total))))
    };
    let shares = |names: [(Color32, &str); 3], counts: [u64; 3], invalid: u64, total: u64| {
        let named = names.into_iter().zip(counts);
        let named =
            named.map(|((color, name), count)| entry(color, format!("{name} {}", percent(count, total))));
        Meaning::of(named.chain(no_depth(invalid, total)))
    };
    match legend {
        Legend::Plain if overlay == Overlay::Normals => {
            Meaning::of([words("Red, green and blue: the normal's x, y and z in world space.")])
        }
        Legend::Plain => Meaning::default(),
        Legend::Depth { near, far, without } => {
            let end = |name: &str, depth: f32| format!("{name}, {}", unit.length(f64::from(depth)));
            let invalid =
                (*without > 0.0).then(|| entry(tokens.invalid, format!("no depth {:.1} %", 100.0 * without)));
            Meaning::of(invalid).with_bar(bar([&end("far", *far), "", &end("near", *near)], sequential))
        }
        Legend::Ratio { unknown } => Meaning::of(unknown_entry(f64::from(*unknown)))
            .with_bar(ratio("this camera denser", "other denser")),
        Legend::Tiles(shares) => Meaning::of([entry(dimmed(Color32::GRAY, UNKNOWN), empty_tiles(shares))])
            .with_bar(bar(["few kept", "", "all kept"], sequential)),
        Legend::Classes { counts, invalid } => {
            let names = if overlay == Overlay::Split { spans(tokens) } else { agreements(tokens) };
            shares(names, *counts, *invalid, counts.iter().sum::<u64>() + invalid)
        }
        Legend::ViewDependence { visible, alike, unknown } => {
            let total = visible + alike + unknown;
            let differs = words(&format!("Differs noticeably: {}.", percent(*visible, total)));
            let alone = unknown_entry(*unknown as f64 / total.max(1) as f64);
            let high = format!("{VIEW_DEPENDENCE_RANGE:.0} of 255");
            Meaning::of([differs].into_iter().chain(alone)).with_bar(bar(["0", "", &high], sequential))
        }
        Legend::Winners { kept, lost_to, dropped, invalid } => {
            let total = kept + dropped + invalid + lost_to.iter().sum::<u64>();
            let mut legend = vec![words(&format!("kept {} (own colors)", percent(*kept, total)))];
            let (ranked, named) = ranked(lost_to);
            for camera in &ranked[..named] {
                let name = cameras.get(*camera).map_or("", |camera| camera.name.as_str());
                let text = format!("{name} {}", percent(lost_to[*camera], total));
                legend.push(entry(camera_cues::color(*camera), text));
            }
            let others: u64 = ranked[named..].iter().map(|camera| lost_to[*camera]).sum();
            if others > 0 {
                legend.push(entry(tokens.text_weak, format!("others {}", percent(others, total))));
            }
            if *dropped > 0 {
                legend
                    .push(entry(tokens.hole, format!("contradicted or mixed {}", percent(*dropped, total))));
            }
            Meaning::of(legend.into_iter().chain(no_depth(*invalid, total)))
        }
    }
}

/// What the colors of a picture of the live view mean; `background` of its holes show what cameras saw at infinity.
pub(crate) fn of_live(key: &LiveKey, rendered: &Picture, background: u64) -> Meaning {
    let mut meaning = of_samples(key, rendered);
    if !matches!(key.color_by, ColorBy::Picture | ColorBy::Value) {
        let total = rendered.image.len() as u64;
        let holes = rendered.image.as_slice().iter().filter(|image| **image == NO_IMAGE).count() as u64;
        let unseen = holes.saturating_sub(background);
        let tokens = Tokens::of(key.dark);
        let (name, color) = match key.holes {
            HoleDisplay::Hatched => ("no sample", tokens.hole_stripe),
            HoleDisplay::Filled => ("filled (invented)", Color32::GRAY),
        };
        for (name, pixels) in [(name, unseen), ("background", background)] {
            if pixels > 0 {
                meaning.legend.push(entry(color, format!("{name} {}", percent(pixels, total))));
            }
        }
    }
    meaning
}

/// That of the samples in it.
fn of_samples(key: &LiveKey, rendered: &Picture) -> Meaning {
    let tokens = Tokens::of(key.dark);
    match key.color_by {
        ColorBy::Picture => Meaning::default(),
        ColorBy::Camera => {
            let mut pixels: BTreeMap<u32, u64> = BTreeMap::new();
            for image in rendered.image.as_slice().iter().filter(|image| **image != NO_IMAGE) {
                *pixels.entry(key.samples.images[*image as usize].camera).or_default() += 1;
            }
            let total = rendered.image.len() as u64;
            let shown = pixels.into_iter().map(|(camera, count)| {
                let name = &key.samples.cameras[camera as usize].name;
                entry(camera_cues::color(camera as usize), format!("{name} {}", percent(count, total)))
            });
            Meaning::of(shown)
        }
        ColorBy::Agreement => Meaning::of(agreements(tokens).map(|(color, name)| entry(color, name))),
        ColorBy::Span => Meaning::of(spans(tokens).map(|(color, name)| entry(color, name))),
        ColorBy::Value => {
            let found = key.display.values.channel_of(&key.samples.values);
            let colored =
                found.and_then(|(_, channel)| Some((channel, key.display.values.colors(channel).ok()?)));
            let meaning =
                colored.map(|(channel, colors)| of_values(ColorBar::of_values(channel, &colors), &colors));
            meaning.unwrap_or_default()
        }
        ColorBy::SamplingRate => Meaning::default().with_bar(ratio("denser than pixels", "coarser")),
    }
}

/// What colors by value mean.
pub(crate) fn of_values(bar: ColorBar, colors: &ValueColors) -> Meaning {
    let grays = [(MISSING_COLOR, "no value"), (BACKGROUND_COLOR, "background")];
    let grays = grays.map(|(color, name)| LegendEntry { color: Some(color), name: name.to_owned() });
    let grays = grays.into_iter().filter(|_| !colors.leaves_out_missing());
    Meaning::of(grays).with_bar(bar)
}

/// What both sides of a comparison are called, and what the colors of a difference mean.
pub(crate) fn of_comparison(compared: &ComparisonFigure) -> Meaning {
    let [left, right] = &compared.names;
    match compared.shown() {
        ShownSides::One(side @ (0 | 1)) => Meaning::of([words(&compared.names[side])]),
        ShownSides::One(_) => {
            let mut meaning = Meaning::of([words(&format!("Difference of {left} and {right}"))]);
            let [low, high] = compared.measure.ends(compared.range);
            if compared.measure == CompareMeasure::Class {
                let classes = CLASSES
                    .map(|(class, name)| LegendEntry { color: Some(class.color()), name: name.to_owned() });
                meaning.legend.extend(classes);
                meaning.legend.push(words(&format!("full color: {high}")));
            } else {
                meaning.color_bar = Some(bar([&low, "", &high], |position| compared.measure.color(position)));
            }
            meaning.legend.push(entry(Tokens::of(compared.dark).raised, "no sample on one side"));
            meaning
        }
        ShownSides::Wiped(_) | ShownSides::Beside => {
            Meaning::of([words(&format!("Left: {left}")), words(&format!("Right: {right}"))])
        }
    }
}

fn spans(tokens: &Tokens) -> [(Color32, &'static str); 3] {
    [
        (tokens.static_over_time, "stored for all frames"),
        (tokens.lasting, "for several"),
        (tokens.moving, "for this frame"),
    ]
}

fn agreements(tokens: &Tokens) -> [(Color32, &'static str); 3] {
    [
        (SampleAgreement::Confirmed, "confirmed by another camera"),
        (SampleAgreement::Contradicted, "contradicted"),
        (SampleAgreement::Alone, "neither"),
    ]
    .map(|(found, name)| (tokens.of_agreement(found), name))
}

fn ratio(low: &str, high: &str) -> ColorBar {
    let end = 2.0_f32.powf(RATIO_RANGE);
    let [low, high] = [format!("r = 1/{end:.0}, {low}"), format!("{high}, r = {end:.0}")];
    bar([&low, "r = 1", &high], |position| diverging(2.0 * position - 1.0))
}

fn bar(ends: [&str; 3], color: impl Fn(f32) -> Color32) -> ColorBar {
    let colors = (0..STEPS).map(|step| rgb(color((step as f32 + 0.5) / STEPS as f32)));
    let ticks = [0.0, 0.5, 1.0].into_iter().zip(ends.map(str::to_owned));
    ColorBar { title: String::new(), colors: colors.collect(), ticks: ticks.collect() }
}

/// The dimmed picture of what one camera alone shows, where there is any; its share is 0 to 1.
fn unknown_entry(share: f64) -> Option<LegendEntry> {
    let there = (share > 0.0).then(|| format!("seen by one camera {:.1} %", 100.0 * share));
    there.map(|name| entry(dimmed(Color32::GRAY, UNKNOWN), name))
}

/// A color and what it means.
pub(crate) fn entry(color: Color32, name: impl Into<String>) -> LegendEntry {
    LegendEntry { color: Some(rgb(color)), name: name.into() }
}

fn words(text: &str) -> LegendEntry {
    LegendEntry { color: None, name: text.to_owned() }
}

fn rgb(color: Color32) -> [u8; 3] {
    [color.r(), color.g(), color.b()]
}
