//! Splats as USD in its text form: a `ParticleField3DGaussianSplat` for each span of frames, shown by time samples of its visibility.
//!
//! Source: `OpenUSD` 26.03, the schemas of `UsdVol` for particle fields. Time codes count the frames from 0.

use std::fmt::Display;
use std::io::{self, Write};

use super::field::{Field, SpanSplats};
use super::gaussian::{Gaussian, coefficients};
use super::timing::Timing;
use crate::error::{Error, Result};
use crate::job::Job;

/// A Gaussian is drawn up to this many standard deviations.
const REACH: f32 = 3.0;

/// Writes the splats of a field. `name` is that of the capture.
///
/// # Errors
/// `Io` naming `place`, `Cancelled`.
pub(super) fn write(
    target: &mut impl Write,
    field: &Field<'_>,
    name: &str,
    timing: Timing,
    place: &std::path::Path,
    job: &Job,
) -> Result<()> {
    let io = |error| Error::io(place, error);
    header(target, field, name, timing).map_err(io)?;
    for span in &field.spans {
        let splats = field.splats(span, job)?;
        prim(target, span, &splats, timing).map_err(io)?;
    }
    writeln!(target, "}}").map_err(io)
}

fn header(target: &mut impl Write, field: &Field<'_>, name: &str, timing: Timing) -> io::Result<()> {
    let name: String = name
        .chars()
        .map(|letter| if letter.is_control() || "\"\\".contains(letter) { ' ' } else { letter })
        .collect();
    let (last, rate) = (timing.frames.saturating_sub(1), timing.frames_per_second);
    write!(
        target,
        "#usda 1.0\n(\n    defaultPrim = \"Scene\"\n    doc = \"{name}, by overlook\"\n    endTimeCode = {last}\n    \
         framesPerSecond = {rate}\n    metersPerUnit = 1\n    startTimeCode = 0\n    timeCodesPerSecond = {rate}\n    \
         upAxis = \"Y\"\n)\n\ndef Xform \"Scene\"\n{{\n"
    )?;
    if let Some(offset) = field.space.offset() {
        let [x, y, z] = offset.to_array();
        write!(
            target,
            "    double3 xformOp:translate = ({x}, {y}, {z})\n    uniform token[] xformOpOrder = [\"xformOp:translate\"]\n"
        )?;
    }
    Ok(())
}

fn prim(target: &mut impl Write, span: &SpanSplats, splats: &[Gaussian], timing: Timing) -> io::Result<()> {
    let (start, end) = (span.span.start, span.span.end);
    write!(target, "\n    def ParticleField3DGaussianSplat \"frames_{start}_to_{}\"\n    {{\n", end - 1)?;
    if !timing.is_always(span.span) {
        let changes: Vec<String> = timing
            .changes(span.span)
            .into_iter()
            .map(|(frame, is_visible)| {
                format!("{frame}: \"{}\"", if is_visible { "inherited" } else { "invisible" })
            })
            .collect();
        writeln!(target, "        token visibility.timeSamples = {{ {} }}", changes.join(", "))?;
    }
    let reached = splats.iter().map(|splat| {
        let around = REACH * splat.radii.x;
        [splat.center - around, splat.center + around]
    });
    if let Some([low, high]) = reached.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]) {
        let ends = [low, high].map(|end| tuple(&end.to_array()));
        writeln!(target, "        float3[] extent = [{}, {}]", ends[0], ends[1])?;
    }
    array(target, "point3f[] positions", splats, |splat| tuple(&splat.center.to_array()))?;
    array(target, "quatf[] orientations", splats, |splat| {
        let rotation = splat.rotation;
        tuple(&[rotation.w, rotation.x, rotation.y, rotation.z])
    })?;
    array(target, "float3[] scales", splats, |splat| tuple(&splat.radii.to_array()))?;
    array(target, "float[] opacities", splats, |splat| splat.opacity)?;
    writeln!(target, "        uniform int radiance:sphericalHarmonicsDegree = 0")?;
    array(target, "float3[] radiance:sphericalHarmonicsCoefficients", splats, |splat| {
        tuple(&coefficients(splat.color))
    })?;
    writeln!(target, "    }}")
}

fn tuple(parts: &[f32]) -> String {
    let parts: Vec<String> = parts.iter().map(ToString::to_string).collect();
    format!("({})", parts.join(", "))
}

/// An attribute with a value for each splat.
fn array<T: Display>(
    target: &mut impl Write,
    name: &str,
    splats: &[Gaussian],
    value: impl Fn(&Gaussian) -> T,
) -> io::Result<()> {
    write!(target, "        {name} = [")?;
    for (nth, splat) in splats.iter().enumerate() {
        let comma = if nth == 0 { "" } else { ", " };
        write!(target, "{comma}{}", value(splat))?;
    }
    writeln!(target, "]")
}
