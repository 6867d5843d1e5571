//! The comparison of two pictures of one viewpoint.

mod control;
pub(crate) mod state;
pub(crate) mod ui;
pub(crate) mod work;

use std::sync::Arc;

use crate::app::model::command::{CompareCommand, WindowCommand};
use crate::app::model::same::Same;
use crate::app::model::state::State;
use crate::app::model::undo::SettingsSlot;
use crate::app::model::window::DockView;
use crate::app::model::{Command, Commands};
use crate::app::rooms::compare::state::{
    CompareKey, CompareLook, CompareMeasure, CompareSide, ComparisonFigure, PictureDifference, PictureFolder,
};
use crate::text::significant;

impl State {
    /// What a figure of the comparison shows; `None` where there is none, or where its sides cannot be compared.
    pub(crate) fn compared_figure(&self) -> Option<ComparisonFigure> {
        let compared = self.doc.compared.as_ref().filter(|_| self.doc.compare_error.is_none())?;
        Some(ComparisonFigure::of(compared, &self.inspector.compare, self.dark))
    }

    /// At the viewpoint, and with the samples, of the last live picture; `None` without one.
    pub(crate) fn compare_key(&self) -> Option<CompareKey> {
        let (scene, shown) = (self.doc.scene.as_ref()?, self.doc.live_shown.as_ref()?);
        let (history, now) = (&self.inspector.history, &self.settings);
        Some(CompareKey {
            scene: scene.clone(),
            choice: self.inspector.compare.choice,
            vantage: shown.key.vantage.clone(),
            // A store that plays from disk has its samples with the picture.
            samples: Same(shown.picture.samples.clone()),
            whole: self.current_whole().is_some_and(|whole| Arc::ptr_eq(whole, &shown.picture.samples)),
            scan: self.doc.scan.clone().map(Same),
            settings: [
                now.clone(),
                history.of(SettingsSlot::A, now).clone(),
                history.of(SettingsSlot::B, now).clone(),
                self.doc.change.before.as_ref().map_or(now, |before| &before.settings).clone(),
            ],
            pictures: self.doc.pictures.clone(),
            dark: self.dark,
        })
    }

    /// Every side, with its name and what it is: those that are always there, and the pictures of other programs.
    fn compare_sides(&self) -> Vec<(CompareSide, String, String)> {
        let always = CompareSide::ALL.map(|(side, name, help)| (side, name.to_owned(), help.to_owned()));
        let opened = self.doc.pictures.iter();
        let opened = opened.map(|folder| (CompareSide::Pictures(folder.id), folder.name(), folder.words()));
        always.into_iter().chain(opened).collect()
    }

    pub(crate) fn side_name(&self, side: CompareSide) -> String {
        let known = self.compare_sides().into_iter().find(|(of, ..)| *of == side);
        known.map(|(_, name, _)| name).unwrap_or_default()
    }

    /// Closes pictures of other programs; sides that showed them show what they did at first.
    pub(crate) fn close_pictures(&mut self, closes: impl Fn(&PictureFolder) -> bool) {
        self.doc.pictures.retain(|folder| !closes(folder));
        let first = CompareLook::default().choice.sides;
        for (side, first) in self.inspector.compare.choice.sides.iter_mut().zip(first) {
            if let CompareSide::Pictures(id) = *side
                && self.doc.pictures.iter().all(|folder| folder.id != id)
            {
                *side = first;
            }
        }
    }
}

/// Asks for what is kept now beside something else, in the view for that.
pub(crate) fn compare_with(side: CompareSide, state: &State, commands: &mut Commands) {
    let mut look = state.inspector.compare.clone();
    look.choice.sides = [side, CompareSide::Kept];
    commands.push(Command::Compare(CompareCommand::Look(Box::new(look))));
    commands.push(Command::Window(WindowCommand::OpenView(DockView::Compare)));
}

/// The pixel under the pointer on both sides; `None` outside.
pub(crate) fn about_pixel(comparison: &PictureDifference, [x, y]: [usize; 2]) -> Option<String> {
    let color = |side: usize| {
        let pixel = comparison.sides[side].get(x, y)?;
        Some(pixel.map_or_else(|| "no sample".to_owned(), |[r, g, b]| format!("{r} {g} {b}")))
    };
    let apart = match (comparison.apart.get(x, y)?, comparison.measure) {
        (None, _) => "nothing to compare".to_owned(),
        (Some(apart), CompareMeasure::Flip) => format!("FLIP {apart:.3}"),
        (Some(apart), CompareMeasure::Brightness) => format!("{apart:+.1}/255"),
        (Some(apart), CompareMeasure::Flicker) => format!("change {apart:.0}/255"),
        (Some(apart), _) => format!("error {apart:.0}/255"),
    };
    Some(format!("Pixel {x}, {y} · left {} · right {} · {apart}", color(0)?, color(1)?))
}

/// The whole comparison in figures.
pub(crate) fn figures(comparison: &PictureDifference) -> String {
    let mean = significant(comparison.mean);
    let apart = match comparison.measure {
        CompareMeasure::Flip => format!("mean FLIP {mean}"),
        CompareMeasure::Flicker => {
            let steps = comparison.flicker_steps.map_or_else(|| "unknown".to_owned(), significant);
            format!("flicker {steps} 8-bit steps (root mean square)")
        }
        _ => format!("mean error {mean}/255"),
    };
    let alike = if comparison.psnr_db.is_infinite() {
        "identical where both have samples".to_owned()
    } else {
        format!("PSNR {:.1} dB, SSIM {:.3}, {apart}", comparison.psnr_db, comparison.ssim)
    };
    let whereabouts = comparison.by_class.map_or_else(String::new, |shares| {
        let [unseen, edge, inner] = shares.map(|share| 100.0 * share);
        format!("; of the squared error unseen {unseen:.0} %, edge {edge:.0} %, inner {inner:.0} %")
    });
    format!("{alike}{whereabouts}; {:.1} % of pixels covered on one side only", 100.0 * comparison.one_sided)
}
