//! Design tokens: every color, distance and text size of the window, for the dark and the light theme.
//!
//! Panels ask for tokens and never name a color. Text on its surface keeps a contrast of at least 4.5 : 1 in both
//! themes; a test computes it.

use egui::{
    Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, Style, TextStyle, Theme, Vec2, Visuals,
};

use overlook_engine::preprocess::agreement::SampleAgreement;

pub(crate) const fn rgb(hex: u32) -> Color32 {
    Color32::from_rgb((hex >> 16) as u8, (hex >> 8) as u8, hex as u8)
}

/// The colors of one theme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tokens {
    /// Behind everything.
    pub background: Color32,
    /// Panels.
    pub surface: Color32,
    /// Cards, buttons and fields on panels.
    pub raised: Color32,
    /// Buttons under the pointer.
    pub raised_hovered: Color32,
    /// Behind pictures.
    pub canvas: Color32,
    /// Lines between areas.
    pub border: Color32,
    /// Text that is read.
    pub text: Color32,
    /// Text that explains.
    pub text_weak: Color32,
    /// What is selected, and the one action that matters.
    pub accent: Color32,
    /// Text on the accent.
    pub on_accent: Color32,
    /// Selected areas behind text.
    pub accent_faint: Color32,
    /// Something is out of date or needs a look.
    pub warning: Color32,
    /// Something failed.
    pub error: Color32,
    /// Behind an error message.
    pub error_faint: Color32,
    /// Pixels that no sample reached.
    pub hole: Color32,
    /// Stripes over such pixels, so that no surface is taken for a hole.
    pub hole_stripe: Color32,
    /// Samples that live over the whole sequence.
    pub static_over_time: Color32,
    /// Samples of several frames.
    pub lasting: Color32,
    /// Samples of one frame.
    pub moving: Color32,
    /// Samples that other cameras confirm.
    pub confirmed: Color32,
    /// Samples that more cameras look past than confirm.
    pub contradicted: Color32,
    /// Samples that nobody confirms or contradicts.
    pub alone: Color32,
    /// Pixels without depth.
    pub invalid: Color32,
    /// Behind text on a picture.
    pub scrim: Color32,
    /// Text on a picture, on the scrim.
    pub on_scrim: Color32,
    /// The mark of the selected pixel, on pictures of any color.
    pub mark: Color32,
}

const DARK: Tokens = tokens(true);
const LIGHT: Tokens = tokens(false);

/// The colors of a theme: of each the one of the dark theme, and the one of the light theme.
const fn tokens(dark: bool) -> Tokens {
    Tokens {
        background: rgb(if dark { 0x0f_1216 } else { 0xdb_e0e6 }),
        surface: rgb(if dark { 0x17_1b21 } else { 0xf7_f8fa }),
        raised: rgb(if dark { 0x23_2931 } else { 0xe7_eaef }),
        raised_hovered: rgb(if dark { 0x2e_3640 } else { 0xd9_dee5 }),
        canvas: rgb(if dark { 0x0b_0d10 } else { 0xd5_d9df }),
        border: rgb(if dark { 0x2c_333d } else { 0xcb_d1d9 }),
        text: rgb(if dark { 0xe4_e8ee } else { 0x1b_2129 }),
        text_weak: rgb(if dark { 0x9b_a7b6 } else { 0x51_5c69 }),
        accent: rgb(if dark { 0x4f_b3ff } else { 0x0b_64b0 }),
        on_accent: rgb(if dark { 0x06_1726 } else { 0xff_ffff }),
        accent_faint: rgb(if dark { 0x24_5079 } else { 0xb5_d6f5 }),
        warning: rgb(if dark { 0xf2_b84b } else { 0x8a_5300 }),
        error: rgb(if dark { 0xff_8a7a } else { 0xb0_2318 }),
        error_faint: rgb(if dark { 0x3a_1d1b } else { 0xfb_e3e0 }),
        hole: rgb(if dark { 0x33_2040 } else { 0x8d_7a9a }),
        hole_stripe: rgb(if dark { 0x3f_2a4e } else { 0x81_6d8f }),
        static_over_time: rgb(if dark { 0x3a_7fc4 } else { 0x2f_72b5 }),
        lasting: rgb(if dark { 0x35_b592 } else { 0x12_9273 }),
        moving: rgb(if dark { 0xf0_a030 } else { 0xd9_8200 }),
        confirmed: rgb(if dark { 0x3a_7fc4 } else { 0x2f_72b5 }),
        contradicted: rgb(if dark { 0xe2_4a2c } else { 0xc4_3412 }),
        alone: rgb(if dark { 0xe9_d648 } else { 0xcf_b400 }),
        invalid: rgb(if dark { 0x55_5a61 } else { 0x8b_9199 }),
        scrim: Color32::from_rgba_premultiplied(6, 8, 10, if dark { 190 } else { 180 }),
        on_scrim: rgb(if dark { 0xf2_f5f8 } else { 0xf7_f9fb }),
        mark: rgb(0xff_5fd2),
    }
}

