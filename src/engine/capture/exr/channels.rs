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
//! | Arnold and plain files | `R…` | `Z` | `N.X…` or `N.R…` | `P.X…` or `P.R…` |
//! | Unreal | `R…` | `FinalImage…WorldDepth.R` | | |

use std::ops::Range;

use exr::meta::attribute::SampleType;
use half::f16;
use half::slice::HalfFloatSliceExt;

use super::channel_finder::{ChannelFinder, NORMAL_LAYERS, POSITION_LAYERS, RGB};
use crate::error::Result;

/// The manifest's keys for channels, if names alone do not decide.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ChannelWishes {
    /// Whether depth or normals are looked for in a file of their own: pictures beside them need no choice, nor need the layer be
    /// there.
    pub(crate) is_apart: bool,
    /// The layer (Blender's view layer) that all channels belong to.
    pub(crate) layer: Option<String>,
    /// Full name of the depth channel.
    pub(crate) depth_channel: Option<String>,
    /// Layer of the channels of positions, or the full name of the first of them.
    pub(crate) position_channel: Option<String>,
    /// Layer of the normal channels, or the full name of the first of them.
    pub(crate) normal_channel: Option<String>,
}

/// Indices of the recognized channels, into the list of names they were found in.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ChannelNames {
    /// Red, green, blue; the same channel for all of them where it is gray (`Y`).
    pub(crate) color: Option<[usize; 3]>,
    /// Alpha beside the color.
    pub(crate) alpha: Option<usize>,
    /// Depth, one channel.
    pub(crate) depth: Option<usize>,
    /// Whether the depth channel is named as Mitsuba names its distance along the ray.
    pub(crate) depth_is_ray_distance: bool,
    /// Normal, x, y, z.
    pub(crate) normal: Option<[usize; 3]>,
    /// World-space position, x, y, z.
    pub(crate) position: Option<[usize; 3]>,
    /// x, y, z of a file of one vector, which need not be called by what it is.
    pub(crate) only_vector: Option<[usize; 3]>,
}

impl ChannelNames {
    /// Recognizes channels among their full names. What is not there is `None`; `place` is named in errors.
    ///
    /// # Errors
    /// `Invalid` where a wished-for channel is missing, or where several layers fit equally well.
    pub(crate) fn find<'a>(
        full: impl IntoIterator<Item = &'a str>,
        wishes: &ChannelWishes,
        place: &'a str,
    ) -> Result<Self> {
        let finder = ChannelFinder::new(full, place);
        let layer = wishes.layer.as_deref().filter(|layer| !wishes.is_apart || finder.has_layer(layer));
        let color_layer = match finder.color_layer(layer) {
            Err(_) if wishes.is_apart => None,
            found => found?,
        };
        let root = finder.root(layer, color_layer);
        let gray =
            || finder.channel(layer.unwrap_or(""), "Y").filter(|_| !wishes.is_apart).map(|gray| [gray; 3]);
        let color = color_layer.map_or_else(gray, |layer| finder.triple(layer, RGB));
        let alpha_layer = color_layer.or(layer).or(color.map(|_| ""));
        let alpha = alpha_layer.filter(|_| color.is_some()).and_then(|layer| finder.channel(layer, "A"));
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
            only_vector: finder.only_vector(color),
        })
    }

    /// What to do about a file in which no picture was found.
    pub(crate) fn advice_on_color<'a>(
        full: impl IntoIterator<Item = &'a str>,
        wishes: &ChannelWishes,
    ) -> String {
        ChannelFinder::new(full, "").advice_on_color(wishes.layer.as_deref())
    }
}

/// One channel, row-major over the asked-for window; NaN where the file's data window does not reach.
#[derive(Clone, Debug)]
pub enum ChannelPlane {
    /// A channel of half floats.
    Half(Vec<f16>),
    /// A channel of floats or whole numbers.
    Single(Vec<f32>),
}

impl ChannelPlane {
    /// A plane of NaN.
    pub(crate) fn unknown(is_half: bool, pixels: usize) -> Self {
        if is_half { Self::Half(vec![f16::NAN; pixels]) } else { Self::Single(vec![f32::NAN; pixels]) }
    }

    /// The numbers in single precision.
    #[must_use]
    pub fn into_single(self) -> Vec<f32> {
        match self {
            Self::Half(values) => values.to_f32_vec(),
            Self::Single(values) => values,
        }
    }

    /// Sets some numbers to those of a line of the file.
    pub(crate) fn set(&mut self, range: Range<usize>, line: &[u8], kind: SampleType) {
        match (self, kind) {
            (Self::Half(values), _) => read(line, &mut values[range], f16::from_ne_bytes),
            (Self::Single(values), SampleType::U32) => {
                read(line, &mut values[range], |bytes| u32::from_ne_bytes(bytes) as f32);
            }
            (Self::Single(values), _) => read(line, &mut values[range], f32::from_ne_bytes),
        }
    }
}

