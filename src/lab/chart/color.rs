//! Colors of charts: ink, grid lines, and series that color-blind people can distinguish (Masataka Okabe and Kei Ito, *Color
//! Universal Design*, 2008).

pub(super) const INK: &str = "#22262b";
pub(super) const FAINT: &str = "#6b7480";
pub(super) const GRID: &str = "#e4e7eb";
pub(super) const PAPER: &str = "#ffffff";
pub(super) const DARK_PAPER: &str = "#171b21";
pub(super) const DARK_INK: &str = "#e4e8ee";
pub(super) const DARK_FAINT: &str = "#9ba7b6";
/// Under text on a picture, and that text.
pub(super) const PLATE: &str = "#0b0d10";
pub(super) const ON_PLATE: &str = "#ffffff";
pub(super) const BLUE: &str = "#0072b2";
pub(super) const ORANGE: &str = "#e69f00";
pub(super) const GREEN: &str = "#009e73";
pub(super) const PINK: &str = "#cc79a7";
pub(super) const RED: &str = "#d55e00";

/// An 8-bit sRGB color as SVG writes it.
pub(super) fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
