//! Which channel is which.
//!
//! A channel's full name is a layer and a suffix (`ViewLayer.Depth.Z` is layer `ViewLayer.Depth`, suffix `Z`). Both
//! decide, never the suffix alone: `Mist.Z`, `Normal.Z`, `Position.Z`, `N.Z`, `P.Z` and `Denoising Depth.Z` end as
//! depth does and are something else.
//!
//! | writer | color | depth | normal | position |
//! |---|---|---|---|---|
//! | Blender | `L.Combined.R…` | `L.Depth.Z`, or `.V` by its File Output node | `L.Normal.X…` | `L.Position.X…` |
//! | Mitsuba 3 | `R…` or `image.R…` | `aov.T` | `nn.X…`, `sh_normal.X…` | `position.X…` |
//! | Arnold and plain files | `R…` | `Z` | `N.X…` | `P.X…` |
//! | Unreal | `R…` | `FinalImage…WorldDepth.R` | | |

use crate::error::{Error, Result};

const NORMAL_LAYERS: &[&str] = &["normal", "normals", "n", "nn", "sh_normal", "geo_normal", "shading_normal"];
const POSITION_LAYERS: &[&str] = &["position", "positions", "pos", "p", "pp"];
const DEPTH_LAYERS: &[&str] = &["depth", "z"];
const DEPTH_SUFFIXES: &[&str] = &["Z", "V", "T", "Y", "R"];
const COLOR_LAYERS: &[&str] = &["", "combined", "rgba", "rgb", "beauty", "color", "finalimage", "image"];

/// What the manifest says about channels where names alone do not decide.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ChannelWishes {
    /// The layer (Blender's view layer) that all channels belong to.
    pub layer: Option<String>,
    /// Full name of the depth channel.
    pub depth_channel: Option<String>,
    /// Layer of the channels of positions, or the full name of the first of them.
    pub position_channel: Option<String>,
    /// Layer of the normal channels, or the full name of the first of them.
    pub normal_channel: Option<String>,
}

/// Indices of the recognized channels, into the list of names they were found in.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ChannelNames {
    /// Red, green, blue.
    pub color: Option<[usize; 3]>,
    /// Alpha beside the color.
    pub alpha: Option<usize>,
    /// Depth, one channel.
    pub depth: Option<usize>,
    /// Whether the depth channel is named as Mitsuba names its distance along the ray.
    pub depth_is_ray_distance: bool,
    /// Normal, x, y, z.
    pub normal: Option<[usize; 3]>,
    /// World-space position, x, y, z.
    pub position: Option<[usize; 3]>,
}

#[derive(Clone, Copy)]
struct Name<'a> {
    layer: &'a str,
    suffix: &'a str,
}

impl<'a> Name<'a> {
    fn of(full: &'a str) -> Self {
        let (layer, suffix) = full.rsplit_once('.').unwrap_or(("", full));
        Self { layer, suffix }
    }
}

/// The last component of a layer and what stands before it: `ViewLayer.Depth` is `("ViewLayer", "Depth")`.
fn split_pass(layer: &str) -> (&str, &str) {
    layer.rsplit_once('.').unwrap_or(("", layer))
}

fn is_one_of(pass: &str, known: &[&str]) -> bool {
    known.iter().any(|name| pass.eq_ignore_ascii_case(name))
}

struct Finder<'a> {
    full: Vec<&'a str>,
    names: Vec<Name<'a>>,
    place: &'a str,
}

impl ChannelNames {
    /// Recognizes channels among their full names. What is not there is `None`; `place` is named in errors.
    ///
    /// # Errors
    /// `Invalid` where a wished-for channel is missing, or where several layers answer equally well.
    pub fn find<'a>(
        full: impl IntoIterator<Item = &'a str>,
        wishes: &ChannelWishes,
        place: &str,
    ) -> Result<Self> {
        let full: Vec<&str> = full.into_iter().collect();
        let names = full.iter().map(|full| Name::of(full)).collect();
        let finder = Finder { full, names, place };
        let color_layer = finder.color_layer(wishes.layer.as_deref())?;
        let root = match (&wishes.layer, color_layer) {
            (Some(layer), _) => Some(layer.as_str()),
            (None, Some(layer)) => Some(finder.root_of_color(layer)),
            (None, None) => None,
        };
        let color = color_layer.and_then(|layer| finder.triple(layer, ["R", "G", "B"]));
        let alpha = color_layer.and_then(|layer| finder.channel(layer, "A"));
        let depth = match &wishes.depth_channel {
            Some(wish) => Some(finder.wished(wish)?),
            None => finder.depth(root, color_layer),
        };
        let normal = match &wishes.normal_channel {
            Some(wish) => Some(finder.wished_triple(wish)?),
            None => finder.vector(NORMAL_LAYERS, root),
        };
        let position = match &wishes.position_channel {
            Some(wish) => Some(finder.wished_triple(wish)?),
            None => finder.vector(POSITION_LAYERS, root),
        };
        let chosen = [color, normal, position].into_iter().flatten().flatten().chain(alpha).chain(depth);
        chosen.into_iter().try_for_each(|index| finder.refuse_namesakes(index))?;
        Ok(Self {
            color,
            alpha,
            depth,
            depth_is_ray_distance: depth.is_some_and(|depth| finder.names[depth].suffix == "T"),
            normal,
            position,
        })
    }
}

