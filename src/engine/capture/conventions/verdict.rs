//! The conclusion from the scores: whether the claimed reading holds, which one fits instead, and how sure that is.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::agreement::Comparison;
use super::buffer_planes::{FoundBetween, may_be_buffer};
use super::reading::{LensReading, Reading};
use super::search::{NARROW, NOT_CHANCE, Scored, UNITS, three_digits};
use super::views::POINTS;

/// A reading that agrees this many times as well refutes the claimed one, and differs surely from others.
const DECIDES: f64 = 2.0;
/// From this on it is sure.
const SURE: f64 = 3.0;
/// Scores within this ratio are equal; the claimed reading is kept then.
const EQUAL: f64 = 1.25;
/// Cameras closer together than this share of the depth cannot distinguish units.
const MIN_BASELINE: f64 = 0.05;
/// Units within this ratio are one.
const SAME_UNIT: f64 = 1.06;

/// What to try with numbers that may be a depth buffer.
const BUFFER_ADVICE: &str = "; depth between 0 and 1 may be a depth buffer: write \"depth_kind\": \"z_buffer\" or \"reversed_z_buffer\", and the planes as \"depth_range\": [near, far]";

/// A capture's conventions, judged by the agreement between its views.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// The outcome.
    pub verdict: ConventionVerdict,
    /// How the capture is read.
    pub claimed: Reading,
    /// Points of one view that another confirms, less points that it contradicts, as a share of all, as the capture is read.
    pub claimed_score: f64,
}

/// Whether the claimed reading holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "outcome", rename_all = "snake_case")]
pub enum ConventionVerdict {
    /// No other reading fits far better.
    Stands {
        /// Parts that another reading would fit as well, and why the views cannot decide.
        undecided: Vec<Undecided>,
    },
    /// Another reading fits far better.
    Other(Box<Alternative>),
    /// The views decide nothing.
    Unknown {
        /// Why.
        why: String,
    },
}

/// A reading that fits far better than the claimed one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Alternative {
    /// The reading.
    pub reading: Reading,
    /// What shows it.
    #[serde(default)]
    pub evidence: Evidence,
    /// By depth, its score as [`Finding::claimed_score`]; by pictures, their correlation.
    pub score: f64,
    /// How many times as well it fits as any reading of another pose, measure or unit, or by pictures as the claimed one; at most 99.
    pub margin: f64,
    /// Parts of it that another reading would fit about as well.
    pub undecided: Vec<Undecided>,
    /// The keys of a manifest that is read this way, with their values as JSON.
    pub keys: Vec<(String, String)>,
}

/// What shows that a reading fits far better.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Evidence {
    /// Points of one view are where another sees a surface.
    #[default]
    Depth,
    /// Patches of one picture look like what another shows in their place.
    Pictures {
        /// The correlation of pictures as the capture is read, at most 1.
        as_read: f64,
    },
}

/// Parts of a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReadingPart {
    /// Direction and axes of poses.
    Pose,
    /// What depth measures.
    Measure,
    /// The unit of depth.
    Unit,
    /// Focal lengths and principal points.
    Lens,
}

/// A part that the views cannot decide.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Undecided {
    /// Which.
    pub part: ReadingPart,
    /// Why.
    pub why: String,
}

