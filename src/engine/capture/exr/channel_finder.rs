//! Looks for the channels of [`channels`](super::channels) among names.

use crate::error::{Error, Result};

pub(super) const RGB: [&str; 3] = ["R", "G", "B"];
const XYZ: [&str; 3] = ["X", "Y", "Z"];
pub(super) const NORMAL_LAYERS: &[&str] =
    &["normal", "normals", "n", "nn", "sh_normal", "geo_normal", "shading_normal"];
pub(super) const POSITION_LAYERS: &[&str] = &["position", "positions", "pos", "p", "pp"];
const DEPTH_LAYERS: &[&str] = &["depth", "z"];
const DEPTH_SUFFIXES: &[&str] = &["Z", "V", "T", "Y", "R"];
const COLOR_LAYERS: &[&str] = &["", "combined", "rgba", "rgb", "beauty", "color", "finalimage", "image"];

/// A channel's full name, taken apart.
#[derive(Clone, Copy)]
pub(super) struct LayeredName<'a> {
    layer: &'a str,
    pub(super) suffix: &'a str,
}

impl<'a> LayeredName<'a> {
    fn of(full: &'a str) -> Self {
        let (layer, suffix) = full.rsplit_once('.').unwrap_or(("", full));
        Self { layer, suffix }
    }
}

/// The last component of a layer and the text before it: `ViewLayer.Depth` is `("ViewLayer", "Depth")`.
fn split_pass(layer: &str) -> (&str, &str) {
    layer.rsplit_once('.').unwrap_or(("", layer))
}

fn is_one_of(pass: &str, known: &[&str]) -> bool {
    known.iter().any(|name| pass.eq_ignore_ascii_case(name))
}

/// Where Blender puts what was composited of its view layers.
const COMPOSITED: &str = "composite";

/// The worst score of depth that belongs to its root.
const OWN_DEPTH: u8 = 1;

/// Whether a layer holds a normal, position or depth pass by its name.
fn is_geometry(layer: &str) -> bool {
    let pass = split_pass(layer).1;
    [NORMAL_LAYERS, POSITION_LAYERS, DEPTH_LAYERS].into_iter().any(|known| is_one_of(pass, known))
}

/// Full names of channels, taken apart.
pub(super) struct ChannelFinder<'a> {
    full: Vec<&'a str>,
    pub(super) names: Vec<LayeredName<'a>>,
    place: &'a str,
}

impl<'a> ChannelFinder<'a> {
    pub(super) fn new(full: impl IntoIterator<Item = &'a str>, place: &'a str) -> Self {
        let full: Vec<&str> = full.into_iter().collect();
        let names = full.iter().map(|full| LayeredName::of(full)).collect();
        Self { full, names, place }
    }

    pub(super) fn channel(&self, layer: &str, suffix: &str) -> Option<usize> {
        self.names.iter().position(|name| name.layer == layer && name.suffix.eq_ignore_ascii_case(suffix))
    }

    pub(super) fn triple(&self, layer: &str, suffixes: [&str; 3]) -> Option<[usize; 3]> {
        let [a, b, c] = suffixes.map(|suffix| self.channel(layer, suffix));
        Some([a?, b?, c?])
    }

    /// Whether any channel is in a layer.
    pub(super) fn has_layer(&self, layer: &str) -> bool {
        self.names.iter().any(|name| is_inside(name.layer, layer))
    }

    /// What to do about a picture that was not found.
    pub(super) fn advice_on_color(&self, layer: Option<&str>) -> String {
        match layer.filter(|layer| !self.has_layer(layer)) {
            Some(layer) => {
                format!("there is no layer '{layer}', name one that is as \"layer\" in the manifest")
            }
            None if self.names.iter().all(|name| self.triple(name.layer, RGB).is_none()) => {
                "save the picture as RGB, in channels R, G and B".to_owned()
            }
            None => "name its layer as \"layer\" in the manifest".to_owned(),
        }
    }

