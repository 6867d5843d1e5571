//! A comparison in words: one pixel of it, and all of it in figures.

use super::comparison::{CompareMeasure, PictureDifference};
use crate::app::model::text::significant;

/// The pixel under the pointer on both sides; `None` outside.
pub(crate) fn about_pixel(comparison: &PictureDifference, [x, y]: [usize; 2]) -> Option<String> {
    let color = |side: usize| {
        let pixel = comparison.sides[side].get(x, y)?;
        Some(pixel.map_or_else(|| "no sample".to_owned(), |[r, g, b]| format!("{r} {g} {b}")))
    };
    let apart = match comparison.apart.get(x, y)? {
        Some(apart) if comparison.measure == CompareMeasure::Flip => format!("FLIP {apart:.3}"),
        Some(apart) if comparison.measure == CompareMeasure::Brightness => format!("{apart:+.1}/255"),
        Some(apart) if comparison.measure == CompareMeasure::Flicker => format!("change {apart:.0}/255"),
        Some(apart) => format!("error {apart:.0}/255"),
        None => "nothing to compare".to_owned(),
    };
    Some(format!("Pixel {x}, {y} · left {} · right {} · {apart}", color(0)?, color(1)?))
}

/// The whole comparison in figures.
pub(crate) fn figures(comparison: &PictureDifference) -> String {
    let psnr = if comparison.psnr_db.is_infinite() {
        "identical where both have samples".to_owned()
    } else {
        format!(
            "PSNR {:.1} dB, SSIM {:.3}, {}",
            comparison.psnr_db,
            comparison.ssim,
            match comparison.measure {
                CompareMeasure::Flip => format!("mean FLIP {}", significant(comparison.mean)),
                CompareMeasure::Flicker => {
                    let steps = comparison.flicker_steps.map_or_else(|| "unknown".to_owned(), significant);
                    format!("flicker {steps} 8-bit steps (root mean square)")
                }
                _ => format!("mean error {}/255", significant(comparison.mean)),
            }
        )
    };
    let whereabouts = comparison.by_class.map_or_else(String::new, |shares| {
        let [unseen, edge, inner] = shares.map(|share| 100.0 * share);
        format!("; of the squared error unseen {unseen:.0} %, edge {edge:.0} %, inner {inner:.0} %")
    });
    format!("{psnr}{whereabouts}; {:.1} % of pixels covered on one side only", 100.0 * comparison.one_sided)
}
