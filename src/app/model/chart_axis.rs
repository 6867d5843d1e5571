//! What a chart of a sweep can show along an axis.

use super::text;
use crate::evaluate::sweep::Point;

/// A quantity along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Psnr,
    Ssim,
    Flip,
    Coverage,
    Bytes,
    Samples,
    Milliseconds,
    Seconds,
}

impl Quantity {
    /// Every quantity: name, and whether its axis is logarithmic.
    pub(crate) const ALL: [(Self, &'static str, bool); 8] = [
        (Self::Psnr, "PSNR, holes filled, dB", false),
        (Self::Ssim, "SSIM", false),
        (Self::Flip, "FLIP", false),
        (Self::Coverage, "Coverage", false),
        (Self::Bytes, "Store size", true),
        (Self::Samples, "Samples", true),
        (Self::Milliseconds, "Painting a view, ms", true),
        (Self::Seconds, "Preprocessing, s", true),
    ];

    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or("", |(_, name, _)| name)
    }

    /// Its name with the direction in which it is better, for an axis.
    pub(crate) fn axis_name(self) -> String {
        let better = if self.is_gain() { "higher" } else { "lower" };
        format!("{} ({better} is better)", self.name())
    }

    pub(crate) fn is_gain(self) -> bool {
        matches!(self, Self::Psnr | Self::Ssim | Self::Coverage)
    }

    /// What is lost by it: better where smaller.
    pub(crate) fn cost(self, point: &Point) -> f64 {
        match self {
            // As the front of the command line has it.
            Self::Bytes => point.bytes_of_samples() as f64,
            _ if self.is_gain() => -self.value(point),
            _ => self.value(point),
        }
    }

    /// Its value in words.
    pub(crate) fn words(self, point: &Point) -> String {
        match self {
            Self::Psnr => format!("{:.2}", point.psnr_filled_db),
            Self::Ssim | Self::Flip => format!("{:.3}", self.value(point)),
            Self::Coverage => format!("{:.1} %", 100.0 * point.coverage),
            Self::Bytes => text::bytes(point.bytes),
            Self::Samples => text::count(point.samples),
            Self::Milliseconds | Self::Seconds => text::significant(self.value(point)),
        }
    }

    /// Its value, as its axis shows it.
    pub(crate) fn of(self, point: &Point) -> f64 {
        let value = self.value(point);
        if self.is_log() { value.max(1e-3).log10() } else { value }
    }

    fn value(self, point: &Point) -> f64 {
        match self {
            Self::Psnr => point.psnr_filled_db,
            Self::Ssim => point.ssim,
            Self::Flip => point.flip,
            Self::Coverage => point.coverage,
            Self::Bytes => point.bytes as f64,
            Self::Samples => point.samples as f64,
            Self::Milliseconds => point.milliseconds,
            Self::Seconds => point.seconds_preprocess,
        }
    }

    /// Whether its axis is logarithmic.
    pub(crate) fn is_log(self) -> bool {
        Self::ALL.iter().any(|(of, _, log)| *of == self && *log)
    }
}