    /// The layer that holds the picture: a known pass name, or the only layer with R, G and B. Some renderers write normals and
    /// positions as R, G and B too, which are a picture only where they are named as one.
    pub(super) fn color_layer(&self, layer: Option<&str>) -> Result<Option<&'a str>> {
        let mut candidates: Vec<&'a str> = Vec::new();
        for name in &self.names {
            let is_inside = layer.is_none_or(|layer| is_inside(name.layer, layer));
            let is_new = !candidates.contains(&name.layer);
            let is_picture = Some(name.layer) == layer || !is_geometry(name.layer);
            if is_inside && is_new && is_picture && self.triple(name.layer, RGB).is_some() {
                candidates.push(name.layer);
            }
        }
        let rank = |candidate: &str| {
            let pass = if Some(candidate) == layer { "" } else { split_pass(candidate).1 };
            COLOR_LAYERS
                .iter()
                .position(|known| pass.eq_ignore_ascii_case(known))
                .unwrap_or(COLOR_LAYERS.len())
        };
        let Some(best) = candidates.iter().map(|candidate| rank(candidate)).min() else {
            return Ok(None);
        };
        candidates.retain(|candidate| rank(candidate) == best);
        match candidates.as_slice() {
            [only] => Ok(Some(only)),
            several => Err(Error::invalid(
                self.place,
                format!(
                    "several layers hold a picture ({}); name one as \"layer\" in the manifest",
                    several.join(", ")
                ),
            )),
        }
    }

    /// `ViewLayer` of `ViewLayer.Combined`; a color layer of no known name is a root itself only if it holds others.
    fn root_of_color(&self, color_layer: &'a str) -> &'a str {
        let has_children = self.names.iter().any(|name| {
            !color_layer.is_empty() && name.layer != color_layer && is_inside(name.layer, color_layer)
        });
        if has_children { color_layer } else { split_pass(color_layer).0 }
    }

    /// The layer of the passes of a picture. A requested layer may be that one, or the picture itself; and the composite of a view
    /// layer is beside it, without passes of its own.
    pub(super) fn root<'b>(
        &'b self,
        layer: Option<&'b str>,
        color_layer: Option<&'b str>,
    ) -> Option<&'b str> {
        let Some(color) = color_layer else { return layer };
        let of_color = self.root_of_color(color);
        let own = match layer {
            Some(layer) if layer == color && !self.is_other_view(of_color) => vec![layer, of_color],
            Some(layer) => vec![layer],
            None => vec![of_color],
        };
        let has_geometry = |root: &&str| self.has_geometry(root, color_layer);
        let last = own.last().copied();
        let nearest = own.into_iter().find(has_geometry);
        nearest.or_else(|| self.root_beside(last, color_layer)).or(last)
    }

    /// The only root with geometry, if the picture's own has no depth. A root with a picture of its own may be another eye's or another
    /// scene's; only a composite is of such a root.
    fn root_beside(&self, own: Option<&str>, color_layer: Option<&str>) -> Option<&str> {
        if self.depth(own, color_layer).is_some() {
            return None;
        }
        let of_name = |name: &LayeredName<'a>| {
            let is_picture = self.triple(name.layer, RGB).is_some();
            [Some(split_pass(name.layer).0), Some(name.layer).filter(|_| is_picture)]
        };
        let mut roots: Vec<&str> = self.names.iter().flat_map(of_name).flatten().collect();
        roots.sort_unstable();
        roots.dedup();
        let is_composited = own.is_some_and(|own| own.eq_ignore_ascii_case(COMPOSITED));
        roots.retain(|root| {
            let is_of_this_picture = is_composited || !self.holds_picture(root);
            self.has_geometry(root, color_layer) && !self.is_other_view(root) && is_of_this_picture
        });
        <[&str; 1]>::try_from(roots).ok().map(|[only]| only)
    }

    fn holds_picture(&self, root: &str) -> bool {
        let is_picture = |layer: &str| !is_geometry(layer) && self.triple(layer, RGB).is_some();
        self.names.iter().any(|name| is_inside(name.layer, root) && is_picture(name.layer))
    }

    /// Whether a root that is not the picture's own is another view's: the channels of the first of several views of one scene
    /// are without a layer.
    fn is_other_view(&self, root: &str) -> bool {
        root.is_empty() && self.triple(root, RGB).is_some()
    }

    /// Whether a root has depth or positions of its own.
    fn has_geometry(&self, root: &str, color_layer: Option<&str>) -> bool {
        let has_depth = self.names.iter().any(|name| {
            self.depth_score(name, Some(root), color_layer).is_some_and(|score| score <= OWN_DEPTH)
        });
        has_depth || self.vector_at(POSITION_LAYERS, |parent| parent == root).is_some()
    }

    pub(super) fn depth(&self, root: Option<&str>, color_layer: Option<&str>) -> Option<usize> {
        let score = |index: usize| Some((self.depth_score(&self.names[index], root, color_layer)?, index));
        let scores: Vec<(u8, usize)> = (0..self.names.len()).filter_map(score).collect();
        let best = scores.iter().min().map(|(best, index)| {
            let of_best = scores.iter().filter(|(score, _)| score == best);
            (*index, is_one_root(root, of_best.map(|(_, index)| self.names[*index].layer)))
        });
        if best.is_some_and(|(_, is_one_root)| !is_one_root) {
            return None;
        }
        best.map(|(index, _)| index).or_else(|| (self.names.len() == 1).then_some(0))
    }

    /// How well a channel fits as depth, 0 best; `None` where it is something else.
    fn depth_score(&self, name: &LayeredName, root: Option<&str>, color_layer: Option<&str>) -> Option<u8> {
        let (parent, pass) = split_pass(name.layer);
        let is_plain = name.suffix.eq_ignore_ascii_case("Z") || name.suffix.eq_ignore_ascii_case("depth");
        let is_depth_pass = is_one_of(pass, DEPTH_LAYERS) && is_one_of(name.suffix, DEPTH_SUFFIXES);
        let is_at_root = |layer: &str| root.is_none_or(|root| root == layer);
        if is_depth_pass && is_at_root(parent) {
            Some(0)
        } else if is_plain && (is_at_root(name.layer) || Some(name.layer) == color_layer) {
            // With no picture in the file there is no root, and a bare suffix proves nothing inside a layer.
            (root.is_some() || name.layer.is_empty()).then_some(OWN_DEPTH)
        } else if name.suffix == "T" && self.is_alone(name.layer) {
            Some(2)
        } else if pass.ends_with("WorldDepth") && name.suffix == "R" {
            Some(3)
        } else if is_depth_pass && parent.is_empty() {
            Some(4)
        } else {
            None
        }
    }

    /// Whether a layer holds one channel, as Mitsuba's layers of depth do: beside an S, a T is a coordinate of textures.
    fn is_alone(&self, layer: &str) -> bool {
        self.names.iter().filter(|name| name.layer == layer).count() == 1
    }

    /// x, y, z of a pass of one of the known names: at the root first, then anywhere if only one.
    pub(super) fn vector(&self, known: &[&str], root: Option<&str>) -> Option<[usize; 3]> {
        let passes = self.names.iter().map(|name| name.layer);
        let passes = passes.filter(|layer| is_one_of(split_pass(layer).1, known));
        if !is_one_root(root, passes) {
            return None;
        }
        let at_root = self.vector_at(known, |parent| root.is_none_or(|root| parent == root));
        let elsewhere = || self.vector_at(known, |parent| !parent.contains('.') && root == Some(""));
        at_root.or_else(elsewhere)
    }

    /// The first pass of one of the known names in a layer that `is_parent` accepts.
    fn vector_at(&self, known: &[&str], is_parent: impl Fn(&str) -> bool) -> Option<[usize; 3]> {
        let is_pass = |layer: &&str| {
            let (parent, pass) = split_pass(layer);
            is_one_of(pass, known) && is_parent(parent)
        };
        self.names.iter().map(|name| name.layer).filter(is_pass).find_map(|layer| self.vector_of(layer))
    }

    fn vector_of(&self, layer: &str) -> Option<[usize; 3]> {
        self.triple(layer, XYZ).or_else(|| self.triple(layer, RGB))
    }

    /// x, y, z of a file of one vector, whatever it is called: without a layer, else as its picture, else in the only layer with them.
    pub(super) fn only_vector(&self, color: Option<[usize; 3]>) -> Option<[usize; 3]> {
        let mut layers: Vec<&str> = self.names.iter().map(|name| name.layer).collect();
        layers.dedup();
        layers.retain(|layer| !is_geometry(layer) && self.triple(layer, XYZ).is_some());
        let only = <[&str; 1]>::try_from(layers).ok().and_then(|[only]| self.triple(only, XYZ));
        self.triple("", XYZ).or(color).or(only)
    }

    pub(super) fn wished(&self, wish: &str) -> Result<usize> {
        self.full.iter().position(|full| *full == wish).ok_or_else(|| self.missing(wish))
    }

    pub(super) fn wished_triple(&self, wish: &str) -> Result<[usize; 3]> {
        let layer = LayeredName::of(wish).layer;
        let of_channel = || {
            let channel = self.full.iter().position(|full| *full == wish)?;
            let triples = [XYZ, RGB].into_iter().filter_map(|suffixes| self.triple(layer, suffixes));
            triples.into_iter().find(|triple| triple.contains(&channel))
        };
        let beside = || self.vector_of(layer).filter(|_| !layer.is_empty());
        let found = self.vector_of(wish).or_else(of_channel).or_else(beside);
        found.ok_or_else(|| self.missing(wish))
    }

    pub(super) fn refuse_namesakes(&self, index: usize) -> Result<()> {
        let name = self.full[index];
        if self.full.iter().filter(|full| **full == name).count() == 1 {
            return Ok(());
        }
        let what = format!(
            "several channels are called '{name}'; save each under its own name, or the parts under theirs"
        );
        Err(Error::invalid(self.place, what))
    }

    fn missing(&self, wish: &str) -> Error {
        const SHOWN: usize = 24;
        let mut there = self.full.iter().take(SHOWN).copied().collect::<Vec<_>>().join(", ");
        if self.full.len() > SHOWN {
            there.push_str(", …");
        }
        Error::invalid(self.place, format!("there is no channel '{wish}'; there are {there}"))
    }
}

fn is_inside(layer: &str, root: &str) -> bool {
    layer == root || layer.strip_prefix(root).is_some_and(|rest| rest.starts_with('.'))
}

/// Whether passes that fit equally well have one root. Without a picture, nothing decides between several roots, and none is taken.
fn is_one_root<'a>(root: Option<&str>, mut layers: impl Iterator<Item = &'a str>) -> bool {
    let first = layers.next().map(|layer| split_pass(layer).0);
    root.is_some() || layers.all(|layer| Some(split_pass(layer).0) == first)
}
