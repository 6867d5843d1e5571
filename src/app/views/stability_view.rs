//! Accuracy against the size of a disturbance.

use std::collections::BTreeMap;

use egui::{RichText, Ui};
use egui_material_icons::icons::ICON_MONITORING;
use egui_plot::{Line, PlotPoints, Points};

use super::chart_parts::{Mark, legend_ui, nearest, no_points_ui, plot, shape, study_button};
use crate::app::colormap;
use crate::app::model::{self, Command, Commands, Quantity, State, Study, method_name};
use crate::app::theme::Tokens;
use crate::app::widgets::choice_ui;
use crate::evaluate::stress::StressPoint;

pub(crate) fn stability_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let charts = &state.inspector.charts;
    let mut names: Vec<&str> = Vec::new();
    for point in &charts.stress {
        if !names.contains(&point.disturbance.as_str()) {
            names.push(&point.disturbance);
        }
    }
    let Some(first) = names.first() else {
        let text = "A stress test disturbs the capture more and more (noise, miscalibrated cameras, thin things) and draws \
                    when accuracy breaks: with these settings, without defenses, and as in the paper.";
        no_points_ui(ui, state, Study::Stress, (ICON_MONITORING, text), commands);
        return;
    };
    let chosen =
        if names.contains(&charts.disturbance.as_str()) { charts.disturbance.as_str() } else { first };
    ui.horizontal_wrapped(|ui| {
        let choices: Vec<_> = names
            .iter()
            .enumerate()
            .map(|(index, name)| (index, model::words(name), String::new()))
            .collect();
        let now = names.iter().position(|name| *name == chosen).unwrap_or(0);
        if let Some(index) = choice_ui(ui, "Disturbance", now, &choices, 150.0) {
            commands.push(Command::Disturbance(names[index].to_owned()));
        }
        study_button(ui, state, Study::Stress, commands);
    });
    if let Some(words) = charts.stale_stress_note(&state.settings) {
        ui.label(RichText::new(words).color(Tokens::in_ui(ui).warning));
    }
    let here: Vec<&StressPoint> = charts.stress.iter().filter(|point| point.disturbance == chosen).collect();
    plot_ui(ui, chosen, &here);
}

fn plot_ui(ui: &mut Ui, disturbance: &str, here: &[&StressPoint]) {
    let mut methods = BTreeMap::<&str, Vec<[f64; 2]>>::new();
    for point in here {
        methods.entry(&point.method).or_default().push([point.dial, point.point.psnr_filled_db]);
    }
    let methods = methods.into_iter().enumerate();
    let curves: Vec<_> = methods
        .map(|(index, (method, places))| (shape(index), colormap::camera(index), method_name(method), places))
        .collect();
    legend_ui(ui, curves.iter().map(|(shape, color, name, _)| (Mark::Points(*shape), *color, *name)));
    let unit = here.first().map_or("", |point| point.unit.as_str());
    let names = [format!("{} ({unit})", model::words(disturbance)), Quantity::Psnr.axis_name()];
    let plot = plot("stability", ui, names, [false; 2]);
    let shown = plot.show(ui, |plot_ui| {
        for (shape, color, name, places) in curves {
            plot_ui.line(Line::new(name, PlotPoints::from(places.clone())).color(color).width(2.0));
            plot_ui.points(Points::new(name, places).color(color).radius(3.5).shape(shape));
        }
        nearest(plot_ui, here.iter().map(|point| [point.dial, point.point.psnr_filled_db]))
    });
    shown.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Stability chart"));
    if let Some(point) = shown.inner.and_then(|index| here.get(index)) {
        let words = format!(
            "{} at {} {}: {:.2} dB, {:+.2} dB lost",
            model::sentence(method_name(&point.method)),
            model::significant(point.dial),
            point.unit,
            point.point.psnr_filled_db,
            point.loss_db
        );
        shown.response.on_hover_text_at_pointer(words);
    }
}