/// Decides on readings, best first.
pub(super) fn decide(comparison: &Comparison, scored: &[Scored]) -> Finding {
    let claimed = comparison.claimed;
    let claimed_score = scored.iter().find(|s| s.reading == claimed).map_or(0.0, |s| s.score);
    let finding = |verdict| Finding { verdict, claimed, claimed_score };
    let best = scored.first().map_or(0.0, |scored| scored.score);
    if best < NOT_CHANCE {
        let mut why = "the views agree under no reading: they may show different things, poses or lenses may be wrong, or depth too noisy".to_owned();
        if may_be_buffer(comparison) {
            why += BUFFER_ADVICE;
        }
        return finding(ConventionVerdict::Unknown { why });
    }
    let chosen = chosen(comparison, scored, best);
    let parts = [ReadingPart::Pose, ReadingPart::Measure, ReadingPart::Unit];
    let undecided = |from: &Scored| -> Vec<Undecided> {
        let margin = |part| margin(comparison, scored, from, part);
        let open = parts.into_iter().filter(|part| margin(*part) < DECIDES);
        open.map(|part| Undecided { part, why: why_undecided(comparison, &from.reading, part) }).collect()
    };
    if claimed_score * DECIDES >= best || is_same(comparison, &chosen.reading, &claimed) {
        let claimed = Scored { reading: claimed, score: claimed_score };
        return finding(ConventionVerdict::Stands { undecided: undecided(&claimed) });
    }
    let margins = parts.map(|part| margin(comparison, scored, &chosen, part));
    finding(ConventionVerdict::Other(Box::new(Alternative {
        reading: chosen.reading,
        score: chosen.score,
        margin: margins.into_iter().fold(99.0, f64::min),
        undecided: undecided(&chosen),
        keys: keys(comparison, &chosen.reading),
        evidence: Evidence::Depth,
    })))
}

/// What numbers between 0 and 1 are found to mean.
pub(super) fn of_planes(comparison: &Comparison, found: &FoundBetween) -> Finding {
    let FoundBetween { reading, margin } = *found;
    let why = "numbers between 0 and 1 that are even in depth fit about as well as those that are even in its reciprocal";
    let undecided = Undecided { part: ReadingPart::Measure, why: why.to_owned() };
    let score = |reading| comparison.score(reading, POINTS, NARROW);
    let other = Alternative {
        reading,
        evidence: Evidence::Depth,
        score: score(&reading),
        margin,
        undecided: if margin < DECIDES { vec![undecided] } else { Vec::new() },
        keys: keys(comparison, &reading),
    };
    let verdict = ConventionVerdict::Other(Box::new(other));
    Finding { verdict, claimed: comparison.claimed, claimed_score: score(&comparison.claimed) }
}

/// The reading that changes the least of what was claimed, among those that fit about as well as the best.
fn chosen(comparison: &Comparison, scored: &[Scored], best: f64) -> Scored {
    let claimed = &comparison.claimed;
    let changes = |s: &Scored| {
        let parts = [ReadingPart::Pose, ReadingPart::Measure, ReadingPart::Unit].into_iter();
        let changed = parts.filter(|part| differs(comparison, &s.reading, claimed, *part)).count();
        let is_mirrored = comparison.poses(&s.reading).iter().any(|pose| pose.matrix3.determinant() < 0.0);
        let pose = s.reading.pose;
        let named = [pose.direction != claimed.pose.direction, pose.axes != claimed.pose.axes];
        let is_uncommon = !UNITS.contains(&s.reading.unit) && s.reading.unit != claimed.unit;
        (changed, is_mirrored, named.into_iter().filter(|is_so| *is_so).count(), is_uncommon)
    };
    let equal = scored.iter().filter(|s| s.score * EQUAL >= best);
    equal.min_by_key(|s| changes(s)).copied().unwrap_or(Scored { reading: *claimed, score: 0.0 })
}

fn is_same(comparison: &Comparison, a: &Reading, b: &Reading) -> bool {
    [ReadingPart::Pose, ReadingPart::Measure, ReadingPart::Unit]
        .into_iter()
        .all(|part| !differs(comparison, a, b, part))
}

/// Whether two readings differ in a part so that views could show it.
fn differs(comparison: &Comparison, a: &Reading, b: &Reading, part: ReadingPart) -> bool {
    match part {
        ReadingPart::Pose => a.pose != b.pose && !comparison.are_one_arrangement(a, b),
        ReadingPart::Measure => {
            !a.measure.is_like(b.measure, comparison.near_clip, comparison.middle_depth(a))
        }
        ReadingPart::Unit if a.measure.is_buffer() || b.measure.is_buffer() => false,
        ReadingPart::Unit => {
            let ratio = a.unit / b.unit;
            ratio.max(ratio.recip()) > SAME_UNIT
        }
        ReadingPart::Lens => a.lens != b.lens,
    }
}

