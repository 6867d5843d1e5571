//! The traversal of a block's verdicts that counting, encoding and decoding share: in which context the rule of each pixel is coded, and
//! by which list of cameras its witness is named.
//!
//! Neighbors mostly fell to the same rule for the same camera, so that a witness is a place in a list: first the witnesses of the
//! neighbors, then those that the block named lately, then all cameras.

use super::neighborhood::{BLOCK, CELLS, STRIDE, cell};
use super::value_traversal::ValueCoder;

/// Columns and rows of a tile.
const TILE: usize = BLOCK / 4;
/// A rule and a witness.
pub(crate) type CodedVerdict = (u8, u16);
/// No sample, and no witness.
const NONE: CodedVerdict = (0, u16::MAX);
/// Rules are numbers below this one.
pub(crate) const RULES: u8 = 12;
/// The rules by which a sample yields to a witness.
const YIELDING: std::ops::RangeInclusive<u8> = 5..=9;
/// The channel of rules, and that of witnesses.
const RULE: usize = 0;
const WITNESS: usize = 1;
/// Channels of verdicts.
pub(crate) const VERDICT_CHANNELS: usize = 2;
/// Witnesses that a block remembers.
const REMEMBERED: usize = 16;

/// What a context tells of a neighbor's rule: no sample, alone, kept, less dense, yielding otherwise, without a witness.
const GROUPS: [u8; RULES as usize] = [0, 1, 2, 2, 2, 3, 4, 4, 4, 4, 5, 5];

/// Whether a rule names a witness.
pub(crate) fn has_witness(rule: u8) -> bool {
    YIELDING.contains(&rule)
}

/// The verdicts of a block of pixels.
pub(crate) struct BlockVerdicts {
    /// Tiles that hold a sample: bit 4y + x for the one in column x, row y.
    pub(crate) tiles: u16,
    /// By [`cell`].
    verdicts: Vec<CodedVerdict>,
}

impl BlockVerdicts {
    /// Without any verdict.
    pub(crate) fn new() -> Self {
        Self { tiles: 0, verdicts: vec![NONE; CELLS] }
    }

    /// Forgets every verdict.
    pub(crate) fn clear(&mut self) {
        self.tiles = 0;
        self.verdicts.fill(NONE);
    }

    /// Notes a verdict.
    pub(crate) fn set(&mut self, x: usize, y: usize, verdict: CodedVerdict) {
        self.tiles |= 1 << (y / TILE * (BLOCK / TILE) + x / TILE);
        self.verdicts[cell(x, y)] = verdict;
    }

    /// The verdict on a pixel.
    pub(crate) fn get(&self, x: usize, y: usize) -> CodedVerdict {
        self.verdicts[cell(x, y)]
    }
}

/// The witnesses of the neighbors of a pixel, those of most first, and how many neighbors name the first.
fn named_around(verdicts: &[CodedVerdict], at: usize) -> ([(u16, u8); 4], usize) {
    let (mut named, mut count) = ([(0, 0); 4], 0);
    for neighbor in [at - 1, at - STRIDE, at - STRIDE + 1, at - STRIDE - 1] {
        let (rule, witness) = verdicts[neighbor];
        if !has_witness(rule) {
            continue;
        }
        if let Some((_, times)) = named[..count].iter_mut().find(|(other, _)| *other == witness) {
            *times += 1;
        } else {
            named[count] = (witness, 1);
            count += 1;
        }
    }
    named[..count].sort_by_key(|(_, times)| std::cmp::Reverse(*times));
    (named, count)
}

/// Codes the verdicts of a block with so many columns and rows of a camera's picture, or decodes those of its tiles.
///
/// # Errors
/// Where decoded numbers are no verdicts of a store with `cameras` cameras.
pub(crate) fn traverse_verdicts(
    coder: &mut impl ValueCoder,
    block: &mut BlockVerdicts,
    (width, height): (usize, usize),
    cameras: usize,
) -> Result<(), String> {
    let mut lately: Vec<u16> = Vec::with_capacity(REMEMBERED + 1);
    for y in 0..height.min(BLOCK) {
        for x in 0..width.min(BLOCK) {
            if block.tiles >> (y / TILE * (BLOCK / TILE) + x / TILE) & 1 == 0 {
                continue;
            }
            let at = cell(x, y);
            let verdicts = &mut block.verdicts;
            let group = |neighbor: usize| usize::from(GROUPS[usize::from(verdicts[neighbor].0)]);
            let [left, above, after, before] =
                [at - 1, at - STRIDE, at - STRIDE + 1, at - STRIDE - 1].map(group);
            let context = (left * 6 + above) * 4 + 2 * usize::from(after > 2) + usize::from(before > 2);
            let rule = coder.code(RULE, context, u32::from(verdicts[at].0));
            let rule = u8::try_from(rule).ok().filter(|rule| *rule < RULES);
            let rule = rule.ok_or("a verdict by a rule that there is not")?;
            let mut witness = NONE.1;
            if has_witness(rule) {
                let (named, count) = named_around(verdicts, at);
                let wanted = verdicts[at].1;
                witness = code_witness(coder, (&named[..count], rule), &lately, wanted)?;
                if usize::from(witness) >= cameras {
                    return Err(format!("a witness is camera {witness} of {cameras}"));
                }
                lately.retain(|other| *other != witness);
                lately.insert(0, witness);
                lately.truncate(REMEMBERED);
            }
            verdicts[at] = (rule, witness);
        }
    }
    Ok(())
}

/// Codes a witness as its place in the list of all, or decodes it.
fn code_witness(
    coder: &mut impl ValueCoder,
    (named, rule): (&[(u16, u8)], u8),
    lately: &[u16],
    wanted: u16,
) -> Result<u16, String> {
    let is_named = |camera: u16| named.iter().any(|(other, _)| *other == camera);
    let others = || lately.iter().copied().filter(|camera| !is_named(*camera));
    let mut listed = named.iter().map(|(camera, _)| *camera).chain(others());
    let known = named.len() + others().count();
    let place = listed.clone().position(|camera| camera == wanted);
    let place = place.unwrap_or(known + usize::from(wanted)) as u32;
    let agreeing = named.first().map_or(0, |(_, times)| usize::from(*times));
    let context = (named.len() * 5 + agreeing) * 2 + usize::from(GROUPS[usize::from(rule)] == 4);
    let place = coder.code(WITNESS, context, place) as usize;
    match listed.nth(place) {
        Some(camera) => Ok(camera),
        None => u16::try_from(place - known).map_err(|_| "a witness is no camera".to_owned()),
    }
}