impl Tokens {
    pub(crate) fn of(dark: bool) -> &'static Self {
        if dark { &DARK } else { &LIGHT }
    }

    /// The tokens of the theme that `ui` is drawn in.
    pub(crate) fn in_ui(ui: &egui::Ui) -> &'static Self {
        Self::of(ui.visuals().dark_mode)
    }

    /// The color of an axis of the world, in either direction.
    pub(crate) fn axis_of(axis: glam::DVec3) -> Color32 {
        match axis.abs() {
            axis if axis.x > 0.5 => rgb(0xe8_6a5c),
            axis if axis.y > 0.5 => rgb(0x7c_c24a),
            _ => rgb(0x5a_9cf0),
        }
    }

    /// The color of samples by their agreement with other cameras.
    pub(crate) fn of_agreement(&self, agreement: SampleAgreement) -> Color32 {
        match agreement {
            SampleAgreement::Confirmed => self.confirmed,
            SampleAgreement::Contradicted => self.contradicted,
            SampleAgreement::Alone => self.alone,
        }
    }

    /// The color of samples that are stored for `length` of all `frames`.
    pub(crate) fn of_span(&self, length: usize, frames: usize) -> Color32 {
        match length {
            _ if length >= frames => self.static_over_time,
            0 | 1 => self.moving,
            _ => self.lasting,
        }
    }
}

/// Distances, in points.
pub(crate) mod space {
    /// Between things that belong together.
    pub(crate) const SMALL: f32 = 4.0;
    /// Between things.
    pub(crate) const MEDIUM: f32 = 8.0;
    /// Between groups.
    pub(crate) const LARGE: f32 = 16.0;
    /// Inside panels, from the edge.
    pub(crate) const PANEL: i8 = 10;
    pub(crate) const TOP_BAR: f32 = 44.0;
    pub(crate) const TOTALS: f32 = 52.0;
    pub(crate) const TABS: f32 = 30.0;
    pub(crate) const TIMELINE: f32 = 72.0;
    /// Height of the status line.
    pub(crate) const STATUS: f32 = 28.0;
    /// Corner radius of cards and buttons.
    pub(crate) const RADIUS: u8 = 6;
    /// Height of buttons and fields.
    pub(crate) const CONTROL: f32 = 26.0;
}

/// The text style of large numbers.
pub(crate) fn figure_style() -> TextStyle {
    TextStyle::Name("figure".into())
}

/// Seconds for which the pointer rests before a tooltip appears.
const TOOLTIP_SECS: f32 = 0.35;

/// Seconds after a tooltip within which the next one appears at once.
const GRACE_SECS: f32 = 0.2;

/// Longer than anybody rests.
const NEVER_SECS: f32 = 1e6;

/// Hides tooltips while a question is open: egui would keep an open one above the question, and show another at once.
pub(crate) fn show_tooltips(ctx: &egui::Context, show: bool) {
    let (secs, grace_secs) = if show { (TOOLTIP_SECS, GRACE_SECS) } else { (NEVER_SECS, 0.0) };
    if ctx.global_style().interaction.tooltip_delay != secs {
        ctx.all_styles_mut(|style| {
            style.interaction.tooltip_delay = secs;
            style.interaction.tooltip_grace_time = grace_secs;
        });
    }
    let is_tooltip = |layer: &egui::LayerId| layer.order == egui::Order::Tooltip;
    if !show && ctx.memory(|memory| memory.areas().visible_layer_ids().iter().any(is_tooltip)) {
        // An open tooltip stays as long as the pointer does, at any delay; a forgotten one does not.
        ctx.memory_mut(egui::Memory::reset_areas);
    }
}