/// How many times as well a reading fits as any other that differs in a part; at most 99.
fn margin(comparison: &Comparison, scored: &[Scored], from: &Scored, part: ReadingPart) -> f64 {
    let others = scored.iter().filter(|s| differs(comparison, &s.reading, &from.reading, part));
    let runner_up = others.map(|s| s.score).fold(0.0, f64::max);
    (from.score / runner_up.max(1e-3)).min(99.0)
}

fn why_undecided(comparison: &Comparison, reading: &Reading, part: ReadingPart) -> String {
    let baseline = comparison.baseline_over_depth(reading);
    match part {
        ReadingPart::Unit if baseline < MIN_BASELINE => format!(
            "the cameras stand too close together ({:.1} % of the depth) to tell the unit of depth",
            100.0 * baseline
        ),
        ReadingPart::Unit => "another unit of depth fits about as well".to_owned(),
        ReadingPart::Pose => {
            "other axes of the poses fit about as well: cameras that look the same way from one plane, or a scene that is flat or symmetric, cannot tell them".to_owned()
        }
        ReadingPart::Measure => {
            "planar depth and distance along the ray fit about as well: the lenses are too narrow, or the depth too noisy, to tell them".to_owned()
        }
        ReadingPart::Lens => "other lenses fit about as well".to_owned(),
    }
}

/// The keys of the manifest by which a reading differs from the claimed one.
pub(super) fn keys(comparison: &Comparison, reading: &Reading) -> Vec<(String, String)> {
    let claimed = &comparison.claimed;
    let mut keys = Vec::new();
    if differs(comparison, reading, claimed, ReadingPart::Pose) {
        if reading.pose.direction != claimed.pose.direction {
            keys.push(("transform_direction", format!("\"{}\"", reading.pose.direction.name())));
        }
        if reading.pose.axes != claimed.pose.axes {
            keys.push(("camera_axes", reading.pose.axes.json()));
        }
    }
    if let Some(kind) = reading.measure.depth_kind()
        && differs(comparison, reading, claimed, ReadingPart::Measure)
    {
        keys.push(("depth_kind", format!("\"{kind}\"")));
    }
    let is_buffer = reading.measure.is_buffer();
    if let Some(planes) = reading.planes.filter(|_| is_buffer && reading.planes != claimed.planes) {
        let far = planes.far.map_or_else(|| "null".to_owned(), number);
        keys.push(("depth_range", format!("[{}, {far}]", number(planes.near))));
    }
    if differs(comparison, reading, claimed, ReadingPart::Unit) {
        keys.push(("depth_unit_scale_factor", number(reading.unit)));
    }
    keys.extend(lens_keys(comparison, &reading.lens));
    keys.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// The keys of another lens; none where cameras have different lenses, which no key expresses together.
fn lens_keys(comparison: &Comparison, reading: &LensReading) -> Vec<(&'static str, String)> {
    let mut lenses = comparison.views.iter().map(|view| view.intrinsics);
    let Some(first) = lenses.next().filter(|first| lenses.all(|lens| lens == *first)) else {
        return Vec::new();
    };
    let read = reading.of(&first);
    let values = [
        ("fl_x", read.fx, first.fx),
        ("fl_y", read.fy, first.fy),
        ("cx", read.cx, first.cx),
        ("cy", read.cy, first.cy),
    ];
    let changed = values.into_iter().filter(|(_, read, claimed)| read != claimed);
    changed.map(|(key, read, _)| (key, number(three_digits(read)))).collect()
}

/// A number as a manifest has it.
pub(super) fn number(value: f64) -> String {
    serde_json::to_string(&value).unwrap_or_else(|_| value.to_string())
}

impl Finding {
    /// The reading that fits far better than the claimed one; `None` if none does.
    #[must_use]
    pub fn alternative(&self) -> Option<&Alternative> {
        match &self.verdict {
            ConventionVerdict::Other(other) => Some(other),
            ConventionVerdict::Stands { .. } | ConventionVerdict::Unknown { .. } => None,
        }
    }

    /// One sentence where another reading fits far better than the claimed one: which, how sure, and the keys to write.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let other = self.alternative()?;
        let mut said = match other.evidence {
            Evidence::Depth => format!(
                "the views agree far better ({:.2} of the points, against {:.2} as read) ",
                other.score,
                self.claimed_score.max(0.0)
            ),
            Evidence::Pictures { as_read } => format!(
                "the pictures agree far better (correlation {:.2}, against {:.2} as read) ",
                other.score,
                as_read.max(0.0)
            ),
        };
        said += &other.meaning(&self.claimed);
        let keys: Vec<String> = other.keys.iter().map(|(key, value)| format!("\"{key}\": {value}")).collect();
        if !keys.is_empty() {
            let _ = write!(said, "; write {} in the manifest", keys.join(", "));
        }
        for undecided in &other.undecided {
            let _ = write!(said, "; not sure: {}", undecided.why);
        }
        if other.undecided.is_empty() {
            let _ = write!(
                said,
                " ({}: {:.0} times as well as {})",
                other.certainty(),
                other.margin,
                other.next()
            );
        }
        Some(said)
    }

    /// One line whatever the outcome.
    #[must_use]
    pub fn sentence(&self) -> String {
        match &self.verdict {
            ConventionVerdict::Other(_) => self.warning().unwrap_or_default(),
            ConventionVerdict::Unknown { why } => format!("conventions cannot be checked: {why}"),
            ConventionVerdict::Stands { undecided } => {
                let mut said = format!(
                    "the views agree as the capture is read ({:.2} of the points)",
                    self.claimed_score
                );
                for undecided in undecided {
                    let _ = write!(said, "; {}", undecided.why);
                }
                said
            }
        }
    }
}