fn read<const BYTES: usize, T>(line: &[u8], target: &mut [T], decode: impl Fn([u8; BYTES]) -> T) {
    let (samples, _) = line.as_chunks::<BYTES>();
    for (value, sample) in target.iter_mut().zip(samples) {
        *value = decode(*sample);
    }
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
    fn an_eye_without_depth_does_not_take_the_other_ones() {
        let names = ["left.R", "left.G", "left.B", "right.R", "right.G", "right.B", "right.Z"];
        for layer in ["left", "right"] {
            let wishes = ChannelWishes { layer: Some(layer.to_owned()), ..ChannelWishes::default() };
            assert_eq!(wish(&names, &wishes).unwrap().depth, (layer == "right").then_some(6), "{layer}");
        }
        assert_eq!(find(&["R", "G", "B", "right.R", "right.G", "right.B", "right.Z"]).depth, None);
    }

    #[test]
    fn normals_and_positions_in_red_green_and_blue_are_no_picture_unless_named_as_one() {
        let triple = |layer: &str| ["R", "G", "B"].map(|suffix| format!("{layer}.{suffix}"));
        let names = [triple("diffuse"), triple("normals"), triple("P")].concat();
        let names: Vec<&str> = names.iter().map(String::as_str).chain(["Depth.Z"]).collect();
        let found = find(&names);
        assert_eq!((found.color, found.depth), (Some([0, 1, 2]), Some(9)));
        assert_eq!((found.normal, found.position), (Some([3, 4, 5]), Some([6, 7, 8])));
        let found = find(&names[3..]);
        assert_eq!((found.color, found.normal), (None, Some([0, 1, 2])));
        let wishes = ChannelWishes { layer: Some("normals".into()), ..ChannelWishes::default() };
        assert_eq!(wish(&names, &wishes).unwrap().color, Some([3, 4, 5]));
    }

    #[test]
    fn a_layer_may_be_named_by_its_picture_and_a_composited_one_has_the_only_passes_there_are() {
        let of = |layer: &str, passes: &[&str]| -> Vec<String> {
            passes.iter().map(|pass| format!("{layer}.{pass}")).collect()
        };
        let picture = ["Combined.R", "Combined.G", "Combined.B"];
        let passes = [picture.as_slice(), &["Depth.Z", "Normal.X", "Normal.Y", "Normal.Z"]].concat();
        let with = |layers: [Vec<String>; 2], layer: &str| {
            let names = layers.concat();
            let wishes = ChannelWishes { layer: Some(layer.into()), ..ChannelWishes::default() };
            wish(&names.iter().map(String::as_str).collect::<Vec<_>>(), &wishes).unwrap()
        };
        let two = || [of("Front", &passes), of("Back", &passes)];
        for (layer, first) in [("Front.Combined", 0), ("Front", 0), ("Back.Combined", 7), ("Back", 7)] {
            let found = with(two(), layer);
            assert_eq!(found.color, Some([0, 1, 2].map(|at| first + at)), "{layer}");
            assert_eq!(found.depth, Some(first + 3), "{layer}");
            assert_eq!(found.normal, Some([4, 5, 6].map(|at| first + at)), "{layer}");
        }
        for layer in ["Composite", "Composite.Combined"] {
            let found = with([of("Composite", &picture), of("ViewLayer", &passes)], layer);
            assert_eq!((found.color, found.depth), (Some([0, 1, 2]), Some(6)), "{layer}");
            assert_eq!(found.normal, Some([7, 8, 9]), "{layer}");
        }
        let views = ["R", "G", "B", "Z", "left.R", "left.G", "left.B"].map(str::to_owned).to_vec();
        assert_eq!(with([views, Vec::new()], "left").depth, None, "the other eye's is not this one's");
        let three = [of("Composite", &picture), two().concat()];
        assert_eq!(with(three, "Composite").depth, None, "which of two is meant is not known");
    }

    #[test]
    fn a_file_of_depth_needs_no_choice_among_its_pictures_but_one_among_depths() {
        let triple = |layer: &str| ["R", "G", "B"].map(|suffix| format!("{layer}.{suffix}")).to_vec();
        let with = |more: &[&str], layer: Option<&str>| {
            let more = more.iter().map(|&name| name.to_owned()).collect();
            let names = [triple("albedo"), triple("emission"), more].concat();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let layer = layer.map(ToOwned::to_owned);
            wish(&names, &ChannelWishes { is_apart: true, layer, ..ChannelWishes::default() }).unwrap()
        };
        assert_eq!(with(&["Z"], None).depth, Some(6));
        assert_eq!(with(&["Z"], Some("albedo")).depth, Some(6));
        assert_eq!(with(&["Z"], Some("elsewhere")).depth, Some(6));
        assert_eq!(with(&["N.X", "N.Y", "N.Z"], None).normal, Some([6, 7, 8]));
        let two = ["Front.Depth.Z", "Back.Depth.Z", "Front.Normal.X", "Front.Normal.Y", "Front.Normal.Z"];
        assert_eq!(with(&two, None).depth, None, "which of two is meant is not known");
        assert_eq!(with(&two, Some("Back")).depth, Some(7));
        assert_eq!(with(&two, None).normal, Some([8, 9, 10]));
    }

    #[test]
    fn channels_without_a_layer_can_be_wished_for() {
        let of = |channel: &str, names: &[&str]| {
            let wishes = ChannelWishes { position_channel: Some(channel.into()), ..ChannelWishes::default() };
            wish(names, &wishes).map(|found| found.position)
        };
        assert_eq!(of("R", &["B", "G", "R"]).unwrap(), Some([2, 1, 0]));
        assert_eq!(of("X", &["X", "Y", "Z"]).unwrap(), Some([0, 1, 2]));
        assert_eq!(of("R", &["X", "Y", "Z", "R", "G", "B"]).unwrap(), Some([3, 4, 5]));
        assert!(of("W", &["X", "Y", "Z"]).is_err());
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