/// Sets fonts, text sizes, distances and both themes' colors.
pub(crate) fn install(ctx: &egui::Context) {
    egui_material_icons::initialize(ctx);
    for theme in [Theme::Dark, Theme::Light] {
        ctx.style_mut_of(theme, |style| apply(style, Tokens::of(theme == Theme::Dark), theme));
    }
}

fn apply(style: &mut Style, tokens: &Tokens, theme: Theme) {
    let proportional = |size| FontId::new(size, FontFamily::Proportional);
    style.text_styles = [
        (TextStyle::Small, proportional(11.5)),
        (TextStyle::Body, proportional(13.5)),
        (TextStyle::Button, proportional(13.5)),
        (TextStyle::Heading, proportional(15.5)),
        (figure_style(), proportional(17.0)),
        (TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace)),
    ]
    .into();
    style.spacing.item_spacing = Vec2::new(space::MEDIUM, 6.0);
    style.spacing.button_padding = Vec2::new(9.0, 4.0);
    style.spacing.interact_size = Vec2::new(32.0, space::CONTROL);
    style.spacing.combo_width = 60.0;
    style.spacing.tooltip_width = 340.0;
    style.spacing.menu_margin = Margin::same(6);
    style.interaction.selectable_labels = false;
    style.interaction.tooltip_delay = TOOLTIP_SECS;
    style.visuals = visuals(tokens, theme);
}

fn visuals(tokens: &Tokens, theme: Theme) -> Visuals {
    let mut visuals = theme.default_visuals();
    visuals.panel_fill = tokens.surface;
    visuals.window_fill = tokens.surface;
    visuals.extreme_bg_color = tokens.background;
    visuals.faint_bg_color = tokens.raised;
    visuals.window_stroke = Stroke::new(1.0, tokens.border);
    visuals.window_corner_radius = CornerRadius::same(10);
    visuals.menu_corner_radius = CornerRadius::same(8);
    visuals.hyperlink_color = tokens.accent;
    visuals.warn_fg_color = tokens.warning;
    visuals.error_fg_color = tokens.error;
    visuals.weak_text_color = Some(tokens.text_weak);
    visuals.selection.bg_fill = tokens.accent_faint;
    visuals.selection.stroke = Stroke::new(1.0, tokens.text);
    visuals.slider_trailing_fill = true;
    visuals.striped = false;
    let radius = CornerRadius::same(space::RADIUS);
    let states = [
        (&mut visuals.widgets.noninteractive, tokens.surface, tokens.border, tokens.text),
        (&mut visuals.widgets.inactive, tokens.raised, tokens.raised, tokens.text),
        (&mut visuals.widgets.hovered, tokens.raised_hovered, tokens.border, tokens.text),
        (&mut visuals.widgets.active, tokens.accent_faint, tokens.accent, tokens.text),
        (&mut visuals.widgets.open, tokens.raised_hovered, tokens.border, tokens.text),
    ];
    for (state, fill, border, text) in states {
        state.bg_fill = fill;
        state.weak_bg_fill = fill;
        state.bg_stroke = Stroke::new(1.0, border);
        state.fg_stroke = Stroke::new(1.0, text);
        state.corner_radius = radius;
        state.expansion = 0.0;
    }
    // The empty part of a slider's rail and an unticked box must be visible on their panel.
    visuals.widgets.inactive.bg_fill = tokens.raised_hovered;
    visuals
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance(color: Color32) -> f32 {
        let [r, g, b] = [color.r(), color.g(), color.b()]
            .map(|c| overlook_engine::color::linear_from_srgb(f32::from(c) / 255.0));
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    fn contrast(a: Color32, b: Color32) -> f32 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn text_can_be_read_on_every_surface_of_both_themes() {
        for tokens in [&DARK, &LIGHT] {
            for surface in [tokens.background, tokens.surface, tokens.raised] {
                for text in [tokens.text, tokens.text_weak] {
                    assert!(contrast(text, surface) >= 4.5, "{text:?} on {surface:?}");
                }
            }
            for text in [tokens.accent, tokens.warning, tokens.error] {
                assert!(contrast(text, tokens.surface) >= 4.5, "{text:?}");
            }
            assert!(contrast(tokens.on_accent, tokens.accent) >= 4.5);
            assert!(contrast(tokens.text, tokens.error_faint) >= 4.5);
            assert!(contrast(tokens.text, tokens.accent_faint) >= 4.5);
        }
    }
}
