//! How scalar values become colors in the window.

use overlook_engine::capture::ValueChannel;
use overlook_engine::render::ValueColors;
use overlook_engine::settings::{Colormap, ValueScale};

/// What of the values is shown, and how.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct ValueLook {
    /// The number of the channel.
    pub channel: usize,
    pub map: Colormap,
    pub scale: ValueScale,
    /// Between which values colors run; `None` for the channel's own range.
    pub range: Option<[f32; 2]>,
    /// Values outside are gray; `None` where all are shown.
    pub isolated: Option<[f32; 2]>,
}

impl Default for ValueLook {
    fn default() -> Self {
        Self { channel: 0, map: Colormap::Viridis, scale: ValueScale::Linear, range: None, isolated: None }
    }
}

impl ValueLook {
    /// The channel that is shown: the first where there are fewer than chosen; `None` where there are none.
    pub(crate) fn channel_of(self, channels: &[ValueChannel]) -> Option<(usize, &ValueChannel)> {
        let index = if self.channel < channels.len() { self.channel } else { 0 };
        channels.get(index).map(|channel| (index, channel))
    }

    /// Its colors, or in words why the range has none.
    pub(crate) fn colors(self, channel: &ValueChannel) -> Result<ValueColors, String> {
        let colors = ValueColors::new(self.map, self.scale, self.range.unwrap_or(channel.range))?;
        Ok(self.isolated.map_or(colors, |isolated| colors.isolating(isolated)))
    }
}

/// Name and unit of a channel.
pub(crate) fn titled_value(channel: &ValueChannel) -> String {
    if channel.unit.is_empty() {
        channel.name.clone()
    } else {
        format!("{} ({})", channel.name, channel.unit)
    }
}

/// The scalar values of one channel of the samples that hold at a frame.
pub(crate) struct FrameValues {
    /// The number of the channel.
    pub channel: usize,
    /// Without missing and infinite ones.
    pub ascending: Vec<f32>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_that_another_scene_lacks_is_its_first_and_a_range_without_width_says_so() {
        let channel = |name: &str| ValueChannel {
            name: name.to_owned(),
            unit: "Pa".to_owned(),
            range: [1.0, 1.0],
            tolerance: 0.0,
            is_exact: true,
        };
        let look = ValueLook { channel: 3, ..ValueLook::default() };
        let channels = [channel("p"), channel("q")];
        assert_eq!(
            look.channel_of(&channels).map(|(index, channel)| (index, channel.name.as_str())),
            Some((0, "p"))
        );
        assert_eq!(look.channel_of(&[]), None);
        assert!(look.colors(&channels[0]).is_err_and(|why| why.contains("no width")));
        let wide = ValueLook { range: Some([0.0, 2.0]), isolated: Some([0.5, 1.0]), ..look };
        let colors = wide.colors(&channels[0]).unwrap();
        assert!(colors.color(0.4) == colors.color(f32::NAN) && colors.color(0.6) != colors.color(f32::NAN));
    }
}
