//! The chunk `VALU`: which channels of scalar values samples have, how they are coded, and where those of each image are. FORMAT.md
//! lists its bytes.

use rayon::prelude::*;

use crate::capture::{MAX_VALUE_CHANNELS, ValueChannel};
use crate::error::{Error, Result};
use crate::plural::counted;
use crate::samples::{SampleImage, SampleSet};
use crate::settings::Coding;
use crate::store::codec::{
    ChannelCoding, PlaneModel, VALUE_CONTEXTS, VALUE_TOKENS, ValueCounts, ValuePredictor, ValueScale,
};
use crate::store::container::{ByteReader, push_text};
use crate::store::image::{ValueCoding, count_values};

/// A channel of scalar values of a store.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredValues {
    /// What its numbers mean.
    pub channel: ValueChannel,
    /// By how much a stored value differs from the capture's, at most; 0 where it has the same bits.
    pub error: f32,
    /// Bytes that the channel takes in the store.
    pub bytes: u64,
}

/// Multiples of a step that a bounded channel may have, so that none is rounded to another: beyond, it is stored exactly.
const MOST_STEPS: f32 = 4e6;

/// Where the values of an image are: offset of their chunk, and bytes of its payload; zeros before they are written.
pub(crate) type ValuePlace = (u64, u32);

/// All that `VALU` holds.
#[derive(Clone, Debug)]
pub(crate) struct ValueTable {
    pub(crate) stored: Vec<StoredValues>,
    pub(crate) coding: ValueCoding,
    pub(crate) places: Vec<ValuePlace>,
}

/// An image, and the one that it is predicted from.
type WithReference = (std::sync::Arc<SampleImage>, Option<std::sync::Arc<SampleImage>>);

impl ValueTable {
    /// How to code the values of some images, and all their samples: of each channel, the predictor that takes the fewest bytes. `None` without channels.
    ///
    /// # Errors
    /// Whatever `image` gives for each of the images; `Invalid` where one has other channels.
    pub(crate) fn fitted(
        samples: &SampleSet,
        (images, sample_count): (usize, u64),
        image: impl Fn(usize) -> Result<WithReference> + Sync,
    ) -> Result<Option<Self>> {
        let channels = samples.values.len();
        if channels == 0 {
            return Ok(None);
        }
        let settings = &samples.settings.store;
        let steps = steps(samples, images, &image)?;
        let of = |predictor: ValuePredictor| -> Vec<ChannelCoding> {
            let of_channel = |(channel, step): (&ValueChannel, &f32)| ChannelCoding {
                scale: ValueScale { step: *step },
                predictor,
                start: channel.range[0],
            };
            samples.values.iter().zip(&steps).map(of_channel).collect()
        };
        let mut best: Vec<Option<(f64, ChannelCoding, PlaneModel)>> = vec![None; channels];
        for predictor in ValuePredictor::ALL {
            let codings = of(predictor);
            let counted = (0..images).into_par_iter().try_fold(
                || ValueCounts::new(channels),
                |mut counts, index| {
                    let (image, reference) = image(index)?;
                    count_values(&image, reference.as_deref(), &codings, &mut counts);
                    Ok::<_, Error>(counts)
                },
            );
            let counted = counted.try_reduce(|| ValueCounts::new(channels), |a, b| Ok(a.plus(&b)))?;
            for ((best, coding), counts) in best.iter_mut().zip(codings).zip(&counted.0) {
                let tables = PlaneModel::fit(counts).map_err(|what| Error::invalid("scalar values", what))?;
                let bits = tables.bits(counts);
                if best.as_ref().is_none_or(|(least, ..)| bits < *least) {
                    *best = Some((bits, coding, tables));
                }
            }
        }
        let best: Vec<_> = best.into_iter().flatten().collect();
        let stored = |(channel, (bits, coding, _)): (&ValueChannel, &(f64, ChannelCoding, PlaneModel))| {
            let plain = size_of::<f32>() as u64 * sample_count;
            StoredValues {
                channel: channel.clone(),
                error: coding.scale.step / 2.0,
                bytes: if settings.coding == Coding::Plain { plain } else { (bits / 8.0).round() as u64 },
            }
        };
        Ok(Some(Self {
            stored: samples.values.iter().zip(&best).map(stored).collect(),
            coding: ValueCoding {
                channels: best.iter().map(|(_, coding, _)| *coding).collect(),
                tables: best.into_iter().map(|(.., tables)| tables).collect(),
                plain: settings.coding == Coding::Plain,
            },
            places: vec![(0, 0); images],
        }))
    }

