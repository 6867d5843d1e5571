//! What takes the memory: bytes of the kept samples by camera and by length of span, laid out as a treemap.
//!
//! Source of the layout: Bruls, Huizing, van Wijk, *Squarified Treemaps*, `VisSym` 2000.

use std::collections::BTreeMap;

use egui::{Rect, pos2, vec2};

use crate::preprocess::SampleSet;

/// A part of the memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    /// Index of the camera.
    pub camera: usize,
    /// Frames of the spans in it.
    pub frames: usize,
    /// Samples in it.
    pub samples: u64,
    /// Bytes it takes.
    pub bytes: u64,
}

/// The kept samples by camera and length of span, largest first.
pub(crate) fn blocks(samples: &SampleSet) -> Vec<Block> {
    let mut totals = BTreeMap::<(usize, usize), (u64, u64)>::new();
    for image in &samples.images {
        let total = totals.entry((image.camera as usize, image.span.len())).or_default();
        total.0 += image.len() as u64;
        total.1 += image.bytes() as u64;
    }
    let mut blocks: Vec<Block> = totals
        .into_iter()
        .map(|((camera, frames), (samples, bytes))| Block { camera, frames, samples, bytes })
        .collect();
    blocks.sort_by_key(|block| std::cmp::Reverse(block.bytes));
    blocks
}

/// A rectangle for each weight (descending, above 0) that fill `area` in proportion, as square as can be.
pub(crate) fn squarified(weights: &[f32], area: Rect) -> Vec<Rect> {
    let total: f32 = weights.iter().sum();
    let mut places = Vec::with_capacity(weights.len());
    if total <= 0.0 || !area.is_positive() {
        return places;
    }
    let scale = area.width() * area.height() / total;
    let (mut rest, mut first) = (area, 0);
    while first < weights.len() {
        let side = rest.width().min(rest.height()).max(1e-3);
        let mut end = first + 1;
        let mut sum = weights[first] * scale;
        while end < weights.len() {
            let wider = sum + weights[end] * scale;
            if worst(&weights[first..=end], wider, side, scale)
                > worst(&weights[first..end], sum, side, scale)
            {
                break;
            }
            (sum, end) = (wider, end + 1);
        }
        rest = lay_row(&weights[first..end], sum, rest, scale, &mut places);
        first = end;
    }
    places
}

/// The largest ratio of sides in a row of this area along `side`.
fn worst(weights: &[f32], sum: f32, side: f32, scale: f32) -> f32 {
    let depth = sum / side;
    weights
        .iter()
        .map(|weight| weight * scale / depth)
        .fold(1.0, |worst, length: f32| worst.max((length / depth).max(depth / length.max(1e-6))))
}

/// Lays a row along the shorter side of `rest`; what is left of it.
fn lay_row(weights: &[f32], sum: f32, rest: Rect, scale: f32, places: &mut Vec<Rect>) -> Rect {
    let upright = rest.width() >= rest.height();
    let depth = sum / rest.width().min(rest.height()).max(1e-3);
    let mut at = rest.min;
    for weight in weights {
        let length = weight * scale / depth.max(1e-6);
        let size = if upright { vec2(depth, length) } else { vec2(length, depth) };
        places.push(Rect::from_min_size(at, size));
        at += if upright { vec2(0.0, length) } else { vec2(length, 0.0) };
    }
    let corner =
        if upright { pos2(rest.left() + depth, rest.top()) } else { pos2(rest.left(), rest.top() + depth) };
    Rect::from_min_max(corner, rest.max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_treemap_fills_its_area_in_proportion() {
        let area = Rect::from_min_size(pos2(10.0, 20.0), vec2(300.0, 120.0));
        let weights = [50.0, 20.0, 10.0, 8.0, 7.0, 4.0, 1.0];
        let places = squarified(&weights, area);
        assert_eq!(places.len(), weights.len());
        for (place, weight) in places.iter().zip(weights) {
            assert!(area.expand(0.01).contains_rect(*place), "{place:?}");
            assert!((place.area() / area.area() - weight / 100.0).abs() < 1e-3);
        }
        assert!(squarified(&[], area).is_empty());
    }
}