impl Alternative {
    /// Whether keys of a manifest can express all its differences from the claimed reading.
    #[must_use]
    pub fn can_be_written(&self, claimed: &Reading) -> bool {
        !self.keys.is_empty()
            && (self.reading.measure == claimed.measure || self.reading.measure.depth_kind().is_some())
    }

    /// How sure it is, in words.
    #[must_use]
    pub fn certainty(&self) -> &'static str {
        if self.margin >= SURE { "sure" } else { "likely" }
    }

    /// What [`Self::margin`] compares it with, in words.
    #[must_use]
    pub fn next(&self) -> &'static str {
        match self.evidence {
            Evidence::Depth => "the next",
            Evidence::Pictures { .. } => "the claimed one",
        }
    }

    /// What the numbers mean under this reading where that differs from the claimed one.
    #[must_use]
    pub fn meaning(&self, claimed: &Reading) -> String {
        let mut parts = Vec::new();
        if self.keys.iter().any(|(key, _)| key == "transform_direction" || key == "camera_axes") {
            let direction = self.reading.pose.direction.words();
            parts.push(format!("if poses are {direction} with axes {}", self.reading.pose.axes.words()));
        }
        if self.reading.measure != claimed.measure {
            let mut part = format!("if depth is {}", self.reading.measure.words());
            if let Some(planes) = self.reading.planes {
                // A plane at the camera is found to a rest.
                let least = 1e-4 * planes.near.max(planes.far.unwrap_or_default());
                let shown = |plane: f64| number(if plane.abs() < least { 0.0 } else { plane });
                let far = planes.far.map_or_else(|| "infinity".to_owned(), shown);
                let _ = write!(part, " (at {} and {far})", shown(planes.near));
            }
            if self.reading.measure.depth_kind().is_none() {
                part += ", which no key of the manifest says: convert it";
            }
            parts.push(part);
        }
        if self.keys.iter().any(|(key, _)| key == "depth_unit_scale_factor") {
            parts.push(format!(
                "if one unit of depth is {} world units instead of {}",
                number(self.reading.unit),
                number(claimed.unit)
            ));
        }
        parts.extend(self.reading.lens.words().into_iter().map(|words| format!("if {words}")));
        parts.join(" and ")
    }
}
