//! What a chart can show along an axis.

use crate::app::model::text;
use overlook_lab::chart::Scale;
use overlook_lab::sweep::Point;

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
    /// Every quantity: name, and the scale of its axis.
    pub(crate) const ALL: [(Self, &'static str, Scale); 8] = [
        (Self::Psnr, "PSNR, holes filled, dB", Scale::Linear),
        (Self::Ssim, "SSIM", Scale::Linear),
        (Self::Flip, "FLIP", Scale::Linear),
        (Self::Coverage, "Coverage", Scale::Linear),
        (Self::Bytes, "Store size", Scale::Log),
        (Self::Samples, "Samples", Scale::Log),
        (Self::Milliseconds, "Rendering a view, ms", Scale::Log),
        (Self::Seconds, "Preprocessing, s", Scale::Log),
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

    /// Its value, as its axis shows it: of logarithmic axes the decimal logarithm.
    pub(crate) fn of(self, point: &Point) -> f64 {
        let value = self.value(point);
        if self.scale() == Scale::Log { value.max(1e-3).log10() } else { value }
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

    /// The scale of its axis.
    pub(crate) fn scale(self) -> Scale {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or(Scale::Linear, |(.., scale)| *scale)
    }
}