    /// The payload.
    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut bytes = vec![self.stored.len() as u8, u8::from(self.coding.plain)];
        for (stored, coding) in self.stored.iter().zip(&self.coding.channels) {
            let ValueChannel { name, unit, range, tolerance, is_exact } = &stored.channel;
            push_text(&mut bytes, name);
            push_text(&mut bytes, unit);
            for number in [range[0], range[1], *tolerance, coding.scale.step, coding.start] {
                bytes.extend(number.to_be_bytes());
            }
            let predictor = ValuePredictor::ALL.iter().position(|other| *other == coding.predictor);
            bytes.push(predictor.unwrap_or(0) as u8);
            bytes.push(u8::from(*is_exact));
            bytes.extend(stored.bytes.to_be_bytes());
        }
        self.coding.tables.iter().for_each(|tables| tables.encode(&mut bytes));
        for (offset, length) in &self.places {
            bytes.extend(offset.to_be_bytes());
            bytes.extend(length.to_be_bytes());
        }
        bytes
    }

    /// Reads what [`ValueTable::encode`] wrote, for a store with so many images.
    ///
    /// # Errors
    /// Where it cannot be.
    pub(crate) fn decode(payload: &[u8], images: usize) -> std::result::Result<Self, String> {
        let mut reader = ByteReader::new(payload);
        let (channels, flags) = (usize::from(reader.u8()?), reader.u8()?);
        if !(1..=MAX_VALUE_CHANNELS).contains(&channels) || flags > 1 {
            return Err(format!(
                "{} with flags {flags}; a newer Overlook may read it",
                counted(channels, "channel")
            ));
        }
        let (mut stored, mut codings) = (Vec::new(), Vec::new());
        for _ in 0..channels {
            let (channel, coding, bytes) = decode_channel(&mut reader)?;
            stored.push(StoredValues { channel, error: coding.scale.step / 2.0, bytes });
            codings.push(coding);
        }
        let tables = (0..channels).map(|_| PlaneModel::decode(&mut reader, VALUE_CONTEXTS, VALUE_TOKENS));
        let tables = tables.collect::<std::result::Result<Vec<_>, _>>()?;
        let places = (0..images).map(|_| Ok::<_, String>((reader.u64()?, reader.u32()?)));
        let places = places.collect::<std::result::Result<Vec<_>, _>>()?;
        reader.finish()?;
        Ok(Self { stored, coding: ValueCoding { channels: codings, tables, plain: flags == 1 }, places })
    }
}

/// The step of each channel: 0 where values are kept exactly.
fn steps(
    samples: &SampleSet,
    images: usize,
    image: &(impl Fn(usize) -> Result<WithReference> + Sync),
) -> Result<Vec<f32>> {
    let channels = samples.values.len();
    let largest = (0..images).into_par_iter().map(|index| {
        let (image, _) = image(index)?;
        if image.values.channels() != channels && !image.is_empty() {
            let has = counted(image.values.channels(), "channel");
            let what = format!("an image has {has} of values where the set has {channels}");
            return Err(Error::invalid("scalar values", what));
        }
        let largest = |channel: usize| image.values.channel(channel).map(f32::abs).fold(0.0, f32::max);
        Ok((0..channels).map(largest).collect::<Vec<f32>>())
    });
    let none = || vec![0.0; channels];
    let larger = |a: Vec<f32>, b: Vec<f32>| Ok(a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect());
    let largest = largest.try_reduce(none, larger)?;
    let step = |(channel, largest): (&ValueChannel, f32)| {
        let is_bounded = !channel.is_exact && largest <= MOST_STEPS * channel.tolerance;
        if is_bounded { channel.tolerance } else { 0.0 }
    };
    Ok(samples.values.iter().zip(largest).map(step).collect())
}

fn decode_channel(
    reader: &mut ByteReader<'_>,
) -> std::result::Result<(ValueChannel, ChannelCoding, u64), String> {
    let (name, unit) = (reader.text()?, reader.text()?);
    let mut number = || reader.u32().map(f32::from_bits);
    let (range, tolerance) = ([number()?, number()?], number()?);
    let (step, start) = (number()?, number()?);
    if [range[0], range[1], tolerance, step].iter().any(|number| !number.is_finite())
        || range[0] > range[1]
        || tolerance < 0.0
        || step < 0.0
        || name.contains(char::is_control)
        || unit.contains(char::is_control)
    {
        return Err(format!("the channel '{}' has an impossible range or name", name.escape_debug()));
    }
    let predictor = reader.u8()?;
    let predictor = *ValuePredictor::ALL.get(usize::from(predictor)).ok_or("an unknown prediction")?;
    let coding = ChannelCoding { scale: ValueScale { step }, predictor, start };
    let is_exact = reader.u8()? != 0;
    Ok((ValueChannel { name, unit, range, tolerance, is_exact }, coding, reader.u64()?))
}