impl<'a> Finder<'a> {
    fn channel(&self, layer: &str, suffix: &str) -> Option<usize> {
        self.names.iter().position(|name| name.layer == layer && name.suffix.eq_ignore_ascii_case(suffix))
    }

    fn triple(&self, layer: &str, suffixes: [&str; 3]) -> Option<[usize; 3]> {
        let [a, b, c] = suffixes.map(|suffix| self.channel(layer, suffix));
        Some([a?, b?, c?])
    }

    /// The layer that holds the picture: a known pass name, or the only layer with R, G and B.
    fn color_layer(&self, layer: Option<&str>) -> Result<Option<&'a str>> {
        let mut candidates: Vec<&'a str> = Vec::new();
        for name in &self.names {
            let is_inside = layer.is_none_or(|layer| is_inside(name.layer, layer));
            let is_new = !candidates.contains(&name.layer);
            if is_inside && is_new && self.triple(name.layer, ["R", "G", "B"]).is_some() {
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

    /// `ViewLayer` of `ViewLayer.Combined`; a color layer of no known name is a root itself only if others lie in it.
    fn root_of_color(&self, color_layer: &'a str) -> &'a str {
        let has_children = self.names.iter().any(|name| {
            !color_layer.is_empty() && name.layer != color_layer && is_inside(name.layer, color_layer)
        });
        if has_children { color_layer } else { split_pass(color_layer).0 }
    }

    fn depth(&self, root: Option<&str>, color_layer: Option<&str>) -> Option<usize> {
        let score = |name: &Name| {
            let (parent, pass) = split_pass(name.layer);
            let is_plain = name.suffix.eq_ignore_ascii_case("Z") || name.suffix.eq_ignore_ascii_case("depth");
            let is_depth_pass = is_one_of(pass, DEPTH_LAYERS) && is_one_of(name.suffix, DEPTH_SUFFIXES);
            let is_at_root = |layer: &str| root.is_none_or(|root| root == layer);
            if is_depth_pass && is_at_root(parent) {
                Some(0)
            } else if is_plain && (is_at_root(name.layer) || Some(name.layer) == color_layer) {
                // With no picture in the file there is no root, and a bare suffix proves nothing inside a layer.
                (root.is_some() || name.layer.is_empty()).then_some(1)
            } else if name.suffix == "T" {
                Some(2)
            } else if pass.ends_with("WorldDepth") && name.suffix == "R" {
                Some(3)
            } else if is_depth_pass && parent.is_empty() {
                Some(4)
            } else {
                None
            }
        };
        let best = (0..self.names.len())
            .filter_map(|index| Some((score(&self.names[index])?, index)))
            .min()
            .map(|(_, index)| index);
        best.or_else(|| (self.names.len() == 1).then_some(0))
    }

    /// x, y, z of a pass of one of the known names: at the root first, then anywhere if only one.
    fn vector(&self, known: &[&str], root: Option<&str>) -> Option<[usize; 3]> {
        let mut layers: Vec<&str> = self
            .names
            .iter()
            .map(|name| name.layer)
            .filter(|layer| is_one_of(split_pass(layer).1, known))
            .filter(|layer| self.triple(layer, ["X", "Y", "Z"]).is_some())
            .collect();
        layers.dedup();
        let at_root = layers.iter().find(|layer| root.is_none_or(|root| split_pass(layer).0 == root));
        let elsewhere = layers.iter().find(|layer| !split_pass(layer).0.contains('.') && root == Some(""));
        at_root.or(elsewhere).and_then(|layer| self.triple(layer, ["X", "Y", "Z"]))
    }

    fn wished(&self, wish: &str) -> Result<usize> {
        self.full.iter().position(|full| *full == wish).ok_or_else(|| self.missing(wish))
    }

    fn wished_triple(&self, wish: &str) -> Result<[usize; 3]> {
        let layers = [Some(wish), wish.rsplit_once('.').map(|(layer, _)| layer)];
        layers
            .into_iter()
            .flatten()
            .find_map(|layer| self.triple(layer, ["X", "Y", "Z"]).or(self.triple(layer, ["R", "G", "B"])))
            .ok_or_else(|| self.missing(wish))
    }

    fn refuse_namesakes(&self, index: usize) -> Result<()> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn find(names: &[&str]) -> ChannelNames {
        ChannelNames::find(names.iter().copied(), &ChannelWishes::default(), "test").unwrap()
    }

    fn wish(names: &[&str], wishes: &ChannelWishes) -> Result<ChannelNames> {
        ChannelNames::find(names.iter().copied(), wishes, "test")
    }

    const BLENDER: &[&str] = &[
        "ViewLayer.Combined.A",
        "ViewLayer.Combined.B",
        "ViewLayer.Combined.G",
        "ViewLayer.Combined.R",
        "ViewLayer.Denoising Albedo.B",
        "ViewLayer.Denoising Albedo.G",
        "ViewLayer.Denoising Albedo.R",
        "ViewLayer.Denoising Depth.Z",
        "ViewLayer.Denoising Normal.X",
        "ViewLayer.Denoising Normal.Y",
        "ViewLayer.Denoising Normal.Z",
        "ViewLayer.Depth.Z",
        "ViewLayer.Mist.Z",
        "ViewLayer.Normal.X",
        "ViewLayer.Normal.Y",
        "ViewLayer.Normal.Z",
        "ViewLayer.Position.X",
        "ViewLayer.Position.Y",
        "ViewLayer.Position.Z",
    ];

    #[test]
    fn blenders_passes_are_told_apart() {
        let found = find(BLENDER);
        assert_eq!(found.color, Some([3, 2, 1]));
        assert_eq!(found.alpha, Some(0));
        assert_eq!(found.depth, Some(11));
        assert_eq!(found.normal, Some([13, 14, 15]));
        assert_eq!(found.position, Some([16, 17, 18]));
        assert!(!found.depth_is_ray_distance);
    }

    #[test]
    fn traps_are_no_depth() {
        let traps = ["Mist.Z", "Normal.Z", "Position.Z", "N.Z", "P.Z", "Denoising Depth.Z"];
        for trap in traps {
            assert_eq!(find(&["R", "G", "B", trap]).depth, None, "{trap}");
            let layered = format!("ViewLayer.{trap}");
            let names =
                ["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B", layered.as_str()];
            assert_eq!(find(&names).depth, None, "{layered}");
        }
        assert_eq!(find(&traps).depth, None);
    }

    #[test]
    fn plain_arnold_and_unreal_names_are_known() {
        let found = find(&["A", "B", "G", "N.X", "N.Y", "N.Z", "P.X", "P.Y", "P.Z", "R", "Z"]);
        assert_eq!((found.color, found.depth), (Some([9, 2, 1]), Some(10)));
        assert_eq!((found.normal, found.position), (Some([3, 4, 5]), Some([6, 7, 8])));
        let unreal = find(&["B", "FinalImageMovieRenderQueue_WorldDepth.R", "G", "R"]);
        assert_eq!(unreal.depth, Some(1));
    }

    #[test]
    fn mitsubas_depth_is_a_distance_along_the_ray() {
        let found = find(&["B", "G", "R", "dd.T", "nn.X", "nn.Y", "nn.Z", "pos.X", "pos.Y", "pos.Z"]);
        assert_eq!((found.depth, found.depth_is_ray_distance), (Some(3), true));
        assert_eq!((found.normal, found.position), (Some([4, 5, 6]), Some([7, 8, 9])));
        let named =
            find(&["image.B", "image.G", "image.R", "dd.T", "sh_normal.X", "sh_normal.Y", "sh_normal.Z"]);
        assert_eq!((named.color, named.depth, named.normal), (Some([2, 1, 0]), Some(3), Some([4, 5, 6])));
    }

    #[test]
    fn the_compositors_v_is_depth_and_a_file_of_one_channel_is_what_it_was_asked_for() {
        let names =
            ["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B", "ViewLayer.Depth.V"];
        assert_eq!(find(&names).depth, Some(3));
        assert_eq!(find(&["Y"]).depth, Some(0));
        assert_eq!(find(&["V", "Other.V"]).depth, None);
    }

    #[test]
    fn two_view_layers_need_a_choice() {
        let names: Vec<String> = ["Front", "Back"]
            .iter()
            .flat_map(|layer| {
                ["Combined.R", "Combined.G", "Combined.B", "Depth.Z"].map(|name| format!("{layer}.{name}"))
            })
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let error = wish(&names, &ChannelWishes::default()).unwrap_err().to_string();
        assert!(error.contains("Front.Combined, Back.Combined"), "{error}");
        let wishes = ChannelWishes { layer: Some("Back".into()), ..ChannelWishes::default() };
        let found = wish(&names, &wishes).unwrap();
        assert_eq!((found.color, found.depth), (Some([4, 5, 6]), Some(7)));
    }

    #[test]
    fn wishes_go_before_names_and_a_missing_one_lists_what_there_is() {
        let mut wishes = ChannelWishes {
            depth_channel: Some("ViewLayer.Mist.Z".into()),
            normal_channel: Some("ViewLayer.Denoising Normal".into()),
            ..ChannelWishes::default()
        };
        let found = wish(BLENDER, &wishes).unwrap();
        assert_eq!((found.depth, found.normal), (Some(12), Some([8, 9, 10])));
        wishes.depth_channel = Some("Z".into());
        let error = wish(BLENDER, &wishes).unwrap_err().to_string();
        assert!(error.contains("'Z'") && error.contains("ViewLayer.Depth.Z"), "{error}");
    }
}
